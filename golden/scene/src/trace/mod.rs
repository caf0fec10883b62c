//! Golden traces: the units' inputs for a frame and the expected results, as an NPZ file.
//!
//! | array | type, shape | content |
//! |---|---|---|
//! | `header` | u8 | JSON: version, configuration hash, scene, formats, and type, shape and digest of every array |
//! | `gather_tasks` | u32, T x 4 | vertices an entry, channels, rows, entries of each MVoxel |
//! | `gather_rows` | i16 | feature codes, MVoxel after MVoxel, row after row |
//! | `gather_slots` | u32 | slot of each entry |
//! | `gather_entry_rows` | u16, E x 8 | row of each vertex; 0 past V |
//! | `gather_entry_weights` | u16, E x 8 | weight of each vertex, U1.W; 0 past V |
//! | `gather_features` | i16 | expected features, entry after entry, all channels |
//! | `gather_sums` | i32 | in place of `gather_features` with `gu.sums = "exact"`: unrounded sums, in units of 2^-W |
//! | `vector_ops` | u32, N x 4 | code, shift, rounding (0 floor, 1 half-up, 2 half-even), elements |
//! | `vector_a`, `vector_b`, `vector_results` | i32 | operands and expected results |

mod arrays;
mod error;
#[cfg(test)]
mod tests;

use std::path::Path;

use potamoi_formats::config::{Config, Sums};
use potamoi_formats::fixed::Rounding;
use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_formats::units::{OpCode, VectorOp};
use serde::{Deserialize, Serialize};

use crate::{Scene, SceneError};
use arrays::{Info, Packed, Values, array_error, list, rows};
use potamoi_base::file_keys::told;
use potamoi_base::files;
use potamoi_reference::observer::Observed;
use potamoi_reference::trace_recorder::{Computed, Gathered, Limits, Recorder};
use potamoi_reference::{GatherTask, ReferenceUnits};

pub use error::TraceError;

/// Version of the file format.
pub const FORMAT_VERSION: u32 = 1;
/// Array name of the gathering unit's results if they are codes.
const CODES: &str = "gather_features";
const EXACT: &str = "gather_sums";
/// The largest file that is read, in bytes.
const LIMIT: u64 = 1 << 32;

/// Work of the units and its results.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Built-in name or file of the scene.
    pub scene: String,
    /// Hash of the configuration.
    pub configuration: String,
    /// Formats, by name, as text such as `U0.16`.
    pub formats: Vec<(String, String)>,
    /// Type of the gathering unit's results: codes of 16 bits, or unrounded sums.
    pub sums: Sums,
    /// Work of the gathering unit.
    pub gathered: Vec<Gathered>,
    /// Work of the vector unit.
    pub computed: Vec<Computed>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    format_version: u32,
    scene: String,
    configuration: String,
    formats: Vec<(String, String)>,
    arrays: Vec<Info>,
}

impl Trace {
    /// Records a frame of a scene.
    ///
    /// # Errors
    /// Those of [`Scene::render_fixed`].
    pub fn record(scene: &Scene, config: &Config, limits: Limits) -> Result<Self, SceneError> {
        let mut twins = ReferenceUnits::new(config);
        let mut recorder = Recorder::new(limits);
        let mut units = Observed::new(&mut twins, config).by(&mut recorder);
        scene.render_fixed(config, &mut units)?;
        let exp = &config.vu.exp;
        let formats = [
            (
                "feature",
                format!("signed, {} bits", config.gu.feature_bits),
            ),
            ("weight", format!("U1.{}", config.gu.weight_bits)),
            ("exp input", exp.input.to_string()),
            ("exp output", format!("U0.{}", exp.output_bits)),
            (
                "one-minus-exp input",
                format!("U4.{}", exp.one_minus_frac_bits),
            ),
        ];
        Ok(Self {
            scene: scene.name().to_owned(),
            configuration: config.hash(),
            formats: formats.map(|(name, f)| (name.to_owned(), f)).to_vec(),
            sums: config.gu.sums,
            gathered: recorder.gathered,
            computed: recorder.computed,
        })
    }

    /// The bytes of the NPZ file; equal traces give equal bytes.
    ///
    /// # Errors
    /// A value fits no array.
    fn pack(&self) -> Result<Vec<u8>, String> {
        let narrow = |n: usize| u32::try_from(n).map_err(|_| format!("{n} is too many"));
        let (mut tasks, mut codes, mut slots) = (vec![], vec![], vec![]);
        let (mut entry_rows, mut weights, mut features) = (vec![], vec![], vec![]);
        for g in &self.gathered {
            let t = &g.task;
            tasks.push([
                t.vertices.count() as u32,
                narrow(t.channels)?,
                narrow(t.rows.len() / t.channels.max(1))?,
                narrow(t.entries.len())?,
            ]);
            codes.extend_from_slice(&t.rows);
            for entry in &t.entries {
                slots.push(entry.slot);
                entry_rows.push(entry.rows);
                weights.push(entry.weights);
            }
            features.extend_from_slice(&g.features);
        }
        let features = match self.sums {
            Sums::Rounded => {
                let narrow = |code| i16::try_from(code).map_err(|_| format!("code {code}"));
                let codes: Result<Vec<i16>, String> = features.into_iter().map(narrow).collect();
                (CODES, Values::I16(list(codes?)))
            }
            Sums::Exact => (EXACT, Values::I32(list(features))),
        };
        let (mut ops, mut a, mut b, mut results) = (vec![], vec![], vec![], vec![]);
        for c in &self.computed {
            ops.push([
                u32::from(c.op.code.code()),
                u32::from(c.op.shift),
                rounding_code(c.op.rounding),
                narrow(c.a.len())?,
            ]);
            a.extend_from_slice(&c.a);
            b.extend_from_slice(&c.b);
            results.extend_from_slice(&c.out);
        }
        let header = |arrays| Header {
            format_version: FORMAT_VERSION,
            scene: self.scene.clone(),
            configuration: self.configuration.clone(),
            formats: self.formats.clone(),
            arrays,
        };
        let arrays = [
            ("gather_tasks", Values::U32(rows(&tasks))),
            ("gather_rows", Values::I16(list(codes))),
            ("gather_slots", Values::U32(list(slots))),
            ("gather_entry_rows", Values::U16(rows(&entry_rows))),
            ("gather_entry_weights", Values::U16(rows(&weights))),
            features,
            ("vector_ops", Values::U32(rows(&ops))),
            ("vector_a", Values::I32(list(a))),
            ("vector_b", Values::I32(list(b))),
            ("vector_results", Values::I32(list(results))),
        ];
        arrays::pack(header, &arrays)
    }

    /// Writes the NPZ file under a temporary name and renames it.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), TraceError> {
        let fail = |source| TraceError::File {
            path: path.to_owned(),
            doing: "write",
            source,
        };
        let bytes = self.pack().map_err(|problem| TraceError::Container {
            path: path.to_owned(),
            problem,
        })?;
        files::write(path, &bytes).map_err(fail)
    }

    /// Reads a trace that was written for `config`.
    ///
    /// # Errors
    /// The file cannot be read, was changed, or belongs to another configuration.
    pub fn read(path: &Path, config: &Config) -> Result<Self, TraceError> {
        let fail = |source| TraceError::File {
            path: path.to_owned(),
            doing: "read",
            source,
        };
        let Some(bytes) = potamoi_base::files::read(path, LIMIT).map_err(fail)? else {
            return Err(TraceError::Container {
                path: path.to_owned(),
                problem: format!("above the limit of {LIMIT} bytes"),
            });
        };
        let trace = Self::unpack(path, &bytes)?;
        let expected = config.hash();
        if trace.configuration != expected {
            return Err(TraceError::Configuration {
                path: path.to_owned(),
                found: told(&trace.configuration),
                expected,
            });
        }
        if trace.sums != config.gu.sums {
            let (name, other) = match trace.sums {
                Sums::Exact => (EXACT, CODES),
                Sums::Rounded => (CODES, EXACT),
            };
            let problem = format!("expected `{other}`, from gu.sums of the configuration");
            return Err(array_error(path, name, problem));
        }
        Ok(trace)
    }

    fn unpack(path: &Path, bytes: &[u8]) -> Result<Self, TraceError> {
        let (header, mut packed) =
            Packed::open(path, bytes, |header: &Header| header.arrays.as_slice())?;
        if header.format_version != FORMAT_VERSION {
            let problem = format!(
                "format_version is {}: expected {FORMAT_VERSION}",
                header.format_version
            );
            return Err(array_error(path, "header", problem));
        }
        let (sums, gathered) = gathered(path, &mut packed)?;
        let computed = computed(path, &mut packed)?;
        Ok(Self {
            scene: header.scene,
            configuration: header.configuration,
            formats: header.formats,
            sums,
            gathered,
            computed,
        })
    }
}

/// The gathering tasks with their results, and the type of the results.
fn gathered(path: &Path, packed: &mut Packed<'_>) -> Result<(Sums, Vec<Gathered>), TraceError> {
    let tasks = packed.u32s("gather_tasks", Some(4))?;
    let mut codes = Parts::new(path, "gather_rows", packed.i16s("gather_rows", None)?);
    let mut slots = Parts::new(path, "gather_slots", packed.u32s("gather_slots", None)?);
    let entry_rows = packed.u16s("gather_entry_rows", Some(8))?;
    let weights = packed.u16s("gather_entry_weights", Some(8))?;
    let sums = match packed.next_name() {
        Some(EXACT) => Sums::Exact,
        _ => Sums::Rounded,
    };
    let (name, features) = match sums {
        Sums::Exact => (EXACT, packed.i32s(EXACT, None)?),
        Sums::Rounded => {
            let codes = packed.i16s(CODES, None)?;
            (CODES, codes.into_iter().map(i32::from).collect())
        }
    };
    let mut entry_rows = Parts::new(path, "gather_entry_rows", entry_rows);
    let mut weights = Parts::new(path, "gather_entry_weights", weights);
    let mut features = Parts::new(path, name, features);
    let mut gathered = vec![];
    for (i, [vertices, channels, rows, entries]) in fours(&tasks).enumerate() {
        let vertices = Vertices::ALL
            .into_iter()
            .find(|v| v.count() as u32 == vertices)
            .ok_or_else(|| {
                let problem = format!("row {i}: {vertices} vertices: expected 1, 2, 4 or 8");
                array_error(path, "gather_tasks", problem)
            })?;
        let [channels, rows, entries] = [channels, rows, entries].map(|n| n as usize);
        let codes = codes.take(rows, channels)?;
        let slots = slots.take(entries, 1)?;
        let entry_rows = entry_rows.take(entries, 8)?;
        let weights = weights.take(entries, 8)?;
        let places = entry_rows.as_chunks::<8>().0.iter();
        let weights = weights.as_chunks::<8>().0.iter();
        gathered.push(Gathered {
            task: GatherTask {
                vertices,
                channels,
                rows: codes.to_vec(),
                entries: slots
                    .iter()
                    .zip(places.zip(weights))
                    .map(|(slot, (rows, weights))| RitEntry {
                        slot: *slot,
                        rows: *rows,
                        weights: *weights,
                    })
                    .collect(),
            },
            features: features.take(entries, channels)?.to_vec(),
        });
    }
    codes.end()?;
    slots.end()?;
    entry_rows.end()?;
    weights.end()?;
    features.end()?;
    Ok((sums, gathered))
}

/// Vector operations with their operands and results.
fn computed(path: &Path, packed: &mut Packed<'_>) -> Result<Vec<Computed>, TraceError> {
    let ops = packed.u32s("vector_ops", Some(4))?;
    let mut a = Parts::new(path, "vector_a", packed.i32s("vector_a", None)?);
    let mut b = Parts::new(path, "vector_b", packed.i32s("vector_b", None)?);
    let results = packed.i32s("vector_results", None)?;
    let mut results = Parts::new(path, "vector_results", results);
    let mut computed = vec![];
    for (i, [code, shift, rounding, count]) in fours(&ops).enumerate() {
        let op = operation(code, shift, rounding).ok_or_else(|| {
            let problem = format!(
                "row {i}: code {code}, shift {shift}, rounding {rounding}: expected 0 to 6, \
                 0 to 63, 0 to 2"
            );
            array_error(path, "vector_ops", problem)
        })?;
        let count = count as usize;
        computed.push(Computed {
            op,
            a: a.take(count, 1)?.to_vec(),
            b: b.take(count, 1)?.to_vec(),
            out: results.take(count, 1)?.to_vec(),
        });
    }
    a.end()?;
    b.end()?;
    results.end()?;
    Ok(computed)
}

/// Values that are taken in consecutive pieces.
struct Parts<'p, T> {
    path: &'p Path,
    name: &'static str,
    values: Vec<T>,
    at: usize,
}

impl<'p, T> Parts<'p, T> {
    fn new(path: &'p Path, name: &'static str, values: Vec<T>) -> Self {
        Self {
            path,
            name,
            values,
            at: 0,
        }
    }

    fn take(&mut self, count: usize, width: usize) -> Result<&[T], TraceError> {
        let total = self.values.len();
        let end = count
            .checked_mul(width)
            .and_then(|n| n.checked_add(self.at));
        let part = end.and_then(|end| self.values.get(self.at..end).map(|part| (end, part)));
        let Some((end, part)) = part else {
            let problem = format!("{total} values: fewer than the tasks and operations name");
            return Err(array_error(self.path, self.name, problem));
        };
        self.at = end;
        Ok(part)
    }

    fn end(&self) -> Result<(), TraceError> {
        let (total, at) = (self.values.len(), self.at);
        if at == total {
            return Ok(());
        }
        let problem = format!("{total} values: expected {at}, as the tasks and operations name");
        Err(array_error(self.path, self.name, problem))
    }
}

fn fours(values: &[u32]) -> impl Iterator<Item = [u32; 4]> {
    values.as_chunks::<4>().0.iter().copied()
}

const fn rounding_code(rounding: Rounding) -> u32 {
    match rounding {
        Rounding::Floor => 0,
        Rounding::HalfUp => 1,
        Rounding::HalfEven => 2,
    }
}

fn operation(code: u32, shift: u32, rounding: u32) -> Option<VectorOp> {
    let code = *OpCode::ALL.get(code as usize)?;
    let rounding = [Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven]
        .get(rounding as usize)
        .copied()?;
    let shift = u8::try_from(shift).ok().filter(|s| *s < 64)?;
    Some(VectorOp {
        code,
        shift,
        rounding,
    })
}
