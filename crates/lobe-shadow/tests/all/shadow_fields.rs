//! Entities together: chains of products against rays, and shading against sums in closed form.

use std::f64::consts::PI;
use std::sync::OnceLock;

use lobe_io::Job;
use lobe_prt::{Channels, Transfer};
use lobe_scene::Scene;
use lobe_sh::product::product_into;
use lobe_sh::{Dir, Expansion as _, Rgb, Rotation, ShVec, Zonal};
use lobe_shadow::{
    FieldOptions, LocalLight, OcclusionField, PlacedField, Placement, RadialInterpolation, RadianceField,
    ShadowFieldOptions, ShadowFields, ShadowReceivers, bake_field, relative_placement,
};
use lobe_testkit::Random;

use crate::shapes::{ball, rabbit, relative_error, together, traced};

const ORDER: usize = 4;

/// Baked once for all tests.
fn field_of_rabbit() -> &'static OcclusionField {
    static FIELD: OnceLock<OcclusionField> = OnceLock::new();
    FIELD.get_or_init(|| bake_field(&rabbit(), &FieldOptions::default().rays(512), Job::default()).unwrap().0)
}

fn field_of_ball() -> &'static OcclusionField {
    static FIELD: OnceLock<OcclusionField> = OnceLock::new();
    FIELD.get_or_init(|| bake_field(&ball(), &FieldOptions::default().cells(8).rays(512), Job::default()).unwrap().0)
}

fn turned(seed: u64) -> Rotation {
    Rotation::from_quaternion(Random::new(seed).quaternion()).unwrap()
}

/// Rabbits around the origin, apart from each other.
fn herd(count: usize) -> Vec<Placement> {
    let at = lobe_testkit::fibonacci_sphere(count);
    let place = |k: usize| Placement::new(at[k].map(|c| 3.2 * c), turned(k as u64), 0.6 + 0.1 * k as f64);
    (0..count).map(place).collect()
}

fn entities<'a>(field: &'a OcclusionField, placements: &[Placement]) -> Vec<PlacedField<'a>> {
    placements.iter().map(|placement| PlacedField { field, placement: *placement }).collect()
}

fn all_of_it() -> ShadowFieldOptions {
    ShadowFieldOptions::default().negligible(0.0)
}

fn near_origin(count: usize) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let mut random = Random::new(6);
    let positions = (0..count).map(|_| random.direction().map(|c| (0.8 * c) as f32)).collect();
    let normals = (0..count).map(|_| random.direction().map(|c| c as f32)).collect();
    (positions, normals)
}

#[test]
fn a_chain_of_fields_is_near_what_rays_see_through_all_entities() {
    let (scene, count) = (rabbit(), 5);
    let (field, placements) = (field_of_rabbit(), herd(count));
    let fields = ShadowFields::new(ORDER, &entities(field, &placements), all_of_it()).unwrap();
    let (positions, _) = near_origin(40);
    let parts: Vec<(&Scene, Placement)> = placements.iter().map(|p| (&scene, *p)).collect();
    let truth = traced(&together(&parts), &positions, ORDER, 2048);
    let visible = |p: &[f32; 3]| fields.visibility_at(*p, None, None).unwrap().into_vec();
    let off = relative_error(&positions.iter().flat_map(visible).collect::<Vec<f32>>(), &truth, ORDER);
    assert!(off < 0.09, "{count} entities: off by {off}");
    // One that is turned, moved and scaled is as it was in its own frame.
    for placement in &placements {
        let one = ShadowFields::new(ORDER, &entities(field, &[*placement]), all_of_it()).unwrap();
        let own = [0.3, -1.4, 0.8];
        let found = one.visibility_at(placement.to_world(own).map(|c| c as f32), None, None).unwrap();
        let expected = field.visibility_at(own, RadialInterpolation::Linear).rotated(placement.rotation());
        for i in 0..ORDER * ORDER {
            assert!((found[i] - expected[i]).abs() < 1e-4, "{i}: {} against {}", found[i], expected[i]);
        }
    }
}

#[test]
fn a_chain_is_the_plain_loop_nearest_first() {
    let (field, placements) = (field_of_rabbit(), herd(6));
    let fields = ShadowFields::new(ORDER, &entities(field, &placements), all_of_it()).unwrap();
    let (positions, _) = near_origin(30);
    for p in positions {
        let mut order: Vec<&Placement> = placements.iter().collect();
        let distance = |q: &Placement| -> f64 {
            let center = q.to_world(field.grid().center());
            (0..3).map(|k| (center[k] - f64::from(p[k])).powi(2)).sum()
        };
        order.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let mut visible = ShVec::constant(ORDER, 1.0_f32);
        for q in order {
            let seen = field.visibility_at(q.to_own(p.map(f64::from)), RadialInterpolation::Linear);
            let mut product = ShVec::zero(ORDER);
            product_into(visible.coefficients(), seen.rotated(q.rotation()).coefficients(), product.coefficients_mut());
            visible = product;
        }
        let found = fields.visibility_at(p, None, None).unwrap();
        for i in 0..ORDER * ORDER {
            assert!((found[i] - visible[i]).abs() < 2e-4, "{p:?}, {i}: {} against {}", found[i], visible[i]);
        }
    }
}

#[test]
fn many_receivers_see_what_each_sees_alone_on_any_number_of_threads() {
    let (field, placements) = (field_of_rabbit(), herd(6));
    let fields = ShadowFields::new(ORDER, &entities(field, &placements), ShadowFieldOptions::default()).unwrap();
    for count in [1003, 201, 16, 1] {
        let (positions, normals) = near_origin(count);
        let receivers = ShadowReceivers::new(&positions, &normals).unwrap();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| fields.visibility(&receivers).unwrap())
        };
        let all = on(1);
        assert!(on(3) == all, "{count} receivers, three threads");
        for k in (0..count).step_by(17) {
            let alone = fields.visibility_at(positions[k], Some(normals[k]), None).unwrap();
            for i in 0..ORDER * ORDER {
                let found = all[k * ORDER * ORDER + i];
                assert!(found == alone[i], "receiver {k} of {count}, {i}: {found}, alone {}", alone[i]);
            }
        }
    }
}

#[test]
fn what_is_left_out_changes_light_by_no_more_than_its_bound() {
    let field = field_of_ball();
    let ring = |k: usize| {
        let (sin, cos) = (0.7 * k as f64).sin_cos();
        let r = 3.0 + 4.0 * k as f64;
        Placement::new([r * cos, r * sin, 0.5 * r], Rotation::IDENTITY, 1.0)
    };
    let placements: Vec<Placement> = (0..12).map(ring).collect();
    let up = [0.0, 0.0, 1.0];
    let exact = ShadowFields::new(ORDER, &entities(field, &placements), all_of_it()).unwrap();
    let truth = exact.visibility_at([0.0; 3], Some(up), None).unwrap();
    let mut last = 0.0;
    for negligible in [1e-3, 1e-2, 5e-2] {
        let options = ShadowFieldOptions::default().negligible(negligible);
        let fields = ShadowFields::new(ORDER, &entities(field, &placements), options).unwrap();
        let found = fields.visibility_at([0.0; 3], Some(up), None).unwrap();
        let off = (0..ORDER * ORDER).map(|i| f64::from((found[i] - truth[i]).abs())).fold(0.0, f64::max);
        // A truncated visibility exceeds 1 by less than a half.
        let bound = 1.5 * negligible * ((2 * ORDER - 1) as f64 / (4.0 * PI)).sqrt();
        assert!(off <= bound, "{negligible}: off by {off}, expected at most {bound}");
        assert!(off >= last, "{negligible}: more is left out, {off} after {last}");
        last = off;
    }
    assert!(last > 0.0, "something was left out");
    // What is below the horizon is left out altogether.
    let below = Placement::new([0.0, 0.0, -2.0], Rotation::IDENTITY, 1.0);
    let fields = ShadowFields::new(ORDER, &entities(field, &[below]), all_of_it()).unwrap();
    assert_eq!(fields.visibility_at([0.0; 3], Some(up), None).unwrap(), ShVec::constant(ORDER, 1.0), "above");
    assert!(fields.visibility_at([0.0; 3], None, None).unwrap().mean() < 0.97, "all around");
}

#[test]
fn what_is_left_out_changes_exit_radiance_by_no_more_than_its_bound() {
    let field = field_of_ball();
    let mut random = Random::new(9);
    let mut place = || {
        let r = 12.0 + 20.0 * random.unit();
        let s = random.direction();
        Placement::new([r * s[0], r * s[1], (r * s[2]).abs()], Rotation::IDENTITY, 1.0)
    };
    let placements: Vec<Placement> = (0..12).map(|_| place()).collect();
    let receivers = ShadowReceivers::new(&[[0.0; 3]], &[[0.0, 0.0, 1.0]]).unwrap();
    // Radiance 1 from everywhere.
    let sky: Vec<Rgb<f64>> =
        (0..16).map(|i| [(4.0 * PI).sqrt(), 0.0][usize::from(i > 0)]).map(|c| Rgb::new(c, c, c)).collect();
    let sent = |negligible: f64| {
        let options = ShadowFieldOptions::default().negligible(negligible);
        let fields = ShadowFields::new(ORDER, &entities(field, &placements), options).unwrap();
        f64::from(fields.shade(&receivers, &sky).unwrap()[0].g)
    };
    let truth = sent(0.0);
    for negligible in [5e-3, 2e-2, 6e-2] {
        let off = (sent(negligible) - truth).abs();
        // Half of the bound at most was measured.
        assert!(off > 0.0 && off <= negligible / PI, "{negligible}: off by {off}");
    }
}

#[test]
fn an_entity_that_sinks_below_the_horizon_leaves_with_a_small_step() {
    let field = field_of_ball();
    let receivers = ShadowReceivers::new(&[[0.0; 3]], &[[0.0, 0.0, 1.0]]).unwrap();
    let sky: Vec<Rgb<f64>> =
        (0..16).map(|i| [(4.0 * PI).sqrt(), 0.0][usize::from(i > 0)]).map(|c| Rgb::new(c, c, c)).collect();
    let sent = |z: f64| {
        let ball = Placement::new([3.0, 0.0, z], Rotation::IDENTITY, 1.0);
        let fields = ShadowFields::new(ORDER, &entities(field, &[ball]), all_of_it()).unwrap();
        f64::from(fields.shade(&receivers, &sky).unwrap()[0].g)
    };
    let radius = field.grid().radius();
    let step = (sent(-radius * 1.001) - sent(-radius * 0.999)).abs();
    assert!(step < HORIZON_STEP, "a step of {step} of 1 in the open");
    // Transfer may come from below: what is there hides it.
    let up: Vec<f32> = (0..16).map(|i| [1.0, 0.0][usize::from(i > 0)]).collect();
    let transfer = Transfer::new(ORDER, Channels::Gray, up).unwrap();
    let sent = |entities: &[PlacedField<'_>]| {
        ShadowFields::new(ORDER, entities, all_of_it()).unwrap().shade_transfer(&receivers, &transfer, &sky).unwrap()[0]
            .g
    };
    let below = Placement::new([0.0, 0.0, -3.0], Rotation::IDENTITY, 1.0);
    let [open, hidden] = [sent(&[]), sent(&entities(field, &[below]))];
    assert!(hidden < 0.99 * open, "{hidden} of {open} with a ball below");
}

/// What a ball of a third of its distance changes of exit radiance 1 as it touches the horizon from below.
const HORIZON_STEP: f64 = 1e-3;

fn light() -> Vec<Rgb<f64>> {
    let mut random = Random::new(12);
    (0..16).map(|i| Rgb::new(if i == 0 { 3.0 } else { random.signed() }, random.signed(), random.signed())).collect()
}

#[test]
fn exit_radiance_is_the_integral_of_light_visibility_and_cosine() {
    let (field, placements) = (field_of_rabbit(), herd(4));
    let fields = ShadowFields::new(ORDER, &entities(field, &placements), all_of_it()).unwrap();
    let (positions, normals) = near_origin(33);
    let albedos: Vec<[f32; 3]> = (0..33).map(|k| [0.5, 0.03 * k as f32, 1.0]).collect();
    let own: Vec<f32> = normals
        .iter()
        .flat_map(|n| Zonal::cone(ORDER, 1.2).towards(Dir::from_f32(*n).unwrap(), 1.0_f32).into_vec())
        .collect();
    let open = ShadowReceivers::new(&positions, &normals).unwrap().with_albedos(&albedos).unwrap();
    for receivers in [open, open.with_own_visibility(ORDER, &own).unwrap()] {
        let shaded = fields.shade(&receivers, &light()).unwrap();
        let visible = fields.visibility(&receivers).unwrap();
        // The same by transfer: cosine and albedo of each receiver, in three channels.
        for k in 0..33 {
            let cosine = Zonal::clamped_cosine(ORDER).towards(Dir::from_f32(normals[k]).unwrap(), (1.0 / PI) as f32);
            let mut product = [0.0_f32; 16];
            product_into(&visible[16 * k..][..16], cosine.coefficients(), &mut product);
            let sum = |c: usize| -> f64 {
                (0..16).map(|i| f64::from(product[i]) * light()[i].to_array()[c]).sum::<f64>()
                    * f64::from(albedos[k][c])
            };
            for c in 0..3 {
                let found = f64::from(shaded[k].to_array()[c]);
                assert!((found - sum(c)).abs() < 1e-4, "receiver {k}, channel {c}: {found} against {}", sum(c));
            }
        }
    }
    // Transfer that is the cosine gives the same for one channel and for three, without a horizon.
    let white = ShadowReceivers::new(&positions, &normals).unwrap();
    let expected: Vec<Rgb<f32>> = positions
        .iter()
        .zip(&normals)
        .map(|(position, normal)| {
            let visible = fields.visibility_at(*position, None, None).unwrap();
            let cosine = Zonal::clamped_cosine(ORDER).towards(Dir::from_f32(*normal).unwrap(), (1.0 / PI) as f32);
            let mut product = [0.0_f32; 16];
            product_into(visible.coefficients(), cosine.coefficients(), &mut product);
            let channel = |c: usize| (0..16).map(|i| product[i] * light()[i].to_array()[c] as f32).sum();
            Rgb::new(channel(0), channel(1), channel(2))
        })
        .collect();
    for channels in [Channels::Gray, Channels::Rgb] {
        let rows: Vec<f32> = normals
            .iter()
            .flat_map(|n| {
                let row = Zonal::clamped_cosine(5).towards(Dir::from_f32(*n).unwrap(), (1.0 / PI) as f32).into_vec();
                vec![row; channels.count()].concat()
            })
            .collect();
        let transfer = Transfer::new(5, channels, rows).unwrap();
        let found = fields.shade_transfer(&white, &transfer, &light()).unwrap();
        for (k, (a, b)) in found.iter().zip(&expected).enumerate() {
            let off = (0..3).map(|c| (a.to_array()[c] - b.to_array()[c]).abs()).fold(0.0, f32::max);
            assert!(off < 2e-5, "{channels:?}, receiver {k}: {a:?} against {b:?}");
        }
    }
}

#[test]
fn a_frame_of_ones_own_needs_no_turned_vectors() {
    let (field, placements) = (field_of_rabbit(), herd(4));
    let frame = Placement::new([0.4, -0.2, 0.1], turned(99), 1.7);
    let in_world = ShadowFields::new(ORDER, &entities(field, &placements), all_of_it()).unwrap();
    let relative: Vec<Placement> = placements.iter().map(|p| relative_placement(p, &frame)).collect();
    let in_frame = ShadowFields::new(ORDER, &entities(field, &relative), all_of_it()).unwrap();
    let (positions, normals) = near_origin(20);
    let world: Vec<[f32; 3]> = positions.iter().map(|p| frame.to_world(p.map(f64::from)).map(|c| c as f32)).collect();
    let turn = |n: &[f32; 3]| frame.rotation().rotate_dir(Dir::from_f32(*n).unwrap()).to_array().map(|c| c as f32);
    let world_normals: Vec<[f32; 3]> = normals.iter().map(turn).collect();
    let light_in_frame = ShVec::from_vec(light()).unwrap().rotated(&frame.rotation().inverse());
    let expected = in_world.shade(&ShadowReceivers::new(&world, &world_normals).unwrap(), &light()).unwrap();
    let found =
        in_frame.shade(&ShadowReceivers::new(&positions, &normals).unwrap(), light_in_frame.coefficients()).unwrap();
    for (k, (a, b)) in found.iter().zip(&expected).enumerate() {
        let off = (0..3).map(|c| (a.to_array()[c] - b.to_array()[c]).abs()).fold(0.0, f32::max);
        assert!(off < 1e-3, "receiver {k}: {a:?} in the frame, {b:?} in the world");
    }
}

#[test]
fn a_lamp_is_dimmed_by_what_is_nearer_than_it_alone() {
    let field = field_of_ball();
    let lamp = RadianceField::ball(ORDER, [0.0; 3], 0.5, Rgb::new(1.0, 2.0, 3.0)).unwrap();
    let at = |z: f64| Placement::new([0.0, 0.0, z], turned(1), 1.0);
    let lamps = [LocalLight { field: &lamp, placement: at(6.0) }];
    let (positions, normals) = ([[0.0_f32; 3], [0.5, 0.0, 0.0]], [[0.0_f32, 0.0, 1.0]; 2]);
    let receivers = ShadowReceivers::new(&positions, &normals).unwrap();
    let sent = |occluders: &[Placement]| {
        let fields = ShadowFields::new(ORDER, &entities(field, occluders), all_of_it()).unwrap();
        fields.with_lights(&lamps).unwrap().shade(&receivers, &[]).unwrap()[0]
    };
    // Lambert: π sin² a of a ball overhead, over π; order 4 has 17/16 of the cosine towards a spot.
    let expected = (0.5_f64 / 6.0).powi(2) * 17.0 / 16.0;
    let open = sent(&[]);
    assert!((f64::from(open.g) / (2.0 * expected) - 1.0).abs() < 0.02, "{open:?}, expected {expected} in red");
    assert!((open.b - 3.0 * open.r).abs() < 1e-6, "its color: {open:?}");
    assert_eq!(sent(&[at(9.0)]), open, "a ball behind the lamp");
    let dimmed = sent(&[at(3.0)]);
    // Order 4 blurs the edge of the shadow over some 45 degrees: of a lamp that is hidden two thirds shine on.
    assert!(dimmed.g < 0.7 * open.g, "a ball before the lamp: {dimmed:?} of {open:?}");
}

#[test]
fn overlapping_entities_hide_what_both_hide_once() {
    let field = field_of_ball();
    let place = Placement::new([0.0, 0.0, 2.0], Rotation::IDENTITY, 1.0);
    let visible = |count: usize| {
        let fields = ShadowFields::new(ORDER, &entities(field, &vec![place; count]), all_of_it()).unwrap();
        fields.visibility_at([0.0; 3], None, None).unwrap().mean()
    };
    let (one, two, three) = (visible(1), visible(2), visible(3));
    let hidden = 1.0 - one;
    // Of order 4 the square of a step differs from the step.
    assert!((one - two).abs() < 0.4 * hidden && (two - three).abs() < 0.08 * hidden, "{one}, {two}, {three}");
}

#[test]
fn no_entities_no_receivers_and_receivers_within_are_defined() {
    let field = field_of_ball();
    let none = ShadowFields::new(ORDER, &[], ShadowFieldOptions::default()).unwrap();
    assert_eq!(none.visibility_at([1.0, 2.0, 3.0], None, None).unwrap(), ShVec::constant(ORDER, 1.0), "all is visible");
    let nobody = ShadowReceivers::new(&[], &[]).unwrap();
    assert!(nobody.is_empty() && none.visibility(&nobody).unwrap().is_empty(), "nobody sees nothing");
    assert!(none.shade(&nobody, &light()).unwrap().is_empty(), "nor sends");
    let here = Placement::new([0.0; 3], turned(3), 1.0);
    for interpolation in [RadialInterpolation::Linear, RadialInterpolation::Cubic] {
        let options = all_of_it().interpolation(interpolation);
        let fields = ShadowFields::new(ORDER, &entities(field, &[here]), options).unwrap();
        for p in [[0.0_f32; 3], [0.2, 0.0, 0.0], [0.0, 1.0, 0.0]] {
            let visible = fields.visibility_at(p, Some([0.0, 0.0, 1.0]), None).unwrap();
            assert!(visible.coefficients().iter().all(|c| c.is_finite()), "{p:?}: {visible:?}");
            assert!((-0.1..0.9).contains(&visible.mean()), "{p:?} sees {}", visible.mean());
        }
    }
}

#[test]
fn wrong_orders_and_numbers_are_refused_in_one_line() {
    let field = &field_of_ball().truncated(3).unwrap();
    let lamp = RadianceField::ball(3, [0.0; 3], 0.5, Rgb::new(1.0, 2.0, 3.0)).unwrap();
    let here = Placement::new([0.0; 3], Rotation::IDENTITY, 1.0);
    let new = |order, options| ShadowFields::new(order, &entities(field, &[here]), options);
    let fields = new(3, all_of_it()).unwrap();
    let lamps = [LocalLight { field: &lamp, placement: here }];
    let positions = [[0.0_f32; 3]; 2];
    let up = [[0.0, 0.0, 1.0_f32]; 2];
    let receivers = ShadowReceivers::new(&positions, &up).unwrap();
    let own = [0.0; 32];
    let of_order_4 = receivers.with_own_visibility(4, &own).unwrap();
    let transfer =
        |order: usize, rows: usize| Transfer::new(order, Channels::Gray, vec![0.0; rows * order * order]).unwrap();
    let four = ShadowFields::new(4, &[], all_of_it()).unwrap();
    for (found, expected) in [
        (new(4, all_of_it()).map(drop), "expected the field of entity 0 to have 4 bands at least, found 3"),
        (new(0, all_of_it()).map(drop), "an order of 1 to 8, found 0"),
        (new(3, all_of_it().negligible(-1.0)).map(drop), "a negligible solid angle of 0 or above, found -1"),
        (new(3, all_of_it().negligible(f64::NAN)).map(drop), "found NaN"),
        (four.with_lights(&lamps).map(drop), "expected the light of lamp 0 to have 4 bands at least, found 3"),
        (fields.visibility(&of_order_4).map(drop), "expected visibility of 9 numbers for each receiver"),
        (fields.shade(&of_order_4, &[]).map(drop), "that of order 3, found 16"),
        (fields.shade_transfer(&receivers, &transfer(2, 2), &[]).map(drop), "3 bands at least, found 2"),
        (fields.shade_transfer(&receivers, &transfer(3, 5), &[]).map(drop), "transfer of 2 receivers, found 5"),
        (fields.visibility_at([f32::NAN; 3], None, None).map(drop), "no finite number"),
        (fields.visibility_at([0.0; 3], None, Some(&[1.0; 4])).map(drop), "visibility of 9 numbers"),
        (ShadowReceivers::new(&positions, &up[1..]).map(drop), "one normal for each of 2, found 1"),
        (
            ShadowReceivers::new(&positions, &positions).map(drop),
            "normals of length 1, found [0.0, 0.0, 0.0] at receiver 0",
        ),
        (ShadowReceivers::new(&positions, &[up[0], [0.0, 2.0, 0.0]]).map(drop), "found [0.0, 2.0, 0.0] at receiver 1"),
        (fields.visibility_at([0.0; 3], Some([0.5; 3]), None).map(drop), "normals of length 1"),
        (receivers.with_own_visibility(usize::MAX, &own).map(drop), "an order of 1 to 8, found 18446744073709551615"),
        (receivers.with_albedos(&positions[1..]).map(drop), "one albedo for each of 2, found 1"),
        (receivers.with_own_visibility(4, &own[1..]).map(drop), "found 31"),
    ] {
        let message = found.unwrap_err().to_string();
        assert!(message.contains(expected) && !message.contains('\n'), "{message}, expected {expected}");
    }
}
