//! Banks split by row, for more than two ports. Part `s` of a bank holds the rows `s`, `s + S` and
//! so on, and reads two of them at once. Ports that need a third row of a part wait for a turn.
//!
//! All banks read the same rows, so that one arbitration serves the whole table.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_netlist::{Feed, IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::row_position::RowPosition;
use crate::circuits::{is, popcount};
use crate::memory::{Size, halves};

/// Rows that a part reads at once.
const READS: u32 = 2;

/// The parts of the banks.
pub(super) struct SplitBanks {
    parts: u32,
    ports: u32,
    part: Arc<Module>,
}

/// Result of the arbitration.
pub(super) struct Turns {
    /// Ports whose row is read at the clock edge.
    pub(super) granted: Signal,
    /// No port has a row left to read.
    pub(super) complete: Signal,
    /// Read enable and line of each part's reads.
    reads: Vec<[LineRead; READS as usize]>,
    /// Source of each port's last word: part, then read.
    source: Vec<Signal>,
}

impl SplitBanks {
    pub(super) fn new(config: &Config, parts: u32) -> Result<Self, IrErrors> {
        let lines = config.mft_rows() / parts;
        let size = Size {
            words: lines,
            bits: config.gu.feature_bits,
        };
        Ok(Self {
            parts,
            ports: config.gu.ports,
            part: halves("mft_halves", size, READS)?,
        })
    }

    /// Arbitrates the requested rows, lower ports first; `rows` has for each port whether its row
    /// is loaded, and the row.
    pub(super) fn turns(
        &self,
        m: &mut ModuleBuilder,
        read: Signal,
        keep: Signal,
        rows: &[(Signal, Signal)],
    ) -> Turns {
        m.section("Turns: two rows a part");
        let part_bits = self.parts.ilog2();
        let served = m.reg("served", Ty::u(self.ports), 0);
        m.note(served, "ports whose row was read in an earlier turn");
        let mut wanted: Vec<(Signal, Signal)> = vec![];
        let (mut granted, mut left, mut source) = (vec![], vec![], vec![]);
        let mut reads = vec![[const { vec![] }; READS as usize]; self.parts as usize];
        for (p, &(ok, row)) in rows.iter().enumerate() {
            let kept = m.bit(keep, p as u32);
            let before = m.bit(served, p as u32);
            let not_yet = m.not(before);
            let wants = m.and(kept, not_yet);
            let wants = m.name(wants, &format!("wants{p}"));
            let part = m.slice(row, 0, part_bits);
            let part = m.name(part, &format!("part{p}"));
            let line = m.slice(row, part_bits, row.width() - part_bits);
            let place = place_in_part(m, p, (wants, part), &wanted);
            wanted.push((wants, part));
            left.extend(place.left);
            let gets = m.and(read, place.wants);
            let gets = m.name(gets, &format!("grant{p}"));
            granted.insert(0, gets);
            let loaded = m.and(gets, ok);
            let loaded = m.name(loaded, &format!("read_port{p}"));
            for (s, of_part) in reads.iter_mut().enumerate() {
                let here = is(m, part, s as u32);
                let here = m.and(loaded, here);
                let here = m.name(here, &format!("port{p}_reads{s}"));
                let Some(second) = place.second else {
                    of_part[0].push((here, line));
                    continue;
                };
                let first = m.not(second);
                for (list, which) in of_part.iter_mut().zip([first, second]) {
                    list.push((m.and(here, which), line));
                }
            }
            let from = m.data_reg(&format!("source{p}"), Ty::u(part_bits + 1));
            let second = place.second.unwrap_or_else(|| m.lit(0, Ty::bit()));
            let choice = m.cat(&[part, second]);
            m.set_next_if(from, gets, choice);
            source.push(from);
        }
        let left = m.any_of(&left);
        let none_left = m.not(left);
        let complete = m.and(read, none_left);
        let complete = m.name(complete, "complete");
        let granted = m.cat(&granted);
        let granted = m.name(granted, "granted_ports");
        let so_far = m.or(served, granted);
        let none = m.lit(0, served.ty());
        let after = m.mux(complete, none, so_far);
        m.set_next_if(served, read, after);
        Turns {
            granted,
            complete,
            reads: merged(m, &reads),
            source,
        }
    }

    /// The banks; for each port the words of all banks.
    pub(super) fn banks(
        &self,
        m: &mut ModuleBuilder,
        place: &RowPosition,
        turns: &Turns,
        lanes: Signal,
    ) -> Vec<Signal> {
        let part_bits = self.parts.ilog2();
        let to = m.slice(place.row, 0, part_bits);
        let line = m.slice(place.row, part_bits, place.row.width() - part_bits);
        let line = m.name(line, "write_line");
        let writes: Vec<_> = (0..self.parts)
            .rev()
            .map(|s| {
                let here = is(m, to, s);
                let write = m.and(place.write, here);
                m.name(write, &format!("write{s}"))
            })
            .collect();
        let writes = m.cat(&writes);
        let [low, high] = [0, 1].map(|r: usize| {
            let reads = turns.reads.iter().rev().map(|reads| reads[r]);
            let (enables, addresses): (Vec<_>, Vec<_>) = reads.unzip();
            (m.cat(&enables), m.cat(&addresses))
        });
        m.section("Banks, one a channel, in parts by row");
        let of_part: &[usize] = &[1];
        let mut inputs = place.of_halves();
        inputs.extend([
            ("we", Feed::Along(of_part, writes)),
            ("waddr", Feed::Shared(line)),
            ("wdata", Feed::Along(&[0], lanes)),
            ("re0", Feed::Along(of_part, low.0)),
            ("raddr0", Feed::Along(of_part, low.1)),
            ("re1", Feed::Along(of_part, high.0)),
            ("raddr1", Feed::Along(of_part, high.1)),
        ]);
        let bits = self
            .part
            .ports()
            .iter()
            .find(|p| p.name == "wdata")
            .map_or(1, |p| p.ty.width);
        let count = lanes.width() / bits;
        let loops = [("lane", count), ("part", self.parts)];
        let banks = m.array("bank", &self.part, &loops, &inputs);
        let words = ["rdata0", "rdata1"].map(|name| m.all_out(banks, name));
        turns
            .source
            .iter()
            .enumerate()
            .map(|(p, &source)| {
                let of_port: Vec<_> = (0..count)
                    .rev()
                    .map(|b| {
                        let of_bank: Vec<_> = (0..self.parts)
                            .flat_map(|s| [0, 1].map(|r| (r, bits * (b * self.parts + s))))
                            .map(|(r, at)| m.slice(words[r as usize], at, bits))
                            .collect();
                        let word = m.select(source, &of_bank);
                        m.name(word, &format!("word{p}_{b}"))
                    })
                    .collect();
                m.cat(&of_port)
            })
            .collect()
    }
}

/// A port's grant in its part.
struct PlaceInPart {
    /// It requests a row, and is granted a read in this turn.
    wants: Signal,
    /// Whether it has the second read; `None`: always the first.
    second: Option<Signal>,
    /// Whether it waits for a turn, where that is possible.
    left: Option<Signal>,
}

/// Grant of port `p`, after the lower ports that request the same part.
fn place_in_part(
    m: &mut ModuleBuilder,
    p: usize,
    (wants, part): (Signal, Signal),
    before: &[(Signal, Signal)],
) -> PlaceInPart {
    let ahead: Vec<_> = before
        .iter()
        .map(|&(other_wants, other)| {
            let same = m.eq(part, other);
            m.and(other_wants, same)
        })
        .collect();
    // The first ports have a read for certain: one is ahead of the second, if it wants the part.
    if ahead.len() < READS as usize {
        let second = ahead.first();
        return PlaceInPart {
            wants,
            second: second.map(|one| m.name(*one, &format!("second{p}"))),
            left: None,
        };
    }
    let count = popcount(m, &ahead);
    let count = m.name(count, &format!("ahead{p}"));
    let limit = m.lit(READS, count.ty());
    let room = m.lt(count, limit);
    let room = m.name(room, &format!("room{p}"));
    let no_room = m.not(room);
    let left = m.and(wants, no_room);
    PlaceInPart {
        wants: m.and(wants, room),
        second: Some(m.bit(count, 0)),
        left: Some(left),
    }
}

/// Read enable and line.
type LineRead = (Signal, Signal);

/// Merges the ports that may use each read of each part; at most one of them does.
fn merged(
    m: &mut ModuleBuilder,
    reads: &[[Vec<LineRead>; READS as usize]],
) -> Vec<[LineRead; READS as usize]> {
    reads
        .iter()
        .enumerate()
        .map(|(s, of_part)| {
            [0, 1].map(|r| {
                let hits: Vec<_> = of_part[r].iter().map(|&(hit, _)| hit).collect();
                let lines: Vec<_> = of_part[r]
                    .iter()
                    .map(|&(hit, line)| {
                        let mask = m.repeat(hit, line.width());
                        m.and(mask, line)
                    })
                    .collect();
                let enable = m.any_of(&hits);
                let enable = m.name(enable, &format!("read{s}_{r}"));
                let first = lines[0];
                let line = lines[1..].iter().fold(first, |all, &l| m.or(all, l));
                (enable, m.name(line, &format!("line{s}_{r}")))
            })
        })
        .collect()
}
