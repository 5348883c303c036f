//! Functions on the sphere as lat-long pictures.

use std::f64::consts::PI;

use lobe_sh::{Coefficient, Dir, Expansion, Rgb};
use rayon::prelude::*;

use crate::Picture;

/// The lat-long picture of a function: top row +z, centre +x, right of the centre -y.
///
/// ```text
///   φ = π (1 - 2u)      θ = π v        (u, v) in [0, 1]² from the top left, at the centres of the pixels
/// ```
#[must_use]
pub fn lat_long_picture(width: usize, height: usize, f: impl Fn(Dir) -> Rgb<f64> + Sync) -> Picture {
    Picture::from_fn(width, height, |x, y| {
        let (u, v) = ((x as f64 + 0.5) / width as f64, (y as f64 + 0.5) / height as f64);
        Rgb::narrow(f(Dir::from_angles(PI * v, PI * (1.0 - 2.0 * u))))
    })
}

/// The lat-long picture of an expansion, evaluated a row at a time.
#[must_use]
pub fn lat_long_picture_of<T: Coefficient<Wide = Rgb<f64>>>(
    width: usize,
    height: usize,
    f: &(impl Expansion<T> + Sync),
) -> Picture {
    let wide: Vec<Rgb<f64>> = f.coefficients().iter().map(|c| c.widen()).collect();
    let f = lobe_sh::ShVec::from_vec(wide).unwrap_or_else(|| unreachable!("an expansion has n² coefficients"));
    let (sin, cos): (Vec<f64>, Vec<f64>) =
        (0..width).map(|x| (PI * (1.0 - (2 * x + 1) as f64 / width as f64)).sin_cos()).unzip();
    let rows = (0..height).into_par_iter().flat_map_iter(|y| {
        let (sin_theta, cos_theta) = (PI * (y as f64 + 0.5) / height as f64).sin_cos();
        let component = |v: &[f64]| v.iter().map(|c| c * sin_theta).collect::<Vec<_>>();
        let mut out = vec![Rgb::ZERO; width];
        f.eval_many_into(&component(&cos), &component(&sin), &vec![cos_theta; width], &mut out);
        out.into_iter().map(Rgb::<f32>::narrow)
    });
    Picture::new(width, height, rows.collect()).unwrap_or_else(|_| unreachable!("every row has its pixels"))
}

#[cfg(test)]
mod tests {
    use lobe_sh::ShVec;
    use lobe_testkit::Random;

    use super::*;

    #[test]
    fn the_axes_lie_where_the_convention_puts_them() {
        let picture = lat_long_picture(400, 200, |s| Rgb::new(s.x(), s.y(), s.z()));
        let places = [
            ("+x", (200, 100), [1.0, 0.0, 0.0]),
            ("-y", (300, 100), [0.0, -1.0, 0.0]),
            ("+y", (100, 100), [0.0, 1.0, 0.0]),
            ("-x", (0, 100), [-1.0, 0.0, 0.0]),
            ("+z", (50, 0), [0.0, 0.0, 1.0]),
            ("-z", (350, 199), [0.0, 0.0, -1.0]),
        ];
        for (name, (x, y), expected) in places {
            let found = picture.pixel(x, y).to_array();
            // A pixel is 0.9° wide; its centre is half of that from the axis.
            let off = (0..3).map(|k| (f64::from(found[k]) - expected[k]).abs()).fold(0.0, f64::max);
            assert!(off < 0.02, "{name} at ({x}, {y}): found {found:?}");
        }
    }

    #[test]
    fn both_routes_draw_the_same_expansion() {
        let mut random = Random::new(11);
        let f = ShVec::from_vec((0..36).map(|_| Rgb::<f64>::from_channels(|_| random.signed())).collect()).unwrap();
        let (a, b) = (lat_long_picture(30, 17, |s| f.eval(s)), lat_long_picture_of(30, 17, &f));
        for (i, (a, b)) in a.pixels().iter().zip(b.pixels()).enumerate() {
            for c in 0..3 {
                assert!((a.channel(c) - b.channel(c)).abs() < 1e-6, "pixel {i}: {a:?} and {b:?}");
            }
        }
    }
}
