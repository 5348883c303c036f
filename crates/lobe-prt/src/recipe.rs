//! Recipes: records of everything that decided the numbers of transfer.

use std::collections::BTreeMap;

use lobe_io::Job;
use lobe_scene::{Alpha, DefaultMaterial, MissingNormals, Scene, ScenePose, SceneSource, UnwrapOptions, Up};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::bake::options::{AlbedoMode, BakeMode, BakeOptions, BakeReport};
use crate::compression::compress::{CompressOptions, CompressReport};
use crate::error::PrtError;
use crate::finishing::finish::FinishOptions;
use crate::fit::adaptive::{AdaptiveOptions, AdaptiveReport};
use crate::job::fingerprint::scene_hash;
use crate::transfer::half_transfer::HalfReport;
use crate::transfer::transfer_parts::TransferParts;

/// The name of [`AlbedoMode::None`] in a recipe.
const DEMODULATED: &str = "none";

/// Members that a bake may leave open: where nothing was chosen they are `null`.
const CHOICES: [&str; 9] =
    ["max_edge", "adaptive", "min_edge", "texels", "grid", "grid_box", "clusters", "components", "weights"];

/// Declares a struct whose fields are the members of a JSON object, with setters.
macro_rules! members {
    ($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $type:ty,)+ }) => {
        $(#[$doc])*
        pub struct $name {
            $($(#[$field_doc])* pub $field: Option<$type>,)+
            /// Members that are none of these, or are not of their type, such as `null` for a choice that was left open.
            pub others: Map<String, Value>,
        }

        impl $name {
            $(
                #[doc = concat!("The same recipe with another `", stringify!($field), "`.")]
                #[must_use]
                pub fn $field(mut self, $field: impl Into<Option<$type>>) -> Self {
                    self.$field = $field.into();
                    self
                }
            )+
        }

        impl From<Value> for $name {
            /// A value that is no object makes an empty recipe.
            fn from(value: Value) -> Self {
                let Value::Object(mut others) = value else { return Self::default() };
                Self { $($field: take(&mut others, stringify!($field)),)+ others }
            }
        }

        impl From<$name> for Value {
            fn from(recipe: $name) -> Self {
                let mut members = recipe.others;
                $(put(&mut members, stringify!($field), recipe.$field);)+
                Self::Object(members)
            }
        }
    };
}

members! {
/// The record of a bake: everything that decided the numbers of its transfer, and nothing that differs from run to run.
///
/// Every file of transfer has one, a JSON object whose members have the names of these fields. It is a note to people
/// and programs: light is applied to transfer without it. A field is `None` if the recipe does not say, or says that
/// nothing was chosen. What Lobe does not know is kept in [`Recipe::others`] and written again.
///
/// ```
/// use lobe_prt::{BakeOptions, Recipe};
///
/// let recipe: Recipe = serde_json::from_str(r#"{"samples": 64, "grid": null, "weather": "fine"}"#).unwrap();
/// assert_eq!((recipe.samples, recipe.grid, recipe.order), (Some(64), None, None));
/// assert_eq!(recipe.others["weather"], "fine");
/// assert_eq!(recipe.bake_options(), BakeOptions::default().samples(64));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Value", into = "Value")]
#[non_exhaustive]
Recipe {
    /// The name of the scene's file without its folders, or of a built-in scene.
    scene: String,
    /// The [fingerprint](lobe_io::Fingerprint) of the scene, 32 hexadecimal digits.
    scene_hash: String,
    /// The light paths.
    mode: BakeMode,
    /// Number of bands.
    order: usize,
    /// Paths from each receiver.
    samples: u32,
    /// Reflections at most; 0 where light is not reflected.
    bounces: usize,
    /// Reflections that were baked, see [`BakeReport::bounces`].
    bounces_baked: usize,
    /// See [`BakeOptions::energy_stop`].
    energy_stop: f64,
    /// The seed of the random directions.
    seed: u64,
    /// `none` if transfer has to be multiplied by the base color where it is shown, see [`AlbedoMode::None`]. Without it
    /// the albedo of the receivers is part of their transfer.
    albedo: String,
    /// The longest edge that was left when triangles were split.
    max_edge: f64,
    /// The error that splitting should reach, see [`AdaptiveOptions::error`](crate::AdaptiveOptions::error), if
    /// triangles were split where transfer is off.
    adaptive: f64,
    /// Edges that are shorter were not split.
    min_edge: f64,
    /// The most vertices after that.
    max_vertices: usize,
    /// The error that splitting left, as it was estimated.
    split_error: f64,
    /// Which axis pointed up in the scene's file, if that was not y.
    up: Up,
    /// The normals of meshes without any, if they were not those of the format.
    missing_normals: MissingNormals,
    /// The material of meshes without any, if that was not white.
    default_material: DefaultMaterial,
    /// Whether the file has the backs of double-sided surfaces, too.
    backs: bool,
    /// The parts of the transfer that the file has, if they are more than the whole.
    parts: TransferParts,
    /// Whether light went straight through glass and blended surfaces.
    straight_through: bool,
    /// Seconds from the beginning of the animation at which the scene stood, if animations, skins or morph targets pose
    /// it. Without it such a scene was baked as its nodes stand.
    time: f64,
    /// The animation, by its name or number, if it was not the first.
    animation: String,
    /// Texels along a side of a lightmap.
    texels: usize,
    /// How the scene was unwrapped for the lightmap, if its own texture coordinates were not those.
    unwrap: UnwrapOptions,
    /// Whether texels were averaged within their noise, see [`FinishOptions::denoise`].
    denoised: bool,
    /// Whether charts were made to agree at seams, see [`FinishOptions::stitch`].
    stitched: bool,
    /// Points of a grid along its axes.
    grid: [usize; 3],
    /// Two corners of the box of that grid.
    grid_box: [f64; 6],
    /// The most clusters of compressed transfer.
    clusters: usize,
    /// Directions of each cluster.
    components: usize,
    /// Bits of a weight of compressed transfer.
    weights: usize,
    /// The relative error of compressed or zonal transfer, or of one in 16 bits.
    relative_error: f64,
    /// Lobes of each receiver of zonal transfer.
    lobes: usize,
    /// Whether the axes of lobes are those of the closed form.
    closed_form: bool,
    /// Rays that were traced.
    rays: u64,
    /// See [`BakeReport::stderr_dc`].
    stderr_dc: f64,
    /// The versions of the programs that baked, by their names.
    versions: BTreeMap<String, String>,
    /// The version of Lobe that compressed.
    compressed_by: String,
    /// The version of Lobe that fitted lobes.
    fitted_by: String,
}
}

impl Recipe {
    /// The recipe of a bake: its options, whether light went straight through surfaces of the scene, and what its report
    /// says that the same arguments lead to again.
    #[must_use]
    pub fn of_bake(scene: &Scene, options: &BakeOptions, report: &BakeReport) -> Self {
        let albedo = (options.albedo == AlbedoMode::None).then(|| DEMODULATED.to_owned());
        let is_see_through = (0..scene.meshes().len()).map(|mesh| scene.material(mesh)).any(|material| {
            material.straight_through && (material.alpha == Alpha::Blend || material.transmission > 0.0)
        });
        let others = CHOICES.map(|choice| (choice.to_owned(), Value::Null)).into_iter().collect();
        Self { others, ..Self::default() }
            .scene_hash(scene_hash(scene))
            .albedo(albedo)
            .straight_through(is_see_through.then_some(true))
            .mode(options.mode)
            .order(options.order)
            .samples(report.samples)
            .bounces(options.most_bounces())
            .bounces_baked(report.bounces)
            .energy_stop(options.energy_stop)
            .seed(options.seed)
            .rays(report.rays)
            .stderr_dc(report.stderr_dc)
            .versions(BTreeMap::from([("lobe".to_owned(), env!("CARGO_PKG_VERSION").to_owned())]))
    }

    /// The recipe of the same transfer, compressed by this version.
    #[must_use]
    pub fn of_compressed(self, options: &CompressOptions, report: &CompressReport) -> Self {
        self.of_fronts()
            .clusters(options.clusters)
            .components(options.components)
            .weights(8 * options.weights.bytes())
            .relative_error(report.relative_error)
            .compressed_by(env!("CARGO_PKG_VERSION").to_owned())
    }

    /// The recipe of the same transfer, rounded to 16 bits by this version: all coefficients are there, and what they lost before, in
    /// clusters or by other rounding, is in the error, as if independent of it.
    #[must_use]
    pub fn of_halves(self, report: &HalfReport) -> Self {
        let error = report.relative_error.hypot(self.relative_error.unwrap_or(0.0));
        let recipe = Self { clusters: None, components: None, weights: None, ..self };
        recipe.of_fronts().relative_error(error).compressed_by(env!("CARGO_PKG_VERSION").to_owned())
    }

    /// The recipe of the transfer of fronts alone, without backs or a direct part.
    fn of_fronts(self) -> Self {
        Self { backs: None, parts: None, ..self }
    }

    /// The same recipe, of a scene that was split where its transfer is off.
    #[must_use]
    pub fn split_by(self, options: &AdaptiveOptions, report: &AdaptiveReport) -> Self {
        let budget = options.budget(report.vertices_before);
        self.adaptive(options.error).max_vertices(budget).split_error(report.error)
    }

    /// The same recipe, of a scene that was read so. Defaults are left out.
    #[must_use]
    pub fn read_from(self, source: &SceneSource) -> Self {
        let defaults = SceneSource::default();
        self.scene(source.file_name())
            .up(Some(source.up).filter(|up| *up != defaults.up))
            .missing_normals(source.missing_normals)
            .default_material(Some(source.default_material).filter(|material| *material != defaults.default_material))
    }

    /// The same recipe, of a scene that was read from a file that poses it.
    #[must_use]
    pub fn posed(self, pose: &ScenePose) -> Self {
        match pose {
            ScenePose::At { animation, time } => self.time(*time).animation(animation.clone()),
            ScenePose::Start => self.time(0.0),
            _ => self,
        }
    }

    /// The recipe of transfer at the texels of a lightmap of this width, finished so.
    #[must_use]
    pub(crate) fn of_texels(self, width: usize, finish: &FinishOptions) -> Self {
        let yes = |is_done: bool| is_done.then_some(true);
        self.texels(width).denoised(yes(finish.denoise)).stitched(yes(finish.stitch))
    }

    /// The scene to which transfer of texels belongs: unwrapped, if it was for the bake; `place` stands in messages.
    ///
    /// # Errors
    /// Those of [`Scene::unwrapped`]; [`PrtError::Invalid`] if that does not give the coordinates of the bake, as of
    /// another scene, or in another version.
    pub fn scene_of_texels(&self, scene: Scene, place: &str) -> Result<Scene, PrtError> {
        let Some(options) = &self.unwrap else { return Ok(scene) };
        let (unwrapped, _) = scene.unwrapped(options, Job::default())?;
        let unwrapped = unwrapped.with_straight_through(self.straight_through == Some(true));
        match &self.scene_hash {
            Some(expected) if scene_hash(&unwrapped) != *expected => {
                let message = "expected the scene that was unwrapped for it, found another, or one that is unwrapped \
                               otherwise; a bake to .glb holds its coordinates";
                Err(PrtError::invalid(place, message))
            }
            _ => Ok(unwrapped),
        }
    }

    /// The pose in which the scene was baked, if its file poses it.
    #[must_use]
    pub fn pose(&self) -> ScenePose {
        match self.time {
            // Read as it was, with a fault in what moves too.
            Some(0.0) if self.animation.is_none() => ScenePose::Start,
            Some(time) => ScenePose::At { animation: self.animation.clone(), time },
            None => ScenePose::Unposed,
        }
    }

    /// The options of the bake, with defaults where the recipe does not say. Matrices are those of interreflected
    /// light.
    #[must_use]
    pub fn bake_options(&self) -> BakeOptions {
        let defaults = BakeOptions::default();
        BakeOptions {
            mode: match self.mode {
                None | Some(BakeMode::Glossy) => BakeMode::Interreflected,
                Some(mode) => mode,
            },
            order: self.order.unwrap_or(defaults.order),
            samples: self.samples,
            bounces: self.bounces.unwrap_or(defaults.bounces),
            energy_stop: self.energy_stop.unwrap_or(defaults.energy_stop),
            seed: self.seed.unwrap_or(defaults.seed),
            channels: None,
            albedo: if self.albedo.as_deref() == Some(DEMODULATED) { AlbedoMode::None } else { AlbedoMode::Vertex },
        }
    }

    /// How the texels of a lightmap were finished.
    #[must_use]
    pub fn finish_options(&self) -> FinishOptions {
        FinishOptions { denoise: self.denoised == Some(true), stitch: self.stitched == Some(true) }
    }

    /// The name of the light paths, also of those that this version does not know.
    #[must_use]
    pub fn mode_name(&self) -> Option<&str> {
        self.mode.map(BakeMode::name).or_else(|| self.others.get("mode")?.as_str())
    }

    /// Refuses transfer whose albedo is where this version does not know it to be: it would be shown as if the albedo
    /// were part of it.
    pub(crate) fn understood(self, place: &str) -> Result<Self, PrtError> {
        let found = match (self.albedo.as_deref(), self.others.get("albedo")) {
            (None, None) | (Some(DEMODULATED), _) => return Ok(self),
            (Some(text), _) => format!("{text:?}"),
            (None, Some(value)) => value.to_string(),
        };
        let message = format!(
            "expected an albedo of {DEMODULATED:?} in its recipe, or none, found {found}; take a Lobe as new as the file"
        );
        Err(PrtError::Unsupported { place: place.to_owned(), message })
    }
}

/// Takes a member of an object, if it is there and of the type.
fn take<T: DeserializeOwned>(members: &mut Map<String, Value>, name: &str) -> Option<T> {
    let value = T::deserialize(members.get(name)?).ok()?;
    members.remove(name);
    Some(value)
}

/// Puts a member into an object, if there is one.
fn put<T: Serialize>(members: &mut Map<String, Value>, name: &str, value: Option<T>) {
    // Numbers, texts and lists of them always are JSON.
    if let Some(value) = value.and_then(|value| serde_json::to_value(value).ok()) {
        members.insert(name.to_owned(), value);
    }
}

#[cfg(test)]
mod tests {
    use lobe_scene::built_in;
    use serde_json::json;

    use super::*;

    #[test]
    fn a_recipe_is_written_as_it_was_read_whatever_is_in_it() {
        for text in [
            "{}",
            r#"{"bounces":3,"energy_stop":0.001,"grid":null,"mode":"glossy","samples":1024,"seed":0,"texels":64}"#,
            r#"{"mode":"by moonlight","samples":"many","unknown":[1,null],"versions":{"lobe":"0.1.0","other":"2"}}"#,
            r#"{"grid":[2,3,4],"grid_box":[0.0,0.5,1.0,2.0,3.0,4.25],"order":-1,"samples":99999999999}"#,
        ] {
            let recipe: Recipe = serde_json::from_str(text).unwrap();
            assert_eq!(serde_json::to_string(&recipe).unwrap(), text, "{recipe:?}");
        }
        assert_eq!(Recipe::from(json!("text")), Recipe::default(), "no object says nothing");
    }

    #[test]
    fn options_are_those_of_the_bake_and_defaults_where_nothing_is_said() {
        let defaults = BakeOptions::default();
        assert_eq!(Recipe::default().bake_options(), defaults, "an empty recipe");
        let options =
            BakeOptions { mode: BakeMode::Shadowed, order: 3, samples: Some(7), energy_stop: 0.5, seed: 9, ..defaults };
        let report = BakeReport {
            samples: 7,
            receivers: 1,
            rays: 2,
            seconds: 0.0,
            bounces: 0,
            energy_per_bounce: vec![],
            energy_left: 0.0,
            stderr_dc: 0.25,
        };
        let scene = built_in::ball_over_ground(4);
        let recipe = Recipe::of_bake(&scene, &options, &report);
        assert_eq!(recipe.bake_options(), BakeOptions { bounces: 0, ..options }, "{recipe:?}");
        assert_eq!((recipe.rays, recipe.stderr_dc), (Some(2), Some(0.25)), "what the report says");
        assert_eq!(recipe.straight_through, None, "nothing of it lets light through");
        assert_eq!((recipe.texels, recipe.others.get("texels")), (None, Some(&Value::Null)), "no lightmap");
        let text = serde_json::to_string(&recipe.clone().texels(64)).unwrap();
        assert!(text.contains("\"texels\":64") && text.contains("\"grid\":null"), "{text}");
        let (meshes, mut materials, textures) = scene.into_parts();
        materials.iter_mut().for_each(|m| (m.transmission, m.straight_through) = (0.5, true));
        let glass = Scene::new(meshes, materials, textures).unwrap();
        let recipe = Recipe::of_bake(&glass, &options, &report);
        assert_eq!(recipe.straight_through, Some(true), "glass");
    }

    #[test]
    fn an_albedo_of_a_later_version_is_refused() {
        for (text, is_known) in [
            ("{}", true),
            (r#"{"albedo":"none"}"#, true),
            (r#"{"albedo":"texel"}"#, false),
            (r#"{"albedo":["none"]}"#, false),
        ] {
            let recipe: Recipe = serde_json::from_str(text).unwrap();
            assert_eq!(recipe.understood("a.glb").is_ok(), is_known, "{text}");
        }
    }
}
