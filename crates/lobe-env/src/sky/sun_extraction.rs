//! Sun extraction: splits a map into a directional light and the rest.

use std::f64::consts::PI;

use derive_setters::Setters;
use lobe_io::parallel;
use lobe_sh::sphere::gauss_legendre;
use lobe_sh::{Coefficient, Dir, Rgb};

use crate::area_light::area_light::AreaLight as _;
use crate::area_light::sphere_light::SphereLight;
use crate::map::mapped_map::MappedMap;
use crate::mapping::texel_quadrature;
use crate::sky::neighbors::{Neighbors, parts};
use crate::sky::no_sun::NoSun;

// An expansion of low order rings at a sun. So the sun is extracted first and lights the scene by itself:
//
//     L = rest + sun        rest <= L, sun = L - rest >= 0 in a disc around the brightest texel, 0 elsewhere
//
// Inside the disc, the rest is a plane fitted to a ring around the disc, per channel, clamped to L. The sun is the
// difference of the texels as they are stored, so the two parts always sum to the original.

/// A texel belongs to the sun if it is at least this fraction as bright as the brightest: far above the sun's
/// surroundings, far below a texel that the sun covers partly.
const EDGE: f64 = 0.05;

/// Bright texels that are no farther apart, in texels, belong together: diagonal neighbors do, those with a dark one
/// between do not.
const JOINED: f64 = 1.6;

/// The most bright places beside a sun that are other lights: more are the sparkle of water, leaves before a sky, or
/// panes.
const MOST_OTHERS: usize = 3;

/// The ring around the sun, in texels beyond its edge: it begins outside the light that the picture's own filter
/// spread.
const RING: [f64; 2] = [1.5, 5.5];

/// Texels longer than this, in units of the root of the mean solid angle, do not widen the ring: a plane does not fit
/// the sky far from the sun, and at the rim of a ball's picture texels are 17° long.
const LONGEST: f64 = 2.5;

/// The least determinant of a normal matrix, relative to the product of its diagonal: below, the ring is too lopsided.
const LEAST_DETERMINANT: f64 = 1e-3;

/// Criteria of a sun.
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct SunOptions {
    /// The largest angle from the center to the edge of a sun, in radians; at least two and a half texels. Default:
    /// 2.5°.
    pub max_radius: f64,
    /// The least luminance of a sun's brightest texel, relative to the ring around the sun. Default: 20.
    pub min_contrast: f64,
    /// The least luminance of a sun's brightest texel, relative to the mean of the map. Default: 100.
    pub min_peak: f64,
}

impl Default for SunOptions {
    fn default() -> Self {
        Self { max_radius: 2.5_f64.to_radians(), min_contrast: 20.0, min_peak: 100.0 }
    }
}

/// A sun: a directional light of small angular size.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sun {
    /// The direction towards the centroid of the sun's light.
    pub direction: Dir,
    /// `∫ (L - rest) ds` over its disc: the irradiance of a surface that faces it. Never includes `1/π`.
    pub irradiance: Rgb<f64>,
    /// The diameter, in radians, of the disc of constant radiance with the same `(∫ L)² / ∫ L²`, by luminance. Texels
    /// limit it from below: a sun smaller than a texel appears as large as one.
    pub angular_diameter: f64,
    /// The number of texels that were changed.
    pub texels: usize,
}

impl Sun {
    /// The radiance of the disc of constant radiance.
    #[must_use]
    pub fn radiance(&self) -> Rgb<f64> {
        let sin = (0.25 * self.angular_diameter).sin();
        // 2π (1 - cos r) = 4π sin²(r/2)
        Rgb::from(self.irradiance.to_array().map(|e| e / (4.0 * PI * sin * sin)))
    }

    /// The irradiance of a surface that faces `normal`: that of a disc of constant radiance, of which the horizon may
    /// hide a part.
    #[must_use]
    pub fn irradiance_at(&self, normal: Dir) -> Rgb<f64> {
        let sine = (0.5 * self.angular_diameter).sin();
        // Of discs so small that their radiance is no number, all of them or nothing is above the horizon.
        if sine < f64::MIN_POSITIVE.sqrt() || self.angular_diameter >= PI {
            return self.irradiance.scale(self.direction.dot(normal).max(0.0));
        }
        let disc = SphereLight { center: self.direction.to_array(), radius: sine };
        self.radiance().scale(disc.irradiance([0.0; 3], normal))
    }
}

/// The sun of a map, and the map without it, in the same mapping and size.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SunReport {
    /// The light extracted.
    pub sun: Sun,
    /// The map with the sun replaced by its surroundings, and with negative texels beside the sun set to black: the
    /// overshoot of a filter, which is subtracted from the sun. All other texels are unchanged. `4π` times its mean
    /// plus the sun's irradiance is `4π` times the mean of the original (test
    /// `nothing_is_lost_when_a_sun_is_taken_out`).
    pub rest: MappedMap,
}

/// Extracts the sun as [`find_sun`], without a word on why there is none.
///
/// ```
/// use lobe_env::{SunOptions, bundled, extract_sun};
///
/// let map = bundled::sunset().map();
/// let report = extract_sun(&map, &SunOptions::default()).ok_or("no sun")?;
/// assert!(report.sun.direction.z() > 0.0 && report.sun.angular_diameter < 0.05);
/// # Ok::<(), &str>(())
/// ```
#[must_use]
pub fn extract_sun(map: &MappedMap, options: &SunOptions) -> Option<SunReport> {
    find_sun(map, options).ok()
}

/// Extracts the sun: the brightest small light of a map.
///
/// There is one if all of this holds, by luminance, of the brightest texel and of all texels joined to it that are at
/// least a twentieth as bright:
///
/// * they fit into a disc of [`SunOptions::max_radius`]: a window, a softbox or a bright cloud does not;
/// * the brightest is [`SunOptions::min_contrast`] times as bright as the ring around that disc: a bright place in a
///   bright sky is not;
/// * it is [`SunOptions::min_peak`] times as bright as the mean of the map: nothing in an overcast sky is;
/// * near them are few other places that are so bright. Two suns that texels part are two: the ring leaves the other
///   one out.
///
/// Towards the rim of a ball's picture texels are long: `4/(N sin(δ/2))` with `N` texels across, at the angle `δ` from
/// the direction behind the ball, and the origin of light within a texel is unknown. The energy is accurate to 2 %
/// everywhere; with 192 texels across the direction is accurate to 0.2° from `δ = 35°` on, to 1° at 25°, and to 5.6°
/// nearer (test `behind_a_ball_the_energy_is_found_and_the_place_as_well_as_texels_are_long`). At the rims of the other
/// round pictures suns are found as anywhere.
///
/// The rest may hold a lamp: a small one in a dark room cannot be told from a sun.
/// [`extract_suns`](crate::extract_suns()) finds the next ones.
///
/// # Errors
/// [`NoSun`], which says what the brightest place lacks.
pub fn find_sun(map: &MappedMap, options: &SunOptions) -> Result<SunReport, NoSun> {
    let mut rest = map.clone();
    Ok(SunReport { sun: take_sun(&mut rest, options)?, rest })
}

/// Leaves of a map the rest of [`find_sun`]; unchanged if there is no sun.
pub(crate) fn take_sun(map: &mut MappedMap, options: &SunOptions) -> Result<Sun, NoSun> {
    // Find the brightest texel.
    let peak = brightest(map).ok_or(NoSun::Dark)?;
    let (light, at) = (peak.luminance(), peak.center);
    let times = light / map.mean().luminance();
    if times < options.min_peak {
        return Err(NoSun::Dim { at, times });
    }
    let pitch = pitch(map, peak.at);
    let reach = options.max_radius.max(2.5 * pitch);
    // Collect the bright texels around it; it may lie at the sun's edge, so search twice as far.
    let near = texels_near(map, peak.center, 2.0 * reach + RING[1] * pitch);
    let bright: Vec<Texel> = near.iter().filter(|texel| texel.luminance() >= EDGE * light).copied().collect();
    let (joined, others) = parted(&bright, &peak, JOINED * pitch).ok_or(NoSun::Crowded { at })?;
    // Measure the disc around their centroid; reject one that is too large.
    let center = middle(&joined).ok_or(NoSun::Dark)?;
    let angle = |texel: &Texel| texel.center.angle_to(center);
    let radius = joined.iter().map(angle).fold(0.0, f64::max);
    if radius > reach {
        return Err(NoSun::Large { at, radius });
    }
    // Fit a plane to the ring around the disc; reject what is not bright enough against it.
    let of_others = Neighbors::new(others.iter().map(|texel| texel.center), RING[0] * pitch);
    let near: Vec<Texel> = near.into_iter().filter(|texel| !of_others.has_near(texel.center)).collect();
    let width = (RING[1] - RING[0]) * pitch.min(LONGEST * usual_pitch(map));
    let inner = radius + RING[0] * pitch;
    let in_ring = |texel: &&Texel| angle(texel) > inner && angle(texel) <= inner + width;
    let plane = Plane::fit(center, near.iter().filter(in_ring)).ok_or(NoSun::Crowded { at })?;
    let times = light / plane.at(center).luminance();
    if (0.0..options.min_contrast).contains(&times) {
        return Err(NoSun::Faint { at, times });
    }
    // Replace the disc by the plane, and the overshoot around it by black.
    let (disc, around): (Vec<&Texel>, Vec<&Texel>) = near.iter().partition(|texel| angle(texel) <= inner);
    let mut sun = take_out(map, &disc, &plane).ok_or(NoSun::Dark)?;
    take_halo(map, &around, &mut sun);
    Ok(sun)
}

/// A texel with its direction and solid angle.
#[derive(Clone, Copy)]
struct Texel {
    at: [usize; 2],
    value: Rgb<f32>,
    center: Dir,
    solid_angle: f64,
}

impl Texel {
    /// `None` for a texel outside the discs of a round picture.
    fn new(map: &MappedMap, x: usize, y: usize) -> Option<Self> {
        let center = map.dir(x, y)?;
        let solid_angle = map.solid_angle(x, y);
        (solid_angle > 0.0).then(|| Self { at: [x, y], value: map.texel(x, y), center, solid_angle })
    }

    fn luminance(&self) -> f64 {
        self.value.widen().luminance()
    }
}

/// The texel of the largest luminance, the first of several; `None` if none is positive.
fn brightest(map: &MappedMap) -> Option<Texel> {
    let (mut best, mut largest) = (None, 0.0);
    for (i, texel) in map.texels().iter().enumerate() {
        let luminance = texel.luminance();
        // Texels outside the discs of a round picture may hold any value.
        if luminance > largest
            && let Some(texel) = Texel::new(map, i % map.width(), i / map.width())
        {
            (best, largest) = (Some(texel), luminance);
        }
    }
    best
}

/// The angle between neighboring texels in the longer direction; at a texel that a rim cuts, that of a whole texel next
/// to it.
fn pitch(map: &MappedMap, [x, y]: [usize; 2]) -> f64 {
    let [w, h] = [map.width() as f64, map.height() as f64];
    let middle = [x as f64 + 0.5, y as f64 + 0.5];
    let inwards = inwards(map, middle);
    let at = |step: f64, dx: f64, dy: f64| {
        let (u, v) = ((middle[0] + step * inwards[0] + dx) / w, (middle[1] + step * inwards[1] + dy) / h);
        map.mapping().dir_from_uv(u, v)
    };
    let extents = |step: f64| {
        // Half a texel, because the edges of one at the border of the picture may lie elsewhere on the sphere.
        let extent = |dx: f64, dy: f64| Some(2.0 * at(step, -dx, -dy)?.angle_to(at(step, dx, dy)?));
        Some(extent(0.25, 0.0)?.max(extent(0.0, 0.25)?))
    };
    // A step of three quarters of a diagonal leads from a texel that is nearly cut away to a whole one.
    let whole = [0.0, 0.55, 1.1].into_iter().find_map(extents);
    whole.unwrap_or(0.0).max(usual_pitch(map))
}

/// The side of a square texel of the mean solid angle.
fn usual_pitch(map: &MappedMap) -> f64 {
    (4.0 * PI / (map.width() * map.height()) as f64).sqrt()
}

/// The unit vector from a point of the picture, in texels, to the center of its disc; zero in pictures without discs.
fn inwards(map: &MappedMap, p: [f64; 2]) -> [f64; 2] {
    let [w, h] = [map.width() as f64, map.height() as f64];
    let discs = map.mapping().form().discs();
    if discs == 0 {
        return [0.0; 2];
    }
    let disc = ((discs as f64 * p[0] / w) as usize).min(discs - 1);
    let middle = (2 * disc + 1) as f64 / (2 * discs) as f64 * w;
    let v = [middle - p[0], 0.5 * h - p[1]];
    let length = v[0].hypot(v[1]);
    if length > 0.0 { v.map(|c| c / length) } else { v }
}

/// The texels whose centers lie within an angle of a direction, in the order of the picture.
fn texels_near(map: &MappedMap, center: Dir, angle: f64) -> Vec<Texel> {
    let limit = angle.min(PI).cos();
    let is_near = |x: usize, y: usize| map.dir(x, y).is_some_and(|s| s.dot(center) >= limit);
    let row = |y: usize| {
        (0..map.width()).filter(move |x| is_near(*x, y)).filter_map(move |x| Texel::new(map, x, y)).collect::<Vec<_>>()
    };
    parallel::map(map.height(), &row).concat()
}

/// Bright texels apart: those that are joined to the peak through neighbors within `gap`, and all others; none if the
/// others are more places than [`MOST_OTHERS`].
fn parted(bright: &[Texel], peak: &Texel, gap: f64) -> Option<(Vec<Texel>, Vec<Texel>)> {
    let first = bright.iter().position(|texel| texel.at == peak.at)?;
    let centers: Vec<Dir> = bright.iter().map(|texel| texel.center).collect();
    // The place to which each texel belongs; that of the peak is 0.
    let places = parts(&centers, gap, first, 1 + MOST_OTHERS)?;
    let of = |is_first: bool| bright.iter().zip(&places).filter(move |(_, place)| (**place == 0) == is_first);
    let texels = |is_first| of(is_first).map(|(texel, _)| *texel).collect();
    Some((texels(true), texels(false)))
}

/// The centroid of some texels, weighted by solid angle.
fn middle(texels: &[Texel]) -> Option<Dir> {
    let sum = texels.iter().fold([0.0; 3], |sum, texel| {
        let s = texel.center.to_array();
        [0, 1, 2].map(|k| sum[k] + texel.solid_angle * s[k])
    });
    Dir::new(sum)
}

/// `a + b p + c q` in coordinates `(p, q)` of the tangent plane, per channel.
struct Plane {
    axes: [[f64; 3]; 2],
    coefficients: [Rgb<f64>; 3],
}

impl Plane {
    /// The least-squares plane through texels around `center`, weighted with their solid angles; `None` if there are
    /// fewer than three.
    fn fit<'a>(center: Dir, texels: impl Iterator<Item = &'a Texel>) -> Option<Self> {
        let [p, q] = lobe_sh::sphere::vector::tangents_along_axis(center.to_array());
        let axes = [p, q];
        let mut matrix = [[0.0; 3]; 3];
        let mut right = [Rgb::ZERO; 3];
        let mut count = 0;
        for texel in texels {
            let row = terms(&axes, texel.center);
            for i in 0..3 {
                for j in 0..3 {
                    matrix[i][j] += texel.solid_angle * row[i] * row[j];
                }
                right[i] += texel.value.widen().scale(texel.solid_angle * row[i]);
            }
            count += 1;
        }
        // In a small map the ring may be too lopsided for a plane: then use its mean.
        let mean = [right[0].scale(1.0 / matrix[0][0]), Rgb::ZERO, Rgb::ZERO];
        (count >= 3).then(|| Self { axes, coefficients: solve(matrix, right).unwrap_or(mean) })
    }

    fn at(&self, s: Dir) -> Rgb<f64> {
        let row = terms(&self.axes, s);
        let [a, b, c] = self.coefficients;
        a + b.scale(row[1]) + c.scale(row[2])
    }
}

fn terms(axes: &[[f64; 3]; 2], s: Dir) -> [f64; 3] {
    let along = |axis: [f64; 3]| lobe_sh::sphere::vector::dot(s.to_array(), axis);
    [1.0, along(axes[0]), along(axes[1])]
}

/// Solves three equations by Cramer's rule; `None` if they are nearly dependent.
fn solve(m: [[f64; 3]; 3], right: [Rgb<f64>; 3]) -> Option<[Rgb<f64>; 3]> {
    let cofactor = |i: usize, j: usize| {
        let (r, s, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[r][c] * m[s][d] - m[r][d] * m[s][c]
    };
    let determinant = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum::<f64>();
    if determinant <= LEAST_DETERMINANT * m[0][0] * m[1][1] * m[2][2] {
        return None;
    }
    Some([0, 1, 2].map(|j| (0..3).fold(Rgb::ZERO, |sum, i| sum + right[i].scale(cofactor(i, j) / determinant))))
}

/// Sets negative values around the disc to black and subtracts as much from the sun: the overshoot of a filter that
/// resized the picture. A channel in which the sun has less than that is left unchanged.
fn take_halo(rest: &mut MappedMap, around: &[&Texel], sun: &mut Sun) {
    let missing = around.iter().fold(Rgb::ZERO, |sum: Rgb<f64>, texel| {
        sum + Rgb::from_channels(|c| texel.solid_angle * f64::from(texel.value.channel(c).min(0.0)))
    });
    let is_paid = [0, 1, 2].map(|c| sun.irradiance.channel(c) + missing.channel(c) >= 0.0);
    let width = rest.width();
    for texel in around {
        let fill = Rgb::<f32>::from_channels(|c| {
            let value = texel.value.channel(c);
            if is_paid[c] && value < 0.0 { 0.0 } else { value }
        });
        let [x, y] = texel.at;
        rest.texels_mut()[y * width + x] = fill;
        sun.texels += usize::from(fill != texel.value);
    }
    sun.irradiance += Rgb::from_channels(|c| if is_paid[c] { missing.channel(c) } else { 0.0 });
}

/// Replaces the disc by the plane, and sums the light above it.
fn take_out(rest: &mut MappedMap, disc: &[&Texel], plane: &Plane) -> Option<Sun> {
    let (mapping, size) = (rest.mapping(), [rest.width(), rest.height()]);
    let rule = gauss_legendre(3);
    let mut nodes = Vec::new();
    let (mut irradiance, mut moment, mut squares, mut texels) = (Rgb::ZERO, [0.0; 3], 0.0, 0);
    for texel in disc {
        let [x, y] = texel.at;
        let level = plane.at(texel.center);
        let fill = Rgb::<f32>::from_channels(|c| (level.channel(c) as f32).min(texel.value.channel(c)).max(0.0));
        rest.texels_mut()[y * size[0] + x] = fill;
        let taken = texel.value.widen() - fill.widen();
        texels += usize::from(fill != texel.value);
        irradiance += taken.scale(texel.solid_angle);
        squares += taken.luminance() * taken.luminance() * texel.solid_angle;
        texel_quadrature::nodes_into(mapping, size, texel.at, &rule, &mut nodes);
        for (s, weight) in &nodes {
            let s = s.to_array();
            moment = [0, 1, 2].map(|k| moment[k] + taken.luminance() * weight * s[k]);
        }
    }
    let solid_angle = irradiance.luminance() * irradiance.luminance() / squares;
    let angular_diameter = 4.0 * (solid_angle / (4.0 * PI)).min(1.0).sqrt().asin();
    Some(Sun { direction: Dir::new(moment)?, irradiance, angular_diameter, texels })
}
