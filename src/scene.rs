//! The scene of a command.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use clap::Args;
use potamoi_base::effects::Choices;
use potamoi_base::file_keys::told_within;
use potamoi_gaussians::{Axes, files};
use potamoi_scene::{BUILTIN, Representation, Scene, file_formats, scenes_named};

use crate::args::{Common, quoted};
use crate::failure::Failure;
use crate::stdout::prose;

/// Kinds of scenes, for help.
fn scenes() -> String {
    scene_help(DEFAULT)
}

/// As [`scenes`], with another default.
pub(crate) fn scene_help(default: &str) -> String {
    let fields = file_formats::field_files()
        .map(|(name, endings)| format!("{name} (.{})", endings.join(", .")));
    format!(
        "Built-in scene ({}; each but the first two also as a ready model behind a colon, such as \
         cairn:ngp: {}; of the originals' sizes: {}), splat model (.{}), Compact-3DGS model (.npz), model file of a field: \
         {}; or description (.toml) [default: {default}]",
        BUILTIN.join(", "),
        Representation::ALL.map(Representation::name).join(", "),
        Representation::FULL_SIZE
            .map(Representation::name)
            .join(", "),
        files::endings().join(", ."),
        fields.collect::<Vec<_>>().join(", "),
    )
}

#[derive(Debug, Args)]
pub(crate) struct SceneArgs {
    #[arg(long, value_name = "SCENE", help = scenes())]
    pub(crate) scene: Option<String>,
    /// Camera file in the OpenCV convention [default: the scene's own camera]
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    /// Index of the camera in the file, from 0
    #[arg(long, value_name = "N", default_value_t = 0, requires = "camera")]
    camera_index: usize,
    /// Width of the picture [default: the scene's]
    #[arg(long, value_name = "PIXELS")]
    width: Option<u32>,
    /// Height of the picture [default: in proportion to the width]
    #[arg(long, value_name = "PIXELS")]
    height: Option<u32>,
    /// Directions of x, y and z in a splat file, such as right-down-front or right-up-back; the
    /// model and its harmonics are rotated, cameras are not [default: those of the file or its
    /// format]
    #[arg(long, value_name = "AXES")]
    axes: Option<Axes>,
    /// Effects to compute even where the scene does not call for them, or `all` (`potamoi effects`
    /// lists them); the result does not change [default: none]
    #[arg(long, value_name = "EFFECT,...", value_delimiter = ',')]
    force: Vec<String>,
    /// Effects to leave out even where the scene calls for them; the result changes [default: none]
    #[arg(long, value_name = "EFFECT,...", value_delimiter = ',')]
    without: Vec<String>,
}

/// Scenes of a command that takes several; each with its own camera.
#[derive(Debug, Args)]
pub(crate) struct ManyScenes {
    #[arg(long, value_name = "SCENE,...", value_delimiter = ',', help = scenes())]
    scene: Vec<String>,
    /// Width of the picture [default: the scene's]
    #[arg(long, value_name = "PIXELS")]
    width: Option<u32>,
    /// Height of the picture [default: in proportion to the width]
    #[arg(long, value_name = "PIXELS")]
    height: Option<u32>,
}

impl ManyScenes {
    /// Opens all of them with their own rules, whatever the machines are.
    pub(crate) fn open(&self) -> Result<Vec<Scene>, Failure> {
        let default = [DEFAULT.to_owned()];
        match self.scene.is_empty() {
            true => self.open_named(&default),
            false => self.open_named(&self.scene),
        }
    }

    /// Opens those that are named; a size without a scene is refused.
    pub(crate) fn open_given(&self) -> Result<Vec<Scene>, Failure> {
        let sides = [("width", self.width), ("height", self.height)];
        let side = sides.iter().find(|(_, side)| side.is_some());
        if let (true, Some((name, _))) = (self.scene.is_empty(), side) {
            return Err(Failure::Usage(format!(
                "--{name}: with --rivals, expected with --scene: the inputs of --rivals have fixed sizes, and \
                 --scene adds one of this size"
            )));
        }
        self.open_named(&self.scene)
    }

    fn open_named(&self, names: &[String]) -> Result<Vec<Scene>, Failure> {
        let mut all = vec![];
        for name in scenes_named(names) {
            let mut scene = Scene::open(&name)?;
            scene.set_size(self.width, self.height)?;
            note(&scene);
            all.push(scene);
        }
        Ok(all)
    }
}

/// Longest printed sentence in characters; `--json` has it in full.
const TOLD: usize = 2000;

/// Items that opened files leave open, and whether each was printed.
static LEFT_OPEN: Mutex<Vec<(String, bool)>> = Mutex::new(vec![]);

fn left_open() -> MutexGuard<'static, Vec<(String, bool)>> {
    LEFT_OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Records the items that a scene's files leave open, so that every command reports them.
pub(crate) fn note(scene: &Scene) {
    let mut all = left_open();
    for sentence in scene.left_open_of_files() {
        if all.iter().all(|(known, _)| *known != sentence) {
            all.push((sentence, false));
        }
    }
}

/// Items that the files opened by this command leave open.
pub(crate) fn left_open_of_files() -> Vec<String> {
    let all = left_open();
    all.iter().map(|(sentence, _)| sentence.clone()).collect()
}

/// Says why all pairs are listed although the configuration asks for fewer.
pub(crate) fn say_all_pairs(why: &str) {
    prose!(
        2,
        "rit.pairs = \"that-may-count\" leaves out no pair of tile and Gaussian: {why}"
    );
}

/// Prints one line on unchecked items, if there are any.
pub(crate) fn say_not_checked(list: &[String]) {
    for (sentence, said) in left_open().iter_mut() {
        *said |= list.contains(sentence);
    }
    if !list.is_empty() {
        let told: Vec<_> = list.iter().map(|s| told_within(s, TOLD)).collect();
        prose!(2, "not checked: {}", told.join("; "));
    }
}

/// Prints the items that no report has printed.
pub(crate) fn say_what_is_left_open() {
    let all = left_open();
    let rest = all.iter().filter(|(_, said)| !said);
    let rest: Vec<String> = rest.map(|(sentence, _)| sentence.clone()).collect();
    drop(all);
    say_not_checked(&rest);
}

/// Effects of paths and outside the units, which a frame cannot leave out.
const OF_PATHS: [&str; 4] = ["warping", "disocclusion", "remote_link", "random_dram"];

/// Default scene.
const DEFAULT: &str = "garden";

impl SceneArgs {
    /// Opens the scene with the render settings of the machine that was asked for.
    pub(crate) fn open(&self, common: &Common) -> Result<Scene, Failure> {
        self.open_named(self.name(), common)
    }

    /// Opens another scene with the same options.
    pub(crate) fn open_named(&self, name: &str, common: &Common) -> Result<Scene, Failure> {
        let mut scene = self.open_as_called_for(name, common)?;
        if let Some(effect) = self
            .without
            .iter()
            .find(|own| OF_PATHS.contains(&own.as_str()))
        {
            return Err(Failure::Usage(format!(
                "--without {effect}: expected an effect of a frame; potamoi effects --without \
                 shows what leaving this one out changes, and potamoi model --variants and \
                 --scenario model paths without it"
            )));
        }
        scene.set_choices(self.choices_over(scene.choices())?);
        note(&scene);
        Ok(scene)
    }

    /// Opens a scene without the effects that the command line forces or leaves out.
    pub(crate) fn open_as_called_for(&self, name: &str, common: &Common) -> Result<Scene, Failure> {
        let mut scene = self.open_plain(name)?;
        common.machine()?.prepare(&mut scene)?;
        Ok(scene)
    }

    /// Opens a scene with its own rules, whatever the machine is.
    pub(crate) fn open_plain(&self, name: &str) -> Result<Scene, Failure> {
        let mut scene = match &self.camera {
            Some(path) => Scene::open_seen_from(name, self.axes, path, self.camera_index)?,
            None => Scene::open_in(name, self.axes)?,
        };
        scene.set_size(self.width, self.height)?;
        note(&scene);
        Ok(scene)
    }

    /// Effects that are forced or left out.
    pub(crate) fn choices(&self) -> Result<Choices, Failure> {
        self.choices_over(Choices::default())
    }

    /// Those choices, with effects that are forced or left out.
    fn choices_over(&self, mut choices: Choices) -> Result<Choices, Failure> {
        if let Some(both) = self.force.iter().find(|name| self.without.contains(name)) {
            return Err(Failure::Usage(format!(
                "--force {both} and --without {both}: expected one of them"
            )));
        }
        for name in &self.force {
            choices = (Choices::named(name)?.into_iter()).fold(choices, Choices::force);
        }
        for name in &self.without {
            choices = (Choices::named(name)?.into_iter()).fold(choices, Choices::leave_out);
        }
        Ok(choices)
    }

    /// Whether a camera or a size other than the scene's own is requested.
    pub(crate) const fn looks_otherwise(&self) -> bool {
        self.camera.is_some() || self.width.is_some() || self.height.is_some()
    }

    /// The first flag that asks for another camera or size, if there is one.
    pub(crate) fn looks_otherwise_by(&self) -> Option<&'static str> {
        let all = [
            ("--camera", self.camera.is_some()),
            ("--width", self.width.is_some()),
            ("--height", self.height.is_some()),
        ];
        all.into_iter()
            .find(|(_, is_given)| *is_given)
            .map(|(flag, _)| flag)
    }

    /// Axes that override a file's.
    pub(crate) const fn axes(&self) -> Option<Axes> {
        self.axes
    }

    pub(crate) fn name(&self) -> &str {
        self.scene.as_deref().unwrap_or(DEFAULT)
    }

    /// How the scene is named on a command line.
    pub(crate) fn arguments(&self) -> String {
        let mut text = format!(" --scene {}", quoted(Path::new(self.name())));
        // Writing to a string does not fail.
        if let Some(path) = &self.camera {
            let _ = write!(text, " --camera {}", quoted(path));
        }
        if self.camera_index != 0 {
            let _ = write!(text, " --camera-index {}", self.camera_index);
        }
        if let Some(axes) = self.axes {
            let _ = write!(text, " --axes {axes}");
        }
        for (name, effects) in [("force", &self.force), ("without", &self.without)] {
            if !effects.is_empty() {
                let _ = write!(text, " --{name} {}", effects.join(","));
            }
        }
        for (name, side) in [("width", self.width), ("height", self.height)] {
            if let Some(side) = side {
                let _ = write!(text, " --{name} {side}");
            }
        }
        text
    }
}
