//! Labels beside points, moved where they would lie on one another.

use serde_json::{Value, json};

/// Width of a letter, height of a line and distance from a point, in pixels.
const LETTER: f64 = 6.6;
const LINE: f64 = 14.0;
const ASIDE: f64 = 9.0;
/// How far to the right of the plot a label may reach, in pixels.
const BEYOND: f64 = 190.0;
/// Lines by which a label is moved at most.
const MOVES: i32 = 14;

/// Labels with their places, in pixels from the upper left corner of the plot.
pub(crate) struct Labels(Vec<Placed>);

struct Placed {
    text: String,
    point: [f64; 2],
    /// Left end and middle of the line.
    at: [f64; 2],
}

impl Placed {
    fn width(text: &str) -> f64 {
        LETTER * text.chars().count() as f64
    }

    /// Whether it is farther from its point than beside it.
    fn is_moved(&self) -> bool {
        let right = self.at[0] - self.point[0];
        let left = -right - Self::width(&self.text);
        self.at[1] != self.point[1] || right.max(left) > 1.5 * ASIDE
    }

    fn overlaps(&self, at: [f64; 2], width: f64) -> bool {
        let own = Self::width(&self.text);
        at[0] < self.at[0] + own && self.at[0] < at[0] + width && (at[1] - self.at[1]).abs() < LINE
    }
}

impl Labels {
    /// Places labels: right of their points, else left, else some lines above or below, on none of `marks`. What
    /// finds no place is left out; a page shows it where the pointer is.
    pub(crate) fn beside(
        points: Vec<([f64; 2], String)>,
        marks: &[[f64; 2]],
        size: [f64; 2],
    ) -> Self {
        let sides = |width: f64| vec![ASIDE, -ASIDE - width, 4.0 * ASIDE];
        Self::placed(points, marks, [size[0] + BEYOND, size[1]], sides)
    }

    /// Places labels of levels, whose points are at the right edge: right of it, else some lines above or
    /// below. None lies over the plot.
    pub(crate) fn right_of(points: Vec<([f64; 2], String)>, size: [f64; 2]) -> Self {
        let room = [f64::INFINITY, size[1]];
        Self::placed(points, &[], room, |_| vec![ASIDE, 2.0 * ASIDE])
    }

    /// Places labels at the first free of these distances to the right of their points, within a room.
    fn placed(
        mut points: Vec<([f64; 2], String)>,
        marks: &[[f64; 2]],
        room: [f64; 2],
        asides: impl Fn(f64) -> Vec<f64>,
    ) -> Self {
        points.retain(|(_, text)| !text.is_empty());
        points.sort_by(|a, b| a.0[1].total_cmp(&b.0[1]).then(a.0[0].total_cmp(&b.0[0])));
        let mut placed: Vec<Placed> = vec![];
        for (point, text) in points {
            let width = Placed::width(&text);
            let is_free = |at: &[f64; 2]| {
                let inside = at[0] >= 0.0
                    && at[0] + width <= room[0]
                    && (0.5 * LINE..=room[1] - 0.5 * LINE).contains(&at[1]);
                let covers = |mark: &[f64; 2]| {
                    (at[0] - 5.0..at[0] + width).contains(&mark[0])
                        && (mark[1] - at[1]).abs() < 0.5 * LINE
                };
                inside
                    && !marks.iter().any(covers)
                    && placed.iter().all(|own| !own.overlaps(*at, width))
            };
            let rows = (0..=MOVES)
                .flat_map(|n| [n, -n])
                .map(|n| f64::from(n) * LINE);
            let places = rows.flat_map(|down| {
                let of = move |aside| [point[0] + aside, point[1] + down];
                asides(width).into_iter().map(of)
            });
            if let Some(at) = places.into_iter().find(is_free) {
                placed.push(Placed { text, point, at });
            }
        }
        Self(placed)
    }
}

/// The layers of labels: lines to those that were moved, and their letters.
pub(crate) fn labelled(labels: &Labels) -> [Value; 2] {
    let pixel = |field: &str| json!({ "field": field, "type": "quantitative", "scale": null, "axis": null });
    let row = |own: &Placed| {
        let is_right = own.at[0] > own.point[0];
        let end = match is_right {
            true => own.at[0] - 2.0,
            false => own.at[0] + Placed::width(&own.text),
        };
        json!({
            "x": own.at[0], "y": own.at[1], "text": own.text,
            "from_x": own.point[0], "from_y": own.point[1], "to_x": end,
        })
    };
    let rows: Vec<Value> = labels.0.iter().map(row).collect();
    let moved = labels.0.iter().zip(&rows).filter(|(own, _)| own.is_moved());
    let moved: Vec<&Value> = moved.map(|(_, row)| row).collect();
    [
        json!({
            "data": { "values": moved },
            "mark": { "type": "rule", "opacity": 0.35, "aria": false },
            "encoding": {
                "x": pixel("from_x"), "y": pixel("from_y"), "x2": { "field": "to_x" }, "y2": { "field": "y" },
            },
        }),
        json!({
            "data": { "values": rows },
            "mark": { "type": "text", "align": "left", "baseline": "middle" },
            "encoding": { "x": pixel("x"), "y": pixel("y"), "text": { "field": "text" } },
        }),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_levels_are_outside_of_the_plot() {
        let size = [400.0, 300.0];
        let levels = (0..8).map(|i| {
            (
                [400.0, 250.0 + f64::from(i)],
                format!("a long name of a level {i}"),
            )
        });
        let Labels(placed) = Labels::right_of(levels.collect(), size);
        assert_eq!(placed.len(), 8);
        assert!(placed.iter().all(|own| own.at[0] > size[0]));
    }

    #[test]
    fn labels_of_neighbours_do_not_overlap() {
        let points = (0..12).map(|i| ([100.0 + f64::from(i), 100.0], format!("point {i}")));
        let points: Vec<_> = points.collect();
        let marks: Vec<_> = points.iter().map(|(at, _)| *at).collect();
        let Labels(placed) = Labels::beside(points, &marks, [400.0, 300.0]);
        assert_eq!(placed.len(), 12);
        for (i, one) in placed.iter().enumerate() {
            for other in &placed[..i] {
                assert!(
                    !other.overlaps(one.at, Placed::width(&one.text)),
                    "{} {}",
                    one.text,
                    other.text
                );
            }
        }
    }
}
