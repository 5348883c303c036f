//! Sections about models of the sky, and about area lights.

use lobe::env::{CieSky, DiscLight, Ground, PolygonLight, PreethamSky, SphereLight, compare_approximations, sky_map};
use lobe::image::{Picture, Tone};
use lobe::sh::{Coefficient as _, Dir, Rgb};

use crate::error::Drawn;
use crate::page::{Canvas, digits, sheet};

/// The heights of the sun over the horizon in degrees.
const HEIGHTS: [f64; 4] = [5.0, 20.0, 45.0, 80.0];

/// The turbidity of the clear skies.
const TURBIDITY: f64 = 3.0;

/// Some of the skies of the CIE: overcast, cloudy, clear, and clear with a broad corona.
const TYPES: [usize; 4] = [1, 7, 12, 15];

/// The distances of the receiver, in radii or half sides of the light.
const DISTANCES: [f64; 5] = [1.0, 2.0, 5.0, 10.0, 50.0];

pub(crate) fn skies(canvas: &mut Canvas<'_>) -> Drawn {
    let ground = Ground { albedo: Rgb::splat(0.2), ..Ground::default() };
    let rows = canvas.size.picture / 4;
    // The sun in the middle of the picture, towards +x.
    let sun = |degrees: f64| Dir::from_angles((90.0 - degrees).to_radians(), 0.0);
    let mut pictures = Vec::new();
    for degrees in HEIGHTS {
        let sky = PreethamSky::new(TURBIDITY, sun(degrees))?;
        pictures.push(Picture::from(&sky_map(&sky, &ground, 2 * rows, rows)));
    }
    for kind in TYPES {
        let sky = CieSky::new(kind, sun(45.0), Rgb::splat(1.0))?;
        pictures.push(Picture::from(&sky_map(&sky, &ground, 2 * rows, rows)));
    }
    let shown: Vec<Picture> = pictures.iter().map(|picture| Tone::PHOTOGRAPH.apply(picture)).collect();
    canvas.plain_figure(
        "skies.png",
        &sheet(HEIGHTS.len(), 4, [1.0; 3], &shown),
        "Above, the clear sky of Preetham, Shirley and Smits at turbidity 3 with the sun at 5°, 20°, 45° and 80°; below, \
         skies of the CIE with the sun at 45°: types 1, 7, 12 and 15. Each has its own exposure.",
    )?;
    canvas.command(
        "lobe env sky --sun 1,0,0.4 --turbidity 3 -o sky.exr\nlobe env sky --model cie --type 12 --sun 1,0,1 -o sky.sh.json",
    );
    Ok(())
}

/// The error of taking an area light for a point.
pub(crate) fn area_lights(canvas: &mut Canvas<'_>) -> Drawn {
    canvas.step()?;
    canvas.text(
        "A light of radius, or half side, 1 above a surface that faces it: how much brighter than the exact, closed form \
         the light of a point is that has the same power.",
    );
    let here = [0.0; 3];
    let mut rows = Vec::new();
    for d in DISTANCES {
        let center = [0.0, 0.0, d];
        let disc = DiscLight { center, normal: -Dir::Z, radius: 1.0 };
        let square = PolygonLight::rectangle(center, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0])?;
        let sphere = SphereLight { center, radius: 1.0 };
        let errors = [
            compare_approximations(&sphere, here, here, Dir::Z),
            compare_approximations(&disc, here, here, Dir::Z),
            compare_approximations(&square, here, here, Dir::Z),
        ];
        let mut row = vec![d.to_string()];
        // Rounding of a sphere that is a point exactly.
        row.extend(errors.map(|e| format!("{} %", digits((1e12 * 100.0 * e.point_error()).round() * 1e-12))));
        rows.push(row);
    }
    canvas.table(&["distance", "sphere", "disc", "square"], &rows);
    canvas.command("lobe env area-light disc --center 0,0,5 --shines 0,0,-1 --radius 1");
    Ok(())
}
