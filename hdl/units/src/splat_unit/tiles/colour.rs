//! Sums of colours: stages 8 to 12.

use potamoi_netlist::{Instance, IrErrors, ModuleBuilder, Signal, Ty};

use super::Pair;
use crate::splat_unit::drain::{Drain, Port};
use crate::splat_unit::formats::COLOUR_SUM;
use crate::splat_unit::product::product_of;
use crate::splat_unit::registers::moved;

/// Channels, the highest bits first.
const CHANNELS: [u32; 3] = [2, 1, 0];

/// Adds `T - T'` times the colour to the sums of the pixel. Returns whether pairs are in the last stages.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn sums(
    m: &mut ModuleBuilder,
    stages: &[Pair],
    weight: Signal,
    (memory, drain): (Instance, &Drain),
) -> Result<[Signal; 3], IrErrors> {
    m.section("Colour");
    let always = m.lit(1, Ty::bit());
    stages[9].take(m, stages[8], stages[8].valid, always);
    let weight = moved(m, "weight_9", weight, always);
    let mut added = vec![];
    for channel in CHANNELS {
        let colour = m.slice(stages[9].colour, 16 * channel, 16);
        let name = format!("channel_{channel}");
        let product = product_of(m, &name, (colour, weight), always)?;
        added.push(m.slice(product, 0, COLOUR_SUM));
    }
    let added = m.cat(&added);
    let added = moved(m, "added_11", added, always);
    let added = moved(m, "added_12", added, always);
    let read = m.out(memory, "rdata");
    let sums = moved(m, "sums", read, always);
    let (mut valid, mut pixel) = (stages[9].valid, stages[9].pixel);
    let late = [10, 11, 12].map(|stage| {
        let own = m.reg(&format!("valid_{stage}"), Ty::bit(), 0);
        m.set_next(own, valid);
        let place = moved(m, &format!("pixel_{stage}"), pixel, always);
        (valid, pixel) = (own, place);
        (own, place)
    });
    let [(reads, read_at), _, (writes, write_at)] = late;
    let words = CHANNELS.map(|i| {
        let [sum, own] = [sums, added].map(|all| m.slice(all, COLOUR_SUM * i, COLOUR_SUM));
        m.add(sum, own)
    });
    let port = Port {
        reads,
        read_at,
        writes,
        write_at,
        word: m.cat(&words),
    };
    drain.connect(m, memory, &port, 0);
    Ok(late.map(|(valid, _)| valid))
}
