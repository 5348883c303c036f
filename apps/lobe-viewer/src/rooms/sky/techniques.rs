//! Techniques of environment mapping for mirrors, glossy and matte balls, prepared beside the window.

use std::f64::consts::FRAC_1_PI;
use std::sync::Arc;

use lobe::env::{
    CubeMap, CubeMipChain, DfgTable, EnvError, EnvMap, Ggx, MappedMap, PrefilterOptions, SpecularLobe, cube,
    cube_source, filter_lobe, project_map,
};
use lobe::figures::{
    BlinnNewell, BruteForceReflection, CubeMapped, Glossy, HighlightMap, MatteByMap, MatteBySh, Paraboloids,
    ReflectionSpace, Shading, SphereMapped, SurfacePoint, highlights_of_lights, irradiance_of_lights,
};
use lobe::io::Job;
use lobe::sh::encoding::IrradiancePolynomial;
use lobe::sh::{Coefficient as _, Dir, Expansion as _, Rgb, Zonal};

use crate::loading::sky_source::OpenedSky;
use crate::loading::task::{Control, Task, TaskEvent};
use crate::rooms::sky::surfaces::{Relief, Surface, Turned, mean_error, values};

/// Texels: the height of a lat-long map, the side of a sphere map and of each paraboloid, twice that of a face.
const MIRROR_SIZE: usize = 128;

/// The width α of the rough balls, wide enough for lights as large as the texels of a face of [`ROUGH_SIZE`].
pub(crate) const ALPHA: f64 = 0.3;

/// Texels along the faces of the map over which rough balls are integrated.
const ROUGH_SIZE: usize = 16;

/// Texels along the faces of the map that is filtered by the lobe.
const FILTERED_SIZE: usize = 32;

/// The reflectance along the normal of the rough balls: a metal.
pub(crate) const METAL: f64 = 0.7;

/// The exponent of highlights, the albedo of what has them, and their color.
pub(crate) const EXPONENT: f64 = 30.0;
pub(crate) const K_D: f64 = 0.4;
pub(crate) const K_S: f64 = 0.3;

/// The largest faces of the map that is blurred for highlights, which have 23 bands.
const BLURRED_SIZE: usize = 64;

/// Names of techniques that several surfaces have.
const ITSELF: &str = "the map itself";
const CUBE: &str = "cube map";
const SUM: &str = "truth: a sum over lights";

/// Rows of maps of irradiance, which has no details smaller than a few of them.
const MATTE_ROWS: usize = 32;

/// Bands of the map of irradiance.
const MATTE_ORDER: usize = 9;

/// A technique, in the frame of the sky.
pub(crate) struct Technique {
    pub(crate) surface: Surface,
    pub(crate) name: &'static str,
    pub(crate) shading: Box<dyn Shading + Send>,
    pub(crate) relief: Relief,
    /// `Σ|a - b| / Σ|b|` against the first of its surface, which is the truth; none of that itself.
    pub(crate) error: Option<f64>,
    /// At the points where errors are measured.
    pub(crate) values: Vec<Rgb<f32>>,
    /// Whether a point is a sum over many lights.
    pub(crate) is_slow: bool,
}

/// The techniques of a sky; each comes when it is ready.
#[derive(Default)]
pub(crate) struct Techniques {
    /// Of which sky, and what prepares them until it has ended.
    task: Option<(Arc<MappedMap>, Option<Task<Technique>>)>,
    pub(crate) ready: Vec<Technique>,
    pub(crate) message: Option<String>,
}

impl Techniques {
    /// Prepares those of a sky, and takes what has come.
    pub(crate) fn follow(&mut self, wake: impl Fn() + Send + 'static, sky: &OpenedSky) {
        if self.task.as_ref().is_none_or(|(map, _)| !Arc::ptr_eq(map, &sky.map)) {
            let map = sky.map.clone();
            self.ready.clear();
            self.message = None;
            let task = Task::start("Techniques", wake, move |control| prepare(control, &map));
            self.task = Some((sky.map.clone(), Some(task)));
        }
        let Some((_, task)) = &mut self.task else { return };
        for event in task.as_ref().map(Task::events).unwrap_or_default() {
            match event {
                TaskEvent::Result(technique) => {
                    self.ready.push(technique);
                    continue;
                }
                TaskEvent::Failed(message) => self.message = Some(message),
                TaskEvent::Done | TaskEvent::Cancelled => {}
            }
            *task = None;
        }
    }

    /// What is being prepared.
    pub(crate) fn describe(&self) -> Option<String> {
        let (_, task) = self.task.as_ref()?;
        task.as_ref().filter(|task| task.is_at_work()).map(Task::describe)
    }

    /// The first of the fast ones for a surface.
    pub(crate) fn of(&self, surface: Surface) -> Option<&Technique> {
        self.ready.iter().find(|technique| technique.surface == surface && !technique.is_slow)
    }
}

/// A rough ball by a map that was filtered for its roughness.
struct SplitSum {
    chain: CubeMipChain,
    table: DfgTable,
}

impl Shading for SplitSum {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        let (chain, table, f0) = (&self.chain, &self.table, Rgb::splat(METAL));
        Glossy { chain, level: 0.0, roughness: ALPHA.sqrt(), f0, table }.radiance(at)
    }
}

type Named = (&'static str, Relief, Box<dyn Shading + Send>);

fn prepare(control: &Control<Technique>, map: &Arc<MappedMap>) -> Result<(), String> {
    let mut truth: Option<(Surface, Vec<Rgb<f32>>)> = None;
    let mut send = |surface: Surface, is_slow: bool, (name, relief, shading): Named| {
        control.stage(name);
        let values = values(surface, &Turned::at_rest(&*shading, relief));
        let error = truth.as_ref().filter(|(of, _)| *of == surface).map(|(_, truth)| mean_error(&values, truth));
        if error.is_none() {
            truth = Some((surface, values.clone()));
        }
        control.send(Technique { surface, name, shading, relief, error, values, is_slow });
        !control.is_cancelled()
    };
    control.stage("mirrors");
    for (surface, mirror) in mirrors(map) {
        if !send(surface, false, mirror) {
            return Ok(());
        }
    }
    control.stage("rough balls");
    let base = cube_source(&**map, 8 * ROUGH_SIZE, Job::default()).map_err(|error| error.to_string())?;
    let averaged = CubeMipChain::averaged(base);
    let is_small = |level: &&CubeMap| level.size() <= ROUGH_SIZE;
    let Some(rough) = averaged.levels().iter().find(is_small).cloned() else { return Ok(()) };
    let metal = Ggx { alpha: ALPHA, f0: METAL };
    let brute = BruteForceReflection::new(&rough, metal);
    if !send(Surface::Glossy, true, (SUM, Relief::Smooth, Box::new(brute))) {
        return Ok(());
    }
    let lobe = SpecularLobe::Ggx { alpha: ALPHA };
    let mut watch = control.watch();
    let job = Job::default().watched_by(&mut watch);
    let tolerance = PrefilterOptions::default().tolerance;
    let filtered = match filter_lobe(averaged.base(), lobe, FILTERED_SIZE, tolerance, job) {
        Err(EnvError::Cancelled) => return Ok(()),
        other => other.map_err(|error| error.to_string())?,
    };
    let split = SplitSum { chain: CubeMipChain::single(filtered), table: DfgTable::new(32) };
    if !send(Surface::Glossy, false, ("split sum", Relief::Smooth, Box::new(split))) {
        return Ok(());
    }
    let views = ReflectionSpace::new(&rough, &metal, 0, 24).normalized();
    if !send(Surface::Glossy, false, ("maps of 12 views", Relief::Smooth, Box::new(views))) {
        return Ok(());
    }
    control.stage("highlights");
    for (is_slow, highlights) in highlights(&averaged, &rough) {
        if !send(Surface::Highlights, is_slow, highlights) {
            return Ok(());
        }
    }
    control.stage("matte balls");
    for matte in matte(map, &rough) {
        if !send(Surface::Matte, false, matte) {
            return Ok(());
        }
    }
    control.rest();
    Ok(())
}

/// Mirrors: first the map itself, as it is stored, with bumps the same, of a ring that meets itself.
fn mirrors(map: &Arc<MappedMap>) -> Vec<(Surface, Named)> {
    let source = |s: Dir| map.radiance(s);
    let itself = || -> Box<dyn Shading + Send> {
        let map = map.clone();
        Box::new(move |p: &SurfacePoint| map.radiance(p.reflected()))
    };
    let cube = CubeMapped::sampled(MIRROR_SIZE / 2, source);
    let smooth: [(&'static str, Box<dyn Shading + Send>); 5] = [
        (ITSELF, itself()),
        ("lat-long map", Box::new(BlinnNewell::sampled(MIRROR_SIZE, source))),
        ("sphere map", Box::new(SphereMapped::sampled(MIRROR_SIZE, source))),
        (CUBE, Box::new(cube.clone())),
        ("dual paraboloid", Box::new(Paraboloids::sampled(MIRROR_SIZE, source))),
    ];
    let smooth = smooth.into_iter().map(|(name, shading)| (Surface::Mirror, (name, Relief::Smooth, shading)));
    let others: [(Surface, Named); 5] = [
        (Surface::Bumpy, (ITSELF, Relief::Bumps, itself())),
        (Surface::Bumpy, (CUBE, Relief::Bumps, Box::new(cube.clone()))),
        (Surface::Ring, ("truth: traced", Relief::Traced, itself())),
        (Surface::Ring, (ITSELF, Relief::Smooth, itself())),
        (Surface::Ring, (CUBE, Relief::Smooth, Box::new(cube))),
    ];
    smooth.chain(others).collect()
}

/// Matte balls with highlights: first the sum over all lights, which is slow.
fn highlights(averaged: &CubeMipChain, rough: &CubeMap) -> Vec<(bool, Named)> {
    let [k_d, k_s] = [K_D, K_S].map(|k| Rgb::splat(k as f32));
    let lights: Vec<(Dir, Rgb<f32>)> = lights(rough).into_iter().map(|(s, light)| (s, Rgb::narrow(light))).collect();
    let sum = move |p: &SurfacePoint| {
        k_d * irradiance_of_lights(&lights, p.normal).scale(FRAC_1_PI as f32)
            + k_s * highlights_of_lights(&lights, EXPONENT, p.reflected())
    };
    let is_small = |level: &&CubeMap| level.size() <= BLURRED_SIZE;
    let blurred = averaged.levels().iter().find(is_small).unwrap_or(averaged.base());
    let rows = 2 * blurred.size();
    let map = EnvMap::from_fn(2 * rows, rows, |s| blurred.radiance(s));
    let map = HighlightMap::of_surroundings(&map, EXPONENT, k_d, k_s);
    vec![
        (true, (SUM, Relief::Smooth, Box::new(sum) as Box<dyn Shading + Send>)),
        (false, ("highlight map", Relief::Smooth, Box::new(map))),
    ]
}

/// Matte balls: first the sum over all lights.
fn matte(map: &Arc<MappedMap>, rough: &CubeMap) -> Vec<Named> {
    let albedo = Rgb::splat(1.0);
    let lights = lights(rough);
    let irradiance = |n: Dir| {
        let lit = |(s, light): &(Dir, Rgb<f64>)| light.scale(s.dot(n).max(0.0));
        Rgb::narrow(lights.iter().map(lit).fold(Rgb::ZERO, |sum, light| sum + light))
    };
    let truth = EnvMap::from_fn(2 * MATTE_ROWS, MATTE_ROWS, irradiance);
    let light = project_map(map, MATTE_ORDER);
    let bands = light.convolved(&Zonal::clamped_cosine(MATTE_ORDER));
    let by_map = EnvMap::from_fn(2 * MATTE_ROWS, MATTE_ROWS, |n| Rgb::narrow(bands.eval(n)));
    let polynomial = IrradiancePolynomial::from_radiance_sh(&light.resized(3));
    vec![
        (SUM, Relief::Smooth, Box::new(MatteByMap { irradiance: truth, albedo })),
        ("irradiance map", Relief::Smooth, Box::new(MatteByMap { irradiance: by_map, albedo })),
        ("nine coefficients", Relief::Smooth, Box::new(MatteBySh { irradiance: polynomial, albedo })),
    ]
}

/// Every texel of a cube as a light: its direction, and its radiance times its solid angle.
fn lights(map: &CubeMap) -> Vec<(Dir, Rgb<f64>)> {
    let size = map.size();
    let light = |i: usize| {
        let (face, x, y) = (i / (size * size), i % size, i / size % size);
        (map.dir(face, x, y), map.texel(face, x, y).widen().scale(cube::solid_angle(size, x, y)))
    };
    (0..map.texels().len()).map(light).collect()
}

#[cfg(test)]
mod tests {
    use std::thread::sleep;
    use std::time::Duration;

    use lobe::env::Mapping;

    use super::*;

    fn even() -> OpenedSky {
        OpenedSky::of("even".into(), MappedMap::from_fn(Mapping::LatLong, 8, 4, |_| Rgb::splat(1.0)))
    }

    #[test]
    fn what_failed_is_told_and_goes_on_no_longer_until_there_is_another_sky() {
        let sky = even();
        let task = Task::start(
            "Techniques",
            || (),
            |control: &Control<Technique>| {
                control.stage("rough balls");
                Err("too bright".into())
            },
        );
        let mut techniques = Techniques { task: Some((sky.map.clone(), Some(task))), ..Techniques::default() };
        while techniques.message.is_none() {
            techniques.follow(|| (), &sky);
            sleep(Duration::from_millis(1));
        }
        assert_eq!(techniques.message.as_deref(), Some("too bright"), "its message");
        assert_eq!(techniques.describe(), None, "nothing is being prepared");
        techniques.follow(|| (), &even());
        assert_eq!(techniques.message, None, "of another sky nothing is known yet");
    }
}
