//! The shadows of a figure with a skin against traced paths: `built-in:walking-figure` at three times of its walk.
//!
//! Its spheres are fitted to the shape that was bound and follow its joints. Prints the PSNR of pictures of direct light by 8, 16
//! and 64 spheres, by none, by transfer that is baked once, at the first moment, and by transfer that is baked for that very moment,
//! against 64 paths a pixel, of all pixels and of those of the ground and of the figure by themselves; the table of the guide (Things
//! that move).
//!
//! ```sh
//! cargo run --release --package lobe-motion --example skins
//! ```

use std::error::Error;

use lobe_env::{bundled, project_env};
use lobe_image::{Picture, compare};
use lobe_io::Job;
use lobe_motion::{
    Moment, MovingBakeOptions, MovingMethod, MovingOptions, MovingScene, MovingShading, light_moving_scene,
};
use lobe_prt::{BakeMode, BakeOptions, Receivers, Transfer, bake};
use lobe_render::{
    Camera, DistantLight, PathOptions, SampleCount, SceneHit, Truth, TruthOptions, ViewOptions, render_truth,
    scene_picture,
};
use lobe_scene::built_in;
use lobe_sh::{Dir, Expansion as _, Rgb, ShVec};
use lobe_shadow::SphereFitOptions;

const ORDER: usize = 4;

/// Of a walk of 1.1 s.
const TIMES: [f64; 3] = [0.1, 0.4, 0.8];

const SIZE: [usize; 2] = [240, 180];

/// What all pictures share.
struct Shot {
    camera: Camera,
    light: ShVec<Rgb<f64>>,
    distant: DistantLight,
    view: ViewOptions,
    transfer: BakeOptions,
}

fn main() -> Result<(), Box<dyn Error>> {
    let Some(camera) = Camera::look_at([2.6, -3.2, 1.9], [0.0, 0.0, 0.8], 38_f64.to_radians()) else {
        return Err("the eye is not where it looks".into());
    };
    let light = project_env(&bundled::sunset().map(), ORDER);
    let [width, height] = SIZE;
    let shot = Shot {
        camera,
        distant: DistantLight::from_expansion(light.clone()),
        light,
        view: ViewOptions::default().width(width).height(height),
        transfer: BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER),
    };
    let bare = MovingScene::animated(built_in::walking_figure(24), Some(0))?;
    let truths = TIMES.iter().map(|time| shot.truth(&bare.at(*time)?)).collect::<Result<Vec<_>, _>>()?;
    println!("| spheres | {} |", TIMES.map(|time| format!("{time} s")).join(" | "));
    println!("|---|{}", "---|".repeat(TIMES.len()));
    let print = |what: &str, lit: &dyn Fn(f64) -> Result<Picture, Box<dyn Error>>| -> Result<(), Box<dyn Error>> {
        let cells = TIMES.iter().zip(&truths).map(|(time, truth)| Ok(cell(&lit(*time)?, truth)));
        println!("| {what} | {} |", cells.collect::<Result<Vec<_>, Box<dyn Error>>>()?.join(" | "));
        Ok(())
    };
    for count in [0, 8, 16, 64] {
        let moving = shot.with_spheres(&bare, count)?;
        print(&count.to_string(), &|time| shot.by_spheres(&moving.at(time)?))?;
    }
    let first = shot.baked_at(&bare.at(0.0)?)?;
    print("baked once, at 0 s", &|time| shot.by_transfer(&first, &bare.at(time)?))?;
    print("baked for the moment", &|time| {
        let moment = bare.at(time)?;
        shot.by_transfer(&shot.baked_at(&moment)?, &moment)
    })
}

/// The PSNR of all pixels, of the ground and of the figure.
fn cell(picture: &Picture, truth: &Truth) -> String {
    let psnr = |shows: &dyn Fn([f32; 3]) -> bool| {
        let all = picture.pixels().iter().zip(truth.mean.pixels()).zip(truth.albedo.pixels());
        let (found, expected): (Vec<_>, Vec<_>) =
            all.filter(|(_, albedo)| shows(**albedo)).map(|((lit, truth), _)| (*lit, *truth)).unzip();
        compare(&found, &expected).psnr
    };
    // The ground is gray, the figure is not.
    let is_gray = |[r, _, b]: [f32; 3]| r > 0.0 && (r - b).abs() < 1e-3;
    let is_figure = |[r, _, b]: [f32; 3]| r - b > 0.2;
    format!("{:.1}, {:.1}, {:.1}", psnr(&|_| true), psnr(&is_gray), psnr(&is_figure))
}

impl Shot {
    fn truth(&self, moment: &Moment<'_>) -> Result<Truth, Box<dyn Error>> {
        let [width, height] = SIZE;
        let paths = PathOptions::default().bounces(0);
        let options = TruthOptions::default().width(width).height(height).count(SampleCount::of(64)).paths(paths);
        Ok(render_truth(moment.scene(), moment.bvh(), &self.camera, &self.distant, &options, Job::default())?)
    }

    /// The scene with so many spheres for the figure, or none.
    fn with_spheres(&self, bare: &MovingScene, count: usize) -> Result<MovingScene, Box<dyn Error>> {
        let spheres = SphereFitOptions::default().count(count.max(1));
        let options = MovingBakeOptions::default().transfer(self.transfer.clone());
        let mut moving = bare.clone();
        let options = options.spheres(spheres).deformed_spheres(None);
        moving.bake(MovingMethod::Exponentials, &options, Job::default())?;
        Ok(if count == 0 { moving.without_occluders() } else { moving })
    }

    fn by_spheres(&self, moment: &Moment<'_>) -> Result<Picture, Box<dyn Error>> {
        let background = |s: Dir| self.distant.radiance(s);
        let shading = MovingShading::new(MovingOptions::default().order(ORDER).method(MovingMethod::Exponentials))?;
        let (camera, job) = (&self.camera, Job::default());
        Ok(light_moving_scene(moment, &shading, &self.light.clone().into(), camera, &self.view, background, job)?
            .picture)
    }

    /// Transfer of the whole scene as it is at a moment.
    fn baked_at(&self, moment: &Moment<'_>) -> Result<Transfer, Box<dyn Error>> {
        let receivers = Receivers::at_vertices(moment.scene())?;
        Ok(bake(moment.scene(), moment.bvh(), &receivers, &self.transfer, Job::default())?.0)
    }

    /// A moment by transfer of its vertices, of whatever moment that is.
    fn by_transfer(&self, transfer: &Transfer, moment: &Moment<'_>) -> Result<Picture, Box<dyn Error>> {
        let lit = transfer.exit_radiance(self.light.coefficients());
        let (background, radiance) = (|s: Dir| self.distant.radiance(s), |hit: &SceneHit<'_>| hit.at_corners(&lit));
        let (scene, bvh, job) = (moment.scene(), moment.bvh(), Job::default());
        Ok(scene_picture(scene, bvh, &self.camera, &self.view, background, radiance, job)?)
    }
}
