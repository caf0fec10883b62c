//! Organisations of the gathering unit and forms of the exponential, synthesised and compared.

use std::fmt::Write as _;

use potamoi_formats::config::Config;
use potamoi_synth::published_cells::area_um2;
use potamoi_synth::study::{
    EXPONENTIALS, GATHERING, Table, Variant, array_um2, crossbar_um2, once, tables,
};
use potamoi_synth::{
    Cacti, Figures, Memories, Raw, STEPS, SYSTEM, Scaled, Shape, SynthError, UnitKind, UnitReport,
    model,
};

use super::{Flow, in_parallel};
use crate::{ExploreError, Progress};

/// What models a memory that no unit has, by its name and shape.
type Model<'a> = &'a dyn Fn(&str, &Shape) -> Result<Figures, SynthError>;

/// A variant, synthesised.
struct Row {
    variant: Variant,
    config: Config,
    unit: UnitReport,
    /// Its memories, and all at the other node.
    memories: Memories,
    scaled: Scaled,
}

impl Row {
    /// Square micrometres of a unit's memories at the other node, by module.
    fn memory_um2(&self, module: &str) -> f64 {
        self.of_um2(&self.unit.unit, module)
    }

    /// Likewise of the system's.
    fn system_um2(&self, name: &str) -> f64 {
        self.of_um2(SYSTEM, name)
    }

    /// Square micrometres of memories of that name by a published cell.
    fn published_um2(&self, name: &str) -> f64 {
        let own = self.memories.macros.iter().filter(|own| own.memory == name);
        own.map(|own| own.count as f64 * area_um2(&own.shape)).sum()
    }

    fn of_um2(&self, of: &str, name: &str) -> f64 {
        let scaled = self.scaled.memories.iter().flat_map(|m| &m.macros);
        let both = self.memories.macros.iter().zip(scaled);
        let own = both.filter(|(raw, _)| raw.of == of && raw.memory == name);
        own.map(|(raw, scaled)| raw.count as f64 * scaled.figures.area_um2)
            .sum()
    }

    /// Square millimetres of other memories at that node.
    fn table_mm2(&self, table: &Table, model: Model<'_>) -> Result<f64, ExploreError> {
        let mut figures = model(table.name, &table.shape)?;
        if let Some(memories) = &self.scaled.memories {
            figures = figures.scaled(&memories.factors);
        }
        Ok(table.count as f64 * figures.area_um2 * 1e-6)
    }

    fn logic_factor(&self) -> f64 {
        self.scaled.logic.as_ref().map_or(1.0, |l| l.factors.area)
    }
}

/// Synthesises the variants of [`GATHERING`] and [`EXPONENTIALS`], `jobs` at once, and compares them
/// in Markdown tables: at the library's node, and scaled from `node` nanometres, if it is known, to
/// `scale_to`.
///
/// # Errors
/// A variant cannot be synthesised, or CACTI is missing or fails.
pub fn compare_variants(
    flow: &Flow<'_>,
    jobs: usize,
    (node, scale_to): (Option<u32>, u32),
    progress: &dyn Progress,
) -> Result<String, ExploreError> {
    let cacti = Cacti::find(flow.cache)?;
    let variants: Vec<Variant> = GATHERING.into_iter().chain(EXPONENTIALS).collect();
    let rows = in_parallel(&variants, jobs, STEPS, progress, |variant, step| {
        let config = variant.config()?;
        let unit = flow.synthesise(&config, variant.unit, step)?.report;
        let memories = model(std::slice::from_ref(&unit), &cacti)?;
        let raw = Raw {
            units: vec![unit.clone()],
            memories: Some(memories.clone()),
        };
        Ok::<_, ExploreError>(Row {
            variant: *variant,
            config,
            unit,
            memories,
            scaled: Scaled::new(&raw, node, scale_to),
        })
    })?;
    let at = match node {
        Some(node) => format!("{node} nm; in brackets at {scale_to} nm"),
        None => "the library's node".to_owned(),
    };
    let origin = format!(
        "{}, {at}. {}; OpenSTA {}; memories at {scale_to} nm by {}.",
        flow.library.name,
        flow.tools.yosys,
        flow.tools.opensta,
        cacti.settings().cacti
    );
    let mac = flow.synthesise(&Config::paper(), UnitKind::ArrayMac, &|| ())?;
    text(&origin, &rows, &mac.report, &|name, shape| {
        cacti.model(name, shape)
    })
}

/// The report, of gathering units and then exponentials.
fn text(
    origin: &str,
    rows: &[Row],
    mac: &UnitReport,
    model: Model<'_>,
) -> Result<String, ExploreError> {
    let (gathering, exponentials) = rows.split_at(GATHERING.len().min(rows.len()));
    let mut text = format!("{origin}\n\n");
    text += &units(gathering);
    if let Some(first) = gathering.first() {
        text += &modules(&first.unit);
        text += &beside(first, mac, model)?;
    }
    text += &joined(gathering, model)?;
    text += &ways(exponentials);
    Ok(text)
}

/// Gathering units: logic beside memories, and the clock.
fn units(rows: &[Row]) -> String {
    let mut text =
        "| gathering unit | logic, mm^2 | flip-flops | period before wires, ps | MFT, mm^2 | RIT, \
                    mm^2 |\n|---|---|---|---|---|---|\n"
            .to_owned();
    for row in rows {
        let unit = &row.unit;
        let scaled = row.scaled.logic.as_ref().and_then(|l| l.units.first());
        let brackets =
            |value: Option<String>| value.map_or_else(String::new, |v| format!(" ({v})"));
        let area = brackets(scaled.map(|u| format!("{:.4}", u.area_um2 * 1e-6)));
        let period = brackets(scaled.map(|u| format!("{:.0}", u.period_ps)));
        let _ = writeln!(
            text,
            "| {} | {:.4}{area} | {} | {:.0}{period} | {:.4} | {:.4} |",
            row.variant.name,
            unit.area_um2 * 1e-6,
            unit.flops,
            unit.period_ps,
            row.memory_um2("mft_bank") * 1e-6,
            row.memory_um2("rit_bank") * 1e-6,
        );
    }
    text + "\n"
}

/// The modules of a unit.
fn modules(unit: &UnitReport) -> String {
    let mut text =
        "| module of the paper's unit | count | cells each | flip-flops | um^2 each | share of \
         logic |\n|---|---|---|---|---|---|\n"
            .to_owned();
    for module in &unit.modules {
        let share = 100.0 * module.count as f64 * module.area_um2 / unit.area_um2;
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} | {:.1} | {share:.1} % |",
            module.module, module.count, module.cells, module.flops, module.area_um2
        );
    }
    text + "\n"
}

/// Logic beside memories, as generated and as the paper may have counted, and both beside
/// an NPU.
fn beside(own: &Row, mac: &UnitReport, model: Model<'_>) -> Result<String, ExploreError> {
    let fifo = own.unit.modules.iter().find(|m| m.module == "feature_fifo");
    let fifo = fifo.map_or(0.0, |m| m.count as f64 * m.area_um2);
    let [logic, without] =
        [own.unit.area_um2, own.unit.area_um2 - fifo].map(|area| area * own.logic_factor() * 1e-6);
    let rit = own.memory_um2("rit_bank") * 1e-6;
    let all = tables(&own.config);
    // By CACTI, and by a published cell.
    let published = |parts: &[Table]| {
        let areas = parts.iter().map(|t| t.count as f64 * area_um2(&t.shape));
        areas.sum::<f64>() * 1e-6
    };
    let rit_cells = own.published_um2("rit_bank") * 1e-6;
    let mut memories = vec![
        (
            "as generated",
            own.memory_um2("mft_bank") * 1e-6 + rit,
            own.published_um2("mft_bank") * 1e-6 + rit_cells,
        ),
        (
            "MFT halves in one bank",
            own.table_mm2(&all[0], model)? + rit,
            published(&all[..1]) + rit_cells,
        ),
    ];
    for (name, parts) in once(&own.config) {
        let areas = parts.iter().map(|table| own.table_mm2(table, model));
        let area = areas.sum::<Result<f64, ExploreError>>()?;
        memories.push((name, area, published(&parts)));
    }
    let names = ["global_feature_buffer", "weight_buffer"];
    let system = names.map(|name| own.system_um2(name));
    let array = array_um2(mac) * own.logic_factor();
    let npu = (array + system[0] + system[1]) * 1e-6;
    let of_cells = names.map(|name| own.published_um2(name));
    let npu_cells = (array + of_cells[0] + of_cells[1]) * 1e-6;
    let mut text =
        "| the paper's unit, mm^2 | memories by CACTI | by a published cell | logic | sum by CACTI \
         | by a published cell | share of the NPU by CACTI | by a published cell | sum without the \
         feature FIFO by CACTI | by a published cell |\n|---|---|---|---|---|---|---|---|---|---|\n"
            .to_owned();
    for (name, area, cells) in memories {
        let _ = writeln!(
            text,
            "| {name} | {area:.4} | {cells:.4} | {logic:.4} | {:.4} | {:.4} | {:.1} % | {:.1} % | \
             {:.4} | {:.4} |",
            area + logic,
            cells + logic,
            100.0 * (area + logic) / npu,
            100.0 * (cells + logic) / npu_cells,
            area + without,
            cells + without
        );
    }
    let _ = writeln!(
        text,
        "\nThe NPU: {npu:.3} mm^2 ({npu_cells:.3} by a published cell), of which the array {:.3}, the \
         global feature buffer {:.3} ({:.3}), the weight buffer {:.3} ({:.3}).\n",
        array * 1e-6,
        system[0] * 1e-6,
        of_cells[0] * 1e-6,
        system[1] * 1e-6,
        of_cells[1] * 1e-6
    );
    Ok(text)
}

/// Tables of features with fewer and fewer ports, and what joins banks and lanes.
fn joined(rows: &[Row], model: Model<'_>) -> Result<String, ExploreError> {
    let mut text =
        "| table of features | memories | mm^2 | crossbar and arbitration, mm^2 | sum |\n\
                    |---|---|---|---|---|\n"
            .to_owned();
    if let Some(first) = rows.first() {
        for table in tables(&first.config) {
            let area = first.table_mm2(&table, model)?;
            let _ = writeln!(
                text,
                "| channel-major, {} | {} of {} x {} bit | {area:.4} | 0 | {area:.4} |",
                table.name, table.count, table.shape.words, table.shape.bits
            );
        }
    }
    for row in rows {
        let crossbar = crossbar_um2(&row.unit) * row.logic_factor() * 1e-6;
        let Some(bank) = row.unit.memories.iter().find(|m| m.module == "mft_bank") else {
            continue;
        };
        if crossbar > 0.0 {
            let area = row.memory_um2("mft_bank") * 1e-6;
            let _ = writeln!(
                text,
                "| {} | {} of {} x {} bit | {area:.4} | {crossbar:.4} | {:.4} |",
                row.variant.name,
                bank.count,
                bank.words,
                bank.bits,
                area + crossbar
            );
        }
    }
    Ok(text + "\n")
}

/// Exponentials by area and time.
fn ways(rows: &[Row]) -> String {
    let mut text = "| exponential | lane, um^2 | shared by the lanes, um^2 | period, ps | clocks per result | lane with its part of the shared logic, um^2 x ns per result | relative to the first |\n\
                    |---|---|---|---|---|---|---|\n"
        .to_owned();
    let mut first = None;
    for row in rows {
        let exp = &row.config.vu.exp;
        let clocks = if exp.pipelined { 1 } else { exp.interval() };
        let of = |name: &str| row.unit.modules.iter().find(|m| m.module == name);
        let lane = of("vector_lane").map_or(0.0, |m| m.area_um2);
        let shared = of("exp_constants").map_or(0.0, |m| m.area_um2);
        let lanes = f64::from(row.config.vu.lanes);
        let product = (lane + shared / lanes) * f64::from(clocks) * row.unit.period_ps * 1e-3;
        let first = *first.get_or_insert(product);
        let _ = writeln!(
            text,
            "| {} | {lane:.1} | {shared:.1} | {:.0} | {clocks} | {product:.0} | {:.2} |",
            row.variant.name,
            row.unit.period_ps,
            product / first
        );
    }
    text + "\n"
}

#[cfg(test)]
mod tests;
