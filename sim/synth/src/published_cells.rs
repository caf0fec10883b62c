//! Areas of memories from a published cell, beside CACTI's: CACTI knows no node below 22 nm, and its
//! areas at 12 nm, scaled with the node, come below the bare cell.

use super::cacti::Shape;

/// Area of a 6T cell with one port at 16 nm, in square micrometres (Chen et al., "A 16 nm 128 Mb
/// SRAM in high-k metal-gate `FinFET` technology", ISSCC 2014). The 12 nm node is of the same family;
/// its cell is assumed to be no smaller.
pub const CELL_UM2: f64 = 0.070;
/// Share of a macro's area that is cells. An assumption; compilers' macros of these sizes have about
/// half to three quarters.
pub const EFFICIENCY: f64 = 0.65;
/// Area that a separate read port adds, relative to the 6T cell: two transistors, as in the 8T cell
/// (Chang et al., "Stable SRAM cell design for the 32 nm node and beyond", VLSI 2005: 30 %).
const READ_PORT: f64 = 0.3;
/// Area that a second port for reads and writes adds, relative to the 6T cell: the pair of bit lines
/// and the word line double the cell. An assumption.
const READ_WRITE_PORT: f64 = 1.0;

/// Square micrometres of a memory at 12 nm.
#[must_use]
pub fn area_um2(shape: &Shape) -> f64 {
    let cells = (shape.words * shape.bits) as f64;
    cells * CELL_UM2 * ports(shape) / EFFICIENCY
}

/// Area of the cell over that of one with a single port.
fn ports(shape: &Shape) -> f64 {
    // One read-write port or the write port is that of the 6T cell.
    let both = (shape.read_writes + shape.writes).saturating_sub(1) as f64;
    1.0 + READ_WRITE_PORT * both + READ_PORT * shape.reads as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 44 KB with one port take 0.039 mm^2; the paper's 0.048 mm^2 are "mostly" its 44 KB.
    #[test]
    fn the_papers_44_kilobytes_fit_its_area() {
        let shape = Shape {
            words: 44 * 1024,
            bits: 8,
            read_writes: 1,
            writes: 0,
            reads: 0,
        };
        let mm2 = area_um2(&shape) * 1e-6;
        assert_eq!(format!("{mm2:.4}"), "0.0388");
    }

    #[test]
    fn ports_make_a_cell_larger() {
        let of = |read_writes, writes, reads| {
            ports(&Shape {
                words: 1,
                bits: 1,
                read_writes,
                writes,
                reads,
            })
        };
        assert_eq!(
            [of(1, 0, 0), of(0, 1, 1), of(0, 1, 2), of(2, 0, 0)],
            [1.0, 1.3, 1.6, 2.0]
        );
    }
}
