//! Fields of lamps against their closed forms.

use std::f64::consts::PI;

use lobe_io::Job;
use lobe_sh::light::SphericalPolygon;
use lobe_sh::sphere::vector::{add, cross, dot, sub};
use lobe_sh::{Dir, Expansion as _, Rgb};
use lobe_shadow::{PatchField, RadialInterpolation, RadianceField, RadianceOptions, Rectangle};
use lobe_testkit::Random;

fn rectangle() -> Rectangle {
    Rectangle { corner: [-1.0, -0.5, 0.2], u: [2.0, 0.0, 0.0], v: [0.0, 1.0, 0.0], two_sided: false }
}

fn polygon(r: &Rectangle, p: [f64; 3], order: usize) -> Vec<f64> {
    let at = |a: f64, b: f64| std::array::from_fn(|k| r.corner[k] + a * r.u[k] + b * r.v[k] - p[k]);
    let corners = vec![at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
    SphericalPolygon::new(corners).unwrap().project(order).into_vec()
}

/// Relative to the constant coefficient.
fn error(field: &RadianceField, truth: impl Fn([f64; 3]) -> Vec<f64>, [near, far]: [f64; 2]) -> f64 {
    let mut random = Random::new(3);
    let (mut errors, mut squares) = (0.0, 0.0);
    for _ in 0..300 {
        let r = near * (far / near).powf(random.unit());
        let mut s = random.direction();
        s[2] = s[2].abs().max(0.02);
        let p: [f64; 3] = std::array::from_fn(|k| field.center()[k] + r * s[k]);
        let found = field.radiance_at(p, RadialInterpolation::Cubic);
        for (found, truth) in found.coefficients().iter().zip(truth(p)) {
            errors += (f64::from(found.g) - truth).powi(2);
            squares += truth * truth;
        }
    }
    f64::sqrt(errors / squares)
}

#[test]
fn a_rectangle_is_its_polygon_and_finer_fields_are_nearer_to_it() {
    let shape = rectangle();
    for (range, bound) in [([0.3, 1.0], 0.2), ([1.2, 3.0], 0.1), ([3.0, 20.0], 0.1)] {
        let errors = [(6, 8), (12, 16), (24, 32)].map(|(spheres, cells)| {
            let options = RadianceOptions::default().spheres(spheres).cells(cells);
            let field = RadianceField::rectangle(&shape, Rgb::new(0.5, 1.0, 2.0), &options).unwrap();
            error(&field, |p| polygon(&shape, p, 4), range)
        });
        assert!(errors[0] > errors[1] && errors[1] > errors[2], "{range:?}: {errors:?}");
        assert!(errors[1] < bound, "{range:?}: {errors:?}, expected below {bound}");
    }
}

#[test]
fn the_back_is_dark_unless_it_shines_too_and_colors_are_factors() {
    let options = RadianceOptions::default().spheres(6).cells(8);
    let field = |two_sided| {
        let shape = Rectangle { two_sided, ..rectangle() };
        RadianceField::rectangle(&shape, Rgb::new(0.5, 1.0, 2.0), &options).unwrap()
    };
    for r in [0.5, 2.0, 50.0] {
        let [front, back] = [0.2 + r, 0.2 - r].map(|z| [0.0, 0.0, z]);
        let at = |field: &RadianceField, p| field.radiance_at(p, RadialInterpolation::Linear);
        assert!(at(&field(false), back).coefficients().iter().all(|c| c.g == 0.0), "the back at {r}");
        let (a, b) = (at(&field(true), front), at(&field(true), back));
        assert!((a[0].g - b[0].g).abs() < 1e-4 * a[0].g, "both sides at {r}: {:?}, {:?}", a[0], b[0]);
        assert!(a.coefficients().iter().all(|c| c.b == 4.0 * c.r && c.g == 2.0 * c.r), "colors at {r}");
    }
}

#[test]
fn a_panel_lights_nothing_behind_its_plane() {
    // Its plane along the planes of the grid of sample points, and across them.
    let oblique = Rectangle { corner: [0.1, -1.0, 0.3], u: [1.0, 0.4, 0.5], v: [-0.3, 1.2, 0.2], two_sided: false };
    let options = RadianceOptions::default();
    for shape in [Rectangle::upright([1.6, 1.2], false), oblique] {
        let field = RadianceField::rectangle(&shape, Rgb::new(0.5, 1.0, 2.0), &options).unwrap();
        let (u, v) = (Dir::new(shape.u).unwrap().to_array(), Dir::new(shape.v).unwrap().to_array());
        let n = Dir::new(cross(shape.u, shape.v)).unwrap().to_array();
        let along = sub(u, n.map(|c| c * dot(u, n)));
        let across = sub(v, n.map(|c| c * dot(v, n)));
        let (mut errors, mut squares) = (0.0, 0.0);
        for k in 0..400_u32 {
            let (r, phi) = (0.3 + 0.05 * f64::from(k % 40), 0.7 * f64::from(k));
            let elevation = [-40.0, -15.0, -5.0, -0.01, 0.5, 3.0, 8.0, 14.0][k as usize % 8] * PI / 180.0;
            let flat = add(along.map(|c| c * phi.cos()), across.map(|c| c * phi.sin()));
            let s: [f64; 3] = std::array::from_fn(|c| flat[c] * elevation.cos() + n[c] * elevation.sin());
            let p = add(field.center(), s.map(|c| c * r));
            for interpolation in [RadialInterpolation::Linear, RadialInterpolation::Cubic] {
                let found = field.radiance_at(p, interpolation);
                if elevation < 0.0 {
                    assert!(
                        found.coefficients().iter().all(|c| c.to_array() == [0.0; 3]),
                        "{elevation} at {r}: {found:?}"
                    );
                    continue;
                }
                for (found, truth) in found.coefficients().iter().zip(polygon(&shape, p, 4)) {
                    errors += (f64::from(found.g) - truth).powi(2);
                    squares += truth * truth;
                }
            }
        }
        let off = f64::sqrt(errors / squares);
        assert!(off < 0.3, "within 14 degrees of the plane in front of it: off by {off}");
    }
}

#[test]
fn the_light_of_a_picture_is_linear_in_it_and_patches_make_up_the_whole() {
    let options = RadianceOptions::default().spheres(8).cells(8).order(3);
    let patches = PatchField::bake(&rectangle(), [4, 2], &options, Job::default()).unwrap();
    assert_eq!(patches.patches(), [4, 2], "patches");
    let white = patches.with_picture(3, &[Rgb::new(1.0, 1.0, 1.0); 6]).unwrap();
    let whole = RadianceField::rectangle(&rectangle(), Rgb::new(1.0, 1.0, 1.0), &options).unwrap();
    assert_eq!((patches.bytes() * 3, white.bytes()), (8 * whole.bytes(), whole.bytes()), "bytes");
    // Two frames of a sequence, and their sum.
    let mut random = Random::new(2);
    let mut frame = || -> Vec<Rgb<f32>> { (0..8 * 6).map(|_| Rgb::new(random.unit(), 0.5, 2.0).map_f32()).collect() };
    let (a, b) = (frame(), frame());
    let sum: Vec<Rgb<f32>> = a.iter().zip(&b).map(|(a, b)| *a + *b).collect();
    let [a, b, sum] = [a, b, sum].map(|picture| patches.with_picture(8, &picture).unwrap());
    // The left half alone is a rectangle of its own.
    let halves: Vec<Rgb<f32>> = (0..8).map(|x| Rgb::new(0.0, if x < 4 { 1.0 } else { 0.0 }, 0.0)).collect();
    let left = patches.with_picture(8, &halves).unwrap();
    let alone = Rectangle { u: [1.0, 0.0, 0.0], ..rectangle() };
    for p in [[0.3, 0.2, 1.0], [-2.0, 1.0, 3.0], [0.0, 0.0, 0.5]] {
        let at = |field: &RadianceField| field.radiance_at(p, RadialInterpolation::Linear);
        for (i, (w, e)) in at(&white).coefficients().iter().zip(at(&whole).coefficients()).enumerate() {
            assert!((w.r - e.r).abs() < 1e-5, "{p:?}, {i}: {w:?} of patches, {e:?} of the whole");
        }
        for (i, c) in at(&sum).coefficients().iter().enumerate() {
            let expected = at(&a)[i] + at(&b)[i];
            assert!((c.r - expected.r).abs() < 1e-5 && (c.b - expected.b).abs() < 1e-4, "{p:?}, {i}");
        }
    }
    let off = error(&left, |p| polygon(&alone, p, 3), [3.0, 20.0]);
    assert!(off < 0.1, "the left half: off by {off}");
}

#[test]
fn what_cannot_be_a_lamp_is_refused_in_one_line() {
    let options = RadianceOptions::default().spheres(4).cells(4);
    let white = Rgb::new(1.0, 1.0, 1.0);
    let flat = Rectangle { v: [1.0, 0.0, 0.0], ..rectangle() };
    let patches = PatchField::bake(&rectangle(), [2, 2], &options, Job::default()).unwrap();
    let bake = |count| PatchField::bake(&rectangle(), count, &options, Job::default()).map(drop);
    for (found, expected) in [
        (RadianceField::rectangle(&flat, white, &options).map(drop), "a rectangle with an area"),
        (RadianceField::ball(3, [0.0; 3], 0.0, white).map(drop), "radius above 0"),
        (RadianceField::ball(9, [0.0; 3], 1.0, white).map(drop), "an order of 1 to 8, found 9"),
        (RadianceField::ball(3, [f64::NAN; 3], 1.0, white).map(drop), "a ball of finite radiance"),
        (bake([0, 1]), "1 to 64 patches"),
        (bake([1, 65]), "1 to 64 patches"),
        (patches.with_colors(&[white]).map(drop), "a radiance for each of 4 patches, found 1"),
        (patches.with_colors(&[Rgb::new(f64::NAN, 0.0, 0.0); 4]).map(drop), "expected finite radiance"),
        (patches.with_picture(3, &[Rgb::new(0.0, 0.0, 0.0); 4]).map(drop), "rows of 3 pixels, found 4"),
        (patches.with_picture(0, &[]).map(drop), "rows of 0 pixels"),
    ] {
        let message = found.unwrap_err().to_string();
        assert!(message.contains(expected) && !message.contains('\n'), "{message}");
    }
}

trait MapF32 {
    fn map_f32(self) -> Rgb<f32>;
}

impl MapF32 for Rgb<f64> {
    fn map_f32(self) -> Rgb<f32> {
        Rgb::from(self.to_array().map(|c| c as f32))
    }
}
