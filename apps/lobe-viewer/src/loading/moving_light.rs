//! Light of moments that move: on the device where that can do it, else on the processor.

use lobe::motion::{Moment, MovingShading, PartObstacles, PartReceivers, VisibilityGrid};
use lobe::prt::Transfer;
use lobe::sh::{Rgb, ShVec};
use lobe::shadow::{RadialInterpolation, ShadowReceivers, SphereShadows};
#[cfg(not(target_arch = "wasm32"))]
use lobe_gpu::SceneView;
use lobe_gpu::{Context, FieldResponse, GpuMovingPart, MovingObstacles, MovingPlaces, StillGrid};
use serde::{Deserialize, Serialize};

/// The most bands of products on the device.
const DEVICE_ORDER: usize = 6;

/// Entities with fields at most on the device.
const DEVICE_FIELDS: usize = 64;

/// Where moments are to be lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
pub(crate) enum LitOn {
    /// On the device, unless that is a program which emulates one
    #[default]
    Auto,
    /// On the device as far as it can
    Device,
    /// On the processor
    Processor,
}

/// Lights moments, and keeps on the device what does not change between them.
pub(crate) struct MovingLight {
    shading: MovingShading,
    /// The device that there is, and where moments are to be lit.
    given: Option<Context>,
    on: LitOn,
    parts: Vec<Option<Kept>>,
    /// Why the last moment was lit on the processor.
    why_not: Option<&'static str>,
}

/// A part on the device.
struct Kept {
    part: GpuMovingPart,
    /// Where in memory what it was made of lies, and how much of it there is.
    made_of: Vec<usize>,
    most_spheres: usize,
}

impl MovingLight {
    /// Lights by a shading, on a device if there is one and it is asked for.
    pub(crate) fn new(shading: MovingShading, device: Option<&Context>, on: LitOn) -> Self {
        Self { shading, given: device.cloned(), on, parts: Vec::new(), why_not: None }
    }

    /// The same elsewhere, from the next moment on.
    pub(crate) fn move_to(&mut self, on: LitOn) {
        self.on = on;
    }

    /// Forgets what is on the device, for parts that are baked anew: others may come to lie where they were in memory.
    pub(crate) fn forget(&mut self) {
        self.parts.clear();
    }

    /// The device, if moments are to be lit there.
    fn device(&self) -> Option<&Context> {
        let is_wanted = |device: &&Context| match self.on {
            LitOn::Auto => !device.is_software() && device.has_storage(),
            LitOn::Device => device.has_storage(),
            LitOn::Processor => false,
        };
        self.given.as_ref().filter(is_wanted)
    }

    /// Where the last moment was lit, and why not on the device if that was asked for.
    pub(crate) fn place(&self) -> String {
        match (self.device(), self.why_not, self.on) {
            (Some(_), None, _) => "on the device".into(),
            (Some(_), Some(why), _) => format!("on the processor, because of {why}"),
            (None, _, LitOn::Device) if self.given.is_none() => "on the processor, because there is no device".into(),
            (None, _, LitOn::Device) => "on the processor, because the device has no storage buffers".into(),
            (None, ..) => "on the processor".into(),
        }
    }

    /// The exit radiance of all vertices of a moment.
    pub(crate) fn exit_radiance(
        &mut self,
        moment: &Moment<'_>,
        light: &ShVec<Rgb<f64>>,
    ) -> anyhow::Result<Vec<Rgb<f32>>> {
        if !self.shade(moment, light)? {
            return Ok(self.shading.exit_radiance(moment, light)?);
        }
        let mut all = Vec::with_capacity(moment.scene().vertex_count());
        for kept in self.parts.iter().flatten() {
            all.extend(kept.part.radiance()?);
        }
        Ok(all)
    }

    /// The same, in a view of radiance. From the device nothing is read back. For the command line, which a page has not.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn show(
        &mut self,
        moment: &Moment<'_>,
        light: &ShVec<Rgb<f64>>,
        view: &SceneView,
    ) -> anyhow::Result<()> {
        if !self.shade(moment, light)? {
            return Ok(view.set_radiance(&self.shading.exit_radiance(moment, light)?)?);
        }
        let mut first = 0;
        for kept in self.parts.iter().flatten() {
            view.take_radiance(first, &kept.part)?;
            first += kept.part.receivers();
        }
        Ok(())
    }

    /// Shades all parts on the device; false if it cannot.
    fn shade(&mut self, moment: &Moment<'_>, light: &ShVec<Rgb<f64>>) -> anyhow::Result<bool> {
        let Some(device) = self.device().cloned() else { return Ok(false) };
        let options = self.shading.options();
        let obstacles: Vec<PartObstacles<'_>> =
            (0..moment.parts().len()).map(|part| moment.obstacles_of(part, options.method)).collect();
        self.why_not = beyond_the_device(&self.shading, moment, &obstacles);
        if self.why_not.is_some() {
            return Ok(false);
        }
        self.parts.resize_with(obstacles.len(), || None);
        for (number, obstacles) in obstacles.iter().enumerate() {
            let receivers = moment.receivers_of(number);
            if receivers.positions.is_empty() {
                self.parts[number] = None;
                continue;
            }
            self.shade_part(&device, number, (&receivers, moment.parts()[number].is_rigid()), obstacles, light)?;
        }
        Ok(true)
    }

    fn shade_part(
        &mut self,
        device: &Context,
        number: usize,
        (receivers, is_rigid): (&PartReceivers<'_>, bool),
        obstacles: &PartObstacles<'_>,
        light: &ShVec<Rgb<f64>>,
    ) -> anyhow::Result<()> {
        let (made_of, spheres) = (made_of(receivers, obstacles), obstacles.spheres.len());
        let is_kept = |kept: &Kept| kept.made_of == made_of && spheres <= kept.most_spheres;
        if !self.parts[number].as_ref().is_some_and(is_kept) {
            let part = upload(device, &self.shading, receivers, obstacles)?;
            self.parts[number] = Some(Kept { part, made_of, most_spheres: spheres });
        }
        let Some(kept) = &mut self.parts[number] else { return Ok(()) };
        let shadows = match obstacles.spheres.as_slice() {
            [] => None,
            spheres => Some(SphereShadows::new(self.shading.table(), spheres, &self.shading.options().spheres)?),
        };
        let moved = (!is_rigid).then(|| shadow_receivers(receivers)).transpose()?;
        let places = MovingPlaces {
            frame: receivers.frame,
            fields: &obstacles.fields,
            spheres: shadows.as_ref(),
            receivers: moved,
        };
        Ok(kept.part.shade(&places, light)?)
    }
}

/// What of a moment a device does not shade.
fn beyond_the_device(
    shading: &MovingShading,
    moment: &Moment<'_>,
    obstacles: &[PartObstacles<'_>],
) -> Option<&'static str> {
    let options = shading.options();
    if options.order > DEVICE_ORDER {
        return Some("orders above 6");
    }
    if moment.has_lamps() {
        return Some("lamps");
    }
    if options.bounce {
        return Some("light that spheres send on");
    }
    if options.fields.interpolation != RadialInterpolation::Linear {
        return Some("fields that are not interpolated linearly");
    }
    obstacles.iter().any(|o| o.fields.len() > DEVICE_FIELDS).then_some("more than 64 fields")
}

/// What tells a part on the device from another: where in memory what it was uploaded from lies, and how much there is of it.
fn made_of(receivers: &PartReceivers<'_>, obstacles: &PartObstacles<'_>) -> Vec<usize> {
    let transfer = receivers.transfer.map_or(0, |transfer| transfer.coefficients().as_ptr().addr());
    let fields = obstacles.fields.iter().map(|placed| placed.field.rows().as_ptr().addr());
    let grids = obstacles.grids.iter().map(|grid| grid.rows().as_ptr().addr());
    let counts =
        [receivers.positions.len(), obstacles.fields.len(), usize::from(obstacles.spheres.is_empty()), transfer];
    counts.into_iter().chain(fields).chain(grids).collect()
}

fn upload(
    device: &Context,
    shading: &MovingShading,
    receivers: &PartReceivers<'_>,
    obstacles: &PartObstacles<'_>,
) -> anyhow::Result<GpuMovingPart> {
    let order = shading.order();
    let grids: Vec<StillGrid<'_>> = obstacles.grids.iter().map(|grid| still_grid(grid)).collect();
    let cut = receivers.transfer.filter(|transfer| transfer.order() > order).map(|transfer| cut_off(transfer, order));
    let cut = cut.transpose()?;
    let transfer = cut.as_ref().or(receivers.transfer);
    let is_tinted = transfer.is_none() || receivers.is_demodulated;
    let mut shape = ShadowReceivers::new(receivers.positions, receivers.normals)?;
    if is_tinted {
        shape = shape.with_albedos(receivers.albedos)?;
    }
    let obstacles = MovingObstacles {
        fields: &obstacles.fields,
        options: &shading.options().fields,
        grids: &grids,
        table: shading.table(),
        most_spheres: obstacles.spheres.len(),
    };
    let response = transfer.map_or(FieldResponse::Cosine, FieldResponse::Transfer);
    Ok(GpuMovingPart::new(device, order, &shape, response, &obstacles)?)
}

fn still_grid(grid: &VisibilityGrid) -> StillGrid<'_> {
    let [min, step] = grid.lattice();
    StillGrid { order: grid.order(), min, step, counts: grid.counts(), rows: grid.rows() }
}

/// Receivers that are matte.
fn shadow_receivers<'a>(receivers: &PartReceivers<'a>) -> anyhow::Result<ShadowReceivers<'a>> {
    Ok(ShadowReceivers::new(receivers.positions, receivers.normals)?.with_albedos(receivers.albedos)?)
}

/// The first bands of transfer.
fn cut_off(transfer: &Transfer, order: usize) -> anyhow::Result<Transfer> {
    let (full, n) = (transfer.order().pow(2), order * order);
    let rows = transfer.coefficients().chunks_exact(full).flat_map(|row| &row[..n]).copied().collect();
    Ok(Transfer::new(order, transfer.channels(), rows)?)
}

#[cfg(test)]
mod tests {
    use lobe::io::Job;
    use lobe::motion::{MovingMethod, MovingOptions, MovingScene};
    use lobe::scene::{AnimatedScene, built_in};
    use lobe::shadow::{ShadowOptions, SphereFitMethod};
    use lobe_gpu::{AdapterChoice, ContextOptions, SceneViewOptions, SurfaceShading};

    use super::*;
    use crate::loading::moving_bakes::moving_bake_options;

    /// The relative difference to the processor that the device keeps, of the largest value.
    const TOLERANCE: f32 = 1e-4;

    fn device(test: &str) -> Option<Context> {
        let context = Context::new(&ContextOptions::default().adapter(AdapterChoice::Software)).ok();
        if context.is_none() {
            lobe_testkit::skipped(&format!("{test} of lobe-viewer: no graphics adapter"));
        }
        context
    }

    fn baked(animated: AnimatedScene, method: MovingMethod, order: usize, still_hides: bool) -> MovingScene {
        let mut scene = MovingScene::animated(animated, Some(0)).unwrap();
        let options = moving_bake_options(order, SphereFitMethod::MedialAxis, 3, still_hides);
        for bake in scene.lacking(method, &options) {
            scene.bake_part(&bake, &options, Job::default()).unwrap();
        }
        scene
    }

    /// Of spheres one by one, as the device takes them.
    fn shading(method: MovingMethod, order: usize) -> MovingShading {
        let spheres = ShadowOptions::default().cut(0.0);
        MovingShading::new(MovingOptions::default().order(order).method(method).spheres(spheres)).unwrap()
    }

    fn light(order: usize) -> ShVec<Rgb<f64>> {
        lobe::env::project_env(&lobe::env::bundled::sunset().map(), order)
    }

    fn difference(found: &[Rgb<f32>], expected: &[Rgb<f32>]) -> f32 {
        assert_eq!(found.len(), expected.len(), "a value of each vertex");
        let numbers = |of: &[Rgb<f32>]| of.iter().flat_map(|c| [c.r, c.g, c.b]).collect::<Vec<_>>();
        let (found, expected) = (numbers(found), numbers(expected));
        let largest = expected.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        assert!(largest > 0.0, "there is light");
        let apart = |(f, e): (&f32, &f32)| if f.is_finite() { (f - e).abs() } else { f32::INFINITY };
        found.iter().zip(&expected).map(apart).fold(0.0, f32::max) / largest
    }

    #[test]
    #[ignore = "long: of the nightly group"]
    fn the_device_lights_moments_as_the_processor_does() {
        let Some(context) = device("the_device_lights_moments_as_the_processor_does") else { return };
        // What is rigid and what is deformed; with visibility of what stands still, turned to the frames of parts, and without.
        let scenes = [
            (built_in::three_objects(8), false, 3),
            (built_in::three_objects(8), true, 2),
            (built_in::walking_figure(8), true, 3),
        ];
        for (animated, still_hides, order) in scenes {
            for method in [MovingMethod::Fields, MovingMethod::Exponentials] {
                let scene = baked(animated.clone(), method, order, still_hides);
                let shading = shading(method, order);
                let mut lit = MovingLight::new(shading.clone(), Some(&context), LitOn::Device);
                // On one upload, with light of more bands than are used too.
                for (time, light) in [(0.3, light(order)), (0.9, light(order + 2)), (0.3, light(order))] {
                    let moment = scene.at(time).unwrap();
                    let found = lit.exit_radiance(&moment, &light).unwrap();
                    let expected = shading.exit_radiance(&moment, &light).unwrap();
                    let worst = difference(&found, &expected);
                    assert!(worst < TOLERANCE, "{method:?}, order {order}, {still_hides}, at {time}: {worst:e}");
                    assert_eq!(lit.place(), "on the device");
                }
            }
        }
    }

    #[test]
    fn a_view_shows_what_the_device_lit_without_reading_it_back() {
        let Some(context) = device("a_view_shows_what_the_device_lit_without_reading_it_back") else { return };
        let (method, order) = (MovingMethod::Exponentials, 2);
        let scene = baked(built_in::three_objects(8), method, order, false);
        let moment = scene.at(0.5).unwrap();
        let shading = shading(method, order);
        let radiance = shading.exit_radiance(&moment, &light(order)).unwrap();
        let options = SceneViewOptions::default().width(64).height(48).rays(1);
        let view =
            SceneView::new(&context, moment.scene(), &SurfaceShading::Radiance(&radiance), None, &options).unwrap();
        let camera = crate::Orbit::default().framing(moment.scene().world_bounds()).on_device().unwrap();
        view.set_camera(&camera).unwrap();
        view.render().unwrap();
        let expected = view.picture().unwrap();
        view.set_radiance(&vec![Rgb::new(0.0, 0.0, 0.0); radiance.len()]).unwrap();
        let mut lit = MovingLight::new(shading, Some(&context), LitOn::Device);
        lit.show(&moment, &light(order), &view).unwrap();
        view.render().unwrap();
        let found = view.picture().unwrap();
        let pixels = |picture: &lobe::image::Picture| {
            picture.pixels().iter().map(|[r, g, b]| Rgb::new(*r, *g, *b)).collect::<Vec<_>>()
        };
        let worst = difference(&pixels(&found), &pixels(&expected));
        // The colors of pixels are half floats, and a difference in the last digit may round them to neighbors.
        assert!(worst < TOLERANCE + 2.0_f32.powi(-10), "{worst:e}");
    }

    #[test]
    fn what_the_device_cannot_light_the_processor_does_and_says_why() {
        let Some(context) = device("what_the_device_cannot_light_the_processor_does_and_says_why") else { return };
        let order = 2;
        let scene = baked(built_in::three_objects(8), MovingMethod::Fields, order, false);
        let moment = scene.at(0.1).unwrap();
        let bounce = MovingShading::new(MovingOptions::default().order(order).bounce(true)).unwrap();
        let plain = shading(MovingMethod::Fields, order);
        for (shading, on, place) in [
            (bounce, LitOn::Device, "on the processor, because of light that spheres send on"),
            (plain.clone(), LitOn::Processor, "on the processor"),
            // A program that emulates a device is slower than the processor by itself.
            (plain, LitOn::Auto, "on the processor"),
        ] {
            let mut lit = MovingLight::new(shading.clone(), Some(&context), on);
            let found = lit.exit_radiance(&moment, &light(order)).unwrap();
            assert_eq!(found, shading.exit_radiance(&moment, &light(order)).unwrap(), "{place}");
            assert_eq!(lit.place(), place);
        }
    }
}
