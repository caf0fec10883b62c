//! The longest path into each module of a unit.

use std::collections::BTreeMap;
use std::path::Path;

use potamoi_formats::config::Config;
use serde::{Deserialize, Serialize};

use super::script::{LIBRARY, NETLIST, PERIOD, sta_of_ends};
use super::tools::TIMING;
use super::{Library, Made, SynthError, Tools, UnitKind};

/// Version of what is kept.
const KEPT: &str = "potamoi-ends 1";
/// The end of paths to the outputs of a unit.
pub(super) const OUTPUTS: &str = "outputs";

/// The longest of the paths that end in the same module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathEnd {
    /// The module whose flip-flops they end in, or `outputs`.
    pub end: String,
    /// Picoseconds, with clock-to-output and setup.
    pub period_ps: f64,
}

/// Times the netlist of a unit once more, by the modules that its paths end in; or
/// finds what an earlier run left in `cache`.
///
/// # Errors
/// OpenSTA fails or prints what is not understood; files cannot be written.
pub fn path_ends(
    config: &Config,
    unit: UnitKind,
    made: &Made,
    library: &Library,
    tools: &Tools,
    cache: &Path,
) -> Result<Vec<PathEnd>, SynthError> {
    let cannot = |path: &Path| {
        let path = path.to_owned();
        move |source| SynthError::File { path, source }
    };
    let script = sta_of_ends(unit.top(), library);
    let netlist = std::fs::read_to_string(&made.netlist).map_err(cannot(&made.netlist))?;
    let mut key = blake3::Hasher::new();
    for part in [KEPT, &script, &tools.opensta, &library.sha256, &netlist] {
        key.update(&(part.len() as u64).to_le_bytes());
        key.update(part.as_bytes());
    }
    let key = &key.finalize().to_hex()[..32];
    let kept = cache.join(format!("{unit}-ends-{key}.json"));
    if let Some(ends) = read_kept(&kept) {
        return Ok(ends);
    }
    let folder = tempfile::tempdir().map_err(cannot(&std::env::temp_dir()))?;
    for (name, text) in [
        (LIBRARY, &library.text),
        (NETLIST, &netlist),
        (TIMING, &script),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).map_err(cannot(&path))?;
    }
    let module = unit.module(config)?;
    let modules: BTreeMap<&str, &str> = module.instances().collect();
    let said = tools.sta(folder.path(), unit.top())?;
    let ends = longest(&said, unit.top(), &modules);
    let ends: Option<Vec<_>> = ends.map(|ends| {
        let period = |slack| (PERIOD - slack) * library.time_ps;
        let ends = ends.into_iter().map(|(end, slack)| PathEnd {
            end,
            period_ps: period(slack),
        });
        ends.collect()
    });
    let ends = ends
        .filter(|ends| !ends.is_empty())
        .ok_or_else(|| SynthError::Output {
            tool: "sta",
            unit: unit.top(),
            what: "slack of each end".to_owned(),
        })?;
    let json = serde_json::to_vec_pretty(&ends).map_err(|e| cannot(&kept)(e.into()))?;
    potamoi_golden::files::write(&kept, &json).map_err(cannot(&kept))?;
    Ok(read_kept(&kept).unwrap_or(ends))
}

fn read_kept(path: &Path) -> Option<Vec<PathEnd>> {
    serde_json::from_slice(&std::fs::read(path).ok()?).ok()
}

/// The smallest slack by module, of lines `cell/pin (kind) required actual slack (MET)`; of
/// instances that are not in `modules`, nothing.
fn longest(said: &str, top: &str, modules: &BTreeMap<&str, &str>) -> Option<BTreeMap<String, f64>> {
    let mut found = BTreeMap::new();
    let is_end = |line: &&str| line.ends_with("(MET)") || line.ends_with("(VIOLATED)");
    for line in said.lines().filter(is_end) {
        let words: Vec<_> = line.split_whitespace().collect();
        let [name, kind, .., slack, _] = words[..] else {
            return None;
        };
        let end = match name.rsplit_once('/') {
            None if kind == "(output)" => OUTPUTS,
            Some((cell, _pin)) => match cell.split_once('/') {
                Some((instance, _)) => modules.get(instance)?,
                None => top,
            },
            None => return None,
        };
        let slack: f64 = slack.parse().ok().filter(|s: &f64| s.is_finite())?;
        let least = found.entry(end.to_owned()).or_insert(slack);
        *least = least.min(slack);
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const SAID: &str = "max_delay/setup group clk\n\n\
        Endpoint                                Delay    Delay    Slack\n\
        ------------------------------------------------------\n\
        r0/_7_/D (DFF)               980.000   900.000   80.000 (MET)\n\
        r1/_7_/D (DFF)               980.000  1000.000  -20.000 (VIOLATED)\n\
        sum[3]_reg/D (DFF)           980.000   500.000  480.000 (MET)\n\
        ready (output)              1000.000   600.000  400.000 (MET)\n";

    #[test]
    fn the_smallest_slack_of_every_module_counts() {
        let modules = BTreeMap::from([("r0", "reducer"), ("r1", "reducer")]);
        let found = longest(SAID, "unit", &modules).unwrap();
        let expected = [("outputs", 400.0), ("reducer", -20.0), ("unit", 480.0)];
        let expected = expected.map(|(end, slack)| (end.to_owned(), slack));
        assert_eq!(found, BTreeMap::from(expected));
        assert!(longest(SAID, "unit", &BTreeMap::new()).is_none());
        let cut = SAID.replace("400.000 (MET)", "(MET)");
        assert!(longest(&cut.replace("600.000", "x"), "unit", &modules).is_none());
    }
}
