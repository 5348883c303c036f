//! Balloon plots: a function on the sphere as the surface `r = |f(s)|`, colored by its sign.

use lobe_io::parallel;
use lobe_sh::{Coefficient, Dir, Rgb};

use crate::plot::mesh::{Mesh, Vertex};
use crate::plot::z_buffer::{Hit, by_band, visible};
use lobe_image::{Picture, Pixel};
use lobe_render::View;
use lobe_sh::sphere::vector::{Vec3, add, dot, normalized, scale};

/// Samples along the edge of a pixel: 16 a pixel make silhouettes smooth.
const SAMPLES: usize = 4;
/// Rows of pixels that are rasterized together.
const BAND: usize = 16;
/// Pixels of the picture for each cell of the mesh along a face. A sphere that fills the picture has a silhouette of
/// straight pieces of `4 · 90° / size`, which miss the circle by less than `2.5 / size` pixels.
const PIXELS_PER_CELL: usize = 4;
/// The part of half the picture that the extent of the balloon fills.
const FILL: f64 = 0.94;

const RED: Rgb<f32> = Rgb::new(0.72, 0.030, 0.025);
const BLUE: Rgb<f32> = Rgb::new(0.025, 0.085, 0.70);

/// A picture of the surface `r = |f(s)|`, red where `f` is positive and blue where it is negative.
#[derive(Clone, Copy, Debug)]
pub struct Balloon {
    /// The number of columns and of rows.
    pub size: usize,
    /// The view of the surface.
    pub view: View,
    /// The distance from the origin that reaches the border of the picture; `None`: the largest that occurs.
    pub extent: Option<f64>,
    /// The color around the surface.
    pub background: Rgb<f32>,
}

/// The directions of the lights.
struct Lights {
    key: Vec3,
    /// Between the key light and the eye.
    halfway: Vec3,
}

impl Lights {
    fn new() -> Self {
        let key = normalized([-0.45, 0.65, 0.75]);
        Self { key, halfway: normalized(add(key, [0.0, 0.0, 1.0])) }
    }
}

impl Balloon {
    /// A balloon on white that fills the picture, in the three-quarter view.
    #[must_use]
    pub fn new(size: usize) -> Self {
        Self { size, view: View::three_quarter(), extent: None, background: Rgb::new(1.0, 1.0, 1.0) }
    }

    /// Draws `f`, which should be smooth: normals are found by differences over 1e-4 rad.
    ///
    /// A function that is zero everywhere has no surface; where it is not finite there is a hole (test
    /// `infinity_is_a_hole_and_nothing_else`).
    #[must_use]
    pub fn picture(&self, f: impl Fn(Dir) -> f64 + Sync) -> Picture {
        self.drawn(&Mesh::of((self.size / PIXELS_PER_CELL).max(16), &f))
    }

    fn drawn(&self, mesh: &Mesh) -> Picture {
        let pixels_per_unit = FILL * 0.5 * self.size as f64 / self.extent.unwrap_or_else(|| mesh.extent());
        let corners = self.corners(mesh, pixels_per_unit * SAMPLES as f64);
        let mut picture = Picture::filled(self.size, self.size, self.background);
        if self.size > 0 {
            let bands = by_band(&corners, &mesh.triangles, BAND * SAMPLES, self.size.div_ceil(BAND));
            parallel::rows(picture.pixels_mut(), BAND * self.size, &|band, pixels| {
                self.draw_band(mesh, &corners, &bands[band], band * BAND, pixels);
            });
        }
        picture
    }

    /// The vertices in the picture, in samples from the top left, and their depth.
    fn corners(&self, mesh: &Mesh, samples_per_unit: f64) -> Vec<Vec3> {
        let middle = 0.5 * (self.size * SAMPLES) as f64;
        let place = |v: &Vertex| {
            let [right, up, forward] = scale(self.view.project(v.position), samples_per_unit);
            [middle + right, middle - up, forward]
        };
        mesh.vertices.iter().map(place).collect()
    }

    /// Draws the rows of `pixels`, of which the first is `first_row`: every pixel is the mean of its samples.
    fn draw_band(&self, mesh: &Mesh, corners: &[Vec3], of_band: &[usize], first_row: usize, pixels: &mut [Pixel]) {
        // Rasterize the samples of the band.
        let (width, rows) = (self.size * SAMPLES, pixels.len() / self.size * SAMPLES);
        let hits = visible(corners, &mesh.triangles, of_band, width, first_row * SAMPLES, rows);
        let lights = Lights::new();
        // Shade the samples of each pixel, and take their mean.
        for (i, pixel) in pixels.iter_mut().enumerate() {
            let (x, y) = (i % self.size * SAMPLES, i / self.size * SAMPLES);
            let mut sum = Rgb::ZERO;
            for k in 0..SAMPLES * SAMPLES {
                let hit = &hits[(y + k / SAMPLES) * width + x + k % SAMPLES];
                sum += hit.as_ref().map_or(self.background, |hit| self.shade(mesh, hit, &lights));
            }
            *pixel = sum.scale(1.0 / (SAMPLES * SAMPLES) as f32).into();
        }
    }

    /// The color of the surface: diffuse light from the upper left, a weaker light from all around that is stronger
    /// from above, and a highlight.
    fn shade(&self, mesh: &Mesh, hit: &Hit, lights: &Lights) -> Rgb<f32> {
        // Interpolate the normal and the value between the corners.
        let mut normal = [0.0; 3];
        let mut value = 0.0;
        for (&corner, &weight) in mesh.triangles[hit.triangle].iter().zip(&hit.weights) {
            let corner = &mesh.vertices[corner];
            normal = add(normal, scale(corner.normal, weight));
            value += weight * corner.value;
        }
        // Shade with a key light, an ambient light and a highlight.
        let n = normalized(self.view.project(normal));
        let diffuse = 0.38 + 0.10 * n[1] + 0.72 * dot(n, lights.key).max(0.0);
        let highlight = 0.16 * dot(n, lights.halfway).max(0.0).powi(32);
        let color = if value >= 0.0 { RED } else { BLUE };
        color.scale(diffuse as f32) + Rgb::splat(highlight as f32)
    }
}

#[cfg(test)]
mod tests {
    use lobe_sh::ShVec;
    use lobe_sh::basis::coefficient_index;

    use super::*;

    fn of_basis(l: usize, m: isize) -> impl Fn(Dir) -> f64 {
        use lobe_sh::Expansion;
        let mut f = ShVec::<f64>::zero(l + 1);
        f[coefficient_index(l, m)] = 1.0;
        move |s| f.eval(s)
    }

    fn is_red([r, _, b]: Pixel) -> bool {
        r > 1.5 * b
    }

    fn is_blue([r, _, b]: Pixel) -> bool {
        b > 1.5 * r
    }

    #[test]
    fn the_first_zonal_function_is_symmetric_with_red_above_and_blue_below() {
        let view = View::from_eye(Dir::X);
        let picture = Balloon { view, ..Balloon::new(80) }.picture(of_basis(1, 0));
        assert!(is_red(picture.pixel(40, 15)) && is_blue(picture.pixel(40, 65)), "above and below the middle");
        for y in 0..80 {
            for x in 0..40 {
                let filled = |x, y| picture.pixel(x, y) != [1.0; 3];
                let places = [(79 - x, y), (x, 79 - y)];
                for (u, v) in places {
                    assert_eq!(filled(x, y), filled(u, v), "the outline at ({x}, {y}) and ({u}, {v})");
                }
                let c = picture.pixel(x, y);
                assert!(if y < 40 { !is_blue(c) } else { !is_red(c) }, "the color at ({x}, {y}): {c:?}");
            }
        }
    }

    #[test]
    fn lobes_point_where_the_function_is_large() {
        // y_1^1 ∝ -x and y_1^-1 ∝ -y: seen from +x, the blue lobe of the second lies on the right.
        let front = Balloon { view: View::from_eye(Dir::X), ..Balloon::new(60) };
        assert!(is_blue(front.picture(of_basis(1, 1)).pixel(30, 30)), "-x is hidden behind +x");
        let sideways = front.picture(of_basis(1, -1));
        assert!(is_blue(sideways.pixel(45, 30)) && is_red(sideways.pixel(15, 30)), "+y is seen on the right");
    }

    #[test]
    fn a_constant_is_a_disc_of_the_right_size() {
        let balloon = Balloon { extent: Some(2.0), background: Rgb::ZERO, ..Balloon::new(120) };
        let picture = balloon.picture(|_| 1.0);
        let covered = picture.pixels().iter().filter(|c| c[0] > 0.0).count() as f64;
        let disc = std::f64::consts::PI * (FILL * 30.0_f64).powi(2);
        assert!((covered / disc - 1.0).abs() < 0.08, "{covered} pixels are touched by a disc of {disc}");
    }

    #[test]
    fn infinity_is_a_hole_and_nothing_else() {
        let view = View::from_eye(Dir::X);
        let balloon = Balloon { view, ..Balloon::new(80) };
        for hole in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
            let picture = balloon.picture(|s| if s.z() > 0.5 { hole } else { 1.0 });
            assert_eq!(picture.pixel(40, 4), [1.0; 3], "{hole}: the hole at the top");
            assert!(is_red(picture.pixel(40, 60)) && is_red(picture.pixel(10, 45)), "{hole}: the rest of the sphere");
        }
    }

    #[test]
    fn zero_has_no_surface() {
        let picture = Balloon::new(20).picture(|_| 0.0);
        assert!(picture.pixels().iter().all(|&c| c == [1.0; 3]), "nothing but background");
    }
}
