//! Clocks of the project's memory model against those of DRAMsim3, on every device.
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use std::collections::HashSet;

use common::agree;
use potamoi_system::system_model::dram::Access;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Accesses of a sequence: enough for a hundred refreshes of LPDDR3.
const COUNT: u64 = 100_000;
/// What the model may be off where all is read.
const READ: f64 = 0.0005;
/// And where some is written: DRAMsim3 calls a write done when it is taken, the last some hundred
/// clocks before the model does.
const WRITTEN: f64 = 0.005;

fn read(address: u64) -> Access {
    Access {
        address,
        is_write: false,
    }
}

fn write(address: u64) -> Access {
    Access {
        address,
        is_write: true,
    }
}

/// Random runs of bursts. DRAMsim3 merges accesses to a burst that is on its way, so that each is
/// there once.
fn runs(seed: u64, length: u64) -> Vec<u64> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut seen = HashSet::new();
    let mut addresses = vec![];
    while addresses.len() < COUNT as usize {
        let start = random.random_range(0u64..1 << 25);
        let run = (start..start + length).filter(|burst| seen.insert(*burst));
        addresses.extend(run.map(|burst| 32 * burst));
    }
    addresses
}

#[test]
fn streams() {
    agree(
        "reads",
        &(0..COUNT).map(|i| read(32 * i)).collect::<Vec<_>>(),
        READ,
    );
    agree(
        "writes",
        &(0..COUNT).map(|i| write(32 * i)).collect::<Vec<_>>(),
        WRITTEN,
    );
    let copied = |i: u64| match i % 2 {
        0 => read(16 * i),
        _ => write((1 << 28) + 16 * (i - 1)),
    };
    agree(
        "a copy",
        &(0..COUNT).map(copied).collect::<Vec<_>>(),
        WRITTEN,
    );
}

#[test]
fn random_accesses() {
    let reads: Vec<_> = runs(1, 1).into_iter().map(read).collect();
    agree("random reads", &reads, READ);
    let mut random = Pcg64Mcg::seed_from_u64(2);
    let mixed = runs(2, 1).into_iter().map(|address| Access {
        address,
        is_write: random.random_bool(0.3),
    });
    let mixed: Vec<_> = mixed.collect();
    agree("random, three of ten written", &mixed, WRITTEN);
}

/// Between the two: runs of bursts at random places, as rows of features are, and strides.
#[test]
fn runs_and_strides() {
    for length in [2u64, 8, 64] {
        let accesses: Vec<_> = runs(3, length).into_iter().map(read).collect();
        agree(&format!("runs of {length}"), &accesses, READ);
    }
    for stride in [3u64, 128, 1024] {
        let accesses: Vec<_> = (0..COUNT).map(|i| read(32 * stride * i)).collect();
        agree(&format!("every {stride}th burst"), &accesses, READ);
    }
}
