//! Occluders that move.

use lobe_gpu::{FieldResponse, GpuShadowFields, GpuSkin, GpuSphereShadows, MorphTarget};
use lobe_prt::{Channels, Transfer};
use lobe_scene::built_in;
use lobe_sh::{Dir, Rgb, Rotation, ShVec};
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
            let visibility = shaded.visibility().unwrap();
            let expected = shadows.visibility(&receivers);
            let wide = |v: &[f32]| v.iter().map(|x| f64::from(*x)).collect::<Vec<_>>();
            let worst = relative_difference(wide(&visibility), wide(&expected));
            assert!(worst < TOLERANCE, "visibility, order {order}, {count} spheres: {worst:e}");
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
        let light = crate::transfer::light(n);
        let own: Vec<f32> = random.signed_vec(n * count).into_iter().map(|x| x as f32).collect();
        let plain = ShadowReceivers::new(&positions, &normals).unwrap().with_albedos(&albedos).unwrap();
        let with_own = plain.with_own_visibility(order, &own).unwrap();
        let rows = random.signed_vec(3 * n * count).into_iter().map(|x| x as f32).collect();
        let transfer = Transfer::new(order, Channels::Rgb, rows).unwrap();
        for (receivers, response) in [(&plain, FieldResponse::Cosine), (&with_own, FieldResponse::Transfer(&transfer))]
        {
            let mut shaded: Option<GpuShadowFields> = None;
            for _ in 0..2 {
                let placed: Vec<PlacedField<'_>> = placements(7, &mut random)
                    .into_iter()
                    .enumerate()
                    .map(|(k, placement)| PlacedField { field: &fields[k % 2], placement })
                    .collect();
                // Moved on the second time.
                if let Some(shaded) = &shaded {
                    shaded.place(&placed).unwrap();
                }
                let shaded = shaded.get_or_insert_with(|| {
                    GpuShadowFields::new(&context, order, &placed, receivers, response, &options).unwrap()
                });
                let found = shaded.exit_radiance(&light).unwrap();
                let cpu = ShadowFields::new(order, &placed, options.clone()).unwrap();
                let expected = match response {
                    FieldResponse::Transfer(transfer) => cpu.shade_transfer(receivers, transfer, &light).unwrap(),
                    _ => cpu.shade(receivers, &light).unwrap(),
                };
                let worst = relative_difference(flat(&found), flat(&expected));
                assert!(worst < TOLERANCE, "order {order}, {response:?}: {worst:e}");
            }
        }
    }
}

#[test]
fn skinned_vertices_are_where_the_processor_has_them() {
    let Some(context) = device("skinned_vertices_are_where_the_processor_has_them") else { return };
    let scene = built_in::walking_figure(8);
    let skinned: Vec<_> = scene.entities().iter().filter(|entity| entity.skin().is_some()).collect();
    assert!(!skinned.is_empty(), "the figure has a skin");
    for entity in skinned {
        let shaded = GpuSkin::of_entity(&context, &scene, entity).unwrap();
        for time in [0.0, 0.3, 0.9] {
            let pose = scene.pose(0, time).unwrap();
            shaded.set_pose(&pose, entity).unwrap();
            let found = shaded.vertices().unwrap();
            let meshes = &pose.scene().meshes()[entity.meshes()];
            let positions: Vec<[f32; 3]> = meshes.iter().flat_map(lobe_scene::Mesh::positions).copied().collect();
            let normals: Vec<[f32; 3]> = meshes.iter().flat_map(lobe_scene::Mesh::normals).copied().collect();
            let p: Vec<[f32; 3]> = found.iter().map(|v| [v.position[0], v.position[1], v.position[2]]).collect();
            let n: Vec<[f32; 3]> = found.iter().map(|v| [v.normal[0], v.normal[1], v.normal[2]]).collect();
            let worst = relative_difference(crate::flat3(&p), crate::flat3(&positions));
            assert!(worst < 1e-5, "positions at {time}: {worst:e}");
            let worst = relative_difference(crate::flat3(&n), crate::flat3(&normals));
            assert!(worst < TOLERANCE, "normals at {time}: {worst:e}");
        }
    }
}

#[test]
fn morph_targets_add_up_by_their_weights() {
    let Some(context) = device("morph_targets_add_up_by_their_weights") else { return };
    let mut random = Random::new(2);
    let count = 100;
    let mut vectors = || -> Vec<[f32; 3]> { (0..count).map(|_| [0, 1, 2].map(|_| random.signed() as f32)).collect() };
    let (positions, normals, first, second, turned) = (vectors(), vectors(), vectors(), vectors(), vectors());
    let targets =
        [MorphTarget { positions: &first, normals: &turned }, MorphTarget { positions: &second, normals: &[] }];
    let influences = vec![vec![(0, 1.0)]; count];
    let shaded = GpuSkin::new(&context, [&positions, &normals], &influences, 1, &targets).unwrap();
    let still = lobe_scene::AnimatedScene::still(built_in::ball_over_ground(4));
    let place = still.rest_pose().unwrap().place(&still.entities()[0]);
    assert_eq!(place.rows()[0], [1.0, 0.0, 0.0, 0.0], "what stands still is where it is");
    shaded.set_joints(&[place], [0.0; 3]).unwrap();
    shaded.set_weights(&[0.25, -0.5]).unwrap();
    let found = shaded.vertices().unwrap();
    for (k, v) in found.iter().enumerate() {
        let n: [f32; 3] = std::array::from_fn(|c| normals[k][c] + 0.25 * turned[k][c]);
        let length = n.iter().map(|c| c * c).sum::<f32>().sqrt();
        for c in 0..3 {
            let p = positions[k][c] + 0.25 * first[k][c] - 0.5 * second[k][c];
            assert!((v.position[c] - p).abs() < 1e-6, "vertex {k}: {v:?} against {p}");
            assert!((v.normal[c] - n[c] / length).abs() < 1e-5, "vertex {k}: {v:?} against {n:?}");
        }
    }
    assert!(shaded.set_weights(&[1.0]).is_err(), "one weight for two targets");
}
