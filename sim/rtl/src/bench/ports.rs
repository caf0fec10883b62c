//! Ports of a unit, by what a bench does with them.

use potamoi_netlist::Module;

use crate::RtlError;

/// An AXI4-Stream.
#[derive(Debug, Clone)]
pub(super) struct Stream {
    /// Name before `_tvalid`.
    pub(super) name: String,
    /// Payload with its widths, without `tvalid` and `tready`.
    pub(super) fields: Vec<(String, u32)>,
}

impl Stream {
    /// Name without its role: `rit` of `s_axis_rit`.
    pub(super) fn short(&self) -> &str {
        self.name.rsplit('_').next().unwrap_or(&self.name)
    }

    /// Width of a field, 0 where there is none.
    pub(super) fn width(&self, field: &str) -> u32 {
        let own = self.fields.iter().find(|(name, _)| name == field);
        own.map_or(0, |(_, bits)| *bits)
    }
}

/// Ports of a unit.
#[derive(Debug, Clone)]
pub(super) struct UnitPorts {
    pub(super) module: String,
    pub(super) inputs: Vec<Stream>,
    pub(super) output: Stream,
    /// Settings, which a job holds.
    pub(super) settings: Vec<(String, u32)>,
    /// Counters and flags.
    pub(super) stats: Vec<(String, u32)>,
    pub(super) clears: bool,
    pub(super) idle: bool,
}

impl UnitPorts {
    /// The ports of a module.
    ///
    /// # Errors
    /// A port that a bench has no use for, or no feature or result stream.
    pub(super) fn of(module: &Module) -> Result<Self, RtlError> {
        let refuse =
            |problem: String| RtlError::Usage(format!("no bench for {}: {problem}", module.name()));
        let mut streams: Vec<(bool, Stream)> = vec![];
        let (mut settings, mut stats, mut clears, mut idle) = (vec![], vec![], false, false);
        for port in module.ports() {
            let (name, width) = (port.name, port.ty.width);
            let field = ["s_axis_", "m_axis_"]
                .iter()
                .any(|role| name.starts_with(role))
                .then(|| name.rsplit_once('_'))
                .flatten();
            if let Some((stream, field)) = field {
                let at = match streams.iter().position(|(_, s)| s.name == stream) {
                    Some(at) => at,
                    None => {
                        let (name, fields) = (stream.to_owned(), vec![]);
                        streams.push((stream.starts_with('m'), Stream { name, fields }));
                        streams.len() - 1
                    }
                };
                if !["tvalid", "tready"].contains(&field) {
                    streams[at].1.fields.push((field.to_owned(), width));
                }
            } else if name == "cfg_clear" {
                clears = true;
            } else if name == "idle" {
                idle = true;
            } else if name.starts_with("cfg_") {
                settings.push((name, width));
            } else if name.starts_with("stat_") {
                stats.push((name, width));
            } else {
                return Err(refuse(format!(
                    "its port {name} is none of a stream, cfg_*, stat_*"
                )));
            }
        }
        let (outputs, inputs): (Vec<_>, Vec<_>) = streams.into_iter().partition(|s| s.0);
        let [(_, output)] = <[_; 1]>::try_from(outputs)
            .map_err(|found| refuse(format!("{} output streams: expected one", found.len())))?;
        Ok(Self {
            module: module.name().to_owned(),
            inputs: inputs.into_iter().map(|s| s.1).collect(),
            output,
            settings,
            stats,
            clears,
            idle,
        })
    }

    pub(super) fn input(&self, short: &str) -> Option<&Stream> {
        self.inputs.iter().find(|s| s.short() == short)
    }
}
