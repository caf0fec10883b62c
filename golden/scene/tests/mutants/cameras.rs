//! Cameras, paths of cameras, and image sequences.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use image::{DynamicImage, ImageFormat, Rgb32FImage, RgbaImage};
use potamoi_base::file_keys::Notes;
use potamoi_scene::trajectory::{self, FileFacts};
use potamoi_scene::{Images, camera_file, colmap, transforms};
use potamoi_warp::Renderer as _;

use crate::frame::{Files, Format, Rng, Verdict, text, tree};
use crate::pictures::{camera, single};

const CAMERAS: &[u8] = br#"[
  {"id": 0, "img_name": "a", "width": 64, "height": 48, "fx": 60.5, "fy": 61.0, "cx": 32.0, "cy": 24.5,
   "position": [0.5, -1.0, 2.0], "rotation": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
   "background": [0.1, 0.2, 0.3]},
  {"id": 1, "img_name": "b", "width": 64, "height": 48, "fx": 60.5, "fy": 61.0,
   "position": [0.0, 0.0, 3.5], "rotation": [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]}
]"#;

const TRANSFORMS: &[u8] = br#"{
  "fl_x": 6.5, "fl_y": 6.25, "cx": 3.0, "cy": 2.0, "w": 6, "h": 4, "k1": 0.0, "aabb_scale": 1,
  "frames": [
    {"file_path": "train/a", "rotation": 0.01,
     "transform_matrix": [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]},
    {"file_path": "train/b.png",
     "transform_matrix": [[0.6, -0.8, 0, 0.5], [0.8, 0.6, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]}
  ]
}"#;

const ANGLES: &[u8] = br#"{
  "camera_angle_x": 0.69,
  "frames": [
    {"file_path": "./r_0", "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]]}
  ]
}"#;

/// Text that both files of a reconstruction are of.
const COLMAP: [(&str, &str); 2] = [
    (
        "cameras.txt",
        include_str!("../../../tests/fixtures/colmap/cameras.txt"),
    ),
    (
        "images.txt",
        include_str!("../../../tests/fixtures/colmap/images.txt"),
    ),
];

const TUM: &str = "# timestamp tx ty tz qx qy qz qw\n\
    1311868163.8697 -0.1357 -1.4217 1.4764 0.0 0.0 0.0 1.0\n\
    1311868163.9031 -0.1360 -1.4227 1.4768 0.0 0.0 0.0199 0.9998\n\
    1311868163.9364 -0.1366 -1.4240 1.4771 0.0 0.0 0.0399 0.9992\n";

const EUROC: &str = "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], \
    q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1]\n\
    1403636580838555648,4.68,-1.78,0.78,1.0,0.0,0.0,0.0,-0.02\n\
    1403636580843555328,4.69,-1.78,0.79,0.9998,0.0,0.0,0.0199,-0.02\n";

/// Poses, and their times beside them.
const KITTI: [(&str, &str); 2] = [
    (
        "00.txt",
        "1 0 0 0 0 1 0 0 0 0 1 0\n0.6 0 0.8 -0.04 0 1 0 -0.02 -0.8 0 0.6 0.86\n",
    ),
    ("times.txt", "0.000000e+00\n1.036224e-01\n"),
];

const REPLICA: &str =
    "1 0 0 0.5 0 1 0 0 0 0 1 2 0 0 0 1\n0.6 -0.8 0 0.5 0.8 0.6 0 0 0 0 1 2 0 0 0 1\n";

/// Times go forward, and the camera is somewhere in between.
fn trajectory(path: &Path) -> Verdict {
    let read = trajectory::read(path, &FileFacts::default(), &mut Notes::default());
    Verdict::of(read, |found| {
        let samples = found.samples();
        let forward = samples.windows(2).all(|w| w[0].seconds < w[1].seconds);
        if samples.len() < 2 || !forward {
            return Err(format!("its times are those of {samples:?}"));
        }
        for sample in samples.iter().take(100) {
            for seconds in [sample.seconds, sample.seconds / 2.0] {
                let pose = found.pose(seconds).ok_or("no pose in between")?;
                if !(pose.position.is_finite() && pose.rotation.is_normalized()) {
                    return Err(format!("a pose is {pose:?}"));
                }
            }
        }
        Ok(())
    })
}

fn mutated_kitti(rng: &mut Rng) -> Files {
    let one = rng.below(KITTI.len());
    let all = KITTI.iter().enumerate().map(|(k, (name, whole))| {
        let bytes = match k == one {
            true => text::mutate(whole, rng),
            false => whole.as_bytes().to_vec(),
        };
        ((*name).to_owned(), bytes)
    });
    all.collect()
}

fn files(path: &Path) -> Verdict {
    Verdict::of(camera_file::read(path, &mut Notes::default()), |cameras| {
        cameras.iter().try_for_each(|own| {
            camera(&own.camera)?;
            let finite = own.background.iter().all(|v| v.is_finite());
            finite
                .then_some(())
                .ok_or_else(|| format!("a background is {:?}", own.background))
        })
    })
}

fn paths(path: &Path) -> Verdict {
    Verdict::of(transforms::read(path, &mut Notes::default()), |frames| {
        frames.iter().try_for_each(|frame| camera(&frame.camera))
    })
}

fn reconstruction(path: &Path) -> Verdict {
    Verdict::of(
        colmap::read(path.parent().expect("a folder"), &mut Notes::default()),
        |frames| frames.iter().try_for_each(|frame| camera(&frame.camera)),
    )
}

fn colmap_files(mut change: impl FnMut(&str, &str) -> Vec<u8>) -> Files {
    COLMAP
        .iter()
        .map(|(name, text)| ((*name).to_owned(), change(name, text)))
        .collect()
}

fn mutated_colmap(rng: &mut Rng) -> Files {
    let one = *rng.pick(&["cameras.txt", "images.txt", "images.txt"]);
    colmap_files(|name, whole| {
        if name == one {
            text::mutate(whole, rng)
        } else {
            whole.as_bytes().to_vec()
        }
    })
}

const SEQUENCE: &str = "[model]\nkind = \"images\"\npath = \"seq\"\ndepth = \"depth\"\n\
                        depth_scale = 2.0\nvoid_above = 50.0\n[render]\nbackground = [0.1, 0.2, 0.3]\n";

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut out = Cursor::new(vec![]);
    image
        .into()
        .write_to(&mut out, format)
        .expect("memory takes it");
    out.into_inner()
}

fn png() -> RgbaImage {
    RgbaImage::from_fn(6, 4, |x, y| {
        image::Rgba([40 * x as u8, 60 * y as u8, 90, 255 - 50 * y as u8])
    })
}

fn exr() -> Rgb32FImage {
    Rgb32FImage::from_fn(6, 4, |x, y| {
        image::Rgb([1.0 + x as f32 + 0.1 * y as f32; 3])
    })
}

fn sequence() -> Files {
    let mut all = single("a.toml", SEQUENCE.into());
    all.push(("seq/transforms.json".to_owned(), TRANSFORMS.to_vec()));
    for name in ["a", "b"] {
        all.push((
            format!("seq/train/{name}.png"),
            encoded(png(), ImageFormat::Png),
        ));
        all.push((
            format!("seq/depth/{name}.exr"),
            encoded(exr(), ImageFormat::OpenExr),
        ));
    }
    all
}

fn mutated_sequence(rng: &mut Rng) -> Files {
    let mut all = sequence();
    for _ in 0..rng.few() {
        match rng.below(7) {
            0 | 1 => all[0].1 = tree::toml(SEQUENCE, rng),
            2 => all[1].1 = tree::json(TRANSFORMS, rng),
            3 => {
                let picture = match rng.below(4) {
                    0 => RgbaImage::new(6, 5).into(),
                    1 => DynamicImage::ImageRgba8(png()).into_luma16().into(),
                    2 => DynamicImage::ImageRgba8(png()).into_rgb16().into(),
                    _ => DynamicImage::from(RgbaImage::new(6, 4)),
                };
                all[2].1 = encoded(picture, ImageFormat::Png);
            }
            4 => {
                let mut depth = exr();
                let at = rng.below(depth.len());
                let value = &mut depth.as_mut()[at];
                *value = rng.float(f64::from(*value)) as f32;
                let value = depth.as_raw()[at];
                if rng.one_in(3) {
                    depth.fill(value);
                }
                all[3].1 = encoded(depth, ImageFormat::OpenExr);
            }
            5 => {
                let at = 2 + rng.below(4);
                rng.damage(&mut all[at].1);
            }
            _ => {
                let at = 1 + rng.below(all.len() - 1);
                drop(all.remove(at));
                // What is left has its places no more.
                return all;
            }
        }
    }
    all
}

/// Every frame is a picture of finite numbers, or what is wrong with it is told.
fn images(path: &Path) -> Verdict {
    let opened = Images::open(&path.to_string_lossy());
    let images = match opened {
        Ok(Some(images)) => images,
        Ok(None) => return Verdict::Refused(format!("{}: no sequence", path.display())),
        Err(error) => return Verdict::Refused(error.to_string()),
    };
    let cameras = match images.path(images.len()) {
        Ok(cameras) => cameras,
        Err(error) => return Verdict::Broken(error.to_string()),
    };
    for own in cameras {
        if let Err(what) = camera(&own) {
            return Verdict::Broken(what);
        }
        let shaded = match images.shade(&own, None) {
            Ok(shaded) => shaded,
            Err(error) => return Verdict::Refused(error.to_string()),
        };
        if shaded
            .picture
            .rgb
            .as_flattened()
            .iter()
            .any(|v| !v.is_finite())
        {
            return Verdict::Broken("a pixel is no number".to_owned());
        }
        // Void is infinite, and what is not known is no number.
        if let Some(depth) = shaded.depth.iter().find(|d| **d < 0.0) {
            return Verdict::Broken(format!("a depth is {depth}"));
        }
    }
    Verdict::Sound
}

pub(crate) fn formats() -> Vec<Format> {
    let json = |name, file: &'static str, whole: &'static [u8], judge| Format {
        name,
        binary: super::BINARY,
        whole: Arc::new(move || single(file, whole.to_vec())),
        mutant: Arc::new(move |rng| single(file, tree::json(whole, rng))),
        judge,
    };
    let lines = |name, file: &'static str, whole: &'static str| Format {
        name,
        binary: super::BINARY,
        whole: Arc::new(move || single(file, whole.into())),
        mutant: Arc::new(move |rng| single(file, text::mutate(whole, rng))),
        judge: trajectory,
    };
    vec![
        lines("tum", "groundtruth.txt", TUM),
        lines("euroc", "data.csv", EUROC),
        lines("replica", "traj.txt", REPLICA),
        Format {
            name: "kitti",
            binary: super::BINARY,
            whole: Arc::new(|| {
                let all = KITTI.iter();
                all.map(|(name, text)| ((*name).to_owned(), text.as_bytes().to_vec()))
                    .collect()
            }),
            mutant: Arc::new(mutated_kitti),
            judge: trajectory,
        },
        json("cameras_json", "cameras.json", CAMERAS, files),
        json("transforms_json", "transforms.json", TRANSFORMS, paths),
        json("transforms_of_angles", "transforms.json", ANGLES, paths),
        Format {
            name: "colmap",
            binary: super::BINARY,
            whole: Arc::new(|| colmap_files(|_, text| text.as_bytes().to_vec())),
            mutant: Arc::new(mutated_colmap),
            judge: reconstruction,
        },
        Format {
            name: "images",
            binary: super::BINARY,
            whole: Arc::new(sequence),
            mutant: Arc::new(mutated_sequence),
            judge: images,
        },
    ]
}
