//! Extremes of sums: weights of one, constant fields, arbitrary words, and perceptrons.

use potamoi_formats::config::Config;
use potamoi_formats::rit::{RitEntry, Vertices};

use super::{Case, Draws, Worst, cases};
use potamoi_fields::mac::MacMlp;
use potamoi_fields::{Layer, Mlp};
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::ReferenceGatheringUnit;
use potamoi_reference::weights::trilinear;

cases!(
    a_weight_of_one,
    constant_fields,
    arbitrary_words,
    sums_of_perceptrons,
);

const LSB: &str = "ulp of a 16-bit feature";

pub(super) fn gathered(config: &str, codes: &[i16; 8], weights: [u16; 8]) -> i16 {
    let twin = ReferenceGatheringUnit::new(&Config::from_toml(config, "hard case").unwrap());
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
    twin.gather(&task, &mut features).unwrap();
    features[0]
}

/// A sample on a vertex: seven weights of 0 and one of 1.
fn a_weight_of_one() -> Case {
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for vertex in 0..8 {
        for code in [i16::MIN, -20_000, -1, 0, 1, 20_000, i16::MAX] {
            let mut codes = [0; 8];
            codes[vertex] = code;
            let weights = trilinear([0, 1, 2].map(|a| (vertex as u16 >> a & 1) << 12), 15);
            ours.see(f64::from(gathered("", &codes, weights)) - f64::from(code));
            // U0.16 ends at 0xffff.
            fails.see(f64::from((i64::from(code) * 0xffff) as i32 >> 16) - f64::from(code));
        }
    }
    Case {
        name: "a weight of exactly 1",
        naive: "U0.16, whose largest is 65,535 / 65,536",
        unit: LSB,
        fails,
        bound: 0.0,
        from: "U1.15 holds 1, and 1 times a code is the code",
        ours,
    }
}

fn constant_fields() -> Case {
    let mut draws = Draws(9);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for _ in 0..2000 {
        let fraction = [0; 3].map(|_| draws.between(0.0, 4097.0) as u16);
        for code in [i16::MIN, -1, 1, i16::MAX] {
            let found = gathered("[gu]\nweight_bits = 8", &[code; 8], trilinear(fraction, 8));
            ours.see(f64::from(found) - f64::from(code));
            let side = |corner: usize, axis: usize| {
                let u = f64::from(fraction[axis]) / 4096.0;
                if corner >> axis & 1 == 1 { u } else { 1.0 - u }
            };
            let alone = |c: usize| (side(c, 0) * side(c, 1) * side(c, 2) * 256.0).round();
            let sum: f64 = (0..8).map(alone).sum();
            fails.see((sum / 256.0 - 1.0) * f64::from(code));
        }
    }
    Case {
        name: "a constant field, weights of 8 bits",
        naive: "each weight rounded by itself",
        unit: LSB,
        fails,
        bound: 0.0,
        from: "the split tree's weights sum to exactly 1",
        ours,
    }
}

/// Eight times the largest words, as untrusted weights may be.
fn arbitrary_words() -> Case {
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for code in [i16::MIN, -30_000, -1, 1, 7, 30_000, i16::MAX] {
        let found = gathered("[gu]\nweights = \"any\"", &[code; 8], [u16::MAX; 8]);
        let sum = 8 * i64::from(code) * 65_535;
        let exact = (sum as f64 / 32_768.0).clamp(-32_768.0, 32_767.0);
        ours.see(f64::from(found) - exact);
        // 31 bits suffice for weights that sum to 1.
        let wrapped = sum << 33 >> 33;
        fails.see((wrapped as f64 / 32_768.0).clamp(-32_768.0, 32_767.0) - exact);
    }
    Case {
        name: "the largest sums of arbitrary weights",
        naive: "the accumulator of trusted weights, 31 bits",
        unit: LSB,
        fails,
        bound: 0.5,
        from: "35 bits hold eight of the largest products; one rounding",
        ours,
    }
}

/// The farthest that 200 weights can carry a sum, in units of 2^31.
fn sums_of_perceptrons() -> Case {
    let mut draws = Draws(17);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for scale in [1e-3, 0.1, 1.0, 50.0] {
        let weights: Vec<f32> = (0..200)
            .map(|_| (scale * draws.between(-1.0, 1.0)) as f32)
            .collect();
        let layer = Layer::new(200, weights.clone(), vec![(scale * 0.3) as f32]).unwrap();
        let mlp = MacMlp::quantise(&Mlp::new(vec![layer]).unwrap(), 8, &[100.0]).unwrap();
        let made = &mlp.layers()[0];
        let reach = |codes: &mut dyn Iterator<Item = i64>| {
            codes.map(|w| w.abs() * 32_768).sum::<i64>() as f64 / 2f64.powi(31)
        };
        ours.see(reach(&mut made.weights().iter().map(|w| i64::from(*w))));
        let most = weights.iter().fold(0f32, |most, w| most.max(w.abs()));
        let finest = |w: &f32| (w / most * 32_767.0).round() as i64;
        fails.see(reach(&mut weights.iter().map(finest)));
    }
    Case {
        name: "sums of a perceptron's layer, 200 inputs",
        naive: "weights at the finest scale that 16 bits hold",
        unit: "of the 32-bit sum's range",
        fails,
        bound: 1.0,
        from: "the scale is halved until no input overflows",
        ours,
    }
}
