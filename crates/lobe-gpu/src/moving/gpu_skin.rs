//! Skins and morph targets on the device.

use bytemuck::{Pod, Zeroable};
use lobe_scene::{AnimatedScene, Entity, Place, PosedScene, SceneError};

use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::pieces::{Piece, cut};
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::{Context, GpuError};

/// A position and a unit normal as shaders have them, each with a fourth number.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GpuVertex {
    /// The position, then 1.
    pub position: [f32; 4],
    /// The normal, then 0.
    pub normal: [f32; 4],
}

/// What a morph target of weight one adds to each vertex.
#[derive(Clone, Copy, Debug)]
pub struct MorphTarget<'a> {
    /// To positions.
    pub positions: &'a [[f32; 3]],
    /// To normals; nothing if empty.
    pub normals: &'a [[f32; 3]],
}

/// Vertices on a device that joints carry and morph targets deform, as [`AnimatedScene::pose`] has them.
///
/// ```text
///   p' = M (p_0 + Σ w_k Δp_k)        n' ∝ M⁻ᵀ (n_0 + Σ w_k Δn_k)        M = Σ w_j M_j
/// ```
///
/// One pass, `skin`, for as many pieces of the vertices as the bindings of the device demand, which writes the buffer `posed` of
/// [`GpuVertex`].
#[derive(Debug)]
pub struct GpuSkin {
    renderer: Renderer,
    vertices: usize,
    joints: usize,
    targets: usize,
}

impl GpuSkin {
    /// Uploads vertices at rest, the joints of each with weights that sum to one, and morph targets.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there are not as many normals, influences or numbers of a target as vertices, no joints, or one
    /// of a vertex is beyond them; [`GpuError::Unsupported`] if anything is too large for the device; [`GpuError::Device`] if it
    /// fails.
    pub fn new(
        context: &Context,
        [positions, normals]: [&[[f32; 3]]; 2],
        influences: &[Vec<(u32, f32)>],
        joints: usize,
        targets: &[MorphTarget<'_>],
    ) -> Result<Self, GpuError> {
        let count = positions.len();
        check(count, normals, influences, joints, targets)?;
        let mut renderer = Renderer::new(context);
        renderer.upload("joints", &vec![[0.0_f32; 12]; joints])?;
        renderer.upload("weights", &vec![0.0_f32; targets.len()])?;
        let vertex = size_of::<GpuVertex>() as u64;
        renderer.allocate("posed", vertex * count as u64)?;
        let slots = [[Slot::Uniform].as_slice(), &[Slot::Read; 5], &[Slot::Write]].concat();
        let kernel = Kernel::new(context, "skin", &Shader::new(&["skin"]), &slots)?;
        let most = influences.iter().map(Vec::len).max().unwrap_or(0);
        // The joints of a vertex: a word where they begin, two for each, and one for where the last end.
        let own = (vertex * targets.len().max(1) as u64).max(4 * (2 + 2 * most) as u64);
        for piece in cut(context, "skin", count, own, &[vertex])? {
            add_piece(&mut renderer, &kernel, &piece, [positions, normals], influences, targets)?;
        }
        Ok(Self { renderer, vertices: count, joints, targets: targets.len() })
    }

    /// The skin of an entity that has one, at the morph weights of its rest.
    ///
    /// # Errors
    /// [`GpuError::Options`] if the entity has no skin or its shape cannot be made; else as [`GpuSkin::new`].
    pub fn of_entity(context: &Context, scene: &AnimatedScene, entity: &Entity) -> Result<Self, GpuError> {
        let Some(skin) = entity.skin() else {
            return Err(GpuError::Options("expected an entity with a skin, found one without".into()));
        };
        let options = |error: SceneError| GpuError::Options(error.to_string());
        let own = scene.own_scene(entity).map_err(options)?;
        let mut positions = Vec::new();
        let mut normals = Vec::new();
        let mut influences = Vec::new();
        for (mesh, number) in own.meshes().iter().zip(entity.meshes()) {
            positions.extend_from_slice(mesh.positions());
            normals.extend_from_slice(mesh.normals());
            let of = |v| scene.influences(number, v).map(|(joint, weight)| (joint as u32, weight as f32)).collect();
            influences.extend((0..mesh.positions().len()).map(of));
        }
        let joints = scene.rest_pose().map_err(options)?.joint_maps(skin).len();
        Self::new(context, [&positions, &normals], &influences, joints, &[])
    }

    /// The pass, and the buffer `posed` that it writes.
    #[must_use]
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Sets the joints: where each takes what is bound to it, such as [`PosedScene::joint_maps`]. `origin` is the point from which
    /// positions count afterwards.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there are more or fewer than before.
    pub fn set_joints(&self, joints: &[Place], origin: [f64; 3]) -> Result<(), GpuError> {
        expect("joints", self.joints, joints.len())?;
        let rows: Vec<[[f32; 4]; 3]> = joints
            .iter()
            .map(|joint| {
                let mut rows = joint.rows();
                rows.iter_mut().zip(origin).for_each(|(row, o)| row[3] -= o);
                rows.map(|row| row.map(|x| x as f32))
            })
            .collect();
        self.renderer.update("joints", &rows)
    }

    /// [`GpuSkin::set_joints`] of a pose, for the skin of an entity.
    ///
    /// # Errors
    /// As there, and if the entity has no skin.
    pub fn set_pose(&self, pose: &PosedScene, entity: &Entity) -> Result<(), GpuError> {
        let Some(skin) = entity.skin() else {
            return Err(GpuError::Options("expected an entity with a skin, found one without".into()));
        };
        self.set_joints(&pose.joint_maps(skin), pose.scene().origin())
    }

    /// Sets the weights of the morph targets.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there are more or fewer than before.
    pub fn set_weights(&self, weights: &[f32]) -> Result<(), GpuError> {
        expect("weights", self.targets, weights.len())?;
        self.renderer.update("weights", weights)
    }

    /// The vertices where the joints and the weights take them.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn vertices(&self) -> Result<Vec<GpuVertex>, GpuError> {
        self.renderer.run()?;
        self.renderer.read("posed", self.vertices)
    }
}

/// Uploads the vertices of a piece, and adds the pass that poses them.
fn add_piece(
    renderer: &mut Renderer,
    kernel: &Kernel,
    piece: &Piece,
    [positions, normals]: [&[[f32; 3]]; 2],
    influences: &[Vec<(u32, f32)>],
    targets: &[MorphTarget<'_>],
) -> Result<(), GpuError> {
    let some = piece.items.clone();
    let rest = vertices(&positions[some.clone()], &normals[some.clone()], 1.0);
    let influences = &influences[some.clone()];
    let mut packed = vec![0; influences.len() + 1];
    for (v, own) in influences.iter().enumerate() {
        packed[v + 1] = packed[v] + own.len() as u32;
    }
    packed.extend(influences.iter().flatten().flat_map(|(joint, weight)| [*joint, weight.to_bits()]));
    let of_target = |target: &MorphTarget<'_>| {
        let normals = target.normals.get(some.clone()).unwrap_or_default();
        vertices(&target.positions[some.clone()], normals, 0.0)
    };
    let added: Vec<GpuVertex> = targets.iter().flat_map(of_target).collect();
    let names = ["sizes", "rest", "influences", "targets"].map(|name| piece.of(name));
    let [own_sizes, own_rest, own_influences, own_targets] = &names;
    renderer.uniform(own_sizes, &[piece.count(), targets.len() as u32, 0, 0])?;
    renderer.upload(own_rest, &rest)?;
    renderer.upload(own_influences, &packed)?;
    renderer.upload(own_targets, &added)?;
    let pass = Pass::compute(piece.of("skin"), kernel, piece.count()).read(own_sizes).read(own_rest);
    let pass = pass.read(own_influences).read("joints").read(own_targets).read("weights");
    renderer.add(pass.write_part("posed", piece.part(size_of::<GpuVertex>() as u64)))
}

fn check(
    count: usize,
    normals: &[[f32; 3]],
    influences: &[Vec<(u32, f32)>],
    joints: usize,
    targets: &[MorphTarget<'_>],
) -> Result<(), GpuError> {
    expect("normals", count, normals.len())?;
    expect("lists of joints", count, influences.len())?;
    for target in targets {
        expect("positions of a morph target", count, target.positions.len())?;
        if !target.normals.is_empty() {
            expect("normals of a morph target", count, target.normals.len())?;
        }
    }
    match influences.iter().position(|own| own.iter().any(|(joint, _)| *joint as usize >= joints)) {
        Some(v) => Err(GpuError::Options(format!("expected joints below {joints}, found another at vertex {v}"))),
        None => Ok(()),
    }
}

fn expect(what: &str, expected: usize, found: usize) -> Result<(), GpuError> {
    if expected == found {
        return Ok(());
    }
    Err(GpuError::Options(format!("expected {expected} {what}, found {found}")))
}

fn vertices(positions: &[[f32; 3]], normals: &[[f32; 3]], w: f32) -> Vec<GpuVertex> {
    let normal = |k: usize| normals.get(k).copied().unwrap_or([0.0; 3]);
    let vertex = |(k, [x, y, z]): (usize, &[f32; 3])| {
        let n = normal(k);
        GpuVertex { position: [*x, *y, *z, w], normal: [n[0], n[1], n[2], 0.0] }
    };
    positions.iter().enumerate().map(vertex).collect()
}
