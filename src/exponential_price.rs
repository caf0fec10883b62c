//! The price of exponentials by themselves: a row each, with the origin of every figure.

use std::fmt::Write as _;

use potamoi_explore::exponential::{Clocks, ExponentialPrice, Figure, SceneQuality};
use potamoi_synth::fit::Origin;

use crate::stdout::say;
use crate::tables;

/// Marks figures that are a ratio times those of a synthesised relative.
const RELATED: &str = "~";

/// Prints a row for each, and where figures come from.
pub(crate) fn print(prices: &[ExponentialPrice]) {
    let scenes: Vec<&SceneQuality> = prices.first().map_or(vec![], |p| p.scenes.iter().collect());
    let header = [
        "by itself",
        "um^2",
        "ps",
        "pJ",
        "clocks",
        "latency",
        "max ulp",
        "rms ulp",
        "max",
        "rms",
    ];
    let header = header.into_iter().map(str::to_owned);
    let header = header.chain(scenes.iter().map(|own| format!("{} dB", own.scene)));
    let mut rows = tables::plain(header.collect::<Vec<_>>());
    for price in prices {
        rows.add_row(row(price));
    }
    say!("{rows}");
    origins(prices, &scenes);
}

/// The cells of a row.
fn row(price: &ExponentialPrice) -> Vec<String> {
    let hardware = price.hardware.known();
    let mark = hardware.map_or("", |own| match own.origin {
        Origin::Synthesised => "",
        Origin::Ratio { .. } => RELATED,
    });
    let of = |digits: usize, value: Option<f64>| {
        value.map_or_else(|| "-".to_owned(), |v| format!("{mark}{v:.digits$}"))
    };
    let error = price.error.known();
    let plain = |value: Option<String>| value.unwrap_or_else(|| "-".to_owned());
    let mut cells = vec![
        price.name.clone(),
        of(0, hardware.map(|own| own.area_um2)),
        of(0, hardware.map(|own| own.period_ps)),
        of(2, hardware.map(|own| own.energy_pj)),
        clocks(&price.interval_clocks),
        clocks(&price.latency_clocks),
        plain(error.map(|own| format!("{:.4}", own.max_ulp))),
        plain(error.map(|own| format!("{:.4}", own.rms_ulp))),
        plain(error.map(|own| format!("{:.2e}", own.max))),
        plain(error.map(|own| format!("{:.2e}", own.rms))),
    ];
    let db = |own: &SceneQuality| plain(own.float_db.known().map(|db| format!("{db:.2}")));
    cells.extend(price.scenes.iter().map(db));
    cells
}

/// The mean, and the most where it is another.
fn clocks(own: &Clocks) -> String {
    match own.mean == own.most as f64 {
        true => own.most.to_string(),
        false => format!("{:.2} to {}", own.mean, own.most),
    }
}

/// Where figures come from, and why some are missing.
fn origins(prices: &[ExponentialPrice], scenes: &[&SceneQuality]) {
    let hardware = || prices.iter().filter_map(|own| own.hardware.known());
    if let Some(own) = hardware().next() {
        let related = hardware().any(|own| own.origin != Origin::Synthesised);
        let related = match related {
            true => format!(
                "; {RELATED}: of a synthesised block that differs in numbers alone, times the ratio that \
                 the fitted formulas give"
            ),
            false => String::new(),
        };
        say!(
            "um^2 and ps of the block, pJ of an exponential where one follows the other, by synthesis: \
             cells at {} nm without wires, scaled from {} nm{related}",
            own.node_nm,
            own.from_nm
        );
    }
    say!(
        "clocks from an operand to the next, latency from an operand to its power, by the cycle model: \
         the mean over all operands to the most"
    );
    if let Some(own) = prices.iter().find_map(|own| own.error.known()) {
        let operands = match prices {
            [_] => format!("all {} operands", own.operands),
            _ => "all operands".to_owned(),
        };
        say!(
            "errors of {operands}, by the reference unit against values of 120 bits: largest and root mean \
             square, in units of the last place (ulp) and as values"
        );
    }
    if let Some(own) = scenes.first() {
        say!(
            "dB: PSNR of pictures of {} x {} pixels in the hardware's formats with this exponential, beside \
             floating point of 64 bits",
            own.size[0],
            own.size[1]
        );
    }
    for (what, why, names) in unknown(prices) {
        say!("no {what} of {}: {why}", names.join("; "));
    }
}

/// Figures that are missing, why, and in which rows.
fn unknown(prices: &[ExponentialPrice]) -> Vec<(&'static str, &str, Vec<&str>)> {
    let mut all: Vec<(&str, &str, Vec<&str>)> = vec![];
    for price in prices {
        let block = [
            ("um^2, ps and pJ", price.hardware.unknown()),
            ("errors", price.error.unknown()),
        ];
        let scenes = price
            .scenes
            .iter()
            .map(|own| ("dB", own.float_db.unknown()));
        let own = block.into_iter().chain(scenes);
        for (what, why) in own.filter_map(|(what, why)| Some((what, why?))) {
            match all
                .iter_mut()
                .find(|known| (known.0, known.1) == (what, why))
            {
                Some((.., names)) if names.last() == Some(&&*price.name) => {}
                Some((.., names)) => names.push(&price.name),
                None => all.push((what, why, vec![&price.name])),
            }
        }
    }
    all
}

/// The rows as CSV; names and reasons, which contain commas, are quoted; unknown figures are empty.
pub(crate) fn csv(prices: &[ExponentialPrice]) -> String {
    let mut text = String::from(
        "name,form,origin,node_nm,area_um2,period_ps,energy_pj,interval_clocks,interval_clocks_most,\
         latency_clocks,latency_clocks_most,operands,ulp,max_ulp,rms_ulp,max,rms",
    );
    for own in prices.first().map_or(&[][..], |own| &own.scenes) {
        text += &format!(",{}_float_db", own.scene);
    }
    text += "\n";
    for price in prices {
        let hardware = match &price.hardware {
            Figure::Unknown { .. } => ",,,,".to_owned(),
            Figure::Known(own) => {
                let origin = match &own.origin {
                    Origin::Synthesised => "synthesised".to_owned(),
                    Origin::Ratio { to } => format!("ratio to {to}").replace('"', "\"\""),
                };
                format!(
                    "\"{origin}\",{},{},{},{}",
                    own.node_nm, own.area_um2, own.period_ps, own.energy_pj
                )
            }
        };
        let error = match &price.error {
            Figure::Unknown { .. } => ",,,,,".to_owned(),
            Figure::Known(own) => format!(
                "{},{},{},{},{},{}",
                own.operands, own.ulp, own.max_ulp, own.rms_ulp, own.max, own.rms
            ),
        };
        let (interval, latency) = (price.interval_clocks, price.latency_clocks);
        // Writing to a string does not fail.
        let _ = write!(
            text,
            "\"{}\",{},{hardware},{},{},{},{},{error}",
            price.name,
            price.form.name(),
            interval.mean,
            interval.most,
            latency.mean,
            latency.most
        );
        for own in &price.scenes {
            let db = own
                .float_db
                .known()
                .map_or_else(String::new, f64::to_string);
            let _ = write!(text, ",{db}");
        }
        text += "\n";
    }
    text
}
