//! What a checkpoint says under a key, as Python would print it.

use super::value::Value;
use super::{Checkpoint, TorchError};
use potamoi_base::record::told;

impl Checkpoint {
    /// Refuses a key that is there and says anything but one of these values, which are
    /// written as Python prints them: `True`, `1`, `'a text'`. A number, a text and a
    /// truth value are never taken for one another.
    ///
    /// # Errors
    /// The key, with what it says.
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
