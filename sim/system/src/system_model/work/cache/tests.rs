#![allow(clippy::unwrap_used)]

use potamoi_base::camera::Camera;
use potamoi_warp::Profile;
use serde_json::Value;

use super::super::path::PathParts;
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
    parts: PathParts::All,
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
        parts: _,
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
        PathOptions {
            parts: PathParts::FullFrames,
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

/// Options that change what is rendered: all but the array and the GPU's cache.
fn rendered_options() -> Vec<PathOptions> {
    let all = changed_options().into_iter();
    all.filter(|own| rendered(own) != rendered(&OPTIONS))
        .collect()
}

#[test]
fn all_that_events_depend_on_is_in_their_key() {
    let (own, paper) = (scene(), Config::paper());
    let of = |options: &PathOptions| events_key(&own, &paper, options).hex();
    let options = rendered_options();
    // Array and cache are applied to them.
    assert_eq!(options.len() + 4, changed_options().len());
    let mut keys: Vec<String> = options.iter().map(of).collect();
    keys.extend(
        common()
            .iter()
            .map(|(s, c)| events_key(s, c, &OPTIONS).hex()),
    );
    all_differ(keys);
    for later in changed_options()
        .iter()
        .filter(|own| rendered(own) == rendered(&OPTIONS))
    {
        assert_eq!(of(later), of(&OPTIONS));
    }
    let pictures = |options: &PathOptions| pictures_key(&own, options).hex();
    let mut keys: Vec<String> = options.iter().map(pictures).collect();
    keys.extend([pictures(&OPTIONS), of(&OPTIONS)]);
    all_differ(keys);
    let loads = |options: &PathOptions| loads_key(&own, &paper, options, 32).hex();
    let mut keys: Vec<String> = options.iter().map(loads).collect();
    keys.extend([loads(&OPTIONS), of(&OPTIONS)]);
    keys.push(loads_key(&own, &paper, &OPTIONS, 64).hex());
    all_differ(keys);
}

/// Scenes and paths, and of the configuration which pairs are listed.
#[test]
fn all_that_reads_depend_on_is_in_their_key() {
    let (own, paper) = (scene(), Config::paper());
    let of = |options: &PathOptions| reads_key(&own, &paper, options).hex();
    let cached = PathOptions {
        cache: OPTIONS.cache + 1,
        ..OPTIONS
    };
    let mut keys: Vec<String> = rendered_options().iter().map(of).collect();
    keys.extend([
        of(&OPTIONS),
        of(&cached),
        frame_reads_key(&own, &paper, 1).hex(),
        frame_reads_key(&own, &paper, 2).hex(),
    ]);
    let scenes = [&common()[2].0, &common()[3].0];
    keys.extend(scenes.map(|scene| reads_key(scene, &paper, &OPTIONS).hex()));
    let listed = "[rit]\npairs = \"that-may-count\"\n";
    for more in ["", "[vu.exp]\niterations = 15"] {
        let config = Config::from_toml(&format!("{listed}{more}"), "test").unwrap();
        keys.push(reads_key(&own, &config, &OPTIONS).hex());
        keys.push(frame_reads_key(&own, &config, 1).hex());
    }
    all_differ(keys);
    let other = Config::from_toml("[vu.exp]\niterations = 15", "test").unwrap();
    assert_eq!(reads_key(&own, &other, &OPTIONS).hex(), of(&OPTIONS));
}

#[test]
fn all_that_a_replay_depends_on_is_in_its_key() {
    let (own, paper) = (scene(), Config::paper());
    let [memory, wider] = [1, 2].map(Memory::with_channels);
    let of = |options: &PathOptions| replay_key(&own, &paper, options, &memory).hex();
    let cached = PathOptions {
        cache: OPTIONS.cache + 1,
        ..OPTIONS
    };
    let mut keys: Vec<String> = rendered_options().iter().map(of).collect();
    keys.extend((common().iter()).map(|(s, c)| replay_key(s, c, &OPTIONS, &memory).hex()));
    keys.extend([
        of(&cached),
        replay_key(&own, &paper, &OPTIONS, &wider).hex(),
    ]);
    all_differ(keys);
}

/// Clock, lanes and pipeline of the vector unit are applied to events; with early termination lanes
/// decide lengths.
#[test]
fn what_is_applied_later_is_in_no_key() {
    let own = scene();
    let of = |text: &str| {
        let config = Config::from_toml(text, "t").unwrap();
        frame_key(&own, &config).hex()
    };
    for later in [
        "clock_ghz = 0.5\n",
        "[vu]\nlanes = 12\n",
        "[vu.exp]\npipelined = true\n",
        "[vu.exp]\niterations_per_clock = 2\n",
    ] {
        assert_eq!(of(later), of(""), "{later}");
    }
    let early = "[vu.exp]\nearly_out = true\n";
    let texts = [
        "",
        early,
        &format!("[vu]\nlanes = 12\n{early}"),
        "[vu.exp]\niterations = 17\n",
        "[gu]\nbanks = 16\n",
        "[gu]\nports = 1\n",
        "[mvoxel]\nrows = 256\n",
        "[rit]\nentries = 64\n",
    ];
    all_differ(texts.map(of).to_vec());
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

#[test]
fn kinds_of_work_have_other_keys() {
    let (own, paper) = (scene(), Config::paper());
    all_differ(vec![
        key("path", &own, &paper).hex(),
        key("frame", &own, &paper).hex(),
    ]);
    let names: Vec<_> = events_key(&own, &paper, &OPTIONS).names().collect();
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
    let is_frame = |path: &std::path::PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy();
        name.starts_with("frame-") && !name.starts_with("frame-reads")
    };
    let files = std::fs::read_dir(folder.path()).unwrap();
    let file = files
        .map(|file| file.unwrap().path())
        .find(is_frame)
        .unwrap();
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
