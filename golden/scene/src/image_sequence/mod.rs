//! Image sequences with depth: frames that were captured or rendered elsewhere, as input for
//! warping.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use image::{ImageFormat, ImageReader};

use super::description::{
    CameraDescription, Description, ImagesDescription, ModelDescription, RenderDescription,
};
use super::transforms::{self, PathFrame};
use super::{SceneError, picture_files};
use potamoi_base::camera::Camera;
use potamoi_base::file_keys::Notes;
use potamoi_base::files;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;
use potamoi_warp::{Geometry, Renderer, Shaded, VOID_BELOW, WarpError, is_void};

/// The largest image file, in bytes.
const LIMIT: u64 = 1 << 29;

/// Unused parts of the files read so far. They are not part of the identity of a sequence.
#[derive(Debug, Clone, Default)]
struct Heard(Arc<Mutex<Notes>>);

impl PartialEq for Heard {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Heard {
    fn add(&self, notes: Notes) {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .extend(notes);
    }

    fn all(&self) -> Notes {
        let notes = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        notes.clone()
    }
}

/// An image sequence. Frames are read on demand.
#[derive(Debug, Clone, PartialEq)]
pub struct Images {
    name: String,
    folder: PathBuf,
    description: ImagesDescription,
    frames: Vec<PathFrame>,
    background: [f32; 3],
    heard: Heard,
}

impl Images {
    /// Opens the sequence of a description; `None` if the description has another model, or if the
    /// name is not that of a description.
    ///
    /// # Errors
    /// The description or its camera path is invalid.
    pub fn open(name: &str) -> Result<Option<Self>, SceneError> {
        let path = Path::new(name);
        if path
            .extension()
            .is_none_or(|e| !e.eq_ignore_ascii_case("toml"))
        {
            return Ok(None);
        }
        let description = Description::read(path)?;
        let ModelDescription::Images(images) = description.model else {
            return Ok(None);
        };
        let wrong = |message: &str| SceneError::Description {
            path: path.to_owned(),
            message: message.to_owned(),
        };
        let (scale, void) = (images.depth_scale, images.void_above);
        for (field, value, is_right) in [
            ("depth_scale", scale, scale > 0.0 && scale.is_finite()),
            ("void_above", void, void > 0.0),
        ] {
            if !is_right {
                let message =
                    format!("field `model.{field}` is {value}: expected a positive number");
                return Err(wrong(&message));
            }
        }
        if description.camera != CameraDescription::Default {
            let message = "section `[camera]`: an image sequence has the cameras of its \
                           transforms.json: leave it out";
            return Err(wrong(message));
        }
        let mut others = description.render;
        let background = others.background.take();
        if others != RenderDescription::default() {
            let message = "section `[render]`: of an image sequence `background` alone counts: \
                           leave the others out";
            return Err(wrong(message));
        }
        let background = background.unwrap_or_default();
        if !background.iter().all(|v| v.is_finite()) {
            return Err(wrong("field `render.background`: expected finite numbers"));
        }
        let folder = path.parent().unwrap_or(Path::new("")).join(&images.path);
        let heard = Heard::default();
        let mut notes = Notes::default();
        let cameras = folder.join("transforms.json");
        let frames = transforms::read(&cameras, &mut notes)?;
        heard.add(notes.of_file(&cameras));
        Ok(Some(Self {
            name: name.to_owned(),
            folder,
            description: images,
            frames,
            background,
            heard,
        }))
    }

    /// Unused parts of the files read so far, and assumptions.
    #[must_use]
    pub fn left_open(&self) -> Vec<String> {
        self.heard.all().sentences()
    }

    /// Name of the sequence.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The cameras of the first `frames` frames.
    ///
    /// # Errors
    /// The sequence has fewer frames.
    pub fn path(&self, frames: usize) -> Result<Vec<Camera>, SceneError> {
        match self.frames.get(..frames) {
            Some(all) => Ok(all.iter().map(|f| f.camera).collect()),
            None => Err(SceneError::Value {
                scene: self.name.clone(),
                field: "frames",
                value: frames.to_string(),
                expected: format!("at most {}, as the sequence has", self.frames.len()),
            }),
        }
    }

    /// Number of frames.
    #[must_use]
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether there are no frames.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    fn frame(&self, camera: &Camera) -> Result<&PathFrame, WarpError> {
        let frame = self.frames.iter().find(|f| f.camera == *camera);
        frame.ok_or_else(|| WarpError::NotTaken {
            sequence: self.name.clone(),
        })
    }

    fn read(
        &self,
        path: &Path,
        camera: &Camera,
        depth: bool,
    ) -> Result<image::DynamicImage, SceneError> {
        let fail = |message: String| SceneError::Description {
            path: path.to_owned(),
            message,
        };
        let bytes = files::read(path, LIMIT).map_err(|source| SceneError::Read {
            path: path.to_owned(),
            source,
        })?;
        let bytes = bytes.ok_or_else(|| fail(format!("expected at most {LIMIT} bytes")))?;
        let mut notes = Notes::default();
        match depth {
            true => picture_files::exr(&bytes, &mut notes).map_err(fail)?,
            false => picture_files::png(&bytes, &mut notes).map_err(fail)?,
        }
        let what = if depth { "depths: " } else { "pictures: " };
        self.heard.add(notes.under(what));
        let mut reader = ImageReader::new(std::io::Cursor::new(bytes));
        reader.set_format(if depth {
            ImageFormat::OpenExr
        } else {
            ImageFormat::Png
        });
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(camera.width);
        limits.max_image_height = Some(camera.height);
        reader.limits(limits);
        let wanted = (camera.width, camera.height);
        let what = if depth {
            "an OpenEXR depth"
        } else {
            "a PNG picture"
        };
        let expected = format!("expected {what} of {} x {} pixels", wanted.0, wanted.1);
        let image = reader
            .decode()
            .map_err(|e| fail(format!("{e}; {expected}")))?;
        let found = (image.width(), image.height());
        if found != wanted {
            return Err(fail(format!(
                "{} x {} pixels: {expected}",
                found.0, found.1
            )));
        }
        Ok(image)
    }

    fn image(&self, frame: &PathFrame) -> Result<image::Rgba32FImage, SceneError> {
        let mut path = self.folder.join(&frame.picture).into_os_string();
        if !has_ending(&frame.picture) {
            path.push(".png");
        }
        Ok(self
            .read(Path::new(&path), &frame.camera, false)?
            .into_rgba32f())
    }

    /// The picture over the background.
    fn picture(&self, frame: &PathFrame) -> Result<Picture, SceneError> {
        let image = self.image(frame)?;
        let over = |pixel: &image::Rgba<f32>| {
            let [r, g, b, a] = pixel.0;
            let [br, bg, bb] = self.background.map(|v| v * (1.0 - a));
            [r * a + br, g * a + bg, b * a + bb]
        };
        Ok(Picture {
            width: frame.camera.width,
            height: frame.camera.height,
            rgb: image.pixels().map(over).collect(),
        })
    }

    /// Depths. Pixels that are void by depth but not transparent, as at the soft edge of a
    /// picture, become unknown.
    fn depth_of(&self, frame: &PathFrame) -> Result<Vec<f32>, SceneError> {
        let clear = self.image(frame)?;
        let mut depths = self.stored_depth(frame)?;
        for (depth, pixel) in depths.iter_mut().zip(clear.pixels()) {
            if is_void(*depth) && f64::from(pixel.0[3]) >= VOID_BELOW {
                *depth = f32::NAN;
            }
        }
        Ok(depths)
    }

    /// Depths as in the file. Those behind the camera become unknown.
    fn stored_depth(&self, frame: &PathFrame) -> Result<Vec<f32>, SceneError> {
        // A stem may hold dots: `frame.0001.png` has the depth `frame.0001.exr`.
        let stem = match has_ending(&frame.picture) {
            true => frame.picture.file_stem(),
            false => frame.picture.file_name(),
        };
        let mut name = stem.unwrap_or_default().to_owned();
        name.push(".exr");
        let folder = self.folder.join(&self.description.depth);
        let path = folder.join(name);
        let image = self.read(&path, &frame.camera, true)?.into_rgb32f();
        let scaled = image.pixels().map(|pixel| {
            let depth = f64::from(pixel.0[0]) * self.description.depth_scale;
            if depth > self.description.void_above {
                f32::INFINITY
            } else if depth < 0.0 {
                f32::NAN
            } else {
                depth as f32
            }
        });
        Ok(scaled.collect())
    }
}

/// Whether a picture's name has a file extension: the number of `frame.0001` is none.
fn has_ending(picture: &Path) -> bool {
    let ending = picture.extension().unwrap_or_default().to_string_lossy();
    !ending.bytes().all(|b| b.is_ascii_digit())
}

impl Renderer for Images {
    fn background(&self) -> [f32; 3] {
        self.background
    }

    fn bounds(&self) -> Option<[DVec3; 2]> {
        None
    }

    fn shade(&self, camera: &Camera, only: Option<&Mask>) -> Result<Shaded, WarpError> {
        let frame = self.frame(camera)?;
        let mut shaded = Shaded {
            picture: self.picture(frame)?,
            depth: self.depth_of(frame)?,
        };
        if let Some(mask) = only {
            let pixels = shaded.picture.rgb.iter_mut().zip(&mut shaded.depth);
            for (_, (rgb, depth)) in pixels.enumerate().filter(|(i, _)| !mask.has(*i)) {
                *rgb = self.background;
                *depth = f32::INFINITY;
            }
        }
        Ok(shaded)
    }
}

impl Geometry for Images {
    fn depth(&self, camera: &Camera) -> Result<Vec<f32>, WarpError> {
        Ok(self.depth_of(self.frame(camera)?)?)
    }
}

#[cfg(test)]
mod tests;
