//! Beats of the gathering unit's streams as port words.

use crate::gather_work::{GatherWork, StreamError};
use crate::work::{MftPiece, RitPiece};

/// Packs beats into port words.
pub struct BeatWords<'a> {
    work: &'a GatherWork<'a>,
    /// Index of a task, and its packed entries.
    packed: (usize, Vec<u8>),
    /// `tdata` of the RIT stream.
    pub data: Vec<u32>,
    /// `tkeep` of the RIT stream.
    pub keep: Vec<u32>,
    /// `tdata` of the MFT stream.
    pub row: Vec<u32>,
    /// `tkeep` of the MFT stream, where it has one.
    pub row_keep: Vec<u32>,
}

impl<'a> BeatWords<'a> {
    /// Buffers without a beat.
    #[must_use]
    pub fn new(work: &'a GatherWork<'a>) -> Self {
        Self {
            work,
            packed: (usize::MAX, vec![]),
            data: vec![0; work.beat_bytes.div_ceil(4)],
            keep: vec![0; work.beat_bytes.div_ceil(32)],
            row: vec![0; work.banks.div_ceil(2)],
            row_keep: vec![0; work.banks.div_ceil(16)],
        }
    }

    /// Fills `data` and `keep` with a beat of the RIT stream.
    ///
    /// # Errors
    /// A slot that its entry cannot carry.
    pub fn rit(&mut self, piece: &RitPiece) -> Result<(), StreamError> {
        if self.packed.0 != piece.mvoxel {
            self.packed.1.clear();
            self.pack(piece.mvoxel)?;
            self.packed.0 = piece.mvoxel;
        }
        let from = piece.byte as usize;
        let count = 2 * piece.beat.halfwords as usize;
        let bytes = &self.packed.1[from..from + count];
        self.data.fill(0);
        for (word, part) in self.data.iter_mut().zip(bytes.chunks(4)) {
            for (i, byte) in part.iter().enumerate() {
                *word |= u32::from(*byte) << (8 * i);
            }
        }
        for (i, word) in self.keep.iter_mut().enumerate() {
            let left = count.saturating_sub(32 * i).min(32);
            *word = ((1u64 << left) - 1) as u32;
        }
        Ok(())
    }

    /// Packs the entries of a task.
    fn pack(&mut self, task: usize) -> Result<(), StreamError> {
        let packed = &mut self.packed.1;
        let placed = self.work.placed.get(task);
        if let Some(placed) = placed.filter(|p| !p.compact.is_empty()) {
            let words = placed.compact.iter().map(|entry| entry.word());
            packed.extend(words.flat_map(u64::to_le_bytes));
            return Ok(());
        }
        let entries = placed.map_or(&self.work.tasks[task].entries, |p| &p.entries);
        for entry in entries {
            let mut entry = *entry;
            if let Some(bit) = self.work.shared_rows {
                let [record, ..] = entry.rows;
                entry.rows[0] = record >> 1 | (record & 1) << bit;
            }
            entry
                .pack(self.work.vertices, packed)
                .map_err(|source| StreamError::Entry { task, source })?;
        }
        Ok(())
    }

    /// Fills `row` with a beat of the MFT stream, and `row_keep` in the feature-major organisation.
    pub fn mft(&mut self, piece: &MftPiece) {
        if self.work.rounds.is_some() {
            return self.block(piece);
        }
        let work = self.work;
        let row = piece.row as usize;
        self.row.fill(0);
        match work.placed.get(piece.mvoxel) {
            None if work.shared_rows.is_some() => {
                let records = work.tasks[piece.mvoxel].rows.len() / work.channels;
                for (i, first) in [0, work.width / 2].into_iter().enumerate() {
                    let record = Some(2 * row + i).filter(|record| *record < records);
                    self.vertex(piece, first, record);
                }
            }
            None => self.vertex(piece, 0, Some(row)),
            Some(placed) if work.vertices_a_row == 1 => {
                self.vertex(piece, 0, placed.own_row(placed.place_of(row)));
            }
            Some(placed) => {
                for parity in 0..work.vertices_a_row {
                    let place = placed.place_in_block(row, parity);
                    self.vertex(piece, parity * work.width, placed.own_row(place));
                }
            }
        }
    }

    /// Packs one channel of B rows.
    fn block(&mut self, piece: &MftPiece) {
        let (banks, channels) = (self.work.banks, self.work.channels);
        let segment = self.work.channels_of(piece.segment as usize);
        let beat = piece.row as usize;
        let (block, channel) = (beat / segment.len(), segment.start + beat % segment.len());
        let rows = self.work.tasks[piece.mvoxel].rows.chunks_exact(channels);
        self.row.fill(0);
        self.row_keep.fill(0);
        for (b, row) in rows.skip(block * banks).take(banks).enumerate() {
            self.row[b / 2] |= u32::from(row[channel] as u16) << (16 * (b % 2));
            self.row_keep[b / 16] |= 3 << (2 * (b % 16));
        }
    }

    /// Fills the lanes from `first` with a row of the task; without a row they stay 0.
    fn vertex(&mut self, piece: &MftPiece, first: usize, row: Option<usize>) {
        let Some(row) = row else {
            return;
        };
        let (width, channels) = (self.work.width, self.work.channels);
        let low = piece.segment as usize * width;
        let from = row * channels;
        let rows = &self.work.tasks[piece.mvoxel].rows;
        let codes = &rows[from + low..from + channels.min(low + width)];
        for (lane, code) in (first..).zip(codes) {
            self.row[lane / 2] |= u32::from(*code as u16) << (16 * (lane % 2));
        }
    }
}
