//! What the work of the gathering unit exercises of its arithmetic: a bit that never changes, or a
//! rounding that never meets a tie, leaves a fault there unseen.

use std::collections::BTreeSet;

use potamoi_formats::config::{Config, Sums};
use potamoi_formats::rit::Vertices;
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::Reducer;
use schemars::JsonSchema;
use serde::Serialize;

/// What the compared entries exercised of the reducers.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct GatherReach {
    /// Bits of the weights that were 1 in some entry and 0 in another, bit 0 first.
    pub weight_bits: u32,
    /// Bits of the feature codes likewise.
    pub feature_bits: u32,
    /// Whether sums lay halfway between two codes and were rounded down, and up.
    pub ties: [bool; 2],
    /// Vertices of entries.
    pub vertices: BTreeSet<usize>,
    #[serde(skip)]
    weights: Seen,
    #[serde(skip)]
    features: Seen,
}

/// Bits that were 1 and bits that were 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Seen {
    ones: u32,
    zeros: u32,
}

impl Seen {
    const fn add(&mut self, code: u32) {
        self.ones |= code;
        self.zeros |= !code;
    }

    /// Those of the lowest `width` bits that were both.
    const fn moved(self, width: u32) -> u32 {
        self.ones & self.zeros & ((1 << width) - 1)
    }
}

impl GatherReach {
    /// Adds the entries of `tasks`. Entries without weights exercise no weight and no rounding.
    pub(super) fn add(&mut self, config: &Config, tasks: &[GatherTask]) {
        let reducer = Reducer::new(config);
        for task in tasks {
            self.vertices.insert(task.vertices.count());
            for code in &task.rows {
                self.features.add(u32::from(*code as u16));
            }
            if task.vertices.is_structured() {
                self.add_weighted(&reducer, task);
            }
        }
        // 1 is the bit above the fraction.
        self.weight_bits = self.weights.moved(reducer.weight_bits() + 1);
        self.feature_bits = self.features.moved(config.gu.feature_bits);
    }

    fn add_weighted(&mut self, reducer: &Reducer, task: &GatherTask) {
        let vertices = task.vertices.count();
        for entry in &task.entries {
            for weight in &entry.weights[..vertices] {
                self.weights.add(u32::from(*weight));
            }
            if self.ties == [true; 2] {
                continue;
            }
            for channel in 0..task.channels {
                let terms = (0..vertices).map(|v| {
                    let place = usize::from(entry.rows[v]) * task.channels + channel;
                    let code = task.rows.get(place).copied().unwrap_or_default();
                    (entry.weights[v], code)
                });
                if let Some(up) = reducer.tie(reducer.sum(terms)) {
                    self.ties[usize::from(up)] = true;
                }
            }
        }
    }

    /// Names what of the arithmetic was not exercised: nothing where all of it was.
    #[must_use]
    pub fn missing(&self, config: &Config) -> Vec<String> {
        let parts = [
            ("weights", self.weight_bits, config.gu.weight_bits + 1),
            ("feature codes", self.feature_bits, config.gu.feature_bits),
        ];
        let still = parts.into_iter().filter_map(|(name, moved, width)| {
            let still: Vec<_> = (0..width).filter(|bit| moved >> bit & 1 == 0).collect();
            match still.as_slice() {
                [] => None,
                _ if moved == 0 => Some(format!("{name} that differ")),
                [only] => Some(format!("{name} that differ in bit {only}")),
                [several @ .., last] => {
                    let several: Vec<_> = several.iter().map(u32::to_string).collect();
                    let several = several.join(", ");
                    Some(format!("{name} that differ in bits {several} and {last}"))
                }
            }
        });
        let rounds = config.gu.sums == Sums::Rounded;
        let tie = match self.ties {
            _ if !rounds => None,
            [true, true] => None,
            [false, false] => Some("ties of rounding".to_owned()),
            [down, _] => Some(format!("ties rounded {}", if down { "up" } else { "down" })),
        };
        let sizes: Vec<_> = Vertices::ALL
            .into_iter()
            .map(Vertices::count)
            .filter(|size| !self.vertices.contains(size))
            .map(|size| size.to_string())
            .collect();
        let sizes =
            (!sizes.is_empty()).then(|| format!("entries of {} vertices", sizes.join(", ")));
        still.chain(tie).chain(sizes).collect()
    }
}

#[cfg(test)]
mod tests {
    use potamoi_formats::rit::{MAX_VERTICES, RitEntry};

    use super::*;

    fn task(weights: [u16; 2], rows: [i16; 2]) -> GatherTask {
        let mut entry = RitEntry {
            slot: 0,
            rows: [0; MAX_VERTICES],
            weights: [0; MAX_VERTICES],
        };
        entry.rows[1] = 1;
        entry.weights[..2].copy_from_slice(&weights);
        GatherTask {
            vertices: Vertices::Two,
            channels: 1,
            rows: rows.to_vec(),
            entries: vec![entry],
        }
    }

    fn reach(config: &Config, tasks: &[GatherTask]) -> Vec<String> {
        let mut reach = GatherReach::default();
        reach.add(config, tasks);
        reach.missing(config)
    }

    #[test]
    fn weights_of_1_exercise_neither_weights_nor_rounding() {
        let config = Config::default();
        let one = 1 << config.gu.weight_bits;
        let said = reach(&config, &[task([one, one], [0, -1])]);
        assert_eq!(said[..2], ["weights that differ", "ties of rounding"]);
        assert_eq!(said[2], "entries of 1, 4, 8 vertices");
        // Single ids have no weight at all.
        let mut unweighted = task([0, 0], [0, -1]);
        unweighted.vertices = Vertices::One;
        assert_eq!(reach(&config, &[unweighted])[..2], said[..2]);
    }

    #[test]
    fn a_bit_that_stays_is_named() {
        let config = Config::default();
        let one = 1_u16 << config.gu.weight_bits;
        let all = one | (one - 1);
        let said = reach(
            &config,
            &[task([all, 0], [-1, 0]), task([one / 2, 0], [1, 0])],
        );
        assert_eq!(said, ["ties rounded up", "entries of 1, 4, 8 vertices"]);
        // Half of 1 is rounded down to 0, half of 3 up to 2.
        let half = |code| task([one / 2, 0], [code, !code]);
        let others = [task([all, 0], [-1, 0]), half(1), half(3)];
        assert_eq!(reach(&config, &others), ["entries of 1, 4, 8 vertices"]);
        let said = reach(&config, &[task([all & !6, 0], [-1, 0x40])]);
        assert_eq!(said[0], "weights that differ in bits 1 and 2");
        let said = reach(&config, &[task([all, 0], [!8, 0])]);
        assert_eq!(said[0], "feature codes that differ in bit 3");
    }
}
