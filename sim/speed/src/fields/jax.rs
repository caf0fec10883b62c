//! JAX, where it is installed.

use std::process::Command;
use std::time::Duration;

use potamoi_fields::{Field, Mlp, Table};
use potamoi_verilated::child::{self, Fault};
use serde::{Deserialize, Serialize};

use crate::row::Figure;

const SCRIPT: &str = include_str!("jax.py");
/// Time limit: many times that of the built-in scenes, most of which goes into compilation.
const LIMIT: Duration = Duration::from_secs(600);
const INSTALL: &str = "to install: pip install jax, for the python3 that PATH leads to";

/// Sizes of a model, and how many samples are computed.
#[derive(Debug, Serialize)]
pub(super) struct Model<'a> {
    name: &'a str,
    kind: &'static str,
    gathered: u64,
    coloured: u64,
    /// Values of an encoded direction.
    encoded: usize,
    tables: Vec<Shape>,
    perceptrons: Vec<Vec<Layer>>,
}

#[derive(Debug, Serialize)]
struct Shape {
    points: [usize; 3],
    rows: usize,
    channels: usize,
    hashed: bool,
}

#[derive(Debug, Serialize)]
struct Layer {
    inputs: usize,
    outputs: usize,
    bias: bool,
}

impl<'a> Model<'a> {
    /// Sizes of a field, for numbers of gathered and of coloured samples; `None` where the script does
    /// not compute such fields.
    pub(super) fn of(name: &'a str, field: &dyn Field, samples: [u64; 2]) -> Option<Self> {
        let kind = match field.algorithm().file.as_ref()?.kind {
            kind @ ("dvgo" | "ngp") => kind,
            _ => return None,
        };
        let [gathered, coloured] = samples;
        let perceptrons = field.perceptrons();
        Some(Self {
            name,
            kind,
            gathered,
            coloured,
            encoded: field.encoded(),
            tables: field.tables().iter().map(shape).collect(),
            perceptrons: perceptrons.into_iter().map(layers).collect(),
        })
    }
}

fn shape(table: &Table) -> Shape {
    Shape {
        points: table.points(),
        rows: table.rows(),
        channels: table.channels(),
        hashed: table.is_hashed(),
    }
}

fn layers(mlp: &Mlp) -> Vec<Layer> {
    let layers = mlp.layers().iter();
    let sizes = layers.map(|layer| Layer {
        inputs: layer.inputs(),
        outputs: layer.outputs(),
        bias: layer.bias().iter().any(|own| *own != 0.0),
    });
    sizes.collect()
}

#[derive(Debug, Serialize)]
struct Asked<'a> {
    runs: u32,
    models: Vec<Model<'a>>,
}

/// What the script prints.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Said {
    Missing { missing: String },
    Found { version: String, models: Vec<Time> },
}

#[derive(Debug, Deserialize)]
struct Time {
    name: String,
    ms: f64,
}

/// What was measured of JAX.
#[derive(Debug)]
pub(super) struct Jax {
    /// Its version, or why there is no figure.
    pub(super) version: Result<String, String>,
    times: Vec<Time>,
}

impl Jax {
    /// Runs the script.
    pub(super) fn measure<'a>(runs: u32, models: impl Iterator<Item = Model<'a>>) -> Self {
        let asked = Asked {
            runs,
            models: models.collect(),
        };
        match Self::said(&asked) {
            Ok(text) => Self::read(&text),
            Err(why) => Self::without(why),
        }
    }

    fn said(asked: &Asked<'_>) -> Result<String, String> {
        let asked = serde_json::to_string(asked).map_err(|error| error.to_string())?;
        let mut command = Command::new("python3");
        command.args(["-c", SCRIPT, &asked]);
        let done = child::run(&command, LIMIT).map_err(|fault| match fault {
            Fault::Missing { .. } => format!("{fault}; {INSTALL}"),
            fault => format!("python3: {fault}"),
        })?;
        if !done.status.success() {
            let text = String::from_utf8_lossy(&done.err);
            let last = text.lines().last().unwrap_or("it says nothing");
            return Err(format!("the script in JAX failed: {last}"));
        }
        String::from_utf8(done.out).map_err(|error| format!("the script in JAX: {error}"))
    }

    /// Reads what the script printed.
    pub(super) fn read(text: &str) -> Self {
        match serde_json::from_str(text.trim()) {
            Ok(Said::Found { version, models }) => Self {
                version: Ok(version),
                times: models,
            },
            Ok(Said::Missing { missing }) => {
                Self::without(format!("python3 says: {missing}; {INSTALL}"))
            }
            Err(error) => Self::without(format!("the script in JAX printed no result: {error}")),
        }
    }

    const fn without(why: String) -> Self {
        Self {
            version: Err(why),
            times: vec![],
        }
    }

    /// Milliseconds of a model.
    pub(super) fn figure(&self, name: &str) -> Figure {
        self.version.as_ref().map_err(Clone::clone)?;
        let time = self.times.iter().find(|time| time.name == name);
        let missing = || format!("the script in JAX printed nothing of {name}");
        time.map(|time| time.ms).ok_or_else(missing)
    }

    /// Its name beside a figure.
    pub(super) fn name(&self) -> String {
        match &self.version {
            Ok(version) => format!("JAX {version}, 64 bits"),
            Err(_) => "JAX, 64 bits".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_script_that_prints_nothing_useful_is_a_reason() {
        for text in ["", "{}", "Traceback"] {
            let why = Jax::read(text).figure("cairn:ngp").unwrap_err();
            assert!(why.contains("printed no result"), "{why}");
        }
        let found = r#"{"version": "1", "models": []}"#;
        let why = Jax::read(found).figure("cairn:ngp").unwrap_err();
        assert!(why.contains("nothing of cairn:ngp"), "{why}");
    }
}
