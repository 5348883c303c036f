//! Light-extraction section of the demo: a photograph as a few directional lights.

use lobe::env::{EnvMap, SunOptions, extract_sun, project_env};
use lobe::image::{Picture, Sheet, Tone};
use lobe::render::{Ball, View};
use lobe::sh::{Dir, LightFitOptions, LightMetric, Rgb, ShVec, Zonal, extract_lights};

use super::{BACKDROP, SWEEP, Sky, Writer, digits};

/// The numbers of lights that are shown.
const COUNTS: [usize; 3] = [3, 2, 1];

/// The most bands that the strongest light is looked for in.
const SUN_ORDER: usize = 10;

impl Writer<'_> {
    pub(super) fn extraction(&mut self, sky: &Sky) -> anyhow::Result<()> {
        let name = sky.bundled.name;
        self.page.section(&format!("{name}: three lights, two, one"));
        self.page.text(
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
            rows.push(vec![count.to_string(), dirs.join("; "), format!("{} %", digits(100.0 * residual / energy))]);
            lights.push(fit.to_sh());
        }
        self.light_balls(sky, &lights)?;
        self.page.table(&["lights", "towards", "energy of the reflection left unexplained"], &rows);
        self.page.command(&format!("lobe sh lights {name}.sh.json --count 3"));
        self.angles_table(sky)
    }

    /// The balls of the original and of the lights, in two rows.
    fn light_balls(&mut self, sky: &Sky, lights: &[ShVec<Rgb<f64>>]) -> anyhow::Result<()> {
        let light = sky.main_direction();
        let eye = Dir::from_angles(70.0_f64.to_radians(), light.phi() + 60.0_f64.to_radians());
        let ball = Ball::new(self.ball * 3 / 4).seen(View::from_eye(eye));
        let radiance = |f: &ShVec<Rgb<f64>>| ball.picture(BACKDROP, |n| lobe::sh::Expansion::eval(f, n));
        let lit = |f: &ShVec<Rgb<f64>>| ball.lit_by_sh(BACKDROP, &f.convolved(&Zonal::clamped_cosine(SWEEP)));
        let tone = Tone::OBJECT.fixed_for(&lit(&lights[0]));
        let above = lights.iter().map(|f| sky.tone.apply(&radiance(f)));
        let below = lights.iter().map(|f| tone.apply(&lit(f)));
        let pictures: Vec<Picture> = above.chain(below).collect();
        let sheet = Sheet { columns: lights.len(), margin: 6, background: BACKDROP.into() }.compose(&pictures);
        let file = sky.file("lights.png");
        self.write(&file, &sheet, &Tone::PLAIN)?;
        self.page.figure(
            &file,
            sheet.width() * 4 / 3,
            "Above the radiance of order 6 towards every normal, below the ball it lights. From the left: the photograph; 3 lights, \
             2, and 1, with ambient light.",
        );
        Ok(())
    }

    /// The angle between the one light that explains most and the brightest place of the picture.
    fn angles_table(&mut self, sky: &Sky) -> anyhow::Result<()> {
        (self.progress)("the strongest light by order");
        let sun = brightest_place(&sky.map);
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
        self.page.table(&head, &rows);
        self.page.text(
            "The angle between the one light that explains most and the brightest place of the picture. A light for radiance is drawn to \
             that place the more bands there are; one for irradiance, when it may move, goes to the middle of all the light.",
        );
        self.page.command(&format!("lobe sh lights {}.sh.json --metric radiance --refine", sky.bundled.name));
        Ok(())
    }
}

/// The sun, or where there is none the brightest texel.
fn brightest_place(map: &EnvMap) -> Dir {
    if let Some(report) = extract_sun(map, &SunOptions::default()) {
        return report.sun.direction;
    }
    let luminance = |i: &usize| map.texels()[*i].luminance();
    let brightest = (0..map.texels().len()).max_by(|a, b| luminance(a).total_cmp(&luminance(b))).unwrap_or(0);
    map.dir(brightest % map.width(), brightest / map.width())
}
