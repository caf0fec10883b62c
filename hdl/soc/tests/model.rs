//! What software sees of the registers while no stream moves.

use std::collections::BTreeMap;

use potamoi_soc::npu::registers::{Access, Register, RegisterMap};

use crate::bus::{OKAY, SLVERR, Write};

/// The registers as a model of software.
pub(crate) struct Model {
    map: RegisterMap,
    values: BTreeMap<String, u64>,
}

impl Model {
    pub(crate) fn new(map: &RegisterMap) -> Self {
        let values = map.registers.iter();
        let values = values.map(|own| (own.name.clone(), u64::from(own.reset())));
        Self {
            map: map.clone(),
            values: values.collect(),
        }
    }

    fn at(&self, address: u64) -> Option<&Register> {
        let mut all = self.map.registers.iter();
        all.find(|own| u64::from(own.offset) == address & !3)
    }

    fn bit(&self, register: &str, field: &str) -> u64 {
        let own = self.map.register(register).unwrap();
        let field = own.fields.iter().find(|own| own.name == field).unwrap();
        u64::from(field.mask())
    }

    /// Response and data of a read.
    pub(crate) fn read(&self, address: u64) -> [u64; 2] {
        match self.at(address) {
            Some(own) => [OKAY, self.values[&own.name]],
            None => [SLVERR, 0],
        }
    }

    /// The response to a write, which takes its effect.
    pub(crate) fn write(&mut self, write: Write) -> u64 {
        let Some(own) = self.at(write.address).cloned() else {
            return SLVERR;
        };
        let bytes = (0..4).filter(|byte| write.strobe >> byte & 1 == 1);
        let mask: u64 = bytes.map(|byte| 0xff << (8 * byte)).sum();
        let (fields, ones) = (u64::from(own.mask()), write.data & mask);
        let before = self.values[&own.name];
        let after = match own.access {
            Access::Constant | Access::Status => return SLVERR,
            Access::ReadWrite => (before & !mask | ones) & fields,
            Access::WriteOneToClear => before & !ones,
            Access::Pulse => {
                self.start("GU", ones);
                self.start("VU", ones);
                0
            }
        };
        self.values.insert(own.name, after);
        OKAY
    }

    /// A start of a job without streams: it runs for ever.
    fn start(&mut self, short: &str, ones: u64) {
        if ones & self.bit("CONTROL", &format!("{short}_START")) == 0 {
            return;
        }
        let running = self.bit("STATUS", &format!("{short}_RUNNING"));
        let packets = self.values[&format!("{short}_PACKETS")];
        if self.values["STATUS"] & running != 0 || packets == 0 {
            let event = self.bit("IRQ_STATUS", &format!("{short}_REFUSED"));
            *self.values.get_mut("IRQ_STATUS").unwrap() |= event;
        } else {
            *self.values.get_mut("STATUS").unwrap() |= running;
            self.values.insert(format!("{short}_LEFT"), packets);
        }
    }

    /// Whether the interrupt is due.
    pub(crate) fn irq(&self) -> u64 {
        u64::from(self.values["IRQ_STATUS"] & self.values["IRQ_ENABLE"] != 0)
    }
}
