//! Plots by Vega-Lite: one specification for a file, for the book and for an interactive page.
//!
//! | module | contents |
//! |---|---|
//! | [`figures`] | numbers as text |
//! | [`library`] | the vendored JavaScript, with version, licence and hash |
//! | [`look`] | colours, shapes and letters that all plots share |
//! | [`renderer`] | specifications as SVG, by the vendored library in an embedded engine |

pub mod figures;
pub mod library;
pub mod look;
pub mod renderer;

pub use look::{COLOURS, Ink, SHAPES, look_of};
pub use renderer::{PlotError, Renderer};
