//! The `potamoi` command line.
fn main() {}
