//! Longest path into each module of a unit.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::retime::{Retiming, Wanted};
use super::script::{PERIOD, sta_of_ends};
use super::{Library, SynthError, SynthesisedUnit, Tools, UnitKind};

/// Version of the cached format.
const KEPT: &str = "potamoi-ends 1";
/// End of paths to the outputs of a unit.
pub(super) const OUTPUTS: &str = "outputs";

/// Longest of the paths that end in one module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathEnd {
    /// The module whose flip-flops end the path, or `outputs`.
    pub end: String,
    /// Picoseconds, clock-to-output delay and setup included.
    pub period_ps: f64,
}

/// Times the netlist of a unit by the module of each path's end; results are cached in `cache`.
///
/// # Errors
/// OpenSTA fails or prints output that is not understood; files cannot be written.
pub fn path_ends(
    unit: UnitKind,
    made: &SynthesisedUnit,
    library: &Library,
    tools: &Tools,
    cache: &Path,
) -> Result<Vec<PathEnd>, SynthError> {
    let modules = made.instances.iter().map(|(name, of)| (&**name, &**of));
    let modules: BTreeMap<&str, &str> = modules.collect();
    let wanted = Wanted {
        version: KEPT,
        name: "ends",
        what: "slack of each end",
        script: &sta_of_ends(unit.top(), library),
        others: &[],
    };
    let retiming = Retiming {
        unit,
        made,
        library,
        tools,
        cache,
    };
    retiming.run(&wanted, |said| {
        let ends = longest(said, unit.top(), &modules)?;
        let ends = ends.into_iter().map(|(end, slack)| PathEnd {
            end,
            period_ps: (PERIOD - slack) * library.time_ps,
        });
        let ends: Vec<PathEnd> = ends.collect();
        (!ends.is_empty()).then_some(ends)
    })
}

/// Smallest slack by module, from lines `cell/pin (kind) required actual slack (MET)`. Instances
/// that are not in `modules` are skipped.
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
                Some((instance, _)) => module_of(instance, modules)?,
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

/// Module of an instance; one of an array is known by its scope.
fn module_of<'a>(instance: &str, modules: &BTreeMap<&str, &'a str>) -> Option<&'a str> {
    let scope = || instance.rsplit_once('.').map(|(scope, _)| scope);
    let found = modules.get(instance);
    found.or_else(|| modules.get(scope()?)).copied()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const SAID: &str = "max_delay/setup group clk\n\n\
        Endpoint                                Delay    Delay    Slack\n\
        ------------------------------------------------------\n\
        r_of_p[1].r[0].sum/_7_/D (DFF)               980.000   900.000   80.000 (MET)\n\
        r1/_7_/D (DFF)               980.000  1000.000  -20.000 (VIOLATED)\n\
        sum[3]_reg/D (DFF)           980.000   500.000  480.000 (MET)\n\
        ready (output)              1000.000   600.000  400.000 (MET)\n";

    #[test]
    fn the_smallest_slack_of_every_module_counts() {
        let modules = BTreeMap::from([("r_of_p[1].r[0]", "reducer"), ("r1", "reducer")]);
        let found = longest(SAID, "unit", &modules).unwrap();
        let expected = [("outputs", 400.0), ("reducer", -20.0), ("unit", 480.0)];
        let expected = expected.map(|(end, slack)| (end.to_owned(), slack));
        assert_eq!(found, BTreeMap::from(expected));
        assert!(longest(SAID, "unit", &BTreeMap::new()).is_none());
        let cut = SAID.replace("400.000 (MET)", "(MET)");
        assert!(longest(&cut.replace("600.000", "x"), "unit", &modules).is_none());
    }
}
