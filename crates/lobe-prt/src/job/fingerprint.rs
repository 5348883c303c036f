//! What tells one job from another.

use lobe_scene::{Alpha, Material, Scene};

use crate::sampling::sobol::mix;
use crate::{BakeOptions, Receivers};

/// Changes whenever the same arguments lead to other numbers than before.
const ALGORITHM: u64 = 2;

/// 128 bits that depend on everything written into it, and on the order. Not for secrets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fingerprint(pub(crate) [u64; 2]);

impl Fingerprint {
    /// That of a kind of job, whose number is `kind`: below 16 for bakes.
    #[must_use]
    pub fn of_kind(kind: u64) -> Self {
        let mut all = Self([ALGORITHM, kind]);
        all.word(kind);
        all
    }

    /// The bits.
    #[must_use]
    pub fn bits(self) -> [u64; 2] {
        self.0
    }

    /// Writes a number into it.
    pub fn word(&mut self, word: u64) {
        let [a, b] = self.0;
        self.0 = [mix(a.rotate_left(23) ^ word), mix(b.rotate_left(41) ^ !word)];
    }

    fn words(&mut self, words: impl ExactSizeIterator<Item = u64>) {
        self.word(words.len() as u64);
        words.for_each(|word| self.word(word));
    }

    /// Writes bytes into it, and how many they are.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.words(bytes.chunks(8).map(|chunk| {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            u64::from_le_bytes(word)
        }));
        self.word(bytes.len() as u64);
    }

    /// Writes numbers into it, and how many they are.
    pub fn floats(&mut self, floats: &[f32]) {
        let word = |pair: &[f32]| pair.iter().fold(0, |word, f| word << 32 | u64::from(f.to_bits()));
        self.words(floats.chunks(2).map(word));
        self.word(floats.len() as u64);
    }

    /// Writes all of a scene into it that a bake depends on: not what makes surfaces shine.
    pub fn scene(&mut self, scene: &Scene) {
        for mesh in scene.meshes() {
            self.floats(mesh.positions().as_flattened());
            self.floats(mesh.normals().as_flattened());
            self.words(mesh.triangles().as_flattened().iter().map(|&i| u64::from(i)));
            (0..2).for_each(|set| self.floats(mesh.uvs(set).as_flattened()));
            self.floats(mesh.colors().as_flattened());
            self.word(mesh.material().map_or(u64::MAX, |m| m as u64));
        }
        scene.materials().iter().for_each(|material| self.material(material));
        for texture in scene.textures() {
            self.words([texture.width() as u64, texture.wrap()[0] as u64, texture.wrap()[1] as u64].into_iter());
            self.bytes(texture.texels().as_flattened());
        }
    }

    fn material(&mut self, material: &Material) {
        self.floats(&material.base_color);
        if let Some(used) = material.base_color_texture {
            self.words([used.texture as u64, used.uv_set as u64].into_iter());
            self.floats(used.uv_map.as_flattened());
        }
        match material.alpha {
            Alpha::Opaque | Alpha::Blend => self.word(0),
            Alpha::Mask(cutoff) => self.floats(&[cutoff]),
        }
        self.word(u64::from(material.double_sided));
    }

    pub(crate) fn points(&mut self, points: &[[f32; 3]]) {
        self.floats(points.as_flattened());
    }

    pub(crate) fn receivers(&mut self, receivers: &Receivers) {
        self.points(receivers.positions());
        self.points(receivers.normals());
        self.points(receivers.albedos());
    }

    pub(crate) fn options(&mut self, options: &BakeOptions) {
        let BakeOptions { mode, order, samples, bounces, energy_stop, seed, channels } = options;
        let channels = channels.map_or(0, |channels| channels.count() as u64);
        let numbers = [*mode as u64, *order as u64, u64::from(*samples), *bounces as u64, *seed, channels];
        self.words(numbers.into_iter());
        self.word(energy_stop.to_bits());
    }
}
