//! Methods of rendering a path's frames, for comparison.

use potamoi_base::camera::Camera;
use potamoi_warp::{
    Chain, Class, Frame, Plan, Sequence, Shaded, Target, WarpError, Warper, half_resolution,
};

/// Method of rendering frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Sparse radiance warping, from references.
    SpaRw,
    /// Each frame warped from the one before (Temp-N).
    Chained,
    /// Half the resolution, upscaled (DS-2).
    HalfResolution,
}

impl Method {
    /// Name in tables and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::SpaRw => "SpaRW",
            Self::Chained => "Temp",
            Self::HalfResolution => "DS-2",
        }
    }
}

/// A method with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodSettings {
    /// The method.
    pub method: Method,
    /// Window: frames of a reference, or of a chain.
    pub window: u32,
    /// Largest angle in degrees between the rays of a warped point; `None`: no limit.
    pub phi: Option<f64>,
    /// Index of the source of depth.
    pub depth: usize,
    /// Label that tells it from the others.
    pub name: String,
}

impl MethodSettings {
    /// All distinct combinations. At half the resolution nothing is warped, so windows, angles and
    /// depths count once. Without `phis` no angle is limited. `depths` are the names of the depths;
    /// at least one window and one depth are required.
    #[must_use]
    pub fn all(methods: &[Method], windows: &[u32], phis: &[f64], depths: &[String]) -> Vec<Self> {
        let mut combinations = vec![];
        for method in methods {
            let warps = *method != Method::HalfResolution;
            let phis: Vec<Option<f64>> = match phis.is_empty() {
                false if warps => phis.iter().copied().map(Some).collect(),
                _ => vec![None],
            };
            let first = |all: usize| if warps { all } else { all.min(1) };
            for window in &windows[..first(windows.len())] {
                for phi in &phis {
                    for (depth, of) in depths[..first(depths.len())].iter().enumerate() {
                        let mut name = method.name().to_owned();
                        if warps {
                            name += &format!("-{window}");
                        }
                        name += &phi.map_or_else(String::new, |phi| format!(", phi {phi}"));
                        if warps && depths.len() > 1 {
                            name += &format!(", {of}");
                        }
                        combinations.push(Self {
                            method: *method,
                            window: *window,
                            phi: *phi,
                            depth,
                            name,
                        });
                    }
                }
            }
        }
        combinations
    }

    /// The frames in order; the references in `lost` never arrive.
    #[must_use]
    pub fn frames<'a>(
        &self,
        warper: Warper<'a>,
        path: &'a [Camera],
        plan: &'a Plan,
        lost: &'a [usize],
    ) -> Box<dyn Iterator<Item = Result<Frame, WarpError>> + 'a> {
        match self.method {
            Method::SpaRw => Box::new(Sequence::new(warper, path, plan, lost)),
            Method::Chained => Box::new(Chain::new(warper, path, self.window)),
            Method::HalfResolution => {
                Box::new(path.iter().enumerate().map(move |(number, camera)| {
                    let picture = half_resolution(warper.renderer, camera)?;
                    let count = picture.rgb.len();
                    Ok(Frame {
                        number,
                        reference: None,
                        target: Target {
                            shaded: Shaded {
                                picture,
                                depth: vec![f32::NAN; count],
                            },
                            classes: vec![Class::Full; count],
                        },
                    })
                }))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At half the resolution one combination remains for all windows, angles and depths.
    #[test]
    fn ways_that_do_not_differ_are_one() {
        let depths = ["model", "mesh 256"].map(str::to_owned);
        let names = |methods: &[Method], phis: &[f64], depths: &[String]| -> Vec<String> {
            let all = MethodSettings::all(methods, &[6, 16], phis, depths);
            all.into_iter().map(|settings| settings.name).collect()
        };
        assert_eq!(
            names(&[Method::SpaRw, Method::HalfResolution], &[], &depths[..1]),
            ["SpaRW-6", "SpaRW-16", "DS-2"]
        );
        let all = names(&[Method::SpaRw, Method::Chained], &[1.0, 2.5], &depths);
        assert_eq!(all.len(), 16);
        assert_eq!(all[1], "SpaRW-6, phi 1, mesh 256");
        assert_eq!(
            names(&[Method::HalfResolution], &[1.0, 2.5], &depths),
            ["DS-2"]
        );
    }
}
