//! The pictures in the documents are those of the program.

use super::root;
use crate::common::expect;

/// The pictures in the documents are those of today's renderer. Codes may
/// differ by one where floating point differs between machines.
#[test]
fn pictures_in_the_documents_are_current() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["garden", "lantern"] {
        expect(
            folder.path(),
            0,
            &["render", "--scene", scene, "--out", "p.png"],
        );
        let kept = root().join(format!("docs/images/{scene}.png"));
        let [kept, now] =
            [kept, folder.path().join("p.png")].map(|p| image::open(p).unwrap().to_rgb8());
        assert_eq!(kept.dimensions(), now.dimensions());
        let far = kept
            .iter()
            .zip(now.iter())
            .filter(|(a, b)| a.abs_diff(**b) > 1)
            .count();
        assert!(
            far * 1000 < kept.len(),
            "{scene}: {far} codes differ: make refresh renders them again"
        );
    }
}
