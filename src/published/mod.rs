//! The schema of a report, made from the types that are written.

mod closed;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::{Map, Value, json};

use crate::failure::Failure;

/// Dialect of the schemas.
const DIALECT: &str = "https://json-schema.org/draft/2020-12/schema";

/// The schema of what a command writes, within the schema of its report.
pub(crate) type Shape = fn(&mut SchemaGenerator) -> Schema;

/// A report of `--json`.
pub(crate) struct Published {
    /// Value of the key `command`: the command, and the flag that chooses this report.
    pub(crate) command: &'static str,
    /// Value of the key `format_version`.
    pub(crate) version: u32,
    pub(crate) shape: Shape,
}

/// A report of one type, as a [`Shape`].
pub(crate) fn shape<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    generator.subschema_for::<T>()
}

/// A report of one type or the other.
pub(crate) fn either<A: JsonSchema, B: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    any_of(&[shape::<A>(generator), shape::<B>(generator)])
}

/// A report of one of three types.
pub(crate) fn one_of_three<A: JsonSchema, B: JsonSchema, C: JsonSchema>(
    generator: &mut SchemaGenerator,
) -> Schema {
    any_of(&[
        shape::<A>(generator),
        shape::<B>(generator),
        shape::<C>(generator),
    ])
}

fn any_of(shapes: &[Schema]) -> Schema {
    let mut schema = Schema::default();
    schema.insert("anyOf".to_owned(), json!(shapes));
    schema
}

impl Published {
    /// Name of the schema: the command's, with a hyphen before the flag.
    pub(crate) fn name(&self) -> String {
        self.command.replace(" --", "-")
    }

    /// The schema. It allows no key that the program does not write.
    pub(crate) fn schema(&self) -> Value {
        let settings = SchemaSettings::draft2020_12().for_serialize();
        let mut generator = settings.into_generator();
        let shape = Value::from((self.shape)(&mut generator));
        let mut definitions = generator.take_definitions(true);
        let shapes = shape["anyOf"].as_array().cloned();
        for own in shapes.unwrap_or_else(|| vec![shape.clone()]) {
            let name = own["$ref"].as_str().and_then(|to| to.rsplit('/').next());
            let report = name.and_then(|name| definitions.get_mut(name));
            if let Some(keys) = report.and_then(|own| own["properties"].as_object_mut()) {
                self.fix(keys);
            }
        }
        let mut schema = json!({
            "$schema": DIALECT,
            "$id": format!("urn:potamoi:report:{}:{}", self.name(), self.version),
            "title": format!("Report of potamoi {}, format {}", self.command, self.version),
        });
        if let (Value::Object(schema), Value::Object(shape)) = (&mut schema, shape) {
            schema.extend(shape);
            schema.insert("$defs".to_owned(), definitions.into());
        }
        closed::close(&mut schema);
        schema
    }

    /// Fixes what tells a report from others.
    fn fix(&self, keys: &mut Map<String, Value>) {
        if let Some(version) = keys.get_mut("format_version") {
            version["const"] = self.version.into();
        }
        if let Some(command) = keys.get_mut("command") {
            command["const"] = self.command.into();
        }
    }

    /// The schema as the text of a file.
    pub(crate) fn text(&self) -> Result<String, Failure> {
        let text = serde_json::to_string_pretty(&self.schema());
        Ok(text.map_err(|error| Failure::Output(error.to_string()))? + "\n")
    }
}
