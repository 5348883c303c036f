//! Entities below the horizon of a receiver: the change where they are left out, against the bound by the bands of the cosine there.

use std::f64::consts::PI;

use lobe_io::Job;
use lobe_prt::{Channels, Transfer};
use lobe_sh::{Dir, Expansion as _, Rgb, Rotation, Zonal};
use lobe_shadow::{
    FieldOptions, OcclusionField, PlacedField, Placement, ShadowFieldOptions, ShadowFields, ShadowReceivers, bake_field,
};

use crate::shapes::ball;

/// Order, then the bounds that the documentation of `ShadowFields` states: for all below the horizon, and for a ball there of a third of
/// its distance and of nine tenths.
const STATED: [(usize, [f64; 3]); 4] = [
    (3, [0.0614, 0.0058, 0.0330]),
    (4, [0.0614, 0.0058, 0.0330]),
    (6, [0.0297, 0.0022, 0.0144]),
    (8, [0.0180, 0.0011, 0.0083]),
];

/// Radii of balls in their distances: the last are near.
const RATIOS: [f64; 4] = [0.1, 1.0 / 3.0, 0.6, 0.9];

/// From where a ball touches the horizon (0) to straight below the receiver (1).
const DEPTHS: [f64; 6] = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];

/// The axis of a ball of half angle `half` so deep below the horizon of a receiver whose normal is z.
fn axis(half: f64, depth: f64) -> Dir {
    let polar = 0.5 * PI + half + depth * (0.5 * PI - half);
    Dir::new([polar.sin(), 0.0, polar.cos()]).unwrap()
}

/// `∫ |t_n|` over the cap, by a product rule in its own frame: the middles of steps, good to a thousandth.
fn residue_in_cap(order: usize, axis: Dir, half: f64) -> f64 {
    const STEPS: usize = 100;
    let cosine = Zonal::clamped_cosine(order).towards(Dir::Z, 1.0 / PI);
    let [x, _, z] = axis.to_array();
    let mut sum = 0.0;
    for i in 0..STEPS {
        let along = 1.0 - (1.0 - half.cos()) * (i as f64 + 0.5) / STEPS as f64;
        let across = (1.0 - along * along).sqrt();
        for j in 0..STEPS {
            let (sin, cos) = (2.0 * PI * (j as f64 + 0.5) / STEPS as f64).sin_cos();
            // The frame of (z, 0, -x), y and the axis.
            let s = [along * x + across * cos * z, across * sin, along * z - across * cos * x];
            sum += cosine.eval(Dir::new(s).unwrap()).abs();
        }
    }
    sum * 2.0 * PI * (1.0 - half.cos()) / (STEPS * STEPS) as f64
}

#[test]
fn the_residue_of_a_truncated_cosine_below_the_horizon_is_what_is_stated() {
    for (order, [all, third, near]) in STATED {
        let largest = |ratio: f64| {
            let caps = DEPTHS.map(|depth| residue_in_cap(order, axis(ratio.asin(), depth), ratio.asin()));
            caps.into_iter().fold(0.0, f64::max)
        };
        let found = [residue_in_cap(order, axis(0.5 * PI, 0.0), 0.5 * PI), largest(1.0 / 3.0), largest(0.9)];
        println!("order {order}: {found:.5?}");
        for (found, stated) in found.into_iter().zip([all, third, near]) {
            assert!(found <= stated && found > 0.95 * stated, "order {order}: {found}, stated {stated}");
        }
    }
}

/// The part of the exact cap that the sky is hidden by: what the exact cosine does not see, truncated ones do.
#[test]
fn exact_balls_below_the_horizon_change_exit_radiance_by_no_more_than_the_residue_in_their_caps() {
    for (order, [all, ..]) in STATED {
        for ratio in RATIOS {
            for depth in DEPTHS {
                let (half, axis) = (ratio.asin(), axis(ratio.asin(), depth));
                // Under a sky of radiance 1 the product with truncated visibility is that with the exact one.
                let hidden = Zonal::cone(order, half).towards(axis, 1.0);
                let change = Zonal::clamped_cosine(order).towards(Dir::Z, 1.0 / PI).dot(&hidden).abs();
                let bound = residue_in_cap(order, axis, half);
                assert!(change <= 1.002 * bound + 1e-9, "order {order}, {ratio} at {depth}: {change} above {bound}");
                assert!(bound <= all, "order {order}, {ratio} at {depth}: {bound} of all {all}");
            }
        }
    }
}

/// What the rays and the interpolation of this field are off by, of exit radiance 1.
const FIELD: f64 = 1.5e-3;

#[test]
fn a_field_below_the_horizon_that_is_left_out_changes_exit_radiance_by_no_more_than_the_residue_in_its_cap() {
    let options = FieldOptions::default().order(8).cells(8).rays(512);
    let (full, _) = bake_field(&ball(), &options, Job::default()).unwrap();
    let radius = full.grid().radius();
    let receivers = ShadowReceivers::new(&[[0.0; 3]], &[[0.0, 0.0, 1.0]]).unwrap();
    for (order, _) in STATED {
        let field = full.truncated(order).unwrap();
        for ratio in RATIOS {
            // A hair more below, so that no rounding brings it up.
            for depth in DEPTHS.map(|depth| depth.max(1e-3)) {
                let half = ratio.asin();
                let axis = axis(half, depth);
                let place = Placement::new(axis.to_array().map(|c| c * radius / ratio), Rotation::IDENTITY, 1.0);
                let change = change(order, &field, place, &receivers);
                let bound = residue_in_cap(order, axis, half);
                assert!(change <= bound + FIELD, "order {order}, {ratio} at {depth}: {change} above {bound}");
            }
        }
    }
}

/// What leaving out an entity changes: a cosine as transfer, for which nothing is left out, against the cosine itself.
fn change(order: usize, field: &OcclusionField, placement: Placement, receivers: &ShadowReceivers<'_>) -> f64 {
    let sky: Vec<Rgb<f64>> =
        (0..order * order).map(|i| [(4.0 * PI).sqrt(), 0.0][usize::from(i > 0)]).map(|c| Rgb::new(c, c, c)).collect();
    let options = ShadowFieldOptions::default().negligible(0.0);
    let fields = ShadowFields::new(order, &[PlacedField { field, placement }], options).unwrap();
    let cosine = Zonal::clamped_cosine(order).towards(Dir::Z, (1.0 / PI) as f32).into_vec();
    let transfer = Transfer::new(order, Channels::Gray, cosine).unwrap();
    let kept = fields.shade_transfer(receivers, &transfer, &sky).unwrap()[0].g;
    let left_out = fields.shade(receivers, &sky).unwrap()[0].g;
    assert!((left_out - 1.0).abs() < 1e-5, "nothing above the horizon hides: {left_out}");
    f64::from((kept - left_out).abs())
}
