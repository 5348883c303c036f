//! Fingerprints of scenes, and of the machine's arithmetic.

use lobe_io::Fingerprint;
use lobe_scene::{Alpha, Material, Scene, TextureUse};
use lobe_sh::simd::Machine;

/// The fingerprint of all of a scene that a bake depends on, 32 hexadecimal digits: [`Recipe::scene_hash`](crate::Recipe).
#[must_use]
pub fn scene_hash(scene: &Scene) -> String {
    /// The kind of scenes among fingerprints.
    const KIND: u64 = 0;
    let mut all = Fingerprint::of_kind(KIND);
    fingerprint_scene(&mut all, scene);
    all.to_string()
}

/// Writes into a fingerprint all of a scene that a bake depends on: not what makes surfaces shine.
pub fn fingerprint_scene(all: &mut Fingerprint, scene: &Scene) {
    for mesh in scene.meshes() {
        all.floats(mesh.positions().as_flattened());
        all.floats(mesh.normals().as_flattened());
        all.words(mesh.triangles().as_flattened().iter().map(|&i| u64::from(i)));
        (0..2).for_each(|set| all.floats(mesh.uvs(set).as_flattened()));
        // Without a third set it is what it was before there was one.
        if !mesh.third_uvs().is_empty() {
            all.floats(mesh.third_uvs().as_flattened());
        }
        all.floats(mesh.colors().as_flattened());
        // Without normal maps the fingerprint is what it was before there were some.
        if !mesh.tangents().is_empty() {
            all.floats(mesh.tangents().as_flattened().as_flattened());
        }
        all.word(mesh.material().map_or(u64::MAX, |m| m as u64));
    }
    // Textures of a finish change nothing of transfer: others count as if those were not there.
    let mut is_used = vec![false; scene.textures().len()];
    let uses = |material: &Material| [material.base_color_texture, material.normal_map.map(|map| map.used)];
    scene.materials().iter().flat_map(uses).flatten().for_each(|used| is_used[used.texture] = true);
    let numbers: Vec<u64> =
        is_used.iter().scan(0, |before, used| Some(std::mem::replace(before, *before + u64::from(*used)))).collect();
    scene.materials().iter().for_each(|material| fingerprint_material(all, material, &numbers));
    for (texture, _) in scene.textures().iter().zip(&is_used).filter(|(_, used)| **used) {
        all.words([texture.width() as u64, texture.wrap()[0] as u64, texture.wrap()[1] as u64].into_iter());
        all.bytes(texture.texels().as_flattened());
    }
}

/// Writes into a fingerprint how the machine rounds sums of the basis, so that no shard or checkpoint of another kind is mixed in: nothing
/// where products and sums are fused, as they are nearly everywhere, and one word where they are not (`LOBE_SIMD=plain`).
pub fn fingerprint_arithmetic(all: &mut Fingerprint) {
    if Machine::detect().is_plain() {
        all.word(u64::from_le_bytes(*b"plainsum"));
    }
}

/// Writes what a material says besides a color into a fingerprint; without textures and emission, two numbers.
pub fn fingerprint_finish(all: &mut Fingerprint, scene: &Scene, material: &Material) {
    all.floats(&[material.metallic, material.roughness]);
    let mut used = |name: &[u8; 8], used: Option<TextureUse>| {
        if let Some(used) = used {
            all.word(u64::from_le_bytes(*name));
            fingerprint_use(all, used, 0);
            let texture = &scene.textures()[used.texture];
            all.words([texture.width() as u64, texture.wrap()[0] as u64, texture.wrap()[1] as u64].into_iter());
            all.bytes(texture.texels().as_flattened());
        }
    };
    used(b"metallic", material.metallic_texture);
    used(b"rough   ", material.roughness_texture);
    used(b"emissive", material.emissive_texture);
    if material.is_emissive() {
        all.floats(&material.emissive);
    }
}

/// The use of a texture, which has this number among those that count.
fn fingerprint_use(all: &mut Fingerprint, used: TextureUse, number: u64) {
    all.words([number, used.uv_set as u64].into_iter());
    all.floats(used.uv_map.as_flattened());
}

fn fingerprint_material(all: &mut Fingerprint, material: &Material, numbers: &[u64]) {
    all.floats(&material.base_color);
    if let Some(used) = material.base_color_texture {
        fingerprint_use(all, used, numbers[used.texture]);
    }
    if let Some(map) = material.normal_map {
        all.word(u64::from_le_bytes(*b"normals "));
        fingerprint_use(all, map.used, numbers[map.used.texture]);
        all.floats(&[map.scale]);
    }
    match material.alpha {
        Alpha::Opaque | Alpha::Blend => all.word(0),
        Alpha::Mask(cutoff) => all.floats(&[cutoff]),
    }
    all.word(u64::from(material.double_sided));
    // The fingerprint of an opaque scene is what it was before there was glass.
    if material.straight_through && material.has_holes() {
        all.floats(&[material.transmission, f32::from(u8::from(material.alpha == Alpha::Blend))]);
    }
}
