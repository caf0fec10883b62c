use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;

const TIMING: Timing = Timing::LPDDR3_1600;
const CURRENTS: Currents = Currents::LPDDR3_8GB;

fn read(address: u64) -> Access {
    Access {
        address,
        is_write: false,
    }
}

fn serve(channels: u32, accesses: &[Access]) -> Counts {
    Dram::new(Geometry::lpddr3(channels), TIMING).serve(accesses.iter().copied())
}

fn stream(count: u64) -> Vec<Access> {
    (0..count).map(|i| read(32 * i)).collect()
}

fn random(count: u64, written: f64) -> Vec<Access> {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let access = |_| Access {
        address: random.random_range(0u64..1 << 25) * 32,
        is_write: random.random_bool(written),
    };
    (0..count).map(access).collect()
}

/// 32 bits at 1600 MT/s are 6.4 GB/s; refresh takes 168 of 3120 clocks and what rows take to
/// close and open again.
#[test]
fn a_stream_is_as_fast_as_the_bus_but_for_refresh() {
    let bursts = 50_000;
    for channels in [1, 2, 4] {
        let done = serve(channels, &stream(bursts));
        let least = bursts * TIMING.burst / u64::from(channels);
        let refreshed = least as f64 / (1.0 - 168.0 / 3120.0);
        assert!(
            done.clocks > least && (done.clocks as f64) < 1.02 * refreshed,
            "{done:?}"
        );
        assert_eq!(done.reads, bursts);
        // A row is opened once, and again after a refresh.
        let rows = bursts.div_ceil(128 * u64::from(channels)) * u64::from(channels);
        assert!(done.activates <= rows + 2 * done.refreshes, "{done:?}");
    }
}

/// Four activates in 50 ns: 2.56 GB/s of single bursts at most.
#[test]
fn random_bursts_are_bound_by_activates() {
    let done = serve(1, &random(20_000, 0.0));
    assert!(done.clocks >= done.activates / 4 * TIMING.four_activates);
    let seconds = done.clocks as f64 * TIMING.clock_ns * 1e-9;
    let rate = done.reads as f64 * 32.0 / seconds;
    assert!((2.2e9..2.56e9).contains(&rate), "{rate}");
}

/// A write after a read waits until the bus has turned: read latency, burst and turnaround, less
/// the write's own latency.
#[test]
fn the_bus_turns_between_a_read_and_a_write() {
    let write = Access {
        address: 32,
        is_write: true,
    };
    let read_alone = serve(1, &[read(0)]).clocks;
    let turned = TIMING.read_latency + TIMING.burst + TIMING.turnaround - TIMING.write_latency;
    let written = turned + TIMING.write_latency - TIMING.read_latency;
    assert_eq!(serve(1, &[read(0), write]).clocks, read_alone + written);
}

/// Four hits of an open row are served, then the oldest access may open another, if the bank has
/// the time between two hits to close the row: another bank takes turns with it.
#[test]
fn hits_do_not_starve_another_row() {
    let [other_bank, other_row] = [4096, 8 * 4096];
    let mut accesses = vec![read(0), read(other_row)];
    accesses.extend((1..100).flat_map(|i| [read(32 * i), read(other_bank + 32 * i)]));
    assert_eq!(serve(1, &accesses).activates, 4);
    // Behind them it is no interruption.
    accesses.remove(1);
    accesses.push(read(other_row));
    assert_eq!(serve(1, &accesses).activates, 3);
}

/// JESD209-3C figures of the device: an access to an open row, and to a closed one.
#[test]
fn energies_are_those_of_the_currents() {
    let near = |found: f64, expected: f64| {
        assert!((found / expected - 1.0).abs() < 1e-3, "{found}, {expected}");
    };
    near(CURRENTS.activate_pj(), 2731.7);
    near(CURRENTS.read_pj(&TIMING), 1176.0);
    near(CURRENTS.write_pj(&TIMING), 1236.0);
    near(CURRENTS.refresh_pj(&TIMING), 41_530.0);
    // Picojoules a bit, standing by and refresh not counted (the paper: 3 to 1).
    let a_bit = |accesses: &[Access]| {
        let done = serve(4, accesses);
        let energy = CURRENTS.energy(&done, &TIMING, 4, done.clocks);
        energy.access_pj() / (256.0 * accesses.len() as f64)
    };
    let (streamed, scattered) = (a_bit(&stream(50_000)), a_bit(&random(50_000, 0.0)));
    let ratio = scattered / streamed;
    assert!((3.2..3.4).contains(&ratio), "{ratio}");
    assert!((4.65..4.75).contains(&streamed), "{streamed}");
}

#[test]
fn energy_of_nothing_is_standing_by() {
    let energy = CURRENTS.energy(&Counts::default(), &TIMING, 2, 800);
    assert_eq!(energy.access_pj(), 0.0);
    // 0.8 mA at 1.8 V and 26 mA at 1.2 V, two devices, a microsecond.
    assert!((energy.total_pj() - 2.0 * 32.64 * 1000.0).abs() < 1e-6);
}

fn accesses() -> impl Strategy<Value = Vec<Access>> {
    let one = (0u64..1 << 14, any::<bool>());
    let access = |(burst, is_write)| Access {
        address: 32 * burst,
        is_write,
    };
    prop::collection::vec(one.prop_map(access), 1..400)
}

proptest! {
    /// Every access is done once; nothing is faster than the bus or the first access; more
    /// channels are never slower by more than what order can cost.
    #[test]
    fn accesses_are_conserved_and_bounded(accesses in accesses()) {
        for channels in [1u32, 2, 4] {
            let done = serve(channels, &accesses);
            let writes = accesses.iter().filter(|a| a.is_write).count() as u64;
            prop_assert_eq!(done.writes, writes);
            prop_assert_eq!(done.reads + done.writes, accesses.len() as u64);
            prop_assert!(done.activates <= accesses.len() as u64 + 8 * done.refreshes * 4);
            let least = accesses.len() as u64 * TIMING.burst / u64::from(channels);
            prop_assert!(done.clocks >= least);
            prop_assert!(done.clocks >= TIMING.activate_to_column + TIMING.write_latency);
            prop_assert_eq!(done, serve(channels, &accesses));
        }
    }
}
