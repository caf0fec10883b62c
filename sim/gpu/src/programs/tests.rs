//! Properties that hold for all programs, and figures of each from its source.
#![allow(clippy::unwrap_used)]

use super::*;
use crate::device::{Better, FIELDS};
use crate::{Kernel, Term};

/// Plausible counts of each program.
fn typical(own: &Registered) -> Counts {
    let value = |name: &str| match name {
        "gaussians" => 3e6,
        "visible" => 1e6,
        "pairs" => 8e6,
        "width" | "height" => 800.0,
        "walked" => 0.6,
        "blending" => 0.2,
        "longest" => 5.0,
        "rays" => 640e3,
        "in_box" | "looks" => 81e6,
        "in_mask" => 16e6,
        "by_alpha" => 9e6,
        "by_weight" => 4e6,
        "voxels" => 4.1e6,
        "channels" => 12.0,
        "lines" => 8.0,
        "sectors" => 10.0,
        "rounds" => 10.0,
        "parameters" => 12.2e6,
        "layers" => 1.0,
        _ => 5e6,
    };
    let one = |c: &Named| (c.name.to_owned(), value(c.name));
    own.counts().iter().map(one).collect()
}

fn seconds(own: &Registered, counts: &Counts, device: &Device) -> [f64; 3] {
    let bounds = own.frame(counts, device).unwrap().bounds(device);
    [bounds.max.seconds, bounds.mid(), bounds.sum.seconds]
}

#[test]
fn bounds_are_in_order_on_every_device() {
    for own in &PROGRAMS {
        for name in Device::names() {
            let device = Device::builtin(name).unwrap();
            let [max, mid, sum] = seconds(own, &typical(own), &device);
            assert!(
                0.0 < max && max <= mid && mid <= sum,
                "{} on {name}",
                own.name
            );
        }
    }
}

#[test]
fn twice_a_count_never_takes_less_time() {
    let device = Device::builtin("2080ti").unwrap();
    for own in &PROGRAMS {
        let before = seconds(own, &typical(own), &device);
        for count in own.counts().iter().filter(|c| c.kind != Kind::Fixed) {
            let mut more = typical(own);
            let value = more.get_mut(count.name).unwrap();
            *value = if count.kind == Kind::Share {
                (2.0 * *value).min(1.0)
            } else {
                2.0 * *value
            };
            let after = seconds(own, &more, &device);
            // Rounds share what is there, so that smaller tensors stay in L2.
            let slack = if count.name == "rounds" {
                0.9
            } else {
                1.0 - 1e-9
            };
            for (b, a) in before.into_iter().zip(after) {
                assert!(a >= b * slack, "{}: {}: {b} to {a}", own.name, count.name);
            }
        }
    }
}

#[test]
fn a_better_device_never_takes_more_time() {
    let device = Device::builtin("orin-nx").unwrap();
    for own in &PROGRAMS {
        let before = seconds(own, &typical(own), &device);
        for field in &FIELDS {
            let mut better = device.clone();
            *(field.place)(&mut better) *= if field.better == Better::More {
                1.5
            } else {
                0.5
            };
            let after = seconds(own, &typical(own), &better);
            for (b, a) in before.into_iter().zip(after) {
                assert!(a <= b * (1.0 + 1e-9), "{}: {}", own.name, field.key);
            }
        }
    }
}

#[test]
fn zero_counts_leave_host_ramp_and_waits_and_an_infinite_device_none() {
    let device = Device::builtin("a6000").unwrap();
    for own in &PROGRAMS {
        let zero: Counts = typical(own).into_keys().map(|k| (k, 0.0)).collect();
        let bounds = own.frame(&zero, &device).unwrap().bounds(&device);
        for (term, spent) in &bounds.sum.by_term {
            let fixed = matches!(term, Term::Host | Term::Ramp | Term::Wait);
            assert!(fixed || *spent == 0.0, "{}: {term:?}", own.name);
        }
        let infinite = Device::infinite();
        let none = own.frame(&typical(own), &infinite).unwrap();
        assert_eq!(none.bounds(&infinite).sum.seconds, 0.0, "{}", own.name);
    }
}

#[test]
fn counts_are_checked() {
    let device = Device::builtin("a6000").unwrap();
    let own = program("3dgs-viewer").unwrap();
    let refused = |counts: &Counts| own.frame(counts, &device).unwrap_err().to_string();
    let mut counts = typical(own);
    counts.remove("pairs");
    assert!(refused(&counts).contains("lacks the count `pairs`: pairs of a Gaussian"));
    counts.insert("pairs".into(), f64::NAN);
    assert!(refused(&counts).contains("`pairs` is NaN"));
    counts.insert("pairs".into(), 1e6);
    counts.insert("walked".into(), 1.5);
    assert!(refused(&counts).contains("from 0 to 1"));
    counts.insert("paris".into(), 1.0);
    assert!(refused(&counts).contains("no count `paris`; its counts are gaussians"));
    let message = program("ngp_pl").unwrap_err().to_string();
    assert!(message.contains("did you mean `ngp-pl`?"), "{message}");
}

/// 79 chunks of an 800 x 800 picture, each of about 137 operations and 17 waits.
#[test]
fn direct_voxgo_launches_what_its_source_does() {
    let device = Device::builtin("xavier-maxn").unwrap();
    let own = program("direct-voxgo").unwrap();
    let frame = own.frame(&typical(own), &device).unwrap();
    assert_eq!(frame.waits(), 79 * 17 + 1);
    let per_chunk = (frame.operations() - 6.0) / 79.0;
    assert!((130.0..160.0).contains(&per_chunk), "{per_chunk}");
}

/// About 58 operations and 6 waits a round.
#[test]
fn ngp_pl_waits_six_times_a_round() {
    let device = Device::builtin("2080ti").unwrap();
    let own = program("ngp-pl").unwrap();
    let frame = own.frame(&typical(own), &device).unwrap();
    assert_eq!(frame.waits(), 10 * 6);
    let per_round = (frame.operations() - 13.0) / 10.0;
    assert!((54.0..62.0).contains(&per_round), "{per_round}");
}

/// `render()` moves 570 bytes a Gaussian more than the viewer.
#[test]
fn render_activates_all_parameters() {
    let device = Device::builtin("a6000").unwrap();
    let bytes = |name| {
        let own = program(name).unwrap();
        let frame = own.frame(&typical(own), &device).unwrap();
        frame.kernels.iter().map(|k| k.dram_bytes).sum::<f64>()
    };
    let more = (bytes("3dgs-render") - bytes("3dgs-viewer")) / 3e6;
    assert!((560.0..580.0).contains(&more), "{more}");
}

/// A test that leaves nothing out costs its instructions and nothing else of sorting; one that leaves
/// out nearly half sorts that much less.
#[test]
fn tested_pairs_cost_instructions_and_what_is_left_out_is_not_sorted() {
    let of = |tested: f64, pairs: f64| {
        let splats = super::Splatting {
            gaussians: 1000.0,
            visible: 800.0,
            pairs,
            tested,
            width: 400.0,
            height: 400.0,
            ..super::Splatting::blank(super::Host::Viewer)
        };
        splats.preparation()
    };
    let sum = |kernels: &[Kernel], of: fn(&Kernel) -> f64| kernels.iter().map(of).sum::<f64>();
    let [plain, tested, fewer] = [of(0.0, 3200.0), of(3200.0, 3200.0), of(3200.0, 1760.0)];
    // A warp walks four times the mean: 32 instructions to count, 28 more to write; 64 a Gaussian.
    let added = sum(&tested, |k| k.instructions) - sum(&plain, |k| k.instructions);
    assert!(
        (added - (400.0 * 60.0 + 2.0 * 64.0 * 1000.0 / 32.0)).abs() < 1e-6,
        "{added}"
    );
    let pipes = |kernel: &Kernel| kernel.fp32 + kernel.int + kernel.sfu;
    assert!((sum(&tested, pipes) - sum(&plain, pipes) - added).abs() < 1e-6);
    assert_eq!(plain[3..], tested[3..]);
    for (all, fewer) in tested[3..].iter().zip(&fewer[3..]) {
        assert!(
            (fewer.dram_bytes - 0.55 * all.dram_bytes).abs() < 1e-6,
            "{fewer:?}"
        );
        assert!(
            (fewer.instructions - 0.55 * all.instructions).abs() < 1e-6,
            "{fewer:?}"
        );
    }
}
