//! Options and reports of bakes.

use derive_setters::Setters;
use lobe_io::Fingerprint;
use lobe_scene::{Mesh, Scene};

use crate::error::PrtError;
use crate::sampling::sobol::coherent_order;
use crate::transfer::transfer::Channels;
use crate::transfer::transfer::check_order;

/// The light paths of a bake.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum BakeMode {
    /// Direct light without occlusion: the closed form.
    Unshadowed,
    /// Direct light with shadows.
    Shadowed,
    /// Shadows and interreflections.
    Interreflected,
    /// The same before a receiver reflects it: of matrices alone.
    Glossy,
}

impl BakeMode {
    /// The names of all, with what they are.
    pub const NAMES: &[(&str, &str)] = &[
        ("unshadowed", "Light that meets nothing on its way"),
        ("shadowed", "Light that the scene may block"),
        ("interreflected", "Light that the scene may block, and that its surfaces reflect"),
        ("glossy", "The same light before a vertex reflects it, as matrices: for glossy surfaces"),
    ];

    /// The name in recipes.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unshadowed => "unshadowed",
            Self::Shadowed => "shadowed",
            Self::Interreflected => "interreflected",
            Self::Glossy => "glossy",
        }
    }

    /// Whether surfaces send light on.
    #[must_use]
    pub fn reflects(self) -> bool {
        matches!(self, Self::Interreflected | Self::Glossy)
    }
}

/// Where the albedo of the receivers is; that of the surfaces which light meets on its way is always in the transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum AlbedoMode {
    /// Each receiver's is a factor of its transfer. Between receivers it is interpolated with the light: detail of
    /// textures is lost.
    Vertex,
    /// Nowhere: the receivers are white, and whoever shades multiplies by the base color of the pixel (demodulated
    /// transfer).
    None,
}

impl AlbedoMode {
    /// What keeps the detail of a scene: [`AlbedoMode::None`] if a texture colors any of its surfaces, else
    /// [`AlbedoMode::Vertex`].
    #[must_use]
    pub fn of_scene(scene: &Scene) -> Self {
        let is_textured = |(number, mesh): (usize, &Mesh)| {
            let texture = &scene.material(number).base_color_texture;
            texture.as_ref().is_some_and(|texture| !mesh.uvs(texture.uv_set).is_empty())
        };
        if scene.meshes().iter().enumerate().any(is_textured) { Self::None } else { Self::Vertex }
    }
}

/// Options of a bake.
#[derive(Clone, Debug, PartialEq, Setters, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct BakeOptions {
    /// The light paths.
    pub mode: BakeMode,
    /// Number of bands, 1 to 8.
    pub order: usize,
    /// Paths from each receiver, at most [`BakeOptions::MAX_SAMPLES`]. Powers of two are distributed best. Without a
    /// choice there are [`BakeOptions::SAMPLES`], and two or four times as many where these leave noise above
    /// [`BakeOptions::NOISE`].
    #[setters(strip_option)]
    pub samples: Option<u32>,
    /// Reflections at most, where the mode [has any](BakeMode::reflects); at most [`BakeOptions::MAX_BOUNCES`].
    pub bounces: usize,
    /// Bounces that carry less than this part of the energy are left out, see [`BakeReport::energy_per_bounce`]; 0
    /// keeps all.
    pub energy_stop: f64,
    /// Bakes with different seeds have independent errors.
    pub seed: u64,
    /// Vectors for each receiver. Without a choice there is one if everything the light meets is gray, else three.
    pub channels: Option<Channels>,
    /// Whether the albedo of the receivers is part of their transfer. Matrices never have it.
    pub albedo: AlbedoMode,
}

impl Default for BakeOptions {
    /// Interreflected transfer of order 4 from paths with up to 3 bounces, of which those below 0.1 % are left out.
    fn default() -> Self {
        Self {
            mode: BakeMode::Interreflected,
            order: 4,
            samples: None,
            bounces: 3,
            energy_stop: 1e-3,
            seed: 0,
            channels: None,
            albedo: AlbedoMode::Vertex,
        }
    }
}

impl BakeOptions {
    /// Paths from a receiver if nothing else is said and they leave little noise.
    pub const SAMPLES: u32 = 1024;

    /// The most paths from a receiver if nothing else is said.
    pub const SAMPLES_OF_NOISE: u32 = 4 * Self::SAMPLES;

    /// The noise above which there are more paths: the standard error of the constant coefficient of a receiver,
    /// relative to its own, as a root mean square over surfaces. What stands in the open has less. In a house of 3.4 %
    /// a picture of a room is off by 3.9 %, and with four times the paths by 3.0 %.
    pub const NOISE: f64 = 0.02;

    /// The most paths from a receiver.
    pub const MAX_SAMPLES: u32 = 1 << 24;

    /// The options of the [direct part](crate::TransferParts) of what was baked by these, with so many paths unless
    /// they say how many: the same paths up to the first surface, so that what both hold has no noise of its own.
    #[must_use]
    pub fn of_direct_part(self, samples: Option<u32>) -> Self {
        Self { mode: BakeMode::Shadowed, samples: self.samples.or(samples), ..self }
    }

    /// The most reflections of a path.
    pub const MAX_BOUNCES: usize = 255;

    pub(crate) fn check(&self) -> Result<(), PrtError> {
        let refuse = |message: String| Err(PrtError::Options(message));
        check_order(self.order)?;
        if let Some(samples) = self.samples.filter(|samples| !(1..=Self::MAX_SAMPLES).contains(samples)) {
            return refuse(format!("expected 1 to 2^24 samples, found {samples}"));
        }
        if self.bounces > Self::MAX_BOUNCES {
            return refuse(format!("expected at most {} bounces, found {}", Self::MAX_BOUNCES, self.bounces));
        }
        if !(0.0..1.0).contains(&self.energy_stop) {
            return refuse(format!("expected an energy to stop at in [0, 1), found {}", self.energy_stop));
        }
        Ok(())
    }

    /// Writes all of them into a fingerprint.
    pub(crate) fn write_into(&self, fingerprint: &mut Fingerprint) {
        let Self { mode, order, samples, bounces, energy_stop, seed, channels, albedo } = self;
        let channels = channels.map_or(0, |channels| channels.count() as u64);
        // Glossy light is interreflected light.
        let mode = (*mode as u64).min(BakeMode::Interreflected as u64);
        let numbers = [mode, *order as u64, u64::from(samples.unwrap_or(0)), *bounces as u64, *seed, channels];
        fingerprint.words(numbers.into_iter());
        fingerprint.word(energy_stop.to_bits());
        if *albedo == AlbedoMode::None {
            fingerprint.word(1);
        }
    }

    /// The vectors of each receiver: as asked for, else one if neither the receivers nor what light meets has a hue.
    #[must_use]
    pub fn channels_for(&self, scene: &Scene, receivers_are_gray: bool) -> Channels {
        let meets_nothing = self.mode == BakeMode::Unshadowed || (self.most_bounces() == 0 && !scene.is_tinted());
        let is_gray = (receivers_are_gray || self.albedo == AlbedoMode::None) && (meets_nothing || scene.is_gray());
        self.channels.unwrap_or(if is_gray { Channels::Gray } else { Channels::Rgb })
    }

    /// Paths from each receiver, before their noise is known.
    pub(crate) fn first_samples(&self) -> u32 {
        self.samples.unwrap_or(Self::SAMPLES)
    }

    /// Paths from each receiver where the first ones leave this noise, which falls as the root of their number.
    pub(crate) fn samples_for(&self, noise: f64) -> u32 {
        let factor = (noise / Self::NOISE).powi(2).ceil().min(f64::from(Self::SAMPLES_OF_NOISE / Self::SAMPLES));
        self.samples.unwrap_or(Self::SAMPLES * (factor as u32).max(1).next_power_of_two())
    }

    /// The numbers of so many paths, so that neighbors follow each other; none where none is needed.
    pub(crate) fn path_order(&self, samples: u32) -> Vec<u32> {
        if self.mode == BakeMode::Unshadowed { Vec::new() } else { coherent_order(samples) }
    }

    /// The most reflections of a path.
    #[must_use]
    pub fn most_bounces(&self) -> usize {
        if self.mode.reflects() { self.bounces } else { 0 }
    }
}

/// The report of a bake.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct BakeReport {
    /// Number of receivers; of a [fit](crate::bake_vertices) of triangles, which are its receivers.
    pub receivers: usize,
    /// Rays traced for the results, those of work done before a resumption included.
    pub rays: u64,
    /// The time since it was started or resumed.
    pub seconds: f64,
    /// Paths from each receiver, of a fit from each vertex.
    pub samples: u32,
    /// Bounces baked: no more than asked for, less where the energy said so.
    pub bounces: usize,
    /// The mean exit radiance of all receivers and channels under a constant sky of radiance 1, by the number of
    /// reflections of the light before it reached the receiver.
    pub energy_per_bounce: Vec<f64>,
    /// An upper bound of what the next bounce would add to the sum of [`BakeReport::energy_per_bounce`]: the weight of
    /// all paths that met a surface at their end. Where no light is absorbed, both together are the mean albedo of the
    /// receivers.
    pub energy_left: f64,
    /// The standard error of the constant coefficient, relative to its mean: from 8 to 64 receivers baked with eight
    /// other seeds each; from fewer, but at least two, where they have more than 2¹⁶ paths. 0 where none of these sees
    /// any light, whose mean is 0 too.
    pub stderr_dc: f64,
}
