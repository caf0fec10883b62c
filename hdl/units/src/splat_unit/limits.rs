//! The table of limits: the largest power at which an opacity counts, rounded up. The host writes it, so
//! that the unit assumes nothing of the exponential or of the alpha threshold.
//!
//! An opacity is its leading one, the six bits after it, and a rest. The limit is a word for the six
//! bits less a word for the place of the leading one.
//!
//! With the opacity in the power, the limit is one word less the opacity's logarithm, exactly.

use potamoi_formats::config::SplatOpacity;
use potamoi_netlist::{Instance, IrErrors, ModuleBuilder, Signal, Ty};

use super::formats::{COMPARE, SEARCH_LIMIT, Widths};
use crate::circuits::is;
use crate::memory::{Size, ram_1r1w};

/// Bits after the leading one.
const INDEX: u32 = 6;
/// Bits of an address: base words, then words of leading ones.
pub(super) const ADDRESS: u32 = 7;

/// The table and its write port.
pub(super) enum Table {
    /// By classes of opacities.
    Classes { base: Instance, less: Instance },
    /// The largest power that counts, and whether any does.
    Sum { most: Signal, counts: Signal },
}

/// Words of the table for an opacity.
pub(super) struct Stored {
    base: Signal,
    less: Signal,
    counts: Signal,
}

/// The limit of an entry.
pub(super) struct Limit {
    /// The largest power that counts.
    pub(super) limit: Signal,
    /// The same with the fraction bits of the search.
    pub(super) search: Signal,
    /// The same of the entry that is multiplied.
    pub(super) early: Signal,
    /// Whether any power counts.
    pub(super) counts: Signal,
}

impl Table {
    /// Declares the table; words are one bit wider than a power.
    ///
    /// # Errors
    /// The netlist's own checks.
    pub(super) fn declare(m: &mut ModuleBuilder, w: &Widths) -> Result<Self, IrErrors> {
        let we = m.input("limit_we", Ty::bit(), "writes a word of the table");
        let address = m.input(
            "limit_addr",
            Ty::u(ADDRESS),
            "0 to 63: base, by the bits after the leading one; 64 to 79: by its place",
        );
        let data = m.input(
            "limit_data",
            Ty::u(w.power + 1),
            "base; or what is subtracted, with the highest bit if any power counts",
        );
        if w.opacity == SplatOpacity::InPower {
            return Ok(Self::sum(m, we, address, data));
        }
        let memory = |name, words, bits| ram_1r1w(name, Size { words, bits });
        let base = memory("splat_limit_base", 1 << INDEX, w.power)?;
        let base = m.instance("limit_base", &base, &[]);
        let less = memory("splat_limit_less", 16, w.power + 1)?;
        let less = m.instance("limit_less", &less, &[]);
        let second = m.bit(address, INDEX);
        let first = m.not(second);
        let (to_base, to_less) = (m.and(we, first), m.and(we, second));
        let (low, lower) = (m.slice(address, 0, INDEX), m.slice(address, 0, 4));
        let word = m.slice(data, 0, w.power);
        for (memory, enable, address, word) in
            [(base, to_base, low, word), (less, to_less, lower, data)]
        {
            m.connect(memory, "we", enable);
            m.connect(memory, "waddr", address);
            m.connect(memory, "wdata", word);
        }
        let between = m.slice(address, 4, INDEX - 4);
        m.unused(between, "Places of leading ones are 0 to 15.");
        Ok(Self::Classes { base, less })
    }

    /// The word at address 0.
    fn sum(m: &mut ModuleBuilder, we: Signal, address: Signal, data: Signal) -> Self {
        let first = is(m, address, 0);
        let writes = m.and(we, first);
        let power = data.width() - 1;
        let (most, counts) = (m.slice(data, 0, power), m.bit(data, power));
        let register = |m: &mut ModuleBuilder, name: &str, value: Signal| {
            let register = m.data_reg(name, value.ty());
            m.set_next_if(register, writes, value);
            register
        };
        Self::Sum {
            most: register(m, "limit_most", most),
            counts: register(m, "limit_counts", counts),
        }
    }

    /// Reads the words of an opacity at the clock edge. The opacity stays as it is in the clock after.
    pub(super) fn look_up(&self, m: &mut ModuleBuilder, now: Signal, opacity: Signal) -> Stored {
        let (of_base, of_less) = match *self {
            Self::Classes { base, less } => (base, less),
            Self::Sum { most, counts } => {
                let within = m.ge(most, opacity);
                return Stored {
                    base: most,
                    less: opacity,
                    counts: m.and(counts, within),
                };
            }
        };
        let width = opacity.width();
        // The last one that is set counts.
        let mut place = m.lit(0, Ty::u(4));
        for bit in 1..width {
            let set = m.bit(opacity, bit);
            let own = m.lit(bit, Ty::u(4));
            place = m.mux(set, own, place);
        }
        let place = m.name(place, "leading_one");
        let above = m.not(place);
        let moved = m.shl(opacity, above);
        let moved = m.name(moved, "from_leading_one");
        let index = m.slice(moved, width - 1 - INDEX, INDEX);
        let index = m.name(index, "after_leading_one");
        let read = |m: &mut ModuleBuilder, memory: Instance, address: Signal| {
            m.connect(memory, "re", now);
            m.connect(memory, "raddr", address);
            m.out(memory, "rdata")
        };
        let base = read(m, of_base, index);
        let word = read(m, of_less, place);
        let power = word.width() - 1;
        let some = m.any(opacity);
        let counts = m.bit(word, power);
        Stored {
            base,
            less: m.slice(word, 0, power),
            counts: m.and(counts, some),
        }
    }
}

impl Limit {
    /// The limit, kept at `enable`.
    pub(super) fn kept(m: &mut ModuleBuilder, w: &Widths, stored: Stored, enable: Signal) -> Self {
        let below = m.lt(stored.base, stored.less);
        let less = m.sub(stored.base, stored.less);
        let none = m.lit(0, less.ty());
        let next = m.mux(below, none, less);
        // Known clocks before the entry leaves, so that its root is found meanwhile.
        let early = m.data_reg("limit_early", next.ty());
        m.set_next(early, next);
        let limit = m.data_reg("limit", next.ty());
        m.set_next_if(limit, enable, early);
        let counts = m.data_reg("counts", Ty::bit());
        m.set_next_if(counts, enable, stored.counts);
        Self {
            limit,
            search: search_of(m, w, limit),
            early: search_of(m, w, early),
            counts,
        }
    }
}

/// Twice a limit with the fraction bits of the search; those below are dropped.
fn search_of(m: &mut ModuleBuilder, w: &Widths, limit: Signal) -> Signal {
    let dropped = w.power_fraction - 2 * COMPARE;
    let search = match dropped {
        0 => {
            let wide = m.extend(limit, w.power + 1);
            m.shl_const(wide, 1)
        }
        _ => m.slice(limit, dropped - 1, w.power - (dropped - 1)),
    };
    match search.width() {
        narrow if narrow < SEARCH_LIMIT => m.extend(search, SEARCH_LIMIT),
        _ => m.slice(search, 0, SEARCH_LIMIT),
    }
}
