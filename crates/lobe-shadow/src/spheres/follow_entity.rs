//! Sphere sets that follow an entity of an animated scene.

use glam::DVec3;
use lobe_io::{Job, Progress};
use lobe_scene::{AnimatedScene, Entity, PosedScene};

use crate::error::ShadowError;
use crate::spheres::follow_morphs::morphs_of;
use crate::spheres::pose::{SkinnedMesh, WorldSphere};
use crate::spheres::skeleton::Skeleton;
use crate::spheres::skeleton::expect_joint;
use crate::spheres::skin::Skin;
use crate::spheres::sphere_set::SphereSet;

/// Spheres times triangles between two looks at whether to stop: a fraction of a second.
const AT_ONCE: usize = 1 << 22;

/// A shape where it was bound, with the joints of its vertices.
#[derive(Default)]
struct BoundShape {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
}

impl SphereSet {
    /// The set bound to an entity, which it was [fitted](crate::fit_spheres) to in the entity's own frame: in the shape
    /// that was bound, with the morph targets where its surface is [largest](AnimatedScene::widest_weights). It follows
    /// morph targets as the surface next to each sphere does. Every sphere gets the four strongest joints of the place
    /// of the surface nearest to its center, with their weights. Spheres of an entity without a skin move with its
    /// node.
    ///
    /// ```
    /// use lobe_io::Job;
    /// use lobe_scene::built_in;
    /// use lobe_shadow::SphereSet;
    ///
    /// let scene = built_in::walking_figure(8);
    /// let figure = &scene.entities()[1];
    /// let head = SphereSet::new(vec![[0.0, 0.0, 1.62]], vec![0.1])?;
    /// let head = head.bind_to(&scene, figure, &mut Job::default())?;
    /// assert_eq!(head.skin().map(|skin| skin.joints()[0][0]), Some(3), "that of the head");
    ///
    /// let posed = head.posed_with(&scene.pose(0, 0.3)?, figure)?;
    /// assert!((posed[0].center[2] - 1.6).abs() < 0.1, "{posed:?}");
    /// # Ok::<(), lobe_shadow::ShadowError>(())
    /// ```
    ///
    /// # Errors
    /// [`ShadowError::Scene`] with those of [`AnimatedScene::own_scene`], [`ShadowError::Options`] with those of
    /// [`SphereSet::bind`] and for more joints than 65535, [`ShadowError::Cancelled`] if the watch of the job said to stop.
    ///
    /// # Panics
    /// If the entity is of another scene, which has more meshes.
    pub fn bind_to(self, scene: &AnimatedScene, entity: &Entity, job: &mut Job<'_>) -> Result<Self, ShadowError> {
        let bound = match entity.skin() {
            Some(_) => {
                let shape = BoundShape::new(scene, entity, self.origin())?;
                let skin = shape.bound(&self, job)?;
                self.with_skin(skin)?
            }
            None => self,
        };
        let morphs = morphs_of(scene, entity, &bound, job)?;
        bound.with_morphs(morphs)?.with_skeleton(Skeleton::of(scene, entity))
    }

    /// The set, bound to an entity in another program or by another version of its file, with the joints numbered as those of
    /// the entity here: by their names if all have one and no two the same, else in the same order. A set without a
    /// [`Skeleton`] is taken for one of this entity, with its joints in this order.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if one of the set and the entity has joints and the other none, or the joints are
    /// others: another number, one that the entity lacks, or names in another order.
    ///
    /// # Panics
    /// If the entity is of another scene, which has more skins.
    pub fn for_entity(self, scene: &AnimatedScene, entity: &Entity) -> Result<Self, ShadowError> {
        let skeleton = Skeleton::of(scene, entity);
        self.expect_targets(scene.morph_weights(entity).len(), &skeleton)?;
        let refuse = |message: String| Err(ShadowError::Options(message));
        let of = skeleton.label();
        let Some(skin) = self.skin() else {
            if skeleton.joints().is_empty() || self.is_empty() {
                return self.with_skeleton(skeleton);
            }
            return refuse(format!(
                "expected spheres bound to the joints of {of}, found spheres without joints; `lobe spheres --entity` binds them"
            ));
        };
        if skeleton.joints().is_empty() {
            return refuse(format!(
                "expected spheres without joints of {of}, which has no skin, found some with joints"
            ));
        }
        let mut joints = skin.joints().to_vec();
        if let Some(own) = self.skeleton() {
            let numbers = own.numbers_in(&skeleton)?;
            // Joints of no weight may have any number.
            joints.iter_mut().flatten().for_each(|j| *j = numbers.get(usize::from(*j)).copied().unwrap_or_default());
        }
        let skin = skin.clone().with_joints(joints);
        self.with_skin(skin)?.with_skeleton(skeleton)
    }

    /// Refuses a set that follows another number of morph targets than an entity has.
    fn expect_targets(&self, expected: usize, skeleton: &Skeleton) -> Result<(), ShadowError> {
        match self.morphs().map(|morphs| morphs.weights().len()).filter(|found| *found != expected) {
            None => Ok(()),
            Some(found) => Err(ShadowError::Options(format!(
                "expected spheres that follow the {expected} morph targets of {}, found some that follow {found}; fit them \
                 to this entity",
                skeleton.label()
            ))),
        }
    }

    /// The spheres in the world, in a pose of the scene whose entity the set is [bound to](Self::bind_to).
    ///
    /// # Errors
    /// As [`SphereSet::posed`].
    ///
    /// # Panics
    /// If the entity is of another scene, which has more nodes or skins.
    pub fn posed_with(&self, posed: &PosedScene, entity: &Entity) -> Result<Vec<WorldSphere>, ShadowError> {
        // The node moves what has no joints: of a part with a skin some meshes may not.
        let joints = entity.skin().map(|skin| posed.joint_maps(skin)).unwrap_or_default();
        let origin = posed.scene().origin();
        let rows = joints.into_iter().chain([posed.place(entity)]).map(|place| {
            let mut rows = place.rows();
            (0..3).for_each(|k| rows[k][3] += origin[k]);
            rows
        });
        self.posed_at(posed.morph_weights(entity), &rows.collect::<Vec<_>>())
    }
}

impl BoundShape {
    /// The shape of an entity with a skin, its positions from the origin of spheres.
    fn new(scene: &AnimatedScene, entity: &Entity, origin: [f64; 3]) -> Result<Self, ShadowError> {
        let (mut shape, own) = (Self::default(), scene.morphed_scene(entity, &scene.widest_weights(entity)?)?);
        let offset = DVec3::from_array(own.origin()) - DVec3::from_array(origin);
        let from_there = |p: &[f32; 3]| (DVec3::from_array(p.map(f64::from)) + offset).as_vec3().to_array();
        for (mesh, own) in entity.meshes().zip(own.meshes()) {
            let first = shape.positions.len() as u32;
            shape.positions.extend(own.positions().iter().map(from_there));
            shape.triangles.extend(own.triangles().iter().map(|t| t.map(|i| first + i)));
            for vertex in 0..own.positions().len() {
                let (four, share) = strongest(scene, mesh, vertex)?;
                shape.joints.push(four);
                shape.weights.push(share);
            }
        }
        Ok(shape)
    }

    /// The joints of all spheres, found a few at a time.
    fn bound(&self, spheres: &SphereSet, job: &mut Job<'_>) -> Result<Skin, ShadowError> {
        let Self { positions, triangles, joints, weights } = self;
        let mesh = SkinnedMesh { positions, triangles, joints, weights };
        let (mut joints, mut weights) = (Vec::with_capacity(spheres.len()), Vec::with_capacity(spheres.len()));
        let piece = (AT_ONCE / triangles.len().max(1)).max(1);
        for (centers, radii) in spheres.centers().chunks(piece).zip(spheres.radii().chunks(piece)) {
            let progress = Progress { done: joints.len(), total: spheres.len(), ..Progress::default() };
            if job.report(&progress).is_break() {
                return Err(ShadowError::Cancelled);
            }
            let few = SphereSet::new(centers.to_vec(), radii.to_vec())?.bind(&mesh)?;
            if let Some(skin) = few.skin() {
                joints.extend_from_slice(skin.joints());
                weights.extend_from_slice(skin.weights());
            }
        }
        Skin::new(joints, weights)
    }
}

/// The four joints that carry a vertex most. Vertices follow all of theirs, spheres these.
fn strongest(scene: &AnimatedScene, mesh: usize, vertex: usize) -> Result<([u16; 4], [f32; 4]), ShadowError> {
    let mut all: Vec<(usize, f64)> = scene.influences(mesh, vertex).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let (mut joints, mut weights) = ([0; 4], [0.0; 4]);
    for (k, (joint, weight)) in all.into_iter().take(4).enumerate() {
        (joints[k], weights[k]) = (expect_joint(joint)?, weight as f32);
    }
    Ok((joints, weights))
}
