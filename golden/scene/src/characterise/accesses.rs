//! Reads of a frame, counted in one pass without storing them.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::banks::{BLOCK, Conflicts, conflicts};
use super::oracle::Oracle;
use super::{BANKS, Banks, LANES, Memory};
use potamoi_fields::{FieldError, TableShape};

/// Number of reads in a batch.
const BATCH: usize = 1 << 20;
/// Maximum number of misses whose positions are kept.
const KEPT: usize = 1 << 16;
/// Bytes in a sector of a GPU's cache.
const SECTOR: u32 = 32;

/// Vectors of one size, consecutive in memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Vectors {
    /// Number of vectors.
    pub count: u32,
    /// Bytes of a vector.
    pub bytes: u32,
}

/// Behaviour of the reads of a frame in pixel-centric order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Accesses {
    /// The model's vectors, table after table.
    pub tables: Vec<Vectors>,
    /// Buffer statistics with the first number of [`LANES`] side by side.
    pub memory: Memory,
    /// The first 65,536 reads that miss the buffer: offset in the tables, and bytes.
    pub first_misses: Vec<(u64, u32)>,
    /// Bank statistics by [`LANES`], then by [`BANKS`].
    pub banks: [[Banks; BANKS.len()]; LANES.len()],
}

impl Accesses {
    /// Total bytes of all vectors.
    #[must_use]
    pub fn stored_bytes(&self) -> u64 {
        let of = |table: &Vectors| u64::from(table.count) * u64::from(table.bytes);
        self.tables.iter().map(of).sum()
    }
}

/// Lanes, which read lists of vectors.
pub(super) trait Lanes: Sync {
    /// Number of lanes.
    fn count(&self) -> usize;

    /// Maximum number of reads of a lane.
    fn reads(&self, lane: usize) -> usize;

    /// Appends the vectors that a lane reads, in order.
    fn list(&self, lane: usize, out: &mut Vec<u32>);
}

/// Number of the first vector of each table.
///
/// # Errors
/// There are more than 2^32 vectors.
pub(super) fn firsts(tables: &[Vectors]) -> Result<Vec<u32>, FieldError> {
    let mut first = 0u32;
    let mut all = vec![];
    for table in tables {
        all.push(first);
        first = first
            .checked_add(table.count)
            .ok_or_else(|| too_many(table.count as usize))?;
    }
    Ok(all)
}

fn too_many(rows: usize) -> FieldError {
    FieldError::Part {
        part: "tables",
        found: format!("{rows} rows and more"),
        expected: "below 2^32 rows".to_owned(),
    }
}

/// The vectors of a table: its rows, with two bytes a channel.
///
/// # Errors
/// There are more than 2^32 vectors.
pub(super) fn rows_of(table: &TableShape) -> Result<Vectors, FieldError> {
    let rows = table.rows();
    Ok(Vectors {
        count: u32::try_from(rows).map_err(|_| too_many(rows))?,
        bytes: 2 * table.channels() as u32,
    })
}

/// Reads of lanes that run side by side.
struct Block {
    /// Vectors in the order of rounds, for the first number of [`LANES`].
    vectors: Vec<u32>,
    conflicts: Conflicts,
}

fn block(lanes: &dyn Lanes, number: usize) -> Block {
    let own = number * BLOCK..lanes.count().min((number + 1) * BLOCK);
    let mut flat = Vec::with_capacity(own.clone().map(|lane| lanes.reads(lane)).sum());
    let mut ends = vec![0];
    for lane in own {
        lanes.list(lane, &mut flat);
        ends.push(flat.len());
    }
    let lists: Vec<&[u32]> = ends.windows(2).map(|w| &flat[w[0]..w[1]]).collect();
    let mut vectors = Vec::with_capacity(flat.len());
    for group in lists.chunks(LANES[0]) {
        let longest = group.iter().map(|lane| lane.len()).max().unwrap_or(0);
        for step in 0..longest {
            vectors.extend(group.iter().filter_map(|lane| lane.get(step)));
        }
    }
    Block {
        vectors,
        conflicts: conflicts(&lists),
    }
}

/// Counts the reads of a frame, lanes side by side, block after block. All lanes of a phase
/// precede those of the next phase. The buffer has `capacity` bytes.
///
/// # Errors
/// There are more than 2^32 vectors.
pub(super) fn count(
    tables: Vec<Vectors>,
    phases: &[&dyn Lanes],
    capacity: u32,
) -> Result<Accesses, FieldError> {
    let firsts = firsts(&tables)?;
    let stored: usize = tables.iter().map(|t| t.count as usize).sum();
    let one_size = tables.iter().all(|t| t.bytes == tables[0].bytes);
    let bytes_of = |vector: u32| match one_size {
        true => tables[0].bytes,
        false => tables[firsts.partition_point(|first| *first <= vector) - 1].bytes,
    };
    let mut blocks = phases.iter().flat_map(|phase| {
        let numbers = 0..phase.count().div_ceil(BLOCK);
        numbers.map(move |number| (*phase, number))
    });
    let mut next_batch = || {
        let (mut batch, mut reads) = (vec![], 0);
        while reads < BATCH
            && let Some((phase, number)) = blocks.next()
        {
            let lanes = number * BLOCK..phase.count().min((number + 1) * BLOCK);
            reads += lanes.map(|lane| phase.reads(lane)).sum::<usize>();
            batch.push((phase, number));
        }
        let made = batch.into_par_iter();
        made.map(|(phase, number)| block(phase, number))
            .collect::<Vec<Block>>()
    };
    let mut oracle = Oracle::new(capacity, stored);
    let mut memory = Memory::default();
    let mut first_misses = vec![];
    let mut offset = 0;
    let offsets: Vec<u64> = tables
        .iter()
        .map(|t| {
            let own = offset;
            offset += u64::from(t.count) * u64::from(t.bytes);
            own
        })
        .collect();
    let address = |vector: u32| {
        let table = firsts.partition_point(|first| *first <= vector) - 1;
        offsets[table] + u64::from(vector - firsts[table]) * u64::from(tables[table].bytes)
    };
    let mut waiting = Conflicts::default();
    let mut before = None;
    let mut batch = next_batch();
    while !batch.is_empty() {
        let consume = || {
            for vector in batch.iter().flat_map(|block| &block.vectors) {
                let bytes = bytes_of(*vector);
                memory.reads += 1;
                memory.read_bytes += u64::from(bytes);
                memory.sectors += u64::from(bytes.div_ceil(SECTOR));
                if oracle.read(*vector, bytes) {
                    continue;
                }
                memory.misses += 1;
                memory.bytes += u64::from(bytes);
                if first_misses.len() < KEPT {
                    first_misses.push((address(*vector), bytes));
                }
                let streams = before.is_some_and(|b: u32| b.checked_add(1) == Some(*vector));
                memory.not_streaming += u64::from(!streams);
                before = Some(*vector);
            }
            for block in &batch {
                let sums = waiting.as_flattened_mut().iter_mut();
                for (sum, own) in sums.zip(block.conflicts.as_flattened()) {
                    *sum += own;
                }
            }
        };
        // The next are found while these are looked up.
        let ((), next) = rayon::join(consume, &mut next_batch);
        batch = next;
    }
    let reads = memory.reads;
    Ok(Accesses {
        tables,
        memory,
        first_misses,
        banks: waiting.map(|own| own.map(|conflicts| Banks { reads, conflicts })),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    struct Lists(Vec<Vec<u32>>);

    impl Lanes for Lists {
        fn count(&self) -> usize {
            self.0.len()
        }
        fn reads(&self, lane: usize) -> usize {
            self.0[lane].len()
        }
        fn list(&self, lane: usize, out: &mut Vec<u32>) {
            out.extend(&self.0[lane]);
        }
    }

    fn vectors(count: u32, bytes: u32) -> Vectors {
        Vectors { count, bytes }
    }

    /// Two lanes read 0 to 4 and 5 to 9 round by round; the next phase reads
    /// vectors of another size one behind the other.
    #[test]
    fn phases_lanes_and_sizes_are_told_apart() {
        let first = Lists(vec![(0..5).collect(), (5..10).collect()]);
        let second = Lists(vec![vec![10, 11, 12, 0]]);
        let tables = vec![vectors(10, 4), vectors(3, 100)];
        let found = count(tables, &[&first, &second], 1000).unwrap();
        let memory = found.memory;
        assert_eq!((memory.reads, memory.misses), (14, 13));
        assert_eq!(memory.bytes, 10 * 4 + 3 * 100);
        // One vector of 4 bytes is read twice; 100 bytes are four sectors.
        assert_eq!(memory.read_bytes, 11 * 4 + 3 * 100);
        assert_eq!(memory.sectors, 11 + 3 * 4);
        // The tenth of the first table, then the second behind its 40 bytes.
        assert_eq!(found.first_misses[9..11], [(9 * 4, 4), (40, 100)]);
        // 0 5 1 6 2 7 3 8 4 9, 10 11 12: the last three stream.
        assert_eq!(memory.not_streaming, 10);
        assert_eq!(found.stored_bytes(), 340);
        assert_eq!(found.banks[0][0].conflicts, 0);
        // With no room, 0 misses again.
        let tables = vec![vectors(10, 4), vectors(3, 100)];
        let none = count(tables, &[&first, &second], 3).unwrap();
        assert_eq!(none.memory.misses, 14);
    }

    /// One thread, or several; more reads than a batch has.
    #[test]
    fn threads_do_not_change_what_is_counted() {
        let lane = |k: u32| {
            (0..6000)
                .map(|i| (i * (k % 7 + 1) + k * k) % 50_000)
                .collect()
        };
        let lists = Lists((0..400).map(lane).collect());
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let counted = || count(vec![vectors(50_000, 2)], &[&lists], 1 << 12).unwrap();
            pool.build().unwrap().install(counted)
        };
        let one = on(1);
        assert!(one.memory.reads as usize > 2 * BATCH);
        assert!(one.memory.misses > 50_000 && one.memory.misses < one.memory.reads);
        assert_eq!(one, on(3));
    }

    #[test]
    fn too_many_vectors_are_refused() {
        let error = firsts(&[vectors(u32::MAX, 2), vectors(1, 2)]).unwrap_err();
        assert!(error.to_string().contains("2^32"), "{error}");
    }
}
