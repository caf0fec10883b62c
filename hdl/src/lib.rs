//! Netlist, printer and hardware units.
