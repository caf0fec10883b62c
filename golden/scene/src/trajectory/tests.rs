#![allow(clippy::unwrap_used, clippy::panic)]

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use potamoi_base::camera::Camera;
use proptest::prelude::*;

use super::*;
use crate::damaged_camera_files::{damaged, damages};

/// `count` samples, `step` seconds apart, of a camera on a circle in the plane of x and z, which
/// turns with it. `speed` is in radians a second.
pub(super) fn circle(radius: f64, speed: f64, count: u32, step: f64) -> Trajectory {
    let sample = |k| {
        let seconds = f64::from(k) * step;
        Sample {
            seconds,
            pose: on_circle(radius, speed * seconds),
        }
    };
    let samples: Vec<Sample> = (0..count).map(sample).collect();
    Trajectory::of(&samples)
}

fn on_circle(radius: f64, angle: f64) -> Pose {
    let tilt = DQuat::from_rotation_x(0.3);
    Pose {
        rotation: DQuat::from_rotation_y(angle) * tilt,
        position: radius * DVec3::new(angle.sin(), 0.0, angle.cos()),
    }
}

fn camera() -> Camera {
    let eye = DVec3::new(0.5, -2.0, -3.0);
    Camera::look_at(eye, DVec3::ZERO, DVec3::NEG_Y, 0.9, 40, 30)
}

/// Angle in radians between two rotations. The arc cosine of a scalar product near 1 loses half of
/// its digits.
fn angle(a: DQuat, b: DQuat) -> f64 {
    let turn = a.conjugate() * b;
    2.0 * DVec3::new(turn.x, turn.y, turn.z).length().min(1.0).asin()
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        fs::write(&path, text).unwrap();
        path
    }
}

fn tum(samples: &[Sample]) -> String {
    let mut text = "# timestamp tx ty tz qx qy qz qw\n".to_owned();
    for Sample { seconds, pose } in samples {
        let (p, q) = (pose.position, pose.rotation);
        let time = 1_300_000_000.0 + seconds;
        writeln!(
            text,
            "{time} {} {} {} {} {} {} {}",
            p.x, p.y, p.z, q.x, q.y, q.z, q.w
        )
        .unwrap();
    }
    text
}

fn euroc(samples: &[Sample], header: &str) -> String {
    let mut text = header.to_owned();
    for Sample { seconds, pose } in samples {
        let (p, q) = (pose.position, pose.rotation);
        let time = 1_403_636_580_000_000_000 + (seconds * 1e9).round() as i64;
        writeln!(
            text,
            "{time},{},{},{},{},{},{},{},0.1,0.2,0.3",
            p.x, p.y, p.z, q.w, q.x, q.y, q.z
        )
        .unwrap();
    }
    text
}

fn rows(pose: &Pose) -> String {
    let matrix = DMat3::from_quat(pose.rotation);
    let rows = (0..3).map(|r| {
        let row = matrix.row(r);
        format!("{} {} {} {}", row.x, row.y, row.z, pose.position[r])
    });
    rows.collect::<Vec<_>>().join(" ")
}

const HEADER: &str = "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], \
                      q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1]\r\n";

fn is_near(found: &Trajectory, expected: &[Sample], seconds: f64) {
    assert_eq!(found.samples().len(), expected.len());
    for (a, b) in found.samples().iter().zip(expected) {
        assert!((a.seconds - b.seconds).abs() < seconds, "{a:?} {b:?}");
        assert!((a.pose.position - b.pose.position).length() < 1e-12);
        assert!(angle(a.pose.rotation, b.pose.rotation) < 1e-7);
    }
}

/// One motion in every dialect, which is recognised.
#[test]
fn every_dialect_is_recognised_and_tells_the_same_motion() {
    let folder = Folder::new();
    let motion = circle(2.0, 0.7, 6, 0.1);
    let samples = motion.samples();
    let lines = |line: &dyn Fn(&Sample) -> String| -> String {
        samples.iter().map(|s| line(s) + "\n").collect()
    };
    let times: String = samples
        .iter()
        .map(|s| format!("{:e}\n", s.seconds))
        .collect();
    let named = euroc(samples, HEADER);
    let tum = tum(samples);
    let kitti = lines(&|s| rows(&s.pose));
    let cases: [(&str, String, &str, &[&str]); 8] = [
        ("tum.txt", tum.clone(), "tum", &[]),
        ("commas.txt", tum.replace(' ', ", "), "tum", &[]),
        (
            "windows.txt",
            format!("\u{feff}{}", tum.replace('\n', "\r\n")),
            "tum",
            &[],
        ),
        ("old.txt", tum.replace('\n', "\r"), "tum", &[]),
        (
            "a.csv",
            named.clone(),
            "euroc",
            &["v_RS_R_x", "v_RS_R_y", "v_RS_R_z"],
        ),
        (
            "bare.csv",
            named[HEADER.len()..].to_owned(),
            "euroc",
            &["column 9", "column 10", "column 11"],
        ),
        ("kitti.txt", kitti.clone(), "kitti", &[]),
        (
            "poses.txt",
            lines(&|s| format!("{} {} 0 0 0 1", s.seconds, rows(&s.pose))),
            "poses",
            &[],
        ),
    ];
    for (name, text, dialect, unused) in cases {
        let mut notes = Notes::default();
        let path = folder.write(name, text);
        let found = read(&path, &FileFacts::default(), &mut notes).unwrap();
        // Of seconds since 1970, doubles keep 2e-7.
        is_near(&found, samples, 3e-7);
        let said = notes.sentences().join("; ");
        assert!(
            said.contains(&format!("format: {dialect}")),
            "{name}: {said}"
        );
        assert_eq!(notes.not_used(), unused, "{name}");
        assert_eq!(
            said.contains("T_BS: the identity"),
            dialect == "euroc",
            "{name}"
        );
        assert_eq!(
            said.contains("10 poses a second"),
            dialect == "kitti",
            "{name}"
        );
    }
    // Without times: a rate, a file of times, or what is assumed.
    let replica = folder.write("traj.txt", lines(&|s| rows(&s.pose) + " 0 0 0 1"));
    let mut notes = Notes::default();
    let found = read(&replica, &FileFacts::default(), &mut notes).unwrap();
    assert_eq!(found.seconds(), 5.0 / 30.0);
    assert!(notes.sentences()[0].contains("times: 30 poses a second"));
    let facts = FileFacts {
        dialect: Some(Dialect::Replica),
        file_hz: Some(10.0),
        ..FileFacts::default()
    };
    let mut notes = Notes::default();
    is_near(&read(&replica, &facts, &mut notes).unwrap(), samples, 1e-12);
    assert!(notes.sentences().is_empty(), "{notes:?}");
    let kitti = folder.write("00.txt", kitti);
    let late = (10..16).map(|k| format!("{k}\n")).collect::<String>();
    let facts = FileFacts {
        times: Some(folder.write("t.txt", late)),
        ..FileFacts::default()
    };
    assert_eq!(read(&kitti, &facts, &mut notes).unwrap().seconds(), 5.0);
    folder.write("times.txt", times);
    let found = read(&kitti, &FileFacts::default(), &mut notes).unwrap();
    is_near(&found, samples, 1e-12);
    assert!(notes.sentences()[0].contains("times.txt beside it"));
}

/// A camera on a body: its poses are the body's after `T_BS`.
#[test]
fn a_camera_is_where_its_body_has_it() {
    let folder = Folder::new();
    let motion = circle(2.0, 0.7, 4, 0.1);
    let path = folder.write("data.csv", euroc(motion.samples(), HEADER));
    // A camera a metre to the body's right that looks along its x.
    let t_bs = [
        0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
    ];
    let facts = FileFacts {
        t_bs: Some(t_bs),
        ..FileFacts::default()
    };
    let found = read(&path, &facts, &mut Notes::default()).unwrap();
    for (camera, body) in found.samples().iter().zip(motion.samples()) {
        let x = body.pose.rotation * DVec3::X;
        assert!((camera.pose.position - (body.pose.position + x)).length() < 1e-12);
        assert!((camera.pose.rotation * DVec3::Z - x).length() < 1e-12);
    }
    let facts = FileFacts {
        t_bs: Some(t_bs.map(|v| 2.0 * v)),
        ..FileFacts::default()
    };
    let error = read(&path, &facts, &mut Notes::default()).unwrap_err();
    assert!(
        error.to_string().contains("camera.t_bs: the last row"),
        "{error}"
    );
}

#[test]
fn what_is_no_trajectory_is_refused_by_file_line_and_field() {
    let folder = Folder::new();
    let one = "1 0 0 0 0 0 0 1\n";
    let long = "1403636580000000000,0,0,0,1,0,0,0\n";
    for (text, dialect, expected) in [
        ("", None, "no pose: expected at least two"),
        ("# nothing\n", Some(Dialect::Tum), "no pose"),
        (one, None, "one pose: expected at least two"),
        (
            "1 2 3\n",
            None,
            "line 1: the first line of numbers is \"1 2 3\", 3 values: expected 8",
        ),
        (
            "1 0 0 0 0 0 1\n",
            Some(Dialect::Tum),
            "line 1: the number of values is 7: expected 8: timestamp tx",
        ),
        (
            "1 0 0 0 0 0 0 1 #\n",
            Some(Dialect::Tum),
            "the number of values is 9",
        ),
        (
            "1 nan 0 0 0 0 0 1\n",
            None,
            "line 1: tx is nan: expected a number from -1e9 to 1e9",
        ),
        ("1 0 0 1e10 0 0 0 1\n", None, "tz is 1e10"),
        ("1 0 0 0 0 inf 0 1\n", None, "qy is inf"),
        ("x 0 0 0 0 0 0 1\n", None, "timestamp is x"),
        ("1e300 0 0 0 0 0 0 1\n", None, "timestamp is 1e300"),
        (
            "1 0 0 0 0 0 0 0\n",
            None,
            "the quaternion is x 0, y 0, z 0, w 0, of length 0.0000: expected of length 1, to 0.01",
        ),
        ("1 0 0 0 0 0 0 1.02\n", None, "of length 1.0200"),
        (
            "2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n",
            None,
            "line 2: timestamp is 1: expected at least",
        ),
        ("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", None, "one pose"),
        (
            "1 0 0 0 0 0 0 1\n2 0 0 \u{e9} 0 0 0 1\n",
            None,
            "line 2: tz is \u{e9}",
        ),
        (
            "1403636580.5,0,0,0,1,0,0,0\n",
            Some(Dialect::Euroc),
            "timestamp is 1403636580.5: expected a whole number",
        ),
        (
            "#timestamp, p_x, p_y\n",
            Some(Dialect::Euroc),
            "a column's name is missing, in column 4: expected a column of p_z",
        ),
        (
            "#timestamp [ns],q_w,q_x,q_y,q_z,p_x,p_y,p_z\n",
            Some(Dialect::Euroc),
            "a column's name is q_w, in column 2",
        ),
        (
            "1403636580000000000,0,0,0\n",
            Some(Dialect::Euroc),
            "the number of values is 4",
        ),
        (
            "1 0 0 0 0 1 0 0 0 0 1\n",
            Some(Dialect::Kitti),
            "the number of values is 11: expected 12",
        ),
        (
            "2 0 0 0 0 1 0 0 0 0 1 0\n",
            None,
            "line 1: the rotation is [2.0, 0.0, 0.0] [0.0",
        ),
        ("1 0 0 0 0 1 0 0 0 0 -1 0\n", None, "right-handed"),
        (
            "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 2\n",
            None,
            "the last row is [0.0, 0.0, 0.0, 2.0]: expected 0 0 0 1",
        ),
        ("0 1 0 0 0 0 1 0 0 0 0 1 x\n", None, "t3 is x"),
    ] {
        let path = folder.write("a.txt", text);
        let facts = FileFacts {
            dialect,
            ..FileFacts::default()
        };
        let error = read(&path, &facts, &mut Notes::default())
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(expected) && error.contains("a.txt"),
            "{text:?}: {error}"
        );
    }
    let path = folder.write("a.txt", b"1 0 0 0 0 0 0 \xff\n");
    let error = read(&path, &FileFacts::default(), &mut Notes::default()).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("line 1: text is not UTF-8 at byte 15"),
        "{error}"
    );
    let none = folder.0.path().join("none.txt");
    let error = read(&none, &FileFacts::default(), &mut Notes::default()).unwrap_err();
    assert!(
        error.to_string().contains("cannot read trajectory"),
        "{error}"
    );
    // Facts that do not go with the file.
    let euroc = folder.write("e.csv", long.to_owned() + &long.replace("580", "581"));
    let facts = |file_hz, times| FileFacts {
        file_hz,
        times,
        ..FileFacts::default()
    };
    let replica = folder.write("r.txt", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n".repeat(3));
    let few = folder.write("few.txt", "0\n1\n");
    let back = folder.write("back.txt", "0\n1\n1\n");
    for (path, facts, expected) in [
        (
            &euroc,
            facts(Some(10.0), None),
            "camera.file_hz is given for the dialect euroc",
        ),
        (
            &replica,
            facts(Some(0.0), None),
            "camera.file_hz is 0: expected 0.001 to 1000",
        ),
        (
            &replica,
            facts(Some(1.0), Some(few.clone())),
            "left out, as camera.times",
        ),
        (
            &replica,
            facts(None, Some(few.clone())),
            "few.txt: 2 times: expected one for each pose",
        ),
        (
            &replica,
            facts(None, Some(back)),
            "back.txt, line 3: the time is 1: expected after",
        ),
        (&replica, facts(None, Some(none)), "none.txt"),
    ] {
        let error = read(path, &facts, &mut Notes::default())
            .unwrap_err()
            .to_string();
        assert!(error.contains(expected), "{error}");
    }
}

/// Motion capture repeats times, and stops for seconds.
#[test]
fn repeated_times_are_listed_and_gaps_found() {
    let folder = Folder::new();
    let text = "0 0 0 0 0 0 0 1\n0.1 1 0 0 0 0 0 1\n0.1 9 0 0 0 0 0 1\n0.2 2 0 0 0 0 0 1\n\
                0.3 2 0 0 0 0 0 1\n5 7 0 0 0 0 0 1\n5 8 0 0 0 0 0 1\n";
    let mut notes = Notes::default();
    let found = read(
        &folder.write("a.txt", text),
        &FileFacts::default(),
        &mut notes,
    )
    .unwrap();
    assert_eq!(
        notes.not_used(),
        ["2 lines that repeat a time, the first is line 3"]
    );
    assert_eq!(found.pose(0.1).unwrap().position.x, 1.0);
    let gaps = found.gaps([0.0, 5.0]);
    assert!(
        matches!(gaps[..], [(at, step)] if at == 0.3 && step == 4.7),
        "{gaps:?}"
    );
    assert!(found.gaps([0.0, 0.3]).is_empty());
    assert_eq!(found.extent([0.0, 5.0]), 7.0);
    assert_eq!(found.extent([0.1, 0.25]), 1.0);
}

/// The error against the circle itself is what linear interpolation has at most: acceleration times
/// the square of the step over 8. A steady turn is exact.
#[test]
fn resampling_errs_by_no_more_than_a_line_leaves_its_circle() {
    let (radius, speed): (f64, f64) = (2.0, 0.7);
    for step in [0.01, 0.1, 0.5] {
        let motion = circle(radius, speed, 21, step);
        let bound = radius * speed * speed * step * step / 8.0;
        let mut largest: f64 = 0.0;
        for k in 0..=997 {
            let seconds = motion.seconds() * f64::from(k) / 997.0;
            let truth = on_circle(radius, speed * seconds);
            let found = motion.pose(seconds).unwrap();
            largest = largest.max((found.position - truth.position).length());
            assert!(angle(found.rotation, truth.rotation) < 1e-8);
        }
        // The bound is of small angles, which chords of 0.35 rad are to a hundredth.
        assert!(
            largest <= bound && largest > 0.9 * bound,
            "{largest} {bound}"
        );
        assert!(motion.pose(-1e-9).is_none() && motion.pose(motion.seconds() + 1e-9).is_none());
    }
}

/// Quaternions of either sign are one rotation.
#[test]
fn rotations_take_the_shortest_arc() {
    let pose = |rotation| Pose {
        rotation,
        position: DVec3::ZERO,
    };
    let [a, b] = [0.1, 0.3].map(DQuat::from_rotation_z);
    for b in [b, -b] {
        let between = pose(a).towards(&pose(b), 0.5).rotation;
        assert!(angle(between, DQuat::from_rotation_z(0.2)) < 1e-12);
    }
}

#[test]
fn frames_are_those_of_the_span() {
    let motion = |from, to, closed| {
        let span = Span { from, to, closed };
        let placement = Placement {
            anchor: DAffine3::IDENTITY,
            scale: 1.0,
        };
        Motion::new(circle(1.0, 0.1, 101, 0.1), span, placement, None).unwrap()
    };
    // At its own rate a file has its own poses, and ten seconds have ten times the rate.
    assert_eq!(motion(0.0, 10.0, true).frames(10.0), 101);
    assert_eq!(motion(0.0, 10.0, false).frames(30.0), 300);
    assert_eq!(motion(2.5, 5.0, false).frames(72.0), 180);
    assert_eq!(motion(0.0, 10.0, true).frames(0.01), 1);
    assert_eq!(motion(0.0, 10.0, false).frames(0.01), 1);
    assert_eq!(motion(0.0, 10.0, true).frames(7.0), 71);
}

fn trajectories() -> impl Strategy<Value = Trajectory> {
    let part = || -1.0..1.0f64;
    let pose = (
        [part(), part(), part(), part()],
        [-50.0..50.0f64, -50.0..50.0, -50.0..50.0],
    );
    let sample = (1e-3..3.0f64, pose);
    prop::collection::vec(sample, 2..12).prop_map(|all| {
        let mut now = 0.0;
        let samples = all.iter().enumerate().map(|(k, (step, (turn, position)))| {
            now += if k == 0 { 0.0 } else { *step };
            let turn = DQuat::from_array(*turn);
            let rotation = match turn.length() > 1e-3 {
                true => turn.normalize(),
                false => DQuat::IDENTITY,
            };
            Sample {
                seconds: now,
                pose: Pose {
                    rotation,
                    position: DVec3::from(*position),
                },
            }
        });
        Trajectory::of(&samples.collect::<Vec<_>>())
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Resampled at its own times a trajectory is its samples, and between two it is between them.
    #[test]
    fn own_times_give_own_samples(motion in trajectories(), share in 0.0..1.0f64) {
        for pair in motion.samples().windows(2) {
            prop_assert_eq!(motion.pose(pair[0].seconds), Some(pair[0].pose));
            let step = pair[1].seconds - pair[0].seconds;
            let found = motion.pose(pair[0].seconds + share * step).unwrap();
            let [from, to] = [pair[0].pose, pair[1].pose];
            let way = |a: &Pose, b: &Pose| (b.position - a.position).length();
            let off = way(&from, &found) + way(&found, &to) - way(&from, &to);
            prop_assert!(off.abs() < 1e-9, "{off}");
            let turn = |a: &Pose, b: &Pose| angle(a.rotation, b.rotation);
            prop_assert!(turn(&from, &found) <= turn(&from, &to) + 1e-9);
        }
        prop_assert_eq!(motion.pose(motion.seconds()), Some(motion.samples().last().unwrap().pose));
    }

    /// The first pose is the anchor to the bit, all are rigid, and the scale scales.
    #[test]
    fn a_placed_motion_begins_at_its_anchor(
        motion in trajectories(), from in 0.0..0.9f64, scale in 1e-3..1e3f64,
    ) {
        let lens = camera();
        let span = Span { from: from * motion.seconds(), to: motion.seconds(), closed: true };
        let placed = |scale| {
            let placement = Placement { anchor: lens.world_to_camera, scale };
            Motion::new(motion.clone(), span, placement, None).unwrap()
        };
        let (own, one) = (placed(scale), placed(1.0));
        prop_assert_eq!(own.camera(0, 30.0, &lens), lens);
        let first = motion.pose(span.from).unwrap();
        for k in 0..one.frames(30.0).min(40) {
            let [far, near] = [&own, &one].map(|motion| motion.camera(k, 30.0, &lens));
            let moved = |c: &Camera| c.position() - lens.position();
            let off = moved(&far) - scale * moved(&near);
            prop_assert!(off.length() < 1e-9 * (1.0 + scale * 200.0), "{off}");
            prop_assert_eq!(far.world_to_camera.matrix3, near.world_to_camera.matrix3);
            // As the file has it: distances from the first pose, and the turn from it.
            let seconds = (span.from + f64::from(k) / 30.0).min(motion.seconds());
            let pose = motion.pose(seconds).unwrap();
            let distance = (pose.position - first.position).length();
            prop_assert!((moved(&near).length() - distance).abs() < 1e-9);
            let turn = near.world_to_camera.matrix3 * lens.world_to_camera.matrix3.transpose();
            let turn = DQuat::from_mat3(&turn).normalize();
            prop_assert!((angle(turn, DQuat::IDENTITY) - angle(first.rotation, pose.rotation)).abs() < 1e-6);
        }
    }

    /// Damaged files are read as poses that can be rendered from, or refused in a line that names
    /// the file.
    #[test]
    fn damaged_files_are_refused_or_sound(which in 0..3usize, changes in damages()) {
        let folder = Folder::new();
        let motion = circle(2.0, 0.7, 5, 0.1);
        let text = match which {
            0 => tum(motion.samples()),
            1 => euroc(motion.samples(), HEADER),
            _ => motion.samples().iter().map(|s| rows(&s.pose) + "\n").collect(),
        };
        let path = folder.write("a.txt", damaged(text.as_bytes(), &changes));
        match read(&path, &FileFacts::default(), &mut Notes::default()) {
            Ok(found) => {
                prop_assert!(found.samples().len() > 1);
                let pose = found.pose(found.seconds() / 2.0).unwrap();
                prop_assert!(pose.position.is_finite() && pose.rotation.is_normalized());
            }
            Err(error) => {
                let error = error.to_string();
                prop_assert!(error.contains("a.txt") && !error.contains('\n') && error.len() < 1000, "{}", error);
            }
        }
    }
}
