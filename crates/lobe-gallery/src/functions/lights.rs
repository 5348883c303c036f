//! Sections about analytic lights: projections in a few bands beside the lights themselves.

use lobe::figures::Curve2d;
use lobe::sh::light::{Normalization, SphericalPolygon};
use lobe::sh::{Dir, Expansion as _, Light, Rgb, ShVec, Zonal};

use crate::error::Drawn;
use crate::page::{BLACK, BLUE, Canvas, GREEN, RED, digits};

/// The half angles of the cones in degrees, and their colors.
const CONES: [(f64, &str, [u8; 3]); 4] =
    [(90.0, "90°", GREEN), (45.0, "45°", RED), (30.0, "30°", BLUE), (12.5, "12.5°", BLACK)];

pub(crate) fn kernels(canvas: &mut Canvas<'_>) -> Drawn {
    let [three, five] = [3, 5].map(Zonal::clamped_cosine);
    canvas.text(&format!(
            "The cosine of a diffuse surface ends at the horizon, its expansion does not. Order 3 is {} too bright at its peak \
             and has a lobe of {} at the opposite pole; order 5 has one of {} there, which is negative.",
            digits(three.eval(1.0) - 1.0),
            digits(three.eval(-1.0)),
            digits(five.eval(-1.0)),
        ));
    let truth = |t: f64| t.max(0.0);
    let curves = [
        Curve2d::of_angle("order 3", RED, false, |t| three.eval(t.cos())),
        Curve2d::of_angle("order 5", BLUE, false, |t| five.eval(t.cos())),
        Curve2d::of_angle("the cosine", BLACK, true, |t| truth(t.cos())),
    ];
    canvas.profiles("kernel.svg", &curves, "over the angle from the normal")?;
    for (order, kernel) in [(3, &three), (5, &five)] {
        let file = format!("kernel-polar-{order}.svg");
        let caption = format!("order {order} in polar form: red is positive, blue negative, the cosine dashed");
        canvas.polar_xz(&file, 1.1, &|s| kernel.eval(s.z()), &|s| truth(s.z()), &caption)?;
    }
    canvas.command(
        "lobe light directional --dir 0,0,1 --order 5 --normalize none -o sun.sh.json\n\
             lobe sh convolve sun.sh.json --kernel cosine -o - | lobe sh plot - --style polar -o kernel.svg",
    );
    Ok(())
}

pub(crate) fn cones(canvas: &mut Canvas<'_>) -> Drawn {
    canvas.text(
            "Discs of radiance 1 and of half angles 90°, 45°, 30° and 12.5°, and discs that fade to their edge, from closed forms \
             for any order. The smaller and harder the disc, the more its expansion overshoots, falls short and rings below zero.",
        );
    for order in [4, 6] {
        let hard = CONES.map(|(degrees, ..)| Zonal::cone(order, degrees.to_radians()));
        let soft = CONES.map(|(degrees, ..)| Zonal::soft_cone(order, degrees.to_radians()));
        let is_inside = |angle: f64, theta: f64| if theta <= angle { 1.0 } else { 0.0 };
        let caption = format!("hard discs at order {order}, the truth dashed");
        canvas.profiles(&format!("cones-hard-{order}.svg"), &cone_curves(&hard, is_inside), &caption)?;
        let ease = |angle: f64, theta: f64| {
            let x = (theta / angle).min(1.0);
            2.0 * x.powi(3) - 3.0 * x * x + 1.0
        };
        let caption = format!("soft discs at order {order}, the truth dashed");
        canvas.profiles(&format!("cones-soft-{order}.svg"), &cone_curves(&soft, ease), &caption)?;
    }
    canvas.command(
        "lobe light soft-cone --dir 0,0,1 --half-angle 30 --order 6 --normalize none -o cone.sh.json\n\
             lobe sh plot cone.sh.json --style polar -o cone.svg",
    );
    Ok(())
}

/// The extent of the window of [`window_of_a_room`] to either side, and up, at distance 1.
const WINDOW: [f64; 2] = [0.6, 0.8];

/// Lights that depend on the height alone.
pub(crate) fn skies_of_formulas(canvas: &mut Canvas<'_>) -> Drawn {
    canvas.text(
            "The hemisphere light mixes the colors of sky and ground by the height, which two bands hold exactly. The gradient has a \
             fold at the horizon, which they do not.",
        );
    let gray = |x: f64| Rgb::new(x, x, x);
    let (sky, horizon, ground) = (1.0, 0.35, 0.1);
    let hemisphere = Light::Hemisphere { up: Dir::Z, sky: gray(sky), ground: gray(ground) };
    let gradient = Light::Gradient { up: Dir::Z, zenith: gray(sky), horizon: gray(horizon), ground: gray(ground) };
    let of = |light: &Light, order| light.project(order, Normalization::None);
    let (two, three, six) = (of(&hemisphere, 2)?, of(&gradient, 3)?, of(&gradient, 6)?);
    let at = |f: &ShVec<Rgb<f64>>, t: f64| f.eval(Dir::from_angles(t, 0.0)).g;
    let mixed = |z: f64| 0.5 * (sky * (1.0 + z) + ground * (1.0 - z));
    let folded = |z: f64| horizon + (sky - horizon) * z.max(0.0) + (ground - horizon) * (-z).max(0.0);
    let curves = [
        Curve2d::of_angle("hemisphere, order 2", GREEN, false, |t| at(&two, t)),
        Curve2d::of_angle("", BLACK, true, |t| mixed(t.cos())),
        Curve2d::of_angle("gradient, order 3", RED, false, |t| at(&three, t)),
        Curve2d::of_angle("gradient, order 6", BLUE, false, |t| at(&six, t)),
        Curve2d::of_angle("what they are", BLACK, true, |t| folded(t.cos())),
    ];
    canvas.profiles("sky-lights.svg", &curves, "over the angle from the zenith")?;
    canvas.command(
            "lobe light gradient --zenith 1,1,1 --horizon 0.35,0.35,0.35 --ground 0.1,0.1,0.1 --normalize none -o sky.sh.json",
        );
    Ok(())
}

/// A polygon from its edges.
pub(crate) fn window_of_a_room(canvas: &mut Canvas<'_>) -> Drawn {
    let [side, top] = WINDOW;
    let vertices = vec![[1.0, -side, 0.0], [1.0, side, 0.0], [1.0, side, top], [1.0, -side, top]];
    let window = SphericalPolygon::new(vertices)?;
    canvas.text(&format!(
            "A rectangle of radiance 1, {} steradians seen from the middle of its lower edge, one unit in front of it: exact in every \
             band, whatever the polygon.",
            digits(window.solid_angle()),
        ));
    let is_inside = |s: Dir| s.x() > 0.0 && s.y().abs() <= side * s.x() && (0.0..=top * s.x()).contains(&s.z());
    let truth = |s: Dir| if is_inside(s) { 1.0 } else { 0.0 };
    for order in [4, 6, 10] {
        let light = window.project(order);
        let file = format!("window-light-{order}.svg");
        let caption = format!("order {order} in the vertical plane, the window dashed");
        canvas.polar_xz(&file, 1.2, &|s| light.eval(s), &truth, &caption)?;
    }
    canvas.command(&format!(
            "lobe light polygon --vertices '1,-{side},0 1,{side},0 1,{side},{top} 1,-{side},{top}' --order 6 --normalize none \
             -o window.sh.json",
        ));
    Ok(())
}

/// Every disc and, dashed and in the same color, the exact light: a function of its half angle and of the angle.
fn cone_curves(cones: &[Zonal; 4], truth: impl Fn(f64, f64) -> f64) -> Vec<Curve2d<'static>> {
    let pair = |((degrees, label, color), cone): ((f64, &'static str, [u8; 3]), &Zonal)| {
        [
            Curve2d::of_angle("", color, true, |t| truth(degrees.to_radians(), t)),
            Curve2d::of_angle(label, color, false, |t| cone.eval(t.cos())),
        ]
    };
    CONES.into_iter().zip(cones).flat_map(pair).collect()
}
