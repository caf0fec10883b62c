//! The comparison as a picture: a group of bars a scene.

use std::path::Path;

use plotters::prelude::*;
use potamoi_machines::{Comparison, Figures, Row};
use potamoi_system::system_model::AtBounds;

use crate::charts::{self, COLOURS, LETTERS, TITLE};
use crate::failure::Failure;

/// Height of a bar and of a group's title, and widths of names and of figures, in pixels.
const BAR: i32 = 26;
const GROUP: i32 = 40;
const NAMES: i32 = 220;
const WIDTH: i32 = 980;
const FIGURES: i32 = 110;

/// A panel: title, and the figure that it shows.
type Panel = (&'static str, fn(&Figures) -> Option<AtBounds<f64>>);

const PANELS: [Panel; 2] = [
    ("frames a second", |own| Some(own.frames_per_second)),
    ("millijoules a frame", |own| own.mj),
];

/// Draws bars from 0 to the lower bound, and lighter ones on to the higher.
pub(super) fn plot(path: &Path, found: &Comparison) -> Result<(), Failure> {
    let rows: Vec<Vec<&Figures>> = (found.scenes.iter())
        .map(|rows| rows.iter().filter_map(Row::figures).collect())
        .collect();
    let of_group = |rows: &Vec<&Figures>| GROUP + BAR * rows.len() as i32;
    let panel: i32 = GROUP + rows.iter().map(of_group).sum::<i32>();
    let height = panel * PANELS.len() as i32 + 20;
    charts::picture(path, (WIDTH as u32, height as u32), |area| {
        for (at, own) in PANELS.iter().enumerate() {
            draw(area, own, &rows, 10 + panel * at as i32)?;
        }
        Ok(())
    })
}

fn draw(
    area: &charts::Area<'_>,
    (title, of): &Panel,
    scenes: &[Vec<&Figures>],
    top: i32,
) -> charts::Drawn {
    let most = scenes.iter().flatten().filter_map(|own| of(own));
    let most = most.map(|own| own.high()).fold(0.0, f64::max);
    let length = |value: f64| {
        let whole = f64::from(WIDTH - NAMES - FIGURES - 20);
        (whole * value / most.max(f64::MIN_POSITIVE)) as i32
    };
    let letters = LETTERS.into_text_style(area);
    area.draw(&Text::new(*title, (10, top), TITLE.into_text_style(area)))?;
    let mut y = top + GROUP;
    for rows in scenes {
        if let Some(first) = rows.first() {
            let [width, height] = first.size;
            let name = format!("{} ({}), {width} x {height}", first.scene, first.algorithm);
            area.draw(&Text::new(name, (10, y), letters.clone()))?;
        }
        y += GROUP / 2;
        for (at, own) in rows.iter().enumerate() {
            let name = format!("{} at {:.2} GHz", own.machine, own.clock_ghz);
            area.draw(&Text::new(name, (20, y + 6), letters.clone()))?;
            let colour = COLOURS[at % COLOURS.len()];
            let bar = |from: i32, to: i32| [(NAMES + from, y + 3), (NAMES + to, y + BAR - 3)];
            let text = match of(own) {
                None => "not known".to_owned(),
                Some(range) => {
                    let [low, high] = [range.low(), range.high()].map(length);
                    area.draw(&Rectangle::new(bar(0, low), colour.filled()))?;
                    area.draw(&Rectangle::new(bar(low, high), colour.mix(0.4).filled()))?;
                    area.draw(&Rectangle::new(bar(0, high), colour.stroke_width(1)))?;
                    crate::bounds::tight(&range)
                }
            };
            let end = of(own).map_or(0, |range| length(range.high()));
            area.draw(&Text::new(text, (NAMES + end + 8, y + 6), letters.clone()))?;
            y += BAR;
        }
        y += GROUP / 2;
    }
    Ok(())
}
