//! Rays among surfaces that may have holes.

use crate::bvh::bvh::Bvh;
use crate::scene::ray::{Hit, Ray};
use crate::scene::scene::Scene;

/// A hit that a ray has passed: where, of which triangle, and its tint.
type Passed = (f32, u32, [f32; 3]);

/// The product of all tints, in an order that does not depend on that in which the tree was searched.
fn product(mut passed: Vec<Passed>) -> [f32; 3] {
    passed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // The tree may ask about a triangle twice.
    passed.dedup_by_key(|&mut (t, triangle, _)| (t.to_bits(), triangle));
    passed.iter().fold([1.0; 3], |all: [f32; 3], (_, _, tint)| [0, 1, 2].map(|c| all[c] * tint[c]))
}

/// Rays through a scene that stop where [`Scene::stops`] says so: not in the holes of alpha masks, and in glass at times.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceRays<'a> {
    scene: &'a Scene,
    bvh: &'a Bvh,
    /// Whether surfaces have to be asked at all.
    has_holes: bool,
    /// Whether light takes on a hue in glass.
    is_tinted: bool,
}

impl<'a> SurfaceRays<'a> {
    /// Rays through `scene`, whose tree is `bvh`.
    #[must_use]
    pub fn new(scene: &'a Scene, bvh: &'a Bvh) -> Self {
        Self { scene, bvh, has_holes: scene.has_holes(), is_tinted: scene.is_tinted() }
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// The tree over its triangles.
    #[must_use]
    pub fn bvh(&self) -> &'a Bvh {
        self.bvh
    }

    /// The first hit at which a ray stops.
    #[must_use]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        if self.has_holes {
            self.bvh.closest_where(ray, |hit| self.scene.stops(ray, hit))
        } else {
            self.bvh.closest(ray)
        }
    }

    /// The first hit at which a ray stops, and what its light is multiplied by on the way there or, without one, out of
    /// the scene: the [tints](Scene::tint) of the glass that it passes.
    #[must_use]
    pub fn closest_through(&self, ray: &Ray) -> (Option<Hit>, [f32; 3]) {
        if !self.is_tinted {
            return (self.closest(ray), [1.0; 3]);
        }
        let mut passed = Vec::new();
        let hit = self.bvh.closest_where(ray, |hit| self.stops_or_passes(ray, hit, &mut passed));
        // What lies behind the surface was asked, too.
        passed.retain(|&(t, _, _)| hit.is_none_or(|hit| t < hit.t));
        (hit, product(passed))
    }

    /// What the light of a ray that stops nowhere is multiplied by, as of [`Self::closest_through`]; none if it stops.
    #[must_use]
    pub fn passes_through(&self, ray: &Ray) -> Option<[f32; 3]> {
        if !self.is_tinted {
            return (!self.is_occluded(ray)).then_some([1.0; 3]);
        }
        let mut passed = Vec::new();
        let stops = self.bvh.is_occluded_where(ray, |hit| self.stops_or_passes(ray, hit, &mut passed));
        (!stops).then(|| product(passed))
    }

    /// [`Self::closest_through`] of each of many rays, in less time: together where all are half lines from one point.
    #[must_use]
    pub fn closest_through_each(&self, rays: &[Ray]) -> Vec<(Option<Hit>, [f32; 3])> {
        if self.is_tinted {
            return rays.iter().map(|ray| self.closest_through(ray)).collect();
        }
        let mut hits = vec![None; rays.len()];
        match rays.first() {
            Some(first) if rays.iter().all(|ray| ray.origin == first.origin && ray.t_max == f32::INFINITY) => {
                let directions: Vec<_> = rays.iter().map(|ray| ray.direction).collect();
                self.closest_from_into(first.origin, &directions, &mut hits);
            }
            _ if self.has_holes => {
                let stops = |place: usize, hit: &Hit| self.scene.stops(&rays[place], hit);
                self.bvh.closest_where_into(rays, &mut hits, stops);
            }
            _ => self.bvh.closest_into(rays, &mut hits),
        }
        hits.into_iter().map(|hit| (hit, [1.0; 3])).collect()
    }

    /// [`Self::passes_through`] of each of many rays, in less time.
    #[must_use]
    pub fn passes_through_each(&self, rays: &[Ray]) -> Vec<Option<[f32; 3]>> {
        if self.is_tinted {
            return rays.iter().map(|ray| self.passes_through(ray)).collect();
        }
        let mut occluded = vec![false; rays.len()];
        self.are_occluded_into(rays, &mut occluded);
        occluded.into_iter().map(|occluded| (!occluded).then_some([1.0; 3])).collect()
    }

    /// Whether each of many rays stops anywhere.
    fn are_occluded_into(&self, rays: &[Ray], occluded: &mut [bool]) {
        if self.has_holes {
            self.bvh.occluded_where_into(rays, occluded, |place, hit| self.scene.stops(&rays[place], hit));
        } else {
            self.bvh.occluded_into(rays, occluded);
        }
    }

    /// Whether light may take on a hue on its way.
    #[must_use]
    pub fn is_tinted(&self) -> bool {
        self.is_tinted
    }

    /// Whether a ray stops at a hit; if not, the hit is added with its tint, if that is one.
    fn stops_or_passes(&self, ray: &Ray, hit: &Hit, passed: &mut Vec<Passed>) -> bool {
        let stops = self.scene.stops(ray, hit);
        if !stops {
            let tint = self.scene.tint(hit);
            passed.extend((tint != [1.0; 3]).then_some((hit.t, hit.triangle, tint)));
        }
        stops
    }

    /// Whether a ray stops anywhere.
    #[must_use]
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        if self.has_holes {
            self.bvh.is_occluded_where(ray, |hit| self.scene.stops(ray, hit))
        } else {
            self.bvh.is_occluded(ray)
        }
    }

    /// The first hits at which many rays from one point stop: those of [`Self::closest`], in less time.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn closest_from_into(&self, origin: [f32; 3], directions: &[[f32; 3]], hits: &mut [Option<Hit>]) {
        if self.has_holes {
            let stops = |place: usize, hit: &Hit| self.scene.stops(&Ray::new(origin, directions[place]), hit);
            self.bvh.closest_from_where_into(origin, directions, hits, stops);
        } else {
            self.bvh.closest_from_into(origin, directions, hits);
        }
    }

    /// Whether each of many rays from one point stops anywhere: see [`Bvh::occluded_from_into`].
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn occluded_from_into(&self, origin: [f32; 3], directions: &[[f32; 3]], occluded: &mut [bool]) {
        if self.has_holes {
            let rays: Vec<_> = directions.iter().map(|&direction| Ray::new(origin, direction)).collect();
            self.are_occluded_into(&rays, occluded);
        } else {
            self.bvh.occluded_from_into(origin, directions, occluded);
        }
    }
}
