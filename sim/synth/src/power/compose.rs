//! Composes a unit's energy from that of slices.
//!
//! A kind of module that is the same in every slice, and more frequent in a larger unit, scales
//! with its number. A module that a unit has once grows linearly in banks or lanes, along the line
//! through two slices: words of a FIFO, masks of a row.

use std::collections::BTreeMap;

use potamoi_gates::Flat;

use super::count::Energies;
use super::static_data::StaticData;
use crate::netlist::ModuleArea;

/// A kind of module in a slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    pub(super) count: u64,
    pub(super) cells: u64,
    pub(super) flops: u64,
    /// Energies of all instances, in femtojoules a cycle.
    pub(super) energies: Energies,
    /// Leakage of all instances, in nanowatts.
    pub(super) leakage: f64,
}

/// Size of a slice, and its kinds of module by name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Slice {
    pub(super) size: u64,
    pub(super) pieces: BTreeMap<String, Piece>,
}

impl Slice {
    pub(super) fn new(size: u64, still: &StaticData, energies: &[Energies]) -> Self {
        let flat: &Flat = &still.flat;
        let mut own = vec![[0u64; 2]; flat.modules.len()];
        for cell in &flat.cells {
            let gate = &flat.gates[usize::from(cell.gate)];
            let [cells, flops] = &mut own[usize::from(cell.module)];
            *cells += 1;
            *flops += u64::from(gate.flop.is_some());
        }
        let leakage = still.leakage_nw();
        let pieces = flat.modules.iter().enumerate().map(|(i, module)| {
            let piece = Piece {
                count: module.count,
                cells: own[i][0] / module.count,
                flops: own[i][1] / module.count,
                energies: energies[i],
                leakage: leakage[i],
            };
            (module.name.clone(), piece)
        });
        Self {
            size,
            pieces: pieces.collect(),
        }
    }

    /// Weighted mean of slices of one size.
    pub(super) fn mean(slices: &[Self], shares: &[f64]) -> Option<Self> {
        let mut mean = slices.first()?.clone();
        for (name, piece) in &mut mean.pieces {
            let mut sum = Energies::default();
            for (slice, share) in slices.iter().zip(shares) {
                sum = sum.plus(slice.pieces.get(name)?.energies.times(*share));
            }
            piece.energies = sum;
        }
        Some(mean)
    }
}

/// Energies and leakage of the whole unit by module, from two slices, the smaller first. Modules
/// that no slice has are named in the error.
pub(super) fn compose(
    slices: &[Slice; 2],
    size: u64,
    modules: &[ModuleArea],
) -> Result<BTreeMap<String, (Energies, f64)>, String> {
    let [small, large] = slices;
    let along = (size as f64 - small.size as f64) / (large.size as f64 - small.size as f64);
    let mut found = BTreeMap::new();
    for module in modules {
        let name = &module.module;
        let (Some(a), Some(b)) = (small.pieces.get(name), large.pieces.get(name)) else {
            return Err(name.clone());
        };
        let is_same = (b.cells, b.flops) == (module.cells, module.flops);
        let of = if is_same && module.count != b.count {
            let times = module.count as f64 / b.count as f64;
            (b.energies.times(times), b.leakage * times)
        } else {
            let line = |a: f64, b: f64| a + along * (b - a);
            let (p, q) = (a.energies, b.energies);
            let energies = Energies {
                switching: line(p.switching, q.switching),
                internal: line(p.internal, q.internal),
                clock: line(p.clock, q.clock),
            };
            (energies, line(a.leakage, b.leakage))
        };
        found.insert(name.clone(), of);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn piece(count: u64, cells: u64, energy: f64) -> Piece {
        let energies = Energies {
            switching: energy,
            internal: 2.0 * energy,
            clock: 1.0,
        };
        Piece {
            count,
            cells,
            flops: 1,
            energies,
            leakage: energy,
        }
    }

    fn slice(size: u64, pieces: &[(&str, Piece)]) -> Slice {
        let pieces = pieces.iter().map(|(n, p)| ((*n).to_owned(), *p)).collect();
        Slice { size, pieces }
    }

    fn module(name: &str, count: u64, cells: u64) -> ModuleArea {
        ModuleArea {
            module: name.to_owned(),
            count,
            cells,
            flops: 1,
            area_um2: 1.0,
            flop_area_um2: 0.0,
        }
    }

    #[test]
    fn what_there_is_more_of_counts_and_what_is_larger_grows_along_a_line() {
        let slices = [
            slice(
                2,
                &[
                    ("top", piece(1, 10, 5.0)),
                    ("lane", piece(2, 7, 6.0)),
                    ("table", piece(1, 3, 1.0)),
                ],
            ),
            slice(
                4,
                &[
                    ("top", piece(1, 14, 9.0)),
                    ("lane", piece(4, 7, 14.0)),
                    ("table", piece(1, 3, 1.5)),
                ],
            ),
        ];
        let modules = [
            module("top", 1, 70),
            module("lane", 32, 7),
            module("table", 1, 3),
        ];
        let found = compose(&slices, 32, &modules).unwrap();
        // 32 of 4 lanes that take 14; 5 + 15 x (9 - 5); 1 + 15 x 0.5 although it is the same.
        for (name, expected) in [("lane", 112.0), ("top", 65.0), ("table", 8.5)] {
            let (energies, leakage) = found[name];
            assert!((energies.switching - expected).abs() < 1e-9, "{name}");
            assert!((energies.internal - 2.0 * expected).abs() < 1e-9, "{name}");
            assert!((leakage - expected).abs() < 1e-9, "{name}");
        }
        let missing = compose(&slices, 32, &[module("other", 1, 1)]);
        assert_eq!(missing.unwrap_err(), "other");
    }

    /// Slices with weights of a quarter and three quarters.
    #[test]
    fn slices_of_one_size_count_by_their_shares() {
        let of = |energy: f64| slice(2, &[("lane", piece(2, 7, energy))]);
        let mean = Slice::mean(&[of(4.0), of(8.0)], &[0.25, 0.75]).unwrap();
        let energies = mean.pieces["lane"].energies;
        assert!((energies.switching - 7.0).abs() < 1e-12, "{energies:?}");
        assert!((energies.internal - 14.0).abs() < 1e-12, "{energies:?}");
        assert!((energies.clock - 1.0).abs() < 1e-12, "{energies:?}");
        assert_eq!(Slice::mean(&[], &[]), None);
    }
}
