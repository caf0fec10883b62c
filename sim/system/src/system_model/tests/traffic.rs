//! Memory traffic of a frame: replayed sequences, saving by streaming, short runs.

use super::*;

/// Replayed sequences replace the rates: full frames use their own, partial frames that of the
/// remaining pixels.
#[test]
fn known_sequences_stand_in_for_rates() {
    let mut work = some_work();
    (work.reads.missed_bytes, work.reads.misses) = (64_000, 2000);
    work.reads.not_streaming = 1000;
    (work.batches[0].row_bytes, work.batches[0].rit_bytes) = (32_000, 4000);
    work.batches[0].rit_read_bytes = 4000;
    let memory = memory(4);
    let sequence = |pj: f64| {
        let rate = Rate {
            ns: 1.0,
            pj,
            io_pj: 0.0,
            rows: 0.0,
        };
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
                model.frame(&work, gathering).unwrap().max
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

/// With half of the bytes random and then half as many bytes streamed, the saving splits into bytes
/// not moved, at the former mean, and streaming of the rest.
#[test]
fn memory_energy_is_saved_by_traffic_and_by_streaming() {
    let mut work = some_work();
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

/// Random rates come from the memory model: they cost more than streams and are hardly faster.
#[test]
fn short_runs_are_slower_and_dearer() {
    let memory = memory(4);
    let stream = memory.streamed();
    assert!((1.0 / stream.ns - 24.5).abs() < 0.2, "{stream:?}");
    let in_the_dies = |rate: &Rate| rate.pj - rate.io_pj;
    assert!((in_the_dies(&stream) / 8.0 - 4.7).abs() < 0.2, "{stream:?}");
    let mut before = memory.random(32.0);
    assert!(in_the_dies(&before) > 2.5 * in_the_dies(&stream));
    assert_eq!(before.io_pj, stream.io_pj);
    for run in [64.0, 256.0, 1024.0, 4096.0, 65536.0] {
        let own = memory.random(run);
        // Runs in both ranks use the bus while one is refreshed, which a stream does not.
        let (fastest, peak) = (0.98 * stream.ns, 1.0 / 25.6);
        assert!(
            own.ns <= before.ns * 1.03 && own.ns >= fastest.max(peak),
            "{run}: {own:?}"
        );
        assert!(own.pj <= before.pj * 1.01, "{run}");
        before = own;
    }
    // Two bytes cost a burst.
    let few = memory.random(2.0);
    assert!((few.ns / memory.random(32.0).ns - 16.0).abs() < 1e-9);
    assert!((few.pj / memory.random(32.0).pj - 16.0).abs() < 1e-9);
}
