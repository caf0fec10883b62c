//! Plot of points and their Pareto front.

use potamoi_explore::accuracy::{CostQuality, ImageQuality, Point, ReferenceKind, Sweep, front};
use potamoi_plots::{COLOURS, SHAPES};
use serde_json::{Value, json};

use crate::charts::{GREY, Labels, SERIES, labelled, number};

/// Width and height of a panel in pixels.
const SIZE: [f64; 2] = [430.0, 420.0];
/// Index of the default among the points.
const DEFAULT: usize = 0;
/// Smallest change, as a share of a panel, of a knob that has a label.
const SEEN: f64 = 0.03;
/// What is said of knobs without a colour of their own.
const OTHERS: &str = "other knobs";

/// Place of a point by one of its qualities; `None` where pictures are equal or the quality is
/// unknown.
fn place(point: &Point, of: impl Fn(&Point) -> Option<ImageQuality>) -> Option<CostQuality> {
    Some(CostQuality {
        cost: point.frame_ns * 1e-3,
        quality: of(point)?.db?,
    })
}

/// A panel for each reference: its name, and the plot.
pub(crate) fn panels(report: &Sweep) -> Vec<(&'static str, Value)> {
    let beside_truth: fn(&Point) -> Option<ImageQuality> = |p| p.truth;
    let converged: fn(&Point) -> Option<ImageQuality> = |p| Some(p.converged);
    let all = [
        (
            ReferenceKind::Truth,
            "dB beside the truth, which the model was sampled from",
            beside_truth,
        ),
        (
            ReferenceKind::Converged,
            "dB beside the converged picture of the model",
            converged,
        ),
    ];
    let known = all.into_iter().filter(|(kind, ..)| {
        *kind == ReferenceKind::Converged || report.reference.kind == ReferenceKind::Truth
    });
    known
        .filter_map(|(kind, what, of)| {
            Some((kind.name(), Panel::of(report, of)?.spec(report, what)))
        })
        .collect()
}

/// Quality over time, against the ground truth where it is known, and against the converged picture.
pub(crate) fn spec(report: &Sweep) -> Value {
    let panels: Vec<Value> = panels(report).into_iter().map(|(_, own)| own).collect();
    json!({
        "title": {
            "text": format!(
                "{}, {} x {}: quality and time of a frame by knob",
                report.scene, report.size[0], report.size[1]
            ),
            "subtitle": potamoi_page::FRONT_LINES,
        },
        "hconcat": panels,
        "spacing": 24,
    })
}

/// The points of a panel, with the ends of its axes.
struct Panel {
    seen: Vec<(usize, CostQuality)>,
    times: [f64; 2],
    qualities: [f64; 2],
}

impl Panel {
    fn of(report: &Sweep, of: fn(&Point) -> Option<ImageQuality>) -> Option<Self> {
        let seen: Vec<(usize, CostQuality)> = (report.points.iter().enumerate())
            .filter_map(|(i, point)| Some((i, place(point, of)?)))
            .collect();
        let range = |of: fn(&CostQuality) -> f64| {
            let all = seen.iter().map(|(_, place)| of(place));
            all.fold((f64::MAX, f64::MIN), |(low, high), v| {
                (low.min(v), high.max(v))
            })
        };
        let ((fast, slow), (low, high)) = (range(|p| p.cost), range(|p| p.quality));
        let [wide, room] = [
            (0.06 * (slow - fast)).max(1e-3 * slow),
            (0.06 * (high - low)).max(0.5),
        ];
        (!seen.is_empty()).then_some(Self {
            seen,
            times: [fast - wide, slow + wide],
            qualities: [low - room, high + room],
        })
    }

    /// Pixels from the upper left corner.
    fn pixels(&self, at: CostQuality) -> [f64; 2] {
        let ([fast, slow], [low, high]) = (self.times, self.qualities);
        [
            SIZE[0] * (at.cost - fast) / (slow - fast),
            SIZE[1] * (high - at.quality) / (high - low),
        ]
    }

    fn at(&self, wanted: usize) -> Option<CostQuality> {
        let found = self.seen.iter().find(|(i, _)| *i == wanted);
        found.map(|(_, place)| *place)
    }

    /// How far a point is from the default, as a share of the panel.
    fn away(&self, at: CostQuality) -> f64 {
        let Some(default) = self.at(DEFAULT) else {
            return 1.0;
        };
        let ([x, y], [a, b]) = (self.pixels(at), self.pixels(default));
        ((x - a) / SIZE[0]).hypot((y - b) / SIZE[1])
    }

    /// Labels: of each knob the setting that changes most, if that is seen.
    fn labels(&self, report: &Sweep) -> Labels {
        let mut furthest: Vec<(&str, usize, CostQuality, f64)> = vec![];
        for (i, place) in &self.seen {
            let (knob, away) = (report.points[*i].knob.as_str(), self.away(*place));
            match furthest.iter_mut().find(|own| own.0 == knob) {
                Some(own) if own.3 < away => *own = (knob, *i, *place, away),
                Some(_) => {}
                None => furthest.push((knob, *i, *place, away)),
            }
        }
        let seen = furthest
            .iter()
            .filter(|own| own.3 > SEEN && own.1 != DEFAULT);
        let text = |i: usize| {
            let point = &report.points[i];
            format!("{} {}", point.knob, point.setting)
        };
        let labels = seen.map(|own| (self.pixels(own.2), text(own.1)));
        let marks: Vec<_> = self.seen.iter().map(|(_, own)| self.pixels(*own)).collect();
        Labels::beside(labels.collect(), &marks, SIZE)
    }

    fn spec(&self, report: &Sweep, what: &str) -> Value {
        let coloured = coloured(report);
        let points: Vec<Value> = (self.seen.iter())
            .filter(|(i, _)| *i != DEFAULT)
            .map(|(i, place)| {
                let own = &report.points[*i];
                let is_known = coloured.contains(&own.knob.as_str());
                json!({
                    "us": place.cost, "db": place.quality, "knob": own.knob, "setting": own.setting,
                    "series": if is_known { &own.knob } else { OTHERS },
                })
            })
            .collect();
        let places: Vec<CostQuality> = self.seen.iter().map(|(_, place)| *place).collect();
        let row = |at: &CostQuality| json!({ "us": at.cost, "db": at.quality });
        let kept: Vec<Value> = front(&places)
            .into_iter()
            .map(|i| row(&places[i]))
            .collect();
        let mut domain: Vec<&str> = coloured;
        domain.push(OTHERS);
        let count = domain.len() - 1;
        let colours: Vec<&str> = COLOURS[..count].iter().copied().chain([GREY]).collect();
        let shapes: Vec<&str> = SHAPES[..count].iter().copied().chain(["circle"]).collect();
        let axis = |field: &str, title: &str, domain: [f64; 2]| {
            let mut own = number(field, title);
            own["scale"] = json!({ "domain": domain, "nice": false, "zero": false });
            own
        };
        let x = axis("us", "microseconds a frame", self.times);
        let y = axis("db", what, self.qualities);
        let series = |range: &[&str]| {
            json!({
                "field": "series", "type": "nominal", "title": null,
                "scale": { "domain": domain, "range": range },
                "legend": { "orient": "bottom", "columns": 4, "symbolOpacity": 1 },
            })
        };
        let ring = |wanted: Option<usize>, shape: &str| {
            let at: Vec<Value> = (wanted.and_then(|i| self.at(i)).iter()).map(row).collect();
            json!({
                "data": { "values": at },
                "mark": { "type": "point", "shape": shape, "size": 300, "strokeWidth": 2, "filled": false, "aria": false },
                "encoding": { "x": x, "y": y, "color": { "value": "#C00000" } },
            })
        };
        let [leaders, names] = labelled(&self.labels(report));
        json!({
            "width": SIZE[0],
            "height": SIZE[1],
            "layer": [
                {
                    "data": { "values": kept },
                    "mark": { "type": "line", "opacity": 0.7 },
                    "encoding": { "x": x, "y": y },
                },
                {
                    "data": { "values": points },
                    "mark": { "type": "line", "opacity": 0.35 },
                    "encoding": {
                        "x": x, "y": y, "color": series(&colours), "detail": { "field": "knob" },
                        "order": { "field": "us" },
                    },
                },
                {
                    "data": { "values": points },
                    "mark": { "type": "point", "filled": true, "size": 70 },
                    "encoding": {
                        "x": x, "y": y, "color": series(&colours), "shape": series(&shapes),
                        "tooltip": [
                            { "field": "knob" }, { "field": "setting" },
                            number("us", "microseconds"), number("db", "dB"),
                        ],
                    },
                },
                leaders,
                names,
                ring(Some(DEFAULT), "square"),
                ring(report.knee, "circle"),
            ],
        })
    }
}

/// Knobs with a colour of their own: those that change the default's picture or time most.
fn coloured(report: &Sweep) -> Vec<&str> {
    let places: Vec<CostQuality> = report.points.iter().map(Point::place).collect();
    let spread = |of: fn(&CostQuality) -> f64| {
        let finite = places.iter().map(of).filter(|v| v.is_finite());
        let (low, high) = finite.fold((f64::MAX, f64::MIN), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        (high - low).max(f64::MIN_POSITIVE)
    };
    let [wide, high] = [spread(|p| p.cost), spread(|p| p.quality)];
    let mut knobs: Vec<(&str, f64)> = vec![];
    for (point, place) in report.points.iter().zip(&places).skip(1) {
        let [x, y] = [
            place.cost - places[0].cost,
            place.quality - places[0].quality,
        ];
        let away = (x / wide).hypot(if y.is_finite() { y / high } else { 0.0 });
        match knobs.iter_mut().find(|(known, _)| *known == point.knob) {
            Some(own) => own.1 = own.1.max(away),
            None => knobs.push((&point.knob, away)),
        }
    }
    knobs.sort_by(|a, b| b.1.total_cmp(&a.1));
    knobs.truncate(SERIES);
    knobs.into_iter().map(|(name, _)| name).collect()
}
