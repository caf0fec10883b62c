//! Each broken promise of a stream raises its own flag, and nothing else does.

use super::{Beat, FULL, Unit, entry, even};

#[test]
fn what_is_right_raises_nothing() {
    let mut unit = Unit::of("", 3, 1);
    unit.rows(&[1, 2, 3, 4]);
    unit.rit(&entry(even()));
    assert_eq!(unit.get("stat_entries"), 1);
    assert_eq!(unit.get("stat_busy"), 8);
    assert_eq!(unit.flags(), 0);
}

#[test]
fn each_broken_promise_raises_its_own_flag() {
    let raised = |beats: &[Beat]| {
        let mut unit = Unit::of("", 3, 1);
        unit.rows(&[1, 2, 3, 4]);
        unit.rit(beats);
        unit.flags()
    };
    let mut vertices = even();
    vertices[5].0 = 4;
    assert_eq!(
        raised(&entry(vertices)),
        1 << 0,
        "a row that was not loaded"
    );
    let mut vertices = even();
    (vertices[2].1, vertices[3].1) = (32 | 1 << 9, 32);
    assert_eq!(raised(&entry(vertices)), 1 << 1, "a weight above bit W");
    let mut vertices = even();
    vertices[7].1 = 33;
    assert_eq!(raised(&entry(vertices)), 1 << 2, "weights off one");
    // Half an entry of two vertices is none of eight.
    let ragged = raised(&[(0, FULL, true)]);
    assert_eq!(ragged & !0b111, 1 << 3, "ragged entries");
    let mut gap = entry(even());
    gap[1].1 = 0x3f;
    assert_eq!(raised(&gap) & 1 << 4, 1 << 4, "a gap in a beat");

    let mut unit = Unit::of("", 3, 1);
    unit.rows(&[1, 2, 3, 4, 5]);
    assert_eq!(unit.flags(), 1 << 6, "a row past the table");

    for (log2, segments) in [(2, 1), (3, 3), (3, 0)] {
        let mut unit = Unit::of("", log2, segments);
        unit.rows(&[1, 2, 3, 4]);
        unit.rit(&entry(even()));
        assert_eq!(
            unit.flags() & 1 << 7,
            1 << 7,
            "{log2} {segments}: bad setting"
        );
    }
}
