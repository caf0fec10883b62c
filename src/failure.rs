//! What a command ends with when it does not end well.

use std::process::ExitCode;

use potamoi_formats::config::ConfigError;
use potamoi_hdl::ir::IrErrors;
use thiserror::Error;

use crate::files::FileError;

#[derive(Debug, Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error("the generated netlist is wrong: {0}")]
    Netlist(#[from] IrErrors),
    #[error(transparent)]
    File(#[from] FileError),
}

impl Failure {
    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Config(_) | Self::File(_) => 2,
            Self::Netlist(_) => 1,
        })
    }
}
