//! Keeping the transfer that a baked file holds of what stands still in it, where nothing that moves stood near.

use std::f64::consts::TAU;
use std::sync::Arc;

use lobe_prt::{BakeOptions, Transfer};
use lobe_scene::{Mesh, Scene};
use lobe_sh::vector::{Vec3, dot, length, sub};

use crate::moving::kept_transfer::{KeptTransfer, row_width};
use crate::{Motion, MovingScene};

/// What moves may look as large as this in all where transfer is kept, in steradians: a thousandth of a hemisphere, as
/// [`ShadowFieldOptions`](lobe_shadow::ShadowFieldOptions) leaves out of shadows.
const NEGLIGIBLE: f64 = 1e-3 * TAU;

/// How many vertices keep their transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct KeptVertices {
    /// Those that keep it.
    pub kept: usize,
    /// All that stand still.
    pub still: usize,
}

/// A ball around what moves, as it stood when the file was baked.
struct Around {
    center: Vec3,
    radius: f64,
}

impl Around {
    /// The largest solid angle that it has above a horizon: `2π (1 - √(1 - (r/d)²))`, none from below, all from within.
    fn solid_angle(&self, p: Vec3, normal: Vec3) -> f64 {
        let to = sub(self.center, p);
        let distance = length(to);
        if distance <= self.radius {
            return 2.0 * TAU;
        }
        if dot(to, normal) <= -self.radius {
            return 0.0;
        }
        TAU * (1.0 - (1.0 - (self.radius / distance).powi(2)).sqrt())
    }
}

impl MovingScene {
    /// Keeps the transfer of a baked file for what stands still in it, with the shadows and the light of its parts among each other:
    /// of vertices from which what moves looked smaller than a thousandth of a hemisphere as it stood. The others would show its
    /// shadow where it is no more: they are baked by what stands still alone, with the options of the file.
    ///
    /// `transfer` is that of all vertices of the file and `options` those that made it. `None` and no change if it has not as many
    /// vertices as the scene, nothing stands still, or the scene is not that of one animated file.
    pub fn keep_transfer(&mut self, transfer: &Transfer, options: &BakeOptions) -> Option<KeptVertices> {
        let rest = self.animated_scene()?.rest().clone();
        if transfer.receivers() != rest.vertex_count() || !matches!(self.parts().first()?.motion, Motion::Still) {
            return None;
        }
        let mut moving = vec![false; rest.meshes().len()];
        for part in self.parts().iter().filter_map(|part| part.entity()) {
            moving[part.meshes()].fill(true);
        }
        let around: Vec<Around> =
            self.parts().iter().filter_map(|part| part.entity()).map(|e| around(&rest, e.meshes())).collect();
        let (mut rows, mut keeps, mut first) = (Vec::new(), Vec::new(), 0);
        let width = row_width(transfer);
        for (mesh, is_moving) in rest.meshes().iter().zip(moving) {
            let count = mesh.positions().len();
            if !is_moving {
                rows.extend_from_slice(&transfer.coefficients()[first * width..][..count * width]);
                keeps.extend(mesh.positions().iter().zip(mesh.normals()).map(|(p, n)| {
                    let (p, n) = (p.map(f64::from), n.map(f64::from));
                    around.iter().map(|around| around.solid_angle(p, n)).sum::<f64>() <= NEGLIGIBLE
                }));
            }
            first += count;
        }
        let still = &mut self.parts_mut()[0];
        if keeps.len() != still.scene.vertex_count() {
            return None;
        }
        let rows = Transfer::new(transfer.order(), transfer.channels(), rows).ok()?;
        let found = KeptVertices { kept: keeps.iter().filter(|keeps| **keeps).count(), still: keeps.len() };
        let kept = KeptTransfer { transfer: rows, keeps, options: options.clone() };
        if found.kept == found.still {
            (still.is_demodulated, still.transfer) = (kept.is_demodulated(), Some(Arc::new(kept.transfer)));
        } else {
            still.kept = Some(Arc::new(kept));
        }
        Some(found)
    }
}

/// A ball around some meshes of a scene.
fn around(scene: &Scene, meshes: std::ops::Range<usize>) -> Around {
    let points = || scene.meshes()[meshes.clone()].iter().flat_map(Mesh::positions).map(|p| p.map(f64::from));
    let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in points() {
        (min, max) = ([0, 1, 2].map(|k| min[k].min(p[k])), [0, 1, 2].map(|k| max[k].max(p[k])));
    }
    let center = [0, 1, 2].map(|k| 0.5 * (min[k] + max[k]));
    let radius = points().map(|p| length(sub(p, center))).fold(0.0, f64::max);
    Around { center, radius }
}
