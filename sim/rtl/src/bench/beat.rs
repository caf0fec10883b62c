//! What a beat carries.

use std::collections::BTreeMap;

use crate::RtlError;

/// Payload of a beat: words, low first, by field.
pub(super) type Beat = BTreeMap<&'static str, Vec<u32>>;

/// Error of a port or field that the benches do not know.
pub(super) fn unknown(port: &str) -> RtlError {
    RtlError::Usage(format!("the benches know no value of the port {port}"))
}
