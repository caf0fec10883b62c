//! Checks of the bus, of the gates in front of the units, and of their jobs.

use potamoi_netlist::{ModuleBuilder, Signal};

use super::registers::{ADDRESS_BITS, INDEX_BITS, WORD_BITS};

/// A ghost register that takes a value where `when` holds.
pub(super) fn taken(
    m: &mut ModuleBuilder,
    name: &str,
    width: u32,
    when: &str,
    value: &str,
) -> Signal {
    let reg = m.ghost_reg(name, width);
    m.ghost_next(reg, when, value);
    reg
}

/// Transfers that are open: those that `begins` has begun and `ends` has not ended.
fn open(m: &mut ModuleBuilder, name: &str, begins: &str, ends: &str) {
    let reg = m.ghost_reg(name, 2);
    m.ghost_next(reg, "1", &format!("{name} + {begins} - {ends}"));
}

/// Checks of `npu_axi_lite`.
pub(super) fn bus_checks(m: &mut ModuleBuilder) {
    m.begin_checks();
    for channel in ["b", "r"] {
        m.ghost(
            &format!("{channel}_taken"),
            &format!("s_axil_{channel}valid & s_axil_{channel}ready"),
        );
    }
    stable_responses(m);
    open(m, "open_addresses", "takes_address", "b_taken");
    open(m, "open_data", "takes_data", "b_taken");
    m.assert(
        "writes_answered",
        "open_addresses == has_address + s_axil_bvalid & open_data == has_data + s_axil_bvalid",
        "Every write is answered once, after its address and its data: none is lost.",
    );
    m.invariant(
        "answered_or_waiting",
        "s_axil_bvalid -> ~has_address & ~has_data",
        "",
    );
    open(m, "open_reads", "reads", "r_taken");
    m.assert(
        "reads_answered",
        "open_reads == s_axil_rvalid",
        "Every read is answered once.",
    );
    payloads(m);
}

fn stable_responses(m: &mut ModuleBuilder) {
    for (channel, fields, name, doc) in [
        (
            "b",
            &[("resp", 2)][..],
            "write_response_stays",
            "bvalid and bresp stay until bready.",
        ),
        (
            "r",
            &[("data", WORD_BITS), ("resp", 2)],
            "read_response_stays",
            "rvalid, rdata and rresp stay until rready.",
        ),
    ] {
        let valid = format!("s_axil_{channel}valid");
        let waits = format!("{channel}_waits");
        taken(
            m,
            &waits,
            1,
            "1",
            &format!("{valid} & ~s_axil_{channel}ready"),
        );
        let mut same = vec![valid];
        for (field, width) in fields {
            let (port, past) = (
                format!("s_axil_{channel}{field}"),
                format!("{channel}{field}_past"),
            );
            taken(m, &past, *width, "1", &port);
            same.push(format!("{port} == {past}"));
        }
        m.assert(name, &format!("{waits} -> {}", same.join(" & ")), doc);
    }
}

/// What the registers are told is what was offered, and what is answered is what they say.
fn payloads(m: &mut ModuleBuilder) {
    let address = m.named("s_axil_awaddr");
    let index = m.slice(address, ADDRESS_BITS - INDEX_BITS, INDEX_BITS);
    m.name(index, "awaddr_index");
    let mut same = vec![];
    for (name, width, when, port) in [
        ("write_index", INDEX_BITS, "takes_address", "awaddr_index"),
        ("write_data", WORD_BITS, "takes_data", "s_axil_wdata"),
        ("write_strobe", WORD_BITS / 8, "takes_data", "s_axil_wstrb"),
    ] {
        let offered = format!("{name}_offered");
        taken(m, &offered, width, when, port);
        same.push(format!("{name} == {offered}"));
    }
    m.assert(
        "written_as_offered",
        &same.join(" & "),
        "The registers are given the address, data and strobes that the master offered last.",
    );
    taken(m, "data_given", WORD_BITS, "reads", "read_data");
    taken(m, "read_refused", 1, "reads", "read_error");
    taken(m, "write_refused", 1, "writes", "write_error");
    m.assert(
        "answered_as_given",
        "s_axil_rdata == data_given & s_axil_rresp == if(read_refused, 2, 0) \
         & s_axil_bresp == if(write_refused, 2, 0)",
        "The master gets the data of the registers, and SLVERR where they refuse.",
    );
}

/// Checks of `npu_packet_gate`.
pub(super) fn gate_checks(m: &mut ModuleBuilder) {
    m.begin_checks();
    m.assert(
        "closed_passes_nothing",
        "m_tvalid | s_tready -> any(left)",
        "A closed gate offers nothing and takes nothing.",
    );
    m.assert(
        "open_passes_all",
        "m_tvalid == (s_tvalid & any(left)) & s_tready == (m_tready & any(left)) & open == any(left)",
        "An open gate is not there.",
    );
    taken(m, "allowed", WORD_BITS, "start", "packets");
    let more = "if(start, 0, passed + step)";
    taken(m, "passed", WORD_BITS + 1, "start | ends", more);
    m.assert(
        "open_for_the_job",
        "if(passed < allowed, left == allowed - passed, left == 0)",
        "The gate is open until the packets that have passed stand for all of the job.",
    );
    m.assert(
        "passes_at_both_sides",
        "(s_tvalid & s_tready) == (m_tvalid & m_tready)",
        "A beat leaves the master when it enters the unit: none is lost, none is there twice.",
    );
}

/// Checks of `npu_job`.
pub(super) fn job_checks(m: &mut ModuleBuilder) {
    m.begin_checks();
    taken(m, "packets_ordered", WORD_BITS, "begins_now", "packets");
    let more = "if(begins_now, 0, packets_taken + 1)";
    taken(m, "packets_taken", WORD_BITS, "begins_now | ends", more);
    m.assert(
        "packets_add_up",
        "left + packets_taken == packets_ordered",
        "The packets of a job are those that were taken and those that are left.",
    );
    m.assert(
        "done_is_complete",
        "is_done -> packets_taken == packets_ordered & idle & ~is_open",
        "A job is done when all its packets have come and were taken, and the unit is idle.",
    );
    m.assert(
        "begins_at_rest",
        "begins_now -> idle & ~running",
        "A job begins only while no other runs.",
    );
    m.assert(
        "begun_or_refused",
        "begins_now == (start & any(packets) & idle & ~running) & refused == (start & ~begins_now)",
        "A start begins a job of packets while the unit is idle, and is refused else.",
    );
}
