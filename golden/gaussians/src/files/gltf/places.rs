//! Where the nodes of a scene place their meshes.

use glam::{DMat3, DMat4, DQuat};

use super::super::error::{FileError, Origin};
use super::document::{Document, Node};
use crate::cloud::Placement;

/// Largest departure from a rotation and one scale: some digits of 32-bit floats.
const CLOSE: f64 = 1e-5;

/// A mesh in the scene.
#[derive(Debug)]
pub(super) struct Shown {
    /// The node that shows it.
    pub(super) node: usize,
    pub(super) mesh: usize,
    transform: DMat4,
}

/// All meshes that the scene shows, in the order of its nodes.
pub(super) fn shown(document: &Document, name: Origin<'_>) -> Result<Vec<Shown>, FileError> {
    let nodes = &document.nodes;
    let mut is_seen = vec![false; nodes.len()];
    let mut next: Vec<(usize, DMat4)> = (document.roots.iter().rev())
        .map(|own| (*own, DMat4::IDENTITY))
        .collect();
    let mut all = vec![];
    while let Some((index, above)) = next.pop() {
        let found = nodes.get(index).zip(is_seen.get_mut(index));
        let Some((node, is_seen)) = found else {
            let expected = format!("below {}, the number of nodes", nodes.len());
            return Err(name.field("index of a node", index, expected));
        };
        if std::mem::replace(is_seen, true) {
            let expected = "once: nodes form a tree";
            return Err(name.field(format!("nodes[{index}]"), "reached twice", expected));
        }
        let transform = above * node.transform;
        if let Some(mesh) = node.mesh {
            let meshes = document.meshes.len();
            if mesh >= meshes {
                let expected = format!("below {meshes}, the number of meshes");
                return Err(name.field(format!("nodes[{index}].mesh"), mesh, expected));
            }
            all.push(Shown {
                node: index,
                mesh,
                transform,
            });
        }
        next.extend(node.children.iter().rev().map(|own| (*own, transform)));
    }
    Ok(all)
}

impl Shown {
    /// The node.
    pub(super) fn node<'a>(&self, document: &'a Document) -> Option<&'a Node> {
        document.nodes.get(self.node)
    }

    /// Its place as a rotation, one scale and a translation.
    pub(super) fn placement(&self, name: Origin<'_>) -> Result<Placement, FileError> {
        let refused = |what: &str| {
            let field = format!("transform of nodes[{}], with those above it", self.node);
            let expected = "a rotation, one scale above 0 and a translation: apply the transform to the \
                            Gaussians before export";
            name.field(field, what, expected)
        };
        let all = self.transform.to_cols_array();
        if all.iter().any(|v| !v.is_finite()) {
            return Err(refused("not finite"));
        }
        if [all[3], all[7], all[11], all[15]] != [0.0, 0.0, 0.0, 1.0] {
            return Err(refused("a projection"));
        }
        let translation = self.transform.w_axis.truncate();
        let linear = DMat3::from_mat4(self.transform);
        if linear == DMat3::IDENTITY {
            return Ok(Placement {
                scale: 1.0,
                rotation: DQuat::IDENTITY,
                translation,
            });
        }
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let scale = linear.determinant().abs().cbrt();
        if scale == 0.0 || !scale.is_finite() {
            return Err(refused("flat, with a scale of 0"));
        }
        let lengths = [x, y, z].map(|own| own.length() / scale - 1.0);
        let angles = [x.dot(y), y.dot(z), z.dot(x)].map(|own| own / scale.powi(2));
        if lengths.iter().chain(&angles).any(|off| off.abs() > CLOSE) {
            return Err(refused("a stretch or a shear"));
        }
        if linear.determinant() < 0.0 {
            return Err(refused("a mirror"));
        }
        // What rounding leaves is no scale.
        let scale = if (scale - 1.0).abs() < CLOSE / 100.0 {
            1.0
        } else {
            scale
        };
        Ok(Placement {
            scale,
            rotation: DQuat::from_mat3(&linear.mul_scalar(1.0 / scale)).normalize(),
            translation,
        })
    }
}
