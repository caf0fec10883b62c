//! Where each figure of the page comes from.

use std::path::Path;

use super::asked::Asked;
use super::document::{Origin, SceneFound};
use crate::args::quoted;

/// The figures, each with its origin and the command that gives it by itself.
pub(super) fn of(asked: &Asked<'_>, scenes: &[SceneFound]) -> Vec<Origin> {
    let found = || {
        scenes
            .iter()
            .flat_map(|own| &own.machines)
            .filter_map(|own| own.more.as_ref())
    };
    let names: Vec<String> = asked
        .scenes
        .iter()
        .map(|own| quoted(Path::new(own.name())))
        .collect();
    let machines: Vec<String> = (asked.machines.iter())
        .map(|own| quoted(Path::new(&own.name)))
        .collect();
    let size = asked.scenes.first().map_or_else(String::new, |own| {
        format!(
            " --width {} --height {}",
            own.camera().width,
            own.camera().height
        )
    });
    let (scene, scenes_of) = (names.first().cloned().unwrap_or_default(), names.join(","));
    let named = asked
        .machines
        .first()
        .is_some_and(|own| own.hardware.is_some());
    let config = match (named, machines.first()) {
        (true, Some(machine)) => format!(" --config {machine}"),
        _ => String::new(),
    };
    let frames = asked.frames;
    let words = |of: &mut dyn Iterator<Item = String>| {
        let mut all: Vec<String> = vec![];
        of.for_each(|own| {
            if !all.contains(&own) {
                all.push(own);
            }
        });
        all.join("; ")
    };
    let clock = words(&mut found().map(|own| own.clock.origin.word().to_owned()));
    let slowest = words(&mut found().filter_map(|own| {
        let block = own.clock.blocks.first()?;
        Some(format!("{} ({})", block.block, block.from))
    }));
    let energy = words(&mut found().map(|own| own.energy_origin.clone()));
    let area =
        words(&mut found().flat_map(|own| own.area.blocks.iter().map(|own| own.from.clone())));
    let row = |figure, origin: &str, how: String, command: Option<String>| Origin {
        figure,
        origin: origin.to_owned(),
        how,
        command,
    };
    let compare = format!(
        "potamoi compare {} --scene {scenes_of}{size} --frames {frames}",
        match named {
            true => machines.join(" "),
            false => "paper".to_owned(),
        }
    );
    let (mut proved, mut unproved) = (0, vec![]);
    for own in found() {
        match own.proof.why() {
            None => proved += 1,
            Some(why) => unproved.push(why.to_owned()),
        }
    }
    let why = words(&mut unproved.into_iter());
    let verified = "the Verilog, run by Verilator, beside the golden models: every bit and cycle of a \
                    share of the frame's work, spread evenly";
    let verified = match (proved, why.as_str()) {
        (_, "") => ("measured", verified.to_owned()),
        (0, why) => ("-", format!("nothing: {why}")),
        (_, why) => ("measured", format!("{verified}; some was not: {why}")),
    };
    vec![
        row(
            "frames a second, milliseconds",
            "cycle model",
            "cycles of the units by cycle models that verification compares with the RTL; the GPU's \
             kernels at two bounds by published rates; a schedule of the path's jobs"
                .to_owned(),
            Some(compare.clone()),
        ),
        row("clock", &clock, format!("slowest block: {slowest}"), Some(compare)),
        row("energy", "fitted, published", energy, Some(format!(
            "potamoi model --scene {scene}{size} --frames {frames}{config}"
        ))),
        row("area", "synthesis", area, Some(format!(
            "potamoi model --scene {scene}{size} --frames {frames}{config}"
        ))),
        row(
            "PSNR",
            "measured",
            "pictures by the reference units, bit for bit those of the RTL, in unquantised linear RGB"
                .to_owned(),
            Some(format!(
                "potamoi render --scene {scene}{size}{config} --quality --out picture.png"
            )),
        ),
        row(
            "what was verified",
            verified.0,
            verified.1,
            Some(format!("potamoi verify --scene {scene}{size}{config}")),
        ),
        row(
            "accuracy against time",
            "cycle model",
            "each setting of each knob rendered by reference units and timed by the cycle models".to_owned(),
            Some(format!("potamoi cost --scene {scene}{size}{config} --frames {frames}")),
        ),
        row(
            "effects",
            "cycle model",
            "counted by the reference units and their cycle models".to_owned(),
            Some(format!(
                "potamoi effects --scene {scene}{size}{config} --frames {frames} --pairs 0"
            )),
        ),
        row(
            "GPU's rates and power, link, interconnect",
            "published, assumed",
            "device files with the source of each figure; docs/explanation/trust.md has their errors"
                .to_owned(),
            None,
        ),
        row(
            "the paper's figures",
            "published",
            "arXiv 2408.06608, as docs/explanation/beside-the-paper.md lists them".to_owned(),
            None,
        ),
    ]
}
