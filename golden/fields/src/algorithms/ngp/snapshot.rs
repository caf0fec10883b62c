//! Snapshots of Instant-NGP, version 1: a MessagePack document, plain or compressed by zlib or
//! gzip, recognised by its first bytes. Only the parts that are used are built, so that memory is
//! bounded by the numbers in the file.
//!
//! Parameters follow one another as in tiny-cuda-nn: density network, colour network, then the
//! levels of the grid. A layer is a matrix with a row an output. Inputs and outputs of a network
//! are rounded up to 16. Inputs beyond the features of the grid are zero, so their weights are
//! dropped.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use flate2::bufread::{GzDecoder, ZlibDecoder};
use glam::DVec3;
use potamoi_formats::document;

use super::document::{Bounds, Direction, Document, Encoding};
use super::grid::{GridShape, Level};
use super::occupancy::{CELLS, Occupancy, VOLUME};
use super::parameters::{ALIGNMENT, Numbers, halves, parameters, perceptron, table, widths};
use super::wrong::{Wrong, check, finite, is};
use super::{NGP, Ngp, Placement};
use crate::calibrate::Magnitudes;
use crate::snapshot_error::SnapshotError;
use crate::{FieldError, HashUnit};
use potamoi_base::file_keys::{FileKeys, Notes, told, told_within};

/// The largest expanded document in bytes: for any file, for small files, and beyond the length of
/// the file. Occupancy is mostly zeros and compresses well: 4 MiB a cube, at most eight cubes.
const LIMIT: u64 = 1 << 30;
const SMALL: u64 = 64 << 20;
const EXPANSION: u64 = 64;
/// Maximum nesting depth of a document.
const DEPTH: usize = 64;
/// Inputs of the colour network for the direction: degree 4, 16 numbers.
const DIRECTION: usize = 16;
/// Maximum number of keys that are skipped.
const MAX_UNREAD: usize = 4096;
/// The largest box, in unit cubes.
const MAX_AABB_SCALE: u32 = 128;
/// Maximum number of vertices along an axis of a level.
const MAX_RESOLUTION: u64 = (1 << 20) - 1;
/// Scale and offset of datasets that do not state them.
const SCALE: f64 = 0.33;
const OFFSET: f64 = 0.5;

pub(super) fn load(path: &Path) -> Result<Ngp, FieldError> {
    let fail = |source| SnapshotError::Read {
        path: path.to_owned(),
        source,
    };
    let file = potamoi_base::files::open(path).map_err(fail)?;
    let length = file.metadata().map_err(fail)?.len();
    from_reader(path, BufReader::new(file), length)
}

/// Reads a snapshot of `length` bytes; `path` names it in errors.
pub(super) fn from_reader(
    path: &Path,
    bytes: impl BufRead,
    length: u64,
) -> Result<Ngp, FieldError> {
    let (document, unread) = read(path, bytes, length)?;
    let mut notes = Notes::default();
    let record = FileKeys::new(&NGP, unread.into_iter().map(|key| (key, ())));
    record
        .finish(&mut notes)
        .map_err(|source| SnapshotError::Key {
            path: path.to_owned(),
            source: Box::new(source),
        })?;
    let wrong = |wrong: Wrong| SnapshotError::Field {
        path: path.to_owned(),
        field: wrong.field,
        found: wrong.found,
        expected: wrong.expected,
    };
    supported(&document).map_err(wrong)?;
    let snapshot = &document.snapshot;
    let aabb_scale = snapshot.nerf.aabb_scale;
    let shape = shape(&document.encoding, aabb_scale).map_err(wrong)?;
    let unit = hash_unit(&document.encoding, &shape).map_err(wrong)?;
    let levels: Vec<Level> = shape.all().collect();
    let features = (shape.levels * shape.features) as usize;
    let latents = document.network.n_output_dims.unwrap_or(ALIGNMENT as u32) as usize;
    let latents = latents.next_multiple_of(ALIGNMENT);
    let density = widths(&document.network, "network", features, latents).map_err(wrong)?;
    let inputs = latents + DIRECTION;
    let colour = widths(&document.rgb_network, "rgb_network", inputs, 3).map_err(wrong)?;
    let in_grid: usize = levels
        .iter()
        .map(|l| l.entries * shape.features as usize)
        .sum();
    let expected = parameters(&density) + parameters(&colour) + in_grid;
    let mut numbers = Numbers::new(&document, expected).map_err(wrong)?;
    let density = perceptron(&density, latents, &mut numbers)?;
    let colour = perceptron(&colour, 3, &mut numbers)?;
    let tables = levels.iter().map(|level| {
        let count = level.entries * shape.features as usize;
        table(level, unit, shape.features as usize, numbers.take(count))
    });
    let tables = tables.collect::<Result<_, _>>()?;
    let side = f64::from(aabb_scale);
    let corner = 0.5 - side / 2.0;
    let placement = placement(&document).map_err(wrong)?;
    let bounds = shown(&document, corner, side).map_err(wrong)?;
    // Cycling axes keeps the order of corners.
    let bounds = bounds.map(|at| placement.to_world(at));
    Ok(Ngp {
        shape,
        unit,
        tables,
        scales: levels.iter().map(|l| l.scale).collect(),
        density,
        colour,
        occupancy: occupancy(&document).map_err(wrong)?,
        placement,
        corner,
        side,
        bounds,
        notes,
        magnitudes: Magnitudes::default(),
    })
}

fn read(path: &Path, mut bytes: impl BufRead, length: u64) -> Result<Told, SnapshotError> {
    let first = bytes.fill_buf().map_err(|source| SnapshotError::Read {
        path: path.to_owned(),
        source,
    })?;
    let mut packed = true;
    let read: Box<dyn Read + '_> = match first {
        [0x1f, 0x8b, ..] => Box::new(GzDecoder::new(&mut bytes)),
        // Deflate with any window; as MessagePack it would be a number.
        [0x08 | 0x18 | 0x28 | 0x38 | 0x48 | 0x58 | 0x68 | 0x78, ..] => {
            Box::new(ZlibDecoder::new(&mut bytes))
        }
        _ => {
            packed = false;
            Box::new(&mut bytes)
        }
    };
    let limit = length.saturating_mul(EXPANSION).clamp(SMALL, LIMIT);
    let container = |field: String, problem: String| SnapshotError::Container {
        path: path.to_owned(),
        field: told(&field),
        problem,
    };
    let parsed = parse(read.take(limit)).map_err(|(field, problem, left)| match left {
        0 => container(
            field,
            format!("the file expands to more than {limit} bytes"),
        ),
        _ => container(field, told_within(&problem, 300)),
    })?;
    let follows = packed && bytes.fill_buf().is_ok_and(|rest| !rest.is_empty());
    if follows {
        let problem = "bytes follow the end of the packed document".to_owned();
        return Err(container(".".to_owned(), problem));
    }
    Ok(parsed)
}

/// A document, and the paths of the keys that were skipped.
type Told = (Document, Vec<String>);

/// The document, or else the invalid field, the problem, and the number of bytes that could have
/// followed.
fn parse(bytes: std::io::Take<impl Read>) -> Result<Told, (String, String, u64)> {
    let mut reader = rmp_serde::Deserializer::new(BufReader::new(bytes));
    reader.set_max_depth(DEPTH);
    let mut track = serde_path_to_error::Track::new();
    let tracked = serde_path_to_error::Deserializer::new(&mut reader, &mut track);
    let mut unread: Vec<String> = vec![];
    let document = serde_ignored::deserialize(tracked, |path| {
        if unread.len() <= MAX_UNREAD {
            // What may be left out is told with a question mark.
            unread.push(path.to_string().replace(".?", ""));
        }
    });
    let document: Document = document.map_err(|e: rmp_serde::decode::Error| {
        let left = reader.get_ref().get_ref().limit();
        (
            track.path().to_string().replace(".?", ""),
            document::foreign(&e.to_string()),
            left,
        )
    })?;
    if unread.len() > MAX_UNREAD {
        let problem = format!("more than {MAX_UNREAD} keys that nobody knows");
        return Err((".".to_owned(), problem, 1));
    }
    // The checksum of packed bytes is compared where they end.
    let rest = reader.get_mut().fill_buf().map(<[u8]>::len);
    let left = reader.get_ref().get_ref().limit();
    let problem = match rest {
        Ok(0) if left > 0 => return Ok((document, unread)),
        Ok(_) => "bytes follow the end of the document".to_owned(),
        Err(e) => e.to_string(),
    };
    Err((".".to_owned(), problem, left))
}

/// Checks fields of which only one value is supported.
fn supported(document: &Document) -> Result<(), Wrong> {
    let snapshot = &document.snapshot;
    check(
        snapshot.version == 1,
        "snapshot.version",
        snapshot.version,
        "1",
    )?;
    let mode = snapshot.mode.as_deref().unwrap_or("nerf");
    let nerf = mode.eq_ignore_ascii_case("nerf");
    check(nerf, "snapshot.mode", mode, "nerf")?;
    let scale = snapshot.nerf.aabb_scale;
    let known = scale.is_power_of_two() && scale <= MAX_AABB_SCALE;
    let expected = "a power of two up to 128";
    check(known, "snapshot.nerf.aabb_scale", scale, expected)?;
    if let Some(dataset) = &snapshot.nerf.dataset {
        let field = |name| format!("snapshot.nerf.dataset.{name}");
        let expected = "false: their axes are others";
        let mitsuba = dataset.from_mitsuba;
        check(!mitsuba, &field("from_mitsuba"), mitsuba, expected)?;
        let expected = "false: colours through the logistic function";
        check(!dataset.is_hdr, &field("is_hdr"), dataset.is_hdr, expected)?;
        let extra = dataset.n_extra_learnable_dims;
        let name = field("n_extra_learnable_dims");
        check(extra == 0, &name, extra, "0")?;
    }
    for (field, linear) in [
        ("snapshot.linear_colors", snapshot.linear_colors),
        ("snapshot.nerf.linear_colors", snapshot.nerf.linear_colors),
    ] {
        let expected = "false: colours are those of training pictures, in sRGB";
        check(linear != Some(true), field, "true", expected)?;
    }
    let encoding = &document.encoding;
    let kind = &encoding.otype;
    let hashed = kind.eq_ignore_ascii_case("HashGrid")
        || (kind.eq_ignore_ascii_case("Grid") && is(&encoding.kind, "Hash"));
    let expected = "HashGrid, or Grid with type Hash";
    check(hashed, "encoding.otype", kind, expected)?;
    let found = encoding.kind.as_deref().unwrap_or_default();
    check(is(&encoding.kind, "Hash"), "encoding.type", found, "Hash")?;
    // tiny-cuda-nn's others, Prime, ReversedPrime and Rng, find other entries.
    let found = encoding.hash.as_deref().unwrap_or_default();
    let usual = is(&encoding.hash, "CoherentPrime");
    check(usual, "encoding.hash", found, "CoherentPrime")?;
    let linear = is(&encoding.interpolation, "Linear");
    let found = encoding.interpolation.as_deref().unwrap_or_default();
    check(linear, "encoding.interpolation", found, "Linear")?;
    let stochastic = encoding.stochastic_interpolation == Some(true);
    let field = "encoding.stochastic_interpolation";
    check(!stochastic, field, "true", "false")?;
    direction(&document.dir_encoding)
}

/// Checks for spherical harmonics of degree 4, alone or in a composite whose other parts have no
/// dimensions left.
fn direction(encoding: &Direction) -> Result<(), Wrong> {
    let (part, field) = if encoding.otype.eq_ignore_ascii_case("Composite") {
        let first = encoding.nested.as_ref().map(|first| &first.0);
        let Some(first) = first.filter(|part| part.n_dims_to_encode == Some(3)) else {
            let field = "dir_encoding.nested";
            return check(false, field, "another", "3 dimensions in its first part");
        };
        let outer = encoding.degree.unwrap_or(4);
        let expected = "4, or left out beside a composite, whose first part gives it";
        check(outer == 4, "dir_encoding.degree", outer, expected)?;
        (&**first, "dir_encoding.nested[0]")
    } else {
        (encoding, "dir_encoding")
    };
    let harmonics = part.otype.eq_ignore_ascii_case("SphericalHarmonics");
    let name = format!("{field}.otype");
    check(harmonics, &name, &part.otype, "SphericalHarmonics")?;
    let alone = part.nested.is_none();
    let expected = "none beside SphericalHarmonics: a composite alone has parts";
    check(alone, &format!("{field}.nested"), "a list", expected)?;
    let degree = part.degree.unwrap_or(4);
    check(degree == 4, &format!("{field}.degree"), degree, "4")
}

/// Sizes of the grid, with the reference's defaults.
fn shape(encoding: &Encoding, aabb_scale: u32) -> Result<GridShape, Wrong> {
    let features = encoding.n_features_per_level.unwrap_or(2);
    let known = [1, 2, 4, 8].contains(&features);
    let field = "encoding.n_features_per_level";
    check(known, field, features, "1, 2, 4 or 8")?;
    let levels = match encoding.n_features {
        Some(all) if all > 0 => {
            let expected = format!("a multiple of n_features_per_level, {features}");
            check(all % features == 0, "encoding.n_features", all, expected)?;
            let levels = all / features;
            let given = encoding.n_levels.unwrap_or(levels);
            let expected = format!("{levels}, from n_features {all}, or left out");
            check(given == levels, "encoding.n_levels", given, expected)?;
            levels
        }
        _ => encoding.n_levels.unwrap_or(16),
    };
    let known = (1..=32).contains(&levels);
    check(known, "encoding.n_levels", levels, "1 to 32")?;
    let log2_entries = encoding.log2_hashmap_size.unwrap_or(15);
    let known = (3..=24).contains(&log2_entries);
    let field = "encoding.log2_hashmap_size";
    check(known, field, log2_entries, "3 to 24")?;
    let base = match encoding.base_resolution {
        Some(base) if base > 0 => base,
        _ => 1 << (log2_entries / 3),
    };
    let known = base <= 1 << 14;
    check(known, "encoding.base_resolution", base, "1 to 16384")?;
    let growth = match encoding.per_level_scale {
        Some(growth) if growth != 0.0 => growth,
        _ => GridShape::growth_to(levels, base, aabb_scale),
    };
    let field = "encoding.per_level_scale";
    check((1.0..=64.0).contains(&growth), field, growth, "1 to 64")?;
    let shape = GridShape {
        levels,
        features,
        log2_entries,
        base,
        growth,
    };
    let finest = shape.level(levels - 1).resolution;
    let found = format!("{growth}, with {finest} vertices along the finest level");
    let expected = format!("at most {MAX_RESOLUTION} of them");
    check(finest <= MAX_RESOLUTION, field, found, expected)?;
    Ok(shape)
}

/// What shares an entry of a hashed level; a vertex unless the file states otherwise.
fn hash_unit(encoding: &Encoding, shape: &GridShape) -> Result<HashUnit, Wrong> {
    let units = [HashUnit::Vertex, HashUnit::MVoxel];
    let field = "encoding.hash_unit";
    let found = encoding.hash_unit.as_deref().unwrap_or("vertex");
    let Some(unit) = units.into_iter().find(|unit| unit.name() == found) else {
        check(false, field, found, "vertex or mvoxel")?;
        return Ok(HashUnit::Vertex);
    };
    let entries = 1usize << shape.log2_entries;
    let fits = unit == HashUnit::Vertex || entries >= HashUnit::BLOCK_ROWS;
    let found = format!("{found}, with {entries} rows a level");
    let expected = format!("{} rows or more, a block's", HashUnit::BLOCK_ROWS);
    check(fits, field, found, expected)?;
    Ok(unit)
}

fn placement(document: &Document) -> Result<Placement, Wrong> {
    let dataset = document.snapshot.nerf.dataset.as_ref();
    let scale = dataset.and_then(|d| d.scale).unwrap_or(SCALE);
    let offset = dataset.and_then(|d| d.offset).unwrap_or([OFFSET; 3]);
    let known = (1e-6..=1e6).contains(&scale);
    let field = "snapshot.nerf.dataset.scale";
    check(known, field, scale, "1e-6 to 1e6")?;
    let known = offset.iter().all(|v| v.abs() <= 1e6);
    let field = "snapshot.nerf.dataset.offset";
    check(known, field, format!("{offset:?}"), "-1e6 to 1e6")?;
    Ok(Placement {
        scale,
        offset: DVec3::from(offset),
    })
}

/// The visible part of the box, in the unit cube's frame.
fn shown(document: &Document, corner: f64, side: f64) -> Result<[DVec3; 2], Wrong> {
    let snapshot = &document.snapshot;
    let whole = [DVec3::splat(corner), DVec3::splat(corner + side)];
    for (field, bounds) in [
        ("snapshot.aabb", snapshot.aabb),
        ("snapshot.render_aabb", snapshot.render_aabb),
    ] {
        let Some(Bounds { min, max }) = bounds else {
            continue;
        };
        let right = (min.iter().zip(max)).all(|(low, high)| low.is_finite() && *low < high);
        let found = format!("{min:?} to {max:?}");
        check(right, field, found, "finite corners, `min` below `max`")?;
    }
    if let Some(Bounds { min, max }) = snapshot.aabb {
        let off = |found: [f64; 3], at: DVec3| (DVec3::from(found) - at).abs().max_element();
        let fits = off(min, whole[0]) < 1e-5 && off(max, whole[1]) < 1e-5;
        let expected = format!("{corner} to {}, from aabb_scale", corner + side);
        let found = format!("{min:?} to {max:?}");
        check(fits, "snapshot.aabb", found, expected)?;
    }
    if let Some(turn) = snapshot.render_aabb_to_local {
        let straight = turn.iter().enumerate().all(|(r, row)| {
            let cells = row.iter().enumerate();
            cells
                .into_iter()
                .all(|(c, v)| (v - f64::from(u8::from(r == c))).abs() < 1e-6)
        });
        let field = "snapshot.render_aabb_to_local";
        check(
            straight,
            field,
            "a turn",
            "the identity: a box along the axes",
        )?;
    }
    let Some(Bounds { min, max }) = snapshot.render_aabb else {
        return Ok(whole);
    };
    let bounds = [
        DVec3::from(min).max(whole[0]),
        DVec3::from(max).min(whole[1]),
    ];
    let found = format!("{min:?} to {max:?}");
    let holds = (bounds[1] - bounds[0]).cmpgt(DVec3::ZERO).all();
    let expected = "a box that meets `aabb`";
    check(holds, "snapshot.render_aabb", found, expected)?;
    Ok(bounds)
}

fn occupancy(document: &Document) -> Result<Option<Occupancy>, Wrong> {
    let snapshot = &document.snapshot;
    let size = snapshot.density_grid_size;
    let expected = CELLS.to_string();
    check(size == CELLS, "snapshot.density_grid_size", size, expected)?;
    let bytes = &snapshot.density_grid_binary.0[..];
    if bytes.is_empty() {
        // Saved before the first training step.
        return Ok(None);
    }
    let cubes = snapshot.nerf.aabb_scale.ilog2() as usize + 1;
    let expected = format!("{}: {cubes} grids of 128^3 in 16 bits", 2 * cubes * VOLUME);
    let found = format!("{} bytes", bytes.len());
    let fits = bytes.len() == 2 * cubes * VOLUME;
    check(fits, "snapshot.density_grid_binary", found, expected)?;
    let thickness: Vec<f32> = halves(bytes).collect();
    finite(&thickness, "snapshot.density_grid_binary")?;
    Ok(Some(Occupancy::new(&thickness)))
}
