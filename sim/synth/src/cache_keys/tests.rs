//! Each input changed alone changes the key. A new input does not compile until it is set here; an
//! input missing from a key fails.

#![allow(clippy::expect_used)]

use super::*;

fn all_differ(keys: impl IntoIterator<Item = Key>) {
    let keys: Vec<String> = keys.into_iter().map(|key| key.hex()).collect();
    for (n, key) in keys.iter().enumerate() {
        assert!(!keys[..n].contains(key), "change {n} is not in the key");
    }
}

/// Digests of one module.
fn netlists(name: &str, digest: &str) -> NetlistDigests {
    let text = format!("{{\"{name}\": \"{digest}\"}}");
    serde_json::from_str(&text).expect("digests")
}

#[test]
fn of_a_unit_in_cells() {
    let (own, changed, name) = (netlists("a", "x"), netlists("a", "y"), netlists("b", "x"));
    let other = |name, text: &str| [(name, text.to_owned())];
    let (others, another, renamed) = (other("o", "1"), other("o", "2"), other("p", "1"));
    let i = UnitInputs {
        unit: UnitKind::Vector,
        yosys: "Yosys 1",
        opensta: "2",
        library: "a1",
        scripts: ["s", "t", "u"],
        others: &others,
        netlists: &own,
    };
    let changed = [
        i,
        UnitInputs {
            unit: UnitKind::Gathering,
            ..i
        },
        UnitInputs {
            yosys: "Yosys 2",
            ..i
        },
        UnitInputs { opensta: "3", ..i },
        UnitInputs { library: "a2", ..i },
        UnitInputs {
            scripts: ["S", "t", "u"],
            ..i
        },
        UnitInputs {
            scripts: ["s", "T", "u"],
            ..i
        },
        UnitInputs {
            scripts: ["s", "t", "U"],
            ..i
        },
        UnitInputs {
            others: &another,
            ..i
        },
        UnitInputs {
            others: &renamed,
            ..i
        },
        UnitInputs {
            netlists: &changed,
            ..i
        },
        UnitInputs {
            netlists: &name,
            ..i
        },
    ];
    all_differ(changed.map(|inputs| inputs.key()));
    let limits = i.key().names().filter(|name| *name == "limits").count();
    assert_eq!(limits, 1);
}

#[test]
fn of_a_netlist_timed_once_more() {
    let i = RetimeInputs {
        unit: UnitKind::Vector,
        wanted: ["ends", "1"],
        opensta: "2",
        library: "a1",
        script: "s",
        netlist: "n",
        others: &[("o", "1")],
    };
    let changed = [
        i,
        RetimeInputs {
            unit: UnitKind::Gathering,
            ..i
        },
        RetimeInputs {
            wanted: ["access", "1"],
            ..i
        },
        RetimeInputs {
            wanted: ["ends", "2"],
            ..i
        },
        RetimeInputs { opensta: "3", ..i },
        RetimeInputs { library: "a2", ..i },
        RetimeInputs { script: "t", ..i },
        RetimeInputs { netlist: "m", ..i },
        RetimeInputs {
            others: &[("o", "2")],
            ..i
        },
        RetimeInputs {
            others: &[("p", "1")],
            ..i
        },
    ];
    all_differ(changed.map(|inputs| inputs.key()));
}

#[test]
fn of_a_mapped_module() {
    let of = |name, text| BTreeMap::from([(name, text)]);
    let (own, text, name) = (of("a.v", "x"), of("a.v", "y"), of("b.v", "x"));
    let i = MappedInputs {
        unit: "vector_unit",
        yosys: "Yosys 1",
        library: "a1",
        script: "s",
        texts: &own,
    };
    let changed = [
        i,
        MappedInputs { unit: "cells", ..i },
        MappedInputs {
            yosys: "Yosys 2",
            ..i
        },
        MappedInputs { library: "a2", ..i },
        MappedInputs { script: "t", ..i },
        MappedInputs { texts: &text, ..i },
        MappedInputs { texts: &name, ..i },
    ];
    all_differ(changed.map(|inputs| inputs.key()));
}

#[test]
fn of_a_mapped_module_without_names() {
    let (own, changed) = (netlists("a", "x"), netlists("a", "y"));
    let [others, another] = ["1", "2"].map(|text| [("o", text.to_owned())]);
    let i = NamelessInputs {
        unit: "vector_unit",
        yosys: "Yosys 1",
        library: "a1",
        script: "s",
        others: &others,
        netlists: &own,
    };
    let changed = [
        i,
        NamelessInputs { unit: "cells", ..i },
        NamelessInputs {
            yosys: "Yosys 2",
            ..i
        },
        NamelessInputs { library: "a2", ..i },
        NamelessInputs { script: "t", ..i },
        NamelessInputs {
            others: &another,
            ..i
        },
        NamelessInputs {
            netlists: &changed,
            ..i
        },
    ];
    all_differ(changed.map(|inputs| inputs.key()));
}

#[test]
fn of_power() {
    let report = UnitReport {
        unit: "vector_unit".to_owned(),
        netlists: netlists("vector_unit", "x"),
        cells: 2,
        flops: 1,
        buffers: 0,
        area_um2: 1.5,
        period_ps: 1000.0,
        clock_ghz: 1.0,
        path: ["a", "b"].map(str::to_owned),
        path_cells: 1,
        modules: vec![],
        memories: vec![],
        flop_memories: vec![],
        with_memories: None,
        power: None,
    };
    let larger = UnitReport {
        cells: 3,
        ..report.clone()
    };
    let [paper, small] = ["paper", "small"].map(|name| Config::preset(name).expect("a preset"));
    let (work, share, number) = ([(0.5, 1)], [(0.25, 1)], [(0.5, 2)]);
    let i = PowerInputs {
        unit: UnitKind::Vector,
        library: "a1",
        scene: "garden",
        report: &report,
        config: &paper,
        netlist: "n",
        parts: vec![("p".to_owned(), &work[..])],
    };
    let with = |change: &dyn Fn(&mut PowerInputs<'_, i32>)| {
        let mut changed = i.clone();
        change(&mut changed);
        changed.key()
    };
    all_differ([
        i.key(),
        with(&|i| i.unit = UnitKind::Gathering),
        with(&|i| i.library = "a2"),
        with(&|i| i.scene = "lantern"),
        with(&|i| i.netlist = "m"),
        PowerInputs {
            report: &larger,
            ..i.clone()
        }
        .key(),
        PowerInputs {
            config: &small,
            ..i.clone()
        }
        .key(),
        PowerInputs {
            parts: vec![("q".to_owned(), &work[..])],
            ..i.clone()
        }
        .key(),
        PowerInputs {
            parts: vec![("p".to_owned(), &share[..])],
            ..i.clone()
        }
        .key(),
        PowerInputs {
            parts: vec![("p".to_owned(), &number[..])],
            ..i.clone()
        }
        .key(),
        PowerInputs {
            parts: vec![],
            ..i.clone()
        }
        .key(),
    ]);
}

#[test]
fn of_a_unit_in_an_fpga() {
    let (own, changed) = (netlists("a", "x"), netlists("a", "y"));
    let i = FpgaInputs {
        unit: UnitKind::Vector,
        yosys: "Yosys 1",
        nextpnr: "1",
        script: "s",
        arguments: &["--seed", "1"],
        netlists: &own,
    };
    let changed = [
        i,
        FpgaInputs {
            unit: UnitKind::Gathering,
            ..i
        },
        FpgaInputs {
            yosys: "Yosys 2",
            ..i
        },
        FpgaInputs { nextpnr: "2", ..i },
        FpgaInputs { script: "t", ..i },
        FpgaInputs {
            arguments: &["--seed", "2"],
            ..i
        },
        FpgaInputs {
            netlists: &changed,
            ..i
        },
    ];
    all_differ(changed.map(|inputs| inputs.key()));
}

#[test]
fn of_a_memory() {
    let of = |cacti, shape, configuration| {
        let inputs = MemoryInputs {
            cacti,
            shape,
            configuration,
        };
        inputs.key()
    };
    let shape = [64, 32, 1, 0, 0];
    let mut keys = vec![of("CACTI 7", shape, "c")];
    for part in 0..shape.len() {
        let mut changed = shape;
        changed[part] += 1;
        keys.push(of("CACTI 7", changed, "c"));
    }
    keys.push(of("CACTI 8", shape, "c"));
    keys.push(of("CACTI 7", shape, "d"));
    all_differ(keys);
}
