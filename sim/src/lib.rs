//! Runs traces on generated hardware and predicts its cycles.
