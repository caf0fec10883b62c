//! Data set of the grid's synthesis results.

use std::path::Path;

use potamoi_formats::config::Config;
use potamoi_formats::document::{self, Value};
use serde::{Deserialize, Serialize};

use super::design::{Family, Point};
use crate::report::{LibraryOrigin, ToolsOrigin};
use crate::{Library, NetlistDigests, PathEnd, Power, SynthError, Tools, UnitReport};

/// Relative difference of a period printed with more or fewer digits.
const NEAR: f64 = 1e-5;
/// Largest share of its unit's energy by which a module may be negative: it is the difference of
/// two slices, in which glitches differ.
const SLICED: f64 = 0.05;
/// Version of the file.
const FORMAT_VERSION: u32 = 3;
/// Size limit in bytes: a hundred times the files that come with the program.
const LIMIT: u64 = 16 << 20;

/// Synthesised configurations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    format_version: u32,
    /// Source of the cells.
    pub library: LibraryOrigin,
    /// Versions of the tools.
    pub tools: ToolsOrigin,
    /// Digest of the points as in the file, 16 hexadecimal digits.
    figures: String,
    /// Points in the order of the design.
    pub points: Vec<GridPoint>,
}

/// A synthesised configuration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridPoint {
    /// Family of its unit.
    pub family: Family,
    /// Its differences from the defaults, as TOML.
    pub config: String,
    /// Digests of the netlists that it was made from.
    pub netlists: NetlistDigests,
    /// Longest path in picoseconds, before wires.
    pub period_ps: f64,
    /// Longest path into each module.
    pub ends: Vec<PathEnd>,
    /// Switching activity.
    pub activity: GridActivity,
    /// Modules, the top one first.
    pub modules: Vec<GridModule>,
}

/// Switching activity of a unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridActivity {
    /// The scene.
    pub scene: String,
    /// Number of cycles.
    pub cycles: u64,
    /// Busy cycles, in which the unit issued.
    pub busy: u64,
    /// Channels of a sample; 0 for the vector unit.
    pub channels: u64,
    /// Energy of all flip-flops' clock pins, in picojoules a cycle.
    pub clock_pj: f64,
}

/// All modules of one kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridModule {
    /// Its name.
    pub module: String,
    /// Number of instances.
    pub count: u64,
    /// Area of one, in square micrometres.
    pub area_um2: f64,
    /// Flip-flops of one.
    pub flops: u64,
    /// Energy of all instances.
    pub energy: GridEnergy,
}

/// Energy of all modules of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridEnergy {
    /// Energy in picojoules a cycle with zero delays: each net changes at most once a cycle.
    pub zero_delay_pj: f64,
    /// Energy in picojoules a cycle with glitches.
    pub with_glitches_pj: f64,
    /// Leakage in nanowatts.
    pub leakage_nw: f64,
}

impl Grid {
    /// A grid of points synthesised with this library and these tools.
    #[must_use]
    pub fn new(
        library: &Library,
        node_nm: Option<u32>,
        tools: &Tools,
        points: Vec<GridPoint>,
    ) -> Self {
        Self {
            format_version: FORMAT_VERSION,
            library: LibraryOrigin::new(library, node_nm),
            tools: ToolsOrigin::new(tools),
            figures: figures(&points),
            points,
        }
    }

    /// Reads a file that `potamoi synth --grid` wrote.
    ///
    /// # Errors
    /// It cannot be read, has another version, or has other points than the grid.
    pub fn read(path: &Path) -> Result<Self, SynthError> {
        let text =
            potamoi_base::files::read_text(path, LIMIT).map_err(|e| wrong(path, e.to_string()))?;
        Self::parse(&text, path)
    }

    /// Parses the text of a file; `path` names it in errors.
    ///
    /// # Errors
    /// As [`Grid::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, SynthError> {
        let document = document::json(text.as_bytes())
            .map_err(|e| wrong(path, format!("no grid of `potamoi synth`: {e}")))?;
        let version = document.get("format_version").and_then(Value::whole);
        if version != Some(FORMAT_VERSION.into()) {
            let found = version.map_or("missing".to_owned(), |v| v.to_string());
            let why = format!("format_version {found}, expected {FORMAT_VERSION}");
            return Err(wrong(path, why));
        }
        let grid: Self = document.read().map_err(|e| wrong(path, e.to_string()))?;
        if grid.figures != figures(&grid.points) {
            let why = "figures or points are not those that it was written with".to_owned();
            return Err(wrong(path, why));
        }
        for point in &grid.points {
            point
                .check()
                .map_err(|why| wrong(path, format!("{}: {why}", point.name())))?;
        }
        Ok(grid)
    }

    /// The points of a family.
    pub fn of(&self, family: Family) -> impl Iterator<Item = &GridPoint> {
        self.points.iter().filter(move |p| p.family == family)
    }
}

/// Digest of points in written form, 16 hexadecimal digits.
fn figures(points: &[GridPoint]) -> String {
    let text = serde_json::to_string(points).unwrap_or_default();
    blake3::hash(text.as_bytes()).to_hex()[..16].to_owned()
}

fn wrong(path: &Path, why: String) -> SynthError {
    SynthError::Parameters {
        path: path.to_owned(),
        why,
        remedy: "potamoi synth --grid FILE",
    }
}

impl GridPoint {
    /// A point of the design with its synthesis results.
    ///
    /// # Errors
    /// A required power is missing.
    pub fn new(point: &Point, unit: &UnitReport, ends: Vec<PathEnd>) -> Result<Self, SynthError> {
        let wrong = |why: String| SynthError::Grid {
            point: point.name(),
            why,
        };
        let power = match &unit.power {
            Some(Power::Estimated(power)) => power,
            Some(Power::Absent { absent }) => return Err(wrong(format!("no power: {absent}"))),
            None => return Err(wrong("its power was not asked for".to_owned())),
        };
        let modules = unit.modules.iter().map(|own| {
            let found = power.modules.iter().find(|m| m.module == own.module);
            let found = found.ok_or_else(|| wrong(format!("no power of {}", own.module)))?;
            Ok::<_, SynthError>(GridModule {
                module: own.module.clone(),
                count: own.count,
                area_um2: own.area_um2,
                flops: own.flops,
                energy: GridEnergy {
                    zero_delay_pj: found.zero_delay_pj_a_cycle,
                    with_glitches_pj: found.with_glitches_pj_a_cycle,
                    leakage_nw: found.leakage_nw,
                },
            })
        });
        Ok(Self {
            family: point.family,
            config: point.text.clone(),
            netlists: unit.netlists.clone(),
            period_ps: unit.period_ps,
            ends,
            activity: GridActivity {
                scene: power.activity.scene.clone(),
                cycles: power.activity.cycles,
                busy: power.activity.busy,
                channels: power.activity.channels,
                clock_pj: power.zero_delay.clock_pj_a_cycle,
            },
            modules: modules.collect::<Result<_, _>>()?,
        })
    }
}

impl GridPoint {
    /// Its configuration.
    ///
    /// # Errors
    /// The text is not a valid configuration.
    pub fn config(&self) -> Result<Config, SynthError> {
        Config::from_toml(&self.config, "the grid").map_err(|e| SynthError::Grid {
            point: self.name(),
            why: e.to_string(),
        })
    }

    /// Digests of the netlists that are generated for it now; those of its synthesis are
    /// [`GridPoint::netlists`].
    ///
    /// # Errors
    /// Its configuration is invalid.
    pub fn current_netlists(&self) -> Result<NetlistDigests, SynthError> {
        NetlistDigests::of(&self.config()?, self.family.unit())
    }

    /// Name on one line.
    #[must_use]
    pub fn name(&self) -> String {
        self.config.trim_end().replace('\n', "; ")
    }

    /// Area of all modules, in square micrometres.
    #[must_use]
    pub fn area_um2(&self) -> f64 {
        self.modules
            .iter()
            .map(|m| m.count as f64 * m.area_um2)
            .sum()
    }

    /// Flip-flops of all modules.
    #[must_use]
    pub fn flops(&self) -> u64 {
        self.modules.iter().map(|m| m.count * m.flops).sum()
    }

    /// Energy of all modules in picojoules a cycle, with zero delays and with glitches.
    #[must_use]
    pub fn energy(&self) -> [f64; 2] {
        let sum = |of: fn(&GridEnergy) -> f64| self.modules.iter().map(|m| of(&m.energy)).sum();
        [sum(|e| e.zero_delay_pj), sum(|e| e.with_glitches_pj)]
    }

    /// Checks that figures are positive, those of modules not negative (a module of memories alone
    /// has no cells), and that the period is that of the longest path.
    fn check(&self) -> Result<(), String> {
        let ends = self.ends.iter().map(|e| ("period_ps", e.period_ps));
        let own = [
            ("period_ps", self.period_ps),
            ("area_um2", self.area_um2()),
            ("flops", self.flops() as f64),
            ("clock_pj", self.activity.clock_pj),
        ];
        self.netlists.check(self.family.unit().top())?;
        let slack = SLICED * self.energy()[1];
        let modules = self.modules.iter().flat_map(|m| {
            let energy = &m.energy;
            [
                ("area_um2", m.area_um2),
                ("zero_delay_pj", energy.zero_delay_pj),
                ("with_glitches_pj + slack", energy.with_glitches_pj + slack),
                ("leakage_nw", energy.leakage_nw),
            ]
        });
        let all = ends
            .chain(own)
            .map(|(field, value)| (field, value, value > 0.0));
        let modules = modules.map(|(field, value)| (field, value, value >= 0.0));
        for (field, value, is_right) in all.chain(modules) {
            if !(value.is_finite() && is_right) {
                return Err(format!("{field} = {value}, expected a number above 0"));
            }
        }
        let longest = self.ends.iter().map(|e| e.period_ps).fold(0.0, f64::max);
        if (longest / self.period_ps - 1.0).abs() > NEAR {
            let period = self.period_ps;
            return Err(format!(
                "period_ps = {period}, its longest path has {longest}"
            ));
        }
        match (self.activity.busy, self.activity.cycles) {
            (busy, of) if (1..=of).contains(&busy) => Ok(()),
            (busy, of) => Err(format!("busy = {busy} of {of} cycles, expected 1 to {of}")),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{SynthReport, UnitKind};

    /// The synthesised gathering unit of the paper as a point.
    fn paper(change: fn(&mut UnitReport)) -> Result<GridPoint, SynthError> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../synth/paper-asap7.json");
        let mut unit = SynthReport::read(&path).unwrap().raw.units.remove(0);
        change(&mut unit);
        let point = Point {
            family: Family::Gathering,
            text: "gu.banks = 32\n".to_owned(),
        };
        GridPoint::new(&point, &unit, vec![])
    }

    #[test]
    fn a_point_has_what_synthesis_found_of_each_module() {
        let found = paper(|_| {}).unwrap();
        let activity = &found.activity;
        assert_eq!((&*activity.scene, activity.channels), ("lantern", 13));
        assert!(activity.busy <= activity.cycles);
        let reducers = found
            .modules
            .iter()
            .find(|m| m.module == "reducer")
            .unwrap();
        assert_eq!(reducers.count, 64);
        let energy = reducers.energy;
        assert!(energy.with_glitches_pj > energy.zero_delay_pj && energy.leakage_nw > 0.0);
        let of = |config: &Config| NetlistDigests::of(config, UnitKind::Gathering).unwrap();
        assert_eq!(found.netlists, of(&Config::paper()));
        let other = Config::from_toml("gu.banks = 16\n", "test").unwrap();
        assert_eq!(
            found.netlists.changed(&of(&other)),
            ["feature_fifo", "gathering_unit", "mft"]
        );
    }

    const GRID: &str = include_str!("../../../../synth/grid-asap7.json");

    /// The file with one change, with or without a new digest.
    fn changed(change: fn(&mut Grid), is_signed: bool) -> String {
        let path = Path::new("grid.json");
        let mut grid = Grid::parse(GRID, path).unwrap();
        change(&mut grid);
        if is_signed {
            grid.figures = figures(&grid.points);
        }
        let text = serde_json::to_string(&grid).unwrap();
        Grid::parse(&text, path).unwrap_err().to_string()
    }

    #[test]
    fn a_file_that_was_changed_is_refused() {
        let error = changed(|g| g.points[3].modules[2].area_um2 *= 1.2, false);
        assert!(
            error.contains("grid.json: figures or points are not those"),
            "{error}"
        );
        for (change, said) in [
            (
                (|g| g.points[0].modules[0].energy.zero_delay_pj = -1.0) as fn(&mut Grid),
                "zero_delay_pj = -1, expected a number above 0",
            ),
            (
                |g| g.points[0].activity.clock_pj = 0.0,
                "clock_pj = 0, expected",
            ),
            (
                |g| g.points[0].activity.busy = 0,
                "busy = 0 of 2563 cycles, expected 1 to 2563",
            ),
            (
                |g| g.points[0].period_ps = 900.0,
                "period_ps = 900, its longest path has 1078.7",
            ),
            (|g| g.points[0].ends.clear(), "its longest path has 0"),
        ] {
            let error = changed(change, true);
            let of = "grid.json: gu.banks = 32; gu.ports = 1; ";
            assert!(error.contains(of) && error.contains(said), "{error}");
        }
    }

    #[test]
    fn power_that_is_missing_is_named() {
        let error = |change| paper(change).unwrap_err().to_string();
        let none = error(|unit| unit.power = None);
        assert!(
            none.contains("(gu.banks = 32)") && none.contains("not asked for"),
            "{none}"
        );
        let absent = error(|unit| {
            let absent = "no delays".to_owned();
            unit.power = Some(Power::Absent { absent });
        });
        assert!(absent.contains("no power: no delays"), "{absent}");
    }
}
