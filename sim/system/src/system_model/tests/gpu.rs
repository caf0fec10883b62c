//! The GPU at both bounds of its kernels.

use potamoi_gpu::{Better, Device, FIELDS};

use super::conservation::SHARING;
use super::*;
use crate::system_model::gpu_only::gpu_only;
use crate::system_model::kernels;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// No variant is slower where the GPU's demands overlap, units that take no time give at least
    /// what it has, and a bottleneck is no more than the whole.
    #[test]
    fn the_bounds_of_each_variant_are_in_order(full in any_work(), seed in any_work()) {
        let sparse = FrameWork { batches: seed.batches, ..full.clone() };
        let path = path(&full, &sparse);
        let system = System::default();
        let model = Model { system: &system, memory: memory(4), costs: costs(Program::of(&full)), clock_ghz: 1.0, weight_bytes: WEIGHTS, replay: None };
        for variant in Variant::ALL {
            for scenario in [Scenario::Local, Scenario::Remote] {
                let run = model.run(&path, variant, scenario).unwrap().0.run;
                let span = run.span_ns();
                prop_assert!(span.max <= span.sum * (1.0 + SHARING), "{}: {span:?}", variant.name);
                // Both do the same work.
                prop_assert_eq!(run.max.spent, run.sum.spent);
                for own in [&run.max, &run.sum] {
                    let free = own.free_units_ns;
                    prop_assert!(free <= own.span_ns);
                    // All bytes still move, and nothing but others' work and bytes takes time.
                    let bytes = [own.memory_utilisation, own.interconnect_utilisation];
                    let bytes = bytes.map(|share| share * own.span_ns);
                    prop_assert!(free >= bytes[0].max(bytes[1]) * (1.0 - 1e-9), "{free} {bytes:?}");
                    let others = own.demand.iter().filter(|(of, _)| !of.is_unit());
                    let others: f64 = others.map(|(_, share)| share * own.span_ns).sum();
                    let most = others + bytes[0] + bytes[1];
                    prop_assert!(free <= most * (1.0 + 1e-9), "{free} {others} {bytes:?}");
                    let (name, share) = own.bottleneck();
                    prop_assert!(share > 0.0 && share <= 1.0 + 1e-9, "{name}: {share}");
                }
            }
        }
    }

    /// A better figure of the device slows no frame at either bound, except for the anomaly of
    /// sharing, and never the GPU alone.
    #[test]
    fn a_better_device_slows_no_frame(work in any_work(), which in 0usize..3) {
        let system = System::default();
        let before = bounds(&system, &work, GATHERING[which]).span_ns();
        let alone = gpu_only(&system.gpu.device, &work);
        prop_assert!(alone.max <= alone.sum);
        for field in &FIELDS {
            let mut own = system.clone();
            *(field.place)(&mut own.gpu.device) *= match field.better {
                Better::More => 2.0,
                Better::Less => 0.5,
            };
            let after = bounds(&own, &work, GATHERING[which]).span_ns();
            prop_assert!(after.max <= before.max * (1.0 + SHARING), "{}", field.key);
            prop_assert!(after.sum <= before.sum * (1.0 + SHARING), "{}", field.key);
            let faster = gpu_only(&own.gpu.device, &work);
            prop_assert!(faster.max <= alone.max && faster.sum <= alone.sum, "{}", field.key);
        }
    }

    /// A device without limits takes no time of its own: its bytes of the shared memory remain.
    #[test]
    fn a_device_without_limits_takes_no_time(work in any_work(), which in 0usize..3) {
        let mut system = System::default();
        system.gpu.device = Device::infinite();
        let found = bounds(&system, &work, GATHERING[which]);
        prop_assert_eq!(found.max.demand[&job_scheduler::Resource::Gpu], 0.0);
        prop_assert_eq!(gpu_only(&system.gpu.device, &work), AtBounds::default());
        // With a memory of its own, not even these.
        system.gpu.shares_memory = false;
        let found = bounds(&system, &work, GATHERING[which]);
        prop_assert_eq!(found.sum.demand[&job_scheduler::Resource::Gpu], 0.0);
        prop_assert_eq!(found.max.span_ns, found.sum.span_ns);
    }

    /// Bytes of memory by pattern are those of the kernels.
    #[test]
    fn bytes_by_pattern_are_those_of_the_kernels(work in any_work()) {
        for own in [
            kernels::indexing(&work),
            kernels::gathering(&work),
            kernels::streamed_gathering(&work),
            kernels::warping(work.pixels),
            kernels::scaling(work.pixels).part(0.3).writing(100.0),
        ] {
            let bytes = own.sum(|kernel| kernel.dram_bytes);
            prop_assert!(near(bytes, own.memory_bytes()), "{own:?}");
            prop_assert!(own.read_bytes >= 0.0 && own.written_bytes >= 0.0);
        }
    }
}

/// Where demands do not overlap, the bytes of the shared memory stand in line with the rest.
#[test]
fn bytes_of_the_shared_memory_add_up_in_the_sum() {
    let mut work = some_work();
    (work.reads.missed_bytes, work.reads.misses) = (6_400_000, 200_000);
    let found = bounds(&System::default(), &work, Gathering::PixelOrder);
    let own = found.map(|run| run.stages["gathering"].own_ns);
    let alone = 6_400_000.0 * memory(4).streamed().ns;
    assert!(own.sum - own.max >= alone, "{own:?} {alone}");
}

/// Bank conflicts take the time of shared memory again: conflicts of half of the reads double it.
#[test]
fn conflicts_of_shared_memory_take_its_time() {
    let lines = |conflict_rate| {
        let mut work = some_work();
        work.reads.conflict_rate = conflict_rate;
        kernels::streamed_gathering(&work).sum(|kernel| kernel.l1_lines)
    };
    assert!(lines(0.0) > 0.0);
    assert!(near(lines(0.5), 2.0 * lines(0.0)));
}

/// Gaussians whose colours are a field (Compact-3DGS): tables are gathered and layers run before
/// they are blended.
#[test]
fn colours_of_a_field_are_gathered_before_they_are_blended() {
    let mut work = some_work();
    (work.samples, work.gaussians, work.pairs) = (0, 1000, 2000);
    work.batches[0].macs = 1_000_000_000;
    let device = Gpu::xavier().device;
    work.reads.tables = 1;
    let plain = gpu_only(&device, &work);
    work.reads.tables = 17;
    let coloured = gpu_only(&device, &work);
    assert!(coloured.max > plain.max && coloured.sum > plain.sum);
}

/// Pairs that are left out are tested, and neither sorted nor blended by our own program. The published
/// one lists all of the profile's, and blends as often.
#[test]
fn pairs_that_are_left_out_are_tested_and_not_sorted() {
    let mut work = some_work();
    (work.samples, work.gaussians, work.visible) = (0, 1000, 900);
    work.pairs = 2_000_000;
    let all = kernels::splatting(&work);
    assert_eq!(all, kernels::published_splatting(&work));
    (work.pairs, work.pairs_tested) = (1_200_000, 2_000_000);
    let fewer = kernels::splatting(&work);
    assert_eq!((fewer.pairs, fewer.tested), (1.2e6, 2e6));
    assert_eq!(kernels::published_splatting(&work), all);
    assert!(near(fewer.pairs * fewer.blending, all.pairs * all.blending));
    let moved = |work: &FrameWork| kernels::indexing(work).sum(|kernel| kernel.dram_bytes);
    let found = moved(&work);
    work.pairs_tested = 0;
    // 16 bytes of each Gaussian that is visible are read once more.
    assert!(near(found, moved(&work) + 16.0 * 900.0));
}

/// The paper says that a million points are warped in less than a millisecond.
#[test]
fn a_million_points_are_warped_in_less_than_a_millisecond() {
    let gpu = Gpu::xavier();
    let ns = |overlap| kernels::warping(1_000_000).ns(&gpu.device, overlap, true, false);
    let [max, sum] = [potamoi_gpu::Overlap::Whole, potamoi_gpu::Overlap::None].map(ns);
    assert!(0.2e6 < max && max < sum && sum < 1.5e6, "{max} {sum}");
}
