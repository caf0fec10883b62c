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

/// A bar: name, figure, and index of its colour.
type Bar = (String, Option<AtBounds<f64>>, usize);

/// A group of bars: the scene, and its machines.
type Group = (String, Vec<Bar>);

/// Index of the colour of GPUs without an accelerator: a grey.
const ALONE: usize = 8;

/// Draws bars from 0 to the lower bound, and lighter ones on to the higher.
pub(super) fn plot(path: &Path, found: &Comparison) -> Result<(), Failure> {
    let panels = [
        (
            "frames a second",
            groups(found, |own| Some(own.frames_per_second), true),
        ),
        ("millijoules a frame", groups(found, |own| own.mj, false)),
    ];
    let of_group = |(_, bars): &Group| GROUP + BAR * bars.len() as i32;
    let height = |groups: &[Group]| GROUP + groups.iter().map(of_group).sum::<i32>();
    let all: i32 = panels.iter().map(|(_, groups)| height(groups)).sum();
    charts::picture(path, (WIDTH as u32, (all + BAR + 20) as u32), |area| {
        let mut top = 10;
        for (title, groups) in &panels {
            draw(area, title, groups, top)?;
            top += height(groups);
        }
        let note = "full colour up to where no demands of a GPU kernel overlap, or all do; lighter up to the other";
        let letters = LETTERS.into_text_style(area);
        area.draw(&Text::new(note, (10, top), letters))?;
        Ok(())
    })
}

fn groups(
    found: &Comparison,
    of: impl Fn(&Figures) -> Option<AtBounds<f64>>,
    has_gpus: bool,
) -> Vec<Group> {
    let group = |rows: &Vec<Row>| {
        let figures: Vec<&Figures> = rows.iter().filter_map(Row::figures).collect();
        let first = figures.first()?;
        let [width, height] = first.size;
        let name = format!("{} ({}), {width} x {height}", first.scene, first.algorithm);
        let mut bars: Vec<Bar> = (figures.iter().enumerate())
            .map(|(at, own)| {
                let machine = super::table::shortened(&own.machine);
                let name = format!("{machine} at {:.2} GHz", own.clock_ghz);
                (name, of(own), at % ALONE)
            })
            .collect();
        for own in figures.iter().filter(|_| has_gpus) {
            let name = format!("{} alone", own.gpu);
            if bars.iter().all(|(known, ..)| *known != name) {
                bars.push((name, Some(own.gpu_alone_frames_per_second), ALONE));
            }
        }
        Some((name, bars))
    };
    found.scenes.iter().filter_map(group).collect()
}

fn draw(area: &charts::Area<'_>, title: &str, groups: &[Group], top: i32) -> charts::Drawn {
    let all = groups.iter().flat_map(|(_, bars)| bars);
    let most = all.filter_map(|(_, of, _)| of.as_ref().map(|own| own.high()));
    let most = most.fold(f64::MIN_POSITIVE, f64::max);
    let length = |value: f64| (f64::from(WIDTH - NAMES - FIGURES - 20) * value / most) as i32;
    let letters = LETTERS.into_text_style(area);
    area.draw(&Text::new(
        title.to_owned(),
        (10, top),
        TITLE.into_text_style(area),
    ))?;
    let mut y = top + GROUP;
    for (scene, bars) in groups {
        area.draw(&Text::new(scene.clone(), (10, y), letters.clone()))?;
        y += GROUP / 2;
        for (name, of, colour) in bars {
            area.draw(&Text::new(name.clone(), (20, y + 6), letters.clone()))?;
            let colour = COLOURS[*colour];
            let bar = |from: i32, to: i32| [(NAMES + from, y + 3), (NAMES + to, y + BAR - 3)];
            let (text, end) = match of {
                None => ("not known".to_owned(), 0),
                Some(range) => {
                    let [low, high] = [range.low(), range.high()].map(length);
                    area.draw(&Rectangle::new(bar(0, low), colour.filled()))?;
                    area.draw(&Rectangle::new(bar(low, high), colour.mix(0.4).filled()))?;
                    area.draw(&Rectangle::new(bar(0, high), colour.stroke_width(1)))?;
                    (crate::bounds::tight(range), high)
                }
            };
            area.draw(&Text::new(text, (NAMES + end + 8, y + 6), letters.clone()))?;
            y += BAR;
        }
        y += GROUP / 2;
    }
    Ok(())
}
