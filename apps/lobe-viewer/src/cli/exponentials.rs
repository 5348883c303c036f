//! Measurement of exponentials of sums of spheres.

use lobe::env::bundled;
use lobe::sh::sphere::even_directions;
use lobe::sh::{Coefficient as _, Dir, Rgb};
use lobe::shadow::{LogTable, LogTableOptions, Occluder, ShadowOptions, ShadowReceivers, SkyLight, SphereShadows};
use lobe_gpu::{BenchReport, Context, GpuSphereShadows, PassTime};

/// Spheres over the receivers.
pub(crate) const SPHERES: usize = 128;

/// Runs of which the least time is kept.
const RUNS: usize = 5;

/// Half the side of the ground on which the receivers are, the radii of the spheres, and how far from the middle they are: those of a
/// crowd over its square.
const GROUND: f32 = 3.0;
const RADIUS: f32 = 0.15;
const AROUND: f64 = 2.0;

/// What a frame of receivers takes.
pub(crate) struct Measured {
    /// Milliseconds of both passes by the clock, with the wait for the device.
    pub(crate) milliseconds: f64,
    /// What the device says of each pass.
    pub(crate) passes: Vec<PassTime>,
}

impl Measured {
    /// Bytes that the passes bind.
    pub(crate) fn bytes(&self) -> u64 {
        self.passes.iter().map(|pass| pass.bytes).sum()
    }
}

/// Measures receivers on a ground under spheres that move.
pub(crate) fn measure(context: &Context, order: usize, count: usize) -> anyhow::Result<Measured> {
    let side = (count as f64).sqrt().ceil().max(1.0);
    let place = |k: usize| {
        let of = |i: f64| GROUND * (2.0 * (i + 0.5) / side - 1.0) as f32;
        [of(k as f64 % side), of((k as f64 / side).floor()), 0.0]
    };
    let positions: Vec<[f32; 3]> = (0..count).map(place).collect();
    let normals = vec![[0.0, 0.0, 1.0]; count];
    let receivers = ShadowReceivers::new(&positions, &normals)?;
    let table = LogTable::new(&LogTableOptions::default().order(order))?;
    let mut shaded = GpuSphereShadows::new(context, &table, &receivers, SPHERES)?;
    let sphere = |s: Dir| Occluder::new(s.to_array().map(|c| (AROUND * c) as f32 + RADIUS), RADIUS);
    let spheres: Vec<Occluder> = even_directions(SPHERES).map(sphere).collect();
    shaded.set_spheres(&SphereShadows::new(&table, &spheres, &ShadowOptions::default())?)?;
    let light = lobe::env::project_env(&bundled::sunset().map(), order).map(|c: Rgb<f64>| Rgb::<f32>::narrow(c));
    // Once, with its light; what is measured then is the passes alone.
    shaded.irradiance(&SkyLight::new(&light, order)?)?;
    let passes = BenchReport::measure(shaded.renderer(), RUNS)?.passes;
    Ok(Measured { milliseconds: BenchReport::milliseconds_a_run(shaded.renderer(), RUNS)?, passes })
}
