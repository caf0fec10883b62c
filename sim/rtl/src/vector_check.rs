//! Compares the vector unit with its cycle model and its golden results in every cycle and every
//! bit.

use potamoi_cycles::{VectorInputs, VectorModel, WorkError};
use potamoi_formats::config::Config;
use potamoi_formats::units::VECTOR_UNIT;

use super::mismatch::{Mismatch, first_difference, same};
use super::model::RtlError;
use super::vector_drive::{ResultSeen, Vector, VectorSeen, VectorWatch, Vectors, keep_lanes};

/// Cycles between two calls of the progress function.
const EVERY: u64 = 1 << 14;

/// Observer that fails at the first difference.
pub(super) struct VectorCheck<'a> {
    vectors: &'a Vectors<'a>,
    /// Expected results, one for each element.
    results: &'a [i32],
    model: VectorModel,
    next: usize,
    data: Vec<u32>,
    keep: Vec<u32>,
    all: [Vec<u32>; 2],
    cycles: u64,
    every: &'a mut dyn FnMut(u64),
}

impl<'a> VectorCheck<'a> {
    /// `every` is called now and then with the cycles since the last call.
    ///
    /// # Errors
    /// A configuration that the model refuses.
    pub(super) fn new(
        config: &Config,
        vectors: &'a Vectors<'a>,
        results: &'a [i32],
        every: &'a mut dyn FnMut(u64),
    ) -> Result<Self, WorkError> {
        let lanes = vectors.lanes;
        let mut keep = vec![0; lanes.div_ceil(8)];
        keep_lanes(&mut keep, lanes, 4);
        Ok(Self {
            vectors,
            results,
            model: VectorModel::new(config)?,
            next: 0,
            data: vec![0; lanes],
            keep: vec![0; lanes.div_ceil(8)],
            all: [vec![u32::MAX; lanes], keep],
            cycles: 0,
            every,
        })
    }

    fn differs(&self, cycle: u64, signal: &str, found: String, expected: String) -> Mismatch {
        let place = self.vectors.list.get(self.next).map_or_else(
            || "after the last vector".to_owned(),
            |v| {
                let last = v.ordinal + v.a.len() - 1;
                let code = v.op.code;
                format!("next vector: elements {} to {last}, {code:?}", v.ordinal)
            },
        );
        Mismatch {
            module: VECTOR_UNIT,
            cycle,
            signal: signal.to_owned(),
            expected,
            found,
            place,
        }
    }

    fn result(
        &mut self,
        cycle: u64,
        seen: &ResultSeen<'_>,
        vector: &Vector<'_>,
    ) -> Result<(), Box<Mismatch>> {
        self.data.fill(0);
        self.keep.fill(0);
        let count = vector.a.len();
        let results = &self.results[vector.ordinal..vector.ordinal + count];
        for (i, result) in results.iter().enumerate() {
            self.data[i] = *result as u32;
        }
        keep_lanes(&mut self.keep, count, 4);
        same(u8::from(seen.last), u8::from(vector.last), |f, e| {
            self.differs(cycle, "m_axis_vec_tlast", f, e)
        })?;
        if let Some(byte) = first_difference(seen.keep, None, &self.keep, &self.all[1]) {
            let lane = byte / 4;
            let bit = |words: &[u32]| (words[byte / 32] >> (byte % 32) & 1).to_string();
            let signal = format!("m_axis_vec_tkeep of lane {lane}");
            let (found, expected) = (bit(seen.keep), bit(&self.keep));
            return Err(Box::new(self.differs(cycle, &signal, found, expected)));
        }
        // Lanes that are not kept give 0, so every bit counts.
        if let Some(bit) = first_difference(seen.data, seen.unknown, &self.data, &self.all[0]) {
            let lane = bit / 32;
            let operands = vector.a.get(lane).zip(vector.b.get(lane));
            let operands = operands.map_or(String::new(), |(a, b)| format!(", a = {a}, b = {b}"));
            let signal = format!("m_axis_vec_tdata of lane {lane}{operands}");
            let found = if seen.unknown.is_some_and(|u| u[lane] != 0) {
                "not known (x or z)".to_owned()
            } else {
                (seen.data[lane] as i32).to_string()
            };
            let expected = (self.data[lane] as i32).to_string();
            return Err(Box::new(self.differs(cycle, &signal, found, expected)));
        }
        Ok(())
    }
}

impl VectorWatch for VectorCheck<'_> {
    fn cycle(
        &mut self,
        cycle: u64,
        inputs: &VectorInputs,
        seen: &VectorSeen<'_>,
    ) -> Result<(), RtlError> {
        let is_idle = self.model.is_idle();
        let wanted = self.model.step(inputs);
        for (name, found, expected) in [
            ("s_axis_vec_tready", seen.ready, wanted.ready),
            ("m_axis_vec_tvalid", seen.result.is_some(), wanted.valid),
            ("idle", seen.idle, is_idle),
        ] {
            same(u8::from(found), u8::from(expected), |f, e| {
                self.differs(cycle, name, f, e)
            })?;
        }
        let counters = [wanted.vectors, wanted.busy, wanted.stall_out].map(u64::from);
        let names = ["stat_vectors", "stat_busy", "stat_stall_out"];
        for (i, name) in names.into_iter().enumerate() {
            same(seen.counters[i], counters[i], |f, e| {
                self.differs(cycle, name, f, e)
            })?;
        }
        if let Some(result) = &seen.result {
            // The model offers no more than was accepted.
            if let Some(vector) = self.vectors.list.get(self.next).copied() {
                self.result(cycle, result, &vector)?;
            }
            self.next += usize::from(inputs.ready);
        }
        self.cycles += 1;
        if self.cycles.is_multiple_of(EVERY) {
            (self.every)(EVERY);
        }
        Ok(())
    }
}
