//! Rays: the same hits by every route, no gaps, no self-hits.

use lobe_scene::{Bvh, Hit, Ray, Simd, built_in};
use lobe_testkit::{Random, directions};

type Corners = [[f32; 3]; 3];

fn narrow(v: [f64; 3]) -> [f32; 3] {
    v.map(|c| c as f32)
}

fn add(a: [f32; 3], b: [f32; 3], factor: f32) -> [f32; 3] {
    std::array::from_fn(|k| a[k] + factor * b[k])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Triangles of mixed size about the origin, some of them slivers.
fn soup(count: usize, seed: u64) -> Vec<Corners> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|i| {
            let center = narrow(random.direction().map(|c| c * 2.0 * random.unit()));
            let size = if i % 5 == 0 { 1.0 } else { 0.2 };
            let flat = if i % 7 == 0 { 1e-4 } else { 1.0 };
            let a = narrow(random.direction());
            let b = narrow(random.direction());
            [center, add(center, a, size), add(add(center, a, size * 0.5), b, size * flat)]
        })
        .collect()
}

/// Rays from in and around the soup, some along axes, some short, some with long or short directions.
fn rays(count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let special = directions();
    (0..count)
        .map(|i| {
            let direction = if i % 3 == 0 { special[i / 3 % special.len()] } else { random.direction() };
            let length = [1.0, 1e-12, 1e12, 0.37][i % 4];
            let origin = narrow(random.direction().map(|c| c * 3.0 * random.unit()));
            let t_max = if i % 5 == 0 { (2.0 * random.unit() / length) as f32 } else { f32::INFINITY };
            Ray { origin, direction: narrow(direction.map(|c| c * length)), t_max }
        })
        .collect()
}

/// The hit of a ray on a triangle, after Möller and Trumbore in `f64`, and its distance inside (negative: outside).
fn reference(ray: &Ray, corners: &Corners) -> (f64, f64) {
    let wide = |v: [f32; 3]| v.map(f64::from);
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let [a, b, c] = corners.map(wide);
    let (d, o) = (wide(ray.direction), wide(ray.origin));
    let (e1, e2) = (minus(b, a), minus(c, a));
    let p = cross(d, e2);
    let determinant = dot(e1, p);
    let s = minus(o, a);
    let u = dot(s, p) / determinant;
    let q = cross(s, e1);
    let v = dot(d, q) / determinant;
    (dot(e2, q) / determinant, u.min(v).min(1.0 - u - v))
}

/// The tree with all vector instructions of this machine, the widest too.
fn by_each(bvh: &Bvh) -> Vec<(Simd, Bvh)> {
    let with = |simd| match bvh.clone().with_simd(simd) {
        Some(bvh) => Some((simd, bvh)),
        None => {
            lobe_testkit::skipped(&format!("this machine has no {simd:?}"));
            None
        }
    };
    Simd::ALL.into_iter().filter_map(with).collect()
}

#[test]
fn hits_are_the_same_by_all_vector_instructions_and_by_brute_force() {
    let soup = soup(600, 1);
    let bvh = Bvh::from_corners(&soup);
    let by_each = by_each(&bvh);
    let single: Vec<Bvh> = soup.iter().map(|corners| Bvh::from_corners(&[*corners])).collect();
    let mut hits = 0;
    for ray in rays(4000, 2) {
        let brute_force = single
            .iter()
            .enumerate()
            .filter_map(|(i, bvh)| bvh.closest(&ray).map(|hit| Hit { triangle: i as u32, ..hit }))
            .min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
        let closest = bvh.closest(&ray);
        assert_eq!(closest, brute_force, "tree and brute force for {ray:?}");
        assert_eq!(bvh.is_occluded(&ray), closest.is_some(), "any and closest for {ray:?}");
        for (simd, bvh) in &by_each {
            assert_eq!(bvh.closest(&ray), closest, "{simd:?} for {ray:?}");
            assert_eq!(bvh.is_occluded(&ray), closest.is_some(), "{simd:?}, any and closest for {ray:?}");
        }
        hits += usize::from(closest.is_some());
    }
    assert!((1000..3900).contains(&hits), "{hits} of 4000 rays hit: a test of both");
}

#[test]
fn boxes_that_tile_a_square_get_the_tree_of_least_cost() {
    // 8⁴ triangles, each in a cell of its own, by chance along x and y.
    let cell = |i: usize| [(i * 1031 % 4096 % 64) as f32, (i * 1031 % 4096 / 64) as f32];
    let triangle = |[x, y]: [f32; 2]| [[x, y, 0.0], [x + 1.0, y, 0.0], [x, y + 1.0, 0.0]];
    let corners: Vec<Corners> = (0..4096).map(|i| triangle(cell(i))).collect();
    // The root, 8 nodes and 64 nodes, and 8³ full blocks that cost 1.2 each: every level has the area of the square once.
    let (cost, least) = (Bvh::from_corners(&corners).expected_cost(), 1.0 + 1.0 + 1.0 + 1.2);
    assert!((cost - least).abs() < 1e-3, "expected cost {cost}, the least is {least}");
}

#[test]
fn hits_agree_with_moeller_and_trumbore_in_double_precision() {
    let soup: Vec<(Corners, Bvh)> = soup(60, 3).into_iter().map(|c| (c, Bvh::from_corners(&[c]))).collect();
    let mut hits = 0;
    for ray in rays(30_000, 4) {
        for (corners, bvh) in &soup {
            let found = bvh.closest(&ray);
            let (t, inside) = reference(&ray, corners);
            let length = ray.direction.iter().map(|&d| f64::from(d).powi(2)).sum::<f64>().sqrt();
            let (depth, end) = (t * length, f64::from(ray.t_max) * length);
            // The sheared corners are off by some 1e-6, in triangles as flat as 1e-4.
            if inside > 1e-2 && depth > 1e-4 && depth < end - 1e-4 {
                let hit = found.unwrap_or_else(|| panic!("missed {corners:?} with {ray:?} at {t}, inside by {inside}"));
                let error = (f64::from(hit.t) * length - depth).abs();
                assert!(error < 2e-3, "{hit:?} with {ray:?}, expected t {t}");
                hits += 1;
            } else if inside < -1e-2 || depth < -1e-4 || depth > end + 1e-4 {
                assert_eq!(found, None, "{corners:?} with {ray:?} at {t}, inside by {inside}");
            }
        }
    }
    assert!(hits > 2000, "{hits} hits: enough to tell");
}

/// All corners, edges at several places, and centers of the triangles.
fn aims(corners: &[Corners]) -> Vec<[f32; 3]> {
    let mut aims = Vec::new();
    for &[a, b, c] in corners {
        aims.extend([a, b, c]);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            for f in [0.5, 0.25, 0.1, 1.0 / 3.0] {
                aims.push(std::array::from_fn(|k| p[k] + (q[k] - p[k]) * f));
            }
        }
        aims.push(std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0));
    }
    aims
}

/// Closed surfaces around the origin, small and large, near and far.
fn closed_surfaces() -> Vec<(String, Vec<Corners>, [f32; 3])> {
    let mut surfaces = Vec::new();
    let shapes = [
        ("box", built_in::closed_white_box(7).corners().collect::<Vec<_>>(), [0.0; 3]),
        ("ball", built_in::ball_over_ground(40).corners().skip(2 * 40 * 40).collect(), [0.0, 0.0, 1.5]),
    ];
    for (name, corners, center) in shapes {
        for (scale, shift) in [(1.0, 0.0), (1e-3, 0.0), (1e4, 0.0), (1.0, 1000.0), (0.7312, 0.123)] {
            let place = |p: [f32; 3]| p.map(|c| c * scale + shift);
            let moved = corners.iter().map(|triangle| triangle.map(place)).collect();
            surfaces.push((format!("{name} x {scale} + {shift}"), moved, place(center)));
        }
    }
    surfaces
}

#[test]
fn no_ray_leaves_a_closed_surface_through_its_edges_or_corners() {
    let mut random = Random::new(5);
    for (name, corners, center) in closed_surfaces() {
        let bvh = Bvh::from_corners(&corners);
        let by_each = by_each(&bvh);
        let size = (bvh.bounds().max[0] - bvh.bounds().min[0]) * 0.2;
        for (i, aim) in aims(&corners).into_iter().enumerate() {
            let origin = if i % 4 == 0 { center } else { add(center, narrow(random.direction()), size) };
            let ray = Ray::new(origin, std::array::from_fn(|k| aim[k] - origin[k]));
            assert!(bvh.is_occluded(&ray) && bvh.closest(&ray).is_some(), "{name} leaks at {aim:?} with {ray:?}");
            for (simd, bvh) in &by_each {
                assert!(bvh.is_occluded(&ray), "{name} leaks at {aim:?} with {ray:?} by {simd:?}");
            }
        }
        for direction in directions() {
            let ray = Ray::new(center, narrow(direction));
            assert!(bvh.is_occluded(&ray), "{name} leaks with {ray:?}");
        }
        for _ in 0..2000 {
            let ray = Ray::new(add(center, narrow(random.direction()), size), narrow(random.direction()));
            assert!(bvh.is_occluded(&ray), "{name} leaks with {ray:?}");
        }
    }
}

#[test]
fn rays_from_outside_do_not_pass_through_edges_or_corners_of_a_height_field() {
    let scene = built_in::terrain(32);
    let bvh = Bvh::new(&scene);
    let corners: Vec<Corners> = scene.corners().collect();
    let mut random = Random::new(6);
    for aim in aims(&corners) {
        if aim[0].abs().max(aim[1].abs()) > 19.9 {
            continue;
        }
        let up = 10.0 + 5.0 * random.unit() as f32;
        let side = [random.signed() as f32, random.signed() as f32];
        let origin = [aim[0] + side[0], aim[1] + side[1], aim[2] + up];
        for origin in [origin, [aim[0], aim[1], aim[2] + up]] {
            let ray = Ray::new(origin, std::array::from_fn(|k| aim[k] - origin[k]));
            assert!(bvh.is_occluded(&ray), "passed at {aim:?} with {ray:?}");
        }
    }
}

/// Rays that leave a surface at angles down to 1e-6, from corners, edges and centers.
fn grazing_rays(corners: &[Corners], count: usize, origin: impl Fn([f32; 3], [f32; 3]) -> [f32; 3]) -> Vec<Ray> {
    let mut random = Random::new(7);
    let aims = aims(corners);
    let per_triangle = aims.len() / corners.len();
    (0..count)
        .map(|i| {
            let place = (i * 7919) % aims.len();
            let [a, b, c] = corners[place / per_triangle].map(|p| p.map(f64::from));
            let edge = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
            let n = cross(edge(b), edge(c));
            let length = dot(n, n).sqrt();
            let n = n.map(|c| c / length);
            let side = random.direction();
            let away = dot(side, n);
            let tilt = 10_f64.powf(-6.0 * random.unit());
            let direction: [f64; 3] = std::array::from_fn(|k| side[k] - away * n[k]);
            let along = dot(direction, direction).sqrt();
            let direction: [f32; 3] = std::array::from_fn(|k| (direction[k] / along + tilt * n[k]) as f32);
            Ray::new(origin(aims[place], narrow(n)), direction)
        })
        .collect()
}

#[test]
fn grazing_rays_do_not_hit_the_surface_they_start_from() {
    // A tilted, shifted plane cut into triangles, far from the origin, where coordinates are coarse; a convex ball.
    let tilt = |p: [f32; 3]| [p[0] * 0.8 + 30.0, p[1] + 0.3 * p[0] - 20.0, p[2] + 0.37 * p[0] - 0.21 * p[1] + 10.0];
    let ground = built_in::ball_over_ground(16).corners().take(2 * 16 * 16).collect::<Vec<_>>();
    let plane: Vec<Corners> = ground.iter().map(|triangle| triangle.map(tilt)).collect();
    let ball: Vec<Corners> = built_in::ball_over_ground(24).corners().skip(2 * 24 * 24).collect();
    for (name, corners) in [("plane", &plane), ("ball", &ball)] {
        let bvh = Bvh::from_corners(corners);
        let hits = |lifted: bool| {
            let origin = |p, n| if lifted { bvh.origin_above(p, n) } else { p };
            grazing_rays(corners, 50_000, origin).iter().filter(|ray| bvh.is_occluded(ray)).count()
        };
        let (with, without) = (hits(true), hits(false));
        assert_eq!(with, 0, "self-hits on the {name} at an offset of {}", bvh.offset());
        assert!(without > 0, "without an offset the {name} should hit itself, or this test shows nothing");
    }
}

#[test]
fn rays_from_a_vertex_do_not_hit_the_triangles_that_share_it() {
    // Without any offset: the vertex is at the origin of the ray's frame exactly.
    let corners: Vec<Corners> = built_in::ball_over_ground(24).corners().skip(2 * 24 * 24).collect();
    let bvh = Bvh::from_corners(&corners);
    let mut random = Random::new(8);
    for triangle in &corners {
        for &vertex in triangle {
            let direction = random.direction();
            let outwards = dot([vertex[0], vertex[1], vertex[2] - 1.5].map(f64::from), direction);
            let ray = Ray::new(vertex, narrow(direction.map(|c| c * outwards.signum())));
            assert!(!bvh.is_occluded(&ray), "{ray:?} hits the ball it leaves");
        }
    }
}

#[test]
fn rays_end_at_their_end_and_start_after_their_start() {
    let bvh = Bvh::from_corners(&[[[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]]);
    let ray = |z: f32, t_max: f32| Ray { origin: [0.2, 0.2, z], direction: [0.0, 0.0, 2.0], t_max };
    assert!(bvh.is_occluded(&ray(0.0, 0.5)), "t = 0.5 is within 0.5");
    assert!(!bvh.is_occluded(&ray(0.0, 0.499_999_97)), "t = 0.5 is beyond the number before it");
    assert!(!bvh.is_occluded(&ray(1.0, f32::INFINITY)), "the start itself is not hit");
    assert!(bvh.is_occluded(&ray(1.0_f32.next_down(), f32::INFINITY)), "just before the triangle");
    assert!(!bvh.is_occluded(&Ray::between([0.2, 0.2, 0.0], [0.2, 0.2, 1.0])), "the other end is excluded");
    assert!(bvh.is_occluded(&Ray::between([0.2, 0.2, 0.0], [0.2, 0.2, 1.001])), "what lies between is not");
}

#[test]
fn rays_that_are_none_hit_nothing() {
    let bvh = Bvh::new(&built_in::closed_white_box(2));
    for (origin, direction) in [
        ([0.0; 3], [0.0; 3]),
        ([0.0; 3], [f32::NAN, 0.0, 1.0]),
        ([f32::NAN, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ([0.0; 3], [f32::INFINITY, 0.0, 0.0]),
        ([f32::NEG_INFINITY, 0.0, 0.0], [1.0, 0.0, 0.0]),
    ] {
        let ray = Ray::new(origin, direction);
        assert_eq!((bvh.is_occluded(&ray), bvh.closest(&ray)), (false, None), "{ray:?}");
    }
    assert!(!Bvh::from_corners(&[]).is_occluded(&Ray::new([0.0; 3], [1.0, 0.0, 0.0])), "no triangles");
}

#[test]
fn of_equally_close_triangles_the_first_is_hit_and_others_can_be_asked_for() {
    let triangle = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let mut corners = vec![triangle; 20];
    corners.push(triangle.map(|p| [p[0], p[1], 2.0]));
    let bvh = Bvh::from_corners(&corners);
    let ray = Ray::new([0.1, 0.1, 0.0], [0.0, 0.0, 1.0]);
    assert_eq!(bvh.closest(&ray).map(|hit| (hit.t, hit.triangle)), Some((1.0, 0)), "the first of twenty");
    let behind = bvh.closest_where(&ray, |hit| hit.triangle == 20);
    assert_eq!(behind.map(|hit| hit.t), Some(2.0), "the one behind");
    assert!(!bvh.is_occluded_where(&ray, |_| false), "none is accepted");
}

#[test]
fn many_rays_from_one_point_hit_what_each_of_them_hits() {
    let scene = built_in::columns_hall(2);
    let bvh = Bvh::new(&scene);
    let directions: Vec<[f32; 3]> = lobe_testkit::fibonacci_sphere(301).into_iter().map(narrow).collect();
    for origin in [[0.0, 0.0, 0.5], [3.0, -6.0, 0.2], [0.0, 0.0, 20.0], [2.0, 2.5, 1.0]] {
        let mut together = vec![false; directions.len()];
        bvh.occluded_from_into(origin, &directions, &mut together);
        let one_by_one: Vec<bool> = directions.iter().map(|&d| bvh.is_occluded(&Ray::new(origin, d))).collect();
        assert_eq!(together, one_by_one, "from {origin:?}");
        for (simd, bvh) in by_each(&bvh) {
            let mut others = vec![!together[0]; directions.len()];
            bvh.occluded_from_into(origin, &directions, &mut others);
            assert_eq!(together, others, "{simd:?} from {origin:?}");
        }
    }
}

/// Compares rays traced together with each of them alone, by all vector instructions; returns the number occluded.
fn compare_together_and_alone(name: &str, bvh: &Bvh, origin: [f32; 3], directions: &[[f32; 3]]) -> usize {
    let alone: Vec<bool> = directions.iter().map(|&d| bvh.is_occluded(&Ray::new(origin, d))).collect();
    for (simd, bvh) in by_each(bvh) {
        for count in [directions.len(), 257, 65, 64, 1] {
            let directions = &directions[..count.min(directions.len())];
            let mut together = vec![false; directions.len()];
            bvh.occluded_from_into(origin, directions, &mut together);
            let different = (0..directions.len()).find(|&i| together[i] != alone[i]);
            let ray = different.map(|i| (alone[i], Ray::new(origin, directions[i])));
            assert_eq!(ray, None, "{name}: alone and not so together, {count} by {simd:?}");
        }
    }
    alone.iter().filter(|&&o| o).count()
}

#[test]
fn rays_together_hit_what_each_hits_alone_in_scenes_of_all_sizes() {
    let soup = soup(300, 12);
    let mut random = Random::new(13);
    for (scale, reach) in
        [(1.0, 1.0), (1e-12, 1.0), (1e-3, 1.0), (3e6, 1.0), (1e14, 1.0), (1.0, 1e9), (1.0, 1e17), (1.0, 1e25)]
    {
        let corners: Vec<Corners> = soup.iter().map(|triangle| triangle.map(|p| p.map(|c| c * scale))).collect();
        let bvh = Bvh::from_corners(&corners);
        let mut occluded = 0;
        for from in 0..6 {
            let origin = match from {
                0 => corners[7][1],
                1 => [0.0; 3],
                _ => narrow(random.direction()).map(|c| 2.0 * c * scale * reach),
            };
            let mut rays: Vec<[f32; 3]> = directions().into_iter().map(narrow).collect();
            rays.extend((0..400).map(|_| narrow(random.direction())));
            rays.extend(aims(&corners[from..from + 20]).iter().map(|aim| add(*aim, origin, -1.0)));
            for (i, ray) in rays.iter_mut().enumerate() {
                *ray = ray.map(|c| c * [1.0, 1e-12, 1e12, 1e24][i % 4] / scale.max(reach));
            }
            rays.splice(3..3, [[0.0; 3], [f32::NAN, 0.0, 1.0], [0.0, f32::INFINITY, 0.0], [-0.0, 0.0, -1.0]]);
            occluded += compare_together_and_alone(&format!("x {scale}, from {reach}"), &bvh, origin, &rays);
        }
        assert!(occluded > 20, "{occluded} rays hit at x {scale}, from {reach}: enough to tell");
    }
}

#[test]
fn no_rays_together_leave_a_closed_surface_through_its_edges_or_corners() {
    for (name, corners, center) in closed_surfaces() {
        let bvh = Bvh::from_corners(&corners);
        let rays: Vec<[f32; 3]> = aims(&corners).iter().map(|aim| add(*aim, center, -1.0)).collect();
        for (simd, bvh) in by_each(&bvh) {
            let mut occluded = vec![false; rays.len()];
            bvh.occluded_from_into(center, &rays, &mut occluded);
            let leak = occluded.iter().position(|o| !o).map(|i| rays[i]);
            assert_eq!(leak, None, "{name} leaks from {center:?} by {simd:?}");
        }
    }
}

#[test]
fn rays_together_from_a_vertex_or_above_it_hit_what_each_hits_alone() {
    // Grazing rays, some from within the triangles of the ground, whose planes have no side there.
    let ground = built_in::ball_over_ground(6);
    let (bvh, corners) = (Bvh::new(&ground), ground.corners().collect::<Vec<_>>());
    let mut random = Random::new(14);
    for triangle in &corners[..20] {
        let vertex = triangle[0];
        let rays: Vec<[f32; 3]> = (0..300)
            .map(|i| {
                let [x, y, z] = random.direction();
                narrow([x, y, z * [1.0, 1e-4, 0.0][i % 3]])
            })
            .collect();
        for origin in [vertex, bvh.origin_above(vertex, [0.0, 0.0, 1.0])] {
            compare_together_and_alone("ball over ground", &bvh, origin, &rays);
        }
    }
}

#[test]
fn triangles_without_area_stop_no_rays_together_either() {
    let mut corners = soup(50, 15);
    for (i, triangle) in corners.iter_mut().enumerate() {
        let [a, b, _] = *triangle;
        *triangle = if i % 2 == 0 { [a, b, a] } else { [a, a, a] };
    }
    let bvh = Bvh::from_corners(&corners);
    let mut random = Random::new(16);
    let mut rays: Vec<[f32; 3]> = (0..300).map(|_| narrow(random.direction())).collect();
    rays.extend(aims(&corners).iter().map(|aim| aim.map(|c| c + 0.0)));
    let occluded = compare_together_and_alone("no area", &bvh, [0.0; 3], &rays);
    assert_eq!(occluded, 0, "rays stopped by triangles without area");
}

#[test]
fn neither_a_tree_nor_its_rays_meet_denormal_numbers() {
    let corners = soup(5000, 41);
    // In one thread, whose flags are looked at.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let build = || drop(Bvh::from_corners(&corners));
    let in_tree = pool.install(|| lobe_testkit::meets_denormals(build));
    let rays: Vec<Ray> = rays(2000, 42).into_iter().map(|ray| Ray::new(ray.origin, ray.direction)).collect();
    let whole = Bvh::from_corners(&corners);
    for simd in Simd::ALL {
        let Some(bvh) = whole.clone().with_simd(simd) else {
            lobe_testkit::skipped(&format!("this machine has no {simd:?}"));
            continue;
        };
        let in_rays = lobe_testkit::meets_denormals(|| {
            let directions: Vec<_> = rays.iter().map(|ray| ray.direction).collect();
            let mut occluded = vec![false; rays.len()];
            bvh.occluded_from_into([0.1, 0.2, 0.3], &directions, &mut occluded);
            for ray in &rays {
                std::hint::black_box((bvh.is_occluded(ray), bvh.closest(ray)));
            }
        });
        assert_ne!(in_rays, Some(true), "{simd:?} rays meet a denormal number");
    }
    assert_ne!(in_tree, Some(true), "the build of a tree meets a denormal number");
    if in_tree.is_none() {
        lobe_testkit::skipped("this processor does not tell of denormal numbers");
    }
}

#[test]
fn closest_hits_of_many_rays_from_a_point_are_those_of_each_bit_by_bit() {
    let bits = |hit: Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.triangle, hit.u.to_bits(), hit.v.to_bits()));
    let mut random = Random::new(43);
    // Each triangle of the second half is at the place of another, so that hits are equally close.
    let mut corners = soup(1500, 44);
    corners.extend_from_within(..);
    let whole = Bvh::from_corners(&corners);
    let mut hit = 0;
    for simd in Simd::ALL {
        let Some(bvh) = whole.clone().with_simd(simd) else {
            lobe_testkit::skipped(&format!("this machine has no {simd:?}"));
            continue;
        };
        for (round, count) in [1, 2, 16, 63, 64, 65, 256, 257, 1000].into_iter().cycle().take(27).enumerate() {
            // Among the triangles, at a corner of one, and far away.
            let origin = match round % 3 {
                0 => narrow(random.direction().map(|c| c * random.unit())),
                1 => corners[17 * round][0],
                _ => narrow(random.direction().map(|c| 100.0 * c)),
            };
            let mut directions: Vec<[f32; 3]> = rays(count, round as u64).iter().map(|ray| ray.direction).collect();
            directions[0] = [0.0, 0.0, if round % 2 == 0 { 0.0 } else { 1.0 }];
            let mut hits = vec![None; count];
            bvh.closest_from_into(origin, &directions, &mut hits);
            let mut odd = hits.clone();
            bvh.closest_from_where_into(origin, &directions, &mut odd, |place, hit| {
                (place as u32 ^ hit.triangle) & 1 == 1
            });
            for (k, &direction) in directions.iter().enumerate() {
                let ray = Ray::new(origin, direction);
                assert_eq!(bits(hits[k]), bits(bvh.closest(&ray)), "{simd:?}, round {round}, ray {k}: {ray:?}");
                let expected = bvh.closest_where(&ray, |hit| (k as u32 ^ hit.triangle) & 1 == 1);
                assert_eq!(bits(odd[k]), bits(expected), "{simd:?}, round {round}, ray {k}, every other triangle");
                hit += usize::from(hits[k].is_some());
            }
        }
    }
    assert!(hit > 1000, "{hit} hits: enough to tell");
}
