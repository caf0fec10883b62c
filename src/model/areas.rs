//! Areas of the accelerator's blocks.

use potamoi_system::system_model::Area;

use crate::stdout::prose;
use crate::tables;

/// The blocks with their cells and memories, and the sums.
pub(super) fn table(area: &Area) -> comfy_table::Table {
    let mut table = tables::plain([
        "the accelerator's area",
        "blocks",
        "logic, mm^2 at 12 nm",
        "memories, mm^2",
        "together, mm^2",
        "origin",
    ]);
    let figure = |mm2: Option<f64>| mm2.map_or_else(|| "-".to_owned(), |mm2| format!("{mm2:.4}"));
    for own in &area.blocks {
        table.add_row([
            own.block.clone(),
            own.count.to_string(),
            figure(own.logic_mm2),
            figure(own.memories_mm2),
            figure(own.mm2()),
            own.from.clone(),
        ]);
    }
    let sums = [
        ("the units", area.units_mm2),
        ("all, before wires", area.total_mm2),
    ];
    for (name, sum) in sums {
        let none = String::new;
        table.add_row([name.to_owned(), none(), none(), none(), figure(sum), none()]);
    }
    table
}

/// Says each memory of the blocks: number, words and bits of one, and the area of all.
pub(super) fn say_memories(area: &Area) {
    for block in area.blocks.iter().filter(|own| !own.memories.is_empty()) {
        let each = block.memories.iter().map(|own| {
            format!(
                "{} {} of {} x {} bits, {:.4} mm^2",
                own.count, own.memory, own.words, own.bits, own.mm2
            )
        });
        let all: Vec<String> = each.collect();
        prose!(2, "memories of {}: {}", block.block, all.join("; "));
    }
}
