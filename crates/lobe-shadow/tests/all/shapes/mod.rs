//! Shapes by formula, about as large as a ball of radius 1, and places around them.

#![allow(dead_code, reason = "tests and examples, each of which uses a part")]
#![allow(clippy::unwrap_used, reason = "shapes that are right by construction")]

use std::f64::consts::{PI, TAU};

use lobe_scene::{Bvh, Mesh, MeshParts, Scene};
use lobe_sh::rotation::tangent_frame;
use lobe_sh::sphere::even_directions;
use lobe_sh::{Dir, eval_basis};
use lobe_shadow::Placement;
use lobe_testkit::Random;

/// A closed surface over (u, v) in [0, 1)², the point at v = 0 and v = 1 a pole where `has_poles`, else as periodic as u.
fn surface(around: u32, along: u32, has_poles: bool, at: impl Fn(f64, f64) -> [f64; 3]) -> Scene {
    let rings = if has_poles { along + 1 } else { along };
    let mut positions = Vec::new();
    for j in 0..rings {
        for i in 0..around {
            let p = at(f64::from(i) / f64::from(around), f64::from(j) / f64::from(along));
            positions.push(p.map(|c| c as f32));
        }
    }
    let index = |i: u32, j: u32| (if has_poles { j } else { j % along }) * around + i % around;
    let mut triangles = Vec::new();
    for j in 0..along {
        for i in 0..around {
            let [a, b, c, d] = [index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    scene(positions, triangles)
}

pub(crate) fn scene(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Scene {
    let mesh = Mesh::new(MeshParts { positions, triangles, ..MeshParts::default() }).unwrap();
    Scene::new(vec![mesh], vec![], vec![]).unwrap()
}

/// A surface around the origin, at `radius` in every direction.
fn star(around: u32, radius: impl Fn([f64; 3]) -> f64) -> Scene {
    surface(around, around / 2, true, |u, v| {
        let ((sin_t, cos_t), (sin_p, cos_p)) = ((PI * v).sin_cos(), (TAU * u).sin_cos());
        let s = [sin_t * cos_p, sin_t * sin_p, cos_t];
        s.map(|c| c * radius(s))
    })
}

pub(crate) fn ball() -> Scene {
    star(64, |_| 1.0)
}

/// Two long ears on a body with a dent.
pub(crate) fn rabbit() -> Scene {
    star(96, |s| {
        let lobe = |axis: [f64; 3], sharpness: f64| {
            let length = axis.iter().map(|c| c * c).sum::<f64>().sqrt();
            let cosine = (0..3).map(|k| s[k] * axis[k]).sum::<f64>() / length;
            (sharpness * (cosine - 1.0)).exp()
        };
        0.55 + 0.5 * lobe([0.25, 0.1, 1.0], 60.0)
            + 0.5 * lobe([-0.3, 0.15, 1.0], 60.0)
            + 0.15 * lobe([0.9, 0.0, 0.2], 6.0)
            - 0.2 * lobe([0.0, -1.0, 0.1], 10.0)
    })
}

pub(crate) fn torus() -> Scene {
    surface(64, 32, false, |u, v| {
        let ((sin_u, cos_u), (sin_v, cos_v)) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
        let r = 0.7 + 0.3 * cos_v;
        [r * cos_u, r * sin_u, -0.3 * sin_v]
    })
}

/// A plate of 1.6 × 1.2 × 0.1.
pub(crate) fn plate() -> Scene {
    let half = [0.8, 0.6, 0.05];
    let corner = |k: u32| std::array::from_fn(|c| if k >> c & 1 == 0 { -half[c] } else { half[c] });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    scene((0..8).map(corner).collect(), triangles)
}

/// A star of five prongs: a ring of ten points, alternately far and near, between two tips on the z axis.
pub(crate) fn prongs() -> Scene {
    let mut positions = vec![[0.0, 0.0, 0.3], [0.0, 0.0, -0.3]];
    let mut triangles = Vec::new();
    for i in 0..10 {
        let (sin, cos) = (TAU * f64::from(i) / 10.0).sin_cos();
        let r = if i % 2 == 0 { 1.0 } else { 0.4 };
        positions.push([r * cos, r * sin, 0.0].map(|x| x as f32));
        let (a, b) = (2 + i as u32, 2 + (i as u32 + 1) % 10);
        triangles.extend([[0, a, b], [1, b, a]]);
    }
    scene(positions, triangles)
}

pub(crate) fn named() -> [(&'static str, Scene); 4] {
    [("ball", ball()), ("rabbit", rabbit()), ("torus", torus()), ("plate", plate())]
}

/// The scenes where they are placed, as one.
pub(crate) fn together(parts: &[(&Scene, Placement)]) -> Scene {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (scene, placement) in parts {
        for corners in scene.corners() {
            let first = positions.len() as u32;
            positions.extend(corners.map(|p| placement.to_world(p.map(f64::from)).map(|c| c as f32)));
            triangles.push([first, first + 1, first + 2]);
        }
    }
    scene(positions, triangles)
}

/// Rays that ask for the truth: in even directions over the cap that holds everything within `radius` of the origin.
struct Truth {
    bvh: Bvh,
    /// Positions of a scene far from the origin count from one of its own.
    origin: [f64; 3],
    radius: f64,
}

impl Truth {
    fn new(scene: &Scene) -> Self {
        let origin = scene.origin();
        let square = |p: [f32; 3]| (0..3).map(|k| (f64::from(p[k]) + origin[k]).powi(2)).sum::<f64>();
        let radius = 1.001 * scene.corners().flatten().map(square).fold(0.0, f64::max).sqrt();
        Self { bvh: Bvh::new(scene), origin, radius }
    }

    fn visibility(&self, point: [f32; 3], order: usize, rays: usize) -> Vec<f32> {
        let r = point.iter().map(|c| f64::from(*c).powi(2)).sum::<f64>().sqrt();
        let (axis, cosine) = match Dir::new(point.map(|c| -f64::from(c))) {
            Some(axis) if r > self.radius => (axis, (1.0 - (self.radius / r).powi(2)).sqrt()),
            _ => (Dir::Z, -1.0),
        };
        let frame = tangent_frame(axis);
        let mut sum = vec![0.0; order * order];
        let directions: Vec<Dir> = even_directions(rays)
            .map(|s| {
                let z = 1.0 - 0.5 * (1.0 - cosine) * (1.0 - s.z());
                let across = ((1.0 - z * z) / (1.0 - s.z() * s.z())).sqrt();
                frame.rotate_dir(Dir::from_unit([s.x() * across, s.y() * across, z]))
            })
            .collect();
        let rays_of: Vec<[f32; 3]> = directions.iter().map(|s| s.to_array().map(|c| c as f32)).collect();
        let mut occluded = vec![false; rays];
        let start = std::array::from_fn(|k| (f64::from(point[k]) - self.origin[k]) as f32);
        self.bvh.occluded_from_into(start, &rays_of, &mut occluded);
        for (s, _) in directions.iter().zip(&occluded).filter(|(_, occluded)| **occluded) {
            sum.iter_mut().zip(eval_basis(*s, order)).for_each(|(sum, y)| *sum += y);
        }
        let weight = TAU * (1.0 - cosine) / rays as f64;
        let one = |i: usize| if i == 0 { (4.0 * PI).sqrt() } else { 0.0 };
        sum.iter().enumerate().map(|(i, sum)| (one(i) - weight * sum) as f32).collect()
    }
}

/// The visibility at points, by rays.
pub(crate) fn traced(scene: &Scene, points: &[[f32; 3]], order: usize, rays: usize) -> Vec<f32> {
    let truth = Truth::new(scene);
    points.iter().flat_map(|p| truth.visibility(*p, order, rays)).collect()
}

/// Points outside the solid whose distances from the origin are evenly distributed in their logarithm between two. Fewer, or
/// none, where nearly all is solid.
pub(crate) fn points_between(scene: &Scene, [near, far]: [f64; 2], count: usize, seed: u64) -> Vec<[f32; 3]> {
    let truth = Truth::new(scene);
    let mut random = Random::new(seed);
    let mut found = Vec::new();
    for _ in 0..20 * count {
        if found.len() == count {
            break;
        }
        let r = near * (far / near).powf(random.unit());
        let p = random.direction().map(|c| (r * c) as f32);
        // Of the sky nothing is left inside.
        if truth.visibility(p, 1, 64)[0] > 0.05 {
            found.push(p);
        }
    }
    found
}

/// The root of the sum of squared differences over that of squares of the truth's occlusion, `1 - V`.
pub(crate) fn relative_error(found: &[f32], truth: &[f32], order: usize) -> f64 {
    let width = order * order;
    let (mut errors, mut squares) = (0.0, 0.0);
    for (found, truth) in found.chunks_exact(width).zip(truth.chunks_exact(width)) {
        for (i, (a, b)) in found.iter().zip(truth).enumerate() {
            let one = if i == 0 { (4.0 * PI).sqrt() } else { 0.0 };
            errors += (f64::from(*a) - f64::from(*b)).powi(2);
            squares += (one - f64::from(*b)).powi(2);
        }
    }
    (errors / squares).sqrt()
}
