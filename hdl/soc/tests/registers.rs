//! Every register after reset, and under random writes and reads, as the table says.

use potamoi_soc::npu::register_map_of;
use potamoi_soc::npu::registers::{ADDRESS_BITS, Access, WORD_BYTES};
use rand::Rng;

use crate::bus::{OKAY, SLVERR, Top, Write};
use crate::config;
use crate::model::Model;

#[test]
fn every_address_reads_its_reset_value_or_an_error() {
    let map = register_map_of(&config()).unwrap();
    let mut top = Top::new(&config(), 1, 0);
    for word in 0..(1 << ADDRESS_BITS) / WORD_BYTES {
        let address = word * WORD_BYTES;
        let own = map.registers.iter().find(|own| own.offset == address);
        let expected = match own {
            Some(own) => [OKAY, u64::from(own.reset())],
            None => [SLVERR, 0],
        };
        assert_eq!(top.read(u64::from(address)), expected, "{address:#x}");
    }
}

/// All ones, then all zeros, to every address: what is kept, what is refused, and nothing else moves.
#[test]
fn a_write_changes_its_register_alone() {
    let map = register_map_of(&config()).unwrap();
    for own in &map.registers {
        let mut top = Top::new(&config(), 2, 0);
        let mut model = Model::new(&map);
        for data in [0xffff_ffff, 0] {
            let write = Write {
                address: own.offset.into(),
                data,
                strobe: 0xf,
            };
            let expected = if own.access.is_written() {
                OKAY
            } else {
                SLVERR
            };
            assert_eq!(model.write(write), expected);
            assert_eq!(top.write(write), expected, "{}", own.name);
            for other in &map.registers {
                let address = other.offset.into();
                assert_eq!(
                    top.read(address),
                    model.read(address),
                    "{} after {write:x?}",
                    other.name
                );
            }
        }
    }
}

/// Random writes and reads, in every order of the channels, at any address, with any strobes.
#[test]
fn random_transfers_do_what_the_table_says() {
    let map = register_map_of(&config()).unwrap();
    for (seed, pauses) in [(1, 0), (2, 30), (3, 60), (4, 85)] {
        let mut top = Top::new(&config(), seed, pauses);
        let mut model = Model::new(&map);
        for at in 0..400 {
            let address = |top: &mut Top| match top.random.random_range(0..8) {
                0 => top.random.random_range(0..1u64 << ADDRESS_BITS),
                _ => {
                    let own = &map.registers[top.random.random_range(0..map.registers.len())];
                    u64::from(own.offset) + top.random.random_range(0..4)
                }
            };
            // Few starts, so that both answers to one occur.
            if at == 200 {
                top.reset();
                model = Model::new(&map);
            }
            let write = Write {
                address: address(&mut top),
                data: top.random.random_range(0..1 << 32) >> top.random.random_range(0..32),
                strobe: top.random.random_range(0..16),
            };
            let read = address(&mut top);
            let place = format!("seed {seed}, transfer {at}: {write:x?}, read {read:#x}");
            match top.random.random_range(0..3) {
                0 => assert_eq!(top.write(write), model.write(write), "{place}"),
                1 => assert_eq!(top.read(read), model.read(read), "{place}"),
                _ => {
                    // What is read beside a write is from before or after it.
                    let before = model.read(read);
                    let expected = model.write(write);
                    let after = model.read(read);
                    let (answer, data) = top.both(write, read);
                    assert_eq!(answer, expected, "{place}");
                    assert!(data == before || data == after, "{place}: {data:x?}");
                }
            }
            top.clock();
            assert_eq!(top.get("irq"), model.irq(), "{place}");
        }
    }
}

/// A second transfer waits until the response of the first has been taken.
#[test]
fn one_write_and_one_read_are_taken_at_a_time() {
    let mut top = Top::new(&config(), 5, 0);
    for (valid, ready) in [
        ("s_axil_awvalid", "s_axil_awready"),
        ("s_axil_wvalid", "s_axil_wready"),
        ("s_axil_arvalid", "s_axil_arready"),
    ] {
        assert_eq!(top.get(ready), 1, "{ready} before its valid");
        top.set(valid, 1);
    }
    for clock in 0..6 {
        top.clock();
        for ready in ["s_axil_awready", "s_axil_wready", "s_axil_arready"] {
            assert_eq!(top.get(ready), 0, "{ready} in clock {clock}");
        }
    }
    for response in ["s_axil_bvalid", "s_axil_rvalid"] {
        assert_eq!(top.get(response), 1);
    }
    top.set("s_axil_bready", 1);
    top.set("s_axil_rready", 1);
    // Not in the same clock: no path leads from ready to ready.
    assert_eq!(
        [top.get("s_axil_awready"), top.get("s_axil_arready")],
        [0, 0]
    );
    top.clock();
    assert_eq!(
        [top.get("s_axil_awready"), top.get("s_axil_arready")],
        [1, 1]
    );
}

/// A reset takes back a transfer that has begun.
#[test]
fn a_reset_forgets_half_a_write_and_a_response() {
    let map = register_map_of(&config()).unwrap();
    let enable = map.register("IRQ_ENABLE").unwrap();
    assert_eq!(enable.access, Access::ReadWrite);
    let mut top = Top::new(&config(), 6, 0);
    top.set("s_axil_awaddr", enable.offset.into());
    top.set("s_axil_awvalid", 1);
    top.set("s_axil_arvalid", 1);
    top.clock();
    top.set("s_axil_awvalid", 0);
    top.set("s_axil_arvalid", 0);
    assert_eq!(top.get("s_axil_rvalid"), 1);
    top.reset();
    assert_eq!([top.get("s_axil_rvalid"), top.get("s_axil_bvalid")], [0, 0]);
    top.set("s_axil_wdata", 0x3f);
    top.set("s_axil_wstrb", 0xf);
    top.set("s_axil_wvalid", 1);
    top.clock();
    top.set("s_axil_wvalid", 0);
    for _ in 0..4 {
        top.clock();
        assert_eq!(top.get("s_axil_bvalid"), 0, "data alone are no write");
    }
    top.reset();
    assert_eq!(top.read(enable.offset.into()), [OKAY, 0]);
}
