//! The price of an exponential by itself: area, clocks, energy, errors over all operands, and pictures.

use potamoi_base::picture::Picture;
use potamoi_cycles::vector_unit::VectorTiming;
use potamoi_formats::config::{Config, ExpBase, ExpConfig, ExpForm, ExpOutput, rules};
use potamoi_formats::units::OpCode;
use potamoi_reference::ReferenceUnits;
use potamoi_reference::exact_exponential::{ExactExponential, ExpError};
use potamoi_reference::exponential::ReferenceExponential;
use potamoi_scene::Scene;
use potamoi_synth::fit::{ExponentialFigures, Fit, Origin};
use potamoi_units::exponential::alone;
use schemars::JsonSchema;
use serde::Serialize;

use crate::ExploreError;
use crate::accuracy::ImageQuality;

/// Node in nanometres for area, period and energy.
const NODE_NM: u32 = 12;
/// Scenes of the pictures: exponentials of splats; 1 less those of voxels.
const SCENES: [&str; 2] = ["garden", "lantern"];
/// Width of their pictures in pixels.
const WIDTH: u32 = 128;

/// A figure, or the reason why there is none.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Figure<T> {
    /// The figure.
    Known(T),
    /// None.
    Unknown {
        /// The reason, a sentence.
        unknown: String,
    },
}

impl<T> Figure<T> {
    /// The figure, where there is one.
    pub const fn known(&self) -> Option<&T> {
        match self {
            Self::Known(figure) => Some(figure),
            Self::Unknown { .. } => None,
        }
    }

    /// Why there is none.
    pub fn unknown(&self) -> Option<&str> {
        match self {
            Self::Known(_) => None,
            Self::Unknown { unknown } => Some(unknown),
        }
    }
}

/// The price of an exponential by itself, as `emit --unit exp` writes it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ExponentialPrice {
    /// Form and settings.
    pub name: String,
    /// The form.
    pub form: ExpForm,
    /// Area, period and energy.
    pub hardware: Figure<ExponentialHardware>,
    /// Clocks from an operand to the next, by the cycle model.
    pub interval_clocks: Clocks,
    /// Clocks from taking an operand to offering its power, by the cycle model.
    pub latency_clocks: Clocks,
    /// Errors over all operands of the format.
    pub error: Figure<PowerError>,
    /// Pictures with this exponential.
    pub scenes: Vec<SceneQuality>,
}

/// Area, period and energy at one node, without wires.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ExponentialHardware {
    /// Node in nanometres.
    pub node_nm: u32,
    /// Where the figures come from.
    pub origin: Origin,
    /// Node of the cells that were synthesised, from which figures are scaled.
    pub from_nm: u32,
    /// Area of the cells at that node, in square micrometres.
    pub area_um2_from: f64,
    /// Area of the cells, in square micrometres.
    pub area_um2: f64,
    /// Longest path, in picoseconds.
    pub period_ps: f64,
    /// Energy of an exponential with glitches where one follows the other, in picojoules.
    pub energy_pj: f64,
}

/// Clocks over all operands.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Clocks {
    /// The mean.
    pub mean: f64,
    /// The most.
    pub most: u64,
}

/// Errors over all operands of the format, against values of 120 bits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct PowerError {
    /// Number of operands.
    pub operands: u32,
    /// Unit of the last place. With the general output, of a mantissa: relative to the power of two.
    pub ulp: f64,
    /// Largest magnitude in units of the last place.
    pub max_ulp: f64,
    /// Root mean square in the same units.
    pub rms_ulp: f64,
    /// Largest magnitude.
    pub max: f64,
    /// Root mean square.
    pub rms: f64,
}

/// PSNR of a scene's picture in the hardware's formats beside floating point.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SceneQuality {
    /// The scene.
    pub scene: &'static str,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// PSNR in dB, peak 1.
    pub float_db: Figure<f64>,
}

/// What prices are measured with: fitted syntheses, and the scenes in floating point.
pub struct Pricing {
    fit: Fit,
    scenes: Vec<(&'static str, Scene, Picture)>,
}

impl Pricing {
    /// Reads the syntheses that come with the program, and renders the scenes in floating point.
    ///
    /// # Errors
    /// None for what comes with the program.
    pub fn open() -> Result<Self, ExploreError> {
        let mut scenes = vec![];
        for name in SCENES {
            let mut scene = Scene::open(name)?;
            scene.set_size(Some(WIDTH), None)?;
            let float = scene.render_float()?.picture;
            scenes.push((name, scene, float));
        }
        Ok(Self {
            fit: Fit::checked_in()?,
            scenes,
        })
    }

    /// The price of an exponential.
    ///
    /// # Errors
    /// Knobs that break a rule; the library of arbitrary precision fails.
    pub fn of(&self, exp: &ExpConfig) -> Result<ExponentialPrice, ExploreError> {
        let mut config = Config::paper();
        config.vu.exp = exp.clone();
        let own = alone(&config);
        let twin = ReferenceExponential::new(exp);
        let [interval_clocks, latency_clocks] = clocks(&own, &twin)?;
        Ok(ExponentialPrice {
            name: name(exp),
            form: exp.form,
            hardware: self.hardware(&own, interval_clocks.mean)?,
            interval_clocks,
            latency_clocks,
            error: error(exp, &twin)?,
            scenes: self.pictures(&config),
        })
    }

    fn hardware(
        &self,
        own: &Config,
        clocks: f64,
    ) -> Result<Figure<ExponentialHardware>, ExploreError> {
        let found = self.fit.exponential(own, NODE_NM)?;
        Ok(found.map_or_else(
            || Figure::Unknown {
                unknown: "neither this block nor one that differs in numbers alone is among the \
                          syntheses that come with the program; potamoi synth --unit vu synthesises \
                          it, with vu.lanes = 1 and vu.ops = [\"exp\"]"
                    .to_owned(),
            },
            |found| Figure::Known(ExponentialHardware::new(found, clocks)),
        ))
    }

    /// The scenes in the paper's other formats.
    fn pictures(&self, config: &Config) -> Vec<SceneQuality> {
        let breaches = rules::check(config);
        let exp = &config.vu.exp;
        let is_rendered = exp.form != ExpForm::Literal
            && exp.base == ExpBase::E
            && exp.output == ExpOutput::Alpha;
        let quality = |(name, scene, float): &(&'static str, Scene, Picture)| {
            let mut twins = ReferenceUnits::new(config);
            let refused = |unknown: String| Figure::Unknown { unknown };
            let float_db = match (is_rendered, breaches.is_empty()) {
                (false, _) => refused(
                    "renderers take exp(-u): vu.exp.base = \"e\", vu.exp.output = \"alpha\", and a \
                     form that is right below 0"
                        .to_owned(),
                ),
                (true, false) => refused(breaches.to_string().replace('\n', "; ")),
                (true, true) => match scene.render_fixed(config, &mut twins) {
                    Ok(shown) => match ImageQuality::of(&shown.picture, float).db {
                        Some(db) => Figure::Known(db),
                        None => refused("the pictures are equal".to_owned()),
                    },
                    Err(error) => refused(error.to_string()),
                },
            };
            SceneQuality {
                scene: name,
                size: [float.width, float.height],
                float_db,
            }
        };
        self.scenes.iter().map(quality).collect()
    }
}

impl ExponentialHardware {
    fn new(found: ExponentialFigures, clocks: f64) -> Self {
        let scaled = found.scaled;
        Self {
            node_nm: scaled.node_nm,
            origin: found.origin,
            from_nm: found.from_nm,
            area_um2_from: found.area_um2_from,
            area_um2: scaled.area_um2,
            period_ps: scaled.period_ps,
            energy_pj: scaled.with_glitches_pj * clocks,
        }
    }
}

/// All operands of the format.
fn operands(exp: &ExpConfig) -> impl Iterator<Item = i32> + use<> {
    let (least, most) = (exp.input.min() as i32, exp.input.max() as i32);
    least..=most
}

/// Interval and latency over all operands.
fn clocks(own: &Config, twin: &ReferenceExponential) -> Result<[Clocks; 2], ExploreError> {
    let refused = |e: &dyn std::fmt::Display| ExploreError::Refused(e.to_string());
    let timing = VectorTiming::new(own).map_err(|e| refused(&e))?;
    let code = OpCode::Exp.code();
    let over = |of: &dyn Fn(u32) -> u64| {
        let (mut sum, mut most, mut count) = (0, 0, 0u32);
        for operand in operands(&own.vu.exp) {
            let own = of(twin.exponent(OpCode::Exp, operand));
            sum += own;
            most = most.max(own);
            count += 1;
        }
        Clocks {
            mean: sum as f64 / f64::from(count.max(1)),
            most,
        }
    };
    Ok([
        over(&|exponent| timing.occupancy(code, exponent)),
        over(&|exponent| timing.latency(code, exponent)),
    ])
}

/// Errors over all operands.
fn error(exp: &ExpConfig, twin: &ReferenceExponential) -> Result<Figure<PowerError>, ExploreError> {
    if exp.input.width() > ExactExponential::MOST_BITS {
        return Ok(Figure::Unknown {
            unknown: format!(
                "operands of vu.exp.input = {} have {} bits: exact values are listed for {} at most",
                exp.input,
                exp.input.width(),
                ExactExponential::MOST_BITS
            ),
        });
    }
    let exact = ExactExponential::in_base(exp.input, exp.base)
        .map_err(|e| ExploreError::Inconclusive(e.to_string()))?;
    let bits = exp.output_bits;
    let is_floating = exp.output == ExpOutput::General && exp.form != ExpForm::Literal;
    let found: ExpError = match is_floating {
        true => exact.measure_floating(bits, |operand| twin.floating(operand)),
        false => exact.measure(bits, |operand| twin.exp(operand)),
    };
    let ulp = 2f64.powi(-(bits as i32));
    Ok(Figure::Known(PowerError {
        operands: 1 << exp.input.width(),
        ulp,
        max_ulp: found.max_ulp,
        rms_ulp: found.rms,
        max: found.max_ulp * ulp,
        rms: found.rms * ulp,
    }))
}

/// Form and settings in words; formats and widths only where they are not the usual ones.
fn name(exp: &ExpConfig) -> String {
    let mut name = match exp.form {
        ExpForm::Piecewise => format!("{} pieces", exp.pieces),
        ExpForm::Radix4 => format!("radix 4, J = {}", exp.iterations),
        form => format!("{}, n = {}", form.name(), exp.iterations),
    };
    if exp.base == ExpBase::Two {
        name += " of 2^-u";
    }
    let plain = exp.form.plain();
    let is_pipelined = exp.pipelined && !plain.pipelined;
    for (is_set, what) in [
        (exp.tail, "tail".to_owned()),
        (exp.early_out, "early out".to_owned()),
        (is_pipelined, "pipelined".to_owned()),
        (
            exp.iterations_per_clock != plain.iterations_per_clock,
            format!("{} a clock", exp.iterations_per_clock),
        ),
        (exp.output != plain.output, "general".to_owned()),
        (exp.input != plain.input, exp.input.to_string()),
        (
            exp.output_bits != plain.output_bits,
            format!("F = {}", exp.output_bits),
        ),
    ] {
        if is_set {
            name += &format!(", {what}");
        }
    }
    name
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn exp(text: &str) -> ExpConfig {
        let text = format!("[vu]\nops = [\"exp\"]\n[vu.exp]\n{text}");
        Config::from_toml(&text, "test").unwrap().vu.exp
    }

    fn db(price: &ExponentialPrice) -> Vec<f64> {
        let all = price.scenes.iter();
        all.filter_map(|own| own.float_db.known().copied())
            .collect()
    }

    /// What the reference of the vector unit and the study of cost state of the same engines.
    #[test]
    fn prices_are_those_of_the_engines() {
        let pricing = Pricing::open().unwrap();
        let of = |text: &str| pricing.of(&exp(text)).unwrap();
        let paper = of("");
        assert_eq!(paper.name, "restoring, n = 16");
        let error = paper.error.known().unwrap();
        assert_eq!(error.operands, 65_536);
        assert!((error.max_ulp - 0.9728).abs() < 1e-4, "{error:?}");
        assert!((0.25..0.35).contains(&error.rms_ulp), "{error:?}");
        assert_eq!(error.max, error.max_ulp / 65_536.0);
        let clocks = |own: &Clocks| (own.mean, own.most);
        assert_eq!(clocks(&paper.interval_clocks), (20.0, 20));
        assert_eq!(clocks(&paper.latency_clocks), (21.0, 21));
        let coarse = of("iterations = 8");
        assert!(coarse.error.known().unwrap().rms_ulp > 10.0);
        for (own, other) in db(&paper).iter().zip(db(&coarse)) {
            assert!(*own > 85.0 && *own > other + 5.0, "{own} {other}");
        }
        let early = of("early_out = true");
        let (mean, most) = clocks(&early.interval_clocks);
        assert!(most == 20 && (mean - 15.63).abs() < 0.01, "{mean}");
        let [energy, own] = [&paper, &early].map(|own| own.hardware.known().unwrap().energy_pj);
        assert!(own < energy, "{own} {energy}");
    }

    #[test]
    fn what_is_not_known_has_its_reason() {
        let pricing = Pricing::open().unwrap();
        let literal = pricing.of(&ExpForm::Literal.plain()).unwrap();
        let said = literal.hardware.unknown().unwrap();
        assert!(said.contains("potamoi synth --unit vu"), "{said}");
        assert!(db(&literal).is_empty());
        let said = literal.scenes[0].float_db.unknown().unwrap();
        assert!(said.contains("right below 0"), "{said}");
        // As printed, it never subtracts below 0: exp(-1) comes out as 1.
        let error = literal.error.known().unwrap();
        assert_eq!(error.operands, 1 << 15);
        assert!(
            (error.max - (1.0 - (-1f64).exp())).abs() < 1e-3,
            "{error:?}"
        );
        let wide = exp("input = \"U3.18\"\nconstant_bits = 24");
        let wide = pricing.of(&wide).unwrap();
        let said = wide.error.unknown().unwrap();
        assert!(
            said.contains("U3.18 have 21 bits: exact values are listed for 20"),
            "{said}"
        );
    }

    /// A mantissa's error is relative; the name tells what is not usual.
    #[test]
    fn the_general_output_is_measured_by_its_mantissa() {
        let exp = exp("output = \"general\"\ninput = \"S3.12\"\niterations = 9\ntail = true");
        let twin = ReferenceExponential::new(&exp);
        let found = error(&exp, &twin).unwrap();
        let found = found.known().unwrap();
        let exact = |x: i32| (f64::from(x) / 4096.0).exp();
        let relative = operands(&exp).map(|x| {
            let (mantissa, exponent) = twin.floating(x);
            let value = mantissa as f64 * 2f64.powi(exponent - 16);
            let binade = 2f64.powf(exact(x).log2().floor());
            (value - exact(x)).abs() / binade
        });
        let most = relative.fold(0.0, f64::max);
        assert!((found.max / most - 1.0).abs() < 1e-6, "{found:?} {most}");
        assert_eq!(name(&exp), "restoring, n = 9, tail, general, S3.12");
    }
}
