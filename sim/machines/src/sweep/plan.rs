//! The plan of a sweep, as a file.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use potamoi_formats::document::{self, Value, Wrong};
use potamoi_formats::file_kinds;
use potamoi_scene::files_read::paths_of;
use potamoi_scene::{BUILTIN, Scene, SceneError, scenes_named};
use serde::Deserialize;

use super::SweepError;
use crate::machine::Machine;
use crate::space::{Axis, Space};
use crate::workload::Workload;

/// Size limit of a plan, in bytes.
const LIMIT: u64 = 1 << 20;
/// Sections with the fields that vary.
const VARY: &str = "vary";
const TOGETHER: &str = "together";
/// Keys of a plan.
const KEYS: [&str; 7] = [
    "machines", "scenes", "width", "height", "workload", VARY, TOGETHER,
];

/// A plan: machines, fields that vary, scenes, and what is measured.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Name of its file.
    pub name: String,
    /// A space for each machine.
    pub spaces: Vec<Space>,
    /// Scenes, with their names as given.
    pub scenes: Vec<Scene>,
    /// What machines do on each scene.
    pub workload: Workload,
    /// Machines and scenes that are files or folders.
    inputs: Vec<PathBuf>,
}

/// Keys of a plan without those of the fields that vary.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Written {
    machines: Vec<String>,
    scenes: Vec<String>,
    width: Option<u32>,
    height: Option<u32>,
    workload: Workload,
}

impl Plan {
    /// Reads a plan. Machines and scenes that are files lie beside it.
    ///
    /// # Errors
    /// The file cannot be read, is not TOML, or names what is no machine, scene, field or value.
    pub fn read(path: &Path) -> Result<Self, SweepError> {
        let fail = |source| SweepError::Read {
            path: path.to_owned(),
            source,
        };
        let bytes = potamoi_base::files::read(path, LIMIT).map_err(fail)?;
        let long = || fail(file_kinds::too_long(path, LIMIT));
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::of(
            &bytes.ok_or_else(long)?,
            &path.display().to_string(),
            folder,
        )
    }

    /// The plan of a text.
    ///
    /// # Errors
    /// As [`Plan::read`].
    pub fn of(bytes: &[u8], name: &str, folder: &Path) -> Result<Self, SweepError> {
        let wrong = |wrong: Wrong| SweepError::Plan {
            name: name.to_owned(),
            problem: wrong.to_string(),
        };
        let within = |part: &'static str| {
            move |source: SweepError| SweepError::Within {
                name: name.to_owned(),
                part,
                source: Box::new(source),
            }
        };
        let given = document::toml(bytes).map_err(wrong)?;
        known_keys(&given).map_err(wrong)?;
        let mut axes = vec![];
        if let Some(own) = given.get(VARY) {
            axes.extend(varied(own).map_err(|of| wrong(of.under(VARY)))?);
        }
        if let Some(own) = given.get(TOGETHER) {
            axes.extend(together(own).map_err(|of| wrong(of.under(TOGETHER)))?);
        }
        let rest = given.without(VARY).without(TOGETHER);
        let written: Written = rest.read().map_err(wrong)?;
        if written.workload.frames == 0 {
            let of = Wrong::found("0", "1 frame or more").under("frames");
            return Err(wrong(of.under("workload")));
        }
        let fps = written.workload.fps;
        if !(fps.is_finite() && fps > 0.0) {
            let of = Wrong::found(fps, "frames a second above 0").under("fps");
            return Err(wrong(of.under("workload")));
        }
        let beside = |own: &String| -> String {
            let path = folder.join(own);
            match path.is_file() {
                true => path.display().to_string(),
                false => own.clone(),
            }
        };
        let default = |own: Vec<String>, name: &str| match own.is_empty() {
            true => vec![name.to_owned()],
            false => own,
        };
        let machines = default(written.machines, "paper");
        let machine_files = machines.iter().map(&beside).map(PathBuf::from);
        let mut inputs: Vec<PathBuf> = machine_files.filter(|own| own.is_file()).collect();
        let spaces = machines.iter().map(|own| {
            // Named as in the plan, so that rows are the same wherever the plan lies.
            let base = Machine::named(&beside(own))
                .map_err(|error| within("machines")(error.into()))?
                .renamed(own);
            Space::new(base, axes.clone()).map_err(|error| within("[vary]")(error.into()))
        });
        let spaces = spaces.collect::<Result<Vec<_>, _>>()?;
        let names: Vec<String> = default(written.scenes, "garden")
            .iter()
            .map(beside)
            .collect();
        let scenes = scenes_named(&names).into_iter().map(|name| {
            let open = || {
                let mut scene = Scene::open(&name)?;
                scene.set_size(written.width, written.height)?;
                Ok(scene)
            };
            open().map_err(|error: SceneError| within("scenes")(error.into()))
        });
        let is_input = |own: &&String| {
            let path = Path::new(own);
            path.is_file() || (path.is_dir() && !BUILTIN.contains(&own.as_str()))
        };
        inputs.extend(names.iter().filter(is_input).map(PathBuf::from));
        let scenes: Vec<Scene> = scenes.collect::<Result<_, _>>()?;
        for space in &spaces {
            let own = space.check_on(&scenes);
            own.map_err(|error| within("[vary]")(error.into()))?;
        }
        Ok(Self {
            inputs,
            name: name.to_owned(),
            spaces,
            scenes,
            workload: written.workload,
        })
    }

    /// Number of points: machines on scenes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.scenes.len() * self.spaces.iter().map(Space::len).sum::<usize>()
    }

    /// Whether it has no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Fields that vary, in order.
    #[must_use]
    pub fn fields(&self) -> Vec<&str> {
        let first = self.spaces.first();
        let axes = first.into_iter().flat_map(|own| &own.axes);
        axes.flat_map(|axis| axis.fields.iter().map(String::as_str))
            .collect()
    }

    /// Scene, space and number in the space of a point: scenes outermost, then machines.
    #[must_use]
    pub fn point(&self, mut number: usize) -> Option<(usize, usize, usize)> {
        for scene in 0..self.scenes.len() {
            for (at, space) in self.spaces.iter().enumerate() {
                match number.checked_sub(space.len()) {
                    None => return Some((scene, at, number)),
                    Some(rest) => number = rest,
                }
            }
        }
        None
    }

    /// Files that the plan reads, as far as known: itself, machines and devices, scenes with their models
    /// and cameras.
    #[must_use]
    pub fn files(&self) -> BTreeSet<PathBuf> {
        let mut found = BTreeSet::from([PathBuf::from(&self.name)]);
        found.extend(self.inputs.iter().flat_map(|own| paths_of(own)));
        for space in &self.spaces {
            let values = space.axes.iter().flat_map(|axis| axis.values.iter());
            let texts = values.flatten().filter_map(Value::text);
            // Devices lie beside the machine.
            let beside = texts.map(|own| space.base.folder().join(own));
            found.extend(beside.filter(|own| own.is_file()));
        }
        found
    }
}

/// Refuses a key that no plan has.
fn known_keys(given: &Value) -> Result<(), Wrong> {
    let Value::Map(entries) = given else {
        return Ok(());
    };
    let unknown = entries.iter().find(|(key, _)| !KEYS.contains(&&**key));
    let Some((key, _)) = unknown else {
        return Ok(());
    };
    // A field of a machine that stands beside [vary], not in it.
    let is_section = [
        "gu", "vu", "su", "rit", "mvoxel", "system", "render", "path",
    ];
    let first = key.split('.').next().unwrap_or_default();
    Err(match is_section.contains(&first) {
        true => Wrong::new(format!(
            "a plan has no field of a machine outside [vary]: write its values there, or the field into \
             the machine's file; the keys of a plan are {}",
            KEYS.join(", ")
        ))
        .under(key),
        false => Wrong::unknown_key(key, &KEYS),
    })
}

/// Fields that vary one by one.
fn varied(section: &Value) -> Result<Vec<Axis>, Wrong> {
    let mut axes = vec![];
    collect(section, "", &mut axes)?;
    Ok(axes)
}

/// Fields of a section by path: `"vu.lanes" = [...]`, or `lanes = [...]` in `[vary.vu]`.
fn collect(section: &Value, path: &str, axes: &mut Vec<Axis>) -> Result<(), Wrong> {
    let Value::Map(entries) = section else {
        let expected = "fields, each with its values";
        return Err(Wrong::found(section.shown(), expected));
    };
    for (key, value) in entries {
        let field = match path {
            "" => key.to_string(),
            path => format!("{path}.{key}"),
        };
        match value {
            Value::Map(_) if value.get("from").is_none() => collect(value, &field, axes)?,
            _ if field == "clock" => axes.push(Axis::of_document("clock_ghz", value)?),
            _ => axes.push(Axis::of_document(&field, value)?),
        }
    }
    Ok(())
}

/// Fields that vary together: sections of fields with as many values each.
fn together(sections: &Value) -> Result<Vec<Axis>, Wrong> {
    let expected = "[[together]] sections";
    let all = sections.list();
    let all = all.ok_or_else(|| Wrong::found(sections.shown(), expected))?;
    let axes = all.iter().enumerate().map(|(at, section)| {
        let own = varied(section).map_err(|wrong| wrong.at(at))?;
        let counts: Vec<usize> = own.iter().map(|axis| axis.values.len()).collect();
        let Some(count) = counts.first().copied() else {
            return Err(Wrong::found("no fields", "fields, each with its values").at(at));
        };
        if counts.iter().any(|other| *other != count) {
            let found = format!("lists of {counts:?} values");
            return Err(Wrong::found(found, "lists that are equally long").at(at));
        }
        let values = (0..count).map(|i| own.iter().map(|axis| axis.values[i][0].clone()).collect());
        Ok(Axis {
            values: values.collect(),
            fields: own.into_iter().flat_map(|axis| axis.fields).collect(),
        })
    });
    axes.collect()
}
