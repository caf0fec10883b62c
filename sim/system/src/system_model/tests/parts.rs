//! Parts by themselves: weights, descriptors, the interconnect, the link, warping, waits.

use super::*;

/// Weights that fit are loaded once per path, others for each block. A slow interconnect is a limit
/// of its own, and descriptors cost their length.
#[test]
fn weights_descriptors_and_the_interconnect_cost_what_they_move() {
    let mut work = some_work();
    work.batches = vec![
        Batch {
            mvoxels: 3,
            feature_bytes: 1000,
            products: 2,
            ..work.batches[0]
        };
        4
    ];
    let of = |system: &System, gathering| frame(system, &work, gathering);
    let whole = of(&System::default(), Gathering::Unit);
    assert!(near(whole.spent.weight_bytes, WEIGHTS as f64));
    // Rows and entries of MVoxels, pixels of one block, weights.
    assert_eq!(whole.spent.transfers, 24 + 1 + 1);
    let small = System {
        weight_buffer_bytes: WEIGHTS - 1,
        feature_block_bytes: 1024,
        ..System::default()
    };
    let again = of(&small, Gathering::Unit);
    assert!(near(again.spent.weight_bytes, 4.0 * WEIGHTS as f64));
    assert!(again.energy.buffers_mj > whole.energy.buffers_mj);
    let slow = System {
        interconnect_over_memory: 0.01,
        ..System::default()
    };
    let (found, bytes) = (of(&slow, Gathering::Unit), whole.spent.interconnect_bytes);
    assert!(
        found.span_ns >= bytes / slow.interconnect_gb_s() && found.interconnect_utilisation > 0.5
    );
    assert!(whole.interconnect_utilisation < whole.memory_utilisation);
    let free = System {
        dma_descriptor_bytes: 0.0,
        interconnect_pj_per_byte: 0.0,
        ..System::default()
    };
    let found = of(&free, Gathering::Unit);
    assert!(found.energy.dma_mj == 0.0 && found.energy.interconnect_mj == 0.0);
    assert!(found.span_ns < whole.span_ns && whole.energy.dma_mj > 0.0);
}

/// A block in one bank of one port is a limit of its own; a block over all banks is not. Bytes and
/// energy of the buffers are the same.
#[test]
fn ports_of_the_feature_buffer_are_a_limit() {
    let work = figures::frame(false, 9, 4096);
    let total = work.total();
    let of = |system: &System| frame(system, &work, Gathering::Unit);
    let wide = of(&System::default());
    let gathered = total.feature_bytes;
    let array = total.input_bytes + total.output_bytes + 2 * total.partial_bytes;
    let vector = total.operand_bytes + total.result_bytes;
    let moved = (gathered + array + vector) as f64;
    assert!(near(wide.spent.feature_buffer_bytes, moved));
    assert!(near(
        wide.feature_buffer_utilisation,
        moved / (48.0 * 16.0 * wide.span_ns)
    ));
    let loaded = wide.spent.weight_bytes;
    let weights = total.weight_bytes as f64 + loaded;
    assert!(near(wide.spent.weight_buffer_bytes, weights));
    assert!(near(
        wide.weight_buffer_utilisation,
        weights / (48.0 * wide.span_ns)
    ));
    let own = costs(Program::Fields);
    let (features, weights) = (
        own.memories.features.unwrap(),
        own.memories.weights.unwrap(),
    );
    let read = total.input_bytes + total.partial_bytes + total.operand_bytes;
    let pj = read as f64 / 16.0 * features.read_pj
        + (moved - read as f64) / 16.0 * features.write_pj
        + total.weight_bytes as f64 / 48.0 * weights.read_pj
        + loaded / 48.0 * weights.write_pj;
    assert!(near(wide.energy.buffers_mj.unwrap(), pj * 1e-9));
    // One bank in all serves 16 bytes a nanosecond, to everyone.
    let one = System {
        feature_banks: 1,
        feature_block_banks: 1,
        ..System::default()
    };
    let narrow = of(&one);
    assert!(
        narrow.span_ns >= moved / 16.0 * (1.0 - 1e-9),
        "{} {}",
        narrow.span_ns,
        moved / 16.0
    );
    assert!(
        narrow.span_ns > wide.span_ns,
        "{} {}",
        narrow.span_ns,
        wide.span_ns
    );
    assert!(narrow.feature_buffer_utilisation > 0.5);
    assert_eq!(narrow.spent, wide.spent);
    // Of 48 that each hold whole blocks, no unit gets more than one at a time.
    let apart = of(&System {
        feature_block_banks: 1,
        ..System::default()
    });
    for bytes in [gathered, array, vector] {
        assert!(apart.span_ns >= bytes as f64 / 16.0);
    }
    assert!(wide.span_ns <= apart.span_ns && apart.span_ns <= narrow.span_ns);
}

fn costs_of(config: &Config, given: Option<&SynthReport>, reports: &[Synthesised]) -> Costs {
    costs_around(config, given, reports, OnChipSizes::default())
}

fn costs_around(
    config: &Config,
    given: Option<&SynthReport>,
    reports: &[Synthesised],
    sizes: OnChipSizes,
) -> Costs {
    let parameters = Parameters {
        given,
        reports,
        estimated: &[],
        records: &SynthReport::of_records().unwrap(),
        system: &Synthesised::checked_in().unwrap()[0].report,
        sizes,
        wire_margin: 0.0,
    };
    let fit = Fit::checked_in().unwrap();
    Costs::new(config, Program::Fields, fit, &parameters).unwrap()
}

/// A given gathering unit takes precedence over formulas.
#[test]
fn a_given_gathering_unit_counts_before_formulas() {
    let reports = Synthesised::checked_in().unwrap();
    let own = &reports[0].report;
    let of = |given| costs_of(&Config::paper(), given, &reports);
    let (given, fitted) = (of(Some(own)), of(None));
    let from = "gathering unit: netlists of this configuration, on lantern";
    assert!(given.origin.starts_with(from), "{}", given.origin);
    let done = some_work().total();
    let pj = |costs: &Costs| costs.of(&done, true, 576).gathering_pj.unwrap();
    // Of the netlist that the formulas were fitted beside: near them, and not the same.
    let off = pj(&given) / pj(&fitted) - 1.0;
    assert!(off != 0.0 && off.abs() < 0.8, "{off}");
    // Energy of the netlist's run: that of its cycles, at the system's node.
    let scaled = own.scaled_unit(UnitKind::Gathering).unwrap();
    let area = |costs: &Costs| costs.area_mm2.unwrap();
    let both = area(&given) - area(&fitted);
    assert!(both.abs() < 0.2 * scaled.area_um2 * 1e-6, "{both}");
}

/// Of a unit that neither a synthesis nor a formula is of, the energy is not known; the time is, and
/// so is the energy of all else.
#[test]
fn time_is_known_without_energy() {
    let reports = Synthesised::checked_in().unwrap();
    // Of two settings that were not synthesised together.
    let text = "[rit]\nentry = \"compact\"\n[gu]\nrecords_a_row = 2\n";
    let compact = Config::from_toml(text, "test").unwrap();
    let own = costs_of(&compact, None, &reports);
    let [unknown] = &own.unknown[..] else {
        unreachable!("{:?}", own.unknown)
    };
    assert_eq!(unknown.block, "gathering unit");
    assert!(unknown.why.contains("rit.entry"), "{}", unknown.why);
    assert_eq!((own.area_mm2, own.leakage_mw), (None, None));
    let work = some_work();
    let system = System::default();
    let model = Model {
        system: &system,
        memory: memory(4),
        costs: &own,
        clock_ghz: own.clock.ghz,
        weight_bytes: WEIGHTS,
        replay: None,
    };
    let run = model.frame(&work, Gathering::Unit).unwrap();
    assert!(run.max.span_ns > 0.0 && run.total_mj().is_none());
    let energy = run.max.energy;
    assert_eq!((energy.gathering_unit_mj, energy.leakage_mj), (None, None));
    let others = [energy.vector_unit_mj, energy.array_mj, energy.named()[0].1];
    assert!(others.iter().all(Option::is_some), "{energy:?}");
    // The GPU gathers: that part is 0 and known.
    let other = model.frame(&work, Gathering::PixelOrder).unwrap();
    assert_eq!(other.max.energy.gathering_unit_mj, Some(0.0));
}

/// What no unit of the array and no queue was built for has no energy either, with its reason.
#[test]
fn what_is_not_built_has_no_energy() {
    let reports = Synthesised::checked_in().unwrap();
    let of = |config: &Config, sizes| costs_around(config, None, &reports, sizes);
    let doubled = OnChipSizes {
        array_double_buffered: true,
        ..OnChipSizes::default()
    };
    let paper = Config::paper();
    let why = |own: &Costs| {
        own.unknown
            .iter()
            .map(|of| of.block.clone())
            .collect::<Vec<_>>()
    };
    let own = of(&paper, doubled);
    assert!(own.mac.is_none());
    assert_eq!(why(&own), ["MAC array"]);
    let direct = Config::from_toml("rit.path = \"direct\"", "test").unwrap();
    let own = of(&direct, OnChipSizes::default());
    assert!(own.mac.is_some() && own.leakage_mw.is_none());
    assert_eq!(why(&own), ["queue of the ray index table"]);
    let small = OnChipSizes {
        weight_buffer_bytes: 50_000,
        ..OnChipSizes::default()
    };
    let own = of(&paper, small);
    assert_eq!(why(&own), ["weight buffer"]);
    let done = Batch {
        weight_bytes: 48,
        ..Batch::default()
    };
    assert_eq!(own.of(&done, false, 576).buffers_pj, None);
}

/// Nothing but the clock depends on an assumed clock, which leaves what is reached as it is.
#[test]
fn an_assumed_clock_changes_no_price() {
    let reports = Synthesised::checked_in().unwrap();
    for text in ["", "gu.banks = 24", "vu.operands.multiply = [32, 31]"] {
        let of = |text: &str| Config::from_toml(text, "test").unwrap();
        let (plain, clocked) = (of(text), of(&format!("clock_ghz = 0.5\n{text}")));
        let found = costs_of(&plain, None, &reports).at_clock_of(&clocked);
        let expected = costs_of(&clocked, None, &reports);
        assert_eq!(format!("{found:?}"), format!("{expected:?}"), "{text}");
        assert_eq!(found.clock.ghz, 0.5);
        assert!(found.clock.reached_ghz.is_some_and(|own| own != 0.5));
    }
}

/// A unit that was synthesised with other numbers is composed of it and of formulas.
#[test]
fn a_unit_with_other_numbers_is_composed() {
    let reports = Synthesised::checked_in().unwrap();
    let pieces = "[vu.exp]\nform = \"piecewise\"\npieces = 128\npipelined = true\n";
    let of = |lanes: u32| {
        let config = Config::from_toml(&format!("[vu]\nlanes = {lanes}\n{pieces}"), "t").unwrap();
        costs_of(&config, None, &reports)
    };
    let [whole, half] = [24, 12].map(of);
    assert!(half.unknown.is_empty(), "{:?}", half.unknown);
    assert!(
        half.origin.contains("parts in which it differs"),
        "{}",
        half.origin
    );
    let done = Batch {
        vector_cycles: 1000,
        vector_busy: 900,
        ..Batch::default()
    };
    let pj = |costs: &Costs| costs.of(&done, false, 1).vector_pj.unwrap();
    let ratio = pj(&half) / pj(&whole);
    assert!((0.4..0.65).contains(&ratio), "{ratio}");
}

/// Leakage, registers of the multipliers and idle power are part of a frame's energy.
#[test]
fn what_waits_takes_energy_too() {
    let own = costs(Program::Fields);
    let (leakage_mw, mac) = (own.leakage_mw.unwrap(), own.mac.unwrap());
    assert!(leakage_mw > 0.1, "{leakage_mw}");
    // Two registers of 16 bits are a part of a multiplication that can be seen.
    let sum = mac.rest_pj + mac.work_pj;
    assert!((0.1..2.0).contains(&sum), "{mac:?}");
    let work = some_work();
    let system = System::default();
    let run = frame(&system, &work, Gathering::Unit);
    let span = run.span_ns;
    let at_rest = leakage_mw + 576.0 * mac.leakage_mw;
    let leakage_mj = run.energy.leakage_mj.unwrap();
    assert!(mac.leakage_mw > 0.0 && near(leakage_mj, at_rest * span * 1e-9));
    // A product that fills the array badly clocks units that multiply nothing.
    let done = work.total();
    let (rest, worked) = (mac.rest_pj, mac.work_pj * done.macs as f64);
    let clocked = 576.0 * done.array_cycles as f64;
    assert!(near(
        run.energy.array_mj.unwrap(),
        (rest * clocked + worked) * 1e-9
    ));
    let busy = run.utilisation[&job_scheduler::Resource::Gpu] * span;
    let gpu = &system.gpu;
    let watts = gpu.watts() * busy + gpu.idle_watts * (span - busy);
    assert!(near(run.energy.gpu_mj, watts * 1e-6));
    let least = memory(4).standby_mw(0.0) * span * 1e-9;
    let most = memory(4).standby_mw(1.0) * span * 1e-9;
    assert!(run.energy.standby_mj > least && run.energy.standby_mj <= most);
}

/// The paper's link: a raw frame of 800 x 800 takes 0.192 s and 0.192 J.
#[test]
fn a_raw_frame_takes_the_link_a_fifth_of_a_second() {
    let mut work = some_work();
    (work.pixels, work.frame_pixels) = (640_000, 640_000);
    let path = path(&work, &work);
    let system = System::default();
    let model = Model {
        system: &system,
        memory: memory(4),
        costs: costs(Program::Fields),
        clock_ghz: 1.0,
        weight_bytes: WEIGHTS,
        replay: None,
    };
    let found = model
        .run(&path, Variant::ALL[0], Scenario::Remote)
        .unwrap()
        .0;
    let found = found.run.max;
    assert!((found.stages["link"].own_ns - 0.192e9).abs() < 1.0);
    assert!((found.energy.link_mj - 192.0).abs() < 1e-9);
    assert!(found.frames_per_second < 1.0 / 0.192);
    // A reference has depths of two bytes beside its colours of three.
    let warped = Variant::named("sparw").unwrap();
    let references = model.run(&path, warped, Scenario::Remote).unwrap().0;
    let references = references.run.max;
    let number = path.references.len() as f64 / path.targets.len() as f64;
    assert!(near(references.stages["link"].own_ns, number * 0.32e9));
}

/// The channel that a stage waited for is named: memory by default, the feature buffer's port with
/// one bank.
#[test]
fn what_is_waited_for_is_named() {
    let mut work = some_work();
    let batch = &mut work.batches[0];
    (batch.row_bytes, batch.mvoxels) = (1_000_000, 100);
    (batch.input_bytes, batch.partial_bytes, batch.array_cycles) = (100_000, 1_000_000, 1000);
    let of = |system: &System, stage| frame(system, &work, Gathering::Unit).stages[stage];
    let gathering = of(&System::default(), "gathering");
    assert!(gathering.memory_ns > 0.0);
    assert_eq!(gathering.last_through.most(), "memory");
    let slow = System {
        feature_banks: 1,
        feature_block_banks: 1,
        ..System::default()
    };
    let computation = of(&slow, "computation");
    assert_eq!(computation.last_through.most(), "feature buffer");
    let parts = computation.last_through;
    let sum =
        parts.memory_ns + parts.interconnect_ns + parts.feature_buffer_ns + parts.weight_buffer_ns;
    assert!(near(sum, computation.memory_ns) && sum > 0.0);
}

#[test]
fn systems_that_cannot_be_are_refused_by_field() {
    for (text, field) in [
        ("memory_channels = 3", "memory_channels"),
        ("interconnect_over_memory = 0.0", "interconnect_over_memory"),
        (
            "interconnect_pj_per_byte = -1.0",
            "interconnect_pj_per_byte",
        ),
        ("dma_descriptor_bytes = nan", "dma_descriptor_bytes"),
        ("array_rows = 0", "array_rows"),
        ("groups_in_flight = 0", "groups_in_flight"),
        ("feature_buffer_bytes = 100", "feature_buffer_bytes"),
        ("feature_banks = 0", "feature_banks"),
        ("feature_block_banks = 0", "feature_block_banks"),
        ("feature_block_banks = 36", "feature_block_banks"),
        ("feature_block_bytes = 100", "feature_block_bytes"),
        ("[remote]\nmemory_gb_s = 616.0", "remote.memory_gb_s"),
        ("link_bytes_per_second = 0.0", "link_bytes_per_second"),
        ("link_nj_per_byte = -1.0", "link_nj_per_byte"),
        ("bandwidth = 1", "bandwidth"),
        ("dma_descriptor_bytes = 1e300", "dma_descriptor_bytes"),
        ("[gpu]\nfields_efficiency = 5.0", "gpu.fields_efficiency"),
        ("[gpu]\ncores = 0.0", "gpu.cores"),
        ("[gpu]\nshaders = 1", "shaders"),
        ("array_rows = \"many\"", "array_rows"),
        ("[gpu]\nidle_watts = 60", "gpu.idle_watts"),
    ] {
        let error = System::from_toml(text, "test.toml")
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("test.toml") && error.contains(field),
            "{error}"
        );
    }
    let made = System::from_toml("memory_channels = 2", "test.toml").unwrap();
    assert_eq!(
        made,
        System {
            memory_channels: 2,
            ..System::default()
        }
    );
    let made = System::from_toml("[remote]\nidle_watts = 7.0", "test.toml").unwrap();
    let mut remote = Gpu::rtx_2080_ti();
    remote.idle_watts = 7.0;
    assert_eq!(
        made,
        System {
            remote,
            ..System::default()
        }
    );
    let text = toml::to_string(&System::default()).unwrap();
    assert_eq!(
        System::from_toml(&text, "test.toml").unwrap(),
        System::default()
    );
}
