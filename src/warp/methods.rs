//! Arguments of the rendering methods to compare.

use crate::failure::Failure;
use clap::{Args, ValueEnum};
use potamoi_explore::warping::{Method, MethodSettings, Source};
use potamoi_warp::{Angle, PlanOptions, Profile, ReferenceFrom, Rule, Sampling, Scope};

/// What is compared, and by which rules.
#[derive(Debug, Args)]
pub(super) struct MethodArgs {
    /// Rendering method of the frames; several are compared side by side
    #[arg(
        long,
        value_name = "METHOD,...",
        value_enum,
        value_delimiter = ',',
        default_value = "sparw"
    )]
    method: Vec<MethodName>,
    /// Number of target frames warped from one reference [default: 16]
    #[arg(long, value_name = "N,...", value_delimiter = ',')]
    window: Vec<u32>,
    /// Maximum angle at a point between the rays of reference and target; pixels beyond it are
    /// rendered [default: no limit]
    #[arg(long, value_name = "DEG,...", value_delimiter = ',')]
    phi: Vec<f64>,
    /// Scope of rendering where the angle exceeds --phi
    #[arg(long, value_enum, default_value_t = PhiScope::Pixel)]
    phi_scope: PhiScope,
    /// Rules of warping: which pixels of a target are warped and which are rendered
    #[arg(long, value_enum, default_value_t = RulesOf::Potamoi)]
    profile: RulesOf,
    /// Angle that is compared with --phi [default: the profile's]
    #[arg(long, value_enum)]
    angle: Option<AngleOf>,
    /// Sampling of a reference's colours [default: the profile's]
    #[arg(long, value_enum)]
    sampling: Option<SamplingBy>,
    /// Whether pixels at edges of the reference are rendered [default: the profile's]
    #[arg(long, value_name = "true|false")]
    render_edges: Option<bool>,
    /// Whether cracks, pixels on which no point landed, are warped where the reference shows the
    /// surface there [default: the profile's]
    #[arg(long, value_name = "true|false")]
    fill_cracks: Option<bool>,
    /// Whether points that are warped onto empty background are kept [default: the profile's]
    #[arg(long, value_name = "true|false")]
    keep_over_void: Option<bool>,
    /// Depth threshold of disocclusion: a pixel is rendered where its depth is below this share of
    /// the warped depth [default: 0.995]
    #[arg(long, value_name = "SHARE")]
    nearer: Option<f64>,
    /// Pose of the references [default: predicted; centre for image sequences]
    #[arg(long, value_enum)]
    reference: Option<From>,
    /// Number of frames before its window at which rendering of a reference starts; 0: the paper's
    /// formula [default: the length of the window]
    #[arg(long, value_name = "N")]
    lead: Option<u32>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodName {
    /// Sparse radiance warping
    Sparw,
    /// Each frame warped from the previous one
    Temp,
    /// Half the resolution, upscaled
    Ds2,
}

impl std::convert::From<MethodName> for Method {
    fn from(name: MethodName) -> Self {
        match name {
            MethodName::Sparw => Self::SpaRw,
            MethodName::Temp => Self::Chained,
            MethodName::Ds2 => Self::HalfResolution,
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum PhiScope {
    /// That pixel
    Pixel,
    /// The whole frame
    Frame,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RulesOf {
    /// Bilinear sampling, cracks filled, edges rendered
    Potamoi,
    /// Nearest sampling; only disoccluded pixels are rendered
    Paper,
    /// As `paper`, with the first authors' half-angle
    FirstAuthors,
}

impl std::convert::From<RulesOf> for Profile {
    fn from(rules: RulesOf) -> Self {
        match rules {
            RulesOf::Potamoi => Self::Potamoi,
            RulesOf::Paper => Self::Paper,
            RulesOf::FirstAuthors => Self::FirstAuthors,
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum AngleOf {
    /// Angle between the two rays at the point
    Subtended,
    /// Half of that angle, as in the first authors' program
    Half,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum SamplingBy {
    /// Colour of the point that landed on the pixel, as in the paper
    Nearest,
    /// Interpolated at the pixel centre's place in the reference, among neighbours of the same
    /// surface
    Bilinear,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum From {
    /// Pose predicted for the middle of the window
    Predicted,
    /// Pose of the window's first frame
    First,
    /// Pose of the frame nearest the window's middle
    Centre,
}

impl MethodArgs {
    pub(super) fn longest_window(&self) -> u32 {
        self.windows().iter().copied().max().unwrap_or(1)
    }

    fn windows(&self) -> &[u32] {
        match self.window.as_slice() {
            [] => &[16],
            own => own,
        }
    }

    /// Refuses rules of warping where no method warps from references.
    pub(super) fn check(&self) -> Result<(), Failure> {
        if self.method.iter().any(|own| *own != MethodName::Ds2) {
            return Ok(());
        }
        let own = [
            ("--window", !self.window.is_empty()),
            ("--phi", !self.phi.is_empty()),
            ("--angle", self.angle.is_some()),
            ("--sampling", self.sampling.is_some()),
            ("--render-edges", self.render_edges.is_some()),
            ("--fill-cracks", self.fill_cracks.is_some()),
            ("--keep-over-void", self.keep_over_void.is_some()),
            ("--nearer", self.nearer.is_some()),
            ("--reference", self.reference.is_some()),
            ("--lead", self.lead.is_some()),
        ];
        match own.iter().find(|(_, is_given)| *is_given) {
            None => Ok(()),
            Some((flag, _)) => Err(Failure::Usage(format!(
                "{flag}: the method ds2 warps nothing: leave it out, or add --method sparw"
            ))),
        }
    }

    /// All distinct combinations requested. `depths` are the names of the depths.
    pub(super) fn settings(&self, depths: &[String]) -> Vec<MethodSettings> {
        let methods: Vec<Method> = self.method.iter().map(|name| (*name).into()).collect();
        MethodSettings::all(&methods, self.windows(), &self.phi, depths)
    }

    /// The rule of one method.
    pub(super) fn rule(&self, settings: &MethodSettings) -> Rule {
        let base = Profile::from(self.profile).rule();
        Rule {
            nearer: self.nearer.unwrap_or(base.nearer),
            phi: settings.phi.map(f64::to_radians),
            angle: match self.angle {
                Some(AngleOf::Subtended) => Angle::Subtended,
                Some(AngleOf::Half) => Angle::Half,
                None => base.angle,
            },
            scope: match self.phi_scope {
                PhiScope::Pixel => Scope::Pixel,
                PhiScope::Frame => Scope::Frame,
            },
            keep_over_void: self.keep_over_void.unwrap_or(base.keep_over_void),
            sampling: match self.sampling {
                Some(SamplingBy::Nearest) => Sampling::Nearest,
                Some(SamplingBy::Bilinear) => Sampling::Bilinear,
                None => base.sampling,
            },
            render_edges: self.render_edges.unwrap_or(base.render_edges),
            fill_cracks: self.fill_cracks.unwrap_or(base.fill_cracks),
            warps_still: base.warps_still,
        }
    }

    pub(super) fn plan(&self, settings: &MethodSettings, source: &Source) -> PlanOptions {
        let reference = match self.reference {
            Some(From::Predicted) => ReferenceFrom::Predicted,
            Some(From::First) => ReferenceFrom::First,
            Some(From::Centre) => ReferenceFrom::Centre,
            None => source.usual_reference(),
        };
        PlanOptions {
            window: settings.window,
            reference,
            lead: self.lead,
        }
    }
}
