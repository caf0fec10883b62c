//! Drives the Verilated vector unit.

use potamoi_formats::config::Config;
use potamoi_formats::units::VectorOp;
use potamoi_hdl::vu::vector_unit;
use potamoi_verilated::{Clock, Library, Model, PortId};

use super::model::{RtlError, compile};
use super::stall::Stalls;

const PATIENCE: u64 = 20_000;

/// A Verilated vector unit.
pub struct VectorUnit {
    lanes: usize,
    library: Library,
}

/// What a run gave.
#[derive(Debug, Clone, PartialEq)]
pub struct VectorRun {
    /// Results, one an element.
    pub results: Vec<i32>,
    /// Cycles until the last vector was accepted by the sink.
    pub cycles: u64,
    /// For every cycle: operands ready 1, results valid 2.
    pub handshakes: Vec<u8>,
    /// Cycle in which each vector was accepted, and in which its results were.
    pub vectors: Vec<(u64, u64)>,
    /// Its sticky flags.
    pub errors: u64,
}

impl VectorUnit {
    /// Builds the unit of a configuration, or finds it in the cache.
    ///
    /// # Errors
    /// A missing tool, or a failure of one.
    pub fn build(config: &Config) -> Result<Self, RtlError> {
        let module = vector_unit(config)?;
        Ok(Self {
            lanes: config.vu.lanes as usize,
            library: compile(&module)?,
        })
    }

    /// Computes element by element, from reset; a new vector begins with every
    /// batch.
    ///
    /// # Errors
    /// Operands of different lengths, or a unit that hangs or fails.
    pub fn run(
        &self,
        batches: &[(VectorOp, &[i32], &[i32])],
        stalls: Stalls,
    ) -> Result<VectorRun, RtlError> {
        let mut vectors: Vec<(VectorOp, &[i32], &[i32])> = vec![];
        for (op, a, b) in batches {
            if a.len() != b.len() {
                return Err(RtlError::Usage(format!(
                    "{} first and {} second operands: expected as many",
                    a.len(),
                    b.len()
                )));
            }
            vectors.extend(
                a.chunks(self.lanes)
                    .zip(b.chunks(self.lanes))
                    .map(|(a, b)| (*op, a, b)),
            );
        }
        let mut model = self.library.model(stalls.seed as u32)?;
        let clock = model.clock("clk")?;
        let reset = model.port("rst_n")?;
        for name in [
            "rst_n",
            "s_axis_vec_tvalid",
            "m_axis_vec_tready",
            "cfg_clear",
        ] {
            let port = model.port(name)?;
            model.set_u64(port, 0)?;
        }
        for _ in 0..3 {
            model.tick(clock)?;
        }
        model.set_u64(reset, 1)?;
        self.cycles(&mut model, clock, &vectors, stalls)
    }

    fn cycles(
        &self,
        model: &mut Model,
        clock: Clock,
        vectors: &[(VectorOp, &[i32], &[i32])],
        stalls: Stalls,
    ) -> Result<VectorRun, RtlError> {
        let port =
            |model: &Model, name: &str| -> Result<PortId, RtlError> { Ok(model.port(name)?) };
        let [valid, ready, data, keep, last, user] =
            ["tvalid", "tready", "tdata", "tkeep", "tlast", "tuser"]
                .map(|n| port(model, &format!("s_axis_vec_{n}")));
        let (valid, ready, data, keep, last, user) = (valid?, ready?, data?, keep?, last?, user?);
        let [out_valid, out_ready, out_data] =
            ["tvalid", "tready", "tdata"].map(|n| port(model, &format!("m_axis_vec_{n}")));
        let (out_valid, out_ready, out_data) = (out_valid?, out_ready?, out_data?);
        let errors = port(model, "stat_errors")?;
        let mut willing = stalls.start();
        let mut run = VectorRun {
            results: Vec::with_capacity(vectors.iter().map(|v| v.1.len()).sum()),
            cycles: 0,
            handshakes: vec![],
            vectors: Vec::with_capacity(vectors.len()),
            errors: 0,
        };
        let (mut sent, mut taken, mut loaded, mut on, mut idle) = (0, 0, usize::MAX, false, 0);
        let mut words = vec![0u32; 2 * self.lanes];
        let mut results = vec![0u32; self.lanes];
        model.set_u64(last, 0)?;
        while taken < vectors.len() {
            let [offers, _, takes] = willing.next();
            on = sent < vectors.len() && (on || offers);
            model.set_u64(valid, u64::from(on))?;
            model.set_u64(out_ready, u64::from(takes))?;
            if on && loaded != sent {
                let (op, a, b) = vectors[sent];
                words.fill(0);
                let mut kept = vec![0u32; self.lanes.div_ceil(32)];
                for (i, (x, y)) in a.iter().zip(b).enumerate() {
                    words[2 * i] = *x as u32;
                    words[2 * i + 1] = *y as u32;
                    kept[i / 32] |= 1 << (i % 32);
                }
                model.set_words(data, &words)?;
                model.set_words(keep, &kept)?;
                model.set_u64(user, u64::from(op.field()))?;
                loaded = sent;
            }
            model.fall(clock)?;
            let is_ready = model.get_u64(ready)? == 1;
            let offered = model.get_u64(out_valid)? == 1;
            run.handshakes
                .push(u8::from(is_ready) | u8::from(offered) << 1);
            idle += 1;
            if offered && takes {
                model.get_words(out_data, &mut results)?;
                let count = vectors[taken].1.len();
                run.results
                    .extend(results[..count].iter().map(|w| *w as i32));
                run.vectors[taken].1 = run.cycles;
                taken += 1;
                idle = 0;
            }
            if on && is_ready {
                run.vectors.push((run.cycles, 0));
                sent += 1;
                on = false;
                idle = 0;
            }
            model.rise(clock)?;
            run.cycles += 1;
            if idle > PATIENCE {
                return Err(RtlError::Hang {
                    unit: potamoi_formats::units::VECTOR_UNIT,
                    cycles: idle,
                    state: format!("{sent} of {} vectors sent, {taken} taken", vectors.len()),
                });
            }
        }
        run.errors = model.get_u64(errors)?;
        Ok(run)
    }
}
