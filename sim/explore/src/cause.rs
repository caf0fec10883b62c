//! Causes of errors, by what a user can do about them.

use std::error::Error;

use potamoi_rtl::RtlError;
use potamoi_synth::SynthError;
use potamoi_verilated::Error as ModelError;

use crate::ExploreError;

/// Where the cause of an error is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// In a file, an argument, the configuration, or a folder that cannot be used.
    Input,
    /// In the hardware or the program: a check failed.
    Check,
    /// In a tool that is missing or broken.
    Tool,
    /// Nowhere: a check had no result.
    Inconclusive,
}

impl ExploreError {
    /// Where its cause is.
    #[must_use]
    pub fn cause(&self) -> Cause {
        match self {
            Self::Config(_)
            | Self::Work(_)
            | Self::Hardware(_)
            | Self::Warp(_)
            | Self::Runtime(_)
            | Self::Mesh(_)
            | Self::Model(_)
            | Self::Cost(_)
            | Self::Refused(_) => Cause::Input,
            Self::Scene(error) => error.unit().map_or(Cause::Input, of_unit),
            Self::Unit(error) => of_unit(&**error),
            Self::Rtl(error) => of_rtl(error),
            Self::Synth(error) => of_synthesis(error),
            Self::Netlist(_) | Self::Check(_) | Self::Rows(_) | Self::Counts(_) => Cause::Check,
            Self::Inconclusive(_) => Cause::Inconclusive,
        }
    }
}

impl ExploreError {
    /// The error in a user's words: of a tool that is missing or broken, without the scene that
    /// was to be rendered with it.
    #[must_use]
    pub fn told(&self) -> String {
        let unit = match self {
            Self::Scene(error) => error.unit(),
            _ => None,
        };
        match unit {
            Some(unit) if of_unit(unit) == Cause::Tool => unit.to_string(),
            _ => self.to_string(),
        }
    }
}

/// Cause of an error of a renderer's units, which may be hardware.
fn of_unit(error: &(dyn Error + Send + Sync + 'static)) -> Cause {
    error.downcast_ref().map_or(Cause::Input, of_rtl)
}

fn of_rtl(error: &RtlError) -> Cause {
    match error {
        RtlError::MissingTool { .. } | RtlError::BrokenTool { .. } => Cause::Tool,
        RtlError::Model(error) => of_model(error),
        RtlError::Stream(_) | RtlError::Work(_) | RtlError::Fault(_) | RtlError::Folder(_) => {
            Cause::Input
        }
        _ => Cause::Check,
    }
}

fn of_synthesis(error: &SynthError) -> Cause {
    match error {
        SynthError::MissingTool { .. }
        | SynthError::NoLibrary { .. }
        | SynthError::Broken { .. } => Cause::Tool,
        SynthError::Tool { .. } | SynthError::Output { .. } | SynthError::Netlist(_) => {
            Cause::Check
        }
        SynthError::Cache(error) => of_model(error),
        SynthError::Rtl(error) => of_rtl(error),
        _ => Cause::Input,
    }
}

/// Cause of a model that was not built or run: a fault of the machine is no failed check.
fn of_model(error: &ModelError) -> Cause {
    match error {
        ModelError::MissingTool { .. }
        | ModelError::OldTool { .. }
        | ModelError::Broken { .. }
        | ModelError::Load { .. } => Cause::Tool,
        ModelError::NoCacheDir
        | ModelError::NoFolder { .. }
        | ModelError::Untrusted { .. }
        | ModelError::Io { .. } => Cause::Input,
        _ => Cause::Check,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_is_that_of_the_innermost_error() {
        let folder = || ModelError::NoCacheDir;
        let refused = || ExploreError::Refused("no".to_owned());
        for (error, cause) in [
            (refused(), Cause::Input),
            (ExploreError::Check("bit".to_owned()), Cause::Check),
            (
                ExploreError::Inconclusive("few".to_owned()),
                Cause::Inconclusive,
            ),
            (SynthError::Cache(folder()).into(), Cause::Input),
            (RtlError::Model(folder()).into(), Cause::Input),
            (
                ExploreError::Unit(Box::new(RtlError::Model(folder()))),
                Cause::Input,
            ),
            (ExploreError::Unit("another unit".into()), Cause::Input),
        ] {
            assert_eq!(error.cause(), cause, "{error}");
        }
    }
}
