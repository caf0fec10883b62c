//! The hard operands through the Verilated units and the twins: the same bits.

use potamoi_formats::config::Config;
use potamoi_formats::fixed::Rounding;
use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_reference::weights::trilinear;
use potamoi_reference::{GatherTask, ReferenceUnits, Units};
use potamoi_rtl::{EngineKind, RtlUnits};

/// Computes on both and gives what they agree on.
fn agreed(rtl: &mut RtlUnits, op: VectorOp, a: &[i32], b: &[i32]) -> Vec<i32> {
    let mut expected = vec![0; a.len()];
    let mut twins = ReferenceUnits::new(&Config::paper());
    twins.vector(op, a, b, &mut expected).unwrap();
    let mut found = vec![0; a.len()];
    rtl.vector(op, a, b, &mut found).unwrap();
    assert_eq!(found, expected, "{op:?} of {a:?}");
    found
}

#[test]
fn exponentials_at_their_ends_and_multiples_of_ln_2() {
    let mut rtl = RtlUnits::new(&Config::paper());
    let mut codes = vec![
        0,
        1,
        2,
        65_535,
        65_536,
        1 << 20,
        i32::MAX,
        -1,
        -8192,
        i32::MIN,
        15_967,
    ];
    for m in 1..=11 {
        let at = (f64::from(m) * 2f64.ln() * 8192.0).round() as i32;
        codes.extend(at - 2..=at + 2);
    }
    let zeros = vec![0; codes.len()];
    let out = agreed(&mut rtl, VectorOp::new(OpCode::Exp), &codes, &zeros);
    // Ends are held: 1 at 0 and of positive powers, exp(-8) past the range. The last lies
    // 2^-16 units from the midpoint of two codes.
    assert_eq!(out[..3], [65_535, 65_528, 65_520]);
    assert_eq!(out[3..10], [22, 22, 22, 22, 65_535, 65_535, 65_535]);
    assert!([9332, 9333].contains(&out[10]), "{}", out[10]);
    // Empty space takes no light, and thin air hardly any.
    let thin = [
        0,
        -1,
        i32::MIN,
        1,
        7,
        8,
        15,
        16,
        (8 << 20) - 1,
        8 << 20,
        i32::MAX,
    ];
    let out = agreed(
        &mut rtl,
        VectorOp::new(OpCode::OneMinusExp),
        &thin,
        &[0; 11],
    );
    assert_eq!(out[..3], [0; 3]);
}

#[test]
fn long_transmittances_and_extreme_squares() {
    let mut rtl = RtlUnits::new(&Config::paper());
    let times = VectorOp {
        code: OpCode::Multiply,
        shift: 16,
        rounding: Rounding::HalfUp,
    };
    // A thousand samples of each alpha, nothing and all among them.
    let factors = [0, 1, 2, 3, 16, 257, 258, 655, 64_881, 65_535, 65_536].map(|a| 65_536 - a);
    let mut left = vec![1 << 20; factors.len()];
    for _ in 0..1000 {
        let next = agreed(&mut rtl, times, &left, &factors);
        assert!(next.iter().zip(&left).all(|(n, l)| (0..=*l).contains(n)));
        left = next;
    }
    assert_eq!((left[0], left[10]), (1 << 20, 0));
    let square = VectorOp {
        code: OpCode::SquareSum,
        shift: 20,
        rounding: Rounding::HalfUp,
    };
    let ends = [i32::MIN, i32::MIN + 1, -1, 0, 1, i32::MAX];
    let (a, b): (Vec<i32>, Vec<i32>) = ends.iter().flat_map(|a| ends.map(|b| (*a, b))).unzip();
    let out = agreed(&mut rtl, square, &a, &b);
    assert!(out.iter().all(|v| *v >= 0));
    assert_eq!(out[0], i32::MAX);
}

/// Extremes of the accumulators, weights of exactly 1, and corners that share rows.
fn tasks() -> Vec<GatherTask> {
    let ends = [i16::MIN, i16::MAX, -1, 1, 0, -32_767, 12_345, -12_345];
    let mut entries = vec![];
    for fraction in [
        [0; 3],
        [4096; 3],
        [2048; 3],
        [1, 4095, 2049],
        [4096, 0, 2048],
    ] {
        for rows in [
            [0, 1, 2, 3, 4, 5, 6, 7],
            [0; 8],
            [1; 8],
            [0, 1, 0, 1, 0, 0, 1, 1],
            [7; 8],
        ] {
            entries.push(RitEntry {
                slot: entries.len() as u32,
                rows,
                weights: trilinear(fraction, 15),
            });
        }
    }
    vec![GatherTask {
        vertices: Vertices::Eight,
        channels: 3,
        rows: (0..8)
            .flat_map(|i| [ends[i], ends[7 - i], ends[i % 2]])
            .collect(),
        entries,
    }]
}

#[test]
fn extremes_and_collisions_are_gathered_alike() {
    let config = Config::paper();
    let (mut twins, mut rtl) = (ReferenceUnits::new(&config), RtlUnits::new(&config));
    let (mut expected, mut found) = (vec![], vec![]);
    twins.gather(&tasks(), &mut expected).unwrap();
    rtl.gather(&tasks(), &mut found).unwrap();
    assert_eq!(found, expected);
    assert_eq!((twins.gather_flags(), rtl.gather_flags()), (0, 0));
    // All corners are one row: its code comes back, whatever the weights.
    for (entry, features) in tasks()[0].entries.iter().zip(found.chunks(3)) {
        if entry.rows.iter().all(|r| *r == entry.rows[0]) {
            let row = usize::from(entry.rows[0]) * 3;
            assert_eq!(features, &tasks()[0].rows[row..row + 3]);
        }
    }
}

/// Weights that need not sum to 1, at their largest, in a unit with room for them.
#[test]
fn arbitrary_words_are_gathered_alike() {
    let text = "[gu]\nbanks = 4\nports = 1\nweights = \"any\"\n";
    let config = Config::from_toml(text, "test").unwrap();
    let mut work = tasks();
    for (i, entry) in work[0].entries.iter_mut().enumerate() {
        entry.weights = [[u16::MAX; 8], [0; 8], [1 << 15; 8]][i % 3];
    }
    let mut twins = ReferenceUnits::new(&config);
    let mut rtl = RtlUnits::on(EngineKind::Interpreter, &config);
    let (mut expected, mut found) = (vec![], vec![]);
    twins.gather(&work, &mut expected).unwrap();
    rtl.gather(&work, &mut found).unwrap();
    assert_eq!(found, expected);
    assert!(found.contains(&i16::MIN) && found.contains(&i16::MAX));
}
