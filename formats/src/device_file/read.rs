//! Reading of device files.

use toml::{Table, Value};

use super::{Contents, DeviceError, Figure, Kind, Origin};
use crate::document::foreign;
use crate::nearest::nearest;

/// The expected form of a figure.
const FORM: &str = "`{ value = 1.0, source = \"...\" }` or `{ value = 1.0, assumed = \"why\" }`";

pub(super) fn contents(
    kind: &Kind,
    file: &str,
    text: &str,
    figures: &[Figure],
) -> Result<Contents, DeviceError> {
    let table: Table = text.parse().map_err(|e: toml::de::Error| {
        let message = foreign(&e.message().replace('\n', ", "));
        let file = file.to_owned();
        DeviceError::Syntax { file, message }
    })?;
    refuse_unknown(kind, file, &table, figures)?;
    let mut own = Contents::default();
    for key in kind.texts {
        own.texts
            .insert((*key).to_owned(), text_of(file, &table, key)?);
    }
    for of in figures {
        own.figures
            .insert(of.key.to_owned(), figure(file, &table, of)?);
    }
    Ok(own)
}

fn refused(file: &str, field: &str, found: &str, expected: &str, action: &str) -> DeviceError {
    DeviceError::Field {
        file: file.to_owned(),
        field: field.to_owned(),
        found: found.to_owned(),
        expected: expected.to_owned(),
        action: action.to_owned(),
    }
}

fn refuse_unknown(
    kind: &Kind,
    file: &str,
    table: &Table,
    figures: &[Figure],
) -> Result<(), DeviceError> {
    let texts = kind.texts.iter().copied();
    let known: Vec<&str> = texts.chain(figures.iter().map(|f| f.key)).collect();
    for key in table.keys() {
        if !known.contains(&key.as_str()) {
            let action = nearest(key, known.iter().copied()).map_or_else(
                || "remove it".to_owned(),
                |near| format!("write `{near}`, or remove it"),
            );
            let expected = format!("the keys are {}", known.join(", "));
            return Err(refused(
                file,
                key,
                &format!("no key of a {}", kind.name),
                &expected,
                &action,
            ));
        }
    }
    Ok(())
}

fn text_of(file: &str, table: &Table, key: &str) -> Result<String, DeviceError> {
    match table.get(key) {
        Some(Value::String(text)) if !text.is_empty() => Ok(text.clone()),
        other => {
            let found = other.map_or_else(|| "missing".to_owned(), ToString::to_string);
            let expected = "a text has to be there";
            let action = format!("write `{key} = \"...\"`");
            Err(refused(file, key, &found, expected, &action))
        }
    }
}

fn figure(file: &str, table: &Table, field: &Figure) -> Result<(f64, Origin), DeviceError> {
    let key = field.key;
    let write = format!("write `{key} = ...` as {FORM}");
    let Some(entry) = table.get(key) else {
        let expected = format!("every device has it ({})", field.unit);
        return Err(refused(file, key, "missing", &expected, &write));
    };
    let Some(entry) = entry.as_table() else {
        let found = entry.to_string();
        let expected = "a value and its origin have to be there";
        return Err(refused(file, key, &found, expected, &write));
    };
    for part in entry.keys() {
        if !["value", "source", "assumed"].contains(&part.as_str()) {
            let name = format!("{key}.{part}");
            let expected = format!("a figure is {FORM}");
            return Err(refused(
                file,
                &name,
                "no key of a figure",
                &expected,
                "remove it",
            ));
        }
    }
    Ok((value(file, entry, field)?, origin(file, entry, key)?))
}

fn value(file: &str, entry: &Table, field: &Figure) -> Result<f64, DeviceError> {
    let found = entry.get("value");
    let number = match found {
        Some(Value::Float(number)) => Some(*number),
        Some(Value::Integer(number)) => Some(*number as f64),
        _ => None,
    };
    match number {
        Some(number) if (field.least..=field.most).contains(&number) => Ok(number),
        _ => {
            let found = found.map_or_else(|| "missing".to_owned(), ToString::to_string);
            let Figure {
                least, most, unit, ..
            } = field;
            let expected = format!("it is a number from {least} to {most} {unit}");
            let action = "look it up in the data sheet, and mind the unit";
            let name = format!("{}.value", field.key);
            Err(refused(file, &name, &found, &expected, action))
        }
    }
}

fn origin(file: &str, entry: &Table, key: &str) -> Result<Origin, DeviceError> {
    let text = |part: &str| {
        let text = entry.get(part).and_then(Value::as_str).map(str::trim);
        text.filter(|text| !text.is_empty()).map(str::to_owned)
    };
    match (text("source"), text("assumed")) {
        (Some(source), None) => Ok(Origin::Source(source)),
        (None, Some(why)) => Ok(Origin::Assumed(why)),
        (source, _) => {
            let found = if source.is_some() {
                "both sourced and assumed"
            } else {
                "without an origin"
            };
            let expected = "each figure has either a `source` or an `assumed` reason";
            let action = "name the publication, or say why it is assumed";
            Err(refused(file, key, found, expected, action))
        }
    }
}
