//! Stream ports common to all organisations of the unit.

use potamoi_formats::config::Config;
use potamoi_formats::timing::GatherStage;
use potamoi_netlist::{Instance, IrErrors, ModuleBuilder, Signal, Ty};

use crate::fifo::fifo;

/// An input port and its name.
pub(crate) type Named = (&'static str, Signal);

/// Ports of the RIT stream.
pub(crate) fn rit_stream(m: &mut ModuleBuilder, config: &Config) -> Vec<Named> {
    let stream = config.rit_stream_bits();
    let bit = Ty::bit();
    [
        ("s_axis_rit_tvalid", bit, "ray index table"),
        ("s_axis_rit_tdata", Ty::u(stream), ""),
        ("s_axis_rit_tkeep", Ty::u(stream / 8), ""),
        ("s_axis_rit_tlast", bit, "ends the MVoxel"),
        ("s_axis_rit_tuser", bit, "streamed once for every segment"),
    ]
    .map(|(name, ty, doc)| (name, m.input(name, ty, doc)))
    .to_vec()
}

/// Content of the feature FIFO for one beat.
pub(crate) struct Beat {
    pub(crate) push: Signal,
    /// Whether it is the last of its MVoxel and segment.
    pub(crate) end: Signal,
    /// Valid entries of the beat.
    pub(crate) keep: Signal,
    /// Slot of each entry.
    pub(crate) slot: Signal,
    /// Features of each entry, in 16-bit lanes.
    pub(crate) data: Signal,
}

/// The feature stream: a FIFO; the issue keeps track of its free space.
pub(crate) struct FeatureStream {
    /// A beat is accepted by the sink.
    pub(crate) pop: Signal,
    pub(crate) fifo: Instance,
    valid: Signal,
    out: Signal,
    widths: [u32; 3],
}

impl FeatureStream {
    /// Builds the FIFO, with a register behind its read where that stage is built.
    ///
    /// # Errors
    /// The netlist's own checks.
    pub(crate) fn build(
        m: &mut ModuleBuilder,
        config: &Config,
        beat: &Beat,
        ready: Signal,
    ) -> Result<Self, IrErrors> {
        let word = m.cat(&[beat.end, beat.keep, beat.slot, beat.data]);
        // The register is one of the places.
        let registered = config.gather_pipeline().has(GatherStage::Output);
        let depth = config.feature_fifo_depth() - u32::from(registered);
        let module = fifo("feature_fifo", depth, word.width())?;
        let inst = m.instance(
            "results",
            &module,
            &[("push", beat.push), ("push_data", word)],
        );
        let some = m.out(inst, "valid");
        let (valid, take) = if registered {
            let valid = m.reg("out_valid", Ty::bit(), 0);
            let free = m.not(valid);
            let free = m.or(free, ready);
            let take = m.and(some, free);
            let take = m.name(take, "take");
            let waits = m.not(ready);
            let waits = m.and(valid, waits);
            let next = m.or(some, waits);
            m.set_next(valid, next);
            (valid, Some(take))
        } else {
            (some, None)
        };
        let pop = m.and(valid, ready);
        let pop = m.name(pop, "pop");
        let leaves_fifo = take.unwrap_or(pop);
        m.connect(inst, "pop", leaves_fifo);
        let mut out = m.out(inst, "data");
        if let Some(take) = take {
            let word = m.data_reg("out_word", word.ty());
            m.set_next_if(word, take, out);
            out = word;
        }
        Ok(Self {
            pop,
            fifo: inst,
            valid,
            out,
            widths: [beat.data.width(), beat.slot.width(), beat.keep.width()],
        })
    }

    /// Declares the stream's outputs; `docs` describe a beat and its data.
    pub(crate) fn outputs(&self, m: &mut ModuleBuilder, docs: [&str; 3]) {
        let [data, slots, entries] = self.widths;
        m.output("m_axis_feat_tvalid", self.valid, docs[0]);
        let features = m.slice(self.out, 0, data);
        m.output("m_axis_feat_tdata", features, docs[1]);
        let keep = m.slice(self.out, data + slots, entries);
        let keep = m.name(keep, "kept_ports");
        let mut bytes = vec![];
        for entry in (0..entries).rev() {
            let kept = m.bit(keep, entry);
            bytes.push(m.repeat(kept, data / 8 / entries));
        }
        let bytes = m.cat(&bytes);
        m.output("m_axis_feat_tkeep", bytes, docs[2]);
        let last = m.bit(self.out, data + slots + entries);
        m.output("m_axis_feat_tlast", last, "ends the MVoxel and segment");
        let user = m.slice(self.out, data, slots);
        m.output("m_axis_feat_tuser", user, "slot of each entry");
    }
}

/// Counter that goes up with `up` and down with `down`.
pub(crate) fn count_both(m: &mut ModuleBuilder, count: Signal, up: Signal, down: Signal) {
    let one = m.lit(1, count.ty());
    let more = m.add(count, one);
    let less = m.sub(count, one);
    let next = m.mux(up, more, less);
    let changes = m.xor(up, down);
    m.set_next_if(count, changes, next);
}
