//! Streamed SOG: a `lod-meta.json` that names SOG folders, and a tree of boxes whose leaves name runs of
//! Gaussians in them, a run for each level of detail.
//!
//! Level 0 is the finest. A run belongs to one level; the environment, if there is one, belongs to all.
//! Source: the specification of the format, version 1, in splat-transform's guides.

use std::collections::{BTreeMap, HashSet};
use std::path::{Component, Path, PathBuf};

use super::super::error::{FileError, Origin};
use super::super::json::Object;
use super::super::reader::{Reader, limited};
use super::{LONGEST_NAME, META, raw, raw_folder};
use crate::Cloud;
use crate::file_content::{Facts, Raw};
use potamoi_base::file_keys::{Fate, FileKeys, Format, Notes, key, told};

/// The file that lists the levels.
pub const LEVELS: &str = "lod-meta.json";
/// The largest one, in bytes.
const LARGEST: u64 = 16 << 20;
/// The largest bundled chunk, in bytes.
const LARGEST_CHUNK: u64 = 1 << 32;

/// Keys of the format.
pub static FORMAT: Format = Format {
    name: "streamed SOG of PlayCanvas",
    files: "a folder with `lod-meta.json`, or that file: its fields; those of chunks are above",
    keys: &[
        key("version", Fate::Honoured, "1; missing in older files"),
        key(
            "asset.*",
            Fate::Listed,
            "who wrote it; `inspect` names the writer",
        ),
        key(
            "count",
            Fate::Honoured,
            "Gaussians of all levels, in agreement with the tree",
        ),
        key(
            "counts",
            Fate::Honoured,
            "Gaussians of each level, in agreement with the tree",
        ),
        key(
            "lodLevels",
            Fate::Honoured,
            "levels, 1 or more; level 0, the finest, unless `model.level` says another",
        ),
        key(
            "environment",
            Fate::Honoured,
            "a chunk that is drawn whatever the level; null is none",
        ),
        key(
            "filenames",
            Fate::Honoured,
            "the `meta.json` of each chunk, in folders below, each once",
        ),
        key("tree.children", Fate::Honoured, "nodes below a node"),
        key(
            "tree.lods.*.file",
            Fate::Honoured,
            "index of a leaf's chunk at a level, which is the key",
        ),
        key(
            "tree.lods.*.offset",
            Fate::Honoured,
            "the first of its Gaussians in the chunk",
        ),
        key(
            "tree.lods.*.count",
            Fate::Honoured,
            "how many; no Gaussian is in two leaves",
        ),
        key(
            "tree.bound",
            Fate::Listed,
            "a box, by which a viewer chooses levels",
        ),
        key(
            "tree.errors",
            Fate::Listed,
            "by which a viewer chooses levels, too",
        ),
        key("levels but *", Fate::Listed, "other levels"),
        key(
            "Gaussians of *",
            Fate::Listed,
            "those of a chunk that no leaf names",
        ),
    ],
    others: Fate::Listed,
};

/// The registry entry of the keys: files are known by their name, not by an ending.
pub(in super::super) static KEYS: Reader = Reader {
    endings: &[],
    formats: &[&FORMAT],
    read: |path, origin| raw_levels(path, None, origin),
};

/// A run of Gaussians.
#[derive(Debug, Clone, Copy)]
struct Run {
    offset: usize,
    count: usize,
}

/// What a `lod-meta.json` says.
struct Levels {
    facts: Facts,
    environment: Option<PathBuf>,
    filenames: Vec<PathBuf>,
    levels: usize,
    counts: Vec<usize>,
    /// The runs of the chosen level, by chunk.
    runs: BTreeMap<usize, Vec<Run>>,
    rest: Vec<String>,
}

/// Reads a level of a `lod-meta.json` or of the folder that has it; the finest unless given.
pub(in super::super) fn raw_levels(
    path: &Path,
    level: Option<usize>,
    origin: &str,
) -> Result<Raw, FileError> {
    let name = Origin(origin);
    let (folder, file) = match path.is_dir() {
        true => (path, path.join(LEVELS)),
        false => (path.parent().unwrap_or(Path::new("")), path.to_owned()),
    };
    let text = limited(&file, LARGEST)?;
    let chosen = level.unwrap_or(0);
    let all = Levels::read(&text, chosen, name)?;
    let mut bytes = text.len() as u64;
    let mut notes = Notes::default();
    let mut parts = vec![];
    let mut clamped: BTreeMap<String, u64> = BTreeMap::new();
    let mut rest = all.rest;
    let mut take = |path: &Path, runs: Option<&Vec<Run>>| -> Result<(), FileError> {
        let (shown, own) = chunk(folder, path, name)?;
        bytes += own.facts.bytes;
        for (what, count) in own.facts.clamped {
            *clamped.entry(what).or_default() += count;
        }
        notes.extend(own.notes);
        match runs {
            None => parts.push(own.cloud),
            Some(runs) => {
                let (cloud, left) = picked(own.cloud, runs, &shown, name)?;
                parts.extend(cloud);
                if left > 0 {
                    rest.push(format!("Gaussians of {} ({left})", told(&shown)));
                }
            }
        }
        Ok(())
    };
    for (file, runs) in &all.runs {
        take(&all.filenames[*file], Some(runs))?;
    }
    if let Some(environment) = &all.environment {
        take(environment, None)?;
    }
    if level.is_none() && all.levels > 1 {
        rest.push(format!("levels but 0 of {}", all.levels));
    }
    let record = FileKeys::new(&FORMAT, rest.into_iter().map(|key| (key, ())));
    record.finish(&mut notes).map_err(|e| name.key(e))?;
    let first = parts.first().is_some_and(Cloud::is_antialiased);
    if parts.iter().any(|own| own.is_antialiased() != first) {
        let expected = "all of them or none: write the chunks again from one model";
        return Err(name.field("chunks trained with antialiasing", "some", expected));
    }
    if parts.is_empty() {
        return Err(name.field(format!("Gaussians of level {chosen}"), 0, "at least one"));
    }
    let mut facts = all.facts;
    facts.bytes = bytes;
    facts.clamped = clamped.into_iter().collect();
    facts.say("level", format!("{chosen} of 0 to {}", all.levels - 1));
    facts.say("chunks", parts.len());
    if !all.counts.is_empty() {
        let counts: Vec<_> = all.counts.iter().map(ToString::to_string).collect();
        facts.say("Gaussians of each level", counts.join(", "));
    }
    let cloud = Cloud::joined(parts).map_err(|e| name.cloud(e))?;
    Ok(Raw::new(cloud, notes).with(facts))
}

/// Reads a chunk, and tells its path.
fn chunk(folder: &Path, path: &Path, name: Origin<'_>) -> Result<(String, Raw), FileError> {
    let shown = path.display().to_string();
    let origin = format!("{}: {}", name.0, told(&shown));
    let file = folder.join(path);
    let own = match path.file_name().is_some_and(|own| own == META) {
        true => raw_folder(file.parent().unwrap_or(folder), &origin)?,
        false => raw(&limited(&file, LARGEST_CHUNK)?, &origin)?,
    };
    Ok((shown, own))
}

/// The Gaussians of the runs, in their order in the chunk, and how many are in none.
fn picked(
    cloud: Cloud,
    runs: &[Run],
    shown: &str,
    name: Origin<'_>,
) -> Result<(Option<Cloud>, usize), FileError> {
    let mut is_picked = vec![false; cloud.len()];
    for run in runs {
        let end = run.offset.checked_add(run.count);
        let own = end.and_then(|end| is_picked.get_mut(run.offset..end));
        let Some(own) = own else {
            let value = format!("{} from {} on", run.count, run.offset);
            let expected = format!("within the {} of the chunk", cloud.len());
            let field = format!("Gaussians of a leaf in {}", told(shown));
            return Err(name.field(field, value, expected));
        };
        if own.contains(&true) {
            let field = format!("Gaussians of two leaves in {}", told(shown));
            return Err(name.field(field, "shared", "each of them in one leaf"));
        }
        own.fill(true);
    }
    let order: Vec<usize> = (0..cloud.len()).filter(|i| is_picked[*i]).collect();
    let left = cloud.len() - order.len();
    Ok(match (order.is_empty(), left) {
        (true, _) => (None, left),
        (_, 0) => (Some(cloud), 0),
        _ => (Some(cloud.select(&order).map_err(|e| name.cloud(e))?), left),
    })
}

impl Levels {
    fn read(text: &[u8], level: usize, name: Origin<'_>) -> Result<Self, FileError> {
        let mut whole = Object::read(text, LEVELS, name)?;
        let version = whole.whole("version")?;
        if let Some(other) = version.filter(|own| *own != 1) {
            return Err(whole.wrong("version", other, "1"));
        }
        let levels = whole.needed("lodLevels")?;
        if levels == 0 {
            return Err(whole.wrong("lodLevels", 0, "1 or more"));
        }
        if level >= levels {
            let expected = format!("0 to {}, the levels of the file", levels - 1);
            return Err(name.field("level", level, expected));
        }
        let filenames = whole.texts("filenames")?;
        let mut seen = HashSet::new();
        if let Some(twice) = filenames.iter().find(|own| !seen.insert(*own)) {
            let value = format!("`{}`, given twice", told(twice));
            return Err(whole.wrong("filenames", value, "each chunk once"));
        }
        let filenames = filenames.iter().map(|own| path("filenames", own, name));
        let filenames = filenames.collect::<Result<Vec<_>, _>>()?;
        let environment = match whole.take("environment") {
            None | Some(serde_json::Value::Null) => None,
            Some(serde_json::Value::String(own)) => Some(path("environment", &own, name)?),
            Some(_) => return Err(whole.wrong("environment", "no text", "a path or null")),
        };
        let mut rest = vec![];
        let mut facts = Facts::of(&FORMAT);
        facts.version = version.map(|own| own.to_string());
        if let Some(mut asset) = whole.object("asset")? {
            facts.generator = asset.text("generator")?;
            if facts.generator.is_some() {
                rest.push("asset.generator".to_owned());
            }
            asset.finish(&mut rest);
        }
        let Some(tree) = whole.object("tree")? else {
            return Err(whole.wrong("tree", "missing", "an object with children or lods"));
        };
        let mut found = vec![0usize; levels.min(text.len())];
        let mut runs: BTreeMap<usize, Vec<Run>> = BTreeMap::new();
        let mut next = vec![tree.named("tree")];
        while let Some(mut node) = next.pop() {
            let mut children = node.objects("children")?;
            children.reverse();
            next.extend(children.into_iter().map(|own| own.named("tree")));
            if let Some(mut lods) = node.object("lods")? {
                for key in lods.names() {
                    let own: Option<usize> = key.parse().ok().filter(|own| *own < levels);
                    let Some(own) = own else {
                        let key = format!("`{}`", told(&key));
                        let expected = format!("levels 0 to {}", levels - 1);
                        return Err(lods.wrong("key", key, &expected));
                    };
                    let Some(mut run) = lods.object(&key)? else {
                        continue;
                    };
                    let file = run.needed("file")?;
                    if file >= filenames.len() {
                        let expected = format!("below {}, the number of chunks", filenames.len());
                        return Err(run.wrong("file", file, &expected));
                    }
                    let (offset, count) = (run.needed("offset")?, run.needed("count")?);
                    run.named("tree.lods.*").finish(&mut rest);
                    if let Some(sum) = found.get_mut(own) {
                        *sum = sum.saturating_add(count);
                    }
                    if own == level && count > 0 {
                        runs.entry(file).or_default().push(Run { offset, count });
                    }
                }
            }
            node.finish(&mut rest);
        }
        let counts = whole.wholes("counts")?;
        if let Some(counts) = counts.as_ref().filter(|own| **own != found) {
            let wrong = counts.iter().zip(&found).position(|(a, b)| a != b);
            let (value, expected) = match wrong {
                Some(at) => (
                    format!("{} at level {at}", counts[at]),
                    found[at].to_string(),
                ),
                None => (
                    format!("{} of them", counts.len()),
                    format!("{levels}, the levels"),
                ),
            };
            return Err(whole.wrong("counts", value, &format!("{expected}, as the tree says")));
        }
        let all = found
            .iter()
            .fold(0usize, |sum, own| sum.saturating_add(*own));
        if let Some(count) = whole.whole("count")?.filter(|own| *own != all) {
            return Err(whole.wrong("count", count, &format!("{all}, as the tree says")));
        }
        whole.finish(&mut rest);
        rest.sort();
        rest.dedup();
        Ok(Self {
            facts,
            environment,
            filenames,
            levels,
            counts: counts.unwrap_or_default(),
            runs,
            rest,
        })
    }
}

/// The path of a chunk in a folder below.
fn path(field: &str, text: &str, name: Origin<'_>) -> Result<PathBuf, FileError> {
    let own = Path::new(text);
    let mut parts = own.components();
    let is_below = parts.all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    let is_short = text.split('/').all(|part| part.len() <= LONGEST_NAME);
    let last = own
        .file_name()
        .map(|last| last.to_string_lossy().into_owned());
    let is_chunk = last.is_some_and(|last| last == META || last.ends_with(".sog"));
    if is_below && is_short && is_chunk && text.len() < 4096 && !text.contains('\0') {
        return Ok(own.to_owned());
    }
    let expected = "the path of a meta.json or .sog in the folder or below it";
    Err(name.field(field, format!("`{}`", told(text)), expected))
}
