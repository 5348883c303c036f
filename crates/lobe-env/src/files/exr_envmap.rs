//! OpenEXR environment maps, declared by the attribute `envmap`.
//!
//! Their outer texel centers lie on the edges, not half a texel inside: texel `i` of `n` lies at the fraction `i/(n -
//! 1)`. The first and the last column of a lat-long map show the same directions; so do the adjacent rows of
//! neighboring faces of a cube. Directions, of which y is up, and the corners of faces are those of the figure in
//! `ImfEnvmap.h` of OpenEXR.
//!
//! In the format the center of a lat-long picture looks along +z and +x lies left of it. Here the center is +x, as in
//! every lat-long picture, and the cube is turned with it, so that both show one sky alike:
//!
//! ```text
//!   (x, y, z)_lobe = (Z, X, Y)_exr
//! ```

use lobe_io::parallel;
use lobe_sh::{Coefficient, Rgb};

use crate::map::cube_map::CubeMap;
use crate::map::env_map::EnvMap;
use crate::mapping::cube::FACES;

/// The stored face that looks along each face of Lobe: +x is OpenEXR's +Z, up is its +Y, -y is its -X.
const STORED_FACES: [usize; FACES] = [4, 5, 2, 3, 1, 0];

/// Resamples a lat-long map to texel centers half a texel inside, bilinearly.
pub(crate) fn lat_long_from_edges(stored: &EnvMap) -> EnvMap {
    let (width, height) = (stored.width(), stored.height());
    let mut texels = vec![Rgb::ZERO; width * height];
    parallel::rows(&mut texels, width, &|y, row| {
        for (x, texel) in row.iter_mut().enumerate() {
            *texel = bilinear(stored.texels(), (width, height), center(x, width), center(y, height));
        }
    });
    EnvMap::from_rows(width, height, texels)
}

/// Resamples a cube map whose six faces are as OpenEXR stores them.
///
/// Each texel of the result looks up its own direction among the stored ones, bilinearly within one face.
pub(crate) fn cube_from_edges(stored: &CubeMap) -> CubeMap {
    let size = stored.size();
    let mut map = stored.clone();
    parallel::rows(map.texels_mut(), size, &|row, line| {
        let (face, y) = (row / size, row % size);
        let from = STORED_FACES[face];
        for (x, texel) in line.iter_mut().enumerate() {
            let [lx, ly, lz] = stored.dir(face, x, y).to_array();
            let (u, v) = place_in_face(from, [ly, lz, lx]);
            *texel = bilinear(stored.face(from), (size, size), u, v);
        }
    });
    map
}

/// The position of a direction on a face, `[0, 1]` to the right and downwards, in OpenEXR's axes.
///
/// ```text
///   face   +X  -X  +Y  -Y  +Z  -Z
///   right  +Z  -Z  +X  +X  -X  +X
///   down   -Y  -Y  -Z  +Z  -Y  -Y
/// ```
fn place_in_face(face: usize, [x, y, z]: [f64; 3]) -> (f64, f64) {
    let (major, right, down) = match face {
        0 => (x, z, -y),
        1 => (-x, -z, -y),
        2 => (y, x, -z),
        3 => (-y, x, z),
        4 => (z, -x, -y),
        _ => (-z, x, -y),
    };
    (0.5 + 0.5 * right / major, 0.5 + 0.5 * down / major)
}

/// The center of texel `i` of `n` in `[0, 1]`.
fn center(i: usize, n: usize) -> f64 {
    (i as f64 + 0.5) / n as f64
}

/// The value at `(u, v)` in `[0, 1]` of a picture whose outer texels lie on its edges.
fn bilinear(texels: &[Rgb<f32>], (width, height): (usize, usize), u: f64, v: f64) -> Rgb<f32> {
    let split = |t: f64, n: usize| {
        let position = t.clamp(0.0, 1.0) * (n - 1) as f64;
        let first = (position as usize).min(n.saturating_sub(2));
        (first, (first + 1).min(n - 1), position - first as f64)
    };
    let ((x0, x1, s), (y0, y1, t)) = (split(u, width), split(v, height));
    // In f64: fractions of the largest f32 may sum to more than it.
    let row = |y: usize| texels[y * width + x0].widen().scale(1.0 - s) + texels[y * width + x1].widen().scale(s);
    Rgb::narrow(row(y0).scale(1.0 - t) + row(y1).scale(t))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_of_directions_shows_each_direction_where_it_is() {
        // The corners of the faces as the figure numbers them: bit 0 is x, bit 1 is y, bit 2 is z.
        let corners = [[3, 7, 1, 5], [6, 2, 4, 0], [6, 7, 2, 3], [0, 1, 4, 5], [7, 6, 5, 4], [2, 3, 0, 1]];
        for size in [2, 3, 8] {
            let point = |corner: usize| [0, 1, 2].map(|axis| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 });
            let mut stack = Vec::new();
            for face in corners {
                for y in 0..size {
                    for x in 0..size {
                        let (s, t) = (x as f32 / (size - 1) as f32, y as f32 / (size - 1) as f32);
                        let [a, b, c, d] = face.map(|corner| Rgb::from(point(corner)));
                        stack.push(
                            (a.scale(1.0 - s) + b.scale(s)).scale(1.0 - t) + (c.scale(1.0 - s) + d.scale(s)).scale(t),
                        );
                    }
                }
            }
            let map = cube_from_edges(&CubeMap::new(size, stack).unwrap());
            for face in 0..6 {
                for (x, y) in [(0, 0), (size - 1, 0), (size / 2, size - 1)] {
                    let [px, py, pz] = map.texel(face, x, y).to_array();
                    let length = (px * px + py * py + pz * pz).sqrt();
                    let found = [pz, px, py].map(|c| f64::from(c / length));
                    let dir = map.dir(face, x, y).to_array();
                    let error = (0..3).map(|i| (found[i] - dir[i]).abs()).fold(0.0, f64::max);
                    assert!(error < 1e-6, "face {face} of {size} at ({x}, {y}): {found:?} against {dir:?}");
                }
            }
        }
    }

    #[test]
    fn a_lat_long_map_moves_by_less_than_half_a_texel() {
        let (w, h) = (32, 16);
        // On the edges: the angle itself is stored, so that it can be read off again.
        let texels = (0..w * h).map(|i| Rgb::new((i % w) as f32 / 31.0, (i / w) as f32 / 15.0, 1.0)).collect();
        let map = lat_long_from_edges(&EnvMap::new(w, h, texels).unwrap());
        for (x, y) in [(0, 0), (31, 15), (16, 7), (5, 12)] {
            let texel = map.texel(x, y);
            let (u, v) = ((x as f32 + 0.5) / 32.0, (y as f32 + 0.5) / 16.0);
            assert!((texel.r - u).abs() < 1e-6 && (texel.g - v).abs() < 1e-6, "({x}, {y}): {texel:?} against {u} {v}");
        }
    }

    #[test]
    fn the_largest_number_stays_finite() {
        let brightest = Rgb::new(f32::MAX, f32::MAX, -f32::MAX);
        let map = lat_long_from_edges(&EnvMap::new(34, 17, vec![brightest; 34 * 17]).unwrap());
        assert!(map.texels().iter().all(|t| *t == brightest), "lat-long: {:?}", map.texels());
        let cube = cube_from_edges(&CubeMap::new(7, vec![brightest; 6 * 49]).unwrap());
        assert!(cube.texels().iter().all(|t| *t == brightest), "cube: {:?}", cube.texels());
    }

    #[test]
    fn a_picture_of_one_texel_stays_one_color() {
        let color = Rgb::new(1.0, 2.0, 3.0);
        let map = cube_from_edges(&CubeMap::new(1, vec![color; 6]).unwrap());
        assert!(map.texels().iter().all(|t| *t == color), "{map:?}");
    }
}
