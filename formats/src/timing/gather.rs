//! From the issue of a vertex to the offer of a result, of the channel-major and the parity
//! organisation.

use super::Pipeline;

/// A register stage of a reducer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReducerStage {
    /// Feature and weight, so that they reach many reducers in a cycle of their own.
    Operands,
    /// The feature's products with each half of the weight.
    PartialProducts,
    /// The product.
    Product,
    /// The sum so far. Its rounding takes no stage.
    Sum,
}

/// A register stage behind the issue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GatherStage {
    /// Stage 1: the table has read the rows at the clock edge.
    Features,
    /// In the reducers.
    Reducer(ReducerStage),
    /// The FIFO of results: its first place.
    Fifo,
    /// The register behind the FIFO.
    Output,
}

impl Pipeline<ReducerStage> {
    /// Products are in parts where `pipelined`, and registered there and of `whole_cells`, whose
    /// eight are summed up at once.
    #[must_use]
    pub fn reducer(pipelined: bool, whole_cells: bool) -> Self {
        Self::built([
            (ReducerStage::Operands, pipelined),
            (ReducerStage::PartialProducts, pipelined),
            (ReducerStage::Product, pipelined || whole_cells),
            (ReducerStage::Sum, true),
        ])
    }
}

impl Pipeline<GatherStage> {
    /// Of a group's last vertex, with the reducers' stages in their place.
    #[must_use]
    pub fn gather(reducer: &Pipeline<ReducerStage>, pipelined: bool) -> Self {
        let mut stages = vec![GatherStage::Features];
        stages.extend(reducer.stages().map(GatherStage::Reducer));
        stages.push(GatherStage::Fifo);
        stages.extend(pipelined.then_some(GatherStage::Output));
        Self::new(stages)
    }
}
