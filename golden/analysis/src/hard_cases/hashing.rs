//! Forced collisions of a hash: the corners of a cell share entries.

use std::collections::BTreeMap;

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::rit::{RitEntry, Vertices};

use super::accumulators::gathering;
use super::{Case, Draws, Measuring, Worst, cases, ensure};
use potamoi_fields::Table;
use potamoi_reference::GatherTask;
use potamoi_reference::weights::trilinear;

cases! {
    "hashed tables";
    forced_collisions, "corners of a cell that hash to one entry", "";
}

fn forced_collisions(under: &Config) -> Measuring {
    let (twin, bits) = (gathering(under)?, under.gu.weight_bits);
    let one = f64::from(1u32 << bits);
    let mut draws = Draws(3);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    let mut shared = 0;
    for entries in [1, 2, 3, 4] {
        let codes: Vec<i16> = (0..entries)
            .map(|_| draws.between(-32_768.0, 32_767.0) as i16)
            .collect();
        let values = codes.iter().map(|c| f32::from(*c)).collect();
        let table = Table::hashed([33; 3], entries, 1, values)?;
        for _ in 0..500 {
            let cell = [0; 3].map(|_| draws.between(0.0, 31.0).floor());
            let fraction = [0; 3].map(|_| draws.between(0.0, 4096.0) as u16);
            let place = DVec3::from([0, 1, 2].map(|a| cell[a] + f64::from(fraction[a]) / 4096.0));
            // Rows of the corners, in the order of the weights.
            let (mut rows, mut count) = ([0u16; 8], 0);
            table.corners(place, |row, _| {
                rows[count] = row as u16;
                count += 1;
            });
            if count != 8 {
                continue;
            }
            let weights = trilinear(fraction, bits);
            let task = GatherTask {
                vertices: Vertices::Eight,
                channels: 1,
                rows: codes.clone(),
                entries: vec![RitEntry {
                    slot: 0,
                    rows,
                    weights,
                }],
            };
            let mut features = vec![];
            let flags = twin.gather(&task, &mut features)?;
            ensure(flags == 0, || format!("flags {flags:b}"))?;
            let terms = rows.iter().zip(weights);
            let exact: i64 = terms
                .clone()
                .map(|(r, w)| i64::from(w) * i64::from(codes[usize::from(*r)]))
                .sum();
            let exact = exact as f64 / one;
            ours.see(f64::from(features[0]) - exact);
            // A weight a row, the last one stays.
            let by_row: BTreeMap<u16, u16> = terms.map(|(r, w)| (*r, w)).collect();
            shared += u32::from(by_row.len() < 8);
            let sum: i64 = by_row
                .iter()
                .map(|(r, w)| i64::from(*w) * i64::from(codes[usize::from(*r)]))
                .sum();
            fails.see(sum as f64 / one - exact);
        }
    }
    ensure(shared > 1500, || format!("{shared} cells with collisions"))?;
    Ok(Case {
        naive: "a weight for each row, the last kept".into(),
        unit: "ulp of a 16-bit feature".into(),
        fails,
        bound: 0.5,
        from: "an exact sum, rounded once".into(),
        ours,
    })
}
