//! Files of the hard scenes, and of cameras that see them.

use std::fs;
use std::path::{Path, PathBuf};

use potamoi_analysis::hard_cases::pictures::{FOCAL, HardScene, SIZE};

/// Writes it as a PLY file, a path of cameras, and a description that names both.
pub(crate) fn write(scene: &HardScene, folder: &Path, cameras: &str) -> PathBuf {
    let names = [
        "x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3",
        "opacity", "f_dc_0", "f_dc_1", "f_dc_2",
    ];
    let count = scene.gaussians.len();
    let mut bytes =
        format!("ply\nformat binary_little_endian 1.0\nelement vertex {count}\n").into_bytes();
    for name in names {
        bytes.extend(format!("property float {name}\n").bytes());
    }
    bytes.extend(b"end_header\n");
    for g in &scene.gaussians {
        let values = g.mean.iter().chain(&g.log_scale).chain(&g.rotation);
        for value in values.chain([&g.logit]).chain(&g.colour) {
            bytes.extend(value.to_le_bytes());
        }
    }
    fs::write(folder.join(format!("{}.ply", scene.name)), bytes).unwrap();
    let json = format!("{}.json", scene.name);
    fs::write(folder.join(&json), cameras).unwrap();
    let path = folder.join(format!("{}.toml", scene.name));
    let text = format!(
        "[model]\nkind = \"splats\"\npath = \"{}.ply\"\n\
         [camera]\nkind = \"opencv-json\"\npath = \"{json}\"\nindex = 0\n",
        scene.name
    );
    fs::write(&path, text).unwrap();
    path
}

/// A camera file: a place and a turn about y, in degrees, for each frame.
pub(crate) fn cameras(poses: &[([f64; 3], f64)]) -> String {
    let one = |(place, turn): &([f64; 3], f64)| {
        let (s, c) = turn.to_radians().sin_cos();
        let [width, height] = SIZE;
        format!(
            "{{\"width\": {width}, \"height\": {height}, \"fx\": {FOCAL}, \"fy\": {FOCAL}, \
             \"position\": {place:?}, \
             \"rotation\": [[{c}, 0.0, {s}], [0.0, 1.0, 0.0], [{}, 0.0, {c}]]}}",
            -s
        )
    };
    let all: Vec<String> = poses.iter().map(one).collect();
    format!("[{}]", all.join(",\n"))
}
