//! The registers as hardware, made of the table: storage, decoding, and a port for each field.

use std::sync::Arc;

use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::field_placement::placed;
use super::register_checks::{Word, register_checks};
use super::registers::{Access, Field, INDEX_BITS, Register, RegisterMap, WORD_BITS};

/// Builds `npu_registers`. For each field: a constant has no port; a status an input; what software
/// writes an output; an event an output and the input `NAME_set`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn register_file(map: &RegisterMap) -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("npu_registers");
    let m = &mut builder;
    m.doc("the registers of the top: storage, decoding, and a port for each field.");
    let bit = Ty::bit();
    let word = Ty::u(WORD_BITS);
    let index = Ty::u(INDEX_BITS);
    let bus = Bus {
        write: m.input("write", bit, "a write takes effect at the clock edge"),
        write_index: m.input("write_index", index, "address without its two low bits"),
        data: m.input("write_data", word, ""),
        strobe: m.input(
            "write_strobe",
            Ty::u(WORD_BITS / 8),
            "bytes that are written",
        ),
        read_index: m.input("read_index", index, "address without its two low bits"),
        mask: None,
    };
    let mut inputs = vec![];
    for own in &map.registers {
        for field in &own.fields {
            inputs.push(input_of(m, own, field));
        }
    }
    m.section("Writes");
    let bytes: Vec<_> = (0..WORD_BITS / 8)
        .rev()
        .map(|byte| {
            let strobe = m.bit(bus.strobe, byte);
            m.repeat(strobe, 8)
        })
        .collect();
    let mask = m.cat(&bytes);
    let mask = m.name(mask, "write_mask");
    let ones = m.and(bus.data, mask);
    let ones = m.name(ones, "written_ones");
    let bus = Bus {
        mask: Some((mask, ones)),
        ..bus
    };
    let mut inputs = inputs.into_iter();
    let (mut words, mut read, mut written, mut outputs) = (vec![], vec![], vec![], vec![]);
    let mut shown = vec![];
    for own in &map.registers {
        m.section(&format!("{} ({})", own.name, own.access.short()));
        let of_fields: Vec<_> = inputs.by_ref().take(own.fields.len()).collect();
        let made = built(m, own, &of_fields, &bus);
        words.push(made.word);
        shown.push(Word {
            own,
            value: made.whole,
            set: of_fields,
        });
        read.push(made.is_read);
        written.extend(made.is_written);
        outputs.extend(made.outputs);
    }
    m.section("Outputs");
    for (name, signal, doc) in outputs {
        m.output(&name, signal, &doc);
    }
    let data = words.into_iter().reduce(|a, b| m.or(a, b));
    let data = data.unwrap_or_else(|| m.lit(0, word));
    let data = m.name(data, "word_read");
    m.output("read_data", data, "0 for an address without a register");
    let known = m.any_of(&read);
    let unknown = m.not(known);
    let unknown = m.name(unknown, "read_error");
    m.output("read_error", unknown, "no register has this address");
    let known = m.any_of(&written);
    let unknown = m.not(known);
    let unknown = m.name(unknown, "write_error");
    m.output(
        "write_error",
        unknown,
        "no register that can be written has this address",
    );
    register_checks(m, &shown);
    builder.finish()
}

/// The bus of the registers.
struct Bus {
    write: Signal,
    write_index: Signal,
    data: Signal,
    strobe: Signal,
    read_index: Signal,
    /// Bits that are written, and those that are written as 1.
    mask: Option<(Signal, Signal)>,
}

/// A register in the netlist.
struct Built {
    /// The fields at their places.
    whole: Signal,
    /// What it adds to the word that is read.
    word: Signal,
    is_read: Signal,
    is_written: Option<Signal>,
    outputs: Vec<(String, Signal, String)>,
}

fn input_of(m: &mut ModuleBuilder, own: &Register, field: &Field) -> Option<Signal> {
    let name = own.signal(field);
    let ty = Ty::u(field.width);
    match own.access {
        Access::Status => Some(m.input(&name, ty, &field.description)),
        Access::WriteOneToClear => Some(m.input(&format!("{name}_set"), ty, &field.description)),
        Access::Constant | Access::ReadWrite | Access::Pulse => None,
    }
}

/// Whether an index of the bus is a register's.
fn is_at(m: &mut ModuleBuilder, index: Signal, register: &Register) -> Signal {
    let own = m.lit(register.offset / 4, index.ty());
    m.eq(index, own)
}

fn built(m: &mut ModuleBuilder, own: &Register, inputs: &[Option<Signal>], bus: &Bus) -> Built {
    let name = own.name.to_ascii_lowercase();
    let is_written = own.access.is_written().then(|| {
        let hit = is_at(m, bus.write_index, own);
        m.name(hit, &format!("{name}_addressed"))
    });
    let writes = is_written.map(|hit| {
        let writes = m.and(bus.write, hit);
        m.name(writes, &format!("{name}_written"))
    });
    let mut outputs = vec![];
    let values: Vec<_> = own
        .fields
        .iter()
        .zip(inputs)
        .map(|(field, input)| {
            let (value, output) = stored(m, own, field, *input, bus.mask.zip(writes));
            if let Some(output) = output {
                outputs.push((own.signal(field), output, field.description.clone()));
            }
            value
        })
        .collect();
    let is_read = is_at(m, bus.read_index, own);
    let is_read = m.name(is_read, &format!("{name}_read"));
    let whole = placed(m, own, &values);
    let whole = match own.access {
        Access::ReadWrite | Access::WriteOneToClear if whole != values[0] => {
            m.name(whole, &format!("{name}_word"))
        }
        _ => whole,
    };
    let taken = m.repeat(is_read, WORD_BITS);
    let word = m.and(taken, whole);
    Built {
        whole,
        word,
        is_read,
        is_written,
        outputs,
    }
}

/// What a field shows to a read, and to the hardware if it is its to see.
fn stored(
    m: &mut ModuleBuilder,
    own: &Register,
    field: &Field,
    input: Option<Signal>,
    writes: Option<((Signal, Signal), Signal)>,
) -> (Signal, Option<Signal>) {
    let ty = Ty::u(field.width);
    let constant = m.lit(field.reset, ty);
    let Some(((mask, ones), write)) = writes else {
        return (input.unwrap_or(constant), None);
    };
    let mask = m.slice(mask, field.low, field.width);
    let ones = m.slice(ones, field.low, field.width);
    if own.access == Access::Pulse {
        let here = m.repeat(write, field.width);
        let pulse = m.and(here, ones);
        return (m.lit(0, ty), Some(pulse));
    }
    let reg = m.reg(&own.signal(field), ty, field.reset);
    match (own.access, input) {
        (Access::WriteOneToClear, Some(set)) => {
            let here = m.repeat(write, field.width);
            let cleared = m.and(here, ones);
            let stays = m.not(cleared);
            let stays = m.and(reg, stays);
            let next = m.or(stays, set);
            m.set_next(reg, next);
        }
        _ => {
            let kept = m.not(mask);
            let kept = m.and(reg, kept);
            let next = m.or(kept, ones);
            m.set_next_if(reg, write, next);
        }
    }
    (reg, Some(reg))
}
