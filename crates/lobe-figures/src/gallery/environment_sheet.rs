//! A contact sheet of environment mapping: every technique beside its reference, with its error.

use std::f64::consts::PI;

use derive_setters::Setters;
use lobe_env::{
    CubeMap, CubeMipChain, DfgTable, EnvError, EnvMap, Ggx, MappedMap, Mapping, PrefilterOptions, Resample, cube,
    irradiance_at, irradiance_map, irradiance_map_brute_force, prefilter_ggx, project_env, reconstruct, resample,
};
use lobe_image::{Exposure, Label, Picture, Sheet, Tone};
use lobe_io::{Job, Progress};
use lobe_sh::encoding::IrradiancePolynomial;
use lobe_sh::filter::convolve_in_place;
use lobe_sh::{Coefficient, Dir, Expansion, Rgb, Zonal};
use web_time::Instant;

use crate::gallery::bump::{Bumped, bumps};
use crate::gallery::exhibit::{Exhibit, Shading, SurfacePoint};
use crate::gallery::glossy::Glossy;
use crate::gallery::highlight_map::{HighlightMap, highlights_of_lights};
use crate::gallery::matte::{MatteByMap, MatteBySh};
use crate::gallery::mirror_maps::{BlinnNewell, CubeMapped, SphereMapped};
use crate::gallery::paraboloids::Paraboloids;
use crate::gallery::reflection_space::{BruteForceReflection, ReflectionSpace};
use crate::gallery::solid::ExhibitSolid;
use crate::gallery::torus::Torus;
use crate::gallery::traced_mirror::TracedMirror;
use lobe_render::{Camera, RenderError, View};

/// Reflections at most in the traced picture of a torus that mirrors itself.
const BOUNCES: usize = 4;
/// The width α of the rough mirrors, wide enough for lights as large as the texels of a face of [`ROUGH_SIZE`].
const ALPHA: f64 = 0.3;
/// Texels along the faces of the map from which rough mirrors are integrated.
const ROUGH_SIZE: usize = 16;
/// The reflectance along the normal of the rough mirrors: a metal, tinted a little.
const METAL: f64 = 0.7;
/// Bands with which the map is blurred for the rough mirror: GGX of [`ALPHA`] keeps less than `1e-3` of the last one.
const GLOSSY_ORDER: usize = 32;
/// The albedo of the diffuse surfaces.
const ALBEDO: f64 = 0.8;
/// The exponent of the highlights, the albedo of what has them, and their color.
const EXPONENT: f64 = 30.0;
const K_D: f32 = 0.4;
const K_S: f32 = 0.3;
/// The height and the number of the bumps.
const BUMPS: (f64, f64) = (0.02, 14.0);
/// Rows of the map of the sums over all texels. Irradiance has no details smaller than a few of them.
const MATTE_ROWS: usize = 32;
/// Rays along each side of a pixel at most, where each is a sum over many lights.
const SLOW_SAMPLES: usize = 2;
/// Rows and columns of the points at which errors are measured: of mirrors, which show single texels, and of others.
const MEASURED: [usize; 2] = [96, 32];
/// The value to which the 99th percentile of the light of a blurred surface is exposed.
const BRIGHT: f64 = 1.5;
/// Pictures a row of the sheet.
const COLUMNS: usize = 7;

/// Sizes and inputs of [`environment_panels`].
#[derive(Clone, Copy, Debug, Setters)]
#[non_exhaustive]
pub struct EnvironmentSheetOptions<'a> {
    /// Pixels along each side of a picture.
    pub size: usize,
    /// Rays along each side of a pixel.
    pub samples: usize,
    /// Texels: the height of the lat-long map, the side of the sphere map and of each paraboloid, twice that of a face.
    pub map_size: usize,
    /// A chain prefiltered for GGX whose level `k` of `n` holds the roughness `√α = k/(n - 1)`; without one, the map is
    /// blurred for the one roughness shown by spherical harmonics.
    #[setters(into)]
    pub prefiltered: Option<&'a CubeMipChain>,
}

impl Default for EnvironmentSheetOptions<'_> {
    /// Pictures of 160 x 160 pixels with 9 rays each, maps of 128 texels.
    fn default() -> Self {
        Self { size: 160, samples: 3, map_size: 128, prefiltered: None }
    }
}

/// The size of the faces from which the mirrors of [`EnvironmentSheetSource`] are blurred, and of the first and the
/// last level of its chain.
const CHAIN: [usize; 3] = [256, 128, 8];

/// A map as [`environment_panels`] takes it: as a lat-long one, and prefiltered.
#[derive(Clone, Debug)]
pub struct EnvironmentSheetSource {
    /// What is mirrored.
    pub sky: EnvMap,
    /// For [`EnvironmentSheetOptions::prefiltered`].
    pub chain: CubeMipChain,
}

impl EnvironmentSheetSource {
    /// From a map in any mapping. Progress is that of one step after the other.
    ///
    /// # Errors
    /// Those of [`resample`] and [`prefilter_ggx`].
    pub fn new(map: MappedMap, mut job: Job<'_>) -> Result<Self, EnvError> {
        let [fine, size, last_size] = CHAIN;
        let to = Resample::to(Mapping::Cube, fine, Mapping::Cube.height_for(fine));
        let cube = resample(&map, &to, job.reborrow())?.into_cube_map()?;
        let chain = prefilter_ggx(&cube, &PrefilterOptions::default().size(size).last_size(last_size), job.reborrow())?;
        let sky = match map.mapping() {
            Mapping::LatLong => map,
            _ => resample(map, &Resample::to(Mapping::LatLong, 8 * fine, 4 * fine), job)?,
        };
        Ok(Self { sky: sky.into_env_map()?, chain })
    }
}

/// One picture of the sheet.
#[derive(Clone, Debug)]
pub struct EnvironmentPanel {
    /// `ball` or `torus`.
    pub solid: &'static str,
    /// The technique, in small letters.
    pub technique: &'static str,
    /// The picture in linear light.
    pub picture: Picture,
    /// The error against the truth that the technique approximates, over the visible surface: `Σ|a - b| / Σ|b|`. `None`
    /// for the truth itself.
    pub error: Option<f64>,
    /// Whether the surface mirrors the map as it is; the others blur it.
    pub mirrors: bool,
}

/// The reference that a technique is measured against.
#[derive(Clone, Copy, PartialEq)]
enum Truth {
    /// None: it is the truth itself, a traced mirror.
    Traced,
    /// None: it is the truth itself, of a surface that blurs the map.
    Summed,
    /// The same, where each point is a sum over many lights.
    SlowlySummed,
    /// The traced reflection of the map.
    Mirror,
    /// The same about the normals of the bumps.
    BumpedMirror,
    /// The sum over all texels by the normal, and over the lights of a coarse map by the reflected direction.
    Highlights,
    /// The integral over the reflectance function, light by light.
    Rough,
    /// The sum over all texels.
    Matte,
}

type Technique<'a> = (&'static str, Box<dyn Shading + 'a>, Truth);

/// Every technique on a ball and on a torus under one map, the ball's pictures first; the torus has one more, where it
/// mirrors itself.
///
/// The eye stands at -x, the middle of the lat-long picture is behind the shapes. What is mirrored is compared with
/// the traced reflection of the map itself, with and without bumps, rough mirrors and highlights with the integral over
/// the map reduced to 6 · 16² lights, matte surfaces with the sum over all texels. The truths have panels of their own.
///
/// The steps of `job` are panels; it cannot be resumed.
///
/// # Errors
/// [`RenderError::Options`] for a job with a checkpoint, or if the irradiance of the map is more than `f32` holds;
/// [`RenderError::Cancelled`] if its watch said to stop.
///
/// # Panics
/// If `samples` is 0 or `map_size` less than 8.
pub fn environment_panels(
    map: &EnvMap,
    options: &EnvironmentSheetOptions<'_>,
    mut job: Job<'_>,
) -> Result<Vec<EnvironmentPanel>, RenderError> {
    job.expect_no_checkpoint().map_err(RenderError::Options)?;
    // Prepare the maps and the references.
    let source = |s: Dir| map.radiance(s);
    let averaged = CubeMipChain::averaged(CubeMap::from_fn(16 * ROUGH_SIZE, source));
    let rough = &averaged.levels()[4];
    let (blurred, table) = (blurred(map), DfgTable::new(32));
    let truths = Truths { map, rough: BruteForceReflection::new(rough, metal()), lights: lights(rough) };
    // List the techniques, each with its reference.
    let mut techniques = mirrors(options.map_size, &source);
    techniques.push(bumped(map, options.map_size));
    techniques.push(("glossy, truth", Box::new(|p: &SurfacePoint| truths.rough.radiance(p)), Truth::SlowlySummed));
    techniques.extend(rough_mirrors(map, rough, options.prefiltered, &blurred, &table));
    techniques.extend(matte(map).map_err(|error| RenderError::Options(error.to_string()))?);

    // Set up the eye and the two shapes; the torus leans towards the eye and a little aside.
    let camera = Camera::perspective(View::ALONG_X, 4.0, 0.3);
    let axis = Dir::new([-0.6, 0.25, 0.75]).unwrap_or(Dir::Z);
    let torus = ExhibitSolid::Torus(Torus { axis, major: 0.7, minor: 0.3 });
    // Render every technique on both shapes, and measure its error.
    let mut panels = Vec::new();
    let (start, total) = (Instant::now(), 2 * techniques.len() + 1);
    let mut go_on = |done: usize| {
        let progress = Progress { done, total, elapsed: start.elapsed(), ..Progress::default() };
        if job.report(&progress).is_break() { Err(RenderError::Cancelled) } else { Ok(()) }
    };
    for (name, solid) in [("ball", ExhibitSolid::Ball { radius: 1.0 }), ("torus", torus)] {
        let scene = Exhibit { solid, camera, samples: options.samples };
        let slow = Exhibit { samples: options.samples.min(SLOW_SAMPLES), ..scene };
        let [many, few] = MEASURED.map(|n| scene.points(n, n));
        let panel = |technique: &'static str, shading: &dyn Shading, truth: Truth| {
            let mirrors = matches!(truth, Truth::Traced | Truth::Mirror | Truth::BumpedMirror);
            let scene = if truth == Truth::SlowlySummed { &slow } else { &scene };
            EnvironmentPanel {
                solid: name,
                technique,
                picture: scene.picture(options.size, options.size, source, shading),
                error: truths.error(truth, shading, if mirrors { &many } else { &few }),
                mirrors,
            }
        };
        for (technique, shading, truth) in &techniques {
            go_on(panels.len())?;
            panels.push(panel(technique, shading.as_ref(), *truth));
        }
        if solid == torus {
            go_on(panels.len())?;
            let mirror = TracedMirror { source, solid, bounces: BOUNCES };
            panels.push(panel("mirrors itself", &mirror, Truth::Traced));
        }
    }
    go_on(panels.len())?;
    Ok(panels)
}

/// [`environment_panels`] as one picture with names and errors in percent, two rows for each shape. Show it with
/// [`Tone::PLAIN`].
///
/// Mirrors are tone mapped like a photograph of the map; surfaces that blur it too, but darker where a lamp would make
/// them white, all alike.
///
/// # Errors
/// As [`environment_panels`].
///
/// # Panics
/// As [`environment_panels`].
pub fn environment_mapping_sheet(
    map: &EnvMap,
    options: &EnvironmentSheetOptions<'_>,
    job: Job<'_>,
) -> Result<Picture, RenderError> {
    let panels = environment_panels(map, options, job)?;
    let photograph = Tone::PHOTOGRAPH.fixed_for(&Picture::from(map));
    let factor = |exposure: Exposure| {
        let blurred = panels.iter().filter(|panel| !panel.mirrors);
        blurred.map(|panel| exposure.factor(&panel.picture)).fold(f64::INFINITY, f64::min)
    };
    let dark = factor(Exposure::Percentile { fraction: 0.99, level: BRIGHT }).min(factor(photograph.exposure));
    let blurred = Tone { exposure: Exposure::Fixed(dark), ..photograph };
    let mut pictures = Vec::new();
    for solid in ["ball", "torus"] {
        let shape = panels.iter().filter(|panel| panel.solid == solid);
        pictures.extend(shape.map(|panel| labeled(panel, if panel.mirrors { &photograph } else { &blurred })));
        // Each shape begins a row.
        let row_end = pictures.len().next_multiple_of(COLUMNS);
        pictures.resize(row_end, Picture::filled(0, 0, Rgb::ZERO));
    }
    Ok(Sheet { columns: COLUMNS, margin: 6, background: [1.0; 3] }.compose(&pictures))
}

/// A panel as it is shown, its name above and its error below.
fn labeled(panel: &EnvironmentPanel, tone: &Tone) -> Picture {
    let shown = tone.apply(&panel.picture);
    // As high as the longest name allows.
    let wide = Label { left: 0.0, top: 0.0, height: 1.0, color: [0.0; 3] }.width(panel.technique);
    let height = (0.065 * shown.width() as f64).max(8.0);
    let band = (1.7 * height).ceil() as usize;
    let mut out = Picture::filled(shown.width(), shown.height() + 2 * band, Rgb::splat(1.0));
    out.paste(&shown, 0, band as isize);
    let label = Label { left: 2.0, top: 0.3 * height, height, color: [0.0; 3] };
    let fitting = height.min((shown.width() as f64 - 4.0) / wide);
    Label { height: fitting, ..label }.draw(&mut out, panel.technique);
    if let Some(error) = panel.error {
        let top = (band + shown.height()) as f64 + 0.3 * height;
        Label { top, ..label }.draw(&mut out, &format!("error {:.2} %", 100.0 * error));
    }
    out
}

fn metal() -> Ggx {
    Ggx { alpha: ALPHA, f0: METAL }
}

fn mirrors<'a>(size: usize, source: &'a (impl Fn(Dir) -> Rgb<f32> + Sync)) -> Vec<Technique<'a>> {
    let traced = |p: &SurfacePoint| source(p.reflected());
    vec![
        ("traced mirror", Box::new(traced), Truth::Traced),
        ("blinn-newell", Box::new(BlinnNewell::sampled(size, source)), Truth::Mirror),
        ("sphere map", Box::new(SphereMapped::sampled(size, source)), Truth::Mirror),
        ("cube map", Box::new(CubeMapped::sampled(size.div_ceil(2), source)), Truth::Mirror),
        ("dual paraboloid", Box::new(Paraboloids::sampled(size, source)), Truth::Mirror),
    ]
}

fn rough_mirrors<'a>(
    map: &EnvMap,
    rough: &CubeMap,
    prefiltered: Option<&'a CubeMipChain>,
    blurred: &'a CubeMipChain,
    table: &'a DfgTable,
) -> Vec<Technique<'a>> {
    let roughness = ALPHA.sqrt();
    let (chain, level) =
        prefiltered.map_or((blurred, 0.0), |chain| (chain, roughness * (chain.levels().len() - 1) as f64));
    let glossy = Glossy { chain, level, roughness, f0: Rgb::splat(METAL), table };
    let views = ReflectionSpace::new(rough, &metal(), 0, 24).normalized();
    let phong = HighlightMap::of_surroundings(map, EXPONENT, Rgb::splat(K_D), Rgb::splat(K_S));
    vec![
        ("glossy, split sum", Box::new(glossy), Truth::Rough),
        ("glossy, 12 views", Box::new(views), Truth::Rough),
        ("highlight map", Box::new(phong), Truth::Highlights),
    ]
}

fn matte<'a>(map: &EnvMap) -> Result<Vec<Technique<'a>>, EnvError> {
    let albedo = Rgb::splat(ALBEDO as f32);
    let truth = irradiance_map_brute_force(map, 2 * MATTE_ROWS, MATTE_ROWS, Job::default())?;
    let by_map = irradiance_map(map, 9, 2 * MATTE_ROWS, MATTE_ROWS)?;
    let irradiance = IrradiancePolynomial::from_radiance_sh(&project_env(map, 3));
    Ok(vec![
        ("matte, truth", Box::new(MatteByMap { irradiance: truth, albedo }), Truth::Summed),
        ("matte, map", Box::new(MatteByMap { irradiance: by_map, albedo }), Truth::Matte),
        ("matte, order 3", Box::new(MatteBySh { irradiance, albedo }), Truth::Matte),
    ])
}

fn bumped<'a>(map: &EnvMap, size: usize) -> Technique<'a> {
    let mirror = CubeMapped::sampled(size.div_ceil(2), |s| map.radiance(s));
    ("bumps, cube map", Box::new(Bumped { inner: mirror, height: bumps(BUMPS.0, BUMPS.1) }), Truth::BumpedMirror)
}

/// Every texel of a cube as a light: its direction, and the irradiance of a surface that faces it.
fn lights(map: &CubeMap) -> Vec<(Dir, Rgb<f32>)> {
    let size = map.size();
    let light = |i: usize| {
        let (face, x, y) = (i / (size * size), i % size, i / size % size);
        (map.dir(face, x, y), map.texel(face, x, y).scale(cube::solid_angle(size, x, y) as f32))
    };
    (0..map.texels().len()).map(light).collect()
}

/// The map blurred for the one roughness of the sheet, as a chain of one level.
fn blurred(map: &EnvMap) -> CubeMipChain {
    let mut light = project_env(map, GLOSSY_ORDER);
    convolve_in_place(light.coefficients_mut(), &Zonal::ggx(GLOSSY_ORDER, ALPHA));
    let picture = reconstruct(&light, 8 * GLOSSY_ORDER, 4 * GLOSSY_ORDER);
    CubeMipChain::single(CubeMap::from_fn(2 * GLOSSY_ORDER, |s| picture.radiance(s)))
}

/// The truths that errors are measured against.
struct Truths<'a> {
    map: &'a EnvMap,
    rough: BruteForceReflection<Ggx>,
    /// Those of the rough map.
    lights: Vec<(Dir, Rgb<f32>)>,
}

impl Truths<'_> {
    fn error(&self, truth: Truth, shading: &dyn Shading, points: &[SurfacePoint]) -> Option<f64> {
        let values = |shading: &dyn Shading| -> Vec<Rgb<f32>> { points.iter().map(|p| shading.radiance(p)).collect() };
        let mirror = |p: &SurfacePoint| self.map.radiance(p.reflected());
        let exact: Vec<Rgb<f32>> = match truth {
            Truth::Traced | Truth::Summed | Truth::SlowlySummed => return None,
            Truth::Mirror => values(&mirror),
            Truth::BumpedMirror => values(&Bumped { inner: mirror, height: bumps(BUMPS.0, BUMPS.1) }),
            Truth::Rough => values(&self.rough),
            Truth::Matte => self.matte(points, ALBEDO),
            Truth::Highlights => {
                let highlight =
                    |p: &SurfacePoint| highlights_of_lights(&self.lights, EXPONENT, p.reflected()).scale(K_S);
                let matte = self.matte(points, f64::from(K_D));
                matte.into_iter().zip(points).map(|(matte, p)| matte + highlight(p)).collect()
            }
        };
        Some(mean_error(&values(shading), &exact))
    }

    /// The radiance of diffuse points of an albedo: the sum over all texels.
    fn matte(&self, points: &[SurfacePoint], albedo: f64) -> Vec<Rgb<f32>> {
        let normals: Vec<Dir> = points.iter().map(|p| p.normal).collect();
        irradiance_at(self.map, &normals).into_iter().map(|e| Rgb::narrow(e.scale(albedo / PI))).collect()
    }
}

/// `Σ|a - b| / Σ|b|` over all channels; 0 where nothing differs.
///
/// Not squared: where a map shows the sun, one point in a thousand would decide alone.
fn mean_error(a: &[Rgb<f32>], b: &[Rgb<f32>]) -> f64 {
    let sum = |f: &dyn Fn(usize, usize) -> f32| -> f64 {
        (0..a.len()).flat_map(|i| (0..3).map(move |c| (i, c))).map(|(i, c)| f64::from(f(i, c).abs())).sum()
    };
    let difference = sum(&|i, c| a[i].channel(c) - b[i].channel(c));
    if difference == 0.0 { 0.0 } else { difference / sum(&|i, c| b[i].channel(c)) }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;

    /// A sky with a broad light, a ground.
    fn map() -> EnvMap {
        EnvMap::from_fn(128, 64, |s| {
            let glow = (20.0 * (s.x() * -0.6 + s.y() * -0.7 + s.z() * 0.4 - 1.0)).exp() as f32;
            Rgb::new(0.6 + 4.0 * glow, 0.6 + 0.3 * s.z() as f32, 0.8 + 0.5 * s.z() as f32)
        })
    }

    #[test]
    fn every_technique_is_near_what_it_stands_for() {
        let options = EnvironmentSheetOptions { size: 16, samples: 1, map_size: 64, prefiltered: None };
        let mut steps = Vec::new();
        let mut watch = |progress: &Progress| {
            steps.push((progress.done, progress.total));
            ControlFlow::Continue(())
        };
        let panels = environment_panels(&map(), &options, Job::default().watched_by(&mut watch)).unwrap();
        assert_eq!(steps, (0..=27).map(|done| (done, 27)).collect::<Vec<_>>(), "a step for each panel");
        assert_eq!(
            panels.len(),
            27,
            "ten techniques and three truths on two shapes, and the torus that mirrors itself"
        );
        let truths = ["traced mirror", "mirrors itself", "glossy, truth", "matte, truth"];
        for panel in &panels {
            let limit = match panel.technique {
                "glossy, split sum" => 0.2,
                "glossy, 12 views" => 0.1,
                _ => 0.03,
            };
            println!("{} {}: {:.4?}", panel.solid, panel.technique, panel.error);
            if truths.contains(&panel.technique) {
                assert_eq!(panel.error, None, "{} {} is the truth", panel.solid, panel.technique);
                continue;
            }
            assert!(panel.error.is_some_and(|e| e < limit), "{} {}: {:?}", panel.solid, panel.technique, panel.error);
        }
    }

    #[test]
    fn the_sheet_holds_all_panels_in_rows_of_seven() {
        let options = EnvironmentSheetOptions { size: 24, samples: 1, map_size: 16, prefiltered: None };
        let sheet = environment_mapping_sheet(&map(), &options, Job::default()).unwrap();
        let cell = (24, 24 + 2 * 14);
        assert_eq!((sheet.width(), sheet.height()), (6 + 7 * (cell.0 + 6), 6 + 4 * (cell.1 + 6)), "four rows of seven");
    }
}
