//! Ray-traced mirrors: the reference that environment mapping approximates.

use lobe_sh::{Dir, Rgb};

use crate::gallery::exhibit::{Shading, SurfacePoint};
use crate::gallery::solid::ExhibitSolid;
use lobe_sh::sphere::vector::{add, scale};

/// The offset of a reflected ray from its surface, in units of the shape: more than a hit is wrong by, and less than
/// any distance between two parts of a shape.
const START: f64 = 1e-7;

/// A perfect mirror that follows its reflected ray into the surroundings themselves.
///
/// ```text
///   L(p, v) = source(r)                         if the ray from p along r leaves the shape, or no bounces are left
///           = L(p', -r) with one bounce less    if it meets the shape again at p'
/// ```
///
/// Without bounces this is what every technique of environment mapping approximates: the reference of their errors.
/// With bounces a torus mirrors itself, which none of them can show. A ball never does.
#[derive(Clone, Copy, Debug)]
pub struct TracedMirror<F> {
    /// The light from every direction.
    pub source: F,
    /// The shape that may be met again.
    pub solid: ExhibitSolid,
    /// The most bounces.
    pub bounces: usize,
}

impl<F: Fn(Dir) -> Rgb<f32> + Sync> Shading for TracedMirror<F> {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        let mut at = *at;
        for _ in 0..self.bounces {
            let r = at.reflected();
            let Some(t) = self.solid.hit(at.position, r, START) else { break };
            let position = add(at.position, scale(r.to_array(), t));
            at = SurfacePoint { position, normal: self.solid.normal(position), view: -r };
        }
        (self.source)(at.reflected())
    }
}

#[cfg(test)]
mod tests {
    use lobe_sh::Coefficient;

    use super::*;
    use crate::gallery::exhibit::{Exhibit, compare_shadings};
    use crate::gallery::torus::Torus;
    use lobe_render::{Camera, View};

    #[test]
    fn a_ball_never_mirrors_itself_and_a_torus_does() {
        let source = |s: Dir| Rgb::new(s.x() as f32, s.y() as f32, s.z() as f32);
        let torus = Torus { axis: Dir::new([-0.6, 0.2, 0.7]).unwrap(), major: 0.7, minor: 0.3 };
        for (solid, mirrors_itself) in [(ExhibitSolid::Ball { radius: 1.0 }, false), (ExhibitSolid::Torus(torus), true)]
        {
            let scene = Exhibit { solid, camera: Camera::orthographic(View::ALONG_X, 1.2), samples: 1 };
            let points = scene.points(50, 50);
            let mirror = |bounces| TracedMirror { source, solid, bounces };
            let report = compare_shadings(&points, &mirror(0), &mirror(5));
            assert_eq!(report.rmse > 0.01, mirrors_itself, "{solid:?}: {report:?}");
        }
    }

    #[test]
    fn any_number_of_bounces_keeps_an_even_light() {
        let torus = ExhibitSolid::Torus(Torus { axis: Dir::Z, major: 0.7, minor: 0.3 });
        let scene = Exhibit { solid: torus, camera: Camera::orthographic(View::three_quarter(), 1.2), samples: 1 };
        let mirror = TracedMirror { source: |_| Rgb::splat(0.5), solid: torus, bounces: 20 };
        for p in scene.points(40, 40) {
            assert_eq!(mirror.radiance(&p), Rgb::splat(0.5), "a mirror loses nothing, at {p:?}");
        }
    }
}
