//! Meshes in files: OBJ and PLY, told apart by their names. Memory stays in
//! proportion to the file.

mod keys;
mod obj;
mod ply;
#[cfg(test)]
mod tests;

use std::path::Path;

use super::{Mesh, MeshError};
use potamoi_base::files;
use potamoi_base::record::{Notes, Record};

pub use keys::{OBJ, PLY};
pub use obj::read_obj;
pub use ply::{read_ply, write_ply};

/// The largest file, in bytes.
const LIMIT: u64 = 1 << 31;
/// The most triangles of a file.
const MAX_TRIANGLES: usize = 1 << 27;

/// How far rounding to 32 bits may move a vertex, as a share of the mesh's longest side.
const ROUNDING: f64 = 1e-4;

/// Reads a file whose name ends in `.obj` or `.ply`; what it says that is not used with it.
///
/// # Errors
/// Another name, a file that cannot be read, or one that holds no mesh with at
/// least one triangle.
pub fn read(path: &Path) -> Result<(Mesh, Notes), MeshError> {
    let is = |ending: &str| {
        let found = path.extension();
        found.is_some_and(|e| e.eq_ignore_ascii_case(ending))
    };
    let [obj, ply] = ["obj", "ply"].map(is);
    if !obj && !ply {
        return Err(MeshError::Unknown {
            path: path.to_owned(),
        });
    }
    let bytes = files::read(path, LIMIT).map_err(|source| MeshError::Read {
        path: path.to_owned(),
        source,
    })?;
    let origin = path.display().to_string();
    let Some(bytes) = bytes else {
        let found = format!("more than {LIMIT} bytes");
        return Err(wrong(&origin, "size", found, "a smaller file"));
    };
    if obj {
        read_obj(&bytes, &origin)
    } else {
        read_ply(&bytes, &origin)
    }
}

fn wrong(
    origin: &str,
    field: impl Into<String>,
    value: impl ToString,
    expected: impl Into<String>,
) -> MeshError {
    MeshError::Field {
        origin: origin.to_owned(),
        field: field.into(),
        value: value.to_string(),
        expected: expected.into(),
    }
}

/// Judges what a reader has not taken.
fn judged(record: Record<()>, origin: &str) -> Result<Notes, MeshError> {
    let mut notes = Notes::default();
    let judged = record.finish(&mut notes);
    judged.map_err(|source| MeshError::Key {
        origin: origin.to_owned(),
        source: Box::new(source),
    })?;
    Ok(notes)
}

/// What a file holds, as it is read.
struct Parts {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// The corners of the box around all vertices.
    corners: [[f64; 3]; 2],
    /// The coordinate that rounding moves most: how far, and what it is.
    moved: (f64, f64),
}

impl Default for Parts {
    fn default() -> Self {
        Self {
            vertices: vec![],
            triangles: vec![],
            corners: [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]],
            moved: (0.0, 0.0),
        }
    }
}

impl Parts {
    /// Takes a vertex; an error is the axis along which it is no finite number of 32 bits.
    fn vertex(&mut self, at: [f64; 3]) -> Result<(), usize> {
        let narrow = at.map(|v| v as f32);
        if let Some(axis) = narrow.iter().position(|v| !v.is_finite()) {
            return Err(axis);
        }
        self.vertices.push(narrow);
        let [low, high] = &mut self.corners;
        for (axis, v) in at.into_iter().enumerate() {
            low[axis] = low[axis].min(v);
            high[axis] = high[axis].max(v);
            let by = (v - f64::from(narrow[axis])).abs();
            if by > self.moved.0 {
                self.moved = (by, v);
            }
        }
        Ok(())
    }

    /// Refuses vertices that floats of 32 bits do not tell apart well: those of a small mesh that
    /// is far from the origin.
    fn hold(&self, origin: &str) -> Result<(), MeshError> {
        let [low, high] = &self.corners;
        let longest = (low.iter().zip(high)).fold(0.0, |most: f64, (l, h)| most.max(h - l));
        let (by, value) = self.moved;
        if by <= ROUNDING * longest {
            return Ok(());
        }
        let expected = format!(
            "coordinates nearer the origin, as floats of 32 bits move this one by {by:.1e} of a mesh \
             {longest:.1e} long: move the mesh and the scene together"
        );
        let value = format!("{value:?}");
        Err(wrong(origin, "a coordinate", value, expected))
    }

    /// Takes a polygon, as triangles from its first corner: right for a convex
    /// one. `false` if there are too many.
    fn polygon(&mut self, corners: &[u32]) -> bool {
        if let Some((first, rest)) = corners.split_first() {
            let sides = rest.windows(2).map(|side| [*first, side[0], side[1]]);
            self.triangles.extend(sides);
        }
        self.triangles.len() <= MAX_TRIANGLES
    }

    fn finish(self, origin: &str) -> Result<Mesh, MeshError> {
        if self.triangles.is_empty() {
            return Err(wrong(origin, "faces", "none", "at least one"));
        }
        let unmoved = self.hold(origin);
        let Self {
            vertices,
            triangles,
            ..
        } = self;
        let missing = |v: &&u32| **v as usize >= vertices.len();
        if let Some(found) = triangles.as_flattened().iter().find(missing) {
            let expected = format!("below {}, one a vertex", vertices.len());
            return Err(wrong(origin, "vertex of a face", found, expected));
        }
        unmoved?;
        let mesh = Mesh::new(vertices, triangles)?;
        if !mesh.has_area() {
            return Err(wrong(origin, "area of the faces", "0", "a surface"));
        }
        Ok(mesh)
    }
}
