//! glTF 2.0 with `KHR_gaussian_splatting`, as `.glb` and as `.gltf`, and SPZ files in it.
//!
//! A Gaussian is a point of a mesh primitive. Sizes are no logarithms, opacities are after the sigmoid,
//! coefficients are in the order of 3D Gaussian splatting. The scene's nodes place meshes; several meshes
//! and primitives make one cloud. x points left, y up, z to the front. An SPZ file is turned from its own
//! axes (right, up, back unless it names others) to these, as the draft of its extension says. Sources: the
//! ratified `KHR_gaussian_splatting`, the draft of `KHR_gaussian_splatting_compression_spz_2` (pull request
//! 2531 of the specification), glTF 2.0, and the writer of splat-transform.
//!
//! The JSON is read without the crate `gltf`, which drops attributes and extensions that it does not know:
//! those of Gaussians, and those to be told.

mod buffers;
mod container;
mod document;
mod keys;
mod places;
mod splats;

use std::path::Path;

use glam::DVec3;

use super::error::{FileError, Origin};
use super::reader::{Reader, whole};
use super::spz;
use crate::axes::Axes;
use crate::cloud::{Cloud, Placement};
use crate::file_content::{Facts, Loaded, Raw};
use buffers::Buffers;
use container::Parts;
use document::{Document, Primitive};
pub use keys::FORMAT;
use places::Shown;
use potamoi_base::file_keys::{FileKeys, Notes};

/// The largest JSON, in bytes.
const LONGEST_JSON: usize = 16 << 20;
/// The distance of a model from its origin, in its own extents, beyond which the origin is moved there:
/// 32-bit floats then lose 10 of their 24 bits.
const FAR: f64 = 1024.0;

/// The registry entry of the format.
pub(super) static READER: Reader = Reader {
    endings: &["glb", "gltf"],
    formats: &[&FORMAT],
    read: |path, origin| {
        let folder = path.parent().unwrap_or(Path::new(""));
        raw(&whole(path)?, folder, origin)
    },
};

/// Reads a cloud; `origin` names the file in errors, and `folder` has the files that it names.
///
/// # Errors
/// The file is no complete glTF 2.0 with Gaussians of the kernel `ellipse`, or the values do not form a
/// valid cloud.
pub fn parse(bytes: &[u8], folder: &Path, origin: &str) -> Result<Loaded, FileError> {
    Ok(raw(bytes, folder, origin)?.turned(None))
}

/// What is gathered from all primitives.
#[derive(Default)]
struct Gathered {
    clouds: Vec<(Cloud, Placement)>,
    rest: Vec<String>,
    notes: Notes,
    raised: u64,
    packed: Vec<String>,
}

fn raw(bytes: &[u8], folder: &Path, origin: &str) -> Result<Raw, FileError> {
    let name = Origin(origin);
    let parts = Parts::of(bytes, name)?;
    if parts.json.len() > LONGEST_JSON {
        let expected = format!("at most {LONGEST_JSON}");
        return Err(name.field("bytes of JSON", parts.json.len(), expected));
    }
    let document = Document::read(parts.json, name)?;
    let mut all = Gathered::default();
    all.rest.extend(parts.beside);
    all.rest.extend(document.rest.iter().cloned());
    document
        .assumed
        .iter()
        .for_each(|own| all.notes.assume(own));
    // Keys that are refused are told before what is wrong with values.
    for primitive in document.meshes.iter().flatten() {
        let keys = primitive.rest.iter().cloned();
        finish(keys, &mut Notes::default(), name)?;
    }
    let shown = places::shown(&document, name)?;
    let mut buffers = Buffers::new(&document, parts.binary, folder, name);
    let mut is_shown = vec![false; document.meshes.len()];
    for own in &shown {
        is_shown[own.mesh] = true;
        gather(&document, &mut buffers, own, bytes.len(), &mut all, name)?;
    }
    let hidden = document.meshes.iter().zip(&is_shown);
    let hidden = hidden
        .filter(|(own, is_shown)| !own.is_empty() && !**is_shown)
        .count();
    if hidden > 0 {
        all.rest
            .push(format!("meshes that the scene does not show ({hidden})"));
    }
    if all.clouds.is_empty() {
        let expected = "a mesh primitive with the extension KHR_gaussian_splatting, which a node of the scene \
                        shows";
        return Err(name.field("Gaussians", "missing", expected));
    }
    all.rest.append(&mut buffers.rest);
    finish(all.rest, &mut all.notes, name)?;

    let mut facts = Facts::of(&FORMAT).version(&document.version);
    facts.generator = document.generator.clone();
    facts.bytes = buffers.bytes_beside();
    facts.say("primitives", all.clouds.len());
    let mut packed = all.packed;
    packed.dedup();
    if !packed.is_empty() {
        facts.say("SPZ inside", format!("version {}", packed.join(", ")));
    }
    facts.clamp(
        "sizes of 0, raised to the smallest normal float",
        all.raised,
    );
    let (cloud, middle) = placed(all.clouds, name)?;
    if middle != DVec3::ZERO {
        let [x, y, z] = middle.to_array();
        (all.notes).assume(format!(
            "centres from ({x}, {y}, {z}) on, which floats do not hold"
        ));
    }
    Ok(Raw {
        origin: middle,
        usual: Axes::LEFT_UP_FRONT,
        ..Raw::new(cloud, all.notes).with(facts)
    })
}

/// Judges keys that nobody used.
fn finish(
    keys: impl IntoIterator<Item = String>,
    notes: &mut Notes,
    name: Origin<'_>,
) -> Result<(), FileError> {
    let record = FileKeys::new(&FORMAT, keys.into_iter().map(|key| (key, ())));
    record.finish(notes).map_err(|e| name.key(e))
}

/// Reads the primitives of a mesh that the scene shows.
fn gather(
    document: &Document,
    buffers: &mut Buffers<'_>,
    shown: &Shown,
    bytes: usize,
    all: &mut Gathered,
    name: Origin<'_>,
) -> Result<(), FileError> {
    let primitives = &document.meshes[shown.mesh];
    if primitives.is_empty() {
        return Ok(());
    }
    let at = shown.placement(name)?;
    if let Some(node) = shown.node(document) {
        all.rest.extend(node.rest.iter().cloned());
    }
    for primitive in primitives {
        primitive
            .assumed
            .iter()
            .for_each(|own| all.notes.assume(own));
        all.rest.extend(primitive.rest.iter().cloned());
        let cloud = match primitive.spz {
            Some(view) => of_spz(document, buffers, primitive, view, all, name)?,
            None => {
                let read = splats::of_attributes(document, buffers, primitive, name)?;
                all.raised += read.raised;
                all.rest.extend(read.rest);
                read.cloud
            }
        };
        all.clouds.push((cloud, at));
        // A mesh may be shown several times.
        let most = bytes + buffers.bytes_beside() as usize;
        let count: usize = all.clouds.iter().map(|(own, _)| own.len()).sum();
        if count > most {
            let expected = format!("at most {most}: a byte of the files for each at the least");
            return Err(name.field("number of Gaussians of all nodes", count, expected));
        }
    }
    Ok(())
}

/// Reads the Gaussians of an SPZ file, in the axes of glTF.
fn of_spz(
    document: &Document,
    buffers: &mut Buffers<'_>,
    primitive: &Primitive,
    view: usize,
    all: &mut Gathered,
    name: Origin<'_>,
) -> Result<Cloud, FileError> {
    let place = format!("{}: SPZ", primitive.place);
    let origin = format!("{}: SPZ of bufferViews[{view}]", name.0);
    let raw = spz::raw(buffers.view(view, &place)?, &origin)?;
    let loaded = raw.turned(None);
    all.notes.extend(loaded.notes.under("SPZ: "));
    all.packed.extend(loaded.facts.version);
    let count = loaded.cloud.len();
    for (semantic, index) in &primitive.attributes {
        let Some(accessor) = document.accessors.get(*index) else {
            let field = format!("{}.{semantic}", primitive.place);
            let expected = format!(
                "below {}, the number of accessors",
                document.accessors.len()
            );
            return Err(name.field(field, index, expected));
        };
        if accessor.count != count {
            let field = format!("accessors[{index}].count");
            let expected = format!("{count}, as many as the SPZ file has Gaussians");
            return Err(name.field(field, accessor.count, expected));
        }
        if accessor.view.is_some() {
            all.notes.list(format!("attributes.{semantic} beside SPZ"));
        }
    }
    // The axes of glTF are their own opposite of those of a cloud: left for right and up for down.
    Ok(loaded.cloud.turned(Axes::LEFT_UP_FRONT))
}

/// One cloud of all, in the axes of glTF, and the origin of its centres.
fn placed(clouds: Vec<(Cloud, Placement)>, name: Origin<'_>) -> Result<(Cloud, DVec3), FileError> {
    let is_antialiased = clouds.first().is_some_and(|(own, _)| own.is_antialiased());
    if clouds
        .iter()
        .any(|(own, _)| own.is_antialiased() != is_antialiased)
    {
        let expected = "all of them or none: render them one by one";
        return Err(name.field("primitives trained with antialiasing", "some", expected));
    }
    let mut middle = DVec3::ZERO;
    if let Some((cloud, at)) = clouds.first() {
        let [low, high] = cloud.bounds().map(|own| DVec3::from(own.map(f64::from)));
        let extent = low.abs().max(high.abs()).max_element() * at.scale;
        if at.translation.abs().max_element() > FAR * extent {
            middle = at.translation;
        }
    }
    let parts = clouds.into_iter().map(|(cloud, at)| {
        let translation = at.translation - middle;
        cloud.placed(&Placement { translation, ..at })
    });
    let cloud = Cloud::joined(parts.collect()).map_err(|e| name.cloud(e))?;
    // A place may be beyond what floats hold.
    let is_finite = cloud.means().iter().flatten().all(|v| v.is_finite());
    let is_sized = cloud
        .log_scales()
        .iter()
        .flatten()
        .all(|v| *v <= crate::cloud::MAX_LOG_SCALE);
    if !is_finite || !is_sized {
        let expected = "centres and sizes within the range of 32-bit floats";
        return Err(name.field("transform of a node", "too large", expected));
    }
    Ok((cloud, middle))
}
