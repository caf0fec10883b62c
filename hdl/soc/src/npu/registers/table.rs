//! The register table: the one place that says which registers there are.
//!
//! Registers that depend on the configuration keep their offset in every configuration.

use potamoi_formats::config::Config;
use potamoi_netlist::PortInfo;

use super::model::{Access, Field, Register, RegisterMap, WORD_BITS};

/// Version of the map: the first number changes where software has to.
pub const VERSION: [u32; 2] = [1, 0];
/// `POTA` in ASCII.
pub const IDENTIFIER: u32 = 0x504f_5441;

/// Settings of the gathering unit: port, field, lowest bit.
const SETTINGS: [(&str, &str, u32, &str); 4] = [
    (
        "cfg_vertices",
        "VERTICES",
        0,
        "log2 of the vertices of an entry; 0: single ids",
    ),
    ("cfg_segments", "SEGMENTS", 8, "channel segments, 1 and up"),
    (
        "cfg_two_records",
        "TWO_RECORDS",
        16,
        "two records share a row",
    ),
    (
        "cfg_channels",
        "CHANNELS",
        24,
        "channels of the last segment",
    ),
];

/// Counters: port, register, offset.
const OF_GATHERS: [(&str, &str, u32, &str); 6] = [
    (
        "stat_busy",
        "GU_BUSY",
        0x100,
        "cycles in which the gathering unit issued",
    ),
    (
        "stat_stall_fifo",
        "GU_STALL_FIFO",
        0x108,
        "stalls up to the last issue: too many groups in flight",
    ),
    (
        "stat_stall_mft",
        "GU_STALL_MFT",
        0x110,
        "stalls up to the last issue: MVoxel not loaded",
    ),
    (
        "stat_stall_rit",
        "GU_STALL_RIT",
        0x118,
        "stalls up to the last issue: no entry",
    ),
    (
        "stat_stall_bank",
        "GU_STALL_BANK",
        0x120,
        "stalls: a bank or a turn of ports",
    ),
    (
        "stat_entries",
        "GU_ENTRIES",
        0x128,
        "entries issued, once for each segment",
    ),
];
const OF_VECTORS: [(&str, &str, u32, &str); 3] = [
    ("stat_vectors", "VU_VECTORS", 0x180, "vectors accepted"),
    (
        "stat_busy",
        "VU_BUSY",
        0x188,
        "cycles in which a vector was accepted or stepped",
    ),
    (
        "stat_stall_out",
        "VU_STALL_OUT",
        0x190,
        "cycles in which only the lack of room refused a vector",
    ),
];

/// Flags of the gathering unit, from bit 0 on.
const GATHER_FLAGS: [(&str, &str); 9] = [
    (
        "ROW_NOT_LOADED",
        "an issued id names a row that was not loaded",
    ),
    (
        "WEIGHT_TOO_LARGE",
        "a weight has a bit above that of 1 set; never with 15 fraction bits",
    ),
    ("WEIGHTS_OFF_ONE", "the weights of an entry do not sum to 1"),
    (
        "RAGGED_ENTRIES",
        "an MVoxel's bytes are not a whole number of entries",
    ),
    (
        "GAP_IN_BEAT",
        "a beat of the RIT is neither full nor null nor the last, or tuser changes",
    ),
    (
        "RIT_TOO_LARGE",
        "an MVoxel exceeds both halves of the RIT buffer",
    ),
    (
        "MFT_ROW_DROPPED",
        "a beat of the MFT past the MVoxel's rows",
    ),
    (
        "BAD_SETTING",
        "an entry size that was not built, or segments out of range",
    ),
    (
        "SETTING_MOVED",
        "a setting changed while the unit was not idle",
    ),
];
/// Flags of the vector unit, from bit 0 on.
const VECTOR_FLAGS: [(&str, &str); 4] = [
    ("NOT_BUILT", "an operation that was not built"),
    ("ROUNDING_RESERVED", "a reserved rounding code"),
    ("TORN_LANE", "a lane with only some of its bytes kept"),
    (
        "OPERAND_BEYOND",
        "an operand beyond its width, where widths are below 32 bits",
    ),
];

/// The map of a configuration whose units have these ports.
#[must_use]
pub fn register_map(config: &Config, gathers: &[PortInfo], vectors: &[PortInfo]) -> RegisterMap {
    let mut registers = identity(config, gathers);
    registers.extend(control());
    registers.extend(jobs(config, gathers, vectors));
    registers.extend(counters(gathers, &OF_GATHERS));
    registers.extend(counters(vectors, &OF_VECTORS));
    RegisterMap {
        configuration: config.hash(),
        registers,
    }
}

/// Settings that these ports have: port and field's name.
pub(in crate::npu) fn settings(ports: &[PortInfo]) -> Vec<(&'static str, &'static str)> {
    let built = SETTINGS.iter().filter(|own| width(ports, own.0) > 0);
    built.map(|(port, field, ..)| (*port, *field)).collect()
}

/// Counters that these ports have: port and register's name.
pub(in crate::npu) fn counted(ports: &[PortInfo]) -> Vec<(&'static str, &'static str)> {
    let all = match width(ports, "stat_vectors") {
        0 => &OF_GATHERS[..],
        _ => &OF_VECTORS[..],
    };
    let built = all.iter().filter(|own| width(ports, own.0) > 0);
    built
        .map(|(port, register, ..)| (*port, *register))
        .collect()
}

/// Bits of a port, 0 where there is none.
fn width(ports: &[PortInfo], name: &str) -> u32 {
    let own = ports.iter().find(|port| port.name == name);
    own.map_or(0, |port| port.ty.width)
}

fn register(name: &str, offset: u32, access: Access, text: &str, fields: Vec<Field>) -> Register {
    Register {
        name: name.to_owned(),
        offset,
        access,
        description: text.to_owned(),
        fields,
    }
}

fn field(name: &str, low: u32, width: u32, reset: u32, description: &str) -> Field {
    Field {
        name: name.to_owned(),
        low,
        width,
        reset,
        description: description.to_owned(),
    }
}

fn whole(reset: u32, description: &str) -> Vec<Field> {
    vec![field("VALUE", 0, WORD_BITS, reset, description)]
}

/// One bit a name, from bit 0 on.
fn bits(names: &[(&str, &str)]) -> Vec<Field> {
    let own = (0..).zip(names);
    own.map(|(at, (name, text))| field(name, at, 1, 0, text))
        .collect()
}

/// What the hardware is.
fn identity(config: &Config, gathers: &[PortInfo]) -> Vec<Register> {
    let (gu, vu) = (&config.gu, &config.vu);
    let hash = u64::from_str_radix(&config.hash(), 16).unwrap_or_default();
    let sizes: u32 = config
        .supported_vertices()
        .iter()
        .map(|v| 1 << v.log2())
        .sum();
    let operations: u32 = vu.ops.iter().map(|op| 1 << op.code()).sum();
    let bytes = |port: &str| width(gathers, port) / 8;
    let own = Access::Constant;
    vec![
        register(
            "ID",
            0x000,
            own,
            "Identifies the block.",
            whole(IDENTIFIER, "`POTA` in ASCII"),
        ),
        register(
            "VERSION",
            0x004,
            own,
            "Version of this map.",
            vec![
                field(
                    "MINOR",
                    0,
                    16,
                    VERSION[1],
                    "changes where registers are added",
                ),
                field("MAJOR", 16, 16, VERSION[0], "changes where software has to"),
            ],
        ),
        register(
            "CONFIG_LOW",
            0x008,
            own,
            "Hash of the configuration, low part.",
            whole(hash as u32, "the last 8 hexadecimal digits"),
        ),
        register(
            "CONFIG_HIGH",
            0x00c,
            own,
            "Hash of the configuration, high part.",
            vec![field(
                "VALUE",
                0,
                16,
                (hash >> 32) as u32,
                "the first 4 hexadecimal digits",
            )],
        ),
        register(
            "GU_PARAMS",
            0x010,
            own,
            "Sizes of the gathering unit.",
            vec![
                field("BANKS", 0, 8, gu.banks, "banks B"),
                field("PORTS", 8, 4, gu.ports, "ports M"),
                field(
                    "ENTRY_SIZES",
                    12,
                    4,
                    sizes,
                    "bit n: entries of 2^n vertices are built",
                ),
                field("FEATURE_BITS", 16, 5, gu.feature_bits, "bits of a feature"),
                field(
                    "WEIGHT_BITS",
                    24,
                    4,
                    gu.weight_bits,
                    "fraction bits of a weight",
                ),
            ],
        ),
        register(
            "GU_LIMITS",
            0x014,
            own,
            "Limits of the gathering unit.",
            vec![
                field(
                    "ROWS",
                    0,
                    17,
                    config.mvoxel.rows,
                    "rows of an MVoxel at most",
                ),
                field("SEGMENTS", 24, 7, gu.segments, "channel segments at most"),
            ],
        ),
        register(
            "GU_STREAMS",
            0x018,
            own,
            "Bytes of a beat of the gathering unit's streams.",
            vec![
                field("RIT", 0, 10, bytes("s_axis_rit_tdata"), "ray index table"),
                field("MFT", 10, 10, bytes("s_axis_mft_tdata"), "rows"),
                field("FEATURES", 20, 12, bytes("m_axis_feat_tdata"), "features"),
            ],
        ),
        register(
            "VU_PARAMS",
            0x01c,
            own,
            "Sizes of the vector unit.",
            vec![
                field(
                    "LANES",
                    0,
                    9,
                    vu.lanes,
                    "lanes L; a beat has 8 L bytes of operands, 4 L of results",
                ),
                field(
                    "OPERATIONS",
                    12,
                    9,
                    operations,
                    "bit n: the operation of code n is built",
                ),
                field(
                    "OUTPUT_BITS",
                    24,
                    5,
                    vu.exp.output_bits,
                    "fraction bits of an exponential",
                ),
            ],
        ),
    ]
}

/// Commands, state and interrupts.
fn control() -> Vec<Register> {
    let events = [
        ("GU_DONE", "the gathering unit's job is done"),
        ("VU_DONE", "the vector unit's job is done"),
        ("GU_ERROR", "a flag of GU_ERRORS has risen"),
        ("VU_ERROR", "a flag of VU_ERRORS has risen"),
        (
            "GU_REFUSED",
            "GU_START came while a job ran, while the unit was not idle, or for 0 packets",
        ),
        (
            "VU_REFUSED",
            "VU_START came while a job ran, while the unit was not idle, or for 0 packets",
        ),
    ];
    let mut state = bits(&[
        (
            "GU_RUNNING",
            "a job of the gathering unit has begun and is not done",
        ),
        (
            "VU_RUNNING",
            "a job of the vector unit has begun and is not done",
        ),
        (
            "GU_IDLE",
            "nothing is received or in flight in the gathering unit",
        ),
        ("VU_IDLE", "no vector is inside the vector unit"),
    ]);
    for idle in &mut state[2..] {
        idle.reset = 1;
    }
    vec![
        register(
            "CONTROL",
            0x020,
            Access::Pulse,
            "Commands.",
            bits(&[
                (
                    "GU_START",
                    "begins a job of the gathering unit with GU_MODE and GU_PACKETS",
                ),
                (
                    "VU_START",
                    "begins a job of the vector unit with VU_PACKETS",
                ),
                ("CLEAR", "clears the counters and error flags of both units"),
                (
                    "SNAPSHOT",
                    "copies all counters, of one clock, to the registers that show them",
                ),
            ]),
        ),
        register(
            "STATUS",
            0x024,
            Access::Status,
            "State of the units.",
            state,
        ),
        register(
            "IRQ_STATUS",
            0x028,
            Access::WriteOneToClear,
            "Events since they were cleared. An event in the clock of its clearing stays.",
            bits(&events),
        ),
        register(
            "IRQ_ENABLE",
            0x02c,
            Access::ReadWrite,
            "Events of which any keeps the output irq high.",
            bits(&events),
        ),
    ]
}

/// Settings, length and progress of jobs, and error flags.
fn jobs(config: &Config, gathers: &[PortInfo], vectors: &[PortInfo]) -> Vec<Register> {
    let vector_flags = width(vectors, "stat_errors") as usize;
    let smallest = config.supported_vertices().first().map_or(0, |v| v.log2());
    let built = SETTINGS.iter().filter(|own| width(gathers, own.0) > 0);
    let settings = built.map(|(port, name, low, text)| {
        let bits = width(gathers, port);
        let reset = match *name {
            "VERTICES" => smallest,
            "SEGMENTS" => 1,
            "CHANNELS" => config.gu.banks,
            _ => 0,
        };
        field(name, *low, bits, reset, text)
    });
    let packets = "Packets of the next job.";
    let left = "Packets of the job that are still to be taken.";
    let (rw, status) = (Access::ReadWrite, Access::Status);
    vec![
        register(
            "GU_MODE",
            0x040,
            rw,
            "Settings of the next job of the gathering unit.",
            settings.collect(),
        ),
        register(
            "GU_PACKETS",
            0x044,
            rw,
            packets,
            whole(0, "MVoxels times segments: the ends (tlast) of m_axis_feat"),
        ),
        register(
            "GU_LEFT",
            0x048,
            status,
            left,
            whole(0, "packets of m_axis_feat"),
        ),
        register(
            "GU_ERRORS",
            0x04c,
            status,
            "Error flags of the gathering unit, sticky until CLEAR.",
            bits(&GATHER_FLAGS),
        ),
        register(
            "VU_PACKETS",
            0x050,
            rw,
            packets,
            whole(0, "the ends (tlast) of s_axis_vec"),
        ),
        register(
            "VU_LEFT",
            0x054,
            status,
            left,
            whole(0, "packets of m_axis_vec"),
        ),
        register(
            "VU_ERRORS",
            0x058,
            status,
            "Error flags of the vector unit, sticky until CLEAR.",
            bits(&VECTOR_FLAGS[..vector_flags.min(VECTOR_FLAGS.len())]),
        ),
    ]
}

/// Counters as of the last snapshot; one wider than a register has two.
fn counters(ports: &[PortInfo], all: &[(&str, &str, u32, &str)]) -> Vec<Register> {
    let mut registers = vec![];
    for (port, name, offset, text) in all {
        let bits = width(ports, port);
        let text = format!("Counter: {text}.");
        let shown = "as of the last SNAPSHOT";
        if bits == 0 {
            continue;
        }
        let low = vec![field("VALUE", 0, bits.min(WORD_BITS), 0, shown)];
        registers.push(register(name, *offset, Access::Status, &text, low));
        if bits > WORD_BITS {
            let high = vec![field(
                "VALUE",
                0,
                bits - WORD_BITS,
                0,
                "bits from 32 on, of the same snapshot",
            )];
            registers.push(register(
                &format!("{name}_HIGH"),
                offset + 4,
                Access::Status,
                &text,
                high,
            ));
        }
    }
    registers
}
