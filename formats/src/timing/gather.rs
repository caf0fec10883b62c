//! Pipeline from the issue of a vertex to the offer of a result, in the channel-major and the
//! parity organisation.

use super::Pipeline;

/// A pipeline stage of a reducer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReducerStage {
    /// Feature and weight, registered for their fan-out to many reducers.
    Operands,
    /// Products of the feature with each half of the weight.
    PartialProducts,
    /// The product.
    Product,
    /// The running sum. Its rounding takes no stage.
    Sum,
}

/// A pipeline stage after the issue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GatherStage {
    /// Stage 1: rows read from the table at the clock edge.
    Features,
    /// A stage of the reducers.
    Reducer(ReducerStage),
    /// First entry of the result FIFO.
    Fifo,
    /// Register after the FIFO.
    Output,
}

impl Pipeline<ReducerStage> {
    /// Pipeline of a reducer. Products are split where `pipelined`, and registered there and with
    /// `whole_cells`, whose eight vertices are summed at once.
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
    /// Pipeline of a group's last vertex, reducer stages included.
    #[must_use]
    pub fn gather(reducer: &Pipeline<ReducerStage>, pipelined: bool) -> Self {
        let mut stages = vec![GatherStage::Features];
        stages.extend(reducer.stages().map(GatherStage::Reducer));
        stages.push(GatherStage::Fifo);
        stages.extend(pipelined.then_some(GatherStage::Output));
        Self::new(stages)
    }
}
