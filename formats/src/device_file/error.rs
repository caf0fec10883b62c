//! What is wrong with a device, and what to do.

/// Why a device is refused.
#[derive(Debug, thiserror::Error)]
pub enum DeviceError {
    /// No device has that name.
    #[error("no {kind} is called `{name}`; the {kind}s are {known}{suggestion}")]
    Unknown {
        /// The kind of device.
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// `; did you mean ...?`, or nothing.
        suggestion: String,
        /// All names.
        known: String,
    },
    /// The file is not readable.
    #[error("{file}: {source}; give a readable file of the form of {example}")]
    Unreadable {
        /// The file.
        file: String,
        /// The error of the operating system.
        source: std::io::Error,
        /// A file to start from.
        example: &'static str,
    },
    /// The file is not TOML.
    #[error("{file}: not TOML: {message}; correct the line")]
    Syntax {
        /// The file.
        file: String,
        /// The error of the parser.
        message: String,
    },
    /// A field is not as it has to be.
    #[error("{file}: `{field}` is {found}, but {expected}; {action}")]
    Field {
        /// The file.
        file: String,
        /// The field.
        field: String,
        /// The value found.
        found: String,
        /// The values allowed.
        expected: String,
        /// The remedy.
        action: String,
    },
}

/// The name that takes the fewest edits, if a third of its letters or fewer are to be edited.
#[must_use]
pub fn nearest<'a>(name: &str, names: &[&'a str]) -> Option<&'a str> {
    let edits = |known: &str| distance(&name.to_lowercase(), known);
    let best = names.iter().min_by_key(|known| edits(known))?;
    (edits(best) <= best.len().div_ceil(3)).then_some(*best)
}

/// Levenshtein's distance.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut before = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = before + usize::from(x != *y);
            before = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(before + 1);
        }
    }
    row[b.len()]
}
