//! Moments: a moving scene at one time.

use lobe_scene::{Bvh, Entity, PosedScene, Scene};
use lobe_sh::{Rgb, Rotation};
use lobe_shadow::{Placement, SphereSet, WorldSphere};

use crate::scene::moving_lamp::PlacedLamp;
use crate::scene::moving_part::MovingPart;
use lobe_render::{Emitter, RenderError};

/// A [`MovingScene`](crate::MovingScene) at one time: its triangles in the world, and where its parts are.
#[derive(Clone, Debug)]
pub struct Moment<'a> {
    parts: &'a [MovingPart],
    scene: Scene,
    bvh: Bvh,
    pub(crate) placed: Vec<PlacedPart>,
    pub(crate) lamps: Vec<PlacedLamp<'a>>,
}

/// A part where it is.
#[derive(Clone, Debug)]
pub(crate) struct PlacedPart {
    /// The place of its own frame, in which its field is; the world's of one that is deformed.
    pub(crate) placement: Placement,
    /// Its spheres in the world.
    pub(crate) spheres: Vec<WorldSphere>,
    /// Its vertices: in its own frame, or of one that is deformed in the world.
    pub(crate) surface: Surface,
}

/// Vertices of a part as receivers of light.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    /// The frame of the positions.
    pub(crate) frame: Placement,
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) albedos: Vec<[f32; 3]>,
}

impl<'a> Moment<'a> {
    /// The parts, their triangles in the world with a tree over them, and where each part is.
    pub(crate) fn new(
        parts: &'a [MovingPart],
        (scene, bvh): (Scene, Bvh),
        placed: Vec<PlacedPart>,
        lamps: Vec<PlacedLamp<'a>>,
    ) -> Self {
        Self { parts, scene, bvh, placed, lamps }
    }

    /// The parts of the moving scene. Their vertices, one part after the other, are those of [`Moment::scene`].
    #[must_use]
    pub fn parts(&self) -> &'a [MovingPart] {
        self.parts
    }

    /// All triangles in the world, to be traced for a reference.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The tree over them.
    #[must_use]
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// The place of a part's own frame in the world. [`Placement::IDENTITY`] of one that stands still, and of one that
    /// is deformed, whose vertices move one by one.
    ///
    /// # Panics
    /// If there is no such part.
    #[must_use]
    pub fn placement_of(&self, part: usize) -> Placement {
        self.placed[part].placement
    }

    /// The spheres that stand for a part, in the world; none of a part without.
    ///
    /// # Panics
    /// If there is no such part.
    #[must_use]
    pub fn spheres(&self, part: usize) -> &[WorldSphere] {
        &self.placed[part].spheres
    }

    /// The lamps, to be traced for a reference by
    /// [`render_truth_with_emitters`](lobe_render::render_truth_with_emitters).
    #[must_use]
    pub fn emitters(&self) -> Vec<Emitter> {
        let emitter = |lamp: &PlacedLamp<'_>| Some(Emitter::new(lamp.surface.as_ref()?, &lamp.placement));
        self.lamps.iter().filter_map(emitter).collect()
    }

    /// The tree, to be [handed on](crate::MovingScene::at_with) to another moment.
    #[must_use]
    pub fn into_bvh(self) -> Bvh {
        self.bvh
    }
}

impl PlacedPart {
    /// A part at a place.
    pub(crate) fn rigid(part: &MovingPart, placement: Placement) -> Self {
        let sphere = |set: &SphereSet, k: usize| WorldSphere {
            center: placement.to_world(set.center(k)),
            radius: f64::from(set.radii()[k]) * placement.scale(),
        };
        let spheres = match &part.spheres {
            Some(set) => (0..set.len()).map(|k| sphere(set, k)).collect(),
            None => Vec::new(),
        };
        // Positions count from the origin of the scene.
        let origin = placement.to_world(part.scene.origin());
        let frame = Placement::new(origin, *placement.rotation(), placement.scale());
        Self { placement, spheres, surface: Surface::new(&part.scene, &part.scene, frame) }
    }

    /// The same part, which a place carries along with all around it.
    pub(crate) fn carried(mut self, by: &Placement) -> Self {
        let carry = |of: &Placement| {
            Placement::new(by.to_world(of.translation()), of.rotation().then(*by.rotation()), by.scale() * of.scale())
        };
        self.placement = carry(&self.placement);
        self.surface.frame = carry(&self.surface.frame);
        for sphere in &mut self.spheres {
            *sphere = WorldSphere { center: by.to_world(sphere.center), radius: by.scale() * sphere.radius };
        }
        self
    }

    /// A part that an animation deforms; its spheres follow its joints.
    pub(crate) fn deformed(
        part: &MovingPart,
        posed: &PosedScene,
        entity: &Entity,
        scene: &Scene,
    ) -> Result<Self, RenderError> {
        let spheres = match &part.spheres {
            Some(set) => set.posed_with(posed, entity)?,
            None => Vec::new(),
        };
        let frame = Placement::new(scene.origin(), Rotation::IDENTITY, 1.0);
        Ok(Self { placement: Placement::IDENTITY, spheres, surface: Surface::new(scene, &part.scene, frame) })
    }
}

impl Surface {
    /// The vertices of a scene, with the albedo of another that has the same ones.
    fn new(scene: &Scene, colored: &Scene, frame: Placement) -> Self {
        let mut surface = Self { frame, positions: Vec::new(), normals: Vec::new(), albedos: Vec::new() };
        for (index, mesh) in scene.meshes().iter().enumerate() {
            surface.positions.extend_from_slice(mesh.positions());
            surface.normals.extend_from_slice(mesh.normals());
            surface.albedos.extend((0..mesh.positions().len()).map(|vertex| {
                let [r, g, b, _] = colored.vertex_base_color(index, vertex);
                [r, g, b]
            }));
        }
        surface
    }

    /// The mean albedo of the vertices.
    pub(crate) fn mean_albedo(&self) -> Rgb<f32> {
        let mut sum = [0.0_f64; 3];
        self.albedos.iter().for_each(|albedo| (0..3).for_each(|c| sum[c] += f64::from(albedo[c])));
        let [r, g, b] = sum.map(|sum| (sum / self.albedos.len().max(1) as f64) as f32);
        Rgb::new(r, g, b)
    }
}
