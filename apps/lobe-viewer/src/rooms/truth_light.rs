//! The light of a truth: the sky itself and lamps, on a grid from which paths draw directions.

use std::f64::consts::PI;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use lobe::env::{EnvError, EnvMap, MappedMap, Mapping, Resample, resample};
use lobe::io::Job;
use lobe::render::DistantLight;
use lobe::sh::{Coefficient as _, Dir, Rgb, Rotation};

/// Rows of the light: texels of a third of a degree, so that a sun is several of them wide.
const ROWS: usize = 512;

/// A disc of light far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Disc {
    pub(crate) dir: Dir,
    /// Half its angle, in radians.
    pub(crate) half_angle: f64,
    /// The radiance that a white surface facing it reflects.
    pub(crate) color: [f64; 3],
}

/// A sky and its texels on the grid.
type Kept = (Weak<MappedMap>, Arc<EnvMap>);

/// The last sky on the grid, which a camera that moves needs again.
#[derive(Clone, Default)]
pub(crate) struct SkyGrid(Arc<Mutex<Option<Kept>>>);

impl SkyGrid {
    /// The texels of a sky, of which each part has the energy that it has in the map.
    ///
    /// # Errors
    /// As [`resample`].
    fn of(&self, sky: &Arc<MappedMap>, job: Job<'_>) -> Result<Arc<EnvMap>, EnvError> {
        let of = Arc::downgrade(sky);
        let is_same = |kept: &&Kept| kept.0.ptr_eq(&of);
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner).as_ref().filter(is_same).cloned();
        if let Some((_, grid)) = kept {
            return Ok(grid);
        }
        let grid = resample(&**sky, &Resample::to(Mapping::LatLong, 2 * ROWS, ROWS), job)?.into_env_map()?;
        let grid = Arc::new(grid);
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some((of, grid.clone()));
        Ok(grid)
    }

    /// The sky, `strength` times as bright and turned, with lamps that do not turn.
    ///
    /// # Errors
    /// As [`resample`].
    pub(crate) fn light(
        &self,
        sky: Option<&Arc<MappedMap>>,
        (strength, turn): (f64, &Rotation),
        lamps: &[Disc],
        job: Job<'_>,
    ) -> Result<DistantLight, EnvError> {
        let sky = match sky {
            Some(sky) => self.of(sky, job)?,
            None => Arc::new(EnvMap::from_fn(2 * ROWS, ROWS, |_| Rgb::ZERO)),
        };
        let back = turn.inverse();
        let lamps: Vec<_> = lamps.iter().map(|lamp| shining(lamp, back.rotate_dir(lamp.dir), &sky)).collect();
        let map = EnvMap::from_fn(2 * ROWS, ROWS, |s| {
            let here = lamps.iter().filter(|(towards, cosine, _)| s.dot(*towards) >= *cosine);
            let own = sky.radiance(s).widen().scale(strength);
            Rgb::narrow(here.fold(own, |sum, (.., radiance)| sum + *radiance))
        });
        Ok(DistantLight::from_map(map).turned(turn))
    }
}

/// Towards a lamp, the cosine of its rim, and its radiance: that with which the texels of its disc make a white surface that faces
/// it reflect its strength, `π strength = Σ L cos Ω`.
fn shining(lamp: &Disc, towards: Dir, grid: &EnvMap) -> (Dir, f64, Rgb<f64>) {
    let rim = lamp.half_angle.cos();
    let texel = |k: usize| {
        let (x, y) = (k % grid.width(), k / grid.width());
        let cosine = grid.dir(x, y).dot(towards);
        (cosine >= rim).then(|| cosine * grid.solid_angle(x, y))
    };
    let projected: f64 = (0..grid.width() * grid.height()).filter_map(texel).sum();
    let radiance = if projected > 0.0 { PI / projected } else { 0.0 };
    (towards, rim, Rgb::from(lamp.color).scale(radiance))
}

#[cfg(test)]
mod tests {
    use lobe::sh::sphere::vector::{add_scaled, dot, scale, tangents};

    use super::*;

    /// `∫ L ds` of red within a square around a direction, by points that are a 27th of a texel apart, in rows that no edge of a texel
    /// lies along.
    fn energy(light: &DistantLight, around: Dir) -> f64 {
        const POINTS: usize = 400;
        let step = 0.09 / POINTS as f64;
        let s = around.to_array();
        let [t, b] = tangents(s);
        let (right, up) = (add_scaled(scale(t, 0.8), b, 0.6), add_scaled(scale(b, 0.8), t, -0.6));
        let at = |k: usize| (k as f64 + 0.5) * step - 0.045;
        let of = |k: usize| {
            let v = add_scaled(add_scaled(s, right, at(k % POINTS)), up, at(k / POINTS));
            let towards = Dir::new(v).unwrap();
            light.radiance(towards).r * step * step / dot(v, v).powf(1.5)
        };
        (0..POINTS * POINTS).map(of).sum()
    }

    fn turns() -> [Rotation; 4] {
        [0.0, 0.3, 1.1, 2.7]
            .map(|angle| Rotation::from_axis_angle(Dir::X, angle).then(Rotation::from_axis_angle(Dir::Z, 1.7 * angle)))
    }

    #[test]
    fn a_small_sun_has_its_energy_in_every_turn() {
        let sun = Dir::from_angles(1.0, 0.4);
        let rim = 0.265_f64.to_radians().cos();
        // Six texels across the sun.
        let map = EnvMap::from_fn(4096, 2048, |s| if s.dot(sun) >= rim { Rgb::splat(1e4) } else { Rgb::ZERO });
        let expected = 4.0 * PI * map.mean().r;
        let (sky, grid) = (Arc::new(MappedMap::from(map)), SkyGrid::default());
        for turn in turns() {
            let light = grid.light(Some(&sky), (1.0, &turn), &[], Job::default()).unwrap();
            let found = energy(&light, turn.rotate_dir(sun));
            assert!((found / expected - 1.0).abs() < 0.01, "{found}, expected {expected}");
        }
    }

    #[test]
    fn lamps_stay_where_they_are_and_have_their_strength_in_every_turn() {
        let lamp = Disc { dir: Dir::from_angles(0.7, 2.0), half_angle: 0.03, color: [2.0, 1.0, 0.5] };
        // As small as it is, it is seen at right angles all over.
        let expected = 2.0 * PI;
        for turn in turns() {
            let light = SkyGrid::default().light(None, (1.0, &turn), &[lamp], Job::default()).unwrap();
            let found = energy(&light, lamp.dir);
            assert!((found / expected - 1.0).abs() < 0.01, "{found}, expected {expected}");
        }
    }
}
