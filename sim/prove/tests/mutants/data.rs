//! Mutants of modules that are proven alone.

use crate::Mutant;

pub(crate) const BANK: [Mutant; 1] = [[
    "holds",
    "mft_bank.v",
    "if (re) word <= mem[addr];",
    "word <= mem[addr];",
]];
pub(crate) const RIT_BANK: [Mutant; 1] = [[
    "holds",
    "rit_bank.v",
    "if (re) word <= mem[raddr];",
    "word <= mem[raddr];",
]];
pub(crate) const REDUCER: [Mutant; 1] = [["acc_held", "reducer.v", "if (valid) acc", "acc"]];
pub(crate) const LANE: [Mutant; 2] = [
    ["exact_held", "vector_lane.v", "if (accept) exact", "exact"],
    [
        "remainders_bounded",
        "vector_lane.v",
        "23'h2c5c86 <= remain_start",
        "23'h2c5c87 <= remain_start",
    ],
];
pub(crate) const HALVES: [Mutant; 6] = [
    ["low_asked", "mft_halves.v", "re & (~read_half)", "re"],
    ["high_asked", "mft_halves.v", "re & read_half", "re"],
    [
        "low_written",
        "mft_halves.v",
        "loaded[0] ? raddr : waddr",
        "loaded[0] ? raddr : (waddr ^ 9'd1)",
    ],
    [
        "low_read",
        "mft_halves.v",
        "loaded[0] ? raddr : waddr",
        "loaded[0] ? (raddr ^ 9'd1) : waddr",
    ],
    [
        "high_written",
        "mft_halves.v",
        "loaded[1] ? raddr : waddr",
        "loaded[1] ? raddr : (waddr ^ 9'd1)",
    ],
    [
        "high_read",
        "mft_halves.v",
        "loaded[1] ? raddr : waddr",
        "loaded[1] ? (raddr ^ 9'd1) : waddr",
    ],
];
