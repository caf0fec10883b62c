//! Systolic array of multiply-accumulate units: cycles and traffic of a matrix product.

use potamoi_reference::Product;

/// The operand that stays in the array.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum Dataflow {
    /// Weights stay: K along the rows, N along the columns.
    WeightStationary,
    /// Sums stay: M along the rows, N along the columns.
    OutputStationary,
    /// Inputs stay: K along the rows, M along the columns.
    InputStationary,
}

/// Bytes of an accumulator.
const PARTIAL: u64 = 4;

/// The array (paper, Sec. "Experimental Setup": 24 x 24).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MacArray {
    /// Rows of units.
    pub rows: u64,
    /// Columns of units.
    pub columns: u64,
    /// The stationary operand.
    pub dataflow: Dataflow,
    /// Whether each unit holds a second operand, loaded while the first is used, as in a TPU.
    pub is_double_buffered: bool,
}

impl MacArray {
    /// The paper's array, weight stationary.
    pub const PAPER: Self = Self {
        rows: 24,
        columns: 24,
        dataflow: Dataflow::WeightStationary,
        is_double_buffered: false,
    };

    /// Number of units.
    #[must_use]
    pub const fn units(&self) -> u64 {
        self.rows * self.columns
    }

    /// Folds of a product, and the vectors that stream through in each.
    #[must_use]
    pub const fn folds(&self, product: &Product) -> (u64, u64) {
        let Product {
            rows,
            depth,
            columns,
        } = *product;
        let (along_rows, along_columns, streamed) = match self.dataflow {
            Dataflow::WeightStationary => (depth, columns, rows),
            Dataflow::OutputStationary => (rows, columns, depth),
            Dataflow::InputStationary => (depth, rows, columns),
        };
        let folds = along_rows.div_ceil(self.rows) * along_columns.div_ceil(self.columns);
        (folds, streamed)
    }

    /// Cycles of a product (Samajdar et al., ISPASS 2020, Sec. III). A fold loads its operand down
    /// the rows, streams its vectors, and ends when the last has passed the far corner. With double
    /// buffering only the first load is waited for. Stationary sums leave on a path of their own
    /// while the next begin, as in SCALE-Sim 3.0.0.
    #[must_use]
    pub fn cycles(&self, product: &Product) -> u64 {
        if product.operations() == 0 {
            return 0;
        }
        let (folds, streamed) = self.folds(product);
        let through = streamed + self.rows + self.columns - 2;
        let load = match self.dataflow {
            Dataflow::OutputStationary => 0,
            Dataflow::WeightStationary | Dataflow::InputStationary => self.rows,
        };
        match self.is_double_buffered {
            true => load + folds * through,
            false => folds * (through + load),
        }
    }

    /// Bytes of partial sums, of 32 bits each (paper, ibid.), that leave the array and come back.
    /// Where a product is deeper than the rows of a weight-stationary array, every fold but the
    /// last of a column passes its sums on. Stationary sums never leave.
    #[must_use]
    pub const fn partial_bytes(&self, product: &Product) -> u64 {
        let handed_on = match self.dataflow {
            Dataflow::OutputStationary => 0,
            Dataflow::WeightStationary | Dataflow::InputStationary => {
                product.depth.div_ceil(self.rows).saturating_sub(1)
            }
        };
        handed_on * product.rows * product.columns * PARTIAL
    }

    /// Utilisation: share of the units' cycles that multiply, from 0 to 1.
    #[must_use]
    pub fn utilisation(&self, product: &Product) -> f64 {
        let all = self.cycles(product) * self.units();
        product.operations() as f64 / all.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used)]
    use super::*;
    use proptest::prelude::*;
    use rand::{Rng as _, SeedableRng as _};
    use rand_pcg::Pcg64Mcg;

    const fn product(rows: u64, columns: u64, depth: u64) -> Product {
        Product {
            rows,
            depth,
            columns,
        }
    }

    /// SCALE-Sim 3.0.0, weight stationary, 24 x 24, memory without stalls; it prints the last
    /// cycle's number, from 0.
    #[test]
    fn cycles_are_those_of_scale_sim() {
        for (of, expected) in [
            (product(4096, 128, 39), 49_992),
            (product(4096, 128, 128), 149_976),
            (product(4096, 3, 128), 24_996),
            (product(4096, 64, 32), 24_996),
            (product(4096, 16, 64), 12_498),
        ] {
            assert_eq!(MacArray::PAPER.cycles(&of), expected, "{of:?}");
        }
    }

    /// Fifty products of random sizes in each dataflow, as SCALE-Sim 3.0.0 itself counts them.
    #[test]
    #[ignore = "exhaustive; run with make test-full"]
    fn random_products_take_the_cycles_of_scale_sim() {
        let seed = 7;
        let mut generator = Pcg64Mcg::seed_from_u64(seed);
        let mut size = |most: u64| generator.random_range(1..=most);
        let products: Vec<Product> = (0..50)
            .map(|_| product(size(150), size(100), size(100)))
            .collect();
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        let mut layers = String::from("Layer,M,N,K,\n");
        for (i, own) in products.iter().enumerate() {
            let Product {
                rows,
                depth,
                columns,
            } = own;
            layers += &format!("p{i},{rows},{columns},{depth},\n");
        }
        std::fs::write(at.join("layers.csv"), layers).unwrap();
        std::fs::write(at.join("layout.csv"), "Layer name,\n").unwrap();
        let tools = concat!(env!("CARGO_MANIFEST_DIR"), "/../../.tools/bin");
        let path = format!("{tools}:{}", std::env::var("PATH").unwrap());
        for (flow, name) in FLOWS.into_iter().zip(["ws", "os", "is"]) {
            let text = include_str!("scale_sim.cfg").replace("{dataflow}", name);
            std::fs::write(at.join("array.cfg"), text).unwrap();
            let output = std::process::Command::new("scale-sim")
                .env("PATH", &path)
                .current_dir(at)
                .args(["-c", "array.cfg", "-t", "layers.csv", "-l", "layout.csv"])
                .args(["-p", name, "-i", "gemm", "-s", "N"])
                .output()
                .expect("scale-sim: get it with tools/setup oracles");
            assert!(output.status.success(), "{output:?}");
            let report = at.join(name).join("run").join("COMPUTE_REPORT.csv");
            let report = std::fs::read_to_string(report).unwrap();
            // Number, cycles with prefetching, cycles: the last one's, from 0.
            let found: Vec<u64> = report
                .lines()
                .skip(1)
                .map(|line| {
                    1 + line
                        .split(',')
                        .nth(2)
                        .unwrap()
                        .trim()
                        .parse::<u64>()
                        .unwrap()
                })
                .collect();
            let array = MacArray {
                dataflow: flow,
                ..MacArray::PAPER
            };
            let expected: Vec<u64> = products.iter().map(|own| array.cycles(own)).collect();
            assert_eq!(found, expected, "{name}, seed {seed}");
        }
    }

    const FLOWS: [Dataflow; 3] = [
        Dataflow::WeightStationary,
        Dataflow::OutputStationary,
        Dataflow::InputStationary,
    ];

    proptest! {
        #[test]
        fn no_product_is_faster_than_its_multiplications(
            rows in 1u64..5000, depth in 1u64..300, columns in 1u64..300,
            flow in 0usize..3, side in 1u64..64, is_double_buffered: bool,
        ) {
            let array = MacArray {
                rows: side,
                columns: 65 - side,
                dataflow: FLOWS[flow],
                is_double_buffered,
            };
            let of = product(rows, columns, depth);
            prop_assert!(array.utilisation(&of) <= 1.0);
            // No more than a vector of sums goes out in a cycle, and one back in.
            if array.dataflow == Dataflow::WeightStationary {
                let vector = array.columns * PARTIAL * array.cycles(&of);
                prop_assert!(array.partial_bytes(&of) <= vector);
                prop_assert_eq!(array.partial_bytes(&of) > 0, of.depth > array.rows);
            }
            let more = product(rows + 1, columns + 1, depth + 1);
            prop_assert!(array.cycles(&of) <= array.cycles(&more));
            if is_double_buffered {
                let plain = MacArray { is_double_buffered: false, ..array };
                prop_assert!(array.cycles(&of) <= plain.cycles(&of));
            }
        }
    }
}
