//! Golden renderers, unit twins and traces.
