//! glTF, by splat-transform's writer, by hand, and damaged.

use glam::DVec3;
use serde_json::{Value, json};

use super::near::{Near, check, first};
use super::*;
use crate::Axes;

const EXACT: Near = Near {
    mean: 0.0,
    size: 1e-6,
    rotation: 1e-6,
    opacity: 1e-6,
    constant: 1e-6,
    rest: 1e-6,
};

/// The JSON and the buffer of a `.glb`.
fn split(bytes: &[u8]) -> (Value, Vec<u8>) {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    (json, bytes[28 + length..].to_vec())
}

/// A `.glb` of them.
fn joined(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let length = 12 + 8 + text.len() + 8 + binary.len();
    let mut all = b"glTF".to_vec();
    all.extend(
        [2u32, length as u32, text.len() as u32]
            .map(u32::to_le_bytes)
            .concat(),
    );
    all.extend(b"JSON");
    all.extend(text);
    all.extend((binary.len() as u32).to_le_bytes());
    all.extend(b"BIN\0");
    all.extend(binary);
    all
}

fn few() -> (Value, Vec<u8>) {
    split(&fixture("few.glb"))
}

fn loaded(bytes: &[u8]) -> crate::Loaded {
    super::super::gltf::parse(bytes, Path::new(""), "f").unwrap()
}

#[track_caller]
fn refused(bytes: &[u8], expected: &str) {
    let error =
        super::super::gltf::parse(bytes, Path::new("/nowhere"), "t.glb").map(|own| own.cloud.len());
    let text = error.map_or_else(
        |e| e.to_string(),
        |_| panic!("read, not refused for: {expected}"),
    );
    assert!(
        text.starts_with("t.glb: ") && !text.contains('\n'),
        "{text}"
    );
    assert!(text.contains(expected), "{text} / {expected}");
}

#[test]
fn what_splat_transform_writes_is_the_original() {
    let own = loaded(&fixture("few.glb"));
    check(&own.cloud, &first(60), &EXACT);
    assert_eq!(own.facts.version.as_deref(), Some("2.0"));
    assert_eq!(
        own.facts.generator.as_deref(),
        Some("splat-transform 3.7.0")
    );
    let listed = ["accessors.min", "accessors.max"];
    assert!(
        listed
            .iter()
            .all(|key| own.notes.not_used().contains(&(*key).to_owned()))
    );
    assert!(
        own.notes
            .not_used()
            .contains(&"attributes.COLOR_0".to_owned())
    );
    assert_eq!(
        own.notes.assumed(),
        [
            "Gaussians in order of depth, not of their distance to the camera",
            "axes left-up-front",
        ]
    );
}

/// The same as text with a buffer in it, and with a file beside it.
#[test]
fn buffers_are_found_wherever_they_are() {
    use base64::Engine as _;
    let (mut json, binary) = few();
    let expected = loaded(&fixture("few.glb")).cloud;
    let text = base64::engine::general_purpose::STANDARD.encode(&binary);
    json["buffers"][0]["uri"] = format!("data:application/octet-stream;base64,{text}").into();
    assert_eq!(loaded(json.to_string().as_bytes()).cloud, expected);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b.bin"), &binary).unwrap();
    json["buffers"][0]["uri"] = "a%20b.bin".into();
    let file = folder.path().join("a.GLTF");
    std::fs::write(&file, json.to_string()).unwrap();
    let own = read(&file, None).unwrap();
    assert_eq!(own.cloud, expected);
    let length = std::fs::metadata(&file).unwrap().len();
    assert_eq!(own.facts.bytes, length + binary.len() as u64);
    for outside in [
        "../a.bin",
        "/etc/passwd",
        "http://a/b",
        "data:,abc",
        "data:a;base64,***",
    ] {
        json["buffers"][0]["uri"] = outside.into();
        refused(json.to_string().as_bytes(), "buffers[0].uri is `");
    }
    json["buffers"][0].as_object_mut().unwrap().remove("uri");
    refused(json.to_string().as_bytes(), "buffers[0].uri is missing");
}

/// Codes of every type that the extension allows, of values that they hold.
#[test]
fn components_of_every_type_are_read() {
    let build = |codes: [(usize, bool); 4]| {
        let mut binary = vec![];
        let mut accessors = vec![];
        let mut views = vec![];
        let values: [&[f64]; 4] = [
            &[1.0, 0.0, 1.0],
            &[0.0, 1.0, 0.0, 0.0],
            &[1.0, 0.0, 1.0],
            &[1.0],
        ];
        let all = values
            .into_iter()
            .zip(codes)
            .chain([(&[0.5, -0.25, 0.125][..], (5126, false))]);
        for (values, (kind, normalised)) in all {
            let start = binary.len();
            for value in values {
                let most = match kind {
                    5120 => 127.0,
                    5121 => 255.0,
                    5122 => 32767.0,
                    _ => 65535.0,
                };
                let code = if normalised { value * most } else { *value };
                match kind {
                    5120 => binary.extend((code as i8).to_le_bytes()),
                    5121 => binary.push(code as u8),
                    5122 => binary.extend((code as i16).to_le_bytes()),
                    5123 => binary.extend((code as u16).to_le_bytes()),
                    _ => binary.extend((*value as f32).to_le_bytes()),
                }
            }
            let length = binary.len() - start;
            binary.resize(binary.len().next_multiple_of(4), 0);
            views.push(json!({"buffer": 0, "byteOffset": start, "byteLength": length}));
            let shape = ["", "SCALAR", "", "VEC3", "VEC4"][values.len()];
            accessors.push(json!({
                "bufferView": accessors.len(), "componentType": kind, "normalized": normalised, "count": 1,
                "type": shape,
            }));
        }
        let own = |name: &str| format!("KHR_gaussian_splatting:{name}");
        let document = json!({
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": binary.len()}],
            "bufferViews": views,
            "accessors": accessors,
            "meshes": [{"primitives": [{
                "mode": 0,
                "attributes": {
                    "POSITION": 0, own("ROTATION"): 1, own("SCALE"): 2, own("OPACITY"): 3,
                    own("SH_DEGREE_0_COEF_0"): 4,
                },
                "extensions": {"KHR_gaussian_splatting": {}},
            }]}],
            "nodes": [{"mesh": 0}],
        });
        joined(&document, &binary)
    };
    const FLOAT: (usize, bool) = (5126, false);
    let expected = loaded(&build([FLOAT; 4]));
    assert_eq!(expected.cloud.opacity_logits(), [f32::INFINITY]);
    assert_eq!(
        expected.cloud.log_scales()[0],
        [0.0, f32::MIN_POSITIVE.ln(), 0.0]
    );
    assert_eq!(expected.facts.clamped[0].1, 1);
    for codes in [
        [(5120, true), (5120, true), (5121, true), (5121, true)],
        [(5120, false), (5122, true), (5121, false), (5123, true)],
        [(5121, true), FLOAT, (5123, true), FLOAT],
        [(5123, false), FLOAT, (5123, false), FLOAT],
        [(5122, true), FLOAT, FLOAT, FLOAT],
    ] {
        assert_eq!(loaded(&build(codes)).cloud, expected.cloud, "{codes:?}");
    }
    for (codes, expected) in [
        (
            [(5125, false), FLOAT, FLOAT, FLOAT],
            "POSITION is VEC3 of components 5125",
        ),
        (
            [FLOAT, (5121, true), FLOAT, FLOAT],
            "ROTATION is VEC4 of components 5121, normalised",
        ),
        (
            [FLOAT, (5120, false), FLOAT, FLOAT],
            "ROTATION is VEC4 of components 5120",
        ),
        (
            [FLOAT, FLOAT, (5120, false), FLOAT],
            "signed ones are of a draft",
        ),
        (
            [FLOAT, FLOAT, FLOAT, (5121, false)],
            "OPACITY is SCALAR of components 5121",
        ),
    ] {
        refused(&build(codes), expected);
    }
    let assumed = expected.notes.assumed().join("; ");
    assert!(
        assumed.contains("kernel ellipse") && assumed.contains("all nodes"),
        "{assumed}"
    );
}

/// Nodes place meshes, one above another.
#[test]
fn nodes_place_their_meshes() {
    let (mut json, binary) = few();
    // A quarter of a turn about z.
    let half_turn = std::f64::consts::FRAC_1_SQRT_2;
    json["nodes"] = json!([
        {"mesh": 0, "translation": [1.0, 2.0, 3.0]},
        {"children": [0], "scale": [2.0, 2.0, 2.0], "rotation": [0.0, 0.0, half_turn, half_turn]},
    ]);
    json["scenes"] = json!([{"nodes": [1]}]);
    let own = loaded(&joined(&json, &binary));
    let plain = loaded(&fixture("few.glb"));
    // In the axes of glTF: moved, scaled, then turned from x to y.
    let to_file = |own: [f32; 3]| Axes::LEFT_UP_FRONT.point_of_file(own).map(f64::from);
    for (after, before) in own.cloud.means().iter().zip(plain.cloud.means()) {
        let [x, y, z] = to_file(*before);
        let moved = DVec3::new(x + 1.0, y + 2.0, z + 3.0) * 2.0;
        let expected = DVec3::new(-moved.y, moved.x, moved.z);
        assert!((DVec3::from(to_file(*after)) - expected).length() < 1e-5);
    }
    let [a, b] = [&own, &plain].map(|own| f64::from(own.cloud.log_scales()[0][0]));
    assert!((a - b - 2f64.ln()).abs() < 1e-6);
    // Twice the same mesh, and one that is not shown.
    json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "translation": [9.0, 0.0, 0.0]}]);
    json["scenes"] = json!([{"nodes": [0, 1]}]);
    let hidden = json["meshes"][0].clone();
    json["meshes"].as_array_mut().unwrap().push(hidden);
    let own = loaded(&joined(&json, &binary));
    assert_eq!(own.cloud.len(), 120);
    assert!(
        own.notes
            .not_used()
            .contains(&"meshes that the scene does not show (1)".to_owned())
    );
    // So far away that floats would lose what is between the Gaussians.
    json["nodes"] = json!([{"mesh": 0, "translation": [4e6, 0.0, -5e6]}]);
    json["scenes"] = json!([{"nodes": [0]}]);
    let own = loaded(&joined(&json, &binary));
    assert_eq!(own.cloud, plain.cloud);
    assert_eq!(own.origin, DVec3::new(-4e6, 0.0, -5e6));
    for (node, expected) in [
        (
            json!({"mesh": 0, "scale": [1.0, 2.0, 1.0]}),
            "is a stretch or a shear",
        ),
        (json!({"mesh": 0, "scale": [1.0, 1.0, -1.0]}), "is a mirror"),
        (json!({"mesh": 0, "scale": [0.0, 0.0, 0.0]}), "is flat"),
        (
            json!({"mesh": 0, "rotation": [0.0, 0.0, 0.0, 2.0]}),
            "nodes[0].rotation is of length 2",
        ),
        (
            json!({"mesh": 0, "matrix": [0], }),
            "nodes[0].matrix is a list of 1: expected 16",
        ),
        (
            json!({"mesh": 0, "skin": 0}),
            "`nodes.skin` cannot be honoured",
        ),
        (
            json!({"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {}}}),
            "EXT_mesh_gpu_instancing` cannot be honoured",
        ),
        (json!({"mesh": 7}), "nodes[0].mesh is 7"),
        (
            json!({"mesh": 0, "children": [0]}),
            "nodes[0] is reached twice",
        ),
        (json!({"mesh": 0, "children": [5]}), "index of a node is 5"),
    ] {
        json["nodes"] = json!([node]);
        refused(&joined(&json, &binary), expected);
    }
}

/// A `.glb` with an SPZ file of the fixtures.
fn with_spz(spz: &[u8], extension: &str, count: usize) -> Vec<u8> {
    let document = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_gaussian_splatting", extension],
        "extensionsRequired": ["KHR_gaussian_splatting", extension],
        "buffers": [{"byteLength": spz.len()}],
        "bufferViews": [{"buffer": 0, "byteLength": spz.len()}],
        "accessors": [{"componentType": 5126, "count": count, "type": "VEC3"}],
        "meshes": [{"primitives": [{
            "mode": 0,
            "attributes": {"POSITION": 0},
            "extensions": {"KHR_gaussian_splatting": {
                "kernel": "ellipse", "colorSpace": "srgb_rec709_display", "sortingMethod": "zDepth",
                "extensions": {extension: {"bufferView": 0}},
            }},
        }]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    });
    joined(&document, spz)
}

#[test]
fn an_spz_file_is_what_it_is_by_itself() {
    for (file, version) in [
        ("cloud.v2.spz", "2"),
        ("cloud.v3.spz", "3"),
        ("cloud.v4.spz", "4"),
    ] {
        let spz = fixture(file);
        for extension in [
            "KHR_gaussian_splatting_compression_spz_2",
            "KHR_gaussian_splatting_compression_spz",
        ] {
            let own = loaded(&with_spz(&spz, extension, COUNT));
            assert_eq!(own.cloud, spz_cloud(&spz, "f").unwrap());
            let inside = own
                .facts
                .more
                .iter()
                .find(|(name, _)| name == "SPZ inside")
                .unwrap();
            assert_eq!(inside.1, format!("version {version}"));
        }
    }
    let two = "KHR_gaussian_splatting_compression_spz_2";
    refused(
        &with_spz(&fixture("cloud.v2.spz"), two, 7),
        "accessors[0].count is 7: expected 300",
    );
    refused(
        &with_spz(b"nothing at all", two, 7),
        "SPZ of bufferViews[0]: gzip stream",
    );
}

#[test]
fn each_defect_is_told() {
    let (good, binary) = few();
    let changed = |change: &dyn Fn(&mut Value)| {
        let mut json = good.clone();
        change(&mut json);
        joined(&json, &binary)
    };
    let at = |pointer: &'static str, value: Value| {
        changed(&|json| *json.pointer_mut(pointer).unwrap() = value.clone())
    };
    let extension = "/meshes/0/primitives/0/extensions/KHR_gaussian_splatting";
    let attributes = "/meshes/0/primitives/0/attributes";
    let with = |pointer: &'static str, key: &'static str, value: Value| {
        changed(&|json| {
            let object = json.pointer_mut(pointer).unwrap().as_object_mut().unwrap();
            object.insert(key.to_owned(), value.clone());
        })
    };
    for (bytes, expected) in [
        (at("/asset/version", json!("1.0")), "asset.version is `1.0`"),
        (
            with("", "extensionsRequired", json!(["EXT_meshopt_compression"])),
            "`EXT_meshopt_compression`",
        ),
        (
            with(extension, "kernel", json!("cone")),
            "KHR_gaussian_splatting.kernel is `cone`",
        ),
        (
            with(extension, "colorSpace", json!("lin_rec709_display")),
            "is `lin_rec709_display`",
        ),
        (
            with(extension, "projection", json!("orthographic")),
            "projection is `orthographic`",
        ),
        (
            with(extension, "sortingMethod", json!("random")),
            "sortingMethod is `random`",
        ),
        (
            at("/meshes/0/primitives/0/mode", json!(4)),
            "meshes[0].primitives[0].mode is 4",
        ),
        (
            with("/meshes/0/primitives/0", "indices", json!(0)),
            "`primitive.indices` cannot be honoured",
        ),
        (
            with("/meshes/0/primitives/0", "targets", json!([])),
            "`primitive.targets` cannot be",
        ),
        (
            with(
                attributes,
                "KHR_gaussian_splatting:SH_DEGREE_4_COEF_0",
                json!(0),
            ),
            "out of sequence",
        ),
        (
            with(attributes, "KHR_gaussian_splatting:GLOW", json!(0)),
            "GLOW` cannot be honoured",
        ),
        (
            with(attributes, "KHR_gaussian_splatting:SCALE", json!(99)),
            "SCALE is 99: expected below",
        ),
        (
            changed(&|json| {
                let all = json
                    .pointer_mut(attributes)
                    .unwrap()
                    .as_object_mut()
                    .unwrap();
                all.remove("KHR_gaussian_splatting:SH_DEGREE_2_COEF_3");
            }),
            "SH_DEGREE_2_COEF_3 is missing",
        ),
        (
            changed(&|json| {
                let all = json
                    .pointer_mut(attributes)
                    .unwrap()
                    .as_object_mut()
                    .unwrap();
                all.remove("KHR_gaussian_splatting:SH_DEGREE_1_COEF_0");
            }),
            "out of sequence",
        ),
        (
            at("/accessors/0/count", json!(0)),
            "accessors[0].count is 0 elements",
        ),
        (
            at("/accessors/0/count", json!(61)),
            "accessors[0].count is 61 elements of 12 bytes",
        ),
        (
            at("/accessors/3/count", json!(59)),
            "elements of an attribute is 59: expected 60",
        ),
        (
            with("/accessors/0", "sparse", json!({})),
            "`accessors.sparse` cannot be honoured",
        ),
        (
            at("/accessors/0/byteOffset", json!(u64::MAX)),
            "accessors[0].count",
        ),
        (
            at("/accessors/0/bufferView", json!(99)),
            "accessors[0].bufferView is 99",
        ),
        (
            with("/bufferViews/0", "byteStride", json!(4)),
            "bufferViews[0].byteStride is 4",
        ),
        (
            at("/bufferViews/0/byteLength", json!(99999)),
            "bufferViews[0].byteLength is 99999 from 0 on",
        ),
        (
            at("/bufferViews/0/buffer", json!(1)),
            "bufferViews[0].buffer is 1",
        ),
        (
            at("/buffers/0/byteLength", json!(999_999)),
            "bytes of buffers[0]",
        ),
        (at("/scene", json!(3)), "scene is 3"),
        (at("/nodes", json!([])), "index of a node is 0"),
        (at("/meshes", json!([])), "nodes[0].mesh is 0"),
        (
            at("/meshes/0/primitives/0/extensions", json!({})),
            "Gaussians is missing",
        ),
        (
            at(
                "/meshes/0/primitives/0/extensions",
                json!({"KHR_spz_gaussian_splats_compression": {}}),
            ),
            "a draft that others follow otherwise",
        ),
        (
            at("/accessors", json!(7)),
            "accessors is 7: expected a list of objects",
        ),
    ] {
        refused(&bytes, expected);
    }
    let whole = fixture("few.glb");
    let set = |at: usize, value: &[u8]| {
        let mut bytes = whole.clone();
        bytes[at..at + value.len()].copy_from_slice(value);
        bytes
    };
    for (bytes, expected) in [
        (set(4, &[1]), "version of the container is 1"),
        (set(8, &[255, 255, 255]), "length that the header states"),
        (set(12, &[255, 255, 255]), "chunk 0: length"),
        (set(16, b"BIN\0"), "chunk 0 is BIN"),
        (whole[..10].to_vec(), "length in bytes is 10"),
        (whole[..3000].to_vec(), "length that the header states"),
        (
            b"{\"asset\": 1, \"asset\": 2}".to_vec(),
            "field `asset` is given twice",
        ),
        (b"{".to_vec(), "JSON: line 1, column 1"),
    ] {
        refused(&bytes, expected);
    }
    let after = loaded(&[whole, vec![1, 2]].concat());
    assert!(
        after
            .notes
            .not_used()
            .contains(&"bytes after the container (2)".to_owned())
    );
}
