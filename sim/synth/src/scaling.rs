//! Scaling between technology nodes by published factors.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Scaling factors from one node to another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Factors {
    /// Publication of the factors.
    pub table: String,
    /// Source node in nanometres.
    pub from_nm: u32,
    /// Target node in nanometres.
    pub to_nm: u32,
    /// Factor of area.
    pub area: f64,
    /// Factor of delay.
    pub delay: f64,
    /// Factor of energy an operation.
    pub energy: f64,
    /// Factor of leakage, where the table has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub leakage: Option<f64>,
}

/// Logic: area, delay and energy from the paper's own source, at the nodes' nominal voltages; 12 nm
/// is interpolated between its columns of 14 and 10 nm.
const LOGIC: &str = "Stillmaker and Baas, Integration 58 (2017), interpolated at 12 nm";
/// Memories: cells shrink less than logic.
const MEMORY: &str = "hwcomponents-cacti 1.0.40 below 22 nm: area and time as the node, energy as its \
                      root, leakage 0.79 of that (FinFET)";

const LOGIC_FACTORS: [(u32, u32, [f64; 3]); 3] = [
    (7, 12, [2.29, 1.26, 1.86]),
    (16, 12, [0.71, 0.61, 0.74]),
    (45, 12, [0.135, 0.30, 0.085]),
];

/// Factors of logic, if known.
#[must_use]
pub fn logic(from_nm: u32, to_nm: u32) -> Option<Factors> {
    let known = LOGIC_FACTORS.iter();
    let (.., [area, delay, energy]) = known.clone().find(|f| (f.0, f.1) == (from_nm, to_nm))?;
    Some(Factors {
        table: LOGIC.to_owned(),
        from_nm,
        to_nm,
        area: *area,
        delay: *delay,
        energy: *energy,
        leakage: None,
    })
}

/// Factors of memories to a smaller node, if known.
#[must_use]
pub fn memory(from_nm: u32, to_nm: u32) -> Option<Factors> {
    if to_nm == 0 || to_nm > from_nm {
        return None;
    }
    let ratio = f64::from(to_nm) / f64::from(from_nm);
    Some(Factors {
        table: MEMORY.to_owned(),
        from_nm,
        to_nm,
        area: ratio,
        delay: ratio,
        energy: ratio.sqrt(),
        leakage: Some(0.79 * ratio.sqrt()),
    })
}

/// Pairs of nodes that [`logic`] knows, for messages.
#[must_use]
pub fn known() -> String {
    let pairs: Vec<_> = LOGIC_FACTORS
        .iter()
        .map(|(from, to, _)| format!("{from} to {to}"))
        .collect();
    pairs.join(", ")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn factors_are_those_of_their_tables() {
        let logic = logic(7, 12).unwrap();
        assert_eq!((logic.area, logic.delay, logic.energy), (2.29, 1.26, 1.86));
        assert_eq!(logic.leakage, None);
        let [larger, largest] = [16, 45].map(|nm| super::logic(nm, 12).unwrap());
        assert_eq!(
            (larger.area, larger.delay, larger.energy),
            (0.71, 0.61, 0.74)
        );
        assert_eq!(
            (largest.area, largest.delay, largest.energy),
            (0.135, 0.30, 0.085)
        );
        assert_eq!(super::logic(180, 12), None);
        assert!(known().contains("7 to 12"));
        let memory = memory(22, 11).unwrap();
        assert_eq!((memory.area, memory.delay), (0.5, 0.5));
        assert!((memory.energy - 0.5f64.sqrt()).abs() < 1e-15);
        assert!((memory.leakage.unwrap() - 0.79 * 0.5f64.sqrt()).abs() < 1e-15);
        assert_eq!(super::memory(22, 45), None);
        assert_eq!(super::memory(22, 0), None);
    }
}
