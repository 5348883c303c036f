//! Keeping the transfer that a baked file holds of what stands still in it, where nothing that moves stood near.

use std::f64::consts::TAU;
use std::sync::Arc;

use lobe_prt::{AlbedoMode, BakeOptions, BakedTransfer, Transfer};
use lobe_scene::{AnimatedScene, Mesh, ScenePose};
use lobe_sh::sphere::vector::{Vec3, dot, length, sub};

use crate::baked::kept_transfer::{KeptTransfer, row_width};
use crate::scene::moving_part::Motion;
use crate::scene::moving_scene::MovingScene;

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
    /// Those of them that the file was baked with in other places or with other normals than they stand in: another
    /// animation, a skin or morph targets changed their mesh. None of these keeps its transfer.
    pub reshaped: usize,
}

/// A vertex that moved by less than this part of the radius of its mesh did not move: matrices of joints that undo each
/// other leave a rounding of `f32`.
const SAME_PLACE: f64 = 1e-5;

/// Normals that differ by less than this length did not turn: 0.06 degrees, above their rounding in compressed files.
const SAME_NORMAL: f64 = 1e-3;

/// A ball around what hides the sky in another place than where the file was baked, or did so then.
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

/// What is not, or will not stay, as a file was baked.
struct Changes {
    /// Of each mesh of the file, whether it moves.
    is_moving: Vec<bool>,
    /// Of each mesh of the file, whether it stands in another shape than it was baked in.
    is_reshaped: Vec<bool>,
    around: Vec<Around>,
}

impl Changes {
    /// Those of the scene of an animated file that was baked in a pose.
    fn of(moving: &MovingScene, animated: &AnimatedScene, pose: &ScenePose) -> Option<Self> {
        let baked = animated.posed_as(pose).ok()?;
        let baked = baked.meshes();
        let posed = animated.rest_pose().ok()?;
        let standing = posed.scene().meshes();
        let mut is_moving = vec![false; baked.len()];
        let mut around = Vec::new();
        for part in moving.parts().iter().filter_map(|part| part.entity()) {
            is_moving[part.meshes()].fill(true);
            around.push(ball(&baked[part.meshes()]));
        }
        let is_reshaped: Vec<bool> = baked.iter().zip(standing).map(|(a, b)| !is_alike(a, b)).collect();
        for k in (0..baked.len()).filter(|k| is_reshaped[*k] && !is_moving[*k]) {
            around.extend([baked, standing].map(|meshes| ball(&meshes[k..=k])));
        }
        Some(Self { is_moving, is_reshaped, around })
    }
}

impl MovingScene {
    /// Keeps what suits of the transfer that a file holds, see [`MovingScene::keep_transfer`], if it is as asked: of
    /// `order` bands at least, of `bounces` reflections. What is not kept, and why, is a note for the user.
    pub fn keep_baked(
        &mut self,
        baked: &BakedTransfer,
        order: Option<usize>,
        bounces: Option<usize>,
    ) -> Option<String> {
        let BakedTransfer { recipe, transfer, .. } = baked;
        let options = recipe.bake_options();
        let not_used = if recipe.straight_through == Some(true) {
            "light goes straight through surfaces in it".to_owned()
        } else if order.is_some_and(|order| order > transfer.order()) {
            format!("it has {} bands, fewer than are asked for", transfer.order())
        } else if bounces.is_some_and(|bounces| bounces != options.bounces) {
            format!("it has {} reflections, not those that are asked for", options.bounces)
        } else {
            match self.keep_transfer(transfer, &options, &recipe.pose()) {
                Some(KeptVertices { kept, still, .. }) if kept == still => return None,
                Some(KeptVertices { kept, still, reshaped }) if reshaped > 0 => {
                    return Some(format!(
                        "{kept} of {still} vertices that stand still keep their transfer; another animation, skins or morph targets give {reshaped} of \
                         the others another shape than they were baked in: these, and what is near them or near what moves, are \
                         baked as they stand"
                    ));
                }
                Some(KeptVertices { kept, still, .. }) => {
                    return Some(format!(
                        "{kept} of {still} vertices that stand still keep their transfer; the others are near what moves, whose \
                         shadow was baked into them: they are baked without it"
                    ));
                }
                None => "nothing in it stands still".to_owned(),
            }
        };
        Some(format!("its transfer is not used: {not_used}; all parts are baked"))
    }

    /// Keeps the transfer of a baked file for what stands still in it, with the shadows and the light of its parts
    /// among each other.
    ///
    /// A vertex keeps its transfer if moving parts looked smaller from it than a thousandth of a hemisphere in the
    /// baked pose. The others would show a shadow where it is no more. They are baked by what stands still alone,
    /// with the options of the file.
    ///
    /// A mesh may stand in another shape than in the baked pose: by another animation, skins or morph targets. It
    /// counts as one that moved from the one shape to the other. Its own vertices are baked anew, and so are others
    /// that see much of either.
    ///
    /// `transfer` is that of all vertices of the file, `options` those that made it, and `pose` where things stood
    /// then. `None` and no change if it has not as many vertices as the scene, nothing stands still, or the scene is
    /// not that of one animated file.
    pub fn keep_transfer(
        &mut self,
        transfer: &Transfer,
        options: &BakeOptions,
        pose: &ScenePose,
    ) -> Option<KeptVertices> {
        let animated = self.animated_scene()?;
        let rest = animated.rest();
        if transfer.receivers() != rest.vertex_count() || !matches!(self.parts().first()?.motion, Motion::Still) {
            return None;
        }
        let Changes { is_moving, is_reshaped, around } = Changes::of(self, animated, pose)?;
        let (mut rows, mut keeps, mut reshaped, mut first) = (Vec::new(), Vec::new(), 0, 0);
        let width = row_width(transfer);
        for (k, mesh) in rest.meshes().iter().enumerate() {
            let count = mesh.positions().len();
            if !is_moving[k] {
                rows.extend_from_slice(&transfer.coefficients()[first * width..][..count * width]);
                keeps.extend(mesh.positions().iter().zip(mesh.normals()).map(|(p, n)| {
                    let (p, n) = (p.map(f64::from), n.map(f64::from));
                    !is_reshaped[k] && around.iter().map(|around| around.solid_angle(p, n)).sum::<f64>() <= NEGLIGIBLE
                }));
                reshaped += if is_reshaped[k] { count } else { 0 };
            }
            first += count;
        }
        let still = &mut self.parts_mut()[0];
        if keeps.len() != still.scene.vertex_count() {
            return None;
        }
        let rows = Transfer::new(transfer.order(), transfer.channels(), rows).ok()?;
        let found = KeptVertices { kept: keeps.iter().filter(|keeps| **keeps).count(), still: keeps.len(), reshaped };
        let kept = KeptTransfer { transfer: rows, keeps, options: options.clone() };
        if found.kept == found.still {
            still.is_demodulated = kept.options.albedo == AlbedoMode::None;
            (still.transfer, still.paths) = (Some(Arc::new(kept.transfer)), Some(kept.options));
        } else {
            still.kept = Some(Arc::new(kept));
        }
        Some(found)
    }
}

/// Whether two meshes of the same vertices are the same surface, but for rounding.
fn is_alike(baked: &Mesh, standing: &Mesh) -> bool {
    let differ = |a: &[[f32; 3]], b: &[[f32; 3]], most: f64| {
        a.iter().zip(b).any(|(a, b)| length(sub(a.map(f64::from), b.map(f64::from))) > most)
    };
    let Around { center, radius } = ball(std::slice::from_ref(baked));
    // Coordinates far from the origin are rounded to their own size.
    let largest_place = SAME_PLACE * radius + f64::from(f32::EPSILON) * (length(center) + radius);
    !differ(baked.positions(), standing.positions(), largest_place)
        && !differ(baked.normals(), standing.normals(), SAME_NORMAL)
}

/// A ball around some meshes of a scene.
fn ball(meshes: &[Mesh]) -> Around {
    let points = || meshes.iter().flat_map(Mesh::positions).map(|p| p.map(f64::from));
    let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in points() {
        (min, max) = ([0, 1, 2].map(|k| min[k].min(p[k])), [0, 1, 2].map(|k| max[k].max(p[k])));
    }
    let center = [0, 1, 2].map(|k| 0.5 * (min[k] + max[k]));
    let radius = points().map(|p| length(sub(p, center))).fold(0.0, f64::max);
    Around { center, radius }
}
