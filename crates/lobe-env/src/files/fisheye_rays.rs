//! Resampling of a round picture along rays from its middle to its rim.
//!
//! With the axis of the lens at the pole of the map, a column of the map is a sector of the picture, and a row a ring. Light
//! is constant over each pixel, as in every map that is integrated, and is summed along rays ψ that are evenly spread:
//!
//! ```text
//!   L'_t = Σ_ψ Σ_p L_p (F(r_leave) - F(r_enter)) / Σ_ψ (F(r_below) - F(r_above))            F = 1 - cos θ
//! ```
//!
//! over the pixels p that a ray crosses between two circles `r_above` and `r_below`, the edges of the row. Along a ray
//! nothing is sampled: the numerators of a constant sum to the denominator, so it stays constant to rounding, and every
//! direction of the circle counts once. Across the rays a pixel is seen by a whole number of them, so that
//!
//! ```text
//!   E_p = Δψ Σ_ψ (F(r_leave) - F(r_enter))      is not quite      Ω_p
//! ```
//!
//! By what is missing, each pixel that stands out of its neighbors is made brighter, as in [`resample`](crate::resample()):
//! `L_p + (Ω_p/E_p - 1) max(0, L_p - m_p)`, m the mean of its neighbors. A sun of one pixel, whose energy would be off by up
//! to a fifth, has it to 1e-5 (test `a_sun_of_one_pixel_keeps_its_energy`).

use std::f64::consts::PI;

use lobe_io::parallel;
use lobe_sh::{Coefficient, Rgb};

use crate::files::cropped::Padding;
use crate::map::env_map::EnvMap;
use crate::mapping::azimuthal::Rect;
use crate::mapping::fisheye::Lens;
use crate::mapping::lat_long::sin_cos_pi;

/// Rays through a pixel at the rim, the farthest from each other. More cost time, and none are missing for constants.
const RAYS: f64 = 4.0;
/// A pixel that exceeds its neighbors by no more than this part of itself is left as it is: what it loses or wins is
/// below a hundredth, and its neighbors win or lose.
const FLAT: f32 = 1.0 / 16.0;
/// The columns of the map that are computed together, one after the other in memory.
const COLUMNS: usize = 256;

/// A picture of which a circle counts.
pub(crate) struct RoundPicture {
    pub(crate) lens: Lens,
    /// Columns and rows.
    pub(crate) size: [usize; 2],
    /// Column and row of the middle of the circle, in pixels from the upper left corner; inside the picture.
    pub(crate) middle: [f64; 2],
    /// The radius of the circle, in pixels.
    pub(crate) radius: f64,
    pub(crate) pixels: Vec<Rgb<f32>>,
}

impl RoundPicture {
    /// The rows, an even number, of a map with about as many texels in the circle as there are pixels: the texels at its
    /// equator have the solid angle Ω of a pixel on average.
    ///
    /// ```text
    ///   H = π/√Ω      Ω = 2π F(1)/(π R²)
    /// ```
    pub(crate) fn rows(lens: &Lens, radius: f64) -> f64 {
        let half = 0.5 * PI * radius / (2.0 * lens.cap(1.0)).sqrt();
        (2.0 * half.round()).max(2.0)
    }

    /// The map of `rows` rows, an even number, and twice as many columns with the axis of the lens towards +z, the top of the
    /// picture towards +x and its right side towards +y.
    pub(crate) fn to_lat_long(&self, rows: usize, padding: Padding) -> EnvMap {
        let width = 2 * rows;
        let sectors = Sectors::new(self, rows, padding);
        let light = sectors.balanced();
        let mut texels = vec![Rgb::ZERO; width * rows];
        for first in (0..width).step_by(COLUMNS) {
            let together = COLUMNS.min(width - first);
            let columns: Vec<Vec<Rgb<f32>>> = parallel::map(together, &|k| sectors.column(first + k, &light));
            parallel::rows(&mut texels, width, &|y, row| {
                for (texel, column) in row[first..].iter_mut().zip(&columns) {
                    *texel = column[y];
                }
            });
        }
        EnvMap::from_rows(width, rows, texels)
    }

    /// The pixel in units of the circle, x to the right and y downwards.
    fn rect(&self, x: usize, y: usize) -> Rect {
        let sides = |i: usize, middle: f64| [i, i + 1].map(|i| (i as f64 - middle) / self.radius);
        Rect { x: sides(x, self.middle[0]), y: sides(y, self.middle[1]) }
    }

    /// What pixel `(x, y)` has more than the mean of its up to eight neighbors in the circle; 0 where it has less.
    fn excess(&self, x: usize, y: usize) -> Rgb<f32> {
        let [width, height] = self.size;
        let own = self.pixels[y * width + x];
        let (mut sum, mut count) = (Rgb::ZERO, 0.0);
        for row in y.saturating_sub(1)..height.min(y + 2) {
            for column in x.saturating_sub(1)..width.min(x + 2) {
                if (column, row) != (x, y) && !self.rect(column, row).is_outside() {
                    sum += self.pixels[row * width + column];
                    count += 1.0;
                }
            }
        }
        let mean = if count > 0.0 { sum.scale(1.0 / count) } else { own };
        Rgb::from((own - mean).to_array().map(|c| c.max(0.0)))
    }
}

/// The rays of a map's columns.
struct Sectors<'a> {
    picture: &'a RoundPicture,
    padding: Padding,
    /// The direction of each ray in the picture, x to the right and y downwards.
    rays: Vec<[f64; 2]>,
    /// The number of rays in each column.
    each: usize,
    /// The distance from the middle, in pixels, of the upper edge of each row and the lower one of the last; infinite
    /// beyond the circle.
    edges: Vec<f64>,
    /// `1 - cos θ` there.
    caps: Vec<f64>,
}

impl<'a> Sectors<'a> {
    fn new(picture: &'a RoundPicture, rows: usize, padding: Padding) -> Self {
        let columns = 2 * rows;
        let each = (RAYS * 2.0 * PI * picture.radius / columns as f64).ceil() as usize;
        let count = each * columns;
        // Ray i is at the azimuth φ from the top to the right, which falls from column to column.
        let ray = |i: usize| {
            let (sin, cos) = sin_cos_pi(1.0 - (2 * i + 1) as f64 / count as f64);
            [sin, -cos]
        };
        let at = |row: usize| row as f64 / rows as f64;
        let edge = |row: usize| {
            let shown = picture.lens.radius(at(row)).filter(|_| row < rows);
            shown.map_or(f64::INFINITY, |r| r * picture.radius)
        };
        let cap = |row: usize| 2.0 * sin_cos_pi(0.5 * at(row)).0.powi(2);
        Self {
            picture,
            padding,
            rays: (0..count).map(ray).collect(),
            each,
            edges: (0..=rows).map(edge).collect(),
            caps: (0..=rows).map(cap).collect(),
        }
    }

    /// The light of every pixel, brighter by what the rays miss of its excess.
    fn balanced(&self) -> Vec<Rgb<f32>> {
        let picture = self.picture;
        let width = picture.size[0];
        let mut light = picture.pixels.clone();
        parallel::rows(&mut light, width, &|y, row| {
            for (x, light) in row.iter_mut().enumerate() {
                let pixel = picture.rect(x, y);
                if pixel.is_outside() {
                    continue;
                }
                let excess = picture.excess(x, y);
                let stands_out = |(excess, own): (f32, f32)| excess > FLAT * own.abs();
                if !excess.to_array().into_iter().zip(light.to_array()).any(stands_out) {
                    continue;
                }
                let seen = self.seen(&pixel);
                if seen > 0.0 {
                    *light += excess.scale((picture.lens.solid_angle(&pixel) / seen - 1.0) as f32);
                }
            }
        });
        light
    }

    /// The solid angle `E_p` that a pixel has by the rays.
    fn seen(&self, pixel: &Rect) -> f64 {
        let lens = &self.picture.lens;
        let along = |i: usize| {
            let [cos, sin] = self.rays[i];
            let (enter, leave) = pixel.ray(sin, cos);
            if leave > enter { lens.cap(leave) - lens.cap(enter) } else { 0.0 }
        };
        2.0 * PI / self.rays.len() as f64 * self.rays_through(pixel).map(along).sum::<f64>()
    }

    /// The rays between the outermost corners of a pixel; all of them if it touches the middle.
    fn rays_through(&self, pixel: &Rect) -> impl Iterator<Item = usize> {
        let count = self.rays.len() as i64;
        let azimuth = |x: f64, y: f64| x.atan2(-y);
        let middle = azimuth(pixel.x[0] + pixel.x[1], pixel.y[0] + pixel.y[1]);
        let corners = pixel.x.into_iter().flat_map(|x| pixel.y.map(|y| azimuth(x, y)));
        let turns = corners.map(|phi| phi - middle).map(|turn| turn - 2.0 * PI * (0.5 * turn / PI).round());
        let [low, high] = turns.fold([0.0_f64; 2], |[low, high], turn| [low.min(turn), high.max(turn)]);
        let index = |phi: f64| 0.5 * (count as f64 * (1.0 - phi / PI) - 1.0);
        let (first, last) = (index(middle + high).ceil() as i64, index(middle + low).floor() as i64);
        let rays = if pixel.nearest() > 0.0 { first..last + 1 } else { 0..count };
        rays.map(move |i| i.rem_euclid(count) as usize)
    }

    /// The texels of a column of the map.
    fn column(&self, x: usize, light: &[Rgb<f32>]) -> Vec<Rgb<f32>> {
        let mut sums: Vec<Rgb<f64>> = vec![Rgb::ZERO; self.caps.len() - 1];
        for ray in &self.rays[x * self.each..(x + 1) * self.each] {
            self.follow(*ray, light, &mut sums);
        }
        let mean = |(sum, caps): (&Rgb<f64>, &[f64])| -> Rgb<f32> {
            Rgb::narrow(sum.scale(1.0 / (self.each as f64 * (caps[1] - caps[0]))))
        };
        sums.iter().zip(self.caps.windows(2)).map(mean).collect()
    }

    /// Adds to the sum of every row what a ray meets in it.
    fn follow(&self, [dx, dy]: [f64; 2], light: &[Rgb<f32>], sums: &mut [Rgb<f64>]) {
        let picture = self.picture;
        let [width, height] = picture.size;
        let (mut across, mut down) = (Steps::new(picture.middle[0], dx), Steps::new(picture.middle[1], dy));
        let end = picture.radius.min(across.to_end(width)).min(down.to_end(height));
        let (mut row, mut start) = (0, 0.0);
        let last = loop {
            let pixel = light[down.at * width + across.at].widen();
            let edge = self.edges[row + 1];
            let stop = across.next.min(down.next).min(edge).min(end);
            let cap = if stop >= edge { self.caps[row + 1] } else { picture.lens.cap(stop / picture.radius) };
            sums[row] += pixel.scale(cap - start);
            start = cap;
            if stop >= end {
                // As the picture has it: what rays miss of a pixel of the rim is no light beyond it.
                break picture.pixels[down.at * width + across.at].widen();
            }
            row += usize::from(stop >= edge);
            across.pass(stop);
            down.pass(stop);
        };
        if self.padding == Padding::Edge {
            for (sum, cap) in sums[row..].iter_mut().zip(&self.caps[row + 1..]) {
                *sum += last.scale(cap - start);
                start = *cap;
            }
        }
    }
}

/// The columns, or the rows, of pixels that a ray crosses.
struct Steps {
    /// Where the ray begins.
    from: f64,
    /// How far it moves across the columns for each pixel of its length.
    slope: f64,
    /// The column in which it is.
    at: usize,
    /// The length at which it leaves that column.
    next: f64,
}

impl Steps {
    /// From a place inside the picture.
    fn new(from: f64, slope: f64) -> Self {
        let at = if slope < 0.0 { from.ceil() - 1.0 } else { from.floor() };
        let mut steps = Self { from, slope, at: at as usize, next: 0.0 };
        steps.next = steps.to_border(steps.at + steps.ahead());
        steps
    }

    /// The columns from the left border of one to the border ahead.
    fn ahead(&self) -> usize {
        usize::from(self.slope > 0.0)
    }

    /// The length at which the ray comes to the left border of a column.
    fn to_border(&self, column: usize) -> f64 {
        if self.slope == 0.0 { f64::INFINITY } else { (column as f64 - self.from) / self.slope }
    }

    /// The length at which the ray leaves a picture of so many columns.
    fn to_end(&self, columns: usize) -> f64 {
        self.to_border(columns * self.ahead())
    }

    /// Goes on to the next column if the ray leaves its own at this length, which is before the end of the picture.
    fn pass(&mut self, stop: f64) {
        if stop >= self.next {
            self.at = if self.slope > 0.0 { self.at + 1 } else { self.at - 1 };
            self.next = self.to_border(self.at + self.ahead());
        }
    }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;
    use crate::mapping::fisheye::FisheyeProjection;

    /// Pictures of all lenses, whose circle is not in the middle.
    fn round_pictures(pixel: impl Fn(usize, usize) -> f32) -> Vec<RoundPicture> {
        const SIZE: [usize; 2] = [30, 26];
        let of_lens = |(projection, degrees): (FisheyeProjection, f64)| {
            let pixels = (0..SIZE[0] * SIZE[1]).map(|i| Rgb::new(pixel(i % SIZE[0], i / SIZE[0]), 1.0, 0.0)).collect();
            let lens = Lens::new(projection, degrees.to_radians()).unwrap();
            RoundPicture { lens, size: SIZE, middle: [14.2, 13.0], radius: 12.7, pixels }
        };
        let fields = [100.0, 180.0];
        let all = FisheyeProjection::ALL.into_iter().flat_map(|projection| fields.map(|degrees| (projection, degrees)));
        let wide = [FisheyeProjection::Equidistant, FisheyeProjection::Equisolid].map(|whole| (whole, 360.0));
        all.chain(wide).map(of_lens).collect()
    }

    fn map_of(picture: &RoundPicture) -> EnvMap {
        let rows = RoundPicture::rows(&picture.lens, picture.radius) as usize;
        picture.to_lat_long(rows, Padding::Black)
    }

    /// The integral of the first channel over the sphere.
    fn energy(map: &EnvMap) -> f64 {
        4.0 * PI * map.mean().r
    }

    /// The first channel of the pixels times their exact solid angles.
    fn exact_energy(picture: &RoundPicture) -> f64 {
        let width = picture.size[0];
        let of_pixel = |(i, light): (usize, &Rgb<f32>)| {
            f64::from(light.r) * picture.lens.solid_angle(&picture.rect(i % width, i / width))
        };
        picture.pixels.iter().enumerate().map(of_pixel).sum()
    }

    #[test]
    fn a_constant_stays_constant_and_has_its_energy() {
        for picture in round_pictures(|_, _| 1.0) {
            let (map, exact) = (map_of(&picture), exact_energy(&picture));
            let found = energy(&map);
            assert!((found / exact - 1.0).abs() < 1e-6, "{:?}: {found} against {exact}", picture.lens);
            let inside =
                (0..map.height()).take_while(|&y| picture.lens.radius((y + 1) as f64 / map.height() as f64).is_some());
            for texel in inside.flat_map(|y| map.row(y)) {
                assert!((texel.r - 1.0).abs() < 1e-6 && texel.b == 0.0, "{:?}: {texel:?}", picture.lens);
            }
        }
    }

    #[test]
    fn the_energy_of_any_picture_is_kept() {
        // A few percent of a pixel are in error at random, of four hundred.
        const LOST: f64 = 2e-3;
        for seed in 1..4 {
            let mut random = Random::new(seed);
            let noise: Vec<f32> = (0..30 * 26).map(|_| random.unit() as f32).collect();
            for picture in round_pictures(|x, y| noise[y * 30 + x]) {
                let (found, exact) = (energy(&map_of(&picture)), exact_energy(&picture));
                assert!((found / exact - 1.0).abs() < LOST, "{:?}: {found} against {exact}", picture.lens);
            }
        }
    }

    #[test]
    fn a_sun_of_one_pixel_keeps_its_energy() {
        // The axes, where rays and edges run side by side; the middle; near the rim; the diagonal; anywhere.
        for sun in [(14, 12), (14, 1), (2, 12), (26, 13), (14, 24), (22, 5), (7, 19), (9, 6), (20, 16)] {
            for picture in round_pictures(|x, y| if (x, y) == sun { 1e4 } else { 0.0 }) {
                let (found, exact) = (energy(&map_of(&picture)), exact_energy(&picture));
                assert!((found / exact - 1.0).abs() < 1e-5, "{:?}, {sun:?}: {found} against {exact}", picture.lens);
            }
        }
    }
}
