#![allow(clippy::unwrap_used)]

use potamoi_base::camera::Camera;
use potamoi_warp::Profile;
use serde_json::Value;

use super::super::super::npu::Dataflow;
use super::*;

const OPTIONS: PathOptions = PathOptions {
    frames: 4,
    fps: 30.0,
    window: 3,
    phi: None,
    profile: Profile::Potamoi,
    array: [24, 24],
    is_double_buffered: false,
    cache: 512 << 10,
};

fn scene() -> Scene {
    Scene::open("lantern").unwrap()
}

fn path_key(options: &PathOptions) -> String {
    key("path", &scene(), &Config::paper())
        .value("path", options)
        .hex()
}

/// A list of options with each field changed alone. A field that is new does not compile until it
/// is changed here.
fn changed_options() -> Vec<PathOptions> {
    let PathOptions {
        frames,
        fps,
        window,
        phi: _,
        profile: _,
        array: [rows, columns],
        is_double_buffered,
        cache,
    } = OPTIONS;
    let o = OPTIONS;
    vec![
        PathOptions {
            frames: frames + 1,
            ..o
        },
        PathOptions {
            fps: fps * (1.0 + f64::EPSILON),
            ..o
        },
        PathOptions {
            window: window + 1,
            ..o
        },
        PathOptions {
            phi: Some(0.0),
            ..o
        },
        PathOptions {
            phi: Some(-0.0),
            ..o
        },
        PathOptions {
            profile: Profile::Paper,
            ..o
        },
        PathOptions {
            array: [rows + 1, columns],
            ..o
        },
        PathOptions {
            array: [rows, columns + 1],
            ..o
        },
        PathOptions {
            is_double_buffered: !is_double_buffered,
            ..o
        },
        PathOptions {
            cache: cache + 1,
            ..o
        },
    ]
}

fn all_differ(mut keys: Vec<String>) {
    let count = keys.len();
    keys.sort();
    keys.dedup();
    assert_eq!(keys.len(), count);
}

#[test]
fn every_option_of_a_path_is_in_its_key() {
    let mut keys: Vec<String> = changed_options().iter().map(path_key).collect();
    keys.push(path_key(&OPTIONS));
    all_differ(keys);
    assert_eq!(path_key(&OPTIONS), path_key(&OPTIONS.clone()));
}

#[test]
fn every_part_of_an_array_is_in_a_frames_key() {
    let Array {
        rows,
        columns,
        dataflow: _,
        is_double_buffered,
    } = Array::PAPER;
    let a = Array::PAPER;
    let arrays = [
        (a, 1),
        (a, 2),
        (
            Array {
                rows: rows + 1,
                ..a
            },
            1,
        ),
        (
            Array {
                columns: columns + 1,
                ..a
            },
            1,
        ),
        (
            Array {
                dataflow: Dataflow::OutputStationary,
                ..a
            },
            1,
        ),
        (
            Array {
                is_double_buffered: !is_double_buffered,
                ..a
            },
            1,
        ),
    ];
    let of = |(array, cache)| array_of(Key::new("frame", VERSION), array, cache).hex();
    all_differ(arrays.map(of).to_vec());
}

#[test]
fn every_channel_of_memory_is_in_a_replays_key() {
    let of = |channels| Memory::lpddr3(channels).identity().to_hex().to_string();
    all_differ([1, 2, 4].map(of).to_vec());
}

/// Changes the `n`th leaf of a value; whether there is one.
fn change_leaf(value: &mut Value, n: &mut usize) -> bool {
    match value {
        Value::Array(items) => items.iter_mut().any(|item| change_leaf(item, n)),
        Value::Object(fields) => fields.values_mut().any(|field| change_leaf(field, n)),
        leaf => {
            if *n > 0 {
                *n -= 1;
                return false;
            }
            *leaf = match leaf.take() {
                Value::Bool(is) => Value::Bool(!is),
                Value::Number(number) => match number.as_u64() {
                    Some(whole) => Value::from(whole + 1),
                    None => Value::from(number.as_f64().unwrap() * 1.5 + 1.0),
                },
                Value::String(text) => Value::from(text + "x"),
                _ => Value::from(1),
            };
            true
        }
    }
}

/// Every leaf of a configuration as it is written, changed alone, changes what is hashed; what is
/// written has every field, so that it reads back as the same configuration.
#[test]
fn every_number_of_a_configuration_is_in_the_key() {
    for (name, text) in potamoi_formats::config::PRESETS {
        let config = Config::from_toml(text, name).unwrap();
        let whole = serde_json::to_value(&config).unwrap();
        let again: Config = serde_json::from_value(whole.clone()).unwrap();
        assert_eq!(again, config, "{name}: a field is not written");
        let of = |value: &Value| Key::new("k", "1").value("configuration", value).hex();
        let mut keys = vec![of(&whole)];
        for leaf in 0.. {
            let mut changed = whole.clone();
            if !change_leaf(&mut changed, &mut { leaf }) {
                break;
            }
            keys.push(of(&changed));
        }
        assert!(keys.len() > 40, "{name}: {} leaves", keys.len());
        all_differ(keys);
    }
}

/// Configurations that differ in one field, as files say it, have other keys.
#[test]
fn configurations_that_differ_have_other_keys() {
    let texts = [
        "",
        "clock_mhz = 999\n",
        "[vu.exp]\niterations = 17\n",
        "[gu]\nbanks = 16\n",
    ];
    let of = |text| {
        let config = Config::from_toml(text, "t").unwrap();
        Key::new("k", "1").value("configuration", &config).hex()
    };
    all_differ(texts.map(of).to_vec());
}

/// Kinds of work, and all cameras of a scene, not its first alone.
#[test]
fn kinds_and_cameras_are_in_the_key() {
    let config = Config::paper();
    let mut looks_away = scene();
    looks_away.set_camera(Camera {
        width: 31,
        ..*scene().camera()
    });
    all_differ(vec![
        key("path", &scene(), &config).hex(),
        key("frame", &scene(), &config).hex(),
        key("path", &looks_away, &config).hex(),
        key("path", &Scene::open("garden").unwrap(), &config).hex(),
    ]);
    let names: Vec<_> = key("path", &scene(), &config).names().collect();
    assert!(
        ["version", "program", "configuration", "model", "path"]
            .iter()
            .all(|part| names.contains(part))
    );
}

/// Counts that somebody divided by ten are counted again.
#[test]
fn edited_counts_are_not_believed() {
    let folder = tempfile::tempdir().unwrap();
    let kept = WorkCache::new(folder.path());
    let mut scene = scene();
    scene.set_size(Some(16), Some(16)).unwrap();
    let frame = || kept.frame(&scene, &Config::paper(), Array::PAPER, 1 << 19);
    let (work, was_kept) = frame().unwrap();
    assert!(!was_kept && frame().unwrap().1);
    let file = std::fs::read_dir(folder.path()).unwrap().next().unwrap();
    let file = file.unwrap().path();
    let text = std::fs::read_to_string(&file).unwrap();
    let (head, body) = text.split_once('\n').unwrap();
    let mut counts: Value = serde_json::from_str(body).unwrap();
    counts["pixels"] = Value::from(counts["pixels"].as_u64().unwrap() / 10);
    for edited in [format!("{head}\n{counts}"), counts.to_string()] {
        std::fs::write(&file, edited).unwrap();
        let (again, was_kept) = frame().unwrap();
        assert!(!was_kept);
        assert_eq!(again, work);
    }
}
