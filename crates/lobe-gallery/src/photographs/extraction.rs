//! Section about a photograph as a few directional lights.

use lobe::env::{SunOptions, extract_sun, project_env};
use lobe::image::{Picture, Tone};
use lobe::sh::light_extraction::{LightFitOptions, LightMetric, extract_lights};
use lobe::sh::{Dir, Expansion as _, Rgb, ShVec, Zonal};

use crate::error::Drawn;
use crate::page::{BACKDROP, Canvas, SWEEP, Sky, ball_from, digits, percent, sheet};

/// The numbers of lights that are shown.
const COUNTS: [usize; 3] = [3, 2, 1];

/// The most bands that the strongest light is looked for in.
const SUN_ORDER: usize = 10;

pub(crate) fn extraction(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    let name = sky.bundled.name;
    canvas.text(
        "Directional lights and one ambient light in place of the whole sky: directions are maxima of the expansion of order 6, \
         intensities the least squares of what diffuse surfaces reflect. The radiance of three lights is not that of the sky, but a \
         ball cannot tell.",
    );
    let mut lights = vec![sky.radiance.clone()];
    let mut rows = Vec::new();
    for count in COUNTS {
        let fit = extract_lights(&sky.radiance, &LightFitOptions::default().count(count))?;
        let [residual, energy] = [fit.residual, fit.energy].map(|e| e.r + e.g + e.b);
        let dirs: Vec<String> = fit.lights.iter().map(|l| l.dir.to_array().map(digits).join(" ")).collect();
        rows.push(vec![count.to_string(), dirs.join("; "), percent(residual / energy)]);
        lights.push(fit.to_sh());
    }
    balls(canvas, sky, &lights)?;
    canvas.table(&["lights", "towards", "energy of the reflection left unexplained"], &rows);
    canvas.command(&format!("lobe sh lights {name}.sh.json --count 3"));
    angles_table(canvas, sky)?;
    canvas.command(&format!("lobe sh lights {name}.sh.json --metric radiance --refine"));
    Ok(())
}

/// The balls of the original and of the lights, in two rows.
fn balls(canvas: &mut Canvas<'_>, sky: &Sky, lights: &[ShVec<Rgb<f64>>]) -> Drawn {
    let ball = ball_from(canvas.size.ball * 3 / 4, sky.beside_the_light(70.0, 60.0));
    let radiance = |f: &ShVec<Rgb<f64>>| ball.picture(BACKDROP, |n| f.eval(n));
    let lit = |f: &ShVec<Rgb<f64>>| ball.lit_by_sh(BACKDROP, &f.convolved(&Zonal::clamped_cosine(SWEEP)));
    let tone = Tone::OBJECT.fixed_for(&lit(&lights[0]));
    let above = lights.iter().map(|f| sky.tone.apply(&radiance(f)));
    let below = lights.iter().map(|f| tone.apply(&lit(f)));
    let pictures: Vec<Picture> = above.chain(below).collect();
    let all = sheet(lights.len(), 6, BACKDROP, &pictures);
    canvas.figure(
        &sky.file("lights.png"),
        (&all, &Tone::PLAIN),
        all.width() * 4 / 3,
        "Above the radiance of order 6 towards every normal, below the ball it lights. From the left: the photograph; 3 lights, \
         2, and 1, with ambient light.",
    )
}

/// The angle between the one light that explains most and the brightest place of the picture.
fn angles_table(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    canvas.step()?;
    let sun = brightest_place(sky);
    let radiance = project_env(&sky.map, SUN_ORDER);
    let mut rows = Vec::new();
    for order in 2..=SUN_ORDER {
        let mut row = vec![order.to_string()];
        for metric in [LightMetric::Radiance, LightMetric::Irradiance] {
            for refine in [false, true] {
                let options = LightFitOptions::default().count(1).refine(refine).metric(metric);
                let fit = extract_lights(&radiance.resized(order), &options)?;
                let angle = fit.lights.first().map(|light| light.dir.angle_to(sun).to_degrees());
                row.push(angle.map_or("none".to_owned(), |angle| format!("{angle:.1}°")));
            }
        }
        rows.push(row);
    }
    let head = ["order", "for radiance, at a maximum", "refined", "for irradiance, at a maximum", "refined"];
    canvas.table(&head, &rows);
    canvas.text(
        "The angle between the one light that explains most and the brightest place of the picture. A light for radiance is drawn to \
         that place the more bands there are; one for irradiance, when it may move, goes to the middle of all the light.",
    );
    Ok(())
}

/// The sun, or where there is none the brightest texel.
fn brightest_place(sky: &Sky) -> Dir {
    let (x, y) = sky.brightest();
    extract_sun(&sky.map, &SunOptions::default()).map_or(sky.map.dir(x, y), |report| report.sun.direction)
}
