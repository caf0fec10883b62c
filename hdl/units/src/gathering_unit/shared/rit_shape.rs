//! Geometry of the RIT buffer, and the state of its halves.

use potamoi_formats::config::{Config, EntryKind, Modes};
use potamoi_formats::rit::{MAX_VERTICES, Vertices};
use potamoi_formats::timing::{Pipeline, RitStage};
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use crate::circuits::bits_for;

/// Geometry that both sides of the buffer share.
pub(crate) struct Shape {
    pub(crate) ports: u32,
    /// 16-bit banks: halfwords of a row.
    pub(crate) banks: u32,
    /// Halfwords of a beat.
    pub(crate) lanes: u32,
    /// Beats of a row.
    pub(crate) phases: u32,
    pub(crate) rows: u32,
    pub(crate) slot_bits: u32,
    /// Fraction bits `W` of a weight.
    pub(crate) weight_bits: u32,
    pub(crate) vertices: Vec<Vertices>,
    /// Whether entries are compact: rows and weights are computed from a cell.
    pub(crate) compact: bool,
    /// Whether all eight vertices of an entry are issued at once.
    pub(crate) whole_cells: bool,
    /// Pipeline stages from the banks to P.
    pub(crate) pipeline: Pipeline<RitStage>,
    config: Config,
}

impl Shape {
    pub(crate) fn of(config: &Config) -> Self {
        let banks = config.rit_row_bits() / 16;
        let lanes = config.rit_stream_bits() / 16;
        Self {
            ports: config.gu.ports,
            banks,
            lanes,
            phases: banks / lanes,
            rows: config.rit_rows(),
            slot_bits: config.rit.slot_bits,
            weight_bits: config.gu.weight_bits,
            vertices: config.supported_vertices(),
            compact: config.rit.entry == EntryKind::Compact,
            whole_cells: config.is_parity(),
            pipeline: config.rit_pipeline(),
            config: config.clone(),
        }
    }

    pub(crate) fn entry_halfwords(&self, vertices: Vertices) -> u32 {
        (self.config.entry_bytes(vertices) / 2) as u32
    }

    /// Whether entries have weights; single-vertex records do not.
    pub(crate) fn has_weights(&self) -> bool {
        self.config.gu.modes != Modes::Unstructured
    }

    /// Number of vertices issued at once.
    pub(crate) const fn at_once(&self) -> u32 {
        if self.whole_cells {
            MAX_VERTICES as u32
        } else {
            1
        }
    }

    /// Row distances from a cell's first vertex to the others.
    pub(crate) fn offsets(&self, vertices: Vertices) -> [u16; MAX_VERTICES] {
        // A rule of the configuration: its rows hold a cell.
        self.config.mvoxel.offsets(vertices).unwrap_or_default()
    }

    /// Width in bits of a vertex's position along each axis, for entries of so many vertices; edges
    /// are powers of two where this is used.
    pub(crate) fn row_fields(&self, vertices: Vertices) -> Vec<u32> {
        let axes = vertices.log2();
        let edges = self.config.mvoxel.edges(axes).unwrap_or([1; 3]);
        let fields = edges[..axes as usize].iter();
        fields.map(|edge| edge.ilog2()).collect()
    }

    /// Width in bits of a vertex's position along an axis of a volume.
    pub(crate) fn axis_bits(&self) -> u32 {
        let edges = self.config.mvoxel.edges(3).unwrap_or([2; 3]);
        edges[0].ilog2()
    }

    /// Groups of M entries in a row.
    pub(crate) fn groups(&self, vertices: Vertices) -> u32 {
        self.banks / (self.ports * self.entry_halfwords(vertices))
    }

    fn most_groups(&self) -> u32 {
        self.vertices
            .iter()
            .map(|v| self.groups(*v))
            .max()
            .unwrap_or(1)
    }

    /// Type of a row index, including one past the last.
    pub(crate) fn row_ty(&self) -> Ty {
        Ty::u(bits_for(self.rows))
    }

    /// Type of a group index within a row, including one past the last.
    pub(crate) fn group_ty(&self) -> Ty {
        Ty::u(bits_for(self.most_groups()))
    }

    /// Width in bits of a row index within a half.
    pub(crate) fn row_index_bits(&self) -> u32 {
        bits_for((self.rows - 1).max(1))
    }

    /// Rows of a bank: half 1 starts at a power of two.
    pub(crate) fn depth(&self) -> u32 {
        (1 << self.row_index_bits()) + self.rows.max(2)
    }

    /// Selects one value for each entry size by `cfg_vertices`.
    pub(crate) fn by_vertices(
        &self,
        m: &mut ModuleBuilder,
        cfg: Signal,
        mut value: impl FnMut(&mut ModuleBuilder, Vertices) -> Signal,
    ) -> Signal {
        let built: Vec<(Vertices, Signal)> =
            self.vertices.iter().map(|v| (*v, value(m, *v))).collect();
        // Entry sizes that are not built read as the largest one.
        let fallback = built[built.len() - 1].1;
        let options: Vec<Signal> = Vertices::ALL
            .into_iter()
            .map(|v| {
                built
                    .iter()
                    .find(|(b, _)| *b == v)
                    .map_or(fallback, |(_, s)| *s)
            })
            .collect();
        m.select(cfg, &options)
    }
}

/// State of the two halves, written by the writer.
pub(crate) struct Halves {
    /// Closed to writes until it is released.
    pub(crate) closed: [Signal; 2],
    pub(crate) end_row: [Signal; 2],
    pub(crate) end_group: [Signal; 2],
    /// Whether it holds the last entry of its MVoxel.
    pub(crate) ends_mvoxel: [Signal; 2],
    /// Whether its MVoxel is streamed once for every segment.
    pub(crate) streamed: [Signal; 2],
    /// Valid entries of its last group.
    pub(crate) last_keep: [Signal; 2],
}

impl Halves {
    pub(crate) fn declare(m: &mut ModuleBuilder, shape: &Shape) -> Self {
        let bit = Ty::bit();
        let mut pair = |name: &str, ty: Ty| [0, 1].map(|h| m.reg(&format!("{name}_{h}"), ty, 0));
        let (closed, end_row) = (pair("closed", bit), pair("end_row", shape.row_ty()));
        let end_group = pair("end_group", shape.group_ty());
        let mut data = |name: &str, ty: Ty| [0, 1].map(|h| m.data_reg(&format!("{name}_{h}"), ty));
        Self {
            closed,
            end_row,
            end_group,
            ends_mvoxel: data("ends_mvoxel", bit),
            streamed: data("streamed", bit),
            last_keep: data("last_keep", Ty::u(shape.ports)),
        }
    }
}

/// `pair[half]`.
pub(crate) fn of_half(m: &mut ModuleBuilder, half: Signal, pair: [Signal; 2]) -> Signal {
    m.mux(half, pair[1], pair[0])
}
