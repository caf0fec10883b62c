//! Plain units for tests, written directly from the definitions of the formats.
#![allow(dead_code, clippy::unwrap_used, clippy::panic)]

use std::path::PathBuf;

use potamoi_formats::fixed::round_shift;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_reference::splat_unit::{Composited, SplatJob};
use potamoi_reference::{GatherTask, Product, UnitError, Units};

/// The folder of shared data, where there is one.
pub(crate) fn shared() -> Option<PathBuf> {
    let folder = std::env::var_os("POTAMOI_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")),
        PathBuf::from,
    );
    folder.join("data").is_dir().then(|| folder.join("data"))
}

/// Units that gather rows and take `exp` correctly rounded from f64.
#[derive(Default)]
pub(crate) struct PlainUnits {
    /// Rows per task that were loaded.
    pub loaded: Vec<usize>,
    /// The exponential of each code, filled at first use.
    table: Vec<i32>,
}

impl Units for PlainUnits {
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        for task in tasks {
            assert_eq!(task.vertices.count(), 1);
            self.loaded.push(task.rows.len() / task.channels);
            for entry in &task.entries {
                let at = usize::from(entry.rows[0]) * task.channels;
                features.extend_from_slice(&task.rows[at..at + task.channels]);
            }
        }
        Ok(())
    }

    fn sums(&mut self, _: &[GatherTask], _: &mut Vec<i32>) -> Result<(), UnitError> {
        Err("no part of a cell is expected".into())
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        assert!(a.len() == b.len() && b.len() == out.len() && !a.is_empty());
        if self.table.is_empty() {
            let exp = |u: i32| (-f64::from(u) / 8192.0).exp() * 65536.0;
            self.table = (0..65536)
                .map(|u| exp(u).round().min(65535.0) as i32)
                .collect();
        }
        for ((a, b), out) in a.iter().zip(b).zip(out) {
            let (x, y) = (i128::from(*a), i128::from(*b));
            let exact = match op.code {
                OpCode::Exp => {
                    *out = self.table[(*a).clamp(0, 65535) as usize];
                    continue;
                }
                OpCode::Multiply => x * y,
                OpCode::SquareSum => x * x + y * y,
                other => panic!("{other:?} is not expected"),
            };
            let rounded = round_shift(exact, u32::from(op.shift), op.rounding);
            *out = rounded.clamp(i128::from(i32::MIN), i128::from(i32::MAX)) as i32;
        }
        Ok(())
    }

    fn splats(&mut self, _: &SplatJob<'_>) -> Result<Composited, UnitError> {
        Err("the vector unit composites".into())
    }

    fn multiplied(&mut self, _: Product) {}
}
