//! The MVoxel feature table: double buffered and channel-major. Bank `b` holds
//! channel `b` of every row, so that M rows are read across all banks without
//! a conflict and without a crossbar.
//!
//! In the parity organisation a row holds the eight vertices of a block of
//! 2 x 2 x 2, each in an eighth of the banks. The vertices of a cell have all eight
//! parities of x, y and z, so that they are in different groups of banks, and each
//! group reads its own row.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::row_place::Place;
use super::split_banks::SplitBanks;
use crate::circuits::{bits_for, plus_one, ram, suffix};
use crate::gathering_unit::parity::block::block;
use crate::gathering_unit::shared::table_halves::TableHalves;

/// Builds `mft`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn mft(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let (banks, ports, rows) = (config.gu.banks, config.gu.ports, config.mft_rows());
    let groups = config.vertices_a_row();
    let bits = config.gu.feature_bits;
    let index_bits = bits_for(rows - 1);
    let split = match config.table_parts() {
        1 => None,
        parts => Some(SplitBanks::new(config, parts)?),
    };
    let mut builder = ModuleBuilder::new("mft");
    let m = &mut builder;
    m.doc(if groups == 1 {
        "double-buffered, channel-major MVoxel feature table. Bank b holds channel b of every row."
    } else {
        "double-buffered MVoxel feature table by parity. A row is a block of 2 x 2 x 2 vertices, \
         each in an eighth of the banks: first the one that is even along x, y and z."
    });
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
        match split {
            None => "reads the rows at the clock edge",
            Some(_) => "asks for the rows, until is_read",
        },
    );
    let read_rows = m.input(
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
    if bits < 16 {
        m.unused(
            data,
            "Lanes are 16 bits wide; features fill their low bits.",
        );
    }

    let count_ty = Ty::u(bits_for(rows));
    let halves = TableHalves::declare(m, count_ty);
    m.section("Writer");
    let write_row = m.reg("write_row", count_ty, 0);
    let ready = halves.ready(m);
    let accept = m.and(valid, ready);
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
    let row_after = m.mux(last, zero, rows_after);
    m.set_next_if(write_row, accept, row_after);
    let done = m.and(accept, last);
    let done = m.name(done, "write_done");
    let no_room = m.not(room);
    let overflow = m.and(accept, no_room);
    let readable = halves.advance(m, done, rows_after, release);
    m.section("Reader");
    let read_count = readable.rows;
    let axis_bits = config.mvoxel.edges(3).map_or(1, |[edge, ..]| edge.ilog2());
    let mut in_range = vec![];
    let mut read_ports = vec![];
    for p in 0..ports {
        let kept = m.bit(keep, p);
        for g in 0..groups {
            let of = match groups {
                1 => p.to_string(),
                _ => format!("{p}_{g}"),
            };
            let given = m.slice(read_rows, 16 * (p * groups + g), 16);
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
            let count_wide = m.extend(read_count, 17);
            let below = m.lt(row_wide, count_wide);
            let ok = match here {
                Some(here) => m.and(below, here),
                None => below,
            };
            let ok = m.name(ok, &format!("row{of}_in_range"));
            in_range.insert(0, ok);
            let index = m.slice(row, 0, index_bits.min(row.width()));
            if split.is_some() {
                // Whose turn it is, the parts of the banks decide.
                read_ports.push((ok, index));
                continue;
            }
            let en = m.all_of(&[read, kept, ok]);
            let en = m.name(en, &format!("read{of}"));
            let address = m.cat(&[halves.read, index]);
            let address = m.name(address, &format!("address{of}"));
            read_ports.push((en, address));
        }
    }
    let write_index = m.slice(write_row, 0, index_bits);
    let lanes: Vec<_> = (0..banks).map(|b| m.slice(data, 16 * b, bits)).collect();
    let place = Place {
        halves: [halves.write, halves.read],
        write,
        row: write_index,
    };
    let (words, turns) = match &split {
        None => (whole_banks(m, config, &place, &lanes, &read_ports)?, None),
        Some(split) => {
            let turns = split.turns(m, read, keep, &read_ports);
            (split.banks(m, &place, &turns, &lanes), Some(turns))
        }
    };

    m.section("Outputs");
    m.output("s_axis_mft_tready", ready, "");
    m.output(
        "is_loaded",
        readable.is_loaded,
        "the half to read holds its MVoxel",
    );
    let joined = m.cat(&in_range);
    let doc = match groups {
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
    for (p, parts) in words.iter().enumerate() {
        let joined = m.cat(parts);
        m.output(
            &format!("feature{p}"),
            joined,
            "features of the rows read last, channel 0 lowest",
        );
    }
    m.output(
        "overflow",
        overflow,
        "a row past the MVoxel's rows is dropped",
    );
    builder.finish()
}

/// Banks that every port reads: of each port, the words of all of them, the last first.
fn whole_banks(
    m: &mut ModuleBuilder,
    config: &Config,
    place: &Place,
    lanes: &[Signal],
    reads: &[(Signal, Signal)],
) -> Result<Vec<Vec<Signal>>, IrErrors> {
    let (ports, rows) = (config.gu.ports, config.mft_rows());
    let groups = config.vertices_a_row() as usize;
    let depth = (1 << place.row.width()) + rows;
    let bank = ram("mft_bank", depth, config.gu.feature_bits, ports)?;
    let write_address = m.cat(&[place.halves[0], place.row]);
    let write_address = m.name(write_address, "write_address");
    m.section(if groups == 1 {
        "Banks, one a channel"
    } else {
        "Banks, one a parity and channel"
    });
    let mut words = vec![vec![]; ports as usize];
    let names: Vec<_> = (0..ports)
        .map(|p| {
            let suffix = suffix(p, ports);
            ["re", "raddr", "rdata"].map(|name| format!("{name}{suffix}"))
        })
        .collect();
    for (b, &lane) in lanes.iter().enumerate() {
        let mut inputs = vec![
            ("we", place.write),
            ("waddr", write_address),
            ("wdata", lane),
        ];
        let of_group = reads
            .iter()
            .skip(b / (lanes.len() / groups))
            .step_by(groups);
        for ([re, raddr, _], (en, address)) in names.iter().zip(of_group) {
            inputs.push((re, *en));
            inputs.push((raddr, *address));
        }
        let inst = m.instance(&format!("bank{b}"), &bank, &inputs);
        for ([.., rdata], words) in names.iter().zip(&mut words) {
            words.insert(0, m.out(inst, rdata));
        }
    }
    Ok(words)
}
