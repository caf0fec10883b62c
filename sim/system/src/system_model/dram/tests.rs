#![allow(clippy::unwrap_used)]
use std::sync::LazyLock;

use potamoi_base::content_hash::hash_of;
use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::super::MemoryDevice;
use super::*;

/// The device that DRAMsim3's configuration describes: one rank, no bank groups.
static DEVICE: LazyLock<MemoryDevice> = LazyLock::new(|| device("lpddr3-1600-8gb"));
static TIMING: LazyLock<Timing> = LazyLock::new(|| DEVICE.timing());
static CURRENTS: LazyLock<Currents> = LazyLock::new(|| DEVICE.currents());

fn device(name: &str) -> MemoryDevice {
    MemoryDevice::builtin(name).unwrap()
}

fn devices() -> impl Iterator<Item = MemoryDevice> {
    MemoryDevice::names().into_iter().map(device)
}

fn read(address: u64) -> Access {
    Access {
        address,
        is_write: false,
    }
}

fn serve(channels: u32, accesses: &[Access]) -> Counts {
    serve_by(&DEVICE, channels, accesses)
}

fn serve_by(device: &MemoryDevice, channels: u32, accesses: &[Access]) -> Counts {
    Dram::new(device.geometry(channels), device.timing()).serve(accesses.iter().copied())
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

/// A stream takes the time of its data lines, and refreshes with what rows take to close and open
/// again: other ranks work meanwhile.
#[test]
fn a_stream_is_as_fast_as_the_bus_but_for_refresh() {
    let bursts = 12_000;
    for device in devices() {
        let (timing, geometry) = (device.timing(), device.geometry(1));
        for channels in [1, 4] {
            let done = serve_by(&device, channels, &stream(bursts));
            let least = bursts * timing.burst / u64::from(channels);
            let refreshed =
                least as f64 / (1.0 - timing.refresh as f64 / timing.refresh_interval as f64);
            let name = &device.name;
            assert!(
                done.clocks > least && (done.clocks as f64) < 1.04 * refreshed,
                "{name}: {done:?}, {least}, {refreshed}"
            );
            assert_eq!(done.reads, bursts);
            // A row of each group is opened once, and again after a refresh, which the next may have
            // been opened before.
            let rows = u64::from(geometry.row_bursts * geometry.bank_groups * channels);
            let opened = bursts.div_ceil(rows) * u64::from(channels * geometry.bank_groups);
            let again = 3 * done.refreshes * u64::from(geometry.bank_groups);
            assert!(done.activates <= opened + again, "{name}: {done:?}");
        }
    }
}

/// Four activates of a rank in tFAW: 2.56 GB/s of single bursts from a rank of LPDDR3 at most.
#[test]
fn random_bursts_are_bound_by_activates() {
    for device in devices() {
        let (timing, geometry) = (device.timing(), device.geometry(1));
        let done = serve_by(&device, 1, &random(6000, 0.0));
        let at_once = 4 * u64::from(geometry.ranks);
        assert!(done.clocks >= done.activates / at_once * timing.four_activates);
        let ns = done.clocks as f64 * timing.clock_ns;
        let rate = done.reads as f64 * 32.0 / ns;
        let window_ns = timing.four_activates as f64 * timing.clock_ns;
        let most = (32.0 * at_once as f64 / window_ns).min(device.peak_gb_s());
        assert!(
            (0.5 * most..most).contains(&rate),
            "{}: {rate}, {most}",
            device.name
        );
    }
    let done = serve(1, &random(6000, 0.0));
    let rate = done.reads as f64 * 32.0 / (done.clocks as f64 * TIMING.clock_ns);
    assert!((2.2..2.56).contains(&rate), "{rate}");
}

/// Two ranks open twice as many rows in the same time, and are refreshed by turns.
#[test]
fn ranks_share_a_bus_and_nothing_else() {
    let two = device("lpddr3-1600");
    let timing = two.timing();
    let serve = |ranks, accesses: &[Access]| {
        let geometry = Geometry {
            ranks,
            ..two.geometry(1)
        };
        Dram::new(geometry, timing).serve(accesses.iter().copied())
    };
    let scattered = random(8000, 0.0);
    let [one, both] = [1, 2].map(|ranks| serve(ranks, &scattered));
    let faster = one.clocks as f64 / both.clocks as f64;
    assert!((1.7..2.0).contains(&faster), "{faster}");
    let per_clock = |own: &Counts| own.refreshes as f64 / own.clocks as f64;
    assert!((per_clock(&both) / per_clock(&one) - 2.0).abs() < 0.05);
    // Bursts of two ranks by turns: each waits for the gap of the bus.
    let rank = 8 * 4096;
    let turns: Vec<_> = (0..1000).map(|i| read(i % 2 * rank + i / 2 * 32)).collect();
    let each = serve(2, &turns).clocks as f64 / 1000.0;
    let gap = (timing.burst + timing.rank_switch) as f64;
    assert!(each > timing.burst as f64 && each < 1.1 * gap, "{each}");
}

/// A burst of LPDDR5 follows one of another group at once, and one of its own two clocks later.
#[test]
fn bursts_of_a_bank_group_are_half_as_fast() {
    let own = device("lpddr5-6400");
    let every = |stride: u64| -> Vec<_> { (0..10_000).map(|i| read(32 * stride * i)).collect() };
    let [all, one] = [1, 4].map(|stride| serve_by(&own, 1, &every(stride)).clocks as f64);
    assert!((one / all - 2.0).abs() < 0.05, "{}", one / all);
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
    /// Every access is done once; nothing is faster than the bus or the first access; the same
    /// accesses take the same time.
    #[test]
    fn accesses_are_conserved_and_bounded(accesses in accesses(), which in 0usize..4) {
        let device = devices().nth(which).unwrap();
        let (timing, geometry) = (device.timing(), device.geometry(1));
        for channels in [1u32, 2, 4] {
            let done = serve_by(&device, channels, &accesses);
            let writes = accesses.iter().filter(|a| a.is_write).count() as u64;
            prop_assert_eq!(done.writes, writes);
            prop_assert_eq!(done.reads + done.writes, accesses.len() as u64);
            let reopened = u64::from(geometry.banks) * done.refreshes;
            prop_assert!(done.activates <= accesses.len() as u64 + 4 * reopened);
            let least = accesses.len() as u64 * timing.burst / u64::from(channels);
            prop_assert!(done.clocks >= least);
            prop_assert!(done.clocks >= timing.activate_to_column + timing.write_latency.min(timing.read_latency));
            prop_assert_eq!(done, serve_by(&device, channels, &accesses));
        }
    }
}

/// Kept rates and replays are of these rules: where the rules give anything else, the name changes,
/// and all is measured again.
#[test]
fn kept_results_are_named_after_what_the_rules_give() {
    let counts = devices().map(|device| {
        let mixed = [stream(3000), random(3000, 0.3)].concat();
        let own = serve_by(&device, 2, &mixed);
        [own.clocks, own.active_clocks, own.activates, own.refreshes]
    });
    let found = hash_of(&counts.collect::<Vec<_>>()).to_hex();
    assert_eq!(RESULTS, &found[..16], "write the new one into dram/mod.rs");
}
