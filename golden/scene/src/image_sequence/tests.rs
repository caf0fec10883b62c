#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;

use image::{ImageBuffer, Rgb, Rgba};
use proptest::prelude::*;
use proptest::sample::Index;

use super::*;
use potamoi_warp::{Class, Profile, Warper};

const SIDES: [u32; 2] = [6, 4];

/// Two frames from one place: a step from black to red, half clear, whose depth
/// is 2 on the left and 3 on the right; the last column is void, in its last row
/// with a colour, as at a soft rim.
fn write(folder: &Path) {
    let frame = |name: &str| {
        format!(
            "{{\"file_path\": \"test/{name}\", \"transform_matrix\": \
             [[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]}}"
        )
    };
    let text = format!(
        "{{\"fl_x\": 8, \"w\": 6, \"h\": 4, \"frames\": [{}, {}]}}",
        frame("a"),
        frame("b")
    );
    for sub in ["test", "depth"] {
        fs::create_dir_all(folder.join(sub)).unwrap();
    }
    fs::write(folder.join("transforms.json"), text).unwrap();
    let [w, h] = SIDES;
    let picture = ImageBuffer::from_fn(w, h, |x, y| {
        let clear = x == 5 && y < 3;
        Rgba([51 * x as u8, 0, 0, if clear { 0 } else { 204 }])
    });
    let depth = ImageBuffer::from_fn(w, h, |x, _| {
        let d = [0.2f32, 0.2, 0.2, 0.3, 0.3, 1.0][x as usize];
        Rgb([d, 7.0, 7.0])
    });
    for name in ["a", "b"] {
        picture
            .save(folder.join(format!("test/{name}.png")))
            .unwrap();
        depth
            .save(folder.join(format!("depth/{name}.exr")))
            .unwrap();
    }
    let toml = "[model]\nkind = \"images\"\npath = \".\"\ndepth_scale = 10\nvoid_above = 9.5\n\
                [render]\nbackground = [0, 0.5, 1]\n";
    fs::write(folder.join("s.toml"), toml).unwrap();
}

fn open(folder: &Path) -> Result<Option<Images>, SceneError> {
    Images::open(folder.join("s.toml").to_str().unwrap())
}

#[test]
fn frames_are_over_their_background_and_depths_in_the_units_of_the_poses() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    let images = open(folder.path()).unwrap().unwrap();
    assert_eq!((images.len(), images.is_empty()), (2, false));
    let camera = images.path(2).unwrap()[1];
    let shaded = images.shade(&camera, None).unwrap();
    let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    // Alpha is 0.8: of the picture 0.8, of the background 0.2.
    assert!(near(shaded.picture.rgb[0], [0.0, 0.1, 0.2]));
    assert!(near(shaded.picture.rgb[4], [0.64, 0.1, 0.2]));
    assert!((shaded.depth[6] - 2.0).abs() < 1e-6 && (shaded.depth[10] - 3.0).abs() < 1e-6);
    assert_eq!(shaded.depth[5], f32::INFINITY);
    assert!(shaded.depth[23].is_nan());
    let bits = |all: &[f32]| all.iter().map(|d| d.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&images.depth(&camera).unwrap()), bits(&shaded.depth));
    // Of a mask, the rest is background and void.
    let mask = Mask::new(SIDES, |i| i == 4);
    let part = images.shade(&camera, Some(&mask)).unwrap();
    assert_eq!(part.picture.rgb[4], shaded.picture.rgb[4]);
    assert_eq!(
        (part.picture.rgb[3], part.depth[3]),
        ([0.0, 0.5, 1.0], f32::INFINITY)
    );
}

/// Each picture has a depth of its own, whether or not it is named with its ending.
#[test]
fn pictures_with_dots_in_their_names_have_their_own_depths() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    let at = |name: &str| folder.path().join(name);
    for (from, to) in [("a", "frame.0000"), ("b", "frame.0001")] {
        fs::rename(
            at(&format!("test/{from}.png")),
            at(&format!("test/{to}.png")),
        )
        .unwrap();
    }
    let [w, h] = SIDES;
    for (name, depth) in [("frame.0000", 0.2f32), ("frame.0001", 0.4), ("frame", 0.6)] {
        let depth = ImageBuffer::from_fn(w, h, |_, _| Rgb([depth; 3]));
        depth.save(at(&format!("depth/{name}.exr"))).unwrap();
    }
    let text = fs::read_to_string(at("transforms.json")).unwrap();
    for ending in ["", ".png"] {
        let named = |text: &str, from: &str, to: &str| {
            text.replace(&format!("test/{from}\""), &format!("test/{to}{ending}\""))
        };
        let text = named(&named(&text, "a", "frame.0000"), "b", "frame.0001");
        fs::write(at("transforms.json"), text).unwrap();
        let images = open(folder.path()).unwrap().unwrap();
        // Both are from one place: the frames are told apart by their number.
        for (frame, depth) in images.frames.iter().zip([2.0f32, 4.0]) {
            let found = images.depth_of(frame).unwrap();
            assert!((found[0] - depth).abs() < 1e-5, "{ending}: {found:?}");
        }
    }
}

/// There is no depth behind the camera.
#[test]
fn depths_behind_the_camera_are_not_known() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    let depths = [1.0f32, -1.0, f32::NEG_INFINITY, f32::NAN, 0.25, 0.5];
    let [w, h] = SIDES;
    let depth = ImageBuffer::from_fn(w, h, |x, _| Rgb([depths[x as usize]; 3]));
    depth.save(folder.path().join("depth/a.exr")).unwrap();
    let images = open(folder.path()).unwrap().unwrap();
    let found = images.depth(&images.path(1).unwrap()[0]).unwrap();
    assert!(found[1..4].iter().all(|d| d.is_nan()), "{found:?}");
    assert_eq!(found[4], 2.5);
}

/// Frames from nearly the same place: what has a surface is warped, what has none is void, and
/// nothing else. From the same place the reference is shown as it is.
#[test]
fn a_frame_from_the_same_place_is_warped_whole() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    let images = open(folder.path()).unwrap().unwrap();
    let camera = images.path(1).unwrap()[0];
    let warper = Warper {
        renderer: &images,
        geometry: Some(&images),
        rule: Profile::Paper.rule(),
    };
    let reference = warper.reference(&camera).unwrap();
    let still = warper.target(&reference, &camera, &camera).unwrap();
    assert!(still.classes.iter().all(|class| *class == Class::Warped));
    assert_eq!(still.shaded.picture.rgb, reference.picture.rgb);

    let mut beside = camera;
    beside.world_to_camera.translation.z += 1e-9;
    let target = warper.target(&reference, &beside, &camera).unwrap();
    for (i, class) in target.classes.iter().enumerate() {
        let expected = match i {
            23 => Class::Edge,
            i if i as u32 % SIDES[0] == 5 => Class::Void,
            _ => Class::Warped,
        };
        assert_eq!(*class, expected, "{i}");
        assert_eq!(target.shaded.picture.rgb[i], reference.picture.rgb[i]);
    }
}

/// Everything in a description, a path, a picture or a depth is used, refused or listed.
#[test]
fn nothing_of_a_sequence_is_dropped() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    let toml = fs::read_to_string(folder.path().join("s.toml")).unwrap();
    for (more, expected) in [
        ("[camera]\nkind = \"orbit\"\n", "`[camera]`"),
        ("group_side = 3\n", "`[render]`"),
        ("order = \"exact\"\n", "`[render]`"),
    ] {
        fs::write(folder.path().join("s.toml"), format!("{toml}{more}")).unwrap();
        let error = open(folder.path()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let background = toml.replace("[0, 0.5, 1]", "[0, nan, 1]");
    fs::write(folder.path().join("s.toml"), background).unwrap();
    let error = open(folder.path()).unwrap_err().to_string();
    assert!(error.contains("render.background"), "{error}");
    fs::write(folder.path().join("s.toml"), &toml).unwrap();
    let path = folder.path().join("transforms.json");
    let cameras = fs::read_to_string(&path).unwrap();
    fs::write(&path, cameras.replacen('{', "{\"aabb_scale\": 4, ", 1)).unwrap();
    let images = open(folder.path()).unwrap().unwrap();
    assert_eq!(
        images.left_open(),
        ["not used of the file: transforms.json: aabb_scale"]
    );
    let camera = images.path(1).unwrap()[0];
    images.shade(&camera, None).unwrap();
    let said = images.left_open().join("; ");
    assert!(said.contains("depths: channel G"), "{said}");
    // A picture of linear colours, behind whose header a chunk says so.
    let file = folder.path().join("test/a.png");
    let plain = fs::read(&file).unwrap();
    let (head, rest) = plain.split_at(33);
    let gamma = [
        0, 0, 0, 4, b'g', b'A', b'M', b'A', 0, 1, 0x86, 0xa0, 0x31, 0xe8, 0x96, 0x5f,
    ];
    fs::write(&file, [head, &gamma, rest].concat()).unwrap();
    let Err(error) = images.shade(&camera, None) else {
        panic!("read")
    };
    assert!(error.to_string().contains("`gAMA`"), "{error}");
}

#[test]
fn what_cannot_be_used_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let shade = || {
        let images = open(at).unwrap().unwrap();
        let camera = images.path(1).unwrap()[0];
        images.shade(&camera, None).unwrap_err().to_string()
    };
    let says = |said: String, words: &[&str]| {
        assert!(words.iter().all(|w| said.contains(w)), "{said}");
    };
    write(at);
    fs::remove_file(at.join("test/a.png")).unwrap();
    says(shade(), &["a.png"]);
    write(at);
    let wide = ImageBuffer::from_pixel(7, 4, Rgb([0u8; 3]));
    wide.save(at.join("test/a.png")).unwrap();
    says(shade(), &["a.png", "6 x 4"]);
    write(at);
    fs::copy(at.join("test/a.png"), at.join("depth/a.exr")).unwrap();
    says(shade(), &["a.exr", "OpenEXR depth of 6 x 4"]);
    write(at);
    let images = open(at).unwrap().unwrap();
    says(images.path(3).unwrap_err().to_string(), &["at most 2"]);
    let mut elsewhere = images.path(1).unwrap()[0];
    elsewhere.width += 1;
    let error = images.shade(&elsewhere, None).unwrap_err().to_string();
    says(error, &["no image was taken from this camera"]);
    for (field, value) in [
        ("depth_scale", "-1"),
        ("depth_scale", "inf"),
        ("void_above", "nan"),
    ] {
        write(at);
        let toml = format!("[model]\nkind = \"images\"\npath = \".\"\n{field} = {value}\n");
        fs::write(at.join("s.toml"), toml).unwrap();
        says(open(at).unwrap_err().to_string(), &["s.toml", "positive"]);
    }
}

proptest! {
    /// Bytes that are changed or cut off: a frame of the right size, or one line
    /// that names the file.
    #[test]
    fn damaged_pictures_are_read_or_refused(
        exr: bool,
        harm in prop::collection::vec((any::<Index>(), any::<u8>()), 1..6),
        cut in prop::option::of(any::<Index>()),
    ) {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path());
        let file = folder.path().join(if exr { "depth/a.exr" } else { "test/a.png" });
        let mut bytes = fs::read(&file).unwrap();
        for (at, value) in &harm {
            let at = at.index(bytes.len());
            bytes[at] = *value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        fs::write(&file, bytes).unwrap();
        let images = open(folder.path()).unwrap().unwrap();
        let camera = images.path(1).unwrap()[0];
        match images.shade(&camera, None) {
            Ok(shaded) => {
                prop_assert_eq!(shaded.picture.rgb.len(), 24);
                prop_assert_eq!(shaded.depth.len(), 24);
            }
            Err(error) => {
                let error = error.to_string();
                prop_assert!(error.contains(file.file_name().unwrap().to_str().unwrap()));
                prop_assert!(!error.contains('\n') && error.len() < 1000, "{}", error);
            }
        }
    }
}
