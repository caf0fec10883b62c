//! PLY meshes: element `vertex` with `x y z`, and `face` with a list
//! `vertex_indices`, or `vertex_index`. Binary files of either byte order and
//! text files are read.

use std::io::Write as _;
use std::path::Path;

use ply_rs_bw::ply::{ElementDef, PropertyType, ScalarType};

use super::keys::PLY;
use super::{Parts, judged, wrong};
use crate::mesh::{Mesh, MeshError};
use potamoi_base::file_keys::{FileKeys, Notes};
use potamoi_base::files;
use potamoi_containers::ply::PlyFileError;
use potamoi_containers::ply::header::{self, Header, least_bytes, type_name};
use potamoi_containers::ply::rows::{Layout, Rows};

/// Names of the list of a face's corners.
const LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Reads a mesh and its unused parts; `origin` names the bytes in errors. Faces become triangle
/// fans from their first corner.
///
/// # Errors
/// The file is not PLY, it lacks vertices or faces as above, coordinates are integers or not
/// finite, or a face has fewer than three corners or refers to a vertex that does not exist.
pub fn read_ply(bytes: &[u8], origin: &str) -> Result<(Mesh, Notes), MeshError> {
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
    let mut record = FileKeys::new(&PLY, entries(&header));
    let place = columns(element("vertex")?, &mut record, origin)?;
    let list = list(element("face")?, &mut record, origin)?;
    let mut notes = judged(record, origin)?;
    let mut parts = Parts::default();
    let mut rows = Rows::new(reader, &header);
    let mut values = vec![];
    for (name, element) in &header.ply.elements {
        let layout = match name.as_str() {
            "face" => Layout::of(element).keeping(list),
            _ => Layout::of(element),
        };
        for index in 0..element.count {
            rows.read(&layout, &mut values).map_err(|message| {
                MeshError::Ply(PlyFileError::Element {
                    origin: origin.to_owned(),
                    element: name.clone(),
                    index,
                    message,
                })
            })?;
            match name.as_str() {
                "vertex" => vertex(&mut parts, index, place.map(|c| values[c]), origin)?,
                "face" => face(&mut parts, index, rows.items(), origin)?,
                _ => {}
            }
        }
    }
    let left = rows.rest().map_err(|e| PlyFileError::Header {
        origin: origin.to_owned(),
        message: e.to_string(),
    })?;
    if left > 0 {
        notes.list(format!("bytes after the last element ({left})"));
    }
    Ok((parts.finish(origin)?, notes))
}

fn vertex(parts: &mut Parts, index: usize, at: [f64; 3], origin: &str) -> Result<(), MeshError> {
    parts.vertex(at).map_err(|axis| {
        let field = format!("vertex {index}, {}", ["x", "y", "z"][axis]);
        let value = format!("{:?}", at[axis]);
        wrong(origin, field, value, "a finite number of 32 bits")
    })
}

fn face(parts: &mut Parts, index: usize, items: &[f64], origin: &str) -> Result<(), MeshError> {
    let whole = |v: f64| (v >= 0.0 && v.fract() == 0.0 && v < 4e9).then_some(v as u32);
    let corner = |v: &f64| {
        let field = format!("face {index}, vertex");
        whole(*v).ok_or_else(|| wrong(origin, field, v, "the number of a vertex"))
    };
    let corners = items.iter().map(corner).collect::<Result<Vec<_>, _>>()?;
    if corners.len() < 3 {
        let found = format!("{} corners", corners.len());
        return Err(wrong(origin, format!("face {index}"), found, "3 or more"));
    }
    if !parts.polygon(&corners) {
        return Err(wrong(origin, "faces", "too many", "at most 2^27 triangles"));
    }
    Ok(())
}

/// Keys of vertex and face properties, other elements and comments.
fn entries(header: &Header) -> Vec<(String, ())> {
    let mut all = vec![];
    for (name, element) in &header.ply.elements {
        match name.as_str() {
            "vertex" | "face" => {
                let own = element.properties.keys();
                all.extend(own.map(|property| format!("{name}/{property}")));
            }
            _ => all.push(format!("element {name}")),
        }
    }
    let comments = header.ply.comments.iter();
    all.extend(comments.map(|text| format!("comment {text}")));
    let infos = header.ply.obj_infos.iter();
    all.extend(infos.map(|text| format!("obj_info {text}")));
    all.into_iter().map(|key| (key, ())).collect()
}

/// Columns of the coordinates.
fn columns(
    vertex: &ElementDef,
    record: &mut FileKeys<()>,
    origin: &str,
) -> Result<[usize; 3], MeshError> {
    let mut all = [0; 3];
    for (to, name) in all.iter_mut().zip(["x", "y", "z"]) {
        record.take(&format!("vertex/{name}"));
        let found = vertex.properties.get_full(name);
        let value = match found.map(|(_, _, property)| &property.data_type) {
            Some(PropertyType::Scalar(ScalarType::Float | ScalarType::Double)) => "",
            Some(PropertyType::Scalar(kind)) => type_name(kind),
            Some(PropertyType::List(..)) => "a list",
            None => "missing",
        };
        *to = match found {
            Some((column, ..)) if value.is_empty() => column,
            _ => {
                let field = format!("element `vertex`, property `{name}`");
                let expected = "float or double: write the file again with one of them";
                return Err(wrong(origin, field, value, expected));
            }
        };
    }
    Ok(all)
}

/// The column of a face's corners.
fn list(face: &ElementDef, record: &mut FileKeys<()>, origin: &str) -> Result<usize, MeshError> {
    let found = LISTS.iter().find_map(|n| face.properties.get_full(*n));
    match found {
        Some((i, name, p)) if matches!(p.data_type, PropertyType::List(..)) => {
            record.take(&format!("face/{name}"));
            Ok(i)
        }
        _ => {
            let value = found.map_or("missing", |_| "a number");
            let field = "element `face`, property `vertex_indices`";
            Err(wrong(origin, field, value, "a list of numbers"))
        }
    }
}

/// Writes a mesh as binary little-endian PLY for other programs.
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
