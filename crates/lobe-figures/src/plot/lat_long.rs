//! Functions on the sphere as lat-long pictures.

use lobe_env::{lat_long, reconstruct};
use lobe_sh::{Coefficient, Dir, Expansion, Rgb, ShVec};

use lobe_image::Picture;

/// The lat-long picture of a function: its values towards the centers of the pixels, laid out as [`lat_long`] shows.
#[must_use]
pub fn lat_long_picture(width: usize, height: usize, f: impl Fn(Dir) -> Rgb<f64> + Sync) -> Picture {
    Picture::from_fn(width, height, |x, y| {
        let (u, v) = ((x as f64 + 0.5) / width as f64, (y as f64 + 0.5) / height as f64);
        Rgb::narrow(f(lat_long::dir_from_uv(u, v)))
    })
}

/// The lat-long picture of an expansion, by the separable sums of [`reconstruct`].
#[must_use]
pub fn lat_long_picture_of<T: Coefficient<Wide = Rgb<f64>>>(
    width: usize,
    height: usize,
    f: &(impl Expansion<T> + Sync),
) -> Picture {
    if width == 0 || height == 0 {
        return Picture::filled(width, height, Rgb::ZERO);
    }
    let wide: Vec<Rgb<f64>> = f.coefficients().iter().map(|c| c.widen()).collect();
    let f = ShVec::from_vec(wide).unwrap_or_else(|| unreachable!("an expansion has n² coefficients"));
    Picture::from(&reconstruct(&f, width, height))
}

#[cfg(test)]
mod tests {
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
            let found = picture.pixel(x, y);
            // A pixel is 0.9° wide; its center is half of that from the axis.
            let off = (0..3).map(|k| (f64::from(found[k]) - expected[k]).abs()).fold(0.0, f64::max);
            assert!(off < 0.02, "{name} at ({x}, {y}): found {found:?}");
        }
    }

    #[test]
    fn a_picture_without_pixels_has_none() {
        let f = ShVec::constant(3, Rgb::splat(1.0_f64));
        for (w, h) in [(0, 0), (0, 5), (5, 0)] {
            let pictures = [lat_long_picture_of(w, h, &f), lat_long_picture(w, h, |s| f.eval(s))];
            for picture in pictures {
                assert_eq!((picture.width(), picture.height(), picture.pixels().len()), (w, h, 0), "{w} x {h}");
            }
        }
    }

    #[test]
    fn both_routes_draw_the_same_expansion() {
        let mut random = Random::new(11);
        let f = ShVec::from_vec((0..36).map(|_| Rgb::<f64>::from_channels(|_| random.signed())).collect()).unwrap();
        let (a, b) = (lat_long_picture(30, 17, |s| f.eval(s)), lat_long_picture_of(30, 17, &f));
        for (i, (a, b)) in a.pixels().iter().zip(b.pixels()).enumerate() {
            for c in 0..3 {
                assert!((a[c] - b[c]).abs() < 1e-6, "pixel {i}: {a:?} and {b:?}");
            }
        }
    }
}
