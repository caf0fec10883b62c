//! The bench as CSV: a line a figure, a check and a constant.

use potamoi_rivals::Verdict;

use super::FairBench;
use crate::comparison::Row;

/// Columns.
const COLUMNS: [&str; 9] = [
    "record",
    "scene",
    "machine",
    "name",
    "value",
    "value_high",
    "unit",
    "origin",
    "source",
];

type Line = [String; 9];

fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |own| own.to_string())
}

fn line(of: [&str; 4], values: [Option<f64>; 2], rest: [&str; 3]) -> Line {
    let [record, scene, machine, name] = of.map(str::to_owned);
    let [value, high] = values.map(number);
    let [unit, origin, source] = rest.map(str::to_owned);
    [
        record, scene, machine, name, value, high, unit, origin, source,
    ]
}

impl FairBench {
    /// All figures, checks and constants as CSV. What is not known is empty.
    ///
    /// # Errors
    /// None: it is written to memory.
    pub fn csv(&self) -> Result<String, csv::Error> {
        let mut csv = csv::Writer::from_writer(vec![]);
        csv.write_record(COLUMNS)?;
        for own in self.figures().chain(self.checks()).chain(self.constants()) {
            csv.write_record(own)?;
        }
        let bytes = csv.into_inner().map_err(|error| error.into_error())?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    fn figures(&self) -> impl Iterator<Item = Line> {
        let mut all = vec![];
        for input in &self.inputs {
            let scene = input.scene.as_str();
            for (name, value) in &input.trace.counts {
                let of = ["count", scene, "", name.as_str()];
                all.push(line(
                    of,
                    [Some(*value), None],
                    ["", "counted", &input.digest],
                ));
            }
            for row in &input.machines {
                let Row::Figures(own) = row else { continue };
                let machine = own.machine.as_str();
                let rate = &own.frames_per_second;
                let of = |name| ["figure", scene, machine, name];
                let rates = [Some(rate.low()), Some(rate.high())];
                all.push(line(
                    of("frames_per_second"),
                    rates,
                    ["frames/s", "cycle model", ""],
                ));
                let mj = own.accelerator_mj;
                let mj = [mj.map(|own| own.low()), mj.map(|own| own.high())];
                all.push(line(of("accelerator"), mj, ["mJ", "synthesis", ""]));
                all.push(line(
                    of("area"),
                    [own.mm2, None],
                    ["mm^2", "synthesis, 12 nm", ""],
                ));
            }
            for own in &input.gpus {
                let machine = format!("{}, {}", own.device, own.program);
                let of = |name| ["figure", scene, machine.as_str(), name];
                let both = |of: &potamoi_system::system_model::AtBounds<f64>| {
                    [Some(of.low()), Some(of.high())]
                };
                let rates = both(&own.frames_per_second);
                all.push(line(
                    of("frames_per_second"),
                    rates,
                    ["frames/s", "kernel model", ""],
                ));
                all.push(line(of("device"), both(&own.mj), ["mJ", "power limit", ""]));
            }
            for own in &input.rivals {
                let rates = own.estimate.as_ref().map(|of| of.frame.rates());
                let values = [rates.map(|own| own[0]), rates.map(|own| own[1])];
                let refused = own.refused.as_deref().unwrap_or_default();
                let of = |name| ["figure", scene, own.rival.as_str(), name];
                let rest = ["frames/s", "published structure", refused];
                all.push(line(of("frames_per_second"), values, rest));
                let mj = own.estimate.as_ref().and_then(|of| of.mj);
                let mj = [mj.map(|own| own[0]), mj.map(|own| own[1])];
                all.push(line(of("accelerator"), mj, ["mJ", "published power", ""]));
            }
        }
        all.into_iter()
    }

    fn checks(&self) -> impl Iterator<Item = Line> {
        self.rivals.iter().flat_map(|own| {
            let rival = own.rival.name.as_str();
            let (word, why) = match &own.verdict {
                Verdict::Validated(check) => ("validated", check.what.clone()),
                Verdict::Not(why) => ("not validated", why.clone()),
            };
            let verdict = line(["verdict", "", rival, word], [None, None], ["", "", &why]);
            let checks = own.checks.iter().map(move |check| {
                let [low, high] = check.ratio;
                let of = ["check", "", rival, check.what.as_str()];
                line(
                    of,
                    [Some(low), Some(high)],
                    ["computed over published", "", &check.source],
                )
            });
            std::iter::once(verdict).chain(checks)
        })
    }

    fn constants(&self) -> impl Iterator<Item = Line> {
        self.rivals.iter().flat_map(|own| {
            let each = own.rival.constants().into_iter();
            each.map(move |(name, constant)| {
                let of = ["constant", "", own.rival.name.as_str(), name.as_str()];
                let origin = &constant.origin;
                let rest = [constant.unit.as_str(), origin.word(), origin.text()];
                line(of, [constant.value, None], rest)
            })
        })
    }
}
