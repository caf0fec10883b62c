//! Reading of rivals' files.

use std::collections::BTreeMap;

use potamoi_gpu::Device;
use potamoi_gpu::programs::program;
use serde::Deserialize;

use crate::constant::{Constant, Entry, Origin};
use crate::rival::{Beside, Demand, Figure, Overlap, Rival, RivalError, Source, Stage, Term};
use crate::trace::{COUNTS, Class};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RivalEntry {
    title: String,
    publication: String,
    classes: Vec<Class>,
    clock_ghz: Entry,
    node_nm: Entry,
    area_mm2: Entry,
    power_w: Entry,
    overlap: OverlapEntry,
    stage: Vec<StageEntry>,
    left_out: Vec<String>,
    #[serde(default)]
    figure: Vec<FigureEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OverlapEntry {
    rule: Overlap,
    source: Option<String>,
    assumed: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StageEntry {
    name: String,
    #[serde(default)]
    work: Vec<TermEntry>,
    units: Option<Entry>,
    rate: Option<Entry>,
    bandwidth: Option<Entry>,
    gpu: Option<GpuEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TermEntry {
    count: String,
    least: Option<String>,
    times: Entry,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GpuEntry {
    device: String,
    program: String,
    kernels: Vec<String>,
    counts: BTreeMap<String, CountEntry>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum CountEntry {
    Named(String),
    Constant(Entry),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FigureEntry {
    what: String,
    /// Whether it stands in the rival's own publication.
    own: bool,
    published: Entry,
    class: Class,
    counts: BTreeMap<String, Entry>,
    beside: Option<BesideEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BesideEntry {
    device: String,
    program: String,
    counts: BTreeMap<String, CountEntry>,
}

struct Reader {
    file: String,
}

/// The files.
const FILES: [(&str, &str); 6] = [
    ("gscore", include_str!("../rivals/gscore.toml")),
    ("neurex-edge", include_str!("../rivals/neurex-edge.toml")),
    (
        "neurex-server",
        include_str!("../rivals/neurex-server.toml"),
    ),
    ("ngpc-8", include_str!("../rivals/ngpc-8.toml")),
    ("ngpc-64", include_str!("../rivals/ngpc-64.toml")),
    ("cicero", include_str!("../rivals/cicero.toml")),
];

impl Rival {
    /// All rivals, in the order of tables.
    ///
    /// # Errors
    /// A file is not as it has to be.
    pub fn all() -> Result<Vec<Self>, RivalError> {
        let each = FILES.iter().map(|(name, text)| Self::of_text(name, text));
        each.collect()
    }

    /// A rival from the text of its file.
    ///
    /// # Errors
    /// The text is not TOML, a key is missing or unknown, a constant has no origin, a stage names no count.
    pub fn of_text(name: &str, text: &str) -> Result<Self, RivalError> {
        read(name, text)
    }
}

fn read(name: &str, text: &str) -> Result<Rival, RivalError> {
    let reader = Reader {
        file: format!("{name}.toml"),
    };
    let entry: RivalEntry =
        toml::from_str(text).map_err(|error| reader.wrong(error.message().to_owned()))?;
    reader.rival(name, entry)
}

impl Reader {
    fn wrong(&self, message: String) -> RivalError {
        RivalError {
            file: self.file.clone(),
            message,
        }
    }

    fn constant(&self, place: &str, entry: Entry) -> Result<Constant, RivalError> {
        let read = entry.read();
        read.map_err(|message| self.wrong(format!("`{place}`: {message}")))
    }

    fn count(&self, place: &str, name: &str) -> Result<(), RivalError> {
        if COUNTS.iter().any(|own| own.name == name) {
            return Ok(());
        }
        let known: Vec<_> = COUNTS.iter().map(|own| own.name).collect();
        Err(self.wrong(format!(
            "`{place}`: no count is called `{name}`; the counts are {}",
            known.join(", ")
        )))
    }

    fn rival(&self, name: &str, entry: RivalEntry) -> Result<Rival, RivalError> {
        let overlap_origin = match (entry.overlap.source, entry.overlap.assumed) {
            (Some(text), None) => Origin::Source(text),
            (None, Some(text)) => Origin::Assumed(text),
            _ => {
                let message = "`overlap`: expected one of `source` and `assumed`";
                return Err(self.wrong(message.to_owned()));
            }
        };
        let stages = entry.stage.into_iter().map(|own| self.stage(own));
        let figures = entry.figure.into_iter().map(|own| self.figure(own));
        Ok(Rival {
            name: name.to_owned(),
            title: entry.title,
            publication: entry.publication,
            classes: entry.classes,
            clock_ghz: self.constant("clock_ghz", entry.clock_ghz)?,
            node_nm: self.constant("node_nm", entry.node_nm)?,
            area_mm2: self.constant("area_mm2", entry.area_mm2)?,
            power_w: self.constant("power_w", entry.power_w)?,
            overlap: entry.overlap.rule,
            overlap_origin,
            stages: stages.collect::<Result<_, _>>()?,
            left_out: entry.left_out,
            figures: figures.collect::<Result<_, _>>()?,
        })
    }

    fn stage(&self, entry: StageEntry) -> Result<Stage, RivalError> {
        let name = entry.name;
        let place = |what: &str| format!("stage {name}: {what}");
        let terms = entry.work.into_iter().map(|own| {
            for count in std::iter::once(&own.count).chain(&own.least) {
                self.count(&place("work"), count)?;
            }
            Ok(Term {
                times: self.constant(&place(&own.count), own.times)?,
                count: own.count,
                least: own.least,
            })
        });
        let work: Vec<Term> = terms.collect::<Result<_, RivalError>>()?;
        let demand = match (entry.units, entry.rate, entry.bandwidth, entry.gpu) {
            (Some(units), Some(rate), None, None) if !work.is_empty() => Demand::Units {
                work,
                units: self.constant(&place("units"), units)?,
                rate: self.constant(&place("rate"), rate)?,
            },
            (None, None, Some(bandwidth), None) if !work.is_empty() => Demand::Bytes {
                work,
                bandwidth: self.constant(&place("bandwidth"), bandwidth)?,
            },
            (None, None, None, Some(gpu)) if work.is_empty() => self.gpu(&place("gpu"), gpu)?,
            _ => {
                return Err(self.wrong(place(
                    "expected `work` with `units` and `rate`, `work` with `bandwidth`, or `gpu`",
                )));
            }
        };
        Ok(Stage { name, demand })
    }

    fn gpu(&self, place: &str, entry: GpuEntry) -> Result<Demand, RivalError> {
        self.known(place, &entry.device, &entry.program)?;
        Ok(Demand::Gpu {
            counts: self.sources(place, entry.counts)?,
            device: entry.device,
            program: entry.program,
            kernels: entry.kernels,
        })
    }

    /// Refuses devices and programs that there are not.
    fn known(&self, place: &str, device: &str, named: &str) -> Result<(), RivalError> {
        Device::builtin(device).map_err(|error| self.wrong(format!("`{place}`: {error}")))?;
        program(named).map_err(|error| self.wrong(format!("`{place}`: {error}")))?;
        Ok(())
    }

    fn sources(
        &self,
        place: &str,
        counts: BTreeMap<String, CountEntry>,
    ) -> Result<Vec<(String, Source)>, RivalError> {
        let each = counts.into_iter().map(|(name, entry)| {
            let source = match entry {
                CountEntry::Named(count) => {
                    self.count(place, &count)?;
                    Source::Count(count)
                }
                CountEntry::Constant(own) => {
                    Source::Constant(self.constant(&format!("{place}: {name}"), own)?)
                }
            };
            Ok((name, source))
        });
        each.collect()
    }

    fn figure(&self, entry: FigureEntry) -> Result<Figure, RivalError> {
        let place = format!("figure {}", entry.what);
        let mut counts = BTreeMap::new();
        for (name, own) in entry.counts {
            self.count(&place, &name)?;
            let own = self.constant(&format!("{place}: {name}"), own)?;
            counts.insert(name, own);
        }
        let beside = match entry.beside {
            None => None,
            Some(own) => {
                self.known(&place, &own.device, &own.program)?;
                Some(Beside {
                    counts: self.sources(&place, own.counts)?,
                    device: own.device,
                    program: own.program,
                })
            }
        };
        Ok(Figure {
            published: self.constant(&place, entry.published)?,
            what: entry.what,
            is_own: entry.own,
            class: entry.class,
            counts,
            beside,
        })
    }
}
