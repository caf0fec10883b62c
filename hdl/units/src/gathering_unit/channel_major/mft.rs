//! The MVoxel feature table (MFT): double buffered and channel-major. Bank `b` holds channel `b` of
//! every row, so that M rows are read across all banks without bank conflicts and without a
//! crossbar.
//!
//! In the parity organisation a row holds the eight vertices of a block of 2 x 2 x 2, each in an
//! eighth of the banks. The vertices of a cell have all eight parities of x, y and z. They are thus
//! in different groups of banks, and each group reads its own row.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_netlist::{Feed, IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::row_position::RowPosition;
use super::split_banks::SplitBanks;
use crate::circuits::{bits_for, plus_one};
use crate::gathering_unit::parity::block::block;
use crate::gathering_unit::shared::table_checks::table_checks;
use crate::gathering_unit::shared::table_halves::TableHalves;
use crate::memory::{Size, halves, suffix};

/// Builds `mft`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn mft(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let split = match config.table_parts() {
        1 => None,
        parts => Some(SplitBanks::new(config, parts)?),
    };
    let mut builder = ModuleBuilder::new("mft");
    let m = &mut builder;
    m.doc(if config.vertices_a_row() == 1 {
        "double-buffered, channel-major MVoxel feature table. Bank b holds channel b of every row."
    } else {
        "double-buffered MVoxel feature table by parity. A row is a block of 2 x 2 x 2 vertices, \
         each in an eighth of the banks: first the one that is even along x, y and z."
    });
    let inputs = Inputs::declare(m, config, split.is_some());
    let table = TableHalves::declare(m, Ty::u(bits_for(config.mft_rows())));
    let written = write(m, config, &inputs, &table);
    let readable = table.advance(m, written.done, written.rows_after, inputs.release);
    let reader = Reader {
        config,
        inputs: &inputs,
        count: readable.rows,
    };
    let (reads, enabled) = reader.reads(m, split.is_some());
    let place = written.place(m, config, &table, inputs.read);
    let lanes = packed(m, inputs.data, config.gu.feature_bits);
    let (words, turns) = match &split {
        None => (whole_banks(m, config, &place, lanes, &enabled)?, None),
        Some(split) => {
            let rows: Vec<_> = reads.iter().map(|read| (read.ok, read.index)).collect();
            let turns = split.turns(m, inputs.read, inputs.keep, &rows);
            (split.banks(m, &place, &turns, lanes), Some(turns))
        }
    };
    m.section("Outputs");
    m.output("s_axis_mft_tready", written.ready, "");
    m.output(
        "is_loaded",
        readable.is_loaded,
        "the half to read holds its MVoxel",
    );
    let partly = m.any(written.row);
    let empty = table.is_empty(m, &[partly]);
    m.output(
        "is_empty",
        empty,
        "no half is loaded, and none is partly written",
    );
    let in_range: Vec<_> = reads.iter().rev().map(|read| read.ok).collect();
    let joined = m.cat(&in_range);
    let doc = match config.vertices_a_row() {
        1 => "ports whose row was loaded",
        _ => "ports and groups of banks whose vertex was loaded",
    };
    m.output("in_range", joined, doc);
    if let Some(turns) = turns {
        m.output(
            "is_read",
            turns.complete,
            "no port's row is left to be read",
        );
        let doc = "ports whose rows are read at the clock edge";
        m.output("granted", turns.granted, doc);
    }
    for (p, words) in words.iter().enumerate() {
        m.output(
            &format!("feature{p}"),
            *words,
            "features of the rows read last, channel 0 lowest",
        );
    }
    m.output(
        "overflow",
        written.overflow,
        "a row past the MVoxel's rows is dropped",
    );
    table_checks(m, "read");
    read_checks(m, config, enabled.len());
    builder.finish()
}

/// Row counts and read enables. `enabled` is the number of read enables: the product of ports and groups
/// of banks, or 0 where ports take turns.
fn read_checks(m: &mut ModuleBuilder, config: &Config, enabled: usize) {
    let rows = config.mft_rows();
    let count = |half: u32| format!("(loaded_{half} -> rows_{half} <= {rows})");
    m.invariant(
        "rows_in_range",
        &format!("write_row <= {rows} & {} & {}", count(0), count(1)),
        "No half holds more rows than there is room for.",
    );
    let groups = config.vertices_a_row();
    let asked = (0..enabled).map(|of| {
        let (port, group) = (of as u32 / groups, of as u32 % groups);
        let name = match groups {
            1 => format!("read{port}"),
            _ => format!("read{port}_{group}"),
        };
        format!("({name} -> read & read_keep[{port}] & in_range[{of}])")
    });
    let asked: Vec<String> = asked.collect();
    if !asked.is_empty() {
        m.assert(
            "reads_asked",
            &asked.join(" & "),
            "A bank is read only for a port that asks for a row that is loaded.",
        );
    }
}

/// The inputs.
struct Inputs {
    valid: Signal,
    data: Signal,
    last: Signal,
    read: Signal,
    rows: Signal,
    keep: Signal,
    release: Signal,
}

impl Inputs {
    /// `turns`: ports may have to request repeatedly.
    fn declare(m: &mut ModuleBuilder, config: &Config, turns: bool) -> Self {
        let (banks, ports) = (config.gu.banks, config.gu.ports);
        let groups = config.vertices_a_row();
        let bit = Ty::bit();
        let valid = m.input("s_axis_mft_tvalid", bit, "");
        let data = m.input(
            "s_axis_mft_tdata",
            Ty::u(16 * banks),
            if groups == 1 {
                "one row, channel 0 lowest"
            } else {
                "one row: vertices by parity, x lowest, channel 0 of each lowest"
            },
        );
        let last = m.input(
            "s_axis_mft_tlast",
            bit,
            "ends the MVoxel's rows of this segment",
        );
        let read = m.input(
            "read",
            bit,
            match turns {
                false => "reads the rows at the clock edge",
                true => "asks for the rows, until is_read",
            },
        );
        let rows = m.input(
            "read_row",
            Ty::u(16 * ports * groups),
            if groups == 1 {
                "row of each port"
            } else {
                "vertex of each port and group of banks: z, y and x of its place"
            },
        );
        let keep = m.input("read_keep", Ty::u(ports), "ports that hold an entry");
        let release = m.input("done", bit, "the half that is read is done with");
        if config.gu.feature_bits < 16 {
            m.unused(
                data,
                "Lanes are 16 bits wide; features fill their low bits.",
            );
        }
        Self {
            valid,
            data,
            last,
            read,
            rows,
            keep,
            release,
        }
    }
}

/// Effect of a beat on the writer.
struct Written {
    ready: Signal,
    /// Write enable and row.
    write: Signal,
    row: Signal,
    /// The MVoxel is complete, with its number of rows.
    done: Signal,
    rows_after: Signal,
    overflow: Signal,
}

fn write(m: &mut ModuleBuilder, config: &Config, inputs: &Inputs, halves: &TableHalves) -> Written {
    m.section("Writer");
    let rows = config.mft_rows();
    let count_ty = Ty::u(bits_for(rows));
    let write_row = m.reg("write_row", count_ty, 0);
    let ready = halves.ready(m);
    let accept = m.and(inputs.valid, ready);
    let accept = m.name(accept, "write_accept");
    let limit = m.param("MVOXEL_ROWS", rows, count_ty, "");
    let room = m.lt(write_row, limit);
    let room = m.name(room, "write_room");
    let write = m.and(accept, room);
    let write = m.name(write, "write");
    let next = plus_one(m, write_row);
    let rows_after = m.mux(room, next, write_row);
    let rows_after = m.name(rows_after, "rows_after");
    let zero = m.lit(0, count_ty);
    let row_after = m.mux(inputs.last, zero, rows_after);
    m.set_next_if(write_row, accept, row_after);
    let done = m.and(accept, inputs.last);
    let done = m.name(done, "write_done");
    let no_room = m.not(room);
    let overflow = m.and(accept, no_room);
    Written {
        ready,
        write,
        row: write_row,
        done,
        rows_after,
        overflow,
    }
}

impl Written {
    fn place(
        &self,
        m: &mut ModuleBuilder,
        config: &Config,
        table: &TableHalves,
        read: Signal,
    ) -> RowPosition {
        let row = m.slice(self.row, 0, bits_for(config.mft_rows() - 1));
        RowPosition {
            halves: [table.write, table.read],
            loaded: table.loaded(m),
            read_last: table.read_last(m, read),
            write: self.write,
            row: m.name(row, "write_address"),
        }
    }
}

/// The features of a beat without what fills its 16-bit lanes.
fn packed(m: &mut ModuleBuilder, data: Signal, feature_bits: u32) -> Signal {
    if feature_bits == 16 {
        return data;
    }
    let lanes: Vec<_> = (0..data.width() / 16)
        .rev()
        .map(|b| m.slice(data, 16 * b, feature_bits))
        .collect();
    let lanes = m.cat(&lanes);
    m.name(lanes, "write_data")
}

/// A row requested by a port from one group of banks.
struct RowRead {
    /// Whether the row is loaded and in this group of banks.
    ok: Signal,
    /// Index of the row within a half.
    index: Signal,
}

/// Read side of the table.
struct Reader<'a> {
    config: &'a Config,
    inputs: &'a Inputs,
    /// Number of rows in the half to read.
    count: Signal,
}

impl Reader<'_> {
    /// The requested row of each port and group of banks. Unless split banks arbitrate, it also has
    /// the read enable and address.
    fn reads(&self, m: &mut ModuleBuilder, turns: bool) -> (Vec<RowRead>, Vec<(Signal, Signal)>) {
        m.section("Reader");
        let groups = self.config.vertices_a_row();
        let (mut reads, mut enabled) = (vec![], vec![]);
        for port in 0..self.config.gu.ports {
            let kept = m.bit(self.inputs.keep, port);
            for g in 0..groups {
                let of = match groups {
                    1 => port.to_string(),
                    _ => format!("{port}_{g}"),
                };
                let read = self.read(m, port, g, &of);
                if !turns {
                    let en = m.all_of(&[self.inputs.read, kept, read.ok]);
                    let en = m.name(en, &format!("read{of}"));
                    enabled.push((en, m.name(read.index, &format!("address{of}"))));
                }
                reads.push(read);
            }
        }
        (reads, enabled)
    }

    fn read(&self, m: &mut ModuleBuilder, port: u32, g: u32, of: &str) -> RowRead {
        let (config, groups) = (self.config, self.config.vertices_a_row());
        let axis_bits = config.mvoxel.edges(3).map_or(1, |[edge, ..]| edge.ilog2());
        let index_bits = bits_for(config.mft_rows() - 1);
        let given = m.slice(self.inputs.rows, 16 * (port * groups + g), 16);
        let (row, here) = match groups {
            1 => (given, None),
            _ => {
                let (row, parity) = block(m, given, axis_bits);
                let own = m.lit(g, parity.ty());
                (row, Some(m.eq(parity, own)))
            }
        };
        let row = m.name(row, &format!("row{of}"));
        let row_wide = m.extend(row, 17);
        let count_wide = m.extend(self.count, 17);
        let below = m.lt(row_wide, count_wide);
        let ok = match here {
            Some(here) => m.and(below, here),
            None => below,
        };
        let ok = m.name(ok, &format!("row{of}_in_range"));
        let index = m.slice(row, 0, index_bits.min(row.width()));
        RowRead { ok, index }
    }
}

/// Banks that every port reads; for each port the words of all banks.
fn whole_banks(
    m: &mut ModuleBuilder,
    config: &Config,
    place: &RowPosition,
    lanes: Signal,
    reads: &[(Signal, Signal)],
) -> Result<Vec<Signal>, IrErrors> {
    let ports = config.gu.ports;
    let groups = config.vertices_a_row();
    let size = Size {
        words: config.mft_rows(),
        bits: config.gu.feature_bits,
    };
    let bank = halves("mft_halves", size, ports)?;
    m.section(if groups == 1 {
        "Banks, one a channel"
    } else {
        "Banks, one a parity and channel"
    });
    let names: Vec<_> = (0..ports)
        .map(|p| ["re", "raddr", "rdata"].map(|name| format!("{name}{}", suffix(p, ports))))
        .collect();
    let of_port = |m: &mut ModuleBuilder, p: u32, what: fn(&(Signal, Signal)) -> Signal| {
        let of_groups = reads
            .iter()
            .skip((p * groups) as usize)
            .take(groups as usize);
        let parts: Vec<_> = of_groups.rev().map(what).collect();
        m.cat(&parts)
    };
    let loops = [("group", groups), ("lane", config.gu.banks / groups)];
    // One group of banks needs no loop of its own.
    let (loops, along): (_, &[usize]) = match groups {
        1 => (&loops[1..], &[]),
        _ => (&loops[..], &[0]),
    };
    let feed = |signal: Signal| match along {
        [] => Feed::Shared(signal),
        _ => Feed::Along(along, signal),
    };
    let mut inputs = place.of_halves();
    inputs.push(("we", Feed::Shared(place.write)));
    inputs.push(("waddr", Feed::Shared(place.row)));
    inputs.push(("wdata", Feed::Each(lanes)));
    for (p, [re, raddr, _]) in (0..).zip(&names) {
        let enable = of_port(m, p, |(enable, _)| *enable);
        let address = of_port(m, p, |(_, address)| *address);
        inputs.push((re, feed(enable)));
        inputs.push((raddr, feed(address)));
    }
    let banks = m.array("bank", &bank, loops, &inputs);
    Ok(names
        .iter()
        .map(|[.., rdata]| m.all_out(banks, rdata))
        .collect())
}
