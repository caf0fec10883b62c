//! Fields made of one case each: corners of cells that hash to one entry, and sums of perceptrons
//! that the finest weights carry past 32 bits.

use std::borrow::Cow;

use glam::DVec3;
use potamoi_base::camera::Camera;
use potamoi_base::picture::Picture;
use potamoi_fields::mac::MacMlp;
use potamoi_fields::voxels::STOP_BELOW;
use potamoi_fields::{
    Algorithm, Along, AnyField, Bounds, ErrorInterval, Field, FieldError, FixedField, FixedOptions,
    Layer, Mlp, QuantisedField, Sampling, Table, error_bounds, render_float,
};
use potamoi_formats::config::Config;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_march::{Head, Lanes, MarchError, Opacities, Transparent};
use potamoi_reference::bounds::VectorBounds;
use potamoi_reference::{ReferenceUnits, Units};
use potamoi_rtl::RtlUnits;
use potamoi_scene::{Model, Scene};

use super::modelled::Case;
use super::obvious::{Obvious, ObviousUnits};
use super::sampled::{Shown, farthest};
use potamoi_analysis::hard_cases::pictures::SIZE;

/// Vertices along each axis, and edges of the world's unit.
const SIDE: usize = 9;
const STEP: f64 = 0.25;
/// Fraction bits of features.
const FRAC: u32 = 14;
/// The same of colours that are hardly told apart.
const COARSE: u32 = 6;

/// One table: a density, and features that a perceptron makes a colour of, or colours as they are.
#[derive(serde::Serialize)]
struct Toy {
    table: [Table; 1],
    /// Fraction bits of what follows the density.
    frac: u32,
    mlp: Option<Mlp>,
    /// Whether weights of the perceptron have the finest scale that 16 bits hold.
    finest: bool,
    /// The least light at which rays go on, opacity that counts, and weight that is given a colour.
    least: [f64; 3],
}

const LEAST: [f64; 3] = [STOP_BELOW, 0.0, 0.0];

/// 343 cells whose corners share five entries.
fn hashed() -> Toy {
    let entries = [
        [0.1, 0.9, 0.1, 0.2],
        [0.4, 0.2, 0.8, 0.3],
        [0.0, 0.5, 0.5, 0.9],
        [0.7, 0.3, 0.2, 0.6],
        [0.2, 0.7, 0.9, 0.4],
    ];
    let table = Table::hashed([SIDE; 3], entries.len(), 4, entries.concat());
    Toy {
        table: [table.unwrap()],
        frac: FRAC,
        mlp: None,
        finest: false,
        least: LEAST,
    }
}

/// One density, colours of few bits.
fn coarse() -> Toy {
    let vertex = |i: usize| {
        let [r, g, b] = [0, 1, 2].map(|c| 0.5 + 0.4 * ((i * 5 + c * 3) as f32).sin());
        [1.9, r, g, b]
    };
    let values = (0..SIDE * SIDE * SIDE).flat_map(vertex).collect();
    Toy {
        table: [Table::new([SIDE; 3], 4, values).unwrap()],
        frac: COARSE,
        mlp: None,
        finest: false,
        least: LEAST,
    }
}

/// Inputs of the perceptron.
const WIDE: usize = 24;

/// Features near their largest, of which the perceptron makes means.
fn wide(finest: bool) -> Toy {
    let mut values = vec![];
    for i in 0..SIDE * SIDE * SIDE {
        let at = [i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE].map(|v| v as f64);
        values.push((0.3 + 0.2 * (at[0] + at[2]).sin()) as f32);
        values.extend(
            (0..WIDE)
                .map(|c| (1.2 + 0.7 * (0.6 * at[0] + 0.4 * at[1] + 0.02 * c as f64).sin()) as f32),
        );
    }
    let weights = (0..3 * WIDE).map(|i| (1.0 + 0.3 * (i as f32).sin()) / (2.4 * WIDE as f32));
    let layer = Layer::new(WIDE, weights.collect(), vec![0.0; 3]).unwrap();
    Toy {
        table: [Table::new([SIDE; 3], 1 + WIDE, values).unwrap()],
        frac: FRAC,
        mlp: Some(Mlp::new(vec![layer]).unwrap()),
        finest,
        least: LEAST,
    }
}

impl Toy {
    fn mac(&self) -> Option<MacMlp> {
        let mlp = self.mlp.as_ref()?;
        Some(MacMlp::quantise(mlp, FRAC as i32, &[1.9]).unwrap())
    }

    fn frac_bits(&self) -> Vec<u32> {
        let mut bits = vec![self.frac; self.channels()];
        bits[0] = FRAC;
        bits
    }
}

/// As reports tell it.
static ALGORITHM: Algorithm = Algorithm {
    name: "toy",
    outside: &["all but what the gathering and the vector unit compute"],
    full_size: None,
    preset: "paper",
    file: None,
};

impl Field for Toy {
    fn algorithm(&self) -> &'static Algorithm {
        &ALGORITHM
    }

    fn tables(&self) -> &[Table] {
        &self.table
    }

    fn place(&self, at: DVec3, places: &mut [DVec3]) {
        places[0] = at;
    }

    fn holds(&self, _: DVec3) -> bool {
        true
    }

    fn depth(&self, features: &[f64]) -> f64 {
        features[0].max(0.0) * STEP
    }

    fn colour(&self, features: &[f64], _: DVec3, scratch: &mut Vec<f64>) -> DVec3 {
        scratch.clear();
        scratch.extend_from_slice(&features[1..]);
        if let Some(mlp) = &self.mlp {
            mlp.run(scratch);
        }
        DVec3::new(scratch[0], scratch[1], scratch[2]).max(DVec3::ZERO)
    }

    fn sampling(&self) -> Sampling {
        Sampling {
            bounds: [DVec3::ZERO, DVec3::splat(SIDE as f64 - 1.0)],
            step: STEP,
            range: [0.0, f64::INFINITY],
            along: Along::Ray,
            least_opacity: self.least[1],
            least_weight: self.least[2],
            stop: self.least[0],
        }
    }

    fn coded(&self, config: &Config) -> Result<QuantisedField<'_>, FieldError> {
        let head = ToyHead {
            channels: self.channels(),
            frac: self.frac,
            mlp: self.mac(),
            finest: self.finest.then(|| self.mlp.clone()).flatten(),
            depth_bits: config.vu.exp.one_minus_frac_bits,
            least: self.least,
        };
        Ok(QuantisedField::in_tables(
            vec![self.frac_bits()],
            Box::new(head),
        ))
    }

    fn bounds(
        &self,
        config: &Config,
        _: &VectorBounds,
        _: &Camera,
    ) -> Result<Option<Box<dyn Bounds + '_>>, FieldError> {
        Ok(Some(Box::new(ToyBounds {
            frac_bits: [self.frac_bits()],
            mac: self.mac(),
            mlp: self.mlp.as_ref(),
            depth_ulp: 2f64.powi(-(config.vu.exp.one_minus_frac_bits as i32)),
        })))
    }
}

struct ToyHead {
    channels: usize,
    frac: u32,
    mlp: Option<MacMlp>,
    /// The obvious form's.
    finest: Option<Mlp>,
    depth_bits: u32,
    least: [f64; 3],
}

impl Head for ToyHead {
    fn channels(&self) -> usize {
        self.channels
    }

    fn alpha_bits(&self) -> u32 {
        16
    }

    fn colour_bits(&self) -> u32 {
        let own = |mlp: &MacMlp| u32::try_from(mlp.output_frac()).unwrap();
        self.mlp.as_ref().map_or(self.frac, own)
    }

    fn least(&self) -> [i32; 2] {
        let [_, opacity, weight] = self.least;
        [(opacity, 16), (weight, 20)].map(|(v, bits)| (v * 2f64.powi(bits)).floor() as i32)
    }

    fn direction_codes(&self) -> usize {
        0
    }

    fn operations(&self) -> Vec<OpCode> {
        vec![OpCode::Relu, OpCode::Multiply, OpCode::OneMinusExp]
    }

    fn encode(&self, _: DVec3, _: &mut Vec<i16>) {}

    fn opacities<'f>(
        &self,
        features: &'f [i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Opacities<'f>, MarchError> {
        let density: Vec<i32> = features
            .chunks(self.channels)
            .map(|f| f[0].into())
            .collect();
        // The step has 10 fraction bits.
        let (step, shift) = ((STEP * 1024.0) as i32, (FRAC + 10 - self.depth_bits) as u8);
        Ok(Opacities {
            alpha: lanes.opacities(&density, step, shift, Transparent::NONE)?,
            kept: Cow::Borrowed(features),
        })
    }

    fn colours(
        &self,
        kept: Vec<i16>,
        _: &[i16],
        lanes: &mut Lanes<'_>,
    ) -> Result<Vec<i32>, MarchError> {
        let features = kept.chunks(self.channels).flat_map(|f| &f[1..]).copied();
        let colour = match (&self.finest, &self.mlp) {
            (Some(mlp), Some(made)) => finest(mlp, made, &features.collect::<Vec<_>>()),
            (_, Some(mlp)) => mlp.run(features.collect(), lanes)?,
            _ => features.map(i32::from).collect(),
        };
        lanes.compute_with(VectorOp::new(OpCode::Relu), &colour, 0)
    }
}

/// The layer with weights at the finest scale that 16 bits hold, its sums of 32 bits.
fn finest(mlp: &Mlp, made: &MacMlp, inputs: &[i16]) -> Vec<i32> {
    let layer = &mlp.layers()[0];
    let most = layer.weights().iter().fold(0f32, |m, w| m.max(w.abs()));
    let frac = (32_767.0 / most).log2().floor() as i32;
    let codes: Vec<i32> = layer
        .weights()
        .iter()
        .map(|w| (w * 2f32.powi(frac)).round() as i32)
        .collect();
    let shift = frac + FRAC as i32 - made.output_frac();
    let sum = |sample: &[i16], row: &[i32]| {
        let terms = sample.iter().zip(row);
        terms.fold(0i32, |sum, (x, w)| sum.wrapping_add(i32::from(*x) * w)) >> shift
    };
    let samples = inputs.chunks(layer.inputs());
    samples
        .flat_map(|sample| {
            codes
                .chunks(layer.inputs())
                .map(move |row| sum(sample, row))
        })
        .collect()
}

struct ToyBounds<'a> {
    frac_bits: [Vec<u32>; 1],
    mac: Option<MacMlp>,
    mlp: Option<&'a Mlp>,
    depth_ulp: f64,
}

impl Bounds for ToyBounds<'_> {
    fn frac_bits(&self) -> &[Vec<u32>] {
        &self.frac_bits
    }

    /// The optical depth is cut off; the opacity's own unit gives 3.56 units of U0.16 at most
    /// (docs/explanation/hard-cases.md).
    fn alpha(&self, _: &[f64], off: &[ErrorInterval]) -> f64 {
        STEP * off[0].largest() + self.depth_ulp + 3.56 * 2f64.powi(-16)
    }

    /// Half a code of each weight times its input, each input's own, and the sum's rounding.
    fn colour(&self, features: &[f64], off: &[ErrorInterval], _: DVec3) -> f64 {
        let (Some(mac), Some(mlp)) = (&self.mac, self.mlp) else {
            return off[1..].iter().fold(0.0, |m, o| o.largest().max(m));
        };
        let (made, layer) = (&mac.layers()[0], &mlp.layers()[0]);
        let code = made.weights().iter().zip(layer.weights());
        // Of all weights the one whose code is farthest from it, at the code's scale.
        let scale = f64::from(made.weights()[0]) / f64::from(layer.weights()[0]);
        let frac = scale.log2().round().exp2();
        let of_weight = code.fold(0.0, |m, (c, w)| {
            f64::max(m, (f64::from(*c) / frac - f64::from(*w)).abs())
        });
        let inputs = features[1..].iter().zip(&off[1..]);
        let largest = layer.weights().iter().fold(0f32, |m, w| m.max(w.abs()));
        let sum: f64 = inputs
            .map(|(x, o)| of_weight * (x.abs() + o.largest()) + f64::from(largest) * o.largest())
            .sum();
        sum + 2f64.powi(-mac.output_frac())
    }
}

fn camera() -> Camera {
    let [width, height] = SIZE;
    let eye = DVec3::new(11.0, -3.0, -9.0);
    Camera::look_at(eye, DVec3::splat(4.0), DVec3::NEG_Y, 0.75, width, height)
}

/// What its picture may be off by.
fn bounds(field: &dyn Field) -> Vec<f64> {
    let config = config();
    let powers = VectorBounds::by_formula(&config.vu.exp);
    let options = FixedOptions::default();
    let bounds = error_bounds(field, &config, &powers, &camera(), &options);
    bounds.unwrap().unwrap()
}

fn config() -> Config {
    Config::paper()
}

fn through(field: &Toy, units: &mut dyn Units) -> Picture {
    let fixed = FixedField::new(field, &config()).unwrap();
    let options = FixedOptions::default();
    fixed.render(&camera(), &options, units).unwrap().picture
}

/// Both fields, to be modelled.
pub(crate) fn cases() -> Vec<Case> {
    let one = |(name, field): (&'static str, Toy)| Case {
        name,
        camera: camera(),
        picture: through(&field, &mut ReferenceUnits::new(&config())),
        step: None,
        config: config(),
        model: Model::Field(AnyField::new(field)),
    };
    [("hashed", hashed()), ("perceptron", wide(false))]
        .map(one)
        .to_vec()
}

pub(crate) fn shown() -> Vec<Shown> {
    let one = |scene, case, form, field: Toy, naive: Picture| {
        let mut twins = ReferenceUnits::new(&config());
        let ours = through(&field, &mut twins);
        assert_eq!(twins.gather_flags(), 0, "{scene}");
        let float = render_float(&field, &camera(), [0.0; 3]).unwrap().picture;
        let bounds = bounds(&field);
        Shown {
            scene,
            case,
            form,
            naive,
            farthest: farthest(&ours, &float, bounds.iter().copied()),
            bound: bounds.iter().copied().fold(0.0, f64::max),
            ours,
            float,
        }
    };
    let by_row = Obvious::WeightPerRow;
    let mut twins = ReferenceUnits::new(&config());
    vec![
        one(
            "hashed",
            "corners of cells that hash to one of five entries",
            by_row.text(),
            hashed(),
            through(&hashed(), &mut ObviousUnits::new(by_row, &config())),
        ),
        one(
            "perceptron",
            "24 inputs near their largest",
            "weights at the finest scale, sums of 32 bits",
            wide(false),
            through(&wide(true), &mut twins),
        ),
    ]
}

#[test]
fn the_hardware_shows_the_same_fields() {
    let mut rtl = RtlUnits::new(&config());
    for field in [hashed(), wide(false)] {
        let expected = through(&field, &mut ReferenceUnits::new(&config()));
        assert_eq!(through(&field, &mut rtl), expected);
    }
    assert_eq!(rtl.gather_flags(), 0);
}

/// Of colours that are hardly told apart most of the bound is their own, and most of what is measured.
#[test]
fn colours_by_themselves_move_a_pixel_within_its_bound() {
    let off = |field: &Toy| {
        let ours = through(field, &mut ReferenceUnits::new(&config()));
        let float = render_float(field, &camera(), [0.0; 3]).unwrap().picture;
        farthest(&ours, &float, bounds(field).into_iter())
    };
    let fine = Toy {
        frac: FRAC,
        ..coarse()
    };
    let [coarse, fine] = [coarse(), fine].map(|field| off(&field));
    assert!(coarse > 20.0 * fine && coarse > 2e-3, "{coarse} {fine}");
}

/// Limits that floating point just misses and the hardware just meets, or the other way round: what
/// only one of the two leaves out is within the pixel's bound.
#[test]
fn what_only_one_of_the_two_leaves_out_is_within_the_bound() {
    let even = |density: f32, least: [f64; 3]| Toy {
        table: [Table::new([SIDE; 3], 4, [density, 1.0, 1.0, 1.0].repeat(SIDE.pow(3))).unwrap()],
        frac: FRAC,
        mlp: None,
        finest: false,
        least,
    };
    for (which, what) in ["light at which rays stop", "opacity", "weight"]
        .iter()
        .enumerate()
    {
        let mut apart = [0u32; 2];
        for i in 0..16u16 {
            let density = f32::from(4000 + 97 * i) / 16384.0;
            let left = (-f64::from(density) * STEP).exp();
            let limit = [left.powi(3), 1.0 - left, left * (1.0 - left)][which];
            for (side, factor) in [1.0 - 1e-9, 1.0 + 1e-9].into_iter().enumerate() {
                let mut least = LEAST;
                least[which] = limit * factor;
                let field = even(density, least);
                let ours = through(&field, &mut ReferenceUnits::new(&config()));
                let float = render_float(&field, &camera(), [0.0; 3]).unwrap().picture;
                let off = farthest(&ours, &float, bounds(&field).into_iter());
                apart[side] += u32::from(off > 0.01);
            }
        }
        println!("{what}: decided otherwise {apart:?} times of 16");
        assert!(apart.iter().sum::<u32>() > 4, "{what}: {apart:?}");
    }
}

/// A field that is added as docs/adding/field.md says is told by scenes as the others are; its
/// pictures, bounds and work are those of the other tests here.
#[test]
fn an_added_field_is_told_like_the_others() {
    let model = Model::Field(AnyField::new(hashed()));
    let up = DVec3::NEG_Y;
    let mut scene = Scene::of("added", model, camera(), up, [0.0; 3]);
    assert_eq!(scene.model().algorithm(), "toy");
    assert_eq!(scene.model().full_size(), None);
    let said = scene.not_checked(&Config::paper());
    assert!(
        said.iter().any(|own| *own == ALGORITHM.outside[0]),
        "{said:?}"
    );
    scene.set_size(Some(16), Some(16)).unwrap();
    let float = scene.render_float().unwrap().picture;
    let mut twins = ReferenceUnits::new(&config());
    let fixed = scene.render_fixed(&config(), &mut twins).unwrap().picture;
    let off = fixed.rgb.iter().flatten().zip(float.rgb.iter().flatten());
    let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let bound = bounds(&hashed()).into_iter().fold(0.0, f64::max);
    assert!(f64::from(off) <= bound, "{off} {bound}");
    let other = Scene::of(
        "added",
        Model::Field(AnyField::new(wide(false))),
        camera(),
        up,
        [0.0; 3],
    );
    assert_ne!(scene.identity(), other.identity());
}
