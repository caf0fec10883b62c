#![allow(clippy::unwrap_used)]

use std::fs;

use glam::{DVec2, DVec3};
use potamoi_base::file_keys::Fate;

use super::text::MAX_LINE;
use super::*;
use crate::damaged_camera_files::{damaged, damages, sound};

const CAMERA: &str = "7 PINHOLE 40 20 30 31 20.5 9.25\n";
const IMAGE: &str = "1 1 0 0 0 0 0 0 7 a.png\n";

fn read_texts(cameras: &str, images: &str) -> Result<Vec<PathFrame>, ColmapError> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("cameras.txt"), cameras).unwrap();
    fs::write(folder.path().join("images.txt"), images).unwrap();
    read(folder.path(), &mut Notes::default())
}

/// The pixel at which a world point is seen.
fn pixel(camera: &Camera, at: DVec3) -> DVec2 {
    let p = camera.world_to_camera.transform_point3(at);
    p.truncate() / p.z * camera.focal + camera.centre
}

/// By hand: a quarter turn about y takes +x of the world ahead of the camera,
/// where the shift adds 1; y, which stays, is 31 x 0.5 / 3 below the centre.
#[test]
fn a_known_point_is_seen_at_its_known_pixel() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let images = format!(
        "# IMAGE_ID, ...\n\n2 {half} 0 -{half} 0 0.25 0 1 7 b c.png\r\n1.5 2.5 -1\r\n{IMAGE}\n"
    );
    let frames = read_texts(&format!("# a comment\n{CAMERA}"), &images).unwrap();
    let names: Vec<_> = frames.iter().map(|f| f.picture.to_str().unwrap()).collect();
    assert_eq!(names, ["a.png", "b c.png"]);
    let camera = &frames[1].camera;
    let seen = pixel(camera, DVec3::new(2.0, 0.5, 0.0));
    let expected = DVec2::new(20.5 + 30.0 * 0.25 / 3.0, 9.25 + 31.0 * 0.5 / 3.0);
    assert!((seen - expected).length() < 1e-12, "{seen} {expected}");
    assert_eq!((camera.width, camera.height), (40, 20));
    // The ray of the pixel whose centre is the principal point looks ahead:
    // COLMAP's upper left pixel has its centre at (0.5, 0.5), as ours has.
    let level = Camera {
        centre: DVec2::new(20.5, 9.5),
        ..*camera
    };
    let (_, ahead) = level.ray(20, 9);
    assert!((ahead - DVec3::X).length() < 1e-12, "{ahead}");
}

/// Lines may end in carriage returns alone.
#[test]
fn lines_of_any_end_are_the_same_images() {
    let images = format!("{IMAGE}1 2 -1\n2 1 0 0 0 0 0 0 7 b.png\n\n3 1 0 0 0 0 0 0 7 c.png\n\n");
    let cameras = format!("# cameras\n{CAMERA}");
    let expected = read_texts(&cameras, &images).unwrap();
    assert_eq!(expected.len(), 3);
    for end in ["\r", "\r\n"] {
        let [cameras, images] = [&cameras, &images].map(|text| text.replace('\n', end));
        assert_eq!(read_texts(&cameras, &images).unwrap(), expected, "{end:?}");
        let wrong = images.replace("2 1 0", "2 x 0");
        let error = read_texts(&cameras, &wrong).unwrap_err().to_string();
        assert!(error.contains("images.txt, line 3: QW is x"), "{error}");
    }
}

#[test]
fn names_with_control_characters_are_refused() {
    for sign in ['\0', '\t', '\u{7f}'] {
        let images = IMAGE.replace("a.png", &format!("a{sign}b.png"));
        let error = read_texts(CAMERA, &images).unwrap_err().to_string();
        assert!(error.contains("NAME is a\\"), "{error}");
    }
}

/// A lens that is no pinhole is refused where a picture was taken with it.
#[test]
fn strange_lenses_of_no_image_are_listed() {
    let cameras =
        format!("{CAMERA}3 FISHEYE 40 20 30 20 9 0.1\n4 OPENCV 40 20 30 31 20 9 0.1 0 0 0\n");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("cameras.txt"), &cameras).unwrap();
    fs::write(folder.path().join("images.txt"), IMAGE).unwrap();
    let mut notes = Notes::default();
    let frames = read(folder.path(), &mut notes).unwrap();
    assert_eq!(frames[0].camera.focal, DVec2::new(30.0, 31.0));
    let listed = [3, 4].map(|id| format!("cameras.txt: camera {id}, which no image uses"));
    assert_eq!(notes.not_used(), listed);
    let images = IMAGE.replace(" 7 ", " 4 ");
    let error = read_texts(&cameras, &images).unwrap_err().to_string();
    assert!(error.contains("cameras.txt, line 3: k1 is 0.1"), "{error}");
}

#[derive(serde::Deserialize)]
struct Told {
    points: Vec<[f64; 3]>,
    seen: std::collections::HashMap<String, Vec<[f64; 2]>>,
}

/// Written and projected by COLMAP itself (tools/colmap-fixtures).
#[test]
fn points_are_seen_where_colmap_sees_them() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/colmap");
    let told: Told = serde_json::from_slice(&fs::read(folder.join("seen.json")).unwrap()).unwrap();
    let frames = read(&folder, &mut Notes::default()).unwrap();
    assert_eq!(frames.len(), 5);
    assert_eq!(frames[0].picture, Path::new("shots/view 4.png"));
    for frame in &frames {
        for (at, expected) in told
            .points
            .iter()
            .zip(&told.seen[frame.picture.to_str().unwrap()])
        {
            let off = pixel(&frame.camera, DVec3::from(*at)) - DVec2::from(*expected);
            assert!(off.length() < 1e-9, "{off}");
        }
    }
}

#[test]
fn what_makes_no_camera_is_refused_by_file_line_and_field() {
    let refused = |cameras: &str, images: &str, expected: &[&str]| {
        let error = read_texts(cameras, images).unwrap_err().to_string();
        for part in expected {
            assert!(error.contains(part), "{part}: {error}");
        }
    };
    for (from, to, parts) in [
        ("PINHOLE", "FISHEYE", ["line 1", "MODEL is FISHEYE"]),
        ("40", "0", ["line 1", "WIDTH is 0"]),
        ("20 ", "1e9 ", ["line 1", "HEIGHT is 1000000000"]),
        ("30", "-30", ["line 1", "fx is -30"]),
        ("31", "nan", ["line 1", "fy is NaN"]),
        ("9.25", "", ["line 1", "cy is missing"]),
        ("9.25", "9.25 1", ["line 1", "PARAMS[] is 1 too much"]),
        ("7 ", "-7 ", ["line 1", "CAMERA_ID is -7"]),
        (
            "7 PINHOLE",
            "8 PINHOLE",
            ["images.txt, line 1", "CAMERA_ID is 7"],
        ),
        (
            CAMERA,
            "7 OPENCV 40 20 30 31 20 9 0 0 1e-3 0",
            ["line 1", "p1 is 0.001"],
        ),
        (
            CAMERA,
            "7 SIMPLE_RADIAL 40 20 30 20 9 0.1",
            ["line 1", "k is 0.1"],
        ),
        (
            CAMERA,
            "7 RADIAL 40 20 30 20 9 0",
            ["line 1", "k2 is missing"],
        ),
        (
            "\n",
            "\n\n7 PINHOLE 40 20 30 31 20 9",
            ["line 3", "CAMERA_ID is 7"],
        ),
        (CAMERA, "", ["images.txt", "CAMERA_ID is 7"]),
    ] {
        refused(&CAMERA.replace(from, to), IMAGE, &parts);
    }
    let next = IMAGE.replace("1 1 0", "2 1 0");
    for (images, parts) in [
        (String::new(), ["images.txt", "no image"]),
        ("# 1 1 0 0 0 0 0 0 7 a\n".to_owned(), ["", "no image"]),
        (IMAGE.replace("a.png", ""), ["line 1", "NAME is missing"]),
        (IMAGE.replace("1 1 0", "1 1.1 0"), ["line 1", "QW QX QY QZ"]),
        (IMAGE.replace("1 1 0", "1 x 0"), ["line 1", "QW is x"]),
        (IMAGE.replace("0 7", "inf 7"), ["line 1", "TZ is inf"]),
        (
            IMAGE.replace("0 7", "0 7.5"),
            ["line 1", "CAMERA_ID is 7.5"],
        ),
        (
            format!("{IMAGE}1 2 3\n{next}{}", next.replace("2 1 0", "3 1 0")),
            ["line 4", "POINTS2D[] is \"3 1 0"],
        ),
        (
            format!("{IMAGE}1 2 3 4\n"),
            ["line 2", "POINTS2D[] is \"1 2 3 4"],
        ),
        (format!("{IMAGE}1 2 3.5\n"), ["line 2", "POINTS2D[]"]),
        (format!("{IMAGE}1 nan 3\n"), ["line 2", "POINTS2D[]"]),
        (format!("{IMAGE}# points\n"), ["line 2", "POINTS2D[]"]),
        (format!("{IMAGE}\n{next}\n"), ["two images", "a.png"]),
        (format!("{IMAGE}\n{IMAGE}\n"), ["line 3", "IMAGE_ID is 1"]),
    ] {
        refused(CAMERA, &images, &parts);
    }
    // No text, no file, no folder.
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("cameras.txt"), b"7 \xff\n").unwrap();
    let error = read(folder.path(), &mut Notes::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("line 1: text is"), "{error}");
    fs::write(folder.path().join("cameras.txt"), CAMERA).unwrap();
    let error = read(folder.path(), &mut Notes::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("images.txt") && error.contains("cannot read"),
        "{error}"
    );
}

/// Poses of the images of a file, by name.
fn poses(images: &str) -> Result<Vec<PathFrame>, String> {
    let error = |e: ColmapError| e.to_string();
    read_texts(CAMERA, images).map_err(error)
}

/// Names of any number of words, of which some make lines of nine, twelve or
/// fifteen values: as many as three, four or five points have.
#[test]
fn images_without_lines_of_points_are_read_where_no_line_could_be_points() {
    let names = ["a.png", "b (1).png", "c 1 2.png", "d 1 2 3 4 5.png", "e"];
    let line = |i: usize, name: &str| format!("{i} 1 0 0 0 {i} 0 0 7 {name}\n");
    let lines = names.iter().enumerate();
    let alone: String = lines.clone().map(|(i, name)| line(i, name)).collect();
    let spaced: String = lines
        .clone()
        .map(|(i, name)| line(i, name) + "\n")
        .collect();
    let points: String = lines
        .map(|(i, name)| line(i, name) + "1 2.5 -1 3 4 7\n")
        .collect();
    let expected = poses(&spaced).unwrap();
    assert_eq!(expected.len(), names.len());
    assert_eq!(poses(&points).unwrap(), expected);
    assert_eq!(poses(&alone).unwrap(), expected);
    assert_eq!(poses(&format!("{alone}\n\n")).unwrap(), expected);
    let commented = alone.replace("\n3 ", "\n# a comment\n3 ");
    assert_eq!(poses(&commented).unwrap(), expected);
    // Numbers for a name: the line could be of points.
    for at in [1, 2, 4] {
        let mut lines: Vec<String> = alone.lines().map(str::to_owned).collect();
        lines[at] = line(at, "10 20 30").trim_end().to_owned();
        let error = poses(&lines.join("\n")).unwrap_err();
        let number = format!("line {}: ", at + 1);
        assert!(
            error.contains(&number) && error.contains("could be both"),
            "{error}"
        );
    }
    // A line of points that was lost among others.
    let lost = points
        .replacen("1 2.5 -1 3 4 7\n", "", 2)
        .replacen("\n1 1", "\n1 2 3\n1 1", 1);
    assert!(poses(&lost).unwrap_err().contains("POINTS2D[]"), "{lost}");
}

#[test]
fn what_is_not_used_of_a_folder_is_listed() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write(
        "cameras.txt",
        &format!("\u{feff}{}", CAMERA.replace("40 20", "40.0 2e1")),
    );
    let notes = || {
        let mut notes = Notes::default();
        read(folder.path(), &mut notes).unwrap();
        notes.not_used().join(", ")
    };
    write("images.txt", &format!("\u{feff}{IMAGE}\r\n"));
    assert_eq!(notes(), "");
    fs::write(
        folder.path().join("images.txt"),
        [b"# Gr\xfc\xdfe\n", format!("{IMAGE}1 2 -1\n").as_bytes()].concat(),
    )
    .unwrap();
    for name in [
        "points3D.txt",
        "rigs.txt",
        "frames.bin",
        "images.bin",
        "notes.md",
    ] {
        write(name, "");
    }
    let all = "frames.bin, images.bin, points3D.txt, rigs.txt, images.txt: POINTS2D[]";
    assert_eq!(notes(), all);
    fs::remove_file(folder.path().join("images.txt")).unwrap();
    let error = read(folder.path(), &mut Notes::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("binary form") && error.contains("model_converter"),
        "{error}"
    );
    write("cameras.txt", &CAMERA.replace("40", "40.5"));
    let error = read(folder.path(), &mut Notes::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("WIDTH is 40.5: expected a whole number"),
        "{error}"
    );
}

/// Every model has a row; those that are refused are refused by name.
#[test]
fn every_model_is_honoured_or_refused() {
    for row in INTRINSICS.keys {
        let name = row.name.replace('*', "OPENCV_");
        let read = read_texts(&format!("7 {name} 40 20 30 31 20 0 0 0\n"), IMAGE);
        let refused = read.is_err_and(|e| e.to_string().contains("MODEL is"));
        assert_eq!(refused, row.fate == Fate::Refused, "{name}");
    }
}

/// A line is read, not the file; one without an end is not.
#[test]
fn a_line_without_an_end_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("cameras.txt"), CAMERA).unwrap();
    let images = fs::File::create(folder.path().join("images.txt")).unwrap();
    images.set_len(MAX_LINE + 1).unwrap();
    let error = read(folder.path(), &mut Notes::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("images.txt, line 1: text is longer: expected at most"),
        "{error}"
    );
    let long = CAMERA.replace("PINHOLE", &"P".repeat(10_000));
    let error = read_texts(&long, IMAGE).unwrap_err().to_string();
    assert!(
        error.contains("MODEL is PPP") && error.len() < 1000,
        "{error}"
    );
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(600))]

    /// Any content yields poses or one clear error.
    #[test]
    fn damaged_files_are_read_or_refused(harm in damages(), of_images: bool) {
        let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/colmap");
        let folder = tempfile::tempdir().unwrap();
        for name in ["cameras.txt", "images.txt"] {
            let mut bytes = fs::read(fixtures.join(name)).unwrap();
            if of_images == (name == "images.txt") {
                bytes = damaged(&bytes, &harm);
            }
            fs::write(folder.path().join(name), bytes).unwrap();
        }
        sound(read(folder.path(), &mut Notes::default()), folder.path())?;
    }
}
