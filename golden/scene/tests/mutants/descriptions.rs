//! Scenes, configurations, traces and meshes.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use potamoi_base::camera::Camera;
use potamoi_formats::config::{Config, PRESETS, rules};
use potamoi_reference::trace_recorder::Limits;
use potamoi_reference::{GatherTask, ReferenceUnits, Units as _};
use potamoi_scene::Scene;
use potamoi_scene::trace::Trace;
use potamoi_warp::mesh;
use zip::CompressionMethod;

use crate::frame::tree::Tree;
use crate::frame::{Format, Rng, Verdict, flat, npy, ply, text, tree, zips};
use crate::pictures::{picture, single};
use crate::splats::small_ply;

/// Of stored voxels, which take long to make.
const LANTERN: &str = "[model]\nkind = \"builtin\"\nname = \"lantern\"\n[camera]\nkind = \"orbit\"\n\
    azimuth = 30.0\nwidth = 64\nheight = 48\n[render]\nbackground = [0.1, 0.2, 0.3]\n\
    halo = \"split\"\nstep = 1.0\ngroup_side = 16\nstop_below = 0.01\n";
const SCENES: [&str; 5] = [
    "[model]\nkind = \"dvgo\"\npath = \"a.tar\"\n[camera]\nkind = \"orbit\"\nazimuth = 30.0\n\
     elevation = 20.0\ndistance = 3.0\nfov = 40.0\ntarget = [0.0, 0.0, 0.5]\nwidth = 64\nheight = 48\n\
     [render]\nbackground = [0.1, 0.2, 0.3]\nhalo = \"split\"\n",
    "[model]\nkind = \"splats\"\npath = \"a.ply\"\n[camera]\nkind = \"transforms\"\n\
     path = \"transforms.json\"\nindex = 0\nwidth = 32\n[render]\nprofile = \"inria\"\n\
     background = [0.0, 0.0, 0.0]\norder = \"exact\"\ngroup_tiles = [2, 2]\ntransmittance_bits = 16\n",
    "[model]\nkind = \"splats\"\npath = \"a.ply\"\n[camera]\nkind = \"opencv-json\"\n\
     path = \"cameras.json\"\nindex = 0\nwidth = 32\nheight = 32\n[render]\nconic_bits = 12\n\
     alpha_min = 0.01\nstop_below = 0.001\n",
    "[model]\nkind = \"splats\"\npath = \"a.ply\"\n[camera]\nkind = \"colmap\"\npath = \".\"\nindex = 0\n",
    "[model]\nkind = \"splats\"\npath = \"a.ply\"\n[camera]\nkind = \"trajectory\"\n\
     path = \"way.txt\"\nformat = \"tum\"\nrate_hz = 30.0\nstart_s = 0.5\nduration_s = 1.0\n\
     scale = 0.5\nat = \"transforms.json\"\nindex = 0\nwidth = 32\n",
];
const BESIDE: [(&str, &[u8]); 6] = [
    (
        "a.tar",
        include_bytes!("../../../tests/fixtures/dvgo/tiny.tar"),
    ),
    (
        "transforms.json",
        br#"{"camera_angle_x": 0.69, "w": 40, "frames": [{"file_path": "a",
            "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]]}]}"#,
    ),
    (
        "cameras.json",
        br#"{"width": 64, "height": 48, "fx": 60.0, "fy": 60.0, "position": [0, 0, 4],
            "rotation": [[1, 0, 0], [0, -1, 0], [0, 0, -1]]}"#,
    ),
    (
        "cameras.txt",
        include_bytes!("../../../tests/fixtures/colmap/cameras.txt"),
    ),
    (
        "images.txt",
        include_bytes!("../../../tests/fixtures/colmap/images.txt"),
    ),
    (
        "way.txt",
        b"0 0 0 0 0 0 0 1\n1 0.5 0 0 0 0 0 1\n2 0.5 0.5 0 0 0 0.6 0.8\n",
    ),
];

fn beside(description: Vec<u8>) -> Vec<(String, Vec<u8>)> {
    let mut files = single("scene.toml", description);
    files.push(("a.ply".to_owned(), small_ply()));
    files.extend(BESIDE.map(|(name, bytes)| (name.to_owned(), bytes.to_vec())));
    files
}

fn scene(path: &Path) -> Verdict {
    Verdict::of(Scene::open(&path.to_string_lossy()), |scene| {
        if !scene.background().iter().all(|v| v.is_finite()) {
            return Err(format!("its background is {:?}", scene.background()));
        }
        picture(scene)
    })
}

/// Rules hold, and the units compute something of it.
fn config(path: &Path) -> Verdict {
    Verdict::of(Config::read(path), |config| {
        let breaches = rules::check(&config);
        if !breaches.is_empty() {
            return Err(format!("rules are broken: {breaches}"));
        }
        let vertices = *config.supported_vertices().first().ok_or("no vertices")?;
        let task = GatherTask {
            vertices,
            channels: 1,
            rows: vec![1; 8],
            entries: vec![potamoi_formats::rit::RitEntry {
                slot: 0,
                rows: [0; 8],
                weights: [0; 8],
            }],
        };
        let mut codes = vec![];
        // A task may be one that its unit refuses.
        let _ = ReferenceUnits::new(&config).gather(&[task], &mut codes);
        if config.hash().len() != 12 {
            return Err(format!("its hash is {}", config.hash()));
        }
        let text = toml::to_string(&config).map_err(|e| e.to_string())?;
        let again = Config::from_toml(&text, "again").map_err(|e| e.to_string())?;
        (again == config)
            .then_some(())
            .ok_or_else(|| "it is another when read again".to_owned())
    })
}

fn paper() -> Config {
    Config::from_toml("[gu]\nsums = \"exact\"\n", "test").expect("a configuration")
}

/// A trace of some entries and elements.
fn small_trace() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| {
        let mut scene = Scene::open("lantern").expect("a scene");
        scene.set_size(Some(8), Some(8)).expect("a size");
        let limits = Limits {
            entries: 20,
            elements: 200,
        };
        let trace = Trace::record(&scene, &paper(), limits).expect("a trace");
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("t.npz");
        trace.write(&path).expect("a file");
        std::fs::read(path).expect("its bytes")
    })
}

/// The members changed, mostly with digests and shapes that fit, as in a file that was forged.
fn mutated_trace(rng: &mut Rng) -> Vec<u8> {
    const HEADER: usize = 128;
    let mut members = zips::members(small_trace());
    let header = members
        .iter()
        .position(|(name, _)| name == "header.npy")
        .expect("a header");
    let mut json = Tree::of_json(&members[header].1[HEADER..]);
    for _ in 0..rng.few() {
        match rng.below(8) {
            0 => json.mutate(rng),
            1 => zips::mutate(&mut members, rng),
            _ => {
                let at = rng.below(members.len());
                if at != header {
                    npy::mutate(&mut members[at].1, rng);
                }
            }
        }
    }
    if !rng.one_in(6) {
        refit(&mut json, &members);
    }
    let text = json.json();
    if let Some((_, own)) = members.iter_mut().find(|(name, _)| name == "header.npy") {
        let head = format!(
            "{{'descr': '|u1', 'fortran_order': False, 'shape': ({},), }}",
            text.len()
        );
        *own = b"\x93NUMPY\x01\0v\0".to_vec();
        own.extend(format!("{head:117}\n").bytes());
        own.extend(text);
    }
    zips::packed(&members, CompressionMethod::Deflated)
}

/// Digests of what the members are now.
fn refit(json: &mut Tree, members: &[(String, Vec<u8>)]) {
    let Tree::Map(items) = json else { return };
    let arrays = items.iter_mut().find(|(key, _)| key == "arrays");
    let Some((_, Tree::List(arrays))) = arrays else {
        return;
    };
    for array in arrays {
        let Tree::Map(items) = array else { continue };
        let name = items.iter().find_map(|(key, value)| match value {
            Tree::Text(name) if key == "name" => Some(format!("{name}.npy")),
            _ => None,
        });
        let bytes = members.iter().find(|(own, _)| Some(own) == name.as_ref());
        let digest = items.iter_mut().find(|(key, _)| key == "digest");
        if let (Some((_, bytes)), Some((_, digest))) = (bytes, digest) {
            *digest = Tree::Text(blake3::hash(bytes).to_hex().to_string());
        }
    }
}

/// As many features and results as entries and operands.
fn trace(path: &Path) -> Verdict {
    Verdict::of(Trace::read(path, &paper()), |trace| {
        for own in &trace.gathered {
            let task = &own.task;
            if own.features.len() != task.entries.len() * task.channels {
                return Err("features and entries differ in number".to_owned());
            }
        }
        let even = trace
            .computed
            .iter()
            .all(|own| own.a.len() == own.b.len() && own.b.len() == own.out.len());
        even.then_some(())
            .ok_or_else(|| "operands and results differ in number".to_owned())
    })
}

const OBJ: &str = "# a pyramid\no thing\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.2 0.3 1.5\nvn 0 0 1\n\
                   f 1 3 2\nf 1/1/1 2/2/1 4/4/1\nf 2//1 3//1 4//1\nf -4 -1 -2\nf 1 2 3 4\n";

fn small_mesh() -> Vec<u8> {
    let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\n\
                      property float y\nproperty float z\nproperty uchar red\nelement face 2\n\
                      property list uchar int vertex_indices\nend_header\n"
        .to_vec();
    for corner in [
        [0.0f32, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.2, 0.3, 1.5],
    ] {
        bytes.extend(corner.iter().flat_map(|v| v.to_le_bytes()));
        bytes.push(200);
    }
    for face in [[0i32, 1, 2], [1, 2, 3]] {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes
}

fn mutated_mesh(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = ply::mutate(&small_mesh(), rng);
    if rng.one_in(4) {
        // The lists, which lie last.
        let at = bytes.len().saturating_sub(26) + 13 * rng.below(2);
        flat::field(
            &mut bytes,
            &[(at, flat::Kind::Whole(1)), (at + 1, flat::Kind::Whole(4))],
            rng,
        );
    }
    bytes
}

/// Corners that are there, and depths in front of a camera.
fn surface(path: &Path) -> Verdict {
    Verdict::of(mesh::read(path).map(|(mesh, _)| mesh), |mesh| {
        let count = mesh.vertices().len();
        if mesh
            .triangles()
            .as_flattened()
            .iter()
            .any(|corner| *corner as usize >= count)
        {
            return Err("a corner is not there".to_owned());
        }
        if mesh
            .vertices()
            .as_flattened()
            .iter()
            .any(|v| !v.is_finite())
        {
            return Err("a vertex is nowhere".to_owned());
        }
        let eye = glam::DVec3::new(3.0, 2.5, 2.0);
        let camera = Camera::look_at(eye, glam::DVec3::ZERO, glam::DVec3::Z, 0.8, 8, 8);
        let depths = mesh.depth(&camera);
        let sound = depths.iter().all(|d| *d > 0.0);
        sound
            .then_some(())
            .ok_or_else(|| format!("depths are {depths:?}"))
    })
}

pub(crate) fn formats() -> Vec<Format> {
    type Mutant = fn(&mut Rng) -> Vec<u8>;
    let one = |name, file: &'static str, whole: fn() -> Vec<u8>, mutant: Mutant, judge| Format {
        name,
        binary: super::BINARY,
        whole: Arc::new(move || single(file, whole())),
        mutant: Arc::new(move |rng| single(file, mutant(rng))),
        judge,
    };
    let preset = |rng: &mut Rng| {
        let (_, text) = rng.pick(&PRESETS);
        let mut tree = Tree::of_toml(text);
        (0..rng.few()).for_each(|_| tree.mutate(rng));
        tree::around(tree.toml(), rng)
    };
    vec![
        Format {
            name: "scene_toml",
            binary: super::BINARY,
            whole: Arc::new(|| beside(SCENES[0].into())),
            mutant: Arc::new(|rng| {
                let text = if rng.one_in(40) {
                    LANTERN
                } else {
                    *rng.pick(&SCENES)
                };
                beside(tree::toml(text, rng))
            }),
            judge: scene,
        },
        one(
            "configuration",
            "c.toml",
            || PRESETS[1].1.into(),
            preset,
            config,
        ),
        one(
            "trace",
            "t.npz",
            || small_trace().to_vec(),
            mutated_trace,
            trace,
        ),
        one(
            "obj",
            "a.obj",
            || OBJ.into(),
            |rng| text::mutate(OBJ, rng),
            surface,
        ),
        one("mesh_ply", "a.ply", small_mesh, mutated_mesh, surface),
    ]
}
