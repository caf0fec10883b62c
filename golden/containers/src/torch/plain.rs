//! Checks of plain values in a checkpoint, in Python's notation.

use super::value::Value;
use super::{Checkpoint, TorchError};
use potamoi_base::file_keys::told;

impl Checkpoint {
    /// Refuses a key that is present unless it has one of these values, in Python's notation:
    /// `True`, `1`, `'a text'`. Numbers, texts and truth values are never equal to one another.
    ///
    /// # Errors
    /// The key, with its value.
    pub fn says_only(&self, keys: &[&str], wanted: &[&str]) -> Result<(), TorchError> {
        let Some(value) = self.find(keys) else {
            return Ok(());
        };
        let found = self.printed(value);
        if wanted.contains(&found.as_str()) {
            return Ok(());
        }
        Err(self.field(keys, found, &wanted.join(" or ")))
    }

    fn printed(&self, value: Value) -> String {
        match value {
            Value::None => "None".to_owned(),
            Value::Bool(true) => "True".to_owned(),
            Value::Bool(false) => "False".to_owned(),
            Value::Int(value) => value.to_string(),
            Value::Float(value) => format!("{value:?}"),
            Value::Text(at) => format!("'{}'", told(&self.arena.texts[at])),
            other => other.kind().to_owned(),
        }
    }
}
