//! Names that are near to a misspelt one.

use std::io::ErrorKind;

use potamoi_base::effects::Effect;
use potamoi_explore::ExploreError;
use potamoi_formats::config::{ConfigError, PRESETS};
pub(crate) use potamoi_formats::nearest::nearest;
use potamoi_machines::MachineError;
use potamoi_machines::sweep::SweepError;
use potamoi_scene::{BUILTIN, Representation, SceneError};

use crate::failure::Failure;

/// A message, with the nearest known name behind it.
pub(crate) fn with_nearest<'a>(
    message: impl std::fmt::Display,
    given: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> String {
    match nearest(given, known) {
        Some(name) => format!("{message}; did you mean `{name}`?"),
        None => message.to_string(),
    }
}

/// The text between the first back quotes of a message.
fn quoted(message: &str) -> Option<&str> {
    message.split('`').nth(1)
}

fn of_scene(error: &SceneError) -> Option<&'static str> {
    match error {
        // The model of a ready scene follows a colon.
        SceneError::Unknown { name, .. } => nearest(name.split(':').next()?, BUILTIN),
        SceneError::Value {
            field: "representation",
            value,
            ..
        } => {
            let all = Representation::ALL.iter().chain(&Representation::FULL_SIZE);
            nearest(value, all.map(|own| own.name()))
        }
        _ => None,
    }
}

fn of_config(error: &ConfigError) -> Option<&'static str> {
    match error {
        ConfigError::Read { path, source } if source.kind() == ErrorKind::NotFound => {
            nearest(&path.to_string_lossy(), PRESETS.map(|(name, _)| name))
        }
        _ => None,
    }
}

fn of_study(error: &ExploreError) -> Option<&'static str> {
    match error {
        ExploreError::Scene(error) => of_scene(error),
        ExploreError::Config(error) => of_config(error),
        _ => None,
    }
}

fn of_machine(error: &MachineError) -> Option<&'static str> {
    match error {
        MachineError::Config(error) => of_config(error),
        MachineError::Explore(error) => of_study(error),
        _ => None,
    }
}

fn of_sweep(error: &SweepError) -> Option<&'static str> {
    match error {
        SweepError::Machine(error) => of_machine(error),
        SweepError::Scene(error) => of_scene(error),
        SweepError::Within { source, .. } => of_sweep(source),
        _ => None,
    }
}

/// The name that a failure's misspelt scene, preset or effect may have meant. Errors of
/// devices and of the command line name theirs themselves.
pub(crate) fn of(failure: &Failure) -> Option<String> {
    let name = match failure {
        Failure::Explore(error) => of_study(error),
        Failure::Machine(error) => of_machine(error),
        Failure::Sweep(error) => of_sweep(error),
        Failure::Effect(error) => {
            let message = error.to_string();
            let names = Effect::ALL.map(|effect| effect.to_string());
            return nearest(quoted(&message)?, names.iter().map(|name| &**name)).map(str::to_owned);
        }
        _ => None,
    };
    name.map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_ends_with_the_nearest_name() {
        let known = ["garden", "lantern", "cairn"];
        assert_eq!(
            with_nearest("no", "carin", known),
            "no; did you mean `cairn`?"
        );
        assert_eq!(with_nearest("no", "q", known), "no");
    }
}
