//! Columns of the dialects, and their treatment.

use potamoi_base::file_keys::Fate::{Honoured, Listed, Refused};
use potamoi_base::file_keys::{Format, key};

/// Every dialect.
pub(in super::super) static FORMATS: [&Format; 5] = [&TUM, &EUROC, &KITTI, &REPLICA, &POSES];

static TUM: Format = Format {
    name: "TUM trajectories",
    files: "`[camera] kind = \"trajectory\"`, `format = \"tum\"`: a line a pose, 8 numbers between \
            blanks or commas. Lines that begin with `#` are comments.",
    keys: &[
        key(
            "timestamp",
            Honoured,
            "seconds; times go forward, and a line that repeats one is listed",
        ),
        key("tx, ty, tz", Honoured, "the camera's position, -1e9 to 1e9"),
        key(
            "qx, qy, qz, qw",
            Honoured,
            "its rotation, camera to world, looking along +z with y down; of length 1, to 0.01",
        ),
    ],
    others: Refused,
};

pub(super) static EUROC: Format = Format {
    name: "EuRoC trajectories",
    files: "`[camera] kind = \"trajectory\"`, `format = \"euroc\"`: `data.csv` of a ground truth, with \
            or without its header.",
    keys: &[
        key("timestamp", Honoured, "whole nanoseconds, from 0"),
        key("p_*x, p_*y, p_*z", Honoured, "the body's position"),
        key(
            "q_*w, q_*x, q_*y, q_*z",
            Honoured,
            "its rotation, body to world; of length 1, to 0.01. `camera.t_bs` is the camera in the body",
        ),
        key("v_*", Listed, "velocity: positions state it"),
        key("b_*", Listed, "biases of the inertial sensor"),
    ],
    others: Listed,
};

static KITTI: Format = Format {
    name: "KITTI trajectories",
    files: "`[camera] kind = \"trajectory\"`, `format = \"kitti\"`: poses of the odometry benchmark, a \
            line a pose. `camera.times`, or a times.txt beside it, has the times; else 10 a second are \
            assumed.",
    keys: &[key(
        "r11 r12 r13 t1 ... t3",
        Honoured,
        "three rows: a rotation, to 0.001, and a translation, camera to world, looking along +z with y down",
    )],
    others: Refused,
};

static REPLICA: Format = Format {
    name: "Replica trajectories",
    files: "`[camera] kind = \"trajectory\"`, `format = \"replica\"`: `traj.txt` as NICE-SLAM has it, a \
            line a pose. 30 a second are assumed, unless `camera.file_hz` is given.",
    keys: &[key(
        "r11 r12 r13 t1 ... r44",
        Honoured,
        "four rows: a rotation and a translation, camera to world, looking along +z with y down; the last is 0 0 0 1",
    )],
    others: Refused,
};

static POSES: Format = Format {
    name: "Timestamped matrices",
    files: "`[camera] kind = \"trajectory\"`, `format = \"poses\"`: a line a pose, 13 or 17 numbers \
            between blanks or commas.",
    keys: &[
        key("timestamp", Honoured, "seconds"),
        key(
            "r11 r12 r13 t1 ...",
            Honoured,
            "three or four rows, camera to world, looking along +z with y down",
        ),
    ],
    others: Refused,
};
