#![allow(clippy::unwrap_used)]
use std::fmt::Write as _;

use proptest::prelude::*;

use super::*;

const OBJ: &str = "# a pyramid\nmtllib no.mtl\no p\nv 0 0 0\nv 1 0 0 1.0\r\nv 1 1 0\n\
                   v 0 1 0 # a comment\nv .5 .5 \\\n 1e0\nvt 0 0\nvn 0 0 1\ng side\nusemtl m\n\
                   f 1/1 4/1/1 3//1 2\ns off\nf 1 2 -1\nf 2 3 5\nf -3 4 5\nf 4 1 5\n";

fn pyramid() -> Mesh {
    let vertices = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.5, 0.5, 1.0],
    ];
    let triangles = vec![
        [0, 3, 2],
        [0, 2, 1],
        [0, 1, 4],
        [1, 2, 4],
        [2, 3, 4],
        [3, 0, 4],
    ];
    Mesh::new(vertices, triangles).unwrap()
}

/// As text, with a polygon and what is read past.
fn text_ply() -> String {
    let mut text = "ply\nformat ascii 1.0\ncomment c\nelement vertex 5\nproperty double x\n\
                    property uchar red\nproperty float y\nproperty float z\nelement face 5\n\
                    property list uchar int vertex_index\nproperty int flags\nelement edge 1\n\
                    property int vertex1\nend_header\n"
        .to_owned();
    for [x, y, z] in pyramid().vertices() {
        writeln!(text, "{x} 7 {y} {z}").unwrap();
    }
    text += "4 0 3 2 1 0\n";
    for [a, b, c] in &pyramid().triangles()[2..] {
        writeln!(text, "3 {a} {b} {c} -1").unwrap();
    }
    text + "0\n"
}

fn binary_ply() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.ply");
    write_ply(&pyramid(), &path).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn every_format_gives_the_same_mesh() {
    assert_eq!(read_obj(OBJ.as_bytes(), "t").unwrap(), pyramid());
    assert_eq!(read_ply(text_ply().as_bytes(), "t").unwrap(), pyramid());
    assert_eq!(read_ply(&binary_ply(), "t").unwrap(), pyramid());
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [("m.OBJ", OBJ.as_bytes()), ("m.ply", &binary_ply())] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(read(&path).unwrap(), pyramid());
    }
    let error = |name: &str| read(&folder.path().join(name)).unwrap_err().to_string();
    assert!(error("m.stl").contains("ends in .obj or .ply"));
    assert!(error("none.ply").contains("cannot read"));
}

#[test]
fn what_is_wrong_in_an_obj_is_said_with_its_line() {
    let refused = |from: &str, to: &str| {
        let changed = OBJ.replacen(from, to, 1);
        assert_ne!(changed, OBJ);
        read_obj(changed.as_bytes(), "t.obj")
            .unwrap_err()
            .to_string()
    };
    for (from, to, message) in [
        (
            "v 1 1 0",
            "v 1 1",
            "line 6, coordinate z is missing: expected a finite number",
        ),
        ("v 1 1 0", "v 1 nan 0", "line 6, coordinate y is nan"),
        ("v 1 1 0", "v 1e99 1 0", "line 6, coordinate x is 1e99"),
        (
            "f 2 3 5",
            "f 2 3",
            "line 17, face is 2 corners: expected 3 or more",
        ),
        ("f 2 3 5", "f 2 3 6", "line 17, vertex of a face is 6"),
        (
            "f 2 3 5",
            "f 2 3 0",
            "the number of one of the 5 vertices before",
        ),
        ("f 2 3 5", "f 2 3 -6", "vertex of a face is -6"),
        (
            "f 2 3 5",
            "f 2 3 -9223372036854775808",
            "vertex of a face is -92",
        ),
        ("f 2 3 5", "f 2 3 x", "vertex of a face is x"),
    ] {
        let error = refused(from, to);
        assert!(
            error.starts_with("t.obj: ") && error.contains(message),
            "{error}"
        );
    }
    let empty = read_obj(b"v 0 0 0\n", "t.obj").unwrap_err().to_string();
    assert_eq!(empty, "t.obj: faces is none: expected at least one");
}

#[test]
fn what_is_wrong_in_a_ply_is_said() {
    let text = text_ply();
    let refused = |from: &str, to: &str| {
        let changed = text.replacen(from, to, 1);
        assert_ne!(changed, text);
        read_ply(changed.as_bytes(), "t.ply")
            .unwrap_err()
            .to_string()
    };
    for (from, to, message) in [
        (
            "property float y",
            "property float w",
            "property `y` is missing",
        ),
        (
            "property float y",
            "property list int int y",
            "property `y` is a list",
        ),
        (
            "list uchar int vertex_index",
            "int vertex_index",
            "is a number: expected a list",
        ),
        ("vertex_index", "corners", "`vertex_indices` is missing"),
        (
            "element face 5",
            "element side 5",
            "element `face` is missing",
        ),
        ("element face 5", "element face 900", "declares at least"),
        ("4 0 3 2 1 0", "2 0 3 0", "face 0 is 2 corners"),
        (
            "4 0 3 2 1 0",
            "4 0 3 2 5 0",
            "vertex of a face is 5: expected below 5",
        ),
        ("4 0 3 2 1 0", "4 0 3 2 -1 0", "face 0, vertex is -1"),
        ("4 0 3 2 1 0", "4 0 3 2", "element `face` 0"),
        ("0.5 7 0.5 1", "0.5 7 1e300 1", "vertex 4, y is inf"),
        ("ply\n", "obj\n", "not a PLY file"),
    ] {
        let error = refused(from, to);
        assert!(
            error.starts_with("t.ply: ") && error.contains(message),
            "{error}"
        );
    }
}

/// A surface that nothing could ever be seen of is no surface.
#[test]
fn faces_on_a_line_are_refused() {
    let flat = "v 0 0 0\nv 1 1 1\nv 3 3 3\nf 1 2 3\nf 1 1 2\n";
    let error = read_obj(flat.as_bytes(), "t.obj").unwrap_err().to_string();
    assert_eq!(error, "t.obj: area of the faces is 0: expected a surface");
    let one = format!("{flat}v 0 1 0\nf 1 2 4\n");
    assert!(read_obj(one.as_bytes(), "t.obj").is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Whatever becomes of a file, it is read, or one line says what is wrong.
    #[test]
    fn damaged_files_are_read_or_refused(
        which in 0usize..3,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0u8..4), 1..6),
    ) {
        let mut bytes = match which {
            0 => OBJ.as_bytes().to_vec(),
            1 => text_ply().into_bytes(),
            _ => binary_ply_bytes().to_vec(),
        };
        for (at, value, how) in changes {
            if bytes.is_empty() {
                break;
            }
            let at = at.index(bytes.len());
            match how {
                0 => bytes[at] = value,
                1 => bytes.insert(at, value),
                2 => drop(bytes.remove(at)),
                _ => bytes.truncate(at),
            }
        }
        let read = if which == 0 { read_obj } else { read_ply };
        match read(&bytes, "t") {
            Ok(mesh) => prop_assert!(mesh.triangles().len() <= bytes.len()),
            Err(error) => {
                let text = error.to_string();
                prop_assert!(text.starts_with("t: ") && !text.contains('\n'), "{text}");
            }
        }
    }
}

fn binary_ply_bytes() -> &'static [u8] {
    static BYTES: std::sync::LazyLock<Vec<u8>> = std::sync::LazyLock::new(binary_ply);
    &BYTES
}
