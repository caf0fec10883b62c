//! Registers that move with a pipeline.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

/// A register that moves with the pipeline.
pub(super) fn moved(m: &mut ModuleBuilder, name: &str, value: Signal, enable: Signal) -> Signal {
    let register = m.data_reg(name, value.ty());
    m.set_next_if(register, enable, value);
    register
}

/// The same over several stages, as one shift register; the first stage is lowest.
pub(super) fn shifted(
    m: &mut ModuleBuilder,
    name: &str,
    value: Signal,
    stages: u32,
    enable: Signal,
) -> Signal {
    if stages == 0 {
        return value;
    }
    let width = value.width();
    let all = m.data_reg(name, Ty::u(stages * width));
    let value = m.as_unsigned(value);
    let next = match stages {
        1 => value,
        _ => {
            let held = m.slice(all, 0, (stages - 1) * width);
            m.cat(&[held, value])
        }
    };
    m.set_next_if(all, enable, next);
    m.slice(all, (stages - 1) * width, width)
}
