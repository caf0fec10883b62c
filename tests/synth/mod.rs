//! `potamoi synth` and `potamoi estimate`.
mod estimates;
mod refused_libraries;
mod syntheses;
