//! What `potamoi synth` prints.

use potamoi_synth::{SynthReport, SynthesisedUnit, published_cells};

use crate::stdout::say;
use crate::tables;

/// A unit: area by module, longest path, memories.
pub(super) fn unit(made: &SynthesisedUnit) {
    let report = &made.report;
    say!(
        "\n{}{}: {} cells, {} of them flip-flops, {:.6} mm^2; period {:.0} ps before wires \
         ({:.3} GHz)",
        report.unit,
        if made.is_cached { " (cached)" } else { "" },
        report.cells,
        report.flops,
        report.area_um2 * 1e-6,
        report.period_ps,
        report.clock_ghz
    );
    say!(
        "longest path: {} to {}, {} cells",
        report.path[0],
        report.path[1],
        report.path_cells
    );
    let mut table = tables::plain([
        "module",
        "count",
        "cells each",
        "flip-flops",
        "um^2 each",
        "share of area",
    ]);
    for module in &report.modules {
        let share = module.count as f64 * module.area_um2 / report.area_um2;
        table.add_row([
            module.module.clone(),
            module.count.to_string(),
            module.cells.to_string(),
            module.flops.to_string(),
            format!("{:.1}", module.area_um2),
            format!("{:.1} %", 100.0 * share),
        ]);
    }
    say!("{}", tables::fitted(&table, &[]));
    for memory in &report.memories {
        say!(
            "memory {}: {} of {} x {} bit, {} ports, not in the areas above",
            memory.module,
            memory.count,
            memory.words,
            memory.bits,
            ports(
                [memory.read_writes, memory.writes, memory.reads],
                ["read-write", "write", "read"],
                " and "
            )
        );
    }
    for memory in &report.flop_memories {
        say!(
            "memory {}: {} of {} x {} bit, flip-flops in the areas above: {}",
            memory.memory,
            memory.count,
            memory.words,
            memory.bits,
            memory.why
        );
    }
    if let Some(power) = &report.power {
        super::power::print(power);
    }
}

/// The kinds of ports that a memory has, each with its number.
fn ports(counts: [u64; 3], kinds: [&str; 3], between: &str) -> String {
    let all = counts
        .into_iter()
        .zip(kinds)
        .filter(|(count, _)| *count > 0);
    let all: Vec<String> = all.map(|(count, kind)| format!("{count} {kind}")).collect();
    all.join(between)
}

/// Memories, and everything at the other node.
pub(super) fn totals(report: &SynthReport) {
    if let Some(memories) = &report.raw.memories {
        let origin = &memories.origin;
        say!(
            "\nmemories by {}, {} nm, {}, {} K:",
            origin.cacti,
            origin.node_nm,
            origin.transistors,
            origin.kelvin
        );
        let mut table = tables::plain([
            "memory",
            "count",
            "words x bits",
            "ports",
            "um^2 each",
            "mm^2",
            "pJ read",
            "pJ write",
            "mW leakage",
            "ps access",
            "ps cycle",
        ]);
        for own in &memories.macros {
            let (shape, figures) = (&own.shape, &own.figures);
            let all = [shape.read_writes, shape.writes, shape.reads];
            table.add_row([
                own.memory.clone(),
                own.count.to_string(),
                format!("{} x {}", shape.words, shape.bits),
                ports(all, ["RW", "W", "R"], " "),
                format!("{:.0}", figures.area_um2),
                format!("{:.5}", own.count as f64 * figures.area_um2 * 1e-6),
                format!("{:.3}", figures.read_pj),
                format!("{:.3}", figures.write_pj),
                format!("{:.4}", own.count as f64 * figures.leakage_mw),
                format!("{:.0}", figures.access_ps),
                format!("{:.0}", figures.cycle_ps),
            ]);
        }
        say!("{}", tables::fitted(&table, &[]));
    }
    for unit in &report.raw.units {
        if let Some(own) = &unit.with_memories {
            say!(
                "{} with its memories' access times: {:.0} ps ({:.3} GHz), {} to {}, {} cells",
                unit.unit,
                own.period_ps,
                own.clock_ghz,
                own.path[0],
                own.path[1],
                own.path_cells
            );
        }
    }
    let Some(scaled) = &report.scaled else { return };
    if let Some(logic) = &scaled.logic {
        say!("\nat {} nm, by {}:", scaled.node_nm, logic.factors.table);
        for unit in &logic.units {
            let energy = unit.energy.map_or_else(String::new, |e| {
                format!(
                    "; {:.1} pJ per active cycle without delays, {:.1} with glitches",
                    e.zero_delay_pj_a_cycle, e.with_glitches_pj_a_cycle
                )
            });
            let memories = unit.with_memories_ps.map_or_else(String::new, |ps| {
                format!(
                    ", {ps:.0} ps ({:.3} GHz) with its memories' access times",
                    1e3 / ps
                )
            });
            say!(
                "{}: {:.6} mm^2, {:.0} ps ({:.3} GHz) before wires{memories}{energy}",
                unit.unit,
                unit.area_um2 * 1e-6,
                unit.period_ps,
                unit.clock_ghz
            );
        }
    }
    if let (Some(own), Some(raw)) = (&scaled.memories, &report.raw.memories) {
        say!("\nat {} nm, by {}:", scaled.node_nm, own.factors.table);
        for (own, raw) in own.macros.iter().zip(&raw.macros) {
            let figures = &own.figures;
            say!(
                "{}: {} of {:.0} um^2, {:.5} mm^2 ({:.5} by a published cell); {:.3} pJ read, {:.3} \
                 pJ write; {:.0} ps cycle",
                own.memory,
                raw.count,
                figures.area_um2,
                raw.count as f64 * figures.area_um2 * 1e-6,
                raw.count as f64 * published_cells::area_um2(&raw.shape) * 1e-6,
                figures.read_pj,
                figures.write_pj,
                figures.cycle_ps
            );
        }
        say!(
            "published cell: {:.3} um^2 at 16 nm with one port (Chen et al., ISSCC 2014), {:.0} % of a \
             macro (assumed), larger by its ports; CACTI's areas at {} nm are below the bare cell",
            published_cells::CELL_UM2,
            100.0 * published_cells::EFFICIENCY,
            scaled.node_nm
        );
    }
}
