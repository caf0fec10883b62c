//! One figure beside another.

use schemars::JsonSchema;
use serde::Serialize;

/// A figure, or why there is none.
pub(crate) type Figure = Result<f64, String>;

/// Part of the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Section {
    /// Frames of Gaussians in floating point, beside the peak of the machine's arithmetic.
    Splats,
    /// Frames of radiance fields in floating point, beside JAX.
    Fields,
    /// Verilated units driven from Rust, beside a C++ testbench of the same stimulus.
    Units,
    /// A whole verification, beside the C++ testbench for the clocks that it simulates.
    Verify,
}

impl Section {
    /// All of them, in the order in which they are measured.
    pub const ALL: [Self; 4] = [Self::Splats, Self::Fields, Self::Units, Self::Verify];
}

/// What stands beside a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// What the machine could do at best.
    Limit,
    /// Another program that does the same work, or a stated part of it.
    Peer,
}

/// A figure to compare with, in the same unit.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Beside {
    /// What it is of.
    pub name: String,
    /// Whether it is a limit or a peer.
    pub kind: Kind,
    /// The figure, measured in the same run; null where there is none.
    pub value: Option<f64>,
    /// Why there is none, and what to install where that would help.
    pub why: Option<String>,
}

impl Beside {
    pub(crate) fn new(kind: Kind, name: impl Into<String>, figure: &Figure) -> Self {
        Self {
            name: name.into(),
            kind,
            value: figure.as_ref().ok().copied(),
            why: figure.as_ref().err().cloned(),
        }
    }
}

/// How much of something was done.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Count {
    /// Of what.
    pub of: &'static str,
    /// How many.
    pub count: u64,
}

/// A measured figure beside a limit or a peer of the same run.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Row {
    /// Its part of the comparison.
    pub section: Section,
    /// What was measured.
    pub what: String,
    /// The figure; null where a tool is missing.
    pub measured: Option<f64>,
    /// Unit of both figures.
    pub unit: &'static str,
    /// Why nothing was measured, and what to install.
    pub why: Option<String>,
    /// The limit or the peer.
    pub beside: Beside,
    /// The measured figure over the one beside: 1 is as fast, 2 takes twice as long. Null where either
    /// is missing.
    pub ratio: Option<f64>,
    /// What was counted of the work.
    pub counts: Vec<Count>,
    /// How both figures come about.
    pub origin: String,
}

impl Row {
    /// A row in milliseconds of processor time.
    pub(crate) fn new(
        section: Section,
        what: impl Into<String>,
        figure: &Figure,
        beside: Beside,
        origin: impl Into<String>,
    ) -> Self {
        let measured = figure.as_ref().ok().copied();
        Self {
            section,
            what: what.into(),
            measured,
            unit: "ms",
            why: figure.as_ref().err().cloned(),
            ratio: ratio(measured, beside.value),
            beside,
            counts: vec![],
            origin: origin.into(),
        }
    }

    /// The same in another unit.
    pub(crate) fn in_unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// The same with what was counted.
    pub(crate) fn with_counts<const N: usize>(self, counts: [(&'static str, u64); N]) -> Self {
        let counts = counts.map(|(of, count)| Count { of, count });
        Self {
            counts: counts.to_vec(),
            ..self
        }
    }
}

fn ratio(measured: Option<f64>, beside: Option<f64>) -> Option<f64> {
    let ratio = measured? / beside?;
    ratio.is_finite().then_some(ratio)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn row(figure: &Figure, beside: &Figure) -> Row {
        let beside = Beside::new(Kind::Peer, "another", beside);
        Row::new(Section::Fields, "this", figure, beside, "both by hand")
    }

    #[test]
    fn a_ratio_is_the_measured_figure_over_the_one_beside() {
        let own = row(&Ok(30.0), &Ok(20.0));
        assert_eq!((own.ratio, own.unit), (Some(1.5), "ms"));
        assert_eq!((own.why, own.beside.why), (None, None));
        assert_eq!(row(&Ok(0.0), &Ok(20.0)).ratio, Some(0.0));
        assert_eq!(row(&Ok(30.0), &Ok(0.0)).ratio, None);
    }

    #[test]
    fn a_figure_that_is_missing_has_its_reason_and_no_ratio() {
        let missing: Figure = Err("no JAX: pip install jax".to_owned());
        let own = row(&Ok(30.0), &missing);
        assert_eq!((own.measured, own.beside.value), (Some(30.0), None));
        assert_eq!((own.ratio, own.why), (None, None));
        assert_eq!(own.beside.why.as_deref(), Some("no JAX: pip install jax"));
        let own = row(&missing, &Ok(20.0));
        assert_eq!((own.measured, own.ratio), (None, None));
        assert_eq!(own.why.as_deref(), Some("no JAX: pip install jax"));
        assert_eq!(own.beside.value, Some(20.0));
    }

    #[test]
    fn counts_and_units_are_kept() {
        let own = row(&Ok(1.0), &Ok(1.0)).in_unit("ns a clock");
        let own = own.with_counts([("clocks", 7)]);
        assert_eq!(own.unit, "ns a clock");
        assert_eq!((own.counts[0].of, own.counts[0].count), ("clocks", 7));
    }
}
