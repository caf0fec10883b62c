#![allow(clippy::unwrap_used)]

use std::sync::OnceLock;

use potamoi_formats::config::Config;
use potamoi_golden::warp::Profile;
use proptest::prelude::*;

use super::work::{
    Batch, Classes, FrameWork, PathOptions, PathReplay, PathWork, Quality, Reads, Replay, Replayed,
    TargetWork,
};
use super::*;
use crate::synth::fit::Fit;
use crate::synth::{SynthReport, Synthesised};

pub(super) fn costs(program: Program) -> &'static Costs {
    static ALL: OnceLock<[Costs; 2]> = OnceLock::new();
    let make = |program| {
        let reports = Synthesised::checked_in().unwrap();
        let (fit, records) = (
            Fit::checked_in().unwrap(),
            SynthReport::of_records().unwrap(),
        );
        let config = Config::paper();
        Costs::new(
            &config,
            program,
            fit,
            &reports,
            &records,
            &reports[0].report,
        )
        .unwrap()
    };
    let all = ALL.get_or_init(|| [make(Program::Fields), make(Program::Splats)]);
    &all[usize::from(program == Program::Splats)]
}

/// Of four channels, or of eight.
pub(super) fn memory(channels: u32) -> &'static Memory {
    static ALL: OnceLock<[Memory; 2]> = OnceLock::new();
    let all = ALL.get_or_init(|| [4, 8].map(Memory::lpddr3));
    &all[usize::from(channels == 8)]
}

/// Batches that a frame could have, and counts beside them.
fn any_work() -> impl Strategy<Value = FrameWork> {
    let batch = (1u64..5_000, 1u64..40_000, 1u64..200_000, 1u64..200_000).prop_map(
        |(entries, rows, array, vector)| Batch {
            runs: 1,
            mvoxels: 1 + rows / 512,
            entries,
            gather_cycles: 4 * entries + rows / 8,
            gather_busy: 4 * entries,
            codes_read: entries * 8 * 13,
            row_bytes: rows * 26,
            rit_bytes: entries * 48,
            rit_read_bytes: entries * 48,
            feature_bytes: entries * 26,
            operations: 1,
            elements: vector,
            vector_cycles: vector,
            vector_busy: vector,
            products: 1,
            macs: array * 100,
            array_cycles: array,
            input_bytes: entries * 26,
            weight_bytes: 1152,
            output_bytes: entries * 6,
        },
    );
    let batches = prop::collection::vec(batch, 1..12);
    (batches, 1u64..1_000_000, any::<bool>()).prop_map(|(batches, samples, splats)| {
        let entries: u64 = batches.iter().map(|b| b.entries).sum();
        let own = |n: u64| if splats { n } else { 0 };
        FrameWork {
            pixels: 4096,
            frame_pixels: 4096,
            samples: samples - own(samples),
            gaussians: own(samples / 10 + 1),
            visible: own(samples / 20),
            left_out_coefficients: 0,
            pairs: own(entries),
            record_bytes: own(samples),
            spilled_bytes: samples / 3,
            scattered_bytes: batches[0].row_bytes,
            reads: Reads {
                tables: 1,
                model_bytes: 1 << 22,
                reads: entries * 8,
                bytes: entries * 8 * 26,
                sectors: entries * 8,
                missed_bytes: entries * 26,
                misses: entries,
                not_streaming: entries / 2,
                conflict_rate: 0.4,
            },
            batches,
        }
    })
}

/// Bytes of the weights of a model.
const WEIGHTS: u64 = 40_000;

const GATHERING: [Gathering; 3] = [Gathering::PixelOrder, Gathering::Streamed, Gathering::Unit];

fn frame(system: &System, work: &FrameWork, gathering: Gathering) -> Run {
    let model = Model {
        system,
        memory: memory(system.memory_channels),
        costs: costs(Program::of(work)),
        clock_ghz: 1.0,
        weight_bytes: WEIGHTS,
        replay: None,
    };
    model.frame(work, gathering).unwrap()
}

/// A path of two references that serve three targets each.
fn path(full: &FrameWork, sparse: &FrameWork) -> PathWork {
    let target = |number: usize| TargetWork {
        reference: (number > 0).then_some(number / 3),
        classes: Classes {
            warped: 4000,
            void: 0,
            rendered: 96,
        },
        work: (number > 0).then(|| sparse.clone()),
    };
    PathWork {
        scene: "made up".to_owned(),
        algorithm: "none".to_owned(),
        size: [64, 64],
        options: PathOptions {
            frames: 6,
            fps: 30.0,
            window: 3,
            phi: None,
            profile: Profile::Potamoi,
            array: [24, 24],
            is_double_buffered: false,
            cache: 1 << 19,
        },
        references: vec![full.clone(), full.clone()],
        reference_frames: vec![(Some(0), 0), (None, 1)],
        targets: (0..6).map(target).collect(),
        chained: (0..6)
            .map(|number| TargetWork {
                reference: (number % 3 > 0).then_some(number / 3),
                work: (number % 3 > 0).then(|| sparse.clone()),
                ..target(number)
            })
            .collect(),
        half: sparse.clone(),
        full_quality: Quality::default(),
        warped_quality: Quality::default(),
        chained_quality: Quality::default(),
        half_quality: Quality::default(),
    }
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(1.0)
}

/// What sharing memory evenly may cost a frame when something in it begins sooner.
const SHARING: f64 = 5e-2;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// What a frame spends is what was counted, and nothing is faster than its limit.
    #[test]
    fn a_frame_is_conserved_and_bounded(work in any_work(), which in 0usize..3) {
        let gathering = GATHERING[which];
        let system = System::default();
        let found = frame(&system, &work, gathering);
        let (spent, total) = (&found.spent, work.total());
        prop_assert_eq!(spent.done, total);
        // Bytes by where they are from.
        let parameters = work.gaussians as f64 * 59.0 * 4.0;
        let sorted = work.pairs as f64 * 8.0 * 12.0;
        let features = total.feature_bytes as f64;
        let (rows, table) = (total.row_bytes as f64, total.rit_bytes as f64);
        let (missed, spilled) = (work.reads.missed_bytes as f64, work.spilled_bytes as f64 / 2.0);
        let scattered = work.scattered_bytes as f64;
        let anywhere = missed * work.reads.not_streaming as f64 / work.reads.misses as f64;
        let weights = if work.batches.iter().any(|b| b.products > 0) { WEIGHTS as f64 } else { 0.0 };
        // Read in order, written, and read from anywhere.
        let [read, written, random] = match gathering {
            Gathering::PixelOrder => [missed - anywhere + features, features, anywhere],
            Gathering::Streamed => [
                rows - scattered + table + spilled + features,
                table + spilled + features,
                scattered,
            ],
            Gathering::Unit => [
                rows - scattered + total.rit_read_bytes as f64 + spilled,
                table + spilled,
                scattered,
            ],
        };
        let shown = work.pixels as f64 * 4.0;
        let expected = [
            (spent.streamed_bytes, parameters + sorted + read + weights),
            (spent.written_bytes, work.record_bytes as f64 + sorted + shown + written),
            (spent.random_bytes, random),
        ];
        for (own, expected) in expected {
            prop_assert!(near(own, expected), "{own} {expected}");
        }
        let moved = spent.streamed_bytes + spent.written_bytes + spent.random_bytes;
        // Four channels of 6.4 GB/s; each unit does a cycle a nanosecond.
        prop_assert!(found.span_ns >= moved / 25.6);
        prop_assert!(found.span_ns >= total.array_cycles as f64);
        prop_assert!(found.span_ns >= total.vector_cycles as f64);
        if gathering == Gathering::Unit {
            prop_assert!(found.span_ns >= total.gather_cycles as f64);
        }
        for share in found.utilisation.values() {
            prop_assert!((0.0..=1.0 + 1e-9).contains(share));
        }
        // Energy: parts are none of them negative, and power is that of the parts.
        let parts = found.energy.named();
        prop_assert!(parts.iter().all(|(_, mj)| *mj >= 0.0 && mj.is_finite()));
        let chip = &spent.on_chip;
        let units = chip.gathering_pj + chip.gathering_memories_pj + chip.vector_pj + chip.array_pj + chip.buffers_pj;
        let energy = &found.energy;
        let sum = energy.gathering_unit_mj + energy.vector_unit_mj + energy.array_mj + energy.buffers_mj;
        prop_assert!(near(units * 1e-9, sum));
        prop_assert!(near(energy.memory_mj, spent.memory_pj * 1e-9));
        // The DMA and the interconnect: a descriptor a transfer, all bytes in whole bursts.
        prop_assert!(near(spent.descriptor_bytes, 64.0 * spent.transfers as f64));
        prop_assert!(spent.transfers > 0 && near(spent.weight_bytes, weights));
        prop_assert!(near(energy.dma_mj, spent.descriptor_pj * 1e-9));
        let over = spent.interconnect_bytes - moved - spent.descriptor_bytes;
        prop_assert!(over >= -1e-6 && over <= 31.0 * spent.random_bytes, "{over}");
        prop_assert!(near(energy.interconnect_mj, 2e-9 * spent.interconnect_bytes));
        prop_assert!(found.span_ns >= spent.interconnect_bytes / 32.0);
        prop_assert!((gathering == Gathering::Unit) == (energy.gathering_unit_mj > 0.0));
    }

    /// Twice as fast a GPU, twice the channels, and of splats twice the feature buffer: no frame is
    /// slower, but for an anomaly of sharing: what begins sooner takes bytes from what others wait
    /// for, a block's at most at a time. Of fields a larger buffer is larger groups of rays, too,
    /// fewer of which take turns.
    #[test]
    fn more_of_a_resource_slows_no_frame(work in any_work(), which in 0usize..3) {
        let system = System::default();
        let before = frame(&system, &work, GATHERING[which]).span_ns;
        let mut faster = system.clone();
        faster.gpu = faster.gpu.reaching(2.0 * system.gpu.fields_efficiency);
        faster.gpu.splats_efficiency = 2.0 * system.gpu.splats_efficiency;
        faster.gpu.pictures_efficiency = 2.0 * system.gpu.pictures_efficiency;
        let wider = System { memory_channels: 8, ..system.clone() };
        let larger = System {
            feature_buffer_bytes: match work.gaussians {
                0 => system.feature_buffer_bytes,
                _ => 2 * system.feature_buffer_bytes,
            },
            ..system
        };
        for (what, own) in [("GPU", faster), ("channels", wider), ("buffer", larger)] {
            let after = frame(&own, &work, GATHERING[which]).span_ns;
            prop_assert!(after <= before * (1.0 + SHARING), "{what}: {before} < {after}");
        }
    }

    /// Paths: all frames are there, and the work of each is done once.
    #[test]
    fn a_path_does_the_work_of_its_frames(full in any_work(), seed in any_work()) {
        // Both of one kind.
        let sparse = FrameWork { batches: seed.batches.clone(), ..full.clone() };
        let path = path(&full, &sparse);
        let system = System::default();
        let model = Model { system: &system, memory: memory(4), costs: costs(Program::of(&full)), clock_ghz: 1.0, weight_bytes: WEIGHTS, replay: None };
        for variant in Variant::ALL {
            for scenario in [Scenario::Local, Scenario::Remote] {
                let (found, timeline) = model.run(&path, variant, scenario).unwrap();
                let (fulls, sparses) = match (variant.frames, scenario) {
                    (Frames::Full, Scenario::Local) => (6, 0),
                    (Frames::Half, Scenario::Local) => (0, 6),
                    (Frames::Full | Frames::Half, Scenario::Remote) => (0, 0),
                    (Frames::Warped, Scenario::Local) => (2, 5),
                    (Frames::Warped, Scenario::Remote) => (0, 5),
                    (Frames::Chained, Scenario::Local) => (2, 4),
                    (Frames::Chained, Scenario::Remote) => (0, 4),
                };
                let entries = fulls * full.total().entries + sparses * sparse.total().entries;
                prop_assert_eq!(found.run.spent.done.entries, entries, "{} {:?}", variant.name, scenario);
                let sent = timeline.iter().filter(|(job, _)| job.stage == "link").count();
                prop_assert_eq!(sent > 0, scenario == Scenario::Remote);
                let linked = found.run.energy.link_mj * 6.0;
                prop_assert!(near(linked, found.run.spent.link_bytes * 100.0 * 1e-6));
                prop_assert!(found.run.spent.written_bytes >= found.run.spent.link_bytes);
                let ends = timeline.iter().map(|(_, at)| at.end_ns).fold(0.0, f64::max);
                prop_assert_eq!(ends, found.run.span_ns);
            }
        }
    }
}

/// Accesses whose sequence is known take what it took when it was replayed: of a frame in full its
/// own, of a part of one what is left.
#[test]
fn known_sequences_stand_in_for_rates() {
    let mut work = proptest_free();
    (work.reads.missed_bytes, work.reads.misses) = (64_000, 2000);
    work.reads.not_streaming = 1000;
    (work.batches[0].row_bytes, work.batches[0].rit_bytes) = (32_000, 4000);
    work.batches[0].rit_read_bytes = 4000;
    let memory = memory(4);
    let sequence = |pj: f64| {
        let rate = Rate { ns: 1.0, pj };
        Some(Replayed {
            bytes: 1,
            at_rates: rate,
            replayed: rate,
            moved: 1.5,
        })
    };
    let of = |missed, loaded| Replay {
        missed: sequence(missed),
        loaded: sequence(loaded),
    };
    let path = PathReplay {
        full: of(100.0, 50.0),
        rest: Some(of(200.0, 60.0)),
    };
    let (stream, random) = (memory.streamed(), memory.random(32.0));
    for (gathering, bytes, at_rates, [full, rest]) in [
        (
            Gathering::PixelOrder,
            64_000.0,
            32_000.0 * (stream.pj + random.pj),
            [100.0, 200.0],
        ),
        (
            Gathering::Unit,
            36_000.0,
            36_000.0 * stream.pj,
            [50.0, 60.0],
        ),
    ] {
        for (pixels, each) in [(4096, full), (4095, rest)] {
            work.pixels = pixels;
            let run = |replay| {
                let system = System::default();
                let model = Model {
                    system: &system,
                    memory,
                    costs: costs(Program::Fields),
                    clock_ghz: 1.0,
                    weight_bytes: 0,
                    replay,
                };
                model.frame(&work, gathering).unwrap()
            };
            let (plain, known) = (run(None), run(Some(&path)));
            let more = known.spent.memory_pj - plain.spent.memory_pj;
            assert!((more / (bytes * each - at_rates) - 1.0).abs() < 1e-9);
            assert!(known.span_ns >= bytes, "{}", known.span_ns);
            assert!(known.spent.interconnect_bytes >= 1.5 * bytes);
        }
    }
    let saving = MemorySaving::of(memory, Some(&path), &work);
    assert!(near(saving.before_pj, 64_000.0 * 200.0));
}

/// Weights that fit are loaded once a path, others for each block; a slow interconnect is a limit of
/// its own, and descriptors cost what they are long.
#[test]
fn weights_descriptors_and_the_interconnect_cost_what_they_move() {
    let mut work = proptest_free();
    work.batches = vec![
        Batch {
            mvoxels: 3,
            feature_bytes: 1000,
            products: 2,
            ..work.batches[0]
        };
        4
    ];
    let of = |system: &System, gathering| frame(system, &work, gathering);
    let whole = of(&System::default(), Gathering::Unit);
    assert!(near(whole.spent.weight_bytes, WEIGHTS as f64));
    // Rows and entries of MVoxels, pixels of one block, weights.
    assert_eq!(whole.spent.transfers, 24 + 1 + 1);
    let small = System {
        weight_buffer_bytes: WEIGHTS - 1,
        feature_block_bytes: 1024,
        ..System::default()
    };
    let again = of(&small, Gathering::Unit);
    assert!(near(again.spent.weight_bytes, 4.0 * WEIGHTS as f64));
    assert!(again.energy.buffers_mj > whole.energy.buffers_mj);
    let slow = System {
        interconnect_bytes_a_clock: 0.25,
        ..System::default()
    };
    let (found, bytes) = (of(&slow, Gathering::Unit), whole.spent.interconnect_bytes);
    assert!(found.span_ns >= 4.0 * bytes && found.interconnect_utilisation > 0.5);
    assert!(whole.interconnect_utilisation < whole.memory_utilisation);
    let free = System {
        dma_descriptor_bytes: 0.0,
        interconnect_pj_per_byte: 0.0,
        ..System::default()
    };
    let found = of(&free, Gathering::Unit);
    assert!(found.energy.dma_mj == 0.0 && found.energy.interconnect_mj == 0.0);
    assert!(found.span_ns < whole.span_ns && whole.energy.dma_mj > 0.0);
}

/// Half of the bytes at random places, and half as many bytes streamed: what is saved is parted in
/// bytes not moved, at the mean of before, and what streaming saves of the rest.
#[test]
fn memory_energy_is_saved_by_traffic_and_by_streaming() {
    let mut work = proptest_free();
    work.reads.missed_bytes = 64_000;
    (work.reads.misses, work.reads.not_streaming) = (2000, 1000);
    work.batches[0].row_bytes = 20_000;
    (work.batches[0].rit_bytes, work.batches[0].rit_read_bytes) = (4000, 8000);
    let memory = memory(4);
    let found = MemorySaving::of(memory, None, &work);
    let (stream, write, random) = (
        memory.streamed().pj,
        memory.written().pj,
        memory.random(32.0).pj,
    );
    assert!(near(found.before_pj, 32_000.0 * (stream + random)));
    assert!(near(found.after_pj, 28_000.0 * stream + 4000.0 * write));
    assert!(near(
        found.by_traffic_pj,
        32_000.0 * (stream + random) / 2.0
    ));
    let saved = found.before_pj - found.after_pj;
    assert!(near(found.by_traffic_pj + found.by_streaming_pj, saved));
    let share = found.traffic_share().unwrap();
    assert!((0.5..0.8).contains(&share), "{share}");
    // Memory that streams already, and the same bytes: nothing is saved by either.
    work.reads.not_streaming = 0;
    (work.batches[0].row_bytes, work.batches[0].rit_bytes) = (64_000, 0);
    work.batches[0].rit_read_bytes = 0;
    let found = MemorySaving::of(memory, None, &work);
    assert!(found.by_traffic_pj == 0.0 && found.by_streaming_pj.abs() < 1e-6);
}

/// What is at rest, a multiplication's registers and idle watts are part of what a frame takes.
#[test]
fn what_waits_takes_energy_too() {
    let own = costs(Program::Fields);
    assert!(own.leakage_mw > 0.1, "{}", own.leakage_mw);
    // Two registers of 16 bits are a part of a multiplication that can be seen.
    assert!(own.mac_pj > 0.1 && own.mac_pj < 2.0, "{}", own.mac_pj);
    let work = proptest_free();
    let system = System::default();
    let run = frame(&system, &work, Gathering::Unit);
    let span = run.span_ns;
    assert!(near(run.energy.leakage_mj, own.leakage_mw * span * 1e-9));
    let busy = run.utilisation[&engine::Resource::Gpu] * span;
    let gpu = &system.gpu;
    let watts = gpu.watts * busy + gpu.idle_watts * (span - busy);
    assert!(near(run.energy.gpu_mj, watts * 1e-6));
    let least = memory(4).standby_mw(0.0) * span * 1e-9;
    let most = memory(4).standby_mw(1.0) * span * 1e-9;
    assert!(run.energy.standby_mj > least && run.energy.standby_mj <= most);
}

/// The paper's link: a raw frame of 800 x 800 takes 0.192 s and 0.192 J.
#[test]
fn a_raw_frame_takes_the_link_a_fifth_of_a_second() {
    let mut work = proptest_free();
    (work.pixels, work.frame_pixels) = (640_000, 640_000);
    let path = path(&work, &work);
    let system = System::default();
    let model = Model {
        system: &system,
        memory: memory(4),
        costs: costs(Program::Fields),
        clock_ghz: 1.0,
        weight_bytes: WEIGHTS,
        replay: None,
    };
    let found = model
        .run(&path, Variant::ALL[0], Scenario::Remote)
        .unwrap()
        .0;
    assert!((found.run.stages["link"].own_ns - 0.192e9).abs() < 1.0);
    assert!((found.run.energy.link_mj - 192.0).abs() < 1e-9);
    assert!(found.run.frames_per_second < 1.0 / 0.192);
}

/// What is calibrated to the paper's millisecond for a million points takes it.
#[test]
fn a_million_points_are_warped_in_a_millisecond() {
    let gpu = Gpu::XAVIER;
    let found = gpu.efficiency_that_warps(1_000_000, 1e6);
    assert!(
        (found / gpu.pictures_efficiency - 1.0).abs() < 1e-3,
        "{found}"
    );
}

/// Every field of a batch is summed and parted.
#[test]
fn all_counts_of_a_batch_are_summed() {
    let keys = toml::Table::try_from(Batch::default()).unwrap();
    let filled: toml::Table = (keys.keys().zip(1..))
        .map(|(key, i)| (key.clone(), toml::Value::Integer(10 * i)))
        .collect();
    let one: Batch = filled.try_into().unwrap();
    let mut sum = Batch::default();
    one.parts(7).for_each(|part| sum += part);
    assert_eq!(sum, one);
    assert!(one.parts(10).all(|part| part.runs == one.runs / 10));
}

/// Work of one batch.
fn proptest_free() -> FrameWork {
    FrameWork {
        pixels: 4096,
        frame_pixels: 4096,
        samples: 10_000,
        gaussians: 0,
        visible: 0,
        left_out_coefficients: 0,
        pairs: 0,
        record_bytes: 0,
        spilled_bytes: 0,
        scattered_bytes: 0,
        reads: Reads {
            reads: 8000,
            bytes: 16_000,
            sectors: 8000,
            ..Reads::default()
        },
        batches: vec![Batch {
            runs: 1,
            entries: 1000,
            gather_cycles: 4100,
            gather_busy: 4000,
            codes_read: 8000,
            ..Batch::default()
        }],
    }
}

/// Random rates are those of the memory model: dearer than streams, and never faster.
#[test]
fn short_runs_are_slower_and_dearer() {
    let memory = memory(4);
    let stream = memory.streamed();
    assert!((1.0 / stream.ns - 23.9).abs() < 0.2, "{stream:?}");
    assert!((stream.pj / 8.0 - 4.6).abs() < 0.2, "{stream:?}");
    let mut before = memory.random(32.0);
    assert!(before.pj > 2.5 * stream.pj);
    for run in [64.0, 256.0, 1024.0, 4096.0, 65536.0] {
        let own = memory.random(run);
        assert!(
            own.ns <= before.ns * 1.01 && own.ns >= stream.ns * 0.99,
            "{run}"
        );
        assert!(own.pj <= before.pj * 1.01, "{run}");
        before = own;
    }
    // Two bytes cost a burst.
    let few = memory.random(2.0);
    assert!((few.ns / memory.random(32.0).ns - 16.0).abs() < 1e-9);
    assert!((few.pj / memory.random(32.0).pj - 16.0).abs() < 1e-9);
}

#[test]
fn systems_that_cannot_be_are_refused_by_field() {
    for (text, field) in [
        ("memory_channels = 3", "memory_channels"),
        (
            "interconnect_bytes_a_clock = 0.0",
            "interconnect_bytes_a_clock",
        ),
        (
            "interconnect_pj_per_byte = -1.0",
            "interconnect_pj_per_byte",
        ),
        ("dma_descriptor_bytes = nan", "dma_descriptor_bytes"),
        ("array_rows = 0", "array_rows"),
        ("groups_in_flight = 0", "groups_in_flight"),
        ("feature_buffer_bytes = 100", "feature_buffer_bytes"),
        ("feature_block_bytes = 100", "feature_block_bytes"),
        ("[remote]\nmemory_gb_s = 0.0", "remote.memory_gb_s"),
        ("link_bytes_per_second = 0.0", "link_bytes_per_second"),
        ("link_nj_per_byte = -1.0", "link_nj_per_byte"),
        ("bandwidth = 1", "bandwidth"),
        ("dma_descriptor_bytes = 1e300", "dma_descriptor_bytes"),
        ("[gpu]\nfields_efficiency = 5.0", "gpu.fields_efficiency"),
        ("[gpu]\ncores = 0.0", "gpu.cores"),
        ("[gpu]\nshaders = 1", "shaders"),
        ("array_rows = \"many\"", "array_rows"),
    ] {
        let error = System::from_toml(text, "test.toml")
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("test.toml") && error.contains(field),
            "{error}"
        );
    }
    let made = System::from_toml("memory_channels = 2", "test.toml").unwrap();
    assert_eq!(
        made,
        System {
            memory_channels: 2,
            ..System::default()
        }
    );
    let made = System::from_toml("[remote]\nlaunch_us = 7.0", "test.toml").unwrap();
    let remote = Gpu {
        launch_us: 7.0,
        ..Gpu::RTX_2080_TI
    };
    assert_eq!(
        made,
        System {
            remote,
            ..System::default()
        }
    );
    let text = toml::to_string(&System::default()).unwrap();
    assert_eq!(
        System::from_toml(&text, "test.toml").unwrap(),
        System::default()
    );
}
