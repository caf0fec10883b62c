#![allow(clippy::unwrap_used)]
use glam::DVec2;

use super::super::damaged_camera_files::{damaged, damages, sound};
use super::*;
use potamoi_base::file_keys::Fate;

fn parsed(text: &str) -> Result<Vec<PathFrame>, String> {
    parse(text.as_bytes(), &mut Notes::default())
}

fn said(text: &str) -> Notes {
    let mut notes = Notes::default();
    parse(text.as_bytes(), &mut notes).unwrap();
    notes
}

/// A frame, with more keys.
fn with(more: &str) -> String {
    ONE.replacen('{', &format!("{{{more}, "), 1)
}

/// The camera of a path of one frame.
fn camera(common: &str, own: &str) -> Camera {
    let text = format!(r#"{{{common}, "frames": [{}]}}"#, with(own));
    parsed(&text).unwrap()[0].camera
}

const ONE: &str = r#"{"file_path": "a/r_0",
    "transform_matrix": [[1,0,0,0],[0,0,-1,-4],[0,1,0,0],[0,0,0,1]]}"#;

/// From (0, -4, 0) along +y, z up.
#[test]
fn the_camera_looks_along_minus_z_with_y_up() {
    let text = format!(r#"{{"camera_angle_x": 0.8, "frames": [{ONE}]}}"#);
    let frame = &parsed(&text).unwrap()[0];
    let camera = &frame.camera;
    assert!((camera.position() - DVec3::new(0.0, -4.0, 0.0)).length() < 1e-12);
    let to = |p: DVec3| camera.world_to_camera.transform_vector3(p);
    assert!((to(DVec3::Y) - DVec3::Z).length() < 1e-12, "ahead");
    assert!((to(DVec3::Z) - DVec3::NEG_Y).length() < 1e-12, "up");
    assert_eq!((camera.width, camera.height), (800, 800));
    assert!((camera.focal.x - 400.0 / 0.4f64.tan()).abs() < 1e-9);
    assert_eq!(frame.picture, Path::new("a/r_0"));
}

#[test]
fn sizes_and_lenses_of_the_file_are_taken() {
    let text = format!(
        r#"{{"w": 640, "h": 480, "fl_x": 500, "fl_y": 510, "cx": 300, "cy": 250,
            "aabb_scale": 4, "frames": [{ONE}, {ONE}]}}"#
    );
    let frames = parsed(&text).unwrap();
    let camera = frames[1].camera;
    assert_eq!((camera.width, camera.height), (640, 480));
    assert_eq!(camera.focal, DVec2::new(500.0, 510.0));
    assert_eq!(camera.centre, DVec2::new(300.0, 250.0));
}

#[test]
fn what_is_no_path_is_refused_by_field() {
    let bent = ONE.replace("[1,0,0,0]", "[2,0,0,0]");
    let mirrored = ONE.replace("[1,0,0,0]", "[-1,0,0,0]");
    let short = ONE.replace("[0,0,-1,-4],", "");
    let narrow = ONE.replace("[0,0,-1,-4]", "[0,0,-1]");
    for (text, expected) in [
        ("[]".to_owned(), "expected named values"),
        (r#"{"camera_angle_x": 1}"#.to_owned(), "frames"),
        (
            r#"{"camera_angle_x": 1, "frames": []}"#.to_owned(),
            "0 frames",
        ),
        (format!(r#"{{"frames": [{ONE}]}}"#), "neither"),
        (
            format!(r#"{{"camera_angle_x": 4, "frames": [{ONE}]}}"#),
            "`camera_angle_x` is 4",
        ),
        (
            format!(r#"{{"fl_x": 9, "w": 0, "frames": [{ONE}]}}"#),
            "`w` is 0",
        ),
        (format!(r#"{{"fl_x": 9, "frames": [{bent}]}}"#), "frames[0]"),
        (
            format!(r#"{{"fl_x": 9, "frames": [{mirrored}]}}"#),
            "no rotation",
        ),
        (
            format!(r#"{{"fl_x": 9, "frames": [{ONE}, {short}]}}"#),
            "frames[1]: `transform_matrix` is no rotation",
        ),
        (
            format!(r#"{{"fl_x": 9, "frames": [{narrow}]}}"#),
            "3 or 4 rows",
        ),
        (format!(r#"{{"fl_x": "9", "frames": [{ONE}]}}"#), "fl_x"),
    ] {
        let error = parsed(&text).unwrap_err();
        assert!(error.contains(expected), "{text}: {error}");
    }
}

#[test]
fn cameras_lie_where_numbers_are_exact() {
    let far = ONE.replace("-1,-4]", "-1,1e10]");
    let text = format!(r#"{{"fl_x": 9, "frames": [{far}]}}"#);
    let error = parsed(&text).unwrap_err();
    assert!(error.contains("expected -1e9 to 1e9"), "{error}");
    let long = format!(r#"{{"fl_x": "{}", "frames": []}}"#, "9".repeat(10_000));
    assert!(parsed(&long).unwrap_err().len() < 1000);
}

/// A frame's own values count, key by key; the focal length, however it is told,
/// as one.
#[test]
fn what_a_frame_says_itself_counts_before_what_is_said_for_all() {
    let all = r#""w": 640, "h": 480, "fl_x": 500, "fl_y": 510, "cx": 300, "cy": 250"#;
    let same = camera(all, r#""note": 1"#);
    assert_eq!(camera(r#""x": 1"#, all), same, "each frame alone");
    assert_eq!(camera(r#""camera_angle_x": 0.8"#, all), same);
    let mixed = camera(all, r#""fl_x": 350.0, "fl_y": 360.0"#);
    let focal = DVec2::new(350.0, 360.0);
    assert_eq!(mixed, Camera { focal, ..same });
    let sized = camera(all, r#""w": 320.0, "h": 2.4e2, "cx": 1, "cy": 2"#);
    let (width, height, centre) = (320, 240, DVec2::new(1.0, 2.0));
    assert_eq!(
        sized,
        Camera {
            width,
            height,
            centre,
            ..same
        }
    );
    let angle = camera(all, r#""camera_angle_x": 0.8"#);
    let focal = DVec2::new(320.0 / 0.4f64.tan(), 510.0);
    assert!((angle.focal - focal).length() < 1e-9, "{angle:?}");
    // The neighbour of a frame with values of its own has the common ones.
    let text = format!(r#"{{{all}, "frames": [{}, {ONE}]}}"#, with(r#""fl_x": 9"#));
    assert_eq!(parsed(&text).unwrap()[1].camera, same);
}

#[test]
fn focal_lengths_are_read_in_every_form() {
    let f = 50.0 / 0.4f64.tan();
    for (text, focal) in [
        (r#""w": 100, "camera_angle_x": 0.8"#, [f, f]),
        (r#""w": 100, "x_fov": 45.836623610465864"#, [f, f]),
        (r#""w": 10, "h": 100, "camera_angle_y": 0.8"#, [f, f]),
        (
            r#""w": 10, "h": 100, "fl_x": 7, "y_fov": 45.836623610465864"#,
            [7.0, f],
        ),
        (r#""w": 100, "fl_y": 7"#, [7.0, 7.0]),
    ] {
        let found = camera(text, r#""note": 1"#).focal;
        assert!(
            (found - DVec2::from(focal)).length() < 1e-9,
            "{text}: {found}"
        );
    }
    let both = format!(r#"{{"w": 100, "fl_x": 90, "camera_angle_x": 1.0, "frames": [{ONE}]}}"#);
    assert!(said(&both).not_used()[0].starts_with("camera_angle_x (it contradicts"));
    let own = ONE.replacen('{', r#"{"fl_x": 90, "camera_angle_x": 1.0, "#, 1);
    let both = format!(r#"{{"w": 100, "frames": [{own}]}}"#);
    assert!(said(&both).not_used()[0].starts_with("frames[].camera_angle_x (it contradicts"));
}

#[test]
fn sizes_that_are_not_given_are_said() {
    for (text, size, said_as) in [
        (
            r#""fl_x": 9, "cx": 320, "cy": 240.5"#,
            [640, 481],
            "640 x 481: from twice cx",
        ),
        (
            r#""fl_x": 9, "w": 64, "cy": 240"#,
            [64, 480],
            "64 x 480: from twice cx",
        ),
        (
            r#""fl_x": 9, "w": 64"#,
            [64, 64],
            "64 x 64: the file does not state it",
        ),
        (
            r#""fl_x": 9, "h": 64"#,
            [64, 64],
            "64 x 64: the file does not state it",
        ),
        (
            r#""fl_x": 9"#,
            [800, 800],
            "800 x 800: the file does not state it",
        ),
    ] {
        let text = format!(r#"{{{text}, "frames": [{ONE}]}}"#);
        let camera = parsed(&text).unwrap()[0].camera;
        assert_eq!([camera.width, camera.height], size, "{text}");
        let notes = said(&text);
        assert!(notes.assumed()[0].contains(said_as), "{notes:?}");
    }
    let odd = format!(r#"{{"fl_x": 9, "cx": 320.25, "frames": [{ONE}]}}"#);
    assert!(parsed(&odd).unwrap_err().contains("twice `cx` is no side"));
    let half = format!(r#"{{"fl_x": 9, "w": 640.5, "frames": [{ONE}]}}"#);
    assert!(
        parsed(&half)
            .unwrap_err()
            .contains("`w` is 640.5: expected a whole number")
    );
}

/// For all frames and for one; with a value that changes nothing they are read.
#[test]
fn lenses_that_are_no_pinhole_are_refused_by_name() {
    for (key, harm, none) in [
        ("k1", "0.1", "0.0"),
        ("k2", "-1e-9", "0"),
        ("k3", "1", "null"),
        ("k4", "1", "0e0"),
        ("p1", "0.1", "-0.0"),
        ("p2", "0.1", "0"),
        ("is_fisheye", "true", "false"),
        ("fisheye_crop_radius", "900", "null"),
        ("distortion_params", "[0, 0.1, 0, 0]", "[0, 0, 0, 0]"),
        ("latlong", "true", "false"),
        ("equirectangular", "true", "false"),
        ("orthographic", "true", "false"),
        ("ftheta_p1", "0.001", "0"),
        ("rolling_shutter", "[0, 0, 0.01, 0]", "[0, 0, 0]"),
        ("rolling_shutter_time", "0.01", "0"),
        ("crop_left", "4", "0"),
        ("from_mitsuba", "true", "false"),
        ("camera_model", "\"EQUIRECTANGULAR\"", "\"OPENCV\""),
        ("camera_model", "\"OPENCV_FISHEYE\"", "\"PINHOLE\""),
        ("camera_model", "7", "null"),
        ("camera_type", "\"fisheye\"", "\"perspective\""),
        ("projection", "\"equirectangular\"", "\"PERSPECTIVE\""),
        ("lens_type", "\"fisheye\"", "\"pinhole\""),
        ("convention", "\"OpenCV\"", "\"OpenGL\""),
        ("coordinate_system", "\"RDF\"", "\"RUB\""),
        ("shift_x", "0.1", "0"),
        ("pixel_aspect_ratio", "2", "1.0"),
        ("K", "[[1, 0, 0]]", "null"),
        ("intrinsics", "[1]", "null"),
        ("params", "[1]", "[]"),
        ("transform_matrix_end", "[[1, 0, 0, 1]]", "null"),
    ] {
        let text = |value: &str, in_frame: bool| {
            let key = format!("\"{key}\": {value}");
            match in_frame {
                true => format!(r#"{{"fl_x": 9, "frames": [{ONE}, {}]}}"#, with(&key)),
                false => format!(r#"{{"fl_x": 9, {key}, "frames": [{ONE}]}}"#),
            }
        };
        for in_frame in [false, true] {
            let error = parsed(&text(harm, in_frame)).unwrap_err();
            assert!(error.contains(&format!("`{key}`")), "{key}: {error}");
            assert_eq!(error.starts_with("frames[1]: "), in_frame, "{error}");
            let notes = said(&text(none, in_frame));
            assert!(notes.not_used().is_empty(), "{key}: {notes:?}");
        }
    }
}

/// A lens may be described within another key, which would be listed as a whole.
#[test]
fn lenses_within_other_keys_are_refused_by_path() {
    for (more, key) in [
        (r#""lens": {"k1": 0.1}"#, "lens.k1"),
        (r#""metadata": [{"k1": 0.1}]"#, "metadata.k1"),
        (r#""camera": {"model": "FISHEYE"}"#, "camera.model"),
        (
            r#""camera": {"camera_model": "FISHEYE"}"#,
            "camera.camera_model",
        ),
    ] {
        for text in [
            format!(r#"{{"fl_x": 9, {more}, "frames": [{ONE}]}}"#),
            format!(r#"{{"fl_x": 9, "frames": [{}]}}"#, with(more)),
        ] {
            let error = parsed(&text).unwrap_err();
            assert!(error.contains(&format!("`{key}` cannot be")), "{error}");
        }
    }
    let none = format!(r#"{{"fl_x": 9, "lens": {{"k1": 0}}, "frames": [{ONE}]}}"#);
    assert!(said(&none).not_used().contains(&"lens".to_owned()));
}

/// Every row of the tables is met: what is honoured is taken, the rest is refused
/// or listed; what has no row is listed.
#[test]
fn every_key_is_honoured_refused_or_listed() {
    let value = |key: &str| match key {
        "camera_model" => "\"PINHOLE\"".to_owned(),
        "camera_angle_x" | "camera_angle_y" => "0.5".to_owned(),
        _ => "11".to_owned(),
    };
    for (format, in_frame) in [(&PATH, false), (&FRAME, true)] {
        let keys = format.keys.iter().map(|row| (row.name, row.fate));
        for (name, fate) in keys.chain([("a key that nobody knows", Fate::Listed)]) {
            if ["frames", "file_path", "transform_matrix"].contains(&name) {
                continue;
            }
            let key = name.replace('*', "_");
            let more = format!("\"{key}\": {}", value(&key));
            let text = match in_frame {
                true => format!(
                    r#"{{"frames": [{}]}}"#,
                    with(&format!(r#"{more}, "fl_x": 9"#))
                ),
                false => format!(r#"{{{more}, "frames": [{}]}}"#, with(r#""fl_x": 9"#)),
            };
            // The focal length stands there by another name, too.
            let text = match key.as_str() {
                "fl_x" => text.replacen(r#", "fl_x": 9"#, "", 1),
                _ => text,
            };
            let mut notes = Notes::default();
            let read = parse(text.as_bytes(), &mut notes);
            let listed = notes.not_used().iter().any(|k| k.ends_with(&key));
            let refused = read.is_err_and(|e| e.contains(&format!("`{key}`")));
            let expected = (fate == Fate::Refused, fate == Fate::Listed);
            assert_eq!((refused, listed), expected, "{key} of {}", format.name);
        }
    }
}

#[test]
fn an_order_that_is_not_that_of_names_is_said() {
    let of = |names: &[&str]| {
        let frames: Vec<_> = names
            .iter()
            .map(|name| ONE.replace("a/r_0", name))
            .collect();
        said(&format!(
            r#"{{"fl_x": 9, "w": 8, "h": 8, "frames": [{}]}}"#,
            frames.join(", ")
        ))
    };
    for sorted in [
        &["a1", "a2", "a10"][..],
        &["a1", "a10", "a2"],
        &["x/r_9", "x/r_10"],
        &["b"],
    ] {
        assert!(of(sorted).assumed().is_empty(), "{sorted:?}");
    }
    let notes = of(&["r_2", "r_10", "r_1"]);
    assert_eq!(
        notes.assumed(),
        ["order of frames: the file's, which is not that of their names"]
    );
}

#[test]
fn marks_before_the_text_do_no_harm() {
    let text = format!("\u{feff}{{\"fl_x\": 9,\r\n \"frames\": [{ONE}]}}");
    assert_eq!(
        parsed(&text).unwrap(),
        parsed(text.trim_start_matches('\u{feff}')).unwrap()
    );
}

#[test]
fn poses_are_whole() {
    for (from, to, expected) in [
        ("[0,0,0,1]", "[0,0,0,2]", "last row"),
        ("[0,0,0,1]", "[0,0,0.5,1]", "last row"),
        ("[1,0,0,0]", "[1,0,0,0,9]", "3 or 4 rows of 4"),
        ("[0,0,0,1]", "[0,0,0,1],[0,0,0,1]", "3 or 4 rows of 4"),
        ("[1,0,0,0]", "[0,0,0,0]", "no rotation"),
        ("[1,0,0,0]", "[\"1\",0,0,0]", "3 or 4 rows of 4"),
    ] {
        let frame = ONE.replace(from, to);
        let error = parsed(&format!(r#"{{"fl_x": 9, "frames": [{frame}]}}"#)).unwrap_err();
        assert!(error.contains(expected), "{to}: {error}");
    }
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(600))]

    /// Any content yields a path or one clear error.
    #[test]
    fn damaged_files_are_read_or_refused(harm in damages()) {
        let text = format!(
            r#"{{"w": 640, "h": 480, "fl_x": 500, "fl_y": 510.5, "cx": 300, "cy": 250,
                "camera_angle_x": 0.7, "camera_angle_y": 0.6, "aabb_scale": 4,
                "frames": [{ONE}, {ONE}]}}"#
        );
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("transforms.json");
        std::fs::write(&path, damaged(text.as_bytes(), &harm)).unwrap();
        sound(read(&path, &mut Notes::default()), &path)?;
    }
}
