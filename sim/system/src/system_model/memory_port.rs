//! Access energy of a synthesised memory.

use potamoi_synth::SynthReport;
use serde::Serialize;

/// Energy of a memory, in picojoules an access.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Port {
    /// Read.
    pub read_pj: f64,
    /// Write.
    pub write_pj: f64,
}

/// Access energy of a memory of a unit or of the system, and the leakage of all such memories in
/// milliwatts; `None` where the report has no such memory.
pub(super) fn port(memories: &SynthReport, unit: &str, name: &str) -> Option<(Port, f64)> {
    let (raw, scaled) = memories.memory(unit, name)?;
    let figures = scaled.map_or(raw.figures, |s| s.figures);
    let port = Port {
        read_pj: figures.read_pj,
        write_pj: figures.write_pj,
    };
    Some((port, figures.leakage_mw * raw.count as f64))
}
