//! Occluders that move.

use lobe_gpu::{FieldResponse, GpuMovingPart, GpuSphereShadows, MovingObstacles, MovingPlaces};
use lobe_prt::{Channels, Transfer};
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, Rotation, ShVec};
use lobe_shadow::{
    FieldGrid, LogTable, LogTableOptions, Occluder, OcclusionField, PlacedField, Placement, ShadowFieldOptions,
    ShadowFields, ShadowOptions, ShadowReceivers, SkyLight, SphereShadows,
};
use lobe_testkit::Random;

use crate::{TOLERANCE, device, flat, relative_difference};

/// Spheres that overlap, above, below and around the receivers.
pub(crate) fn spheres(count: usize, random: &mut Random) -> Vec<Occluder> {
    let sphere = |_| {
        let center = [0, 1, 2].map(|_| (2.0 * random.signed()) as f32);
        Occluder::new(center, (0.1 + 0.5 * random.unit()) as f32)
    };
    (0..count).map(sphere).collect()
}

pub(crate) fn sky(order: usize) -> ShVec<Rgb<f32>> {
    let mut random = Random::new(7);
    let mut c: Vec<Rgb<f32>> = (0..order * order)
        .map(|_| Rgb::new(0.2 * random.signed() as f32, 0.2 * random.signed() as f32, 0.2 * random.signed() as f32))
        .collect();
    c[0] = Rgb::new(2.0, 2.5, 3.0);
    ShVec::from_vec(c).unwrap()
}

#[test]
fn spheres_leave_as_much_of_the_sky_as_on_the_processor() {
    let Some(context) = device("spheres_leave_as_much_of_the_sky_as_on_the_processor") else { return };
    let mut random = Random::new(17);
    let positions: Vec<[f32; 3]> = (0..200).map(|_| [0, 1, 2].map(|_| 2.0 * random.signed() as f32)).collect();
    let normals: Vec<[f32; 3]> = (0..200).map(|_| random.direction().map(|c| c as f32)).collect();
    let receivers = ShadowReceivers::new(&positions, &normals).unwrap();
    for order in [3, 6] {
        let table = LogTable::new(&LogTableOptions::default().order(order)).unwrap();
        let mut shaded = GpuSphereShadows::new(&context, &table, &receivers, 24).unwrap();
        let light = SkyLight::new(&sky(4), order).unwrap();
        // Moved, fewer, none: on one upload of the receivers.
        for (count, share) in [(24, true), (24, false), (5, true), (0, true)] {
            let spheres = spheres(count, &mut random);
            let options = ShadowOptions::default().cut(0.0).share_overlaps(share);
            let shadows = SphereShadows::new(&table, &spheres, &options).unwrap();
            shaded.set_spheres(&shadows).unwrap();
            let found = shaded.irradiance(&light).unwrap();
            let expected = shadows.irradiance(&receivers, &light).unwrap();
            let worst = relative_difference(flat(&found), flat(&expected));
            assert!(worst < TOLERANCE, "order {order}, {count} spheres, {share}: {worst:e}");
        }
        let many = spheres(25, &mut random);
        let shadows = SphereShadows::new(&table, &many, &ShadowOptions::default().share_overlaps(false)).unwrap();
        assert!(shaded.set_spheres(&shadows).is_err(), "no room for 25");
    }
}

/// A field of noise: what is looked up where matters here, not what hides.
pub(crate) fn noise_field(order: usize, random: &mut Random) -> OcclusionField {
    let grid = FieldGrid::new([0.1, -0.2, 0.3], 0.7, [0.3, 6.0], 5, 4).unwrap();
    let count = grid.points() * (order + order * order);
    let rows = random.signed_vec(count).into_iter().map(|x| 0.2 * x as f32).collect();
    OcclusionField::new(grid, order, rows).unwrap()
}

pub(crate) fn placements(count: usize, random: &mut Random) -> Vec<Placement> {
    let place = |k: usize| {
        let turn = Rotation::from_axis_angle(Dir::new(random.direction()).unwrap(), 3.0 * random.signed());
        let turn = if k == 0 { Rotation::IDENTITY } else { turn };
        Placement::new([0, 1, 2].map(|_| 3.0 * random.signed()), turn, 0.5 + random.unit())
    };
    (0..count).map(place).collect()
}

#[test]
fn shadow_fields_leave_what_they_leave_on_the_processor() {
    let Some(context) = device("shadow_fields_leave_what_they_leave_on_the_processor") else { return };
    let mut random = Random::new(23);
    let count = 150;
    let positions: Vec<[f32; 3]> = (0..count).map(|_| [0, 1, 2].map(|_| 2.0 * random.signed() as f32)).collect();
    let normals: Vec<[f32; 3]> = (0..count).map(|_| random.direction().map(|c| c as f32)).collect();
    let albedos: Vec<[f32; 3]> = (0..count).map(|_| [0, 1, 2].map(|_| random.unit() as f32)).collect();
    for order in [2, 4] {
        let n = order * order;
        // One of more bands than are used.
        let fields = [noise_field(order, &mut random), noise_field((order + 1).min(8), &mut random)];
        let options = ShadowFieldOptions::default().negligible(0.3);
        let table = LogTable::new(&LogTableOptions::default().order(order)).unwrap();
        let light = ShVec::from_vec(crate::transfer::light(n)).unwrap();
        let sky = SkyLight::new(&light.map(Rgb::<f32>::narrow), order).unwrap();
        let plain = ShadowReceivers::new(&positions, &normals).unwrap();
        let with_albedos = plain.with_albedos(&albedos).unwrap();
        let rows = random.signed_vec(3 * n * count).into_iter().map(|x| x as f32).collect();
        let transfer = Transfer::new(order, Channels::Rgb, rows).unwrap();
        for (receivers, response) in
            [(&with_albedos, FieldResponse::Cosine), (&plain, FieldResponse::Transfer(&transfer))]
        {
            let mut part: Option<GpuMovingPart> = None;
            // Moved on the second time.
            for _ in 0..2 {
                let placed: Vec<PlacedField<'_>> = placements(7, &mut random)
                    .into_iter()
                    .enumerate()
                    .map(|(k, placement)| PlacedField { field: &fields[k % 2], placement })
                    .collect();
                let obstacles =
                    MovingObstacles { fields: &placed, options: &options, grids: &[], table: &table, most_spheres: 0 };
                let part = part.get_or_insert_with(|| {
                    GpuMovingPart::new(&context, order, receivers, response, &obstacles).unwrap()
                });
                let frame = Placement::new([0.0; 3], Rotation::IDENTITY, 1.0);
                let places = MovingPlaces { frame, fields: &placed, spheres: None, receivers: None };
                part.shade(&places, &light).unwrap();
                let found = part.radiance().unwrap();
                let cpu = ShadowFields::new(order, &placed, options.clone()).unwrap();
                let expected = match response {
                    FieldResponse::Transfer(transfer) => {
                        cpu.shade_transfer(receivers, transfer, light.coefficients()).unwrap()
                    }
                    _ => {
                        let seen = cpu.visibility(receivers).unwrap();
                        let of = |k: usize| {
                            let irradiance = sky.irradiance(normals[k], &seen[n * k..n * (k + 1)]);
                            (irradiance * Rgb::from(albedos[k])).scale(std::f32::consts::FRAC_1_PI)
                        };
                        (0..count).map(of).collect()
                    }
                };
                let worst = relative_difference(flat(&found), flat(&expected));
                assert!(worst < TOLERANCE, "order {order}, {response:?}: {worst:e}");
            }
        }
        let own = vec![0.5; n * count];
        let with_own = plain.with_own_visibility(order, &own).unwrap();
        let obstacles = MovingObstacles { fields: &[], options: &options, grids: &[], table: &table, most_spheres: 0 };
        let refused = GpuMovingPart::new(&context, order, &with_own, FieldResponse::Cosine, &obstacles);
        assert!(refused.is_err(), "visibility of their own is not looked at");
    }
}
