//! Rounds that lanes take at the banks.

use potamoi_formats::config::Config;
use potamoi_formats::rit::{MAX_VERTICES, RitEntry, Vertices};

/// Rounds of each vertex of R entries, 1 and up; 0 past the last vertex.
pub type Rounds = [u16; MAX_VERTICES];

/// The rounds of every R entries, from their rows alone: a bank gives one row a
/// round, to all lanes that want it, so a vertex takes as many rounds as the
/// busiest bank has different rows to give.
///
/// Rows are told apart by the bits that name one of `mvoxel.rows`: a row that
/// is not loaded takes part by these.
#[must_use]
pub fn rounds(config: &Config, vertices: Vertices, entries: &[RitEntry]) -> Vec<Rounds> {
    let banks = config.gu.banks as usize;
    let bits = usize::BITS - (config.mvoxel.rows as usize - 1).leading_zeros();
    let names = (1usize << bits) - 1;
    // Lists of the different rows that each bank was asked for.
    let mut asked: Vec<Vec<usize>> = vec![vec![]; banks];
    entries
        .chunks(config.gu.lanes.max(1) as usize)
        .map(|lanes| {
            let mut rounds = Rounds::default();
            for (v, count) in rounds.iter_mut().enumerate().take(vertices.count()) {
                asked.iter_mut().for_each(Vec::clear);
                for entry in lanes {
                    let row = usize::from(entry.rows[v]) & names;
                    let of_bank = &mut asked[row % banks];
                    if !of_bank.contains(&row) {
                        of_bank.push(row);
                    }
                }
                *count = asked.iter().map(Vec::len).max().unwrap_or(0) as u16;
            }
            rounds
        })
        .collect()
}
