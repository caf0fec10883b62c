//! Conservation, limits and monotonicity for random work.

use super::*;

/// Largest relative slowdown from even sharing of memory, when a job begins sooner.
pub(super) const SHARING: f64 = 5e-2;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// A frame spends what was counted, and no part is faster than its limit.
    #[test]
    fn a_frame_is_conserved_and_bounded(work in any_work(), which in 0usize..3) {
        let gathering = GATHERING[which];
        let system = System::default();
        let found = frame(&system, &work, gathering);
        let (spent, total) = (&found.spent, work.total());
        prop_assert_eq!(spent.done, total);
        // Bytes by where they are from.
        // What precedes rendering is the published rasterizer's.
        let prepared = kernels::indexing(&work);
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
            (spent.streamed_bytes, prepared.read_bytes + read + weights),
            (spent.written_bytes, prepared.written_bytes + shown + written),
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
        // Buffers on chip: all bytes of their ports, 48 of 16 bytes a clock, and one of 48.
        let array = total.input_bytes + total.output_bytes + 2 * total.partial_bytes;
        let vector = total.operand_bytes + total.result_bytes;
        let buffered = features + (array + vector) as f64;
        prop_assert!(near(spent.feature_buffer_bytes, buffered));
        prop_assert!(found.span_ns >= buffered / 768.0 * (1.0 - 1e-9));
        let weighed = total.weight_bytes as f64 + weights;
        prop_assert!(near(spent.weight_buffer_bytes, weighed));
        prop_assert!(found.span_ns >= weighed / 48.0 * (1.0 - 1e-9));
        for share in found.utilisation.values() {
            prop_assert!((0.0..=1.0 + 1e-9).contains(share));
        }
        // Energy: parts are none of them negative, and power is that of the parts.
        let parts = found.energy.named();
        prop_assert!(parts.iter().all(|(_, mj)| mj.is_some_and(|mj| mj >= 0.0 && mj.is_finite())));
        let chip = &spent.on_chip;
        let logic = [chip.gathering_pj, chip.vector_pj, chip.array_pj].map(Option::unwrap);
        let units = logic.iter().sum::<f64>() + chip.gathering_memories_pj.unwrap() + chip.buffers_pj.unwrap();
        let energy = &found.energy;
        let logic = [energy.gathering_unit_mj, energy.vector_unit_mj, energy.array_mj].map(Option::unwrap);
        let sum = logic.iter().sum::<f64>() + energy.buffers_mj.unwrap();
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
        prop_assert!((gathering == Gathering::Unit) == (energy.gathering_unit_mj > Some(0.0)));
        // Of these bytes the GPU's: what it gathers and finds, but not what units read and show.
        let gpu = &spent.gpu;
        let units = match gathering {
            Gathering::PixelOrder | Gathering::Streamed => features + weights + shown,
            Gathering::Unit => read - table + spilled + random + weights + shown,
        };
        let on_gpu = match gathering {
            Gathering::Unit => moved - units - table,
            _ => moved - units,
        };
        prop_assert!(near(gpu.memory_bytes, on_gpu), "{} {on_gpu}", gpu.memory_bytes);
        prop_assert!(gpu.launches > 0.0 && gpu.instructions > 0.0 && gpu.l1_lines > 0.0);
        // Four schedulers a multiprocessor issue an instruction a clock each.
        let device = &system.gpu.device;
        let at_best = gpu.instructions / (4.0 * device.multiprocessors * device.clock_ghz);
        prop_assert!(found.span_ns >= at_best);
        // Rows are opened for bursts, and memory refreshes every 3.9 us.
        prop_assert!(spent.rows_opened > 0.0 && spent.rows_opened <= spent.interconnect_bytes / 32.0 + 1.0);
        let ranks = 4 * 2;
        prop_assert!(found.refreshes.abs_diff((found.span_ns / 3900.0) as u64 * ranks) <= ranks);
        prop_assert_eq!(found.remote_mj, None);
    }

    /// Twice of any resource, for splats also of the feature buffer, slows no frame, except for the
    /// anomaly of sharing: a job that begins sooner takes bandwidth from others, for one block at
    /// most. For fields, a larger buffer also means larger ray groups, of which fewer take turns.
    #[test]
    fn more_of_a_resource_slows_no_frame(work in any_work(), which in 0usize..3) {
        let system = System::default();
        let spans = |system: &System| bounds(system, &work, GATHERING[which]).span_ns();
        let before = spans(&system);
        let wider = System { memory_channels: 8, ..system.clone() };
        let larger = System {
            feature_buffer_bytes: match work.gaussians {
                0 => system.feature_buffer_bytes,
                _ => 2 * system.feature_buffer_bytes,
            },
            ..system.clone()
        };
        let of = |change: fn(&mut System)| {
            let mut own = system.clone();
            change(&mut own);
            own
        };
        for (what, own) in [
            ("channels", wider),
            ("buffer", larger),
            ("interconnect", of(|s| s.interconnect_over_memory *= 2.0)),
            ("GPU's memory", of(|s| s.gpu.shares_memory = false)),
            ("weight buffer", of(|s| s.weight_buffer_bytes *= 2)),
            ("descriptors", of(|s| s.dma_descriptor_bytes /= 2.0)),
        ] {
            let after = spans(&own);
            prop_assert!(after.max <= before.max * (1.0 + SHARING), "{what}: {before:?} < {after:?}");
            prop_assert!(after.sum <= before.sum * (1.0 + SHARING), "{what}: {before:?} < {after:?}");
        }
        // Banks, of which so few are a limit.
        let banks = |all, block| System { feature_banks: all, feature_block_banks: block, ..system.clone() };
        let before = frame(&banks(2, 2), &work, GATHERING[which]).span_ns;
        for (all, block) in [(4, 2), (4, 4)] {
            let after = frame(&banks(all, block), &work, GATHERING[which]).span_ns;
            prop_assert!(after <= before * (1.0 + SHARING), "{all}, {block}: {before} < {after}");
        }
    }

    /// Twice the link or twice the remote GPU slows no path, except for the same anomaly.
    #[test]
    fn more_afar_slows_no_path(full in any_work(), seed in any_work()) {
        let sparse = FrameWork { batches: seed.batches, ..full.clone() };
        let path = path(&full, &sparse);
        let span = |system: &System, variant| {
            let model = Model { system, memory: memory(4), costs: costs(Program::of(&full)), clock_ghz: 1.0, weight_bytes: WEIGHTS, replay: None };
            let run = model.run(&path, variant, Scenario::Remote).unwrap().0.run.max;
            // The energy of what works afar is its own.
            let busy = run.utilisation[&job_scheduler::Resource::Remote] * run.span_ns;
            let watts = system.remote.watts() * busy + system.remote.idle_watts * (run.span_ns - busy);
            assert!(near(run.remote_mj.unwrap(), watts * 1e-6 / 6.0));
            run.span_ns
        };
        let system = System::default();
        let mut link = system.clone();
        link.link_bytes_per_second *= 2.0;
        let mut cores = system.clone();
        cores.remote.device.multiprocessors *= 2.0;
        for variant in Variant::ALL {
            let before = span(&system, variant);
            for own in [&link, &cores] {
                let after = span(own, variant);
                prop_assert!(after <= before * (1.0 + SHARING), "{}: {before} < {after}", variant.name);
            }
        }
    }

    /// A path has all its frames, and does the work of each once.
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
                prop_assert_eq!(found.run.max.spent.done.entries, entries, "{} {:?}", variant.name, scenario);
                let sent = timeline.iter().filter(|(job, _)| job.stage == "link").count();
                prop_assert_eq!(sent > 0, scenario == Scenario::Remote);
                let linked = found.run.max.energy.link_mj * 6.0;
                prop_assert!(near(linked, found.run.max.spent.link_bytes * 100.0 * 1e-6));
                prop_assert!(found.run.max.spent.written_bytes >= found.run.max.spent.link_bytes);
                let ends = timeline.iter().map(|(_, at)| at.end_ns).fold(0.0, f64::max);
                prop_assert_eq!(ends, found.run.max.span_ns);
            }
        }
    }
}

/// Every field of a batch is summed and split.
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
