//! The frozen list, and the bench on one input.
#![allow(clippy::unwrap_used, clippy::panic)]

use potamoi_rivals::Verdict;

use super::{BenchScene, FairBench, FrozenInputs};
use crate::{Machine, Row, Workbench, Workload};

fn workload(frames: u32) -> Workload {
    Workload {
        frames,
        quality: false,
        ..Workload::default()
    }
}

/// A trace changes where the renderer, the scene or the counting does: on purpose, the digest in `frozen.toml` is
/// written anew, and the reason goes into the commit.
#[test]
fn traces_are_those_of_the_frozen_list() {
    let list = FrozenInputs::read().unwrap();
    let bench = Workbench::default();
    let mut changed = vec![];
    for own in list.open().unwrap() {
        let traced = bench.traced(&own.scene, &workload(list.frames)).unwrap();
        let (found, known) = (traced.trace.digest(), own.digest.unwrap());
        if found != known {
            changed.push(format!(
                "{}: {found} {:?}",
                own.scene.name(),
                traced.trace.counts
            ));
        }
    }
    assert!(changed.is_empty(), "{}", changed.join("\n"));
}

#[test]
fn machines_gpus_and_rivals_meet_one_trace() {
    let list = FrozenInputs::read().unwrap();
    let first = list.open().unwrap().swap_remove(0);
    let machines = [Machine::named("paper").unwrap()];
    let other = BenchScene {
        digest: Some("another".to_owned()),
        scene: first.scene.clone(),
    };
    let found = FairBench::of(&machines, &[first, other], list.frames, &()).unwrap();
    let [input, changed] = &found.inputs[..] else {
        panic!("{} inputs", found.inputs.len());
    };
    assert!(input.is_as_frozen() && !changed.is_as_frozen());
    assert!(matches!(input.machines[0], Row::Figures(_)));
    let counts = &input.trace.counts;
    let of = |name: &str| counts[name];
    // 64 x 64 pixels; what is drawn lies in subtiles, and those in tiles.
    assert_eq!(of("pixels"), 4096.0);
    assert!(of("drawn-pixels") < of("subtile-pixels") && of("subtile-pixels") < of("tile-pixels"));
    assert!(of("tile-pixels") <= 256.0 * of("pairs"));
    let gscore = input
        .rivals
        .iter()
        .find(|own| own.rival == "gscore")
        .unwrap();
    let frame = gscore.estimate.as_ref().unwrap().frame;
    let rendering = of("tile-pixels") / 64e9;
    let memory = (236.0 * of("gaussians") + 9.2 * of("pairs") + 4.8 * of("pixels")) / 51.2e9;
    assert!(
        (frame.most - rendering.max(memory)).abs() < 1e-12,
        "{frame:?}"
    );
    for own in &input.rivals {
        assert_eq!(
            own.estimate.is_some(),
            own.rival == "gscore",
            "{}",
            own.rival
        );
        assert_eq!(own.refused.is_some(), own.rival != "gscore");
    }
    let csv = found.csv().unwrap();
    let validated = |name| {
        let own = found
            .rivals
            .iter()
            .find(|own| own.rival.name == name)
            .unwrap();
        matches!(own.verdict, Verdict::Validated(_))
    };
    assert!(!validated("gscore") && !validated("cicero"));
    // Every constant of every rival stands in the file with its origin.
    let constants: usize = found
        .rivals
        .iter()
        .map(|own| own.rival.constants().len())
        .sum();
    let lines = csv.lines().filter(|line| line.starts_with("constant,"));
    assert_eq!(lines.count(), constants);
    assert!(csv.contains("constant,,cicero,power,,,W,unknown,"), "{csv}");
}
