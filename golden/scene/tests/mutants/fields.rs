//! Checkpoints and snapshots of fields.

use std::io::{Read as _, Write as _};
use std::path::Path;
use std::sync::Arc;

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::GzEncoder;
use potamoi_fields::Field;
use potamoi_scene::{Model, Scene};

use crate::frame::tree::Tree;
use crate::frame::{Format, Rng, Verdict, pickle};
use crate::pictures::{picture, single};

/// Bounds in order, finite values, and a picture.
fn judge(path: &Path) -> Verdict {
    Verdict::of(Scene::open(&path.to_string_lossy()), |scene| {
        match scene.model() {
            Model::Field(field) => sampled(&**field)?,
            other => return Err(format!("it is {}", other.algorithm())),
        }
        picture(scene)
    })
}

fn sampled(field: &dyn Field) -> Result<(), String> {
    let [low, high] = field.sampling().bounds;
    if !(low.is_finite() && high.is_finite() && low.cmplt(high).all()) {
        return Err(format!("its bounds are {low} and {high}"));
    }
    let values = field.tables().iter().flat_map(|table| table.values());
    match values.copied().find(|v| !v.is_finite()) {
        Some(value) => Err(format!("a table has {value}")),
        None => Ok(()),
    }
}

const DVGO: &[u8] = include_bytes!("../../../tests/fixtures/dvgo/tiny.tar");
const TENSORF: &[u8] = include_bytes!("../../../tests/fixtures/tensorf/tiny.th");
const NGP: &[u8] = include_bytes!("../../../tests/fixtures/ngp/cube.ingp");

/// What a ZLIB stream holds.
fn unpacked() -> Vec<u8> {
    let mut bytes = vec![];
    let read = ZlibDecoder::new(NGP).read_to_end(&mut bytes);
    read.expect("a whole file");
    bytes
}

fn mutated_messages(rng: &mut Rng) -> Vec<u8> {
    let mut tree = Tree::of_messages(&unpacked());
    (0..rng.few()).for_each(|_| tree.mutate(rng));
    let mut bytes = tree.messages();
    if rng.one_in(25) {
        rng.damage(&mut bytes);
    }
    bytes
}

fn mutated_ingp(rng: &mut Rng) -> Vec<u8> {
    let mut out = GzEncoder::new(vec![], Compression::fast());
    out.write_all(&mutated_messages(rng))
        .expect("memory takes it");
    let mut out = out.finish().expect("memory takes it");
    if rng.one_in(25) {
        rng.damage(&mut out);
    }
    out
}

pub(crate) fn formats() -> Vec<Format> {
    let one = |name,
               file: &'static str,
               whole: fn() -> Vec<u8>,
               mutant: fn(&mut Rng) -> Vec<u8>| Format {
        name,
        binary: super::BINARY,
        whole: Arc::new(move || single(file, whole())),
        mutant: Arc::new(move |rng| single(file, mutant(rng))),
        judge,
    };
    vec![
        one(
            "dvgo",
            "a.tar",
            || DVGO.to_vec(),
            |rng| pickle::torch(DVGO, rng),
        ),
        one(
            "tensorf",
            "a.th",
            || TENSORF.to_vec(),
            |rng| pickle::torch(TENSORF, rng),
        ),
        one("ingp", "a.ingp", || NGP.to_vec(), mutated_ingp),
        one("msgpack", "a.msgpack", unpacked, mutated_messages),
    ]
}
