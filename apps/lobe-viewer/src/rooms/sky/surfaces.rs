//! Surfaces of the shapes before a sky: smooth, bumpy or self-mirroring mirrors, rough and matte ones.

use lobe::figures::{Bumped, Exhibit, ExhibitSolid, Shading, SurfacePoint, Torus, TracedMirror, bumps};
use lobe::render::{Camera, View};
use lobe::sh::{Dir, Rgb, Rotation};

/// Rows and columns of the points at which errors are measured.
const MEASURED: usize = 48;

/// The height and the number of the bumps.
const BUMPS: [f64; 2] = [0.02, 14.0];

/// The most reflections of a ring in itself.
const BOUNCES: usize = 4;

/// The radii of the ring: of the circle in the middle of its tube, and of the tube.
const RING: [f64; 2] = [0.7, 0.3];

/// Polar angle and azimuth of its axis: leaning towards an eye that looks along +x, so that its far side is mirrored in the near one.
const AXIS: [f64; 2] = [0.75, 2.8];

/// What a shape is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Surface {
    Mirror,
    /// A mirror whose normals are perturbed.
    Bumpy,
    /// A ring, which mirrors itself.
    Ring,
    Glossy,
    /// A matte part and highlights.
    Highlights,
    Matte,
}

impl Surface {
    /// All of them; their rows have this order.
    pub(crate) const ALL: [Self; 6] =
        [Self::Mirror, Self::Bumpy, Self::Ring, Self::Glossy, Self::Highlights, Self::Matte];

    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Mirror => "Mirrors",
            Self::Bumpy => "Mirrors with bumps",
            Self::Ring => "Mirrors in the shape of a ring",
            Self::Glossy => "Glossy: GGX of α = 0.3",
            Self::Highlights => "Matte with highlights: Phong of s = 30",
            Self::Matte => "Matte",
        }
    }

    /// Its shape.
    pub(crate) fn solid(self) -> ExhibitSolid {
        match self {
            Self::Ring => ExhibitSolid::Torus(ring()),
            _ => ExhibitSolid::Ball { radius: 1.0 },
        }
    }

    /// The relief through which its expansion is looked up.
    pub(crate) fn relief(self) -> Relief {
        if self == Self::Bumpy { Relief::Bumps } else { Relief::Smooth }
    }

    /// The points at which errors are measured, seen along +x.
    fn measured_points(self) -> Vec<SurfacePoint> {
        let camera = Camera::perspective(View::ALONG_X, 4.0, 0.3);
        Exhibit { solid: self.solid(), camera, samples: 1 }.points(MEASURED, MEASURED)
    }
}

/// The light of a surface at the points where errors are measured.
pub(crate) fn values(surface: Surface, shading: &dyn Shading) -> Vec<Rgb<f32>> {
    surface.measured_points().iter().map(|point| shading.radiance(point)).collect()
}

fn ring() -> Torus {
    Torus { axis: Dir::from_angles(AXIS[0], AXIS[1]), major: RING[0], minor: RING[1] }
}

/// The small shape of a surface, by which its rays are led before they leave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relief {
    Smooth,
    Bumps,
    /// Rays meet the ring again.
    Traced,
}

/// A technique under a sky that is turned, on a surface that is not.
pub(crate) struct Turned<'a> {
    pub(crate) shading: &'a dyn Shading,
    pub(crate) relief: Relief,
    pub(crate) back: Rotation,
}

impl<'a> Turned<'a> {
    /// The same in the frame of the sky.
    pub(crate) fn at_rest(shading: &'a dyn Shading, relief: Relief) -> Self {
        Self { shading, relief, back: Rotation::IDENTITY }
    }

    /// The light of the turned sky at a point.
    fn smooth(&self, at: &SurfacePoint) -> Rgb<f32> {
        let [normal, view] = [at.normal, at.view].map(|s| self.back.rotate_dir(s));
        self.shading.radiance(&SurfacePoint { normal, view, ..*at })
    }
}

impl Shading for Turned<'_> {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        match self.relief {
            Relief::Smooth => self.smooth(at),
            Relief::Bumps => {
                let inner = |at: &SurfacePoint| self.smooth(at);
                Bumped { inner, height: bumps(BUMPS[0], BUMPS[1]) }.radiance(at)
            }
            Relief::Traced => {
                // A point that is seen along its normal mirrors that direction.
                let source = |r: Dir| self.smooth(&SurfacePoint { normal: r, view: r, ..*at });
                TracedMirror { source, solid: ExhibitSolid::Torus(ring()), bounces: BOUNCES }.radiance(at)
            }
        }
    }
}

/// `Σ|a - b| / Σ|b|`: not squared, for where a map shows the sun one point in a thousand would decide alone.
pub(crate) fn mean_error(found: &[Rgb<f32>], truth: &[Rgb<f32>]) -> f64 {
    let channels = |c: &Rgb<f32>| [c.r, c.g, c.b].map(f64::from);
    let sum = |all: &mut dyn Iterator<Item = [f64; 3]>| all.flatten().map(f64::abs).sum::<f64>();
    let apart = found.iter().zip(truth).map(|(a, b)| {
        let (a, b) = (channels(a), channels(b));
        std::array::from_fn(|k| a[k] - b[k])
    });
    sum(&mut apart.into_iter()) / sum(&mut truth.iter().map(channels)).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light that differs in every direction.
    fn sky(s: Dir) -> Rgb<f32> {
        Rgb::from(s.to_array().map(|c| 1.0 + c as f32))
    }

    #[test]
    fn bumps_and_reflections_stay_with_the_surface_while_the_sky_turns() {
        let mirror = |at: &SurfacePoint| sky(at.reflected());
        let back = Rotation::from_axis_angle(Dir::Y, 0.7);
        let turned_mirror = |at: &SurfacePoint| sky(back.rotate_dir(at.reflected()));
        for (surface, relief) in [(Surface::Bumpy, Relief::Bumps), (Surface::Ring, Relief::Traced)] {
            let turned = Turned { shading: &mirror, relief, back };
            let expected = Turned::at_rest(&turned_mirror, relief);
            for at in surface.measured_points() {
                let (found, expected) = (turned.radiance(&at), expected.radiance(&at));
                let apart = (found - expected).to_array().into_iter().fold(0.0_f32, |most, c| most.max(c.abs()));
                assert!(apart < 1e-5, "{surface:?} at {at:?}: {found:?}, expected {expected:?}");
            }
        }
    }

    #[test]
    fn only_a_ring_mirrors_itself_and_only_bumps_are_rough() {
        let mirror = |at: &SurfacePoint| sky(at.reflected());
        let of = |surface, relief| values(surface, &Turned::at_rest(&mirror, relief));
        for (surface, relief) in [(Surface::Ring, Relief::Traced), (Surface::Bumpy, Relief::Bumps)] {
            let error = mean_error(&of(surface, Relief::Smooth), &of(surface, relief));
            assert!(error > 0.01, "{surface:?}: {error}");
        }
    }
}
