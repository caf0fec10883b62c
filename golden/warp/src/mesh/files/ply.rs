//! PLY meshes: element `vertex` with `x y z`, and `face` with a list
//! `vertex_indices`, or `vertex_index`. Binary files of either byte order and
//! text files are read.

use std::io::Write as _;
use std::path::Path;

use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{ElementDef, Property, PropertyAccess, PropertyType};

use super::{Parts, wrong};
use crate::mesh::{Mesh, MeshError};
use potamoi_base::files;
use potamoi_containers::ply::header::{self, least_bytes};
use potamoi_containers::ply::{PlyFileError, read_element};

/// Names of the list of a face's corners.
const LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Reads a mesh; `origin` names the bytes in errors. Faces are fanned into
/// triangles from their first corner; other elements and properties are read
/// past.
///
/// # Errors
/// No PLY file, one without vertices or faces as above, coordinates that are not
/// finite, or a face of fewer than three corners or of a vertex that is not
/// there.
pub fn read_ply(bytes: &[u8], origin: &str) -> Result<Mesh, MeshError> {
    let mut reader = bytes;
    let header = header::read(&mut reader, origin)?;
    let needed = least_bytes(&header.ply);
    if needed > reader.len() as u128 {
        return Err(MeshError::Ply(PlyFileError::Truncated {
            origin: origin.to_owned(),
            needed,
            found: reader.len() as u64,
        }));
    }
    let element = |name: &str| {
        let found = header.ply.elements.get(name);
        let field = format!("element `{name}`");
        found.ok_or_else(|| wrong(origin, field, "missing", "a mesh of vertices and faces"))
    };
    let place = columns(element("vertex")?, origin)?;
    let list = list(element("face")?, origin)?;
    let parser = Parser::<Row>::new();
    let mut parts = Parts::default();
    for (name, element) in &header.ply.elements {
        for index in 0..element.count {
            let row = read_element(&parser, &mut reader, header.ply.encoding, element);
            let row = row.map_err(|message| {
                MeshError::Ply(PlyFileError::Element {
                    origin: origin.to_owned(),
                    element: name.clone(),
                    index,
                    message,
                })
            })?;
            match name.as_str() {
                "vertex" => {
                    let at = place.map(|column| row.scalar(column));
                    let narrow = at.map(|v| v as f32);
                    if let Some(axis) = narrow.iter().position(|v| !v.is_finite()) {
                        let field = format!("vertex {index}, {}", ["x", "y", "z"][axis]);
                        return Err(wrong(origin, field, at[axis], "a finite number of 32 bits"));
                    }
                    parts.vertices.push(narrow);
                }
                "face" => {
                    let corners = row.corners(list).map_err(|found| {
                        let field = format!("face {index}, vertex");
                        wrong(origin, field, found, "the number of a vertex")
                    })?;
                    if corners.len() < 3 {
                        let found = format!("{} corners", corners.len());
                        return Err(wrong(origin, format!("face {index}"), found, "3 or more"));
                    }
                    if !parts.polygon(&corners) {
                        return Err(wrong(origin, "faces", "too many", "at most 2^27 triangles"));
                    }
                }
                _ => {}
            }
        }
    }
    parts.finish(origin)
}

/// Columns of the coordinates.
fn columns(vertex: &ElementDef, origin: &str) -> Result<[usize; 3], MeshError> {
    let mut all = [0; 3];
    for (to, name) in all.iter_mut().zip(["x", "y", "z"]) {
        *to = match vertex.properties.get_full(name) {
            Some((i, _, p)) if matches!(p.data_type, PropertyType::Scalar(_)) => i,
            found => {
                let value = found.map_or("missing", |_| "a list");
                let field = format!("element `vertex`, property `{name}`");
                return Err(wrong(origin, field, value, "a number"));
            }
        };
    }
    Ok(all)
}

/// The column of a face's corners.
fn list(face: &ElementDef, origin: &str) -> Result<usize, MeshError> {
    let found = LISTS.iter().find_map(|n| face.properties.get_full(*n));
    match found {
        Some((i, _, p)) if matches!(p.data_type, PropertyType::List(..)) => Ok(i),
        _ => {
            let value = found.map_or("missing", |_| "a number");
            let field = "element `face`, property `vertex_indices`";
            Err(wrong(origin, field, value, "a list of numbers"))
        }
    }
}

/// The properties of an element, in the order of the header.
struct Row(Vec<Property>);

impl PropertyAccess for Row {
    fn new() -> Self {
        Self(vec![])
    }

    fn set_property(&mut self, _: &str, property: Property) {
        self.0.push(property);
    }
}

impl Row {
    fn scalar(&self, column: usize) -> f64 {
        match self.0.get(column) {
            Some(Property::Char(v)) => f64::from(*v),
            Some(Property::UChar(v)) => f64::from(*v),
            Some(Property::Short(v)) => f64::from(*v),
            Some(Property::UShort(v)) => f64::from(*v),
            Some(Property::Int(v)) => f64::from(*v),
            Some(Property::UInt(v)) => f64::from(*v),
            Some(Property::Float(v)) => f64::from(*v),
            Some(Property::Double(v)) => *v,
            // Columns were found to be scalars.
            _ => f64::NAN,
        }
    }

    /// An error is a number that is none of a vertex.
    fn corners(&self, column: usize) -> Result<Vec<u32>, String> {
        fn all<T: Copy + ToString>(
            values: &[T],
            number: impl Fn(T) -> Option<u32>,
        ) -> Result<Vec<u32>, String> {
            let each = values.iter();
            each.map(|v| number(*v).ok_or_else(|| v.to_string()))
                .collect()
        }
        let whole = |v: f64| (v >= 0.0 && v.fract() == 0.0 && v < 4e9).then_some(v as u32);
        match self.0.get(column) {
            Some(Property::ListChar(v)) => all(v, |v| u32::try_from(v).ok()),
            Some(Property::ListUChar(v)) => all(v, |v| Some(u32::from(v))),
            Some(Property::ListShort(v)) => all(v, |v| u32::try_from(v).ok()),
            Some(Property::ListUShort(v)) => all(v, |v| Some(u32::from(v))),
            Some(Property::ListInt(v)) => all(v, |v| u32::try_from(v).ok()),
            Some(Property::ListUInt(v)) => all(v, Some),
            Some(Property::ListFloat(v)) => all(v, |v| whole(f64::from(v))),
            Some(Property::ListDouble(v)) => all(v, whole),
            // The column was found to be a list.
            _ => Ok(vec![]),
        }
    }
}

/// Writes a mesh as binary little-endian PLY, which other programs show.
///
/// # Errors
/// The file cannot be written.
pub fn write_ply(mesh: &Mesh, path: &Path) -> std::io::Result<()> {
    let (vertices, triangles) = (mesh.vertices(), mesh.triangles());
    let mut bytes = Vec::with_capacity(256 + 12 * vertices.len() + 13 * triangles.len());
    write!(
        bytes,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n\
         property float y\nproperty float z\nelement face {}\n\
         property list uchar uint vertex_indices\nend_header\n",
        vertices.len(),
        triangles.len()
    )?;
    for value in vertices.as_flattened() {
        bytes.extend_from_slice(&value.to_le_bytes());
    }
    for triangle in triangles {
        bytes.push(3);
        for vertex in triangle {
            bytes.extend_from_slice(&vertex.to_le_bytes());
        }
    }
    files::write(path, &bytes)
}
