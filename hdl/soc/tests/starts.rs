//! Jobs of the vector unit, in the clock: what a start opens, when it is done, and what it refuses.

use potamoi_soc::npu::register_map_of;
use potamoi_soc::npu::registers::RegisterMap;

use crate::bus::{OKAY, Top, Write};
use crate::config;

struct Driver {
    top: Top,
    map: RegisterMap,
}

impl Driver {
    fn new() -> Self {
        Self {
            top: Top::new(&config(), 7, 0),
            map: register_map_of(&config()).unwrap(),
        }
    }

    fn write(&mut self, register: &str, data: u64) {
        let write = Write {
            address: self.map.register(register).unwrap().offset.into(),
            data,
            strobe: 0xf,
        };
        assert_eq!(self.top.write(write), OKAY);
    }

    fn read(&mut self, register: &str) -> u64 {
        let address = self.map.register(register).unwrap().offset.into();
        let [answer, data] = self.top.read(address);
        assert_eq!(answer, OKAY);
        data
    }

    fn bit(&self, register: &str, field: &str) -> u64 {
        let own = self.map.register(register).unwrap();
        let field = own.fields.iter().find(|own| own.name == field).unwrap();
        u64::from(field.mask())
    }

    fn has(&mut self, register: &str, field: &str) -> bool {
        let bit = self.bit(register, field);
        self.read(register) & bit != 0
    }

    /// Offers an operand of the operation pass; says whether it was taken.
    fn offer(&mut self, value: u64, last: bool) -> bool {
        for (port, value) in [
            ("tdata", value),
            ("tkeep", 0xff),
            ("tlast", u64::from(last)),
            ("tuser", 0),
            ("tvalid", 1),
        ] {
            self.top.set(&format!("s_axis_vec_{port}"), value);
        }
        let taken = self.top.get("s_axis_vec_tready") == 1;
        self.top.clock();
        self.top.set("s_axis_vec_tvalid", 0);
        taken
    }
}

/// Two packets are taken, a third waits for the next job; done comes with the last result.
#[test]
fn a_job_takes_its_packets_and_no_more() {
    let mut d = Driver::new();
    let (start, done) = (d.bit("CONTROL", "VU_START"), d.bit("IRQ_STATUS", "VU_DONE"));
    d.write("IRQ_ENABLE", done);
    assert!(!d.offer(1, false), "no job, and an operand was taken");
    d.write("VU_PACKETS", 2);
    d.write("CONTROL", start);
    for (value, last) in [(1, false), (2, true), (3, true)] {
        while !d.offer(value, last) {}
    }
    for _ in 0..20 {
        assert!(!d.offer(4, true), "an operand past the job was taken");
    }
    assert!(d.has("STATUS", "VU_RUNNING") && !d.has("STATUS", "VU_IDLE"));
    assert_eq!([d.read("VU_LEFT"), d.top.get("irq")], [2, 0]);
    let mut results = vec![];
    while results.len() < 3 {
        d.top.set("m_axis_vec_tready", 1);
        if d.top.get("m_axis_vec_tvalid") == 1 {
            results.push(d.top.get("m_axis_vec_tdata"));
            assert_eq!(d.top.get("m_axis_vec_tlast"), u64::from(results.len() > 1));
        }
        d.top.clock();
    }
    assert_eq!(results, [1, 2, 3]);
    d.top.set("m_axis_vec_tready", 0);
    // Idle, then the event, then the output.
    for expected in [0, 0, 1] {
        assert_eq!(d.top.get("irq"), expected);
        d.top.clock();
    }
    assert!(!d.has("STATUS", "VU_RUNNING") && d.has("STATUS", "VU_IDLE"));
    assert_eq!(d.read("IRQ_STATUS"), done);
    d.write("IRQ_STATUS", done);
    d.top.clock();
    assert_eq!([d.read("IRQ_STATUS"), d.top.get("irq")], [0, 0]);
    // Shown as of a snapshot alone.
    assert_eq!(d.read("VU_VECTORS"), 0);
    let snapshot = d.bit("CONTROL", "SNAPSHOT");
    d.write("CONTROL", snapshot);
    assert_eq!(d.read("VU_VECTORS"), 3);
    // A further job takes the operand that waited.
    d.write("VU_PACKETS", 1);
    d.write("CONTROL", start);
    while !d.offer(4, true) {}
}

#[test]
fn a_start_is_refused_while_a_job_runs_and_for_no_packets() {
    let mut d = Driver::new();
    for (short, other) in [("GU", "VU"), ("VU", "GU")] {
        let start = d.bit("CONTROL", &format!("{short}_START"));
        let refused = d.bit("IRQ_STATUS", &format!("{short}_REFUSED"));
        d.write("CONTROL", start);
        assert_eq!(d.read("IRQ_STATUS"), refused, "no packets");
        d.write("IRQ_STATUS", refused);
        d.write(&format!("{short}_PACKETS"), 9);
        d.write("CONTROL", start);
        assert_eq!(d.read("IRQ_STATUS"), 0);
        assert!(d.has("STATUS", &format!("{short}_RUNNING")));
        assert!(!d.has("STATUS", &format!("{other}_RUNNING")));
        d.write(&format!("{short}_PACKETS"), 5);
        d.write("CONTROL", start);
        assert_eq!(d.read("IRQ_STATUS"), refused, "a job runs");
        assert_eq!(
            d.read(&format!("{short}_LEFT")),
            9,
            "the job that runs is as it was"
        );
        d.top.reset();
    }
}

/// A flag that rises is an event once; clearing the flag does not clear the event.
#[test]
fn an_error_is_an_event_until_it_is_cleared() {
    let mut d = Driver::new();
    let (start, error) = (
        d.bit("CONTROL", "VU_START"),
        d.bit("IRQ_STATUS", "VU_ERROR"),
    );
    d.write("IRQ_ENABLE", error);
    d.write("VU_PACKETS", 2);
    d.write("CONTROL", start);
    d.top.set("m_axis_vec_tready", 1);
    for (port, value) in [("tkeep", 0x0f), ("tlast", 1), ("tvalid", 1)] {
        d.top.set(&format!("s_axis_vec_{port}"), value);
    }
    d.top.clock();
    d.top.set("s_axis_vec_tvalid", 0);
    let flag = d.bit("VU_ERRORS", "TORN_LANE");
    assert_eq!(
        [d.read("VU_ERRORS"), d.read("IRQ_STATUS"), d.top.get("irq")],
        [flag, error, 1]
    );
    let clear = d.bit("CONTROL", "CLEAR");
    d.write("CONTROL", clear);
    assert_eq!(
        [d.read("VU_ERRORS"), d.read("IRQ_STATUS"), d.top.get("irq")],
        [0, error, 1]
    );
    d.write("IRQ_STATUS", error);
    assert_eq!([d.read("IRQ_STATUS"), d.top.get("irq")], [0, 0]);
}
