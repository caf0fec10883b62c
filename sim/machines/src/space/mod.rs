//! Spaces of machines: fields, each with its values.

#[cfg(test)]
mod tests;

use std::collections::HashSet;

use potamoi_formats::document::{self, Value, Wrong};
use potamoi_scene::Scene;

use crate::machine::{Machine, MachineError, shown};

/// Largest number of points of a space.
const MOST: usize = 10_000_000;
/// Largest number of points that are looked at for one that keeps the rules.
const MOST_LOOKED_AT: usize = 4_096;
/// Largest number of values of a range.
const MOST_VALUES: usize = 10_000;

/// Fields that vary together; one field, as a rule.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Paths of the fields, such as `vu.lanes`, `system.memory_channels`, `render.step`, `path.window`.
    pub fields: Vec<String>,
    /// Values of all fields, at each place.
    pub values: Vec<Vec<Value>>,
}

/// The values of varied fields at a point, as text, in the order of the fields.
pub type Setting = Vec<(String, String)>;

impl Axis {
    /// A field with its values, as a command line has them: `vu.lanes=12,24,48`, a range with a step or a
    /// factor, `vu.lanes=12..48:+12` and `vu.lanes=12..48:*2`, or a list in TOML, `vu.ops=[["exp"]]`.
    ///
    /// # Errors
    /// Text of another form; the error says what was expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let expected = "expected FIELD=VALUE,..., FIELD=FROM..TO:+STEP or FIELD=FROM..TO:*FACTOR";
        let (field, values) = text
            .split_once('=')
            .ok_or_else(|| format!("{text}: {expected}"))?;
        let values = match (range_of(values), list_of(values)) {
            (Some(range), _) => range.map_err(|why| format!("{text}: {why}; {expected}"))?,
            (_, Some(list)) => list,
            // A range without its step.
            _ if is_bounds(values) => return Err(format!("{text}: {expected}")),
            _ => values.split(',').map(|own| value(own.trim())).collect(),
        };
        if field.trim().is_empty() || values.is_empty() {
            return Err(format!("{text}: {expected}"));
        }
        Ok(Self::of(field.trim(), values))
    }

    /// A field with its values.
    #[must_use]
    pub fn of(field: &str, values: Vec<Value>) -> Self {
        Self {
            fields: vec![field.to_owned()],
            values: values.into_iter().map(|own| vec![own]).collect(),
        }
    }

    /// A field with the values of a document: a list, or a range such as
    /// `{ from = 12, to = 48, factor = 2 }` or `{ from = 1, to = 4, step = 1 }`.
    ///
    /// # Errors
    /// Another kind of value.
    pub fn of_document(field: &str, given: &Value) -> Result<Self, Wrong> {
        let expected = "a list of values, or { from, to, step } or { from, to, factor }";
        let wrong = || Wrong::found(given.shown(), expected).under(field);
        let values = match given {
            Value::List(all) if !all.is_empty() => all.to_vec(),
            Value::Map(_) => {
                let number = |key| given.get(key).and_then(Value::number);
                let (from, to) = number("from").zip(number("to")).ok_or_else(wrong)?;
                let by = match (number("step"), number("factor")) {
                    (Some(step), None) => By::Step(step),
                    (None, Some(factor)) => By::Factor(factor),
                    _ => return Err(wrong()),
                };
                range(from, to, by).map_err(|why| Wrong::new(why).under(field))?
            }
            _ => return Err(wrong()),
        };
        Ok(Self::of(field, values))
    }
}

#[derive(Clone, Copy)]
enum By {
    Step(f64),
    Factor(f64),
}

/// A range of a command line, if the text is one.
fn range_of(text: &str) -> Option<Result<Vec<Value>, String>> {
    let (bounds, by) = text.split_once(':')?;
    let (from, to) = bounds.split_once("..")?;
    let number = |own: &str| {
        own.trim()
            .parse::<f64>()
            .map_err(|_| format!("`{own}` is no number"))
    };
    let read = || {
        let by = match (by.strip_prefix('+'), by.strip_prefix('*')) {
            (Some(step), _) => By::Step(number(step)?),
            (_, Some(factor)) => By::Factor(number(factor)?),
            _ => return Err(format!("`{by}` is neither +STEP nor *FACTOR")),
        };
        range(number(from)?, number(to)?, by)
    };
    Some(read())
}

/// Whether a text is a range without the step or factor that it needs.
fn is_bounds(text: &str) -> bool {
    let bounds = text.split_once("..");
    bounds.is_some_and(|(from, to)| {
        [from, to]
            .iter()
            .all(|own| own.trim().parse::<f64>().is_ok())
    })
}

/// The values of a list in TOML, if the text is one.
fn list_of(text: &str) -> Option<Vec<Value>> {
    match value(text.trim()) {
        Value::List(all) => Some(all.to_vec()),
        _ => None,
    }
}

/// Numbers from one to another, both included where they are met.
fn range(from: f64, to: f64, by: By) -> Result<Vec<Value>, String> {
    let grows = match by {
        By::Step(step) => step > 0.0,
        By::Factor(factor) => factor > 1.0 && from > 0.0,
    };
    if !(grows && from <= to && to.is_finite()) {
        let why = "from at most to, a step above 0, a factor above 1 from a number above 0";
        return Err(format!("the range does not end: expected {why}"));
    }
    let at = |i: i32| match by {
        // Decimal steps have no more than twelve digits behind the point.
        By::Step(step) => (f64::from(i).mul_add(step, from) * 1e12).round() / 1e12,
        By::Factor(factor) => from * factor.powi(i),
    };
    let count = match by {
        By::Step(step) => (to - from) / step,
        By::Factor(factor) => (to / from).log(factor),
    };
    if count > MOST_VALUES as f64 {
        return Err(format!("it has more than {MOST_VALUES} values"));
    }
    // Half a millionth is what rounding of decimal steps adds up to.
    let end = to * (1.0 + 5e-7);
    let all = (0..).map(at).take_while(|own| *own <= end);
    Ok(all.map(number).collect())
}

/// A whole number as such.
fn number(of: f64) -> Value {
    match of.fract() == 0.0 && of.abs() < 1e15 {
        true => Value::Int(of as i64),
        false => Value::Float(of),
    }
}

/// A value of a command line: a number, a Boolean, a list, otherwise a text.
fn value(text: &str) -> Value {
    let read = document::toml(format!("v = {text}").as_bytes()).ok();
    let found = read.and_then(|own| own.get("v").cloned());
    found.unwrap_or_else(|| Value::Text(text.into()))
}

/// A space of machines: every combination of the values of its axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Space {
    /// The machine that the fields change.
    pub base: Machine,
    /// Axes; the last varies fastest.
    pub axes: Vec<Axis>,
}

impl Space {
    /// A space of fields that each vary once.
    ///
    /// # Errors
    /// A field that varies twice, a value that stands twice, a value that the base does not take, more than ten million points.
    pub fn new(base: Machine, axes: Vec<Axis>) -> Result<Self, SpaceError> {
        let mut known: Vec<&str> = vec![];
        for field in axes.iter().flat_map(|axis| &axis.fields) {
            if known.contains(&field.as_str()) {
                return Err(SpaceError::Twice {
                    field: field.clone(),
                });
            }
            known.push(field);
        }
        for axis in &axes {
            let of = |values: &Vec<Value>| values.iter().map(shown).collect::<Vec<_>>().join(", ");
            let mut known = HashSet::new();
            if let Some(again) = axis.values.iter().find(|own| !known.insert(of(own))) {
                return Err(SpaceError::Repeated {
                    field: axis.fields.join(", "),
                    value: of(again),
                });
            }
        }
        let mut own = Self { base, axes };
        own.read_texts();
        let count =
            (own.axes.iter()).try_fold(1usize, |of, axis| of.checked_mul(axis.values.len()));
        if count.is_none_or(|count| count > MOST) {
            return Err(SpaceError::Large);
        }
        own.check()?;
        Ok(own)
    }

    /// Takes a number for a text where a field takes texts alone: the device `3090`.
    fn read_texts(&mut self) {
        let base = &self.base;
        let is_taken = |field: &str, value: &Value| {
            let found = base.with(&base.name, &[(field, value.clone())]);
            found.map_or_else(|error| error.is_rule(), |_| true)
        };
        for axis in &mut self.axes {
            for values in &mut axis.values {
                for (field, value) in axis.fields.iter().zip(values) {
                    let text = Value::Text(shown(value).into());
                    if value.text().is_none() && !is_taken(field, value) && is_taken(field, &text) {
                        *value = text;
                    }
                }
            }
        }
    }

    /// Refuses values that no machine takes, before anything is counted. Values that break a rule
    /// beside others are points that are refused one by one.
    fn check(&self) -> Result<(), SpaceError> {
        for axis in &self.axes {
            for values in &axis.values {
                let changes = changes(axis, values);
                match self.base.with(&self.base.name, &changes) {
                    Err(error) if !error.is_rule() => return Err(error.into()),
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// The first broken rule of a space in which no point keeps the rules. Of a space of more than some
    /// thousand points none is looked for.
    #[must_use]
    pub fn without_points(&self) -> Option<MachineError> {
        let looked_at = (self.len() <= MOST_LOOKED_AT).then_some(self.len());
        let mut first = None;
        for point in 0..looked_at? {
            match self.machine(&self.places(point)) {
                Ok(_) => return None,
                Err(error) => first = first.or(Some(error)),
            }
        }
        first
    }

    /// Refuses values of `[render]` that none of the scenes takes, before anything is counted.
    ///
    /// # Errors
    /// The first such value.
    pub fn check_on(&self, scenes: &[Scene]) -> Result<(), SpaceError> {
        let is_render = |axis: &&Axis| axis.fields.iter().any(|own| own.starts_with("render."));
        for axis in self.axes.iter().filter(is_render) {
            for values in &axis.values {
                let Ok(machine) = self.base.with(&self.base.name, &changes(axis, values)) else {
                    continue;
                };
                let mut failed = None;
                let is_taken = scenes.iter().any(|scene| {
                    let own = machine.prepare(&mut scene.clone());
                    own.map_err(|error| failed = Some(error)).is_ok()
                });
                if let (false, Some(error)) = (is_taken, failed) {
                    return Err(error.into());
                }
            }
        }
        Ok(())
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// Whether it has no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Places on the axes of a point by its number.
    #[must_use]
    pub fn places(&self, mut point: usize) -> Vec<usize> {
        let mut places = vec![0; self.axes.len()];
        for (place, axis) in places.iter_mut().zip(&self.axes).rev() {
            *place = point % axis.values.len();
            point /= axis.values.len();
        }
        places
    }

    /// Number of the point at these places.
    #[must_use]
    pub fn number(&self, places: &[usize]) -> usize {
        let both = self.axes.iter().zip(places);
        both.fold(0, |of, (axis, place)| of * axis.values.len() + place)
    }

    /// Values of the varied fields at places, as text.
    #[must_use]
    pub fn setting(&self, places: &[usize]) -> Setting {
        let chosen = self.axes.iter().zip(places);
        let each = chosen.flat_map(|(axis, place)| {
            let fields = axis.fields.iter().zip(&axis.values[*place]);
            fields.map(|(field, value)| (field.clone(), shown(value)))
        });
        each.collect()
    }

    /// The machine at places.
    ///
    /// # Errors
    /// Values that do not go together; the error names the broken rule.
    pub fn machine(&self, places: &[usize]) -> Result<Machine, MachineError> {
        let chosen = self.axes.iter().zip(places);
        let changes: Vec<(&str, Value)> = chosen
            .flat_map(|(axis, place)| changes(axis, &axis.values[*place]))
            .collect();
        self.base.with(&self.base.name, &changes)
    }
}

fn changes<'a>(axis: &'a Axis, values: &[Value]) -> Vec<(&'a str, Value)> {
    let both = axis.fields.iter().zip(values);
    both.map(|(field, value)| (field.as_str(), value.clone()))
        .collect()
}

/// Why axes are no space.
#[derive(Debug, thiserror::Error)]
pub enum SpaceError {
    /// A field varies twice.
    #[error("field `{field}` varies twice: give all its values once")]
    Twice {
        /// The field.
        field: String,
    },
    /// A field has a value twice.
    #[error("field `{field}` has the value {value} twice: leave one out")]
    Repeated {
        /// The field, or the fields that vary together.
        field: String,
        /// The value.
        value: String,
    },
    /// It has too many points.
    #[error("more than {MOST} points: expected fewer values, or a search (potamoi explore)")]
    Large,
    /// A value is no machine's.
    #[error(transparent)]
    Machine(#[from] MachineError),
}
