//! EuRoC MAV, `state_groundtruth_estimate0/data.csv` (Burri et al. 2016): nanoseconds, position and
//! quaternion, scalar first, of the body in the world, then velocity and biases, which are not used.
//! The body is the inertial sensor; `T_BS` of a camera's `sensor.yaml` is its pose in the body, in
//! which a camera looks along +z, x right and y down.

use glam::DVec3;
use potamoi_base::file_keys::{FileKeys, Notes};

use super::dialect::is_header;
use super::error::{TrajectoryError, Wrong};
use super::keys::EUROC;
use super::lines::{Line, Lines, number, shown};
use super::pose::{FAR, Pose};
use super::table::{Sample, Table};

/// Columns that are read, in the file's order.
pub(super) const FIELDS: [&str; 8] = ["timestamp", "p_x", "p_y", "p_z", "q_w", "q_x", "q_y", "q_z"];
const NANOSECONDS_A_SECOND: f64 = 1e9;

pub(super) fn read(
    lines: &Lines<'_>,
    table: &mut Table<'_>,
    notes: &mut Notes,
) -> Result<(), TrajectoryError> {
    let mut first = None;
    let mut header = None;
    for line in lines.all() {
        if is_header(line) && table.count() == 0 {
            let names = names(line).map_err(|wrong| lines.at(line, wrong))?;
            header = Some(names);
            continue;
        }
        if line.is_comment() {
            continue;
        }
        let (time, nanos, pose, columns) = pose(line).map_err(|wrong| lines.at(line, wrong))?;
        if table.count() == 0 {
            further(header.as_deref(), columns, notes);
        }
        let since = nanos - *first.get_or_insert(nanos);
        let seconds = since as f64 / NANOSECONDS_A_SECOND;
        table.push(line, time, Sample { seconds, pose })?;
    }
    Ok(())
}

/// The names of columns, without their units. The first eight must be those that are read.
fn names(line: Line<'_>) -> Result<Vec<String>, Wrong> {
    let text = line.text()?.trim_start_matches('#');
    let names = text.split(',').map(|name| {
        let name = name.split('[').next().unwrap_or(name);
        name.trim().to_owned()
    });
    let names: Vec<String> = names.collect();
    for (at, field) in FIELDS.into_iter().enumerate() {
        let name = names.get(at).map_or("", String::as_str);
        // `p_RS_R_x` is the x of the position p.
        let ends = |(head, tail)| name.starts_with(head) && name.ends_with(tail);
        let fits = field.split_once('_').map_or(name == field, ends);
        if !fits {
            let expected = format!("a column of {field}, in the order {}", FIELDS.join(", "));
            let value = format!("{}, in column {}", shown(name), at + 1);
            return Err(("a column's name", value, expected));
        }
    }
    Ok(names)
}

/// Lists the columns behind the pose.
fn further(header: Option<&[String]>, columns: usize, notes: &mut Notes) {
    let named = |at: usize| match header.and_then(|names| names.get(at)) {
        Some(name) if !name.is_empty() => name.clone(),
        _ => format!("column {}", at + 1),
    };
    let rest = (FIELDS.len()..columns).map(|at| (named(at), ()));
    // No row of the table is refused, and each name is listed once.
    let _ = FileKeys::new(&EUROC, rest).finish(notes);
}

/// A line's time as text and in nanoseconds, its pose, and its number of columns.
fn pose(line: Line<'_>) -> Result<(&str, i64, Pose, usize), Wrong> {
    let words: Vec<&str> = line.text()?.split(',').map(str::trim).collect();
    if words.len() < FIELDS.len() {
        let expected = format!("at least {}: {}", FIELDS.len(), FIELDS.join(", "));
        return Err(("the number of values", words.len().to_string(), expected));
    }
    let nanos = words[0].parse::<i64>().ok();
    // The difference of two such times has 63 bits.
    let Some(nanos) = nanos.filter(|nanos| (0..1 << 62).contains(nanos)) else {
        let expected = "a whole number of nanoseconds, 0 to 4.6e18".to_owned();
        return Err((FIELDS[0], shown(words[0]), expected));
    };
    let value = |at: usize| number(FIELDS[at], words[at], FAR);
    let position = DVec3::new(value(1)?, value(2)?, value(3)?);
    let parts = [value(5)?, value(6)?, value(7)?, value(4)?];
    let pose = Pose::of_quaternion(position, parts)?;
    Ok((words[0], nanos, pose, words.len()))
}
