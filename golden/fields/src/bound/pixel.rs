//! Error bounds of pixels from those of their samples.

use glam::DVec3;

use super::gathered::gathered;
use super::{Bounds, ErrorInterval, UnitErrors};
use crate::samples::Samples;
use crate::volume::Ray;
use crate::{Field, FixedOptions, Sampling};
use potamoi_march::{BACKGROUND, pixel_bits};

/// The data for following a pixel's ray.
pub(super) struct Follower<'a> {
    pub(super) field: &'a dyn Field,
    pub(super) bounds: &'a dyn Bounds,
    pub(super) sampling: Sampling,
    pub(super) errors: UnitErrors,
    pub(super) weight_bits: u32,
    pub(super) options: &'a FixedOptions,
}

/// A ray, followed up to some sample.
struct Followed {
    /// Transmittance in floating point.
    left: f64,
    /// Upper bound of the effect of opacity errors on the pixel, or on the transmittance.
    reach: f64,
    /// Upper bound of the effect of rounding the transmittance.
    rounded: f64,
    /// Upper bound of the effect of colour errors.
    colours: f64,
    /// Weights of samples without colour: in floating point, and possible ones in fixed point.
    hidden: [f64; 2],
    /// Upper bound of the number of composited samples.
    seen: u32,
}

/// Features of a sample with their errors.
struct Sample {
    places: Vec<DVec3>,
    features: Vec<f64>,
    off: Vec<ErrorInterval>,
}

impl Follower<'_> {
    /// Upper bound of the error of a pixel's channels, for a ray and its counterpart in the
    /// fixed-point renderer.
    pub(super) fn bound(&self, ray: &Samples, other: Option<Ray>) -> f64 {
        let mut own = Followed {
            left: 1.0,
            reach: 0.0,
            rounded: 0.0,
            colours: 0.0,
            hidden: [0.0; 2],
            seen: 0,
        };
        let mut sample = Sample {
            places: vec![DVec3::ZERO; self.field.tables().len()],
            features: vec![0.0; self.field.channels()],
            off: vec![ErrorInterval::default(); self.field.channels()],
        };
        let stop = self.sampling.stop;
        let count = other.map_or(0, |other| u64::from(other.samples));
        let mut apart = 0.0;
        for k in 0..ray.count.max(count) {
            let at = ray.at(k);
            let is_here = k < ray.count && self.field.holds(at);
            let is_there = match other {
                None => is_here,
                Some(other) => k < count && self.bounds.holds(other.at(k as u32)),
            };
            if !is_here && !is_there {
                continue;
            }
            self.gather(at, other.map(|other| other.at(k as u32)), &mut sample);
            self.add(&sample, [is_here, is_there], ray.direction, &mut own);
            if own.left < stop {
                // The other may have stopped before, or go on.
                apart = (own.left + own.reach + own.rounded).max(stop);
                break;
            }
        }
        if apart == 0.0 && self.options.terminate && own.left - own.reach - own.rounded < stop {
            apart = stop;
        }
        let behind = self.options.background;
        let brightest = behind.iter().fold(1.0, |m, v| f64::max(m, f64::from(*v)));
        // Products are rounded, and so is the background, and the picture to 24 bits.
        let products =
            f64::from(own.seen) * 2f64.powi(-1 - pixel_bits(self.errors.result_bits) as i32);
        let written = brightest * 2f64.powi(-23) + BACKGROUND.ulp() / 2.0;
        let moved = brightest * (own.reach + own.rounded + apart)
            + own.colours
            + own.hidden[0].max(own.hidden[1]);
        // Both pictures lie between nothing and the brightest.
        moved.min(brightest) + products + written
    }

    /// Adds the next sample, which one of the renderers may skip.
    fn add(
        &self,
        sample: &Sample,
        [is_here, is_there]: [bool; 2],
        towards: DVec3,
        own: &mut Followed,
    ) {
        let Sample { features, off, .. } = sample;
        let (least, least_weight) = (self.sampling.least_opacity, self.sampling.least_weight);
        let exact = -(-self.field.depth(features)).exp_m1();
        let most = self.bounds.alpha(features, off);
        let is_shown = is_here && exact > least;
        let alpha = if is_shown { exact } else { 0.0 };
        // Codes are compared with the code below the limit.
        let unit = 2f64.powi(-(self.errors.result_bits as i32));
        let is_shown_there = is_there && exact + most > least - unit;
        let moved = match (is_shown, is_shown_there) {
            (false, false) => return,
            _ if is_here != is_there => exact + most,
            (true, true) if exact - most > least => most,
            // What one of them leaves out is close to the limit.
            _ => most + exact.min(least),
        };
        let before = own.reach + own.rounded;
        own.seen += 1;
        own.reach += own.left * moved;
        own.rounded += self.unit();
        let weight = own.left * alpha;
        let weight_off = own.left * moved + (alpha + moved) * before + self.unit();
        if weight <= least_weight {
            own.hidden[0] += weight;
        } else {
            own.colours += weight * self.bounds.colour(features, off, towards).min(1.0);
        }
        if weight - weight_off <= least_weight {
            own.hidden[1] += (weight + weight_off).min(least_weight);
        }
        own.left *= 1.0 - alpha;
    }

    /// One unit of the transmittance.
    fn unit(&self) -> f64 {
        2f64.powi(-(self.options.transmittance_bits as i32))
    }

    /// Gathers features at a world point, with their errors at the fixed-point renderer's
    /// position.
    fn gather(&self, at: DVec3, there: Option<DVec3>, sample: &mut Sample) {
        let Sample {
            places,
            features,
            off,
        } = sample;
        self.field.place(at, places);
        let (mut features, mut off) = (&mut features[..], &mut off[..]);
        let tables = self.field.tables().iter().zip(self.bounds.frac_bits());
        for ((table, bits), place) in tables.zip(places) {
            let (own, rest) = features.split_at_mut(table.channels());
            let (own_off, rest_off) = off.split_at_mut(table.channels());
            table.gather(*place, own);
            let there = there.unwrap_or(*place);
            gathered(table, bits, self.weight_bits, there, own, own_off);
            (features, off) = (rest, rest_off);
        }
    }
}
