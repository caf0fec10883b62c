#![allow(clippy::unwrap_used)]

use std::collections::HashMap;

use proptest::prelude::*;

use super::*;

#[test]
fn mvoxels_fill_the_rows_as_far_as_they_go() {
    assert_eq!(edges([9, 9, 1], 512), Some([32, 16, 1]));
    assert_eq!(edges([9, 9, 1], 256), Some([16, 16, 1]));
    assert_eq!(edges([9, 9, 1], 8), Some([4, 2, 1]));
    assert_eq!(edges([9, 1, 1], 512), Some([512, 1, 1]));
    assert_eq!(edges([9, 9, 9], 512), Some([8; 3]));
    assert_eq!(edges([9, 9, 9], u32::MAX), Some([40; 3]));
    // Not the vertices of a cell.
    for (points, rows) in [([9, 9, 9], 7), ([9, 9, 1], 3), ([9, 1, 1], 1)] {
        assert_eq!(edges(points, rows), None, "{points:?}");
    }
}

/// By hand: MVoxels of 3 x 3 x 3 vertices, and the sum of their indices'
/// distances.
#[test]
fn distances_are_those_of_manhattan() {
    let tiling = Tiling::new([9; 3], [3; 3], Halo::Shared);
    assert_eq!(tiling.counts(), [4; 3]);
    assert_eq!(tiling.with_halo(Halo::Split).counts(), [3; 3]);
    // From the MVoxel (0, 1, 3) to (2, 3, 1), and from one outside, (-2, 0, 0).
    let to = tiling.index(2 + 4 * (3 + 4));
    let from = |eye| tiling.distances_from(eye).distance(to);
    assert_eq!(from([1.0, 2.0, 7.9]), 2 + 2 + 2);
    assert_eq!(from([-3.5, 0.0, 0.0]), 4 + 3 + 1);
    // Along an axis of one vertex nothing is far.
    let plane = Tiling::new([9, 9, 1], [3, 3, 1], Halo::Shared);
    assert_eq!(plane.distances_from([0.0, 0.0, 1e6]).distance([1, 2, 0]), 3);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// For lines, planes and volumes with a split halo, nothing is stored twice, and every corner
    /// of every cell is in exactly one holder, with the same code as with a shared halo.
    #[test]
    fn every_corner_is_found_once(
        points in prop::array::uniform3(2usize..11),
        axes in 1usize..4,
        edge in prop::array::uniform3(2usize..6),
        part in prop::array::uniform3(0.0..1.0f64),
    ) {
        let flat = |all: [usize; 3]| [0, 1, 2].map(|a| if a < axes { all[a] } else { 1 });
        let (points, edge) = (flat(points), flat(edge));
        let codes: Vec<i16> = (0..points.iter().product::<usize>() as i16).collect();
        let shared = Tiling::new(points, edge, Halo::Shared);
        let split = shared.with_halo(Halo::Split);
        let cut = |t: &Tiling| (0..t.count()).map(|m| t.cut(m, &codes, 1)).collect::<Vec<_>>();
        let (rows, parts) = (cut(&shared), cut(&split));
        prop_assert_eq!(parts.iter().map(Vec::len).sum::<usize>(), codes.len());
        let at = [0, 1, 2].map(|a| part[a] * (points[a] - 1) as f64);
        let (here, there) = (shared.locate(at), split.locate(at));
        prop_assert_eq!(here.fraction, there.fraction);
        prop_assert_eq!(shared.holders(&here).count(), 1);
        let mut found = HashMap::new();
        for holder in split.holders(&there) {
            let (own, held) = split.part_rows(&there, holder);
            let here = (0..1usize << axes).filter(|c| held >> c & 1 == 1);
            let last = here.map(|corner| own[corner]).max();
            prop_assert_eq!(Some(split.last_row(&there, holder)), last);
            for corner in (0..1 << axes).filter(|c| held >> c & 1 == 1) {
                let code = parts[holder.mvoxel][usize::from(own[corner])];
                prop_assert_eq!(found.insert(corner, code), None);
            }
        }
        let whole = shared.corner_rows(&here);
        prop_assert_eq!(found.len(), 1 << axes);
        for (corner, code) in found {
            prop_assert_eq!(rows[here.mvoxel][usize::from(whole[corner])], code);
        }
        let owner = shared.holders(&here).next().unwrap();
        let last = whole[..1 << axes].iter().copied().max();
        prop_assert_eq!(Some(shared.last_row(&here, owner)), last);
        let (again, held) = shared.part_rows(&here, owner);
        prop_assert_eq!((again, held), (whole, u8::MAX));
    }
}
