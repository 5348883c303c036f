//! Transfer section of the demo: a baked scene under a turning sky, beside path-traced references.

use lobe::image::{Picture, Pixel, Tone, compare, error_map, write_animated_png};
use lobe::io::Job;
use lobe::prt::{BakeMode, BakeOptions, BakeReport, Receivers, Transfer, bake};
use lobe::render::{
    Camera, DistantLight, PathOptions, RenderError, SampleCount, SceneHit, Truth, TruthOptions, ViewOptions,
    render_truth, scene_picture,
};
use lobe::scene::{Bvh, Scene, built_in};
use lobe::sh::{Coefficient as _, Dir, Expansion as _, Rgb, Rotation, ShVec, Window};

use super::{SWEEP, Sky, Writer, digits};

/// The order of the pictures.
const SHOWN: usize = 4;

/// Turns of the sky that are shown beside the truth, in degrees.
const TURNS: [f64; 3] = [0.0, 120.0, 240.0];

/// Cells to the meter: shadows of columns need them.
const DETAIL: usize = 3;

/// Bounces before the reflection to the eye.
const BOUNCES: usize = 2;

/// Pictures of a full turn of the sky, shown in two seconds.
const FRAMES: usize = 24;
const SECONDS_PER_FRAME: f64 = 1.0 / 12.0;

/// Rays for a pixel and axis.
const RAYS: usize = 2;

/// The baked hall and its camera.
pub(super) struct Hall {
    scene: Scene,
    bvh: Bvh,
    camera: Camera,
    transfer: Transfer,
    /// Columns and rows.
    pub(super) size: [usize; 2],
    paths: usize,
}

impl Writer<'_> {
    /// A hall under a sky that turns; the hall.
    pub(super) fn transfer(&mut self, sky: &Sky) -> anyhow::Result<Hall> {
        let name = sky.bundled.name;
        self.page.section(&format!("{name}: a scene that knows what it does to light"));
        (self.progress)("a baked hall");
        let (hall, report) = Hall::new(self.picture)?;
        self.page.text(&format!(
            "Transfer was baked at the {} vertices of a built-in hall by {} rays: shadows and {BOUNCES} reflections of light from surface \
             to surface are in it. Turning the sky costs no more than {} products for each vertex and color. Beside it the \
             truth, traced by {} paths for each pixel under the photograph itself.",
            report.receivers,
            report.rays,
            SHOWN * SHOWN,
            hall.paths
        ));
        let truths = self.stills(sky, &hall)?;
        self.turning(sky, &hall)?;
        self.transfer_table(sky, &hall, &truths);
        self.page.command(&format!(
            "lobe bake built-in:columns -o hall.glb\n\
             lobe render hall.glb --env bundled:{name} --frames 24 -o hall.png\n\
             lobe render trace hall.glb --env bundled:{name} --samples 256 -o truth.exr"
        ));
        Ok(hall)
    }

    /// Transfer, truth and difference for each turn; the truths.
    fn stills(&mut self, sky: &Sky, hall: &Hall) -> anyhow::Result<Vec<Truth>> {
        let mut truths = Vec::new();
        let mut tone = None;
        for degrees in TURNS {
            let turn = about_z(degrees);
            let truth = hall.truth(sky, &turn)?;
            let tone: &Tone = tone.get_or_insert_with(|| Tone::PHOTOGRAPH.fixed_for(&truth.mean));
            let claim = hall.picture(sky, &turn, &sky.radiance.resized(SHOWN))?;
            let report = compare(claim.pixels(), truth.mean.pixels());
            let width = hall.size[0];
            for (what, picture, caption) in [
                ("transfer", &claim, format!("turned by {degrees}°: transfer of order {SHOWN}")),
                ("truth", &truth.mean, "the truth: paths of light".to_owned()),
            ] {
                let file = sky.file(&format!("hall-{degrees}-{what}.png"));
                self.write(&file, picture, tone)?;
                self.page.figure(&file, width, &caption);
            }
            let file = sky.file(&format!("hall-{degrees}-difference.png"));
            let full_scale = 0.5 * report.mean;
            self.write(&file, &error_map(&claim, &truth.mean, full_scale)?, &Tone::PLAIN)?;
            self.page.figure(&file, width, "the difference, white at half of the mean");
            truths.push(truth);
        }
        Ok(truths)
    }

    /// The sky turns once around.
    fn turning(&mut self, sky: &Sky, hall: &Hall) -> anyhow::Result<()> {
        let light = sky.radiance.resized(SHOWN);
        let frame = |k: usize| hall.picture(sky, &about_z(360.0 * k as f64 / FRAMES as f64), &light);
        let frames = (0..FRAMES).map(frame).collect::<anyhow::Result<Vec<Picture>>>()?;
        let file = sky.file("hall-turning.png");
        (self.progress)(&file);
        write_animated_png(
            self.folder.join(&file),
            &frames,
            &Tone::PHOTOGRAPH.fixed_for(&frames[0]),
            SECONDS_PER_FRAME,
        )?;
        self.page.figure(&file, hall.size[0], "the sky turns, by transfer alone");
        Ok(())
    }

    /// The PSNR of each order, with and without a window.
    fn transfer_table(&mut self, sky: &Sky, hall: &Hall, truths: &[Truth]) {
        (self.progress)("transfer by order");
        let mut rows = Vec::new();
        let (mut last, mut rings) = (f64::NEG_INFINITY, false);
        for order in 1..=SWEEP {
            let radiance = sky.radiance.resized(order);
            let [plain, calm] = [&radiance, &calmed(&radiance)].map(|light| hall.psnr(light, truths));
            let note = if plain < last { "rings: less than the order before" } else { "" };
            rings |= plain < last;
            last = plain;
            rows.push(vec![
                order.to_string(),
                format!("{} dB", digits(plain)),
                format!("{} dB", digits(calm)),
                note.to_owned(),
            ]);
        }
        let why = if rings {
            "Where a higher order comes out lower, it rings: what is cut off a sun swings below zero, and between two orders the \
             trough changes places with the crest. The window calms it and blurs the light."
        } else {
            "Each order comes nearer; a window, which this light does not need, costs sharpness."
        };
        self.page.text(&format!(
            "The peak signal-to-noise ratio over what is seen of the hall, under the three skies together, by the order of light and \
             transfer, plain and with a window (Hanning, zero one band above the order). {why}"
        ));
        self.page.table(&["order", "PSNR", "windowed", ""], &rows);
    }
}

impl Hall {
    /// Bakes it. `picture` is the width of pictures on the page.
    fn new(picture: usize) -> anyhow::Result<(Self, BakeReport)> {
        let scene = built_in::columns_hall(DETAIL);
        let bvh = Bvh::new(&scene);
        let receivers = Receivers::at_vertices(&scene)?;
        let samples = picture as u32;
        // Bake as many bounces as the page says, whatever energy they carry.
        let options = BakeOptions::default()
            .mode(BakeMode::Interreflected)
            .order(SWEEP)
            .samples(samples)
            .bounces(BOUNCES)
            .energy_stop(0.0);
        let (transfer, report) = bake(&scene, &bvh, &receivers, &options, Job::default())?;
        let Some(camera) = Camera::look_at([10.0, -11.0, 4.5], [0.0, 0.0, 1.6], 18_f64.to_radians()) else {
            unreachable!("the eye is not where it looks")
        };
        let size = [picture * 3 / 5, picture * 2 / 5];
        Ok((Self { scene, bvh, camera, transfer, size, paths: picture / 8 }, report))
    }

    /// The hall under the turned light, the turned photograph behind it.
    pub(super) fn picture(&self, sky: &Sky, turn: &Rotation, light: &ShVec<Rgb<f64>>) -> anyhow::Result<Picture> {
        let behind = DistantLight::from_map(sky.map.clone()).turned(turn);
        Ok(self.lit(&light.rotated(turn), |s| behind.seen(s))?)
    }

    fn lit(
        &self,
        light: &ShVec<Rgb<f64>>,
        background: impl Fn(Dir) -> Rgb<f64> + Sync,
    ) -> Result<Picture, RenderError> {
        let lit = self.transfer.exit_radiance(light.coefficients());
        let [width, height] = self.size;
        let options = ViewOptions::default().width(width).height(height).rays(RAYS);
        let radiance = |hit: &SceneHit<'_>| hit.at_corners(&lit);
        scene_picture(&self.scene, &self.bvh, &self.camera, &options, background, radiance, Job::default())
    }

    pub(super) fn truth(&self, sky: &Sky, turn: &Rotation) -> anyhow::Result<Truth> {
        let light = DistantLight::from_map(sky.map.clone()).turned(turn);
        let [width, height] = self.size;
        let paths = PathOptions::default().bounces(BOUNCES);
        let options =
            TruthOptions::default().width(width).height(height).count(SampleCount::of(self.paths)).paths(paths);
        Ok(render_truth(&self.scene, &self.bvh, &self.camera, &light, &options, Job::default())?)
    }

    /// The peak signal-to-noise ratio over what is seen of the hall, under as many turns as there are truths.
    pub(super) fn psnr(&self, light: &ShVec<Rgb<f64>>, truths: &[Truth]) -> f64 {
        let (mut found, mut expected) = (Vec::new(), Vec::new());
        for (degrees, truth) in TURNS.into_iter().zip(truths) {
            found.extend(self.seen(light, degrees, truth));
            expected.extend(covered(truth, &truth.mean));
        }
        compare(&found, &expected).psnr
    }

    /// All pixels that show nothing but the hall.
    pub(super) fn seen(&self, light: &ShVec<Rgb<f64>>, degrees: f64, truth: &Truth) -> Vec<Pixel> {
        let Ok(picture) = self.lit(&light.rotated(&about_z(degrees)), |_| Rgb::ZERO) else {
            unreachable!("the picture has pixels and rays, and nobody stops it")
        };
        covered(truth, &picture).collect()
    }
}

/// The pixels of a picture where a truth shows nothing but surfaces.
pub(super) fn covered<'a>(truth: &'a Truth, picture: &'a Picture) -> impl Iterator<Item = Pixel> + 'a {
    truth.coverage.iter().zip(picture.pixels()).filter(|(coverage, _)| **coverage == 1.0).map(|(_, pixel)| *pixel)
}

/// Light under the window of this section.
pub(super) fn calmed(light: &ShVec<Rgb<f64>>) -> ShVec<Rgb<f64>> {
    light.windowed(&Window::Hanning { width: (light.order() + 1) as f64 })
}

pub(super) fn about_z(degrees: f64) -> Rotation {
    Rotation::from_axis_angle(Dir::Z, degrees.to_radians())
}
