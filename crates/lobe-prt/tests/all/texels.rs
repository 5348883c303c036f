//! Receivers at the texels of a lightmap.

use crate::common::{baked, options};
use lobe_io::Job;
use lobe_prt::{BakeMode, Lightmap, TexelReceivers, Transfer};
use lobe_scene::{Bvh, Hit, Material, Mesh, MeshParts, Ray, Scene, UnwrapOptions};

/// A square of side 2 about the origin, facing up, whose picture fills the part `[from, to]²` of the unit square; x
/// along u, y against v.
fn square(from: f32, to: f32, set: usize, z: f32) -> MeshParts {
    let mut parts = MeshParts {
        name: "square".into(),
        positions: vec![[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        colors: vec![[0.0, 0.5, 0.5, 1.0], [1.0, 0.5, 0.5, 1.0], [1.0, 0.5, 0.5, 1.0], [0.0, 0.5, 0.5, 1.0]],
        ..MeshParts::default()
    };
    parts.uvs[set] = vec![[from, to], [to, to], [to, from], [from, from]];
    parts
}

fn scene(parts: impl IntoIterator<Item = MeshParts>) -> Scene {
    let meshes = parts.into_iter().map(|parts| Mesh::new(parts).unwrap()).collect();
    Scene::new(meshes, Vec::<Material>::new(), vec![]).unwrap()
}

#[test]
fn texels_lie_where_the_surface_is_unfolded() {
    for set in [0, 1] {
        let texels = TexelReceivers::new(&scene([square(0.25, 0.75, set, 0.0)]), 16).unwrap();
        let receivers = texels.receivers();
        // Eight texels have their center inside; their neighbors touch at most a corner.
        let inside = receivers.positions().iter().filter(|p| p[0].abs() < 0.99 && p[1].abs() < 0.99).count();
        assert_eq!(inside, 64, "set {set}");
        for (i, &texel) in texels.texels().iter().enumerate() {
            let (x, y) = (texel as usize % 16, texel as usize / 16);
            let expected = [x, 15 - y].map(|k| ((k as f32 + 0.5) / 4.0 - 2.0).clamp(-1.0, 1.0));
            let (found, albedo) = (receivers.positions()[i], receivers.albedos()[i]);
            assert!(
                (0..2).all(|k| (found[k] - expected[k]).abs() < 2e-5),
                "texel {x}, {y}: {found:?}, not {expected:?}"
            );
            assert!((albedo[0] - (expected[0] + 1.0) / 2.0).abs() < 1e-5, "texel {x}, {y}: red {}", albedo[0]);
            assert_eq!(receivers.normals()[i], [0.0, 0.0, 1.0], "normal of texel {x}, {y}");
        }
    }
}

#[test]
fn at_an_edge_between_colors_of_zero_no_albedo_is_below_zero() {
    let mut parts = square(0.01, 0.93, 0, 0.0);
    parts.colors = vec![[1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0]];
    for width in [30, 57, 101] {
        let texels = TexelReceivers::new(&scene([parts.clone()]), width).unwrap();
        let least = texels.receivers().albedos().as_flattened().iter().fold(1.0_f32, |least, c| least.min(*c));
        assert_eq!(least, 0.0, "{width} texels");
    }
}

#[test]
fn every_texel_of_the_picture_shows_a_nearest_receiver() {
    let texels = TexelReceivers::new(&scene([square(0.25, 0.5, 0, 0.0)]), 16).unwrap();
    let values: Vec<f32> = (0..texels.receivers().len()).map(|i| i as f32).collect();
    let transfer = Transfer::new(1, lobe_prt::Channels::Gray, values).unwrap();
    let picture = texels.picture(&transfer).unwrap();
    assert_eq!(picture.receivers(), 256, "texels");
    let places: Vec<(i32, i32)> = texels.texels().iter().map(|&t| (t as i32 % 16, t as i32 / 16)).collect();
    for (texel, &shown) in picture.coefficients().iter().enumerate() {
        let (x, y) = (texel as i32 % 16, texel as i32 / 16);
        let steps = |&(a, b): &(i32, i32)| (x - a).abs().max((y - b).abs());
        let (found, least) = (steps(&places[shown as usize]), places.iter().map(steps).min().unwrap());
        assert_eq!(found, least, "texel {x}, {y} shows {:?}", places[shown as usize]);
    }
    let wrong = texels.picture(&picture).unwrap_err().to_string();
    assert!(wrong.starts_with("lightmap: expected transfer of "), "{wrong}");
}

#[test]
fn transfer_at_texels_is_that_of_receivers_there() {
    let scene = scene([square(0.0, 0.5, 1, 0.0), square(0.5, 1.0, 1, 1.0)]);
    let texels = TexelReceivers::new(&scene, 8).unwrap();
    let (transfer, _) = baked(&scene, texels.receivers(), &options(BakeMode::Shadowed, 2, 256));
    for (i, position) in texels.receivers().positions().iter().enumerate() {
        let [below, above] = [position[2] < 0.5, position[2] > 0.5];
        let open = transfer.vector(i, 1)[0] / (0.5 * 0.5 / std::f32::consts::PI.sqrt());
        assert!((above && open > 0.999) || (below && open < 0.9), "{position:?}: {open} of the sky");
    }
}

#[test]
fn unfoldings_that_cannot_hold_light_are_refused_in_one_line() {
    let refusal = |scene: Scene, width| TexelReceivers::new(&scene, width).unwrap_err().to_string();
    let mut bare = square(0.0, 1.0, 0, 0.0);
    bare.uvs = [vec![], vec![]];
    let cases = [
        (refusal(scene([square(0.0, 1.0, 0, 0.0)]), 0), "expected a width of 1 to 16384 texels, found 0"),
        (
            refusal(scene([bare]), 8),
            "mesh `square`: it has no texture coordinates for a lightmap; unfold it into a set of its own",
        ),
        (
            refusal(scene([square(0.0, 0.5, 0, 0.0), square(0.25, 0.75, 0, 1.0)]), 8),
            "mesh `square`: triangles overlap in the lightmap at texel 2, 2; unfold them apart",
        ),
        (
            refusal(scene([square(0.5, 1.5, 0, 0.0)]), 8),
            "mesh `square`: expected texture coordinates in the unit square, found [[0.5, 1.5], [1.5, 1.5], [1.5, 0.5]]",
        ),
    ];
    for (found, expected) in cases {
        assert_eq!(found, expected, "refusal");
    }
}

#[test]
fn texels_whose_center_is_on_an_edge_of_the_picture_do_not_see_behind_a_wall_there() {
    // The edges of the floor's picture run through centers of texels, and a wall stands on one of them.
    let floor = square(0.5 / 32.0, 15.5 / 32.0, 0, 0.0);
    let mut wall = square(0.6, 0.9, 0, 0.0);
    wall.positions = vec![[1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 2.0], [1.0, -1.0, 2.0]];
    let scene = scene([floor, wall]);
    let texels = TexelReceivers::new(&scene, 32).unwrap();
    let (transfer, _) = baked(&scene, texels.receivers(), &options(BakeMode::Shadowed, 1, 1024));
    let mut beside_the_wall = 0;
    for (i, position) in texels.receivers().positions().iter().enumerate() {
        if position[0] > 0.999 && position[1].abs() < 0.8 && position[2] == 0.0 {
            // A wall takes half of what arrives at its foot, whatever its height.
            let open = transfer.vector(i, 1)[0] / (0.5 * 0.5 / std::f32::consts::PI.sqrt());
            assert!((open - 0.5).abs() < 0.02, "{position:?}: {open} of the sky");
            beside_the_wall += 1;
        }
    }
    assert!(beside_the_wall >= 11, "{beside_the_wall} texels beside the wall");
}

/// A closed room of half a side of 1, whose walls, floor and ceiling go on beyond each other by `over`, each unfolded
/// into a sixth.
fn overhanging_room(over: f32) -> Scene {
    let side = 1.0 + over;
    let walls = (0..6).map(|k| {
        let (axis, sign) = (k % 3, if k < 3 { 1.0 } else { -1.0 });
        let corner = |a: f32, b: f32| {
            let mut p = [0.0; 3];
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (sign, a * side, b * side);
            p
        };
        let positions = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let (left, top) = ((k % 3) as f32 / 3.0 + 0.02, (k / 3) as f32 / 2.0 + 0.03);
        let (right, bottom) = (left + 0.29, top + 0.44);
        // Fronts look inside.
        let triangles = if sign < 0.0 { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[0, 2, 1], [0, 3, 2]] };
        let mut parts = MeshParts { name: format!("wall {k}"), positions, triangles, ..MeshParts::default() };
        parts.uvs[0] = vec![[left, top], [right, top], [right, bottom], [left, bottom]];
        parts
    });
    scene(walls)
}

/// The most light that a lightmap shows at places of the walls of that room that are inside of it.
fn brightest_inside(scene: &Scene, over: f32, width: usize) -> f64 {
    /// Places along each wall, the outermost next to its foot.
    const PLACES: usize = 97;
    let texels = TexelReceivers::new(scene, width).unwrap();
    let (transfer, _) = baked(scene, texels.receivers(), &options(BakeMode::Shadowed, 1, 64));
    let (picture, lightmap) = (texels.picture(&transfer).unwrap(), Lightmap::new(scene, width).unwrap());
    // Places of a square of side 1 from the first corner of both triangles, of which the inner part is in the room.
    let part = |k: usize| 0.5 + (k as f32 / (PLACES - 1) as f32 - 0.5) * 0.9999 / (1.0 + over);
    let shown = |(triangle, a, b): (u32, f32, f32)| {
        let hit = Hit { t: 0.0, triangle, u: a, v: b };
        let texels = lightmap.texels_at(scene, &hit).into_iter();
        texels.map(|(texel, part)| f64::from(picture.vector(texel, 0)[0]) * part).sum::<f64>()
    };
    let places = (0..12).flat_map(|triangle| {
        let all = (0..PLACES * PLACES).map(move |k| (part(k / PLACES), part(k % PLACES)));
        // Of two corners after the first one is a side from it, the other a diagonal: `triangles` of the room.
        let is_diagonal_last = (triangle % 2 == 0) == (triangle >= 6);
        let corners = move |(x, y): (f32, f32)| {
            let (diagonal, side) = (x.min(y), x.max(y) - x.min(y));
            if is_diagonal_last { (triangle, side, diagonal) } else { (triangle, diagonal, side) }
        };
        all.map(corners)
    });
    places.map(shown).fold(0.0, f64::max)
}

#[test]
fn a_closed_room_stays_black_up_to_its_walls_however_far_they_go_on_beyond_each_other() {
    for over in [0.0, 0.001, 0.01, 0.05, 0.3] {
        let scene = overhanging_room(over);
        for width in [24, 50, 128, 256] {
            let brightest = brightest_inside(&scene, over, width);
            assert!(brightest < 1e-3, "{over} of {width} texels: {brightest}, what is between texels is no brighter");
        }
    }
}

#[test]
fn a_wall_that_goes_on_beyond_a_closed_room_keeps_its_texels_there() {
    // Walls reach 0.3 beyond each other: at least 8 texels of 256, of which the first moves.
    let texels = TexelReceivers::new(&overhanging_room(0.3), 256).unwrap();
    let beyond = |p: &&[f32; 3]| p.iter().any(|c| c.abs() > 1.06);
    let (found, all) = (texels.receivers().positions().iter().filter(beyond).count(), texels.receivers().len());
    // The part of a wall that is farther than 1.06 from its middle, and the texels that its border only touches.
    let expected = (1.0 - (1.06_f64 / 1.3).powi(2)) * all as f64;
    assert!((found as f64 / expected - 1.0).abs() < 0.1, "{found} of {all} texels far beyond, expected {expected}");
}

#[test]
fn a_floor_that_goes_on_far_behind_a_wall_is_lit_there() {
    // The wall stands in the middle of the floor, along x = 0.25.
    let mut wall = square(0.6, 0.9, 0, 0.0);
    wall.positions = vec![[0.25, -1.0, 0.0], [0.25, 1.0, 0.0], [0.25, 1.0, 2.0], [0.25, -1.0, 2.0]];
    let both = scene([square(0.0, 0.5, 0, 0.0), wall]);
    let (moved, plain) =
        (TexelReceivers::new(&both, 64).unwrap(), TexelReceivers::new(&scene([square(0.0, 0.5, 0, 0.0)]), 64));
    let behind = |texels: &TexelReceivers| {
        let positions = texels.receivers().positions().iter();
        positions.filter(|p| p[2] == 0.0 && p[0] > 0.26).count()
    };
    assert_eq!(behind(&moved), behind(&plain.unwrap()), "texels of the floor behind the wall");
}

const WIDTH: usize = 64;

/// A floor of side 2 and these rectangles of a single or double-sided material, each by three corners that are followed
/// by the fourth, unfolded.
fn on_a_floor(rectangles: &[[[f32; 3]; 3]], double_sided: bool) -> Scene {
    let corners = |[a, b, c]: [[f32; 3]; 3]| [a, b, c, [0, 1, 2].map(|k| a[k] + c[k] - b[k])];
    let triangles = |k: u32| [[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]];
    let block = MeshParts {
        positions: rectangles.iter().copied().flat_map(corners).collect(),
        triangles: (0..rectangles.len() as u32).flat_map(triangles).collect(),
        material: Some(0),
        ..MeshParts::default()
    };
    let floor = MeshParts { material: Some(0), colors: vec![], ..square(0.0, 0.5, 0, 0.0) };
    let material = Material { double_sided, ..Material::matte("white", [1.0; 3]) };
    let meshes = [floor, block].map(|parts| Mesh::new(parts).unwrap());
    let scene = Scene::new(meshes.to_vec(), vec![material], vec![]).unwrap();
    scene.unwrapped(&UnwrapOptions::default().texels(WIDTH), Job::default()).unwrap().0
}

/// The four sides of a box from z = 0 to 0.5 between these bounds, and its top, seen from outside.
fn sides_and_top([x, y]: [[f32; 2]; 2]) -> [[[f32; 3]; 3]; 5] {
    const TOP: f32 = 0.5;
    let side = |[a, b]: [f32; 2], [c, d]: [f32; 2]| [[a, b, 0.0], [c, d, 0.0], [c, d, TOP]];
    let [p, q, r, s] = [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]];
    let [on_p, on_q, on_r] = [p, q, r].map(|[x, y]| [x, y, TOP]);
    [side(p, q), side(q, r), side(r, s), side(s, p), [on_p, on_q, on_r]]
}

/// What the lightmap of a scene shows of the sky at places of its floor, as a part of all of it.
fn shown_of_the_sky(scene: &Scene, places: impl Iterator<Item = [f32; 2]>) -> Vec<([f32; 2], f64)> {
    let texels = TexelReceivers::new(scene, WIDTH).unwrap();
    let (transfer, _) = baked(scene, texels.receivers(), &options(BakeMode::Shadowed, 1, 256));
    let (picture, lightmap) = (texels.picture(&transfer).unwrap(), Lightmap::new(scene, WIDTH).unwrap());
    let bvh = Bvh::new(scene);
    let shown = |[x, y]: [f32; 2]| {
        // From just above the floor, under whatever is above.
        let hit = bvh.closest(&Ray::new([x, y, 0.01], [0.0, 0.0, -1.0])).unwrap();
        let parts = lightmap.texels_at(scene, &hit);
        let shown: f64 = parts.iter().map(|&(texel, part)| f64::from(picture.vector(texel, 0)[0]) * part).sum();
        ([x, y], shown / (0.5 / std::f64::consts::PI.sqrt()))
    };
    places.map(shown).collect()
}

#[test]
fn a_solid_block_on_a_floor_has_no_black_line_at_its_foot() {
    let sides = sides_and_top([[-0.3, 0.3]; 2]);
    let bottom = [[-0.3, -0.3, 0.0], [-0.3, 0.3, 0.0], [0.3, 0.3, 0.0]];
    let closed: Vec<_> = sides.into_iter().chain([bottom]).collect();
    for (block, double_sided) in [(&sides[..], false), (&sides[..], true), (&closed[..], true)] {
        let places = (0..200).map(|k| {
            let (along, side) = ((k % 50) as f32 / 49.0 * 0.5 - 0.25, k / 50);
            let off = if side < 2 { 0.302 } else { -0.302 };
            if side % 2 == 0 { [off, along] } else { [along, off] }
        });
        for (place, open) in shown_of_the_sky(&on_a_floor(block, double_sided), places) {
            // The foot of a wall sees between a half and all of the sky.
            let what = format!("{} sides, double-sided {double_sided}", block.len());
            assert!((0.45..1.01).contains(&open), "{what}, at {place:?}: {open} of the sky");
        }
    }
}

#[test]
fn a_room_with_a_door_is_no_solid_though_its_walls_are_modeled_from_outside() {
    // Two rooms behind each other; the second has no roof, and a low door leads to it.
    let [front, right, back, left, _] = sides_and_top([[-0.6, 0.6], [-0.4, 0.4]]);
    let roof = [[-0.6, -0.4, 0.5], [0.0, -0.4, 0.5], [0.0, 0.4, 0.5]];
    let over_the_door = [[0.0, -0.4, 0.15], [0.0, 0.4, 0.15], [0.0, 0.4, 0.5]];
    let scene = on_a_floor(&[front, right, back, left, roof, over_the_door], true);
    let places = (0..50).map(|k| [-0.598, k as f32 / 49.0 * 0.7 - 0.35]);
    for (place, open) in shown_of_the_sky(&scene, places) {
        assert!(open < 1e-3, "at {place:?}, where no sky is to be seen: {open} of the sky");
    }
}
