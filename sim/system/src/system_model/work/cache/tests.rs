#![allow(clippy::unwrap_used)]

use potamoi_base::camera::Camera;
use potamoi_warp::Profile;
use serde_json::Value;

use super::*;
use potamoi_cycles::mac_array::Dataflow;

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

/// Scenes, configurations, paths and memories, the first as it is, each other one changed alone in
/// what all kinds of work depend on.
fn common() -> Vec<(Scene, Config)> {
    let mut looks_away = scene();
    looks_away.set_camera(Camera {
        width: 31,
        ..*scene().camera()
    });
    vec![
        (scene(), Config::paper()),
        (scene(), Config::preset("small").unwrap()),
        (Scene::open("garden").unwrap(), Config::paper()),
        (looks_away, Config::paper()),
    ]
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
fn all_that_a_path_depends_on_is_in_its_key() {
    let (own, paper) = (scene(), Config::paper());
    let of = |options: &PathOptions| path_key(&own, &paper, options).hex();
    let mut keys: Vec<String> = changed_options().iter().map(of).collect();
    keys.extend(common().iter().map(|(s, c)| path_key(s, c, &OPTIONS).hex()));
    all_differ(keys);
    assert_eq!(of(&OPTIONS), of(&OPTIONS.clone()));
}

#[test]
fn all_that_a_replay_depends_on_is_in_its_key() {
    let (own, paper) = (scene(), Config::paper());
    let [memory, wider] = [1, 2].map(Memory::with_channels);
    let of = |options: &PathOptions| replay_key(&own, &paper, options, &memory).hex();
    let mut keys: Vec<String> = changed_options().iter().map(of).collect();
    keys.extend((common().iter()).map(|(s, c)| replay_key(s, c, &OPTIONS, &memory).hex()));
    keys.push(replay_key(&own, &paper, &OPTIONS, &wider).hex());
    all_differ(keys);
}

#[test]
fn all_that_a_frame_depends_on_is_in_its_key() {
    let MacArray {
        rows,
        columns,
        dataflow: _,
        is_double_buffered,
    } = MacArray::PAPER;
    let a = MacArray::PAPER;
    let arrays = [
        (a, 1),
        (a, 2),
        (
            MacArray {
                rows: rows + 1,
                ..a
            },
            1,
        ),
        (
            MacArray {
                columns: columns + 1,
                ..a
            },
            1,
        ),
        (
            MacArray {
                dataflow: Dataflow::OutputStationary,
                ..a
            },
            1,
        ),
        (
            MacArray {
                is_double_buffered: !is_double_buffered,
                ..a
            },
            1,
        ),
    ];
    let (own, paper) = (scene(), Config::paper());
    let of = |(array, cache)| frame_key(&own, &paper, array, cache).hex();
    let mut keys = arrays.map(of).to_vec();
    let others = &common()[1..];
    keys.extend((others.iter()).map(|(s, c)| frame_key(s, c, a, 1).hex()));
    all_differ(keys);
}

#[test]
fn every_channel_of_memory_is_in_a_replays_key() {
    let of = |channels| {
        Memory::with_channels(channels)
            .identity()
            .to_hex()
            .to_string()
    };
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

#[test]
fn kinds_of_work_have_other_keys() {
    let (own, paper) = (scene(), Config::paper());
    all_differ(vec![
        key("path", &own, &paper).hex(),
        key("frame", &own, &paper).hex(),
    ]);
    let names: Vec<_> = path_key(&own, &paper, &OPTIONS).names().collect();
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
    let frame = || kept.frame(&scene, &Config::paper(), MacArray::PAPER, 1 << 19);
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
