//! Sums of weights.

use potamoi_formats::config::Config;
use potamoi_units::gathering_unit::gathering_unit;

use super::{CELLS, Unit, compact, entry, even};

/// Untrusted weights need not sum to one.
#[test]
fn any_weights_raise_no_sum_flag() {
    let mut unit = Unit::of("weights = \"any\"", 3, 1);
    unit.rows(&[1, 2, 3, 4]);
    let mut vertices = even();
    vertices[7].1 = 33;
    unit.rit(&entry(vertices));
    assert_eq!(unit.flags(), 0);
}

/// Fractions above 1 count as 1, and those of axes that an entry lacks not at all:
/// a constant comes back as it is.
#[test]
fn compact_weights_sum_to_one_whatever_the_bits() {
    let module = gathering_unit(&Config::from_toml(CELLS, "test").unwrap()).unwrap();
    for log2 in [1, 2, 3] {
        for fraction in [[0; 3], [1, 4095, 77], [8191, 5000, 4097], [4096, 0, 8191]] {
            let mut unit = Unit::new(&module, log2, 1);
            unit.set("m_axis_feat_tready", 0);
            unit.rows(&[0x7ffe; 8]);
            unit.rit(&compact(fraction, 0));
            assert_eq!(unit.get("m_axis_feat_tvalid"), 1);
            assert_eq!(unit.get("m_axis_feat_tdata"), 0x7ffe, "{log2} {fraction:?}");
        }
    }
}

/// Of exact sums a part may weigh less than 1, and never more.
#[test]
fn parts_of_cells_may_weigh_less_than_one() {
    for (weight, flags) in [(31, 0), (32, 0), (33, 1 << 2)] {
        let mut unit = Unit::of("sums = \"exact\"", 3, 1);
        unit.rows(&[1, 2, 3, 4]);
        unit.rit(&entry([(0, weight); 8]));
        assert_eq!(unit.flags(), flags, "{weight}");
    }
}
