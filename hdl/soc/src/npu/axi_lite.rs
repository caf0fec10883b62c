//! An AXI4-Lite subordinate in front of plain registers: one write and one read at a time.

use std::sync::Arc;

use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::checks::bus_checks;
use super::registers::{ADDRESS_BITS, INDEX_BITS, WORD_BITS};

/// Response codes of AXI.
const OKAY: u32 = 0;
const SLVERR: u32 = 2;

/// Inputs of the bus: name, bits, meaning.
pub(super) const INPUTS: [(&str, u32, &str); 11] = [
    (
        "s_axil_awaddr",
        ADDRESS_BITS,
        "byte address; the two low bits are ignored",
    ),
    ("s_axil_awprot", 3, "ignored"),
    ("s_axil_awvalid", 1, "address of a write"),
    ("s_axil_wdata", WORD_BITS, ""),
    ("s_axil_wstrb", WORD_BITS / 8, "bytes that are written"),
    (
        "s_axil_wvalid",
        1,
        "data of a write, before or after its address",
    ),
    ("s_axil_bready", 1, ""),
    (
        "s_axil_araddr",
        ADDRESS_BITS,
        "byte address; the two low bits are ignored",
    ),
    ("s_axil_arprot", 3, "ignored"),
    ("s_axil_arvalid", 1, "address of a read"),
    ("s_axil_rready", 1, ""),
];
/// Outputs of the bus: name, meaning, and whether reset keeps them low in the same clock.
pub(super) const OUTPUTS: [(&str, &str, bool); 8] = [
    (
        "s_axil_awready",
        "no address waits, no response is owed",
        true,
    ),
    ("s_axil_wready", "no data wait, no response is owed", true),
    ("s_axil_bvalid", "a write has had its effect", false),
    (
        "s_axil_bresp",
        "0 OKAY, 2 SLVERR: nothing was written",
        false,
    ),
    ("s_axil_arready", "no data are offered", true),
    ("s_axil_rvalid", "data of the read", false),
    ("s_axil_rdata", "", false),
    ("s_axil_rresp", "0 OKAY, 2 SLVERR: no register there", false),
];

/// Builds `npu_axi_lite`. No output depends on an input in the same clock but for reset.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn axi_lite() -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("npu_axi_lite");
    let m = &mut builder;
    m.doc(
        "AXI4-Lite subordinate of the registers: one write and one read at a time, responses held \
         until they are taken.",
    );
    let inputs = INPUTS.map(|(name, bits, doc)| m.input(name, Ty::u(bits), doc));
    let [
        awaddr,
        awprot,
        awvalid,
        wdata,
        wstrb,
        wvalid,
        bready,
        araddr,
        arprot,
        arvalid,
        rready,
    ] = inputs;
    for protection in [awprot, arprot] {
        m.unused(protection, "every access is allowed");
    }
    let write_error = m.input("write_error", Ty::bit(), "of the register that is written");
    let read_data = m.input(
        "read_data",
        Ty::u(WORD_BITS),
        "of the register that is read",
    );
    let read_error = m.input("read_error", Ty::bit(), "");

    m.section("Writes: address and data wait for each other");
    let has_address = m.reg("has_address", Ty::bit(), 0);
    let has_data = m.reg("has_data", Ty::bit(), 0);
    let answers = m.reg("s_axil_bvalid", Ty::bit(), 0);
    let write = m.and(has_address, has_data);
    let write = m.name(write, "writes");
    let awready = free(m, has_address, answers);
    let awready = m.name(awready, "can_take_address");
    let wready = free(m, has_data, answers);
    let wready = m.name(wready, "can_take_data");
    let takes_address = m.and(awvalid, awready);
    let takes_address = m.name(takes_address, "takes_address");
    let takes_data = m.and(wvalid, wready);
    let takes_data = m.name(takes_data, "takes_data");
    let index = m.slice(awaddr, ADDRESS_BITS - INDEX_BITS, INDEX_BITS);
    let aw_index = held(m, "write_index", index, takes_address);
    let w_data = held(m, "write_data", wdata, takes_data);
    let w_strobe = held(m, "write_strobe", wstrb, takes_data);
    for (reg, takes) in [(has_address, takes_address), (has_data, takes_data)] {
        filled(m, reg, takes, write);
    }
    let bresp = response(m, "s_axil_bresp", write, write_error);
    let taken = m.and(answers, bready);
    filled(m, answers, write, taken);

    m.section("Reads");
    let offers = m.reg("s_axil_rvalid", Ty::bit(), 0);
    let arready = m.not(offers);
    let arready = m.name(arready, "can_read");
    let reads = m.and(arvalid, arready);
    let reads = m.name(reads, "reads");
    let read_index = m.slice(araddr, ADDRESS_BITS - INDEX_BITS, INDEX_BITS);
    let rdata = m.reg("s_axil_rdata", Ty::u(WORD_BITS), 0);
    m.set_next_if(rdata, reads, read_data);
    let rresp = response(m, "s_axil_rresp", reads, read_error);
    let taken = m.and(offers, rready);
    filled(m, offers, reads, taken);

    m.section("Outputs");
    let values = [
        awready, wready, answers, bresp, arready, offers, rdata, rresp,
    ];
    for ((name, doc, low), value) in OUTPUTS.into_iter().zip(values) {
        match low {
            true => m.output_low_in_reset(name, value, doc),
            false => m.output(name, value, doc),
        }
    }
    m.output("write", write, "a write takes effect at the clock edge");
    m.output("write_index", aw_index, "");
    m.output("write_data", w_data, "");
    m.output("write_strobe", w_strobe, "");
    m.output("read_index", read_index, "");
    bus_checks(m);
    builder.finish()
}

/// Whether a channel can take a transfer: it holds none, and no response is owed.
fn free(m: &mut ModuleBuilder, holds: Signal, owes: Signal) -> Signal {
    let busy = m.or(holds, owes);
    m.not(busy)
}

/// A register that keeps a payload.
fn held(m: &mut ModuleBuilder, name: &str, payload: Signal, takes: Signal) -> Signal {
    let reg = m.reg(name, payload.ty(), 0);
    m.set_next_if(reg, takes, payload);
    reg
}

/// A bit that `set` sets and `clear` clears; both never come at once.
fn filled(m: &mut ModuleBuilder, reg: Signal, set: Signal, clear: Signal) {
    let stays = m.not(clear);
    let stays = m.and(reg, stays);
    let next = m.or(stays, set);
    m.set_next(reg, next);
}

fn response(m: &mut ModuleBuilder, name: &str, when: Signal, error: Signal) -> Signal {
    let reg = m.reg(name, Ty::u(2), OKAY);
    let [good, bad] = [OKAY, SLVERR].map(|code| m.lit(code, Ty::u(2)));
    let code = m.mux(error, bad, good);
    m.set_next_if(reg, when, code);
    reg
}
