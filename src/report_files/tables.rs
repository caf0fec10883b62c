//! The tables of a report: every list of objects, one object a row.

use std::collections::{BTreeMap, VecDeque};
use std::io;

use serde_json::{Map, Value};

/// A table.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Table {
    /// Columns, in the order in which rows have them first.
    columns: Vec<String>,
    /// Cells of each row by column.
    rows: Vec<BTreeMap<String, Value>>,
}

impl Table {
    fn push(&mut self, row: Vec<(String, Value)>) {
        for (name, _) in &row {
            if !self.columns.contains(name) {
                self.columns.push(name.clone());
            }
        }
        self.rows.push(row.into_iter().collect());
    }

    /// The table as CSV: numbers as in JSON, nothing for null and for a key that a row lacks, lists as
    /// JSON.
    pub(super) fn csv(&self) -> io::Result<String> {
        let mut csv = csv::Writer::from_writer(vec![]);
        csv.write_record(&self.columns)?;
        for row in &self.rows {
            csv.write_record(self.columns.iter().map(|name| match row.get(name) {
                None | Some(Value::Null) => String::new(),
                Some(Value::String(text)) => text.clone(),
                Some(other) => other.to_string(),
            }))?;
        }
        let bytes = csv.into_inner().map_err(|error| error.into_error())?;
        String::from_utf8(bytes).map_err(io::Error::other)
    }
}

/// The tables of a report, by their places in it; what stands in no list is the table of the empty place.
pub(super) fn of(report: &Value) -> BTreeMap<String, Table> {
    let mut found = BTreeMap::new();
    if let Value::Object(own) = report {
        collect("", &[], own, 0, &mut found);
    }
    found
}

/// The objects of a list that has nothing else.
fn objects(value: &Value) -> Option<Vec<&Map<String, Value>>> {
    let all = value.as_array().filter(|all| !all.is_empty())?;
    all.iter().map(Value::as_object).collect()
}

/// Adds the row of an object, which is number `at` of the table `place`, and the rows of the tables in it.
/// `outer` has the tables around it, with the numbers of their rows.
fn collect(
    place: &str,
    outer: &[(String, Value)],
    own: &Map<String, Value>,
    at: usize,
    found: &mut BTreeMap<String, Table>,
) {
    let mut row = outer.to_vec();
    let mut inner = vec![];
    let mut todo = VecDeque::from([(String::new(), own)]);
    while let Some((prefix, part)) = todo.pop_front() {
        for (key, value) in part {
            let name = format!("{prefix}{key}");
            match (objects(value), value) {
                (Some(rows), _) => inner.push((name, rows)),
                (None, Value::Object(object)) if !object.is_empty() => {
                    todo.push_back((format!("{name}."), object));
                }
                _ => row.push((name, value.clone())),
            }
        }
    }
    found.entry(place.to_owned()).or_default().push(row);
    let mut within = outer.to_vec();
    if !place.is_empty() {
        within.push((place.to_owned(), at.into()));
    }
    for (name, rows) in inner {
        let name = match place.is_empty() {
            true => name,
            false => format!("{place}.{name}"),
        };
        for (number, item) in rows.into_iter().enumerate() {
            collect(&name, &within, item, number, found);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use serde_json::json;

    #[test]
    fn lists_of_objects_are_tables_that_name_the_rows_around_them() {
        let report = json!({
            "format_version": 1, "size": [4, 3], "none": null, "empty": [],
            "scenes": [
                { "name": "a, \"b\"", "clock": { "ghz": 1.5 }, "runs": [{ "ms": 1 }, { "ms": 2, "x": true }] },
                { "name": "c", "clock": { "ghz": null }, "runs": [{ "ms": 3 }] },
            ],
        });
        let found = of(&report);
        let texts: Vec<_> = found
            .iter()
            .map(|(place, own)| (&**place, own.csv().unwrap()))
            .collect();
        let expected = [
            ("", "format_version,size,none,empty\n1,\"[4,3]\",,[]\n"),
            ("scenes", "name,clock.ghz\n\"a, \"\"b\"\"\",1.5\nc,\n"),
            ("scenes.runs", "scenes,ms,x\n0,1,\n0,2,true\n1,3,\n"),
        ];
        let texts: Vec<(&str, &str)> = texts.iter().map(|(a, b)| (*a, &**b)).collect();
        assert_eq!(texts, expected);
    }
}
