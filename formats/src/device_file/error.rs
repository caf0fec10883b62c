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
