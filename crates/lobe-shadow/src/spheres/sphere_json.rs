//! Sphere sets as JSON, to be read by people and scripts.

use serde::Serialize;

use crate::spheres::fit_spheres::SphereFitReport;
use crate::spheres::sphere_set::SphereSet;

/// What `lobe spheres --json` prints; see [`SphereSetJson::new`].
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SphereSetJson {
    /// The spheres, in the frame of the mesh.
    pub spheres: Vec<SphereJson>,
    /// [`SphereFitReport::outside_volume`].
    pub outside_volume: f64,
    /// [`SphereSet::union_volume`].
    pub union_volume: f64,
    /// [`SphereFitReport::solid_volume`].
    pub solid_volume: f64,
    /// [`SphereFitReport::history`].
    pub history: Vec<f64>,
    /// [`SphereFitReport::certainty`].
    pub certainty: f64,
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SphereJson {
    /// Its center, in the mesh's own frame wherever the mesh is.
    pub center: [f64; 3],
    /// Its radius.
    pub radius: f32,
}

impl SphereSetJson {
    /// A set and the report of its fit.
    ///
    /// ```
    /// use lobe_io::Job;
    /// use lobe_scene::{Mesh, MeshParts, Scene};
    /// use lobe_shadow::{SphereFitOptions, SphereSetJson, fit_spheres};
    ///
    /// let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let triangles = vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];
    /// let mesh = Mesh::new(MeshParts { positions, triangles, ..MeshParts::default() })?;
    /// let scene = Scene::new(vec![mesh], Vec::new(), Vec::new())?;
    /// let options = SphereFitOptions::default().count(2).samples(200).rounds(2);
    /// let (set, report) = fit_spheres(&scene, &options, Job::default())?;
    /// assert_eq!(SphereSetJson::new(&set, &report).spheres.len(), 2);
    /// # Ok::<(), lobe_shadow::ShadowError>(())
    /// ```
    #[must_use]
    pub fn new(set: &SphereSet, report: &SphereFitReport) -> Self {
        let sphere = |(k, &radius): (usize, &f32)| SphereJson { center: set.center(k), radius };
        let SphereFitReport { outside_volume, solid_volume, history, certainty, .. } = report.clone();
        let spheres = set.radii().iter().enumerate().map(sphere).collect();
        let union_volume = set.union_volume();
        Self { spheres, outside_volume, union_volume, solid_volume, history, certainty }
    }
}
