//! The 256 cases of marching cubes (Lorensen and Cline 1987), derived rather than tabulated:
//! contours of the six faces of a cell, joined to loops, and filled with triangles.
//!
//! If two diagonally opposite corners of a face are inside, each is cut off separately. That
//! depends only on the face, so the two cells that share it agree, and no crack opens between
//! them; the first published table has some.

use std::sync::LazyLock;

/// Corners of an edge of a cell. Corner `c` lies at `(c & 1, c >> 1 & 1,
/// c >> 2)`; edges 0 to 3 run along x, 4 to 7 along y, 8 to 11 along z.
pub(super) const fn ends(edge: u8) -> [u8; 2] {
    let (axis, place) = (edge / 4, edge % 4);
    let low = (place & 1) << ((axis + 1) % 3) | (place >> 1) << ((axis + 2) % 3);
    [low, low | 1 << axis]
}

/// The edge between two neighbouring corners.
const fn edge_between(a: u8, b: u8) -> u8 {
    let axis = (a ^ b).trailing_zeros() as u8;
    let low = a & b;
    axis * 4 + (low >> ((axis + 1) % 3) & 1) + 2 * (low >> ((axis + 2) % 3) & 1)
}

/// Triangles of every case. Bit `c` of the case is set if corner `c` is inside. Each triangle has
/// three cut edges, counterclockwise as seen from outside the surface.
pub(super) static CASES: LazyLock<Vec<Vec<[u8; 3]>>> =
    LazyLock::new(|| (0..=255).map(triangles).collect());

/// Corners of a face in order, counterclockwise as seen from outside the cell.
fn face(axis: u8, far: bool) -> [u8; 4] {
    let (b, c) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
    let base = u8::from(far) << axis;
    let around = [base, base | b, base | b | c, base | c];
    if far {
        around
    } else {
        [around[0], around[3], around[2], around[1]]
    }
}

fn triangles(case: u8) -> Vec<[u8; 3]> {
    let inside = |corner: u8| case >> corner & 1 == 1;
    // Of each cut edge the next one on its loop. It is where a run of inside
    // corners of one of its faces begins and where one of the other ends.
    let mut next = [None; 12];
    for axis in 0..3 {
        for far in [false, true] {
            let corners = face(axis, far);
            for k in 0..4 {
                let before = corners[(k + 3) % 4];
                if !inside(corners[k]) || inside(before) {
                    continue;
                }
                let last = (0..4).find(|n| !inside(corners[(k + n) % 4]));
                if let Some(n) = last {
                    let leaves = edge_between(corners[(k + n + 3) % 4], corners[(k + n) % 4]);
                    next[edge_between(before, corners[k]) as usize] = Some(leaves);
                }
            }
        }
    }
    let mut all = vec![];
    for start in 0..12u8 {
        let mut around = vec![];
        let mut at = start;
        while let Some(to) = next[at as usize].take() {
            around.push(at);
            at = to;
        }
        all.extend(fill(&around).unwrap_or_default());
    }
    all
}

/// Whether a diagonal between two cut edges lies in a face of the cell. The neighbour may have the
/// same diagonal, and four triangles would share it.
fn share_a_face(a: u8, b: u8) -> bool {
    let [[a, c], [b, d]] = [ends(a), ends(b)];
    // Bits that all four corners have alike.
    let differ = (a ^ c) | (a ^ b) | (a ^ d);
    differ != 7
}

/// Triangulates a loop without a diagonal in a face.
fn fill(around: &[u8]) -> Option<Vec<[u8; 3]>> {
    let (first, rest) = around.split_first()?;
    let (last, between) = rest.split_last()?;
    if between.is_empty() {
        return Some(vec![]);
    }
    let fine = |i: usize, j: usize| j - i == 1 || !share_a_face(around[i], around[j]);
    // The triangle at the side from the last to the first.
    (1..=between.len()).find_map(|k| {
        if !(fine(0, k) && fine(k, around.len() - 1)) {
            return None;
        }
        let mut all = vec![[*first, around[k], *last]];
        all.extend(fill(&around[..=k])?);
        all.extend(fill(&around[k..])?);
        Some(all)
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::collections::HashMap;

    fn is_cut(case: usize, edge: u8) -> bool {
        let [a, b] = ends(edge).map(|c| case >> c & 1);
        a != b
    }

    #[test]
    fn edges_join_the_corners_that_they_are_between() {
        for edge in 0..12 {
            let [a, b] = ends(edge);
            assert_eq!(a ^ b, 1 << (edge / 4));
            assert_eq!(edge_between(a, b), edge);
            assert_eq!(edge_between(b, a), edge);
        }
    }

    /// Within a cell every inner edge has two triangles, of opposite senses, and
    /// the border is the contours of the faces, each once.
    #[test]
    fn every_case_is_a_surface_whose_border_lies_in_the_faces() {
        for (case, triangles) in CASES.iter().enumerate() {
            let mut sides: HashMap<[u8; 2], i32> = HashMap::new();
            let mut used = [false; 12];
            for t in triangles {
                for k in 0..3 {
                    used[t[k] as usize] = true;
                    *sides.entry([t[k], t[(k + 1) % 3]]).or_default() += 1;
                }
            }
            assert!(
                (0..12).all(|e| used[e as usize] == is_cut(case, e)),
                "{case}"
            );
            for ([a, b], count) in &sides {
                assert_eq!(*count, 1, "{case}");
                let inner = sides.contains_key(&[*b, *a]);
                assert_eq!(inner, !share_a_face(*a, *b), "{case}: {a} {b}");
            }
            assert!(triangles.len() <= 5, "{case}: {}", triangles.len());
        }
    }

    /// What a face's contours are depends on its corners alone: mirrored, the
    /// neighbour has the same lines in the other sense.
    #[test]
    fn neighbours_agree_on_the_face_between_them() {
        let border = |case: usize, axis: u8, far: bool| {
            let mut all = vec![];
            for t in &CASES[case] {
                for k in 0..3 {
                    let side = [t[k], t[(k + 1) % 3]];
                    let on = |e: u8| ends(e).iter().all(|c| (c >> axis & 1 == 1) == far);
                    if on(side[0]) && on(side[1]) {
                        all.push(side);
                    }
                }
            }
            all
        };
        for axis in 0..3u8 {
            let mask: usize = (0..8).filter(|c| c >> axis & 1 == 1).map(|c| 1 << c).sum();
            let move_down = |edge: u8| {
                let [a, b] = ends(edge).map(|c| c & !(1 << axis));
                edge_between(a, b)
            };
            for low in 0..256 {
                // Every case whose near face is this one's far one.
                let shared = (low & mask) >> (1 << axis);
                for other in 0..256usize {
                    if other & !mask != shared {
                        continue;
                    }
                    let mut here: Vec<_> = border(low, axis, true)
                        .into_iter()
                        .map(|[a, b]| [move_down(b), move_down(a)])
                        .collect();
                    let mut there = border(other, axis, false);
                    here.sort_unstable();
                    there.sort_unstable();
                    assert_eq!(here, there, "{axis} {low} {other}");
                }
            }
        }
    }

    #[test]
    fn one_corner_is_cut_off_and_faces_outwards() {
        let cut = &CASES[1];
        assert_eq!(cut.len(), 1);
        let middle = |e: u8| {
            let [a, b] = ends(e).map(|c| [c & 1, c >> 1 & 1, c >> 2].map(f64::from));
            glam::DVec3::from([0, 1, 2].map(|i| (a[i] + b[i]) / 2.0))
        };
        let [a, b, c] = cut[0].map(middle);
        assert!((b - a).cross(c - a).dot(glam::DVec3::ONE) > 0.0);
        assert!(CASES[0].is_empty() && CASES[255].is_empty());
    }
}
