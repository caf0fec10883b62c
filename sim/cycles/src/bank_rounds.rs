//! Rounds of bank accesses for lanes.

use potamoi_formats::config::Config;
use potamoi_formats::rit::{MAX_VERTICES, RitEntry, Vertices};

/// Rounds of each vertex of R entries, at least 1; 0 past the last vertex.
pub type Rounds = [u16; MAX_VERTICES];

/// The rounds of every R entries, from their rows alone. A bank delivers one row a round, to all
/// lanes that read it. A vertex thus takes as many rounds as the largest number of distinct rows in
/// one bank.
///
/// Rows are distinguished by the bits that address `mvoxel.rows`; a row that is not loaded counts
/// by these.
#[must_use]
pub fn rounds(config: &Config, vertices: Vertices, entries: &[RitEntry]) -> Vec<Rounds> {
    let mut out = vec![Rounds::default(); entries.len().div_ceil(lanes(config))];
    visit(config, vertices, entries, |group, v, asked| {
        out[group][v] = asked.iter().map(Vec::len).max().unwrap_or(0) as u16;
    });
    out
}

/// Bank conflicts of concurrent lanes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Waiting {
    /// Reads of all lanes.
    pub reads: u64,
    /// Distinct rows that wait for another row of their bank: conflicts as `potamoi characterise`
    /// counts them, with each vertex a round.
    pub rows: u64,
    /// Reads that would wait if lanes could not share a read of the same row.
    pub unshared: u64,
}

/// Bank conflicts, from the entries' rows alone.
#[must_use]
pub fn waiting(config: &Config, vertices: Vertices, entries: &[RitEntry]) -> Waiting {
    let mut out = Waiting {
        reads: (entries.len() * vertices.count()) as u64,
        ..Waiting::default()
    };
    let mut served = 0;
    visit(config, vertices, entries, |_, _, asked| {
        let used = asked.iter().filter(|rows| !rows.is_empty());
        let rows: usize = used.clone().map(|rows| rows.len() - 1).sum();
        out.rows += rows as u64;
        served += used.count() as u64;
    });
    out.unshared = out.reads - served;
    out
}

fn lanes(config: &Config) -> usize {
    config.gu.lanes.max(1) as usize
}

/// Calls `with` with the number of R entries, the vertex, and the distinct rows read from each bank.
fn visit(
    config: &Config,
    vertices: Vertices,
    entries: &[RitEntry],
    mut with: impl FnMut(usize, usize, &[Vec<usize>]),
) {
    let banks = config.gu.banks as usize;
    let bits = usize::BITS - (config.mvoxel.rows as usize - 1).leading_zeros();
    let names = (1usize << bits) - 1;
    let mut asked: Vec<Vec<usize>> = vec![vec![]; banks];
    for (group, lanes) in entries.chunks(lanes(config)).enumerate() {
        for v in 0..vertices.count() {
            asked.iter_mut().for_each(Vec::clear);
            for entry in lanes {
                let row = usize::from(entry.rows[v]) & names;
                let of_bank = &mut asked[row % banks];
                if !of_bank.contains(&row) {
                    of_bank.push(row);
                }
            }
            with(group, v, &asked);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn entries(rows: &[[u16; 2]]) -> Vec<RitEntry> {
        let entry = |rows: &[u16; 2]| RitEntry {
            slot: 0,
            rows: [rows[0], rows[1], 0, 0, 0, 0, 0, 0],
            weights: [0; 8],
        };
        rows.iter().map(entry).collect()
    }

    #[test]
    fn a_bank_gives_one_row_a_round_to_all_who_want_it() {
        let text = "[gu]\norganisation = \"feature-major\"\nbanks = 4\nlanes = 4\nports = 1";
        let config = Config::from_toml(text, "test").unwrap();
        // Vertex 0: rows 0, 4 and 8 share a bank, and 0 is shared. Vertex 1: four banks.
        let side = [[0, 0], [4, 1], [0, 2], [8, 3]];
        // Then one lane alone, and one row for two lanes.
        let more = [[5, 5], [5, 9]];
        let all = [&side[..], &more[..]].concat();
        let found = rounds(&config, Vertices::Two, &entries(&all));
        assert_eq!(found, [[3, 1, 0, 0, 0, 0, 0, 0], [1, 2, 0, 0, 0, 0, 0, 0]]);
        // Rows 4 and 8 wait for row 0, and 9 for 5.
        let found = waiting(&config, Vertices::Two, &entries(&all));
        let expected = Waiting {
            reads: 12,
            rows: 3,
            // Three lanes but one at bank 0, one at bank 1, twice.
            unshared: 5,
        };
        assert_eq!(found, expected);
    }
}
