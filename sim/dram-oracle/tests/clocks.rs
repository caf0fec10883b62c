//! Clocks of the project's memory model against those of DRAMsim3, one to four channels.
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use common::agree;
use potamoi_system::system_model::dram::Access;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Accesses of a sequence: enough for a hundred refreshes.
const COUNT: u64 = 100_000;

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

#[test]
fn streams() {
    agree(
        "reads",
        &(0..COUNT).map(|i| read(32 * i)).collect::<Vec<_>>(),
    );
    agree(
        "writes",
        &(0..COUNT).map(|i| write(32 * i)).collect::<Vec<_>>(),
    );
    let copied = |i: u64| match i % 2 {
        0 => read(16 * i),
        _ => write((1 << 28) + 16 * (i - 1)),
    };
    agree("a copy", &(0..COUNT).map(copied).collect::<Vec<_>>());
}

#[test]
fn random_accesses() {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut address = || random.random_range(0u64..1 << 25) * 32;
    let reads: Vec<_> = (0..COUNT).map(|_| read(address())).collect();
    agree("random reads", &reads);
    let mut random = Pcg64Mcg::seed_from_u64(2);
    let mixed = (0..COUNT).map(|_| Access {
        address: random.random_range(0u64..1 << 25) * 32,
        is_write: random.random_bool(0.3),
    });
    agree("random, three of ten written", &mixed.collect::<Vec<_>>());
}

/// Between the two: runs of bursts at random places, as rows of features are, and strides.
#[test]
fn runs_and_strides() {
    let mut random = Pcg64Mcg::seed_from_u64(3);
    for run in [2u64, 8, 64] {
        let mut accesses = vec![];
        while accesses.len() < COUNT as usize {
            let start = random.random_range(0u64..1 << 25) * 32;
            accesses.extend((0..run).map(|i| read(start + 32 * i)));
        }
        agree(&format!("runs of {run}"), &accesses);
    }
    for stride in [3u64, 128, 1024] {
        let accesses: Vec<_> = (0..COUNT).map(|i| read(32 * stride * i)).collect();
        agree(&format!("every {stride}th burst"), &accesses);
    }
}
