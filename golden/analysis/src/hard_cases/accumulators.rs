//! Extremes of sums: weights of one, constant fields, arbitrary words, and perceptrons.

use potamoi_formats::config::Config;
use potamoi_formats::config::{Sums, WeightTrust};
use potamoi_formats::rit::{RitEntry, Vertices};

use super::{Case, Draws, Measuring, Stop, Worst, cases, eight_vertices, unless};
use potamoi_fields::mac::MacMlp;
use potamoi_fields::{Layer, Mlp};
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::ReferenceGatheringUnit;
use potamoi_reference::weights::trilinear;

cases! {
    "sums";
    a_weight_of_one, "a weight of exactly 1", "";
    constant_fields, "a constant field", "[gu]\nweight_bits = 8";
    arbitrary_words, "the largest sums of arbitrary weights", "[gu]\nweights = \"any\"";
    sums_of_perceptrons, "sums of a perceptron's layer, 200 inputs", "";
}

const LSB: &str = "ulp of a 16-bit feature";

/// What a gathering unit makes of one feature of a cell's eight corners.
pub(super) fn gathered(
    twin: &ReferenceGatheringUnit,
    codes: &[i16; 8],
    weights: [u16; 8],
) -> Result<i16, Stop> {
    let task = GatherTask {
        vertices: Vertices::Eight,
        channels: 1,
        rows: codes.to_vec(),
        entries: vec![RitEntry {
            slot: 0,
            rows: [0, 1, 2, 3, 4, 5, 6, 7],
            weights,
        }],
    };
    let mut features = vec![];
    twin.gather(&task, &mut features)?;
    Ok(features[0])
}

/// The gathering unit of entries of eight vertices, with features of 16 bits.
pub(super) fn gathering(config: &Config) -> Result<ReferenceGatheringUnit, Stop> {
    eight_vertices(config)?;
    unless(config.gu.feature_bits == 16, || {
        "gu.feature_bits: the codes of these cases have 16".to_owned()
    })?;
    unless(config.gu.sums == Sums::Rounded, || {
        "gu.sums: sums leave the unit as they are, without a rounding".to_owned()
    })?;
    Ok(ReferenceGatheringUnit::new(config))
}

/// A sample on a vertex: seven weights of 0 and one of 1.
fn a_weight_of_one(under: &Config) -> Measuring {
    let (twin, bits) = (gathering(under)?, under.gu.weight_bits);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for vertex in 0..8 {
        for code in [i16::MIN, -20_000, -1, 0, 1, 20_000, i16::MAX] {
            let mut codes = [0; 8];
            codes[vertex] = code;
            let weights = trilinear([0, 1, 2].map(|a| (vertex as u16 >> a & 1) << 12), bits);
            ours.see(f64::from(gathered(&twin, &codes, weights)?) - f64::from(code));
            // U0.16 ends at 0xffff.
            fails.see(f64::from((i64::from(code) * 0xffff) as i32 >> 16) - f64::from(code));
        }
    }
    Ok(Case {
        naive: "U0.16, whose largest is 65,535 / 65,536".into(),
        unit: LSB.into(),
        fails,
        bound: 0.0,
        from: format!("U1.{bits} holds 1, and 1 times a code is the code").into(),
        ours,
    })
}

fn constant_fields(under: &Config) -> Measuring {
    let (twin, bits) = (gathering(under)?, under.gu.weight_bits);
    let one = f64::from(1u32 << bits);
    let mut draws = Draws(9);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for _ in 0..2000 {
        let fraction = [0; 3].map(|_| draws.between(0.0, 4097.0) as u16);
        for code in [i16::MIN, -1, 1, i16::MAX] {
            let found = gathered(&twin, &[code; 8], trilinear(fraction, bits))?;
            ours.see(f64::from(found) - f64::from(code));
            let side = |corner: usize, axis: usize| {
                let u = f64::from(fraction[axis]) / 4096.0;
                if corner >> axis & 1 == 1 { u } else { 1.0 - u }
            };
            let alone = |c: usize| (side(c, 0) * side(c, 1) * side(c, 2) * one).round();
            let sum: f64 = (0..8).map(alone).sum();
            fails.see((sum / one - 1.0) * f64::from(code));
        }
    }
    Ok(Case {
        naive: "each weight rounded by itself".into(),
        unit: LSB.into(),
        fails,
        bound: 0.0,
        from: "the split tree's weights sum to exactly 1".into(),
        ours,
    })
}

/// Eight times the largest words, as untrusted weights may be.
fn arbitrary_words(under: &Config) -> Measuring {
    let (twin, bits) = (gathering(under)?, under.gu.weight_bits);
    unless(under.gu.weights == WeightTrust::Any, || {
        "gu.weights = \"trusted\": weights sum to 1, and a flag tells where they do not".to_owned()
    })?;
    let one = f64::from(1u32 << bits);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for code in [i16::MIN, -30_000, -1, 1, 7, 30_000, i16::MAX] {
        let found = gathered(&twin, &[code; 8], [u16::MAX; 8])?;
        let sum = 8 * i64::from(code) * 65_535;
        let exact = (sum as f64 / one).clamp(-32_768.0, 32_767.0);
        ours.see(f64::from(found) - exact);
        // Those of a feature and of a weight, without a bit for sums, suffice for weights that sum to 1.
        let spare = 64 - (16 + bits);
        let wrapped = sum << spare >> spare;
        fails.see((wrapped as f64 / one).clamp(-32_768.0, 32_767.0) - exact);
    }
    Ok(Case {
        naive: format!("the accumulator of trusted weights, {} bits", 16 + bits).into(),
        unit: LSB.into(),
        fails,
        bound: 0.5,
        from: "the accumulator holds eight of the largest products; one rounding".into(),
        ours,
    })
}

/// The farthest that 200 weights can carry a sum, in units of 2^31.
fn sums_of_perceptrons(_: &Config) -> Measuring {
    let mut draws = Draws(17);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for scale in [1e-3, 0.1, 1.0, 50.0] {
        let weights: Vec<f32> = (0..200)
            .map(|_| (scale * draws.between(-1.0, 1.0)) as f32)
            .collect();
        let layer = Layer::new(200, weights.clone(), vec![(scale * 0.3) as f32])?;
        let mlp = MacMlp::quantise(&Mlp::new(vec![layer])?, 8, &[100.0])?;
        let made = &mlp.layers()[0];
        let reach = |codes: &mut dyn Iterator<Item = i64>| {
            codes.map(|w| w.abs() * 32_768).sum::<i64>() as f64 / 2f64.powi(31)
        };
        ours.see(reach(&mut made.weights().iter().map(|w| i64::from(*w))));
        let most = weights.iter().fold(0f32, |most, w| most.max(w.abs()));
        let finest = |w: &f32| (w / most * 32_767.0).round() as i64;
        fails.see(reach(&mut weights.iter().map(finest)));
    }
    Ok(Case {
        naive: "weights at the finest scale that 16 bits hold".into(),
        unit: "of the 32-bit sum's range".into(),
        fails,
        bound: 1.0,
        from: "the scale is halved until no input overflows".into(),
        ours,
    })
}
