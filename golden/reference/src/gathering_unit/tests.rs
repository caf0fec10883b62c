#![allow(clippy::unwrap_used)]
use proptest::prelude::*;

use super::*;

fn entry(rows: [u16; 8], weights: [u16; 8]) -> RitEntry {
    RitEntry {
        slot: 7,
        rows,
        weights,
    }
}

fn task(vertices: Vertices, rows: Vec<i16>, entries: Vec<RitEntry>) -> GatherTask {
    GatherTask {
        vertices,
        channels: 1,
        rows,
        entries,
    }
}

fn run(text: &str, task: &GatherTask) -> (Vec<i16>, u8) {
    let config = Config::from_toml(text, "test").unwrap();
    let mut features = vec![];
    let flags = ReferenceGatheringUnit::new(&config).gather(task, &mut features);
    (features, flags.unwrap())
}

/// The largest and smallest sums that trusted weights can make.
#[test]
fn extremes_of_the_accumulator_come_back_exactly() {
    let one = [4096; 8];
    for code in [i16::MIN, -1, 0, 1, i16::MAX] {
        let all = task(
            Vertices::Eight,
            vec![code; 8],
            vec![entry([0, 1, 2, 3, 4, 5, 6, 7], one)],
        );
        assert_eq!(run("", &all), (vec![code], 0));
        let mut single = [0; 8];
        single[5] = 1 << 15;
        let alone = task(Vertices::Eight, vec![code; 8], vec![entry([7; 8], single)]);
        assert_eq!(run("", &alone), (vec![code], 0));
    }
    // Arbitrary words: eight times the largest is held at the limit.
    let any = "[gu]\nweights = \"any\"";
    let most = [u16::MAX; 8];
    for (code, held) in [(i16::MAX, i16::MAX), (i16::MIN, i16::MIN), (1, 16)] {
        let t = task(Vertices::Eight, vec![code], vec![entry([0; 8], most)]);
        assert_eq!(run(any, &t).0, [held], "{code}");
    }
}

/// Halves go to the even code; upward or downward they would drift.
#[test]
fn halves_go_to_even() {
    let half = [1 << 14, 1 << 14, 0, 0, 0, 0, 0, 0];
    let pairs = [(0, 1, 0), (1, 2, 2), (-1, 0, 0), (-2, -1, -2), (2, 3, 2)];
    for (a, b, expected) in pairs {
        let t = task(
            Vertices::Two,
            vec![a, b],
            vec![entry([0, 1, 0, 0, 0, 0, 0, 0], half)],
        );
        assert_eq!(run("", &t), (vec![expected], 0), "{a} {b}");
    }
}

#[test]
fn flags_say_what_is_wrong() {
    let half = [1 << 14, 1 << 14, 0, 0, 0, 0, 0, 0];
    let right = entry([0, 1, 0, 0, 0, 0, 0, 0], half);
    let rows = vec![100, 200];
    let mut missing = right;
    missing.rows[1] = 2;
    let t = task(Vertices::Two, rows.clone(), vec![missing]);
    assert_eq!(run("", &t), (vec![50], FLAG_ROW));
    let mut off = right;
    off.weights[0] -= 1;
    let t = task(Vertices::Two, rows.clone(), vec![off]);
    assert_eq!(run("", &t).1, FLAG_SUM);
    let narrow = "[gu]\nweight_bits = 8\nweights = \"any\"";
    let mut wide = right;
    wide.weights = [256, 512, 0, 0, 0, 0, 0, 0];
    let t = task(Vertices::Two, rows.clone(), vec![wide]);
    assert_eq!(run(narrow, &t), (vec![100], FLAG_WEIGHT));
    let t = task(
        Vertices::One,
        vec![1; 9],
        vec![entry([8, 0, 0, 0, 0, 0, 0, 0], half)],
    );
    assert_eq!(
        run("[mvoxel]\nrows = 8", &t),
        (vec![0], FLAG_TABLE | FLAG_ROW)
    );
}

proptest! {
    /// However an entry's vertices are parted, the sums of the parts are
    /// rounded to what the whole entry gives; rounding each part is not.
    #[test]
    fn sums_of_parts_are_rounded_as_the_whole(
        codes in prop::array::uniform8(any::<i16>()),
        fractions in prop::array::uniform3(0u16..=4096),
        parts in prop::array::uniform8(0usize..3),
    ) {
        let weights = crate::weights::trilinear(fractions, 15);
        let rows = [0, 1, 2, 3, 4, 5, 6, 7];
        let whole = task(Vertices::Eight, codes.to_vec(), vec![entry(rows, weights)]);
        let reducer = Reducer::new(&Config::paper());
        let sums = [0, 1, 2].map(|part| {
            let own = (0..8).filter(|v| parts[*v] == part);
            reducer.sum(own.map(|v| (weights[v], codes[v])))
        });
        prop_assert!(sums.iter().all(|s| i32::try_from(*s).is_ok()));
        let rounded = reducer.round(sums.iter().sum());
        prop_assert_eq!(run("", &whole).0, [rounded]);
    }

    /// Any rows, weights and widths against exact integers.
    #[test]
    fn features_are_the_rounded_exact_sums(
        bits in 8u32..=16, weight_bits in 4u32..=15, count in 0usize..3,
        raw in prop::collection::vec(any::<i16>(), 1..40),
        picks in prop::collection::vec((prop::array::uniform8(any::<u16>()), prop::array::uniform8(any::<u16>())), 1..20),
    ) {
        let vertices = [Vertices::Two, Vertices::Four, Vertices::Eight][count];
        let rows: Vec<i16> = raw.iter().map(|v| v >> (16 - bits)).collect();
        let entries: Vec<RitEntry> = picks
            .iter()
            .map(|(places, weights)| {
                let rows = places.map(|p| p % rows.len() as u16);
                entry(rows, weights.map(|w| w & ((2u32 << weight_bits) - 1) as u16))
            })
            .collect();
        let t = task(vertices, rows.clone(), entries.clone());
        let text = format!("[gu]\nfeature_bits = {bits}\nweight_bits = {weight_bits}\nweights = \"any\"");
        let (features, flags) = run(&text, &t);
        prop_assert_eq!(flags, 0);
        let top = 1i64 << (bits - 1);
        for (feature, e) in features.iter().zip(&entries) {
            let sum: i64 = (0..vertices.count())
                .map(|v| i64::from(rows[usize::from(e.rows[v])]) * i64::from(e.weights[v]))
                .sum();
            let (down, rest) = (sum >> weight_bits, sum & ((1 << weight_bits) - 1));
            let half = 1i64 << (weight_bits - 1);
            let up = rest > half || (rest == half && down & 1 == 1);
            let expected = (down + i64::from(up)).clamp(-top, top - 1);
            prop_assert_eq!(i64::from(*feature), expected);
        }
    }
}
