//! Meshes in files: OBJ and PLY, told apart by their names. Memory stays in
//! proportion to the file.

mod obj;
mod ply;
#[cfg(test)]
mod tests;

use std::path::Path;

use super::{Mesh, MeshError};
use potamoi_base::files;

pub use obj::read_obj;
pub use ply::{read_ply, write_ply};

/// The largest file, in bytes.
const LIMIT: u64 = 1 << 31;
/// The most triangles of a file.
const MAX_TRIANGLES: usize = 1 << 27;

/// Reads a file whose name ends in `.obj` or `.ply`.
///
/// # Errors
/// Another name, a file that cannot be read, or one that holds no mesh with at
/// least one triangle.
pub fn read(path: &Path) -> Result<Mesh, MeshError> {
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

/// What a file holds, as it is read.
#[derive(Default)]
struct Parts {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Parts {
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
        let Self {
            vertices,
            triangles,
        } = self;
        let missing = |v: &&u32| **v as usize >= vertices.len();
        if let Some(found) = triangles.as_flattened().iter().find(missing) {
            let expected = format!("below {}, one a vertex", vertices.len());
            return Err(wrong(origin, "vertex of a face", found, expected));
        }
        let mesh = Mesh::new(vertices, triangles)?;
        if !mesh.has_area() {
            return Err(wrong(origin, "area of the faces", "0", "a surface"));
        }
        Ok(mesh)
    }
}
