//! Memories in modules of their own, which a macro of a memory compiler can replace, and banks of two
//! halves. One family with the same port names and rules:
//!
//! | kind | ports | used for |
//! |---|---|---|
//! | `1r1w` | `we`, `waddr`, `wdata`; `re`, `raddr`, `rdata` | RIT |
//! | `1rw` | `we`, `re`, `addr`, `wdata`, `rdata` | a half of a feature bank with one read |
//! | `1rw1r` | `we`, `re0`, `addr0`, `wdata`, `rdata0`; `re1`, `addr1`, `rdata1` | a half with two reads |
//!
//! Reads and writes take effect at the clock edge. `rdata` changes with `re` alone, and nothing has a
//! reset. What a read returns of a word that is written at the same edge is not defined.

use std::sync::Arc;

use potamoi_netlist::{Instance, IrErrors, Module, ModuleBuilder, Signal, Ty};

use crate::circuits::bits_for;

/// Number of words and their width in bits.
#[derive(Clone, Copy)]
pub(crate) struct Size {
    pub(crate) words: u32,
    pub(crate) bits: u32,
}

impl Size {
    fn address(self) -> Ty {
        Ty::u(bits_for(self.words - 1))
    }
}

/// A memory with a write port and a read port.
///
/// # Errors
/// The netlist's own checks.
pub(crate) fn ram_1r1w(name: &str, size: Size) -> Result<Arc<Module>, IrErrors> {
    let mut m = wrapper(
        name,
        size,
        "1r1w",
        "A read of the word that is written at the same edge returns an undefined word, which the \
         unit does not use.",
    );
    let we = m.input("we", Ty::bit(), "write at the clock edge");
    let waddr = m.input("waddr", size.address(), "");
    let wdata = m.input("wdata", Ty::u(size.bits), "");
    let re = m.input("re", Ty::bit(), READS);
    let raddr = m.input("raddr", size.address(), "");
    let mem = m.memory("mem", size.words, size.bits, "");
    m.mem_write(mem, we, waddr, wdata);
    let word = m.mem_read(mem, re, raddr, "word");
    m.output("rdata", word, "");
    holds_between_reads(&mut m, size, &[String::new()]);
    m.finish()
}

/// A memory whose first port writes or reads; `1rw1r` has a second one, which only reads.
///
/// # Errors
/// The netlist's own checks.
fn ram_rw(name: &str, size: Size, ports: u32) -> Result<Arc<Module>, IrErrors> {
    let mut m = wrapper(
        name,
        size,
        ["1rw", "1rw1r"][ports as usize - 1],
        match ports {
            1 => "Its port writes or reads, never both at one edge.",
            _ => {
                "Port 0 writes or reads, port 1 only reads. Nothing is read at an edge that writes."
            }
        },
    );
    let we = m.input("we", Ty::bit(), "write at the clock edge");
    let wdata = m.input("wdata", Ty::u(size.bits), "");
    let mem = m.memory("mem", size.words, size.bits, "");
    for p in 0..ports {
        let of = suffix(p, ports);
        let re = m.input(&format!("re{of}"), Ty::bit(), READS);
        let address = m.input(&format!("addr{of}"), size.address(), "");
        if p == 0 {
            m.mem_write(mem, we, address, wdata);
        }
        let word = m.mem_read(mem, re, address, &format!("word{of}"));
        m.output(&format!("rdata{of}"), word, "");
    }
    let ports: Vec<String> = (0..ports).map(|p| suffix(p, ports)).collect();
    holds_between_reads(&mut m, size, &ports);
    m.finish()
}

/// Checks of a memory: they read its ports alone, so that they are of a macro, too.
fn holds_between_reads(m: &mut ModuleBuilder, size: Size, ports: &[String]) {
    m.begin_checks();
    for of in ports {
        let was_read = m.ghost_data_reg(&format!("was_read{of}"), 1);
        m.ghost_next(was_read, "1", &format!("re{of}"));
        let past = m.ghost_data_reg(&format!("past_rdata{of}"), size.bits);
        m.ghost_next(past, "1", &format!("rdata{of}"));
        let same = format!("rdata{of}_stays");
        m.same_in_all_bits(&same, &format!("rdata{of}"), &format!("past_rdata{of}"));
        m.assert(
            &format!("holds{of}"),
            &format!("was_read{of} | {same}"),
            "A read alone changes the word that is read.",
        );
    }
}

/// Fewest words of a memory that a macro can replace: memory compilers offer no smaller ones.
const FEWEST_OF_MACRO: u32 = 32;

const READS: &str = "read at the clock edge; holds its output otherwise";

fn wrapper(name: &str, size: Size, kind: &str, rule: &str) -> ModuleBuilder {
    let mut m = ModuleBuilder::new(name);
    m.doc(&format!(
        "memory of {} words of {} bits, {kind}. {rule}",
        size.words, size.bits
    ));
    m.no_read_during_write();
    if size.words >= FEWEST_OF_MACRO {
        m.macro_hook();
    }
    m
}

/// Suffix of read port `r` of so many.
#[must_use]
pub(crate) fn suffix(r: u32, reads: u32) -> String {
    if reads == 1 {
        String::new()
    } else {
        r.to_string()
    }
}

/// A bank of a table of which one half is written while the other is read: a memory a half, so that
/// no memory has more than two ports. More than two reads take copies, which are written alike.
///
/// Inputs are `we`, `waddr`, `wdata`, `re` and `raddr` of each read, and `write_half`, `read_half`,
/// `loaded` (a bit a half) and `half_of_words`, the half that was read last. A half that is loaded
/// is read only, any other is written only.
///
/// # Errors
/// The netlist's own checks.
pub(crate) fn halves(name: &str, size: Size, reads: u32) -> Result<Arc<Module>, IrErrors> {
    let size = Size {
        // An address has a bit at least.
        words: size.words.max(2),
        ..size
    };
    let memory = format!("{}_bank", name.trim_end_matches("_halves"));
    let pairs = reads / 2;
    let two = match pairs {
        0 => None,
        _ => Some(ram_rw(&memory, size, 2)?),
    };
    let one_name = if pairs == 0 {
        memory
    } else {
        format!("{memory}_one_read")
    };
    let one = match reads % 2 {
        0 => None,
        _ => Some(ram_rw(&one_name, size, 1)?),
    };
    let mut builder = ModuleBuilder::new(name);
    let m = &mut builder;
    m.doc("a bank of the table, a memory a half. A loaded half is read, the other one is written.");
    let bit = Ty::bit();
    let we = m.input("we", bit, "write at the clock edge");
    let write_half = m.input("write_half", bit, "");
    let waddr = m.input("waddr", size.address(), "");
    let wdata = m.input("wdata", Ty::u(size.bits), "");
    let read_half = m.input("read_half", bit, "");
    let loaded = m.input(
        "loaded",
        Ty::u(2),
        "halves that are read, or wait to be read",
    );
    let of_words = m.input("half_of_words", bit, "half of the words read last");
    let ports: Vec<_> = (0..reads)
        .map(|r| {
            let of = suffix(r, reads);
            let re = m.input(&format!("re{of}"), bit, READS);
            (re, m.input(&format!("raddr{of}"), size.address(), ""))
        })
        .collect();
    let mut words: Vec<Vec<Signal>> = vec![vec![]; reads as usize];
    let mut parts = vec![];
    for (h, half) in ["low", "high"].into_iter().enumerate() {
        m.section(&format!("Half {h}"));
        let own = |m: &mut ModuleBuilder, of: Signal| if h == 0 { m.not(of) } else { of };
        let here = own(m, write_half);
        let writes = m.and(we, here);
        let writes = m.name(writes, &format!("{half}_we"));
        let reads_here = own(m, read_half);
        let is_read = m.bit(loaded, h as u32);
        let mut read = 0;
        for (c, copy) in ports.chunks(2).enumerate() {
            let Some(module) = (if copy.len() == 2 { &two } else { &one }) else {
                continue;
            };
            let (re, raddr) = copy[0];
            let address = m.mux(is_read, raddr, waddr);
            let address = m.name(
                address,
                &format!("{half}_addr{}", suffix(2 * c as u32, reads)),
            );
            let re = m.and(re, reads_here);
            let mut inputs = vec![("we", writes), ("wdata", wdata)];
            let outputs: &[&str] = match copy.get(1) {
                None => {
                    inputs.extend([("re", re), ("addr", address)]);
                    &["rdata"]
                }
                Some(&(re1, raddr1)) => {
                    let re1 = m.and(re1, reads_here);
                    inputs.extend([("re0", re), ("addr0", address)]);
                    inputs.extend([("re1", re1), ("addr1", raddr1)]);
                    &["rdata0", "rdata1"]
                }
            };
            let name = match ports.len() {
                ..=2 => half.to_owned(),
                _ => format!("{half}_copy{c}"),
            };
            let instance = m.instance(&name, module, &inputs);
            parts.push(Part {
                instance,
                name,
                half: h,
                read: 2 * c as u32,
            });
            for output in outputs {
                words[read].push(m.out(instance, output));
                read += 1;
            }
        }
    }
    m.section("Outputs");
    for (r, of_read) in (0..).zip(words) {
        let word = m.mux(of_words, of_read[1], of_read[0]);
        m.output(&format!("rdata{}", suffix(r, reads)), word, "");
    }
    rows_at_their_addresses(m, &parts, reads);
    builder.finish()
}

/// A memory of a half: its name, the half, and its first read.
struct Part {
    instance: Instance,
    name: String,
    half: usize,
    read: u32,
}

/// Checks of where a row lies, which who loads or dumps the memories by themselves relies on.
fn rows_at_their_addresses(m: &mut ModuleBuilder, parts: &[Part], reads: u32) {
    m.begin_checks();
    for part in parts {
        let Part { name, half, .. } = part;
        let both = part.read + 1 < reads;
        let port = if both { "addr0" } else { "addr" };
        m.inside_as(&format!("{name}_given"), part.instance, port);
        let asked = |m: &mut ModuleBuilder, name: &str, read: u32, of: String| {
            let enable = format!("{name}_enabled");
            m.inside_as(&enable, part.instance, &format!("re{of}"));
            let here = ["~", ""][*half];
            m.assert(
                &format!("{name}_asked"),
                &format!("{enable} -> re{} & {here}read_half", suffix(read, reads)),
                "A half is read only if it is asked for.",
            );
        };
        let first = if both { "0" } else { "" };
        asked(m, name, part.read, first.to_owned());
        let same = |m: &mut ModuleBuilder, which: &str, row: &str| {
            let name = format!("{name}_{which}_row");
            let given = format!("{}_given", part.name);
            m.same_in_all_bits(&name, &given, row);
            name
        };
        let writes = same(m, "write", "waddr");
        m.assert(
            &format!("{name}_written"),
            &format!("loaded[{half}] | {writes}"),
            "A half that is written gets the row that is written as its address.",
        );
        let reads_row = same(m, "read", &format!("raddr{}", suffix(part.read, reads)));
        m.assert(
            &format!("{name}_read"),
            &format!("~loaded[{half}] | {reads_row}"),
            "A half that is read gets the row that is read as its address.",
        );
        if both {
            let given = format!("{name}_given_second");
            m.inside_as(&given, part.instance, "addr1");
            asked(m, &format!("{name}_second"), part.read + 1, "1".to_owned());
            let second = format!("{name}_second_row");
            m.same_in_all_bits(&second, &given, &format!("raddr{}", part.read + 1));
            m.assert(
                &format!("{name}_read_second"),
                &second,
                "The second read gets its row as its address.",
            );
        }
    }
}
