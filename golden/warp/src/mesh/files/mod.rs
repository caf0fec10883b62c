//! Mesh files: OBJ and PLY, selected by file name. Memory is proportional to the file.

mod keys;
mod obj;
mod ply;
#[cfg(test)]
mod tests;

use std::path::Path;

use super::{Mesh, MeshError};
use potamoi_base::file_keys::{FileKeys, Notes};
use potamoi_base::files;

pub use keys::{OBJ, PLY};
pub use obj::read_obj;
pub use ply::{read_ply, write_ply};

/// The largest file, in bytes.
const LIMIT: u64 = 1 << 31;
/// Maximum number of triangles in a file.
const MAX_TRIANGLES: usize = 1 << 27;

/// Maximum rounding error of a vertex in 32 bits, relative to the mesh's longest side.
const ROUNDING: f64 = 1e-4;

/// Reads a file whose name ends in `.obj` or `.ply`, and returns its unused parts with the mesh.
///
/// # Errors
/// The name has another extension, or the file cannot be read or does not hold a mesh of at least
/// one triangle.
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

/// Checks the keys that a reader has not used.
fn judged(record: FileKeys<()>, origin: &str) -> Result<Notes, MeshError> {
    let mut notes = Notes::default();
    let judged = record.finish(&mut notes);
    judged.map_err(|source| MeshError::Key {
        origin: origin.to_owned(),
        source: Box::new(source),
    })?;
    Ok(notes)
}

/// The content of a file while it is read.
struct Parts {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// The corners of the box around all vertices.
    corners: [[f64; 3]; 2],
    /// The largest rounding error of a coordinate, and that coordinate.
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
    /// Adds a vertex. The error is the axis of a coordinate that is not finite in 32 bits.
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

    /// Refuses vertices that 32-bit floats cannot distinguish well: those of a small mesh far from
    /// the origin.
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

    /// Adds a polygon as a triangle fan from its first corner, which is correct for convex ones.
    /// `false` if there are too many triangles.
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
