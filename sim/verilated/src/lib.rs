//! Builds, loads and drives Verilator models at run time.
