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
    assert_eq!(read_obj(OBJ.as_bytes(), "t").unwrap().0, pyramid());
    assert_eq!(read_ply(text_ply().as_bytes(), "t").unwrap().0, pyramid());
    assert_eq!(read_ply(&binary_ply(), "t").unwrap().0, pyramid());
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [("m.OBJ", OBJ.as_bytes()), ("m.ply", &binary_ply())] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(read(&path).unwrap().0, pyramid());
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
        ("f 2 3 5", "f 2/x 3 5", "line 17, corner of a face is 2/x"),
        ("f 2 3 5", "f 2//0 3 5", "line 17, corner of a face is 2//0"),
        (
            "f 2 3 5",
            "f 2/1/1/1 3 5",
            "corner of a face is 2/1/1/1: expected numbers of a vertex, a texture",
        ),
        (
            "f 2 3 5",
            "f 2 7 6",
            "vertex of a face is 7: expected the number of one of the 5 vertices",
        ),
        (
            "f 2 3 5",
            "f 2 3 4294967297",
            "vertex of a face is 4294967297",
        ),
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
        (
            "float y",
            "ushort y",
            "property `y` is ushort: expected float",
        ),
        (
            "float y",
            "uint8 y",
            "property `y` is uchar: expected float",
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
        ("0.5 7 0.5 1", "0.5 7 1e300 1", "vertex 4, y is 1e300"),
        ("ply\n", "obj\n", "not a PLY file"),
    ] {
        let error = refused(from, to);
        assert!(
            error.starts_with("t.ply: ") && error.contains(message),
            "{error}"
        );
    }
}

/// Lines of any end, after a byte-order mark: no vertex is lost, so that no number of one means
/// another.
#[test]
fn ends_of_lines_and_marks_do_no_harm() {
    let text = OBJ.replace("\r\n", "\n");
    for end in ["\n", "\r", "\r\n"] {
        let ended = text.replace('\n', end);
        for mark in ["", "\u{feff}"] {
            let (mesh, _) = read_obj(format!("{mark}{ended}").as_bytes(), "t").unwrap();
            assert_eq!(mesh, pyramid(), "{end:?}");
            // The mark stands before the first vertex, too.
            let first = format!("{mark}v 0 0 0{end}v 1 0 0{end}v 0 1 0{end}f 1 2 3{end}f 3 2 1");
            let (mesh, _) = read_obj(first.as_bytes(), "t").unwrap();
            assert_eq!(mesh.triangles(), [[0, 1, 2], [2, 1, 0]]);
        }
        let wrong = ended.replacen("v 1 1 0", "v 1 1", 1);
        let error = read_obj(wrong.as_bytes(), "t").unwrap_err().to_string();
        assert!(error.contains("line 6, coordinate z is missing"), "{error}");
        let ply = text_ply().replace('\n', end);
        assert_eq!(read_ply(ply.as_bytes(), "t").unwrap().0, pyramid());
    }
    let whole = text.trim_end().to_owned() + " \\";
    assert_eq!(read_obj(whole.as_bytes(), "t").unwrap().0, pyramid());
}

#[test]
fn vertices_may_come_behind_their_faces() {
    let is_face = |line: &&str| line.starts_with('f') && !line.contains('-');
    let whole = OBJ.replace("\\\n", " ").replace("f 1 2 -1", "f 1 2 5");
    let whole = whole.replace("f -3 4 5", "f 3 4 5");
    let (faces, others): (Vec<_>, Vec<_>) = whole.lines().partition(is_face);
    assert_eq!(faces.len(), 5);
    let turned = [faces.join("\n"), others.join("\n")].join("\n");
    assert_eq!(read_obj(turned.as_bytes(), "t").unwrap().0, pyramid());
    // Those told from the end are told from where the face stands.
    let error = read_obj(b"f -3 -2 -1\nv 0 0 0\nv 1 0 0\nv 0 1 0\n", "t").unwrap_err();
    let said =
        "t: line 1, vertex of a face is -3: expected the number of one of the 0 vertices before";
    assert_eq!(error.to_string(), said);
}

#[test]
fn what_is_not_used_is_listed_and_other_surfaces_are_refused() {
    let obj = |text: &str| read_obj(text.as_bytes(), "t.obj");
    let listed = |text: &str| obj(text).unwrap().1.not_used().to_vec();
    let words = [
        "# (comments)",
        "mtllib",
        "o",
        "vt",
        "vn",
        "g",
        "usemtl",
        "texture of f",
        "normal of f",
        "s",
    ];
    assert_eq!(listed(OBJ), words);
    let more = "v 0 0 0 2\nv 1 0 0 0 1 0\nv 0 1 0 1\nf 1 2 3\nl 1 2\np 1\ncurv2 1\nnews 3\nl 2 1\n";
    let words = ["weight of v", "colour of v", "l", "p", "curv2", "news"];
    assert_eq!(listed(more), words);
    for word in ["surf", "fo", "call", "V", "F"] {
        let error = obj(&format!("{more}{word} 1 2 3\n"))
            .unwrap_err()
            .to_string();
        let said = format!("t.obj: `{word}` cannot be honoured");
        assert!(error.starts_with(&said), "{error}");
    }
    let (_, notes) = read_ply((text_ply() + "more 1\n").as_bytes(), "t").unwrap();
    let expected = [
        "vertex/red",
        "face/flags",
        "element edge",
        "comment c",
        "bytes after the last element (5)",
    ];
    assert_eq!(notes.not_used(), expected);
    let strips = text_ply().replace("element edge", "element tristrips");
    let error = read_ply(strips.as_bytes(), "t.ply")
        .unwrap_err()
        .to_string();
    assert!(error.contains("`element tristrips` cannot"), "{error}");
    assert!(
        read_ply(&binary_ply(), "t")
            .unwrap()
            .1
            .not_used()
            .is_empty()
    );
}

/// Corners a millimetre apart, five hundred kilometres from the origin.
#[test]
fn meshes_that_floats_do_not_hold_are_refused() {
    let text = |far: f64| {
        let at = |x: f64, y: f64| format!("v {:?} {y} 0\n", far + x);
        format!(
            "{}{}{}f 1 2 3\n",
            at(0.0, 0.0),
            at(0.001, 0.0),
            at(0.0, 0.001)
        )
    };
    let error = read_obj(text(500_000.0).as_bytes(), "t").unwrap_err();
    let error = error.to_string();
    assert!(
        error.starts_with("t: a coordinate is 500000.001: expected coordinates nearer"),
        "{error}"
    );
    assert!(read_obj(text(0.5).as_bytes(), "t").is_ok());
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
            Ok((mesh, _)) => prop_assert!(mesh.triangles().len() <= bytes.len()),
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
