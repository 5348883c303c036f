//! Techniques of environment mapping for mirrors, glossy and matte balls, prepared beside the window.

use std::sync::Arc;

use lobe::env::{
    CubeMap, CubeMipChain, DfgTable, EnvMap, Ggx, MappedMap, PrefilterMethod, SpecularLobe, cube, cube_source,
    filter_lobe, project_map,
};
use lobe::io::Job;
use lobe::render::{
    BlinnNewell, BruteForceReflection, Camera, CubeMapped, Exhibit, ExhibitSolid, Glossy, IrradiancePolynomial,
    MatteByMap, MatteBySh, Paraboloids, ReflectionSpace, Shading, SphereMapped, SurfacePoint, View,
};
use lobe::sh::{Coefficient as _, Dir, Expansion as _, Rgb, Rotation, Zonal, convolved};

use crate::loading::sky_source::OpenedSky;
use crate::loading::task::{Control, Task, TaskEvent};

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

/// Rows of maps of irradiance, which has no details smaller than a few of them.
const MATTE_ROWS: usize = 32;

/// Bands of the map of irradiance.
const MATTE_ORDER: usize = 9;

/// Rows and columns of the points at which errors are measured.
const MEASURED: usize = 48;

/// What a ball is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Surface {
    Mirror,
    Glossy,
    Matte,
}

impl Surface {
    pub(crate) const ALL: [Self; 3] = [Self::Mirror, Self::Glossy, Self::Matte];

    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Mirror => "Mirrors",
            Self::Glossy => "Glossy: GGX of α = 0.3",
            Self::Matte => "Matte",
        }
    }
}

/// A technique, in the frame of the sky.
pub(crate) struct Technique {
    pub(crate) surface: Surface,
    pub(crate) name: &'static str,
    pub(crate) shading: Box<dyn Shading + Send>,
    /// `Σ|a - b| / Σ|b|` against the first of its surface, which is the truth; none of that itself.
    pub(crate) error: Option<f64>,
    /// Whether a point is a sum over many lights.
    pub(crate) is_slow: bool,
}

/// The techniques of a sky; each comes when it is ready.
#[derive(Default)]
pub(crate) struct Techniques {
    task: Option<(Arc<MappedMap>, Task<Technique>)>,
    pub(crate) ready: Vec<Technique>,
    pub(crate) message: Option<String>,
}

impl Techniques {
    /// Prepares those of a sky, and takes what has come.
    pub(crate) fn follow(&mut self, wake: impl Fn() + Send + 'static, sky: &OpenedSky) {
        if self.task.as_ref().is_none_or(|(map, _)| !Arc::ptr_eq(map, &sky.map)) {
            let map = sky.map.clone();
            self.ready.clear();
            let task = Task::start("Techniques", wake, move |control| prepare(control, &map));
            self.task = Some((sky.map.clone(), task));
        }
        for event in self.task.as_ref().map(|(_, task)| task.events()).unwrap_or_default() {
            match event {
                TaskEvent::Result(technique) => self.ready.push(technique),
                TaskEvent::Failed(message) => self.message = Some(message),
                TaskEvent::Done | TaskEvent::Cancelled => {}
            }
        }
    }

    /// What is being prepared.
    pub(crate) fn describe(&self) -> Option<String> {
        self.task.as_ref().filter(|(_, task)| task.is_at_work()).map(|(_, task)| task.describe())
    }

    /// The first of the fast ones for a surface.
    pub(crate) fn of(&self, surface: Surface) -> Option<&Technique> {
        self.ready.iter().find(|technique| technique.surface == surface && !technique.is_slow)
    }
}

/// A technique under a sky that is turned.
pub(crate) struct Turned<'a> {
    pub(crate) shading: &'a dyn Shading,
    pub(crate) back: Rotation,
}

impl Shading for Turned<'_> {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        let [normal, view] = [at.normal, at.view].map(|s| self.back.rotate_dir(s));
        self.shading.radiance(&SurfacePoint { normal, view, ..*at })
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

/// The points of a ball at which errors are measured, seen along +x.
pub(crate) fn measured_points() -> Vec<SurfacePoint> {
    let camera = Camera::perspective(View::ALONG_X, 4.0, 0.3);
    Exhibit { solid: ExhibitSolid::Ball { radius: 1.0 }, camera, samples: 1 }.points(MEASURED, MEASURED)
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

type Named = (&'static str, Box<dyn Shading + Send>);

fn prepare(control: &Control<Technique>, map: &Arc<MappedMap>) -> Result<(), String> {
    let points = measured_points();
    let mut truth: Option<(Surface, Vec<Rgb<f32>>)> = None;
    let mut send = |surface: Surface, is_slow: bool, (name, shading): Named| {
        control.stage(name);
        let values: Vec<Rgb<f32>> = points.iter().map(|point| shading.radiance(point)).collect();
        let error = truth.as_ref().filter(|(of, _)| *of == surface).map(|(_, truth)| mean_error(&values, truth));
        if error.is_none() {
            truth = Some((surface, values));
        }
        control.send(Technique { surface, name, shading, error, is_slow });
        !control.is_cancelled()
    };
    control.stage("mirrors");
    for mirror in mirrors(map) {
        if !send(Surface::Mirror, false, mirror) {
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
    if !send(Surface::Glossy, true, ("truth: a sum over lights", Box::new(brute))) {
        return Ok(());
    }
    let lobe = SpecularLobe::Ggx { alpha: ALPHA };
    let mut watch = control.watch();
    let job = Job::default().watched_by(&mut watch);
    let filtered = filter_lobe(averaged.base(), lobe, FILTERED_SIZE, PrefilterMethod::default(), job);
    // What was stopped has no more to say.
    let Ok(filtered) = filtered else { return Ok(()) };
    let split = SplitSum { chain: CubeMipChain::single(filtered), table: DfgTable::new(32) };
    if !send(Surface::Glossy, false, ("split sum", Box::new(split))) {
        return Ok(());
    }
    let views = ReflectionSpace::new(&rough, &metal, 0, 24).normalized();
    if !send(Surface::Glossy, false, ("maps of 12 views", Box::new(views))) {
        return Ok(());
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

/// Mirrors: first the map itself, as it is stored.
fn mirrors(map: &Arc<MappedMap>) -> Vec<Named> {
    let source = |s: Dir| map.radiance(s);
    let itself = map.clone();
    vec![
        ("the map itself", Box::new(move |p: &SurfacePoint| itself.radiance(p.reflected()))),
        ("lat-long map", Box::new(BlinnNewell::sampled(MIRROR_SIZE, source))),
        ("sphere map", Box::new(SphereMapped::sampled(MIRROR_SIZE, source))),
        ("cube map", Box::new(CubeMapped::sampled(MIRROR_SIZE / 2, source))),
        ("dual paraboloid", Box::new(Paraboloids::sampled(MIRROR_SIZE, source))),
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
    let bands = convolved(&light, &Zonal::clamped_cosine(MATTE_ORDER));
    let by_map = EnvMap::from_fn(2 * MATTE_ROWS, MATTE_ROWS, |n| Rgb::narrow(bands.eval(n)));
    let polynomial = IrradiancePolynomial::of_radiance(&light.resized(3));
    vec![
        ("truth: a sum over lights", Box::new(MatteByMap { irradiance: truth, albedo })),
        ("irradiance map", Box::new(MatteByMap { irradiance: by_map, albedo })),
        ("nine coefficients", Box::new(MatteBySh { irradiance: polynomial, albedo })),
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
