//! Plot of effects: those called for, and the simulator time of each.

use std::path::Path;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use potamoi_explore::effects::{Effects, FoundEffect};

use super::report::cost_words;
use crate::charts::{COLOURS, LETTERS, TITLE, picture};
use crate::failure::Failure;

/// Width in pixels, and height of a row.
const WIDTH: u32 = 1240;
const ROW: u32 = 34;
/// Width in pixels of the effects' names, and of their cost texts.
const NAMES: u32 = 190;
const WORDS: u32 = 430;
/// Margin in pixels above and below the rows.
const FRAME: u32 = 130;
/// Half of a bar's height, as a share of its row.
const HALF: f64 = 0.3;

/// One row an effect: wall time with it, its part of that time, and the spread of the pairs; beside
/// it, its hardware cost.
pub(super) fn plot(path: &Path, report: &Effects) -> Result<(), Failure> {
    let rows = report.effects.len();
    let size = (WIDTH, FRAME + ROW * rows as u32);
    let longest = report.effects.iter().filter_map(FoundEffect::timed);
    let longest = longest
        .map(|wall| wall.with_ms + wall.spread_ms.unwrap_or(0.0))
        .fold(1e-3, f64::max);
    let title = format!(
        "{}, {} x {}, {} frames: what is called for, and what it takes",
        report.scene, report.width, report.height, report.frames
    );
    picture(path, size, |area| {
        let area = area.titled(&title, TITLE)?;
        let (names, area) = area.split_horizontally(NAMES);
        let (area, words) = area.split_horizontally(WIDTH - NAMES - WORDS);
        let mut chart = ChartBuilder::on(&area)
            .margin(12)
            .x_label_area_size(44)
            .build_cartesian_2d(0.0..longest * 1.08, 0.0..rows as f64)?;
        chart
            .configure_mesh()
            .disable_y_mesh()
            .disable_y_axis()
            .x_desc("ms of the simulator: light what was timed with the effect, dark its own, black the spread")
            .x_label_formatter(&|v| format!("{v:.1}"))
            .label_style(LETTERS)
            .max_light_lines(1)
            .draw()?;
        let bar = |y: f64, from: f64, to: f64, style: ShapeStyle| {
            Rectangle::new([(from, y - HALF), (to, y + HALF)], style)
        };
        for (i, found) in report.effects.iter().enumerate() {
            let colour = match found.called_for {
                true => COLOURS[1],
                false => COLOURS[7],
            };
            let y = (rows - i) as f64 - 0.5;
            if let Some(wall) = found.timed() {
                let own = wall.difference_ms.clamp(0.0, wall.with_ms);
                let rest = bar(y, 0.0, wall.with_ms - own, colour.mix(0.25).filled());
                let own = bar(y, wall.with_ms - own, wall.with_ms, colour.filled());
                chart.draw_series([rest, own])?;
                if let Some(spread) = wall.spread_ms {
                    let ends = [(wall.with_ms - spread, y), (wall.with_ms + spread, y)];
                    chart.draw_series([PathElement::new(ends, BLACK.stroke_width(2))])?;
                }
            }
            let (_, across) = chart.backend_coord(&(0.0, y));
            let (_, top) = names.get_base_pixel();
            let line = across - top;
            let letters = LETTERS.into_font().color(&colour);
            let right = letters.pos(Pos::new(HPos::Right, VPos::Center));
            let left = letters.pos(Pos::new(HPos::Left, VPos::Center));
            names.draw(&Text::new(found.title(), (NAMES as i32 - 6, line), right))?;
            words.draw(&Text::new(cost_words(found), (0, line), left))?;
        }
        Ok(())
    })
}
