//! Rays among surfaces that may have holes.

use crate::{Bvh, Hit, Ray, Scene};

/// Rays through a scene that stop where [`Scene::stops`] says so: not in the holes of alpha masks, and in glass at times.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceRays<'a> {
    scene: &'a Scene,
    bvh: &'a Bvh,
    /// Whether surfaces have to be asked at all.
    has_holes: bool,
}

impl<'a> SurfaceRays<'a> {
    /// Rays through `scene`, whose tree is `bvh`.
    #[must_use]
    pub fn new(scene: &'a Scene, bvh: &'a Bvh) -> Self {
        Self { scene, bvh, has_holes: scene.has_holes() }
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

    /// Whether a ray stops anywhere.
    #[must_use]
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        if self.has_holes {
            self.bvh.is_occluded_where(ray, |hit| self.scene.stops(ray, &hit))
        } else {
            self.bvh.is_occluded(ray)
        }
    }

    /// Whether each of many rays from one point stops anywhere: see [`Bvh::occluded_from_into`].
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn occluded_from_into(&self, origin: [f32; 3], directions: &[[f32; 3]], occluded: &mut [bool]) {
        if self.has_holes {
            assert_eq!(directions.len(), occluded.len(), "directions and answers");
            for (direction, occluded) in directions.iter().zip(occluded) {
                *occluded = self.is_occluded(&Ray::new(origin, *direction));
            }
        } else {
            self.bvh.occluded_from_into(origin, directions, occluded);
        }
    }
}
