//! Reading moving scenes from descriptions and the files that they name.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lobe_prt::{AlbedoMode, Baked, BakedOrScene, BakedTransfer, read_baked_or_scene};
use lobe_scene::{AnimatedScene, GltfReader, Scene, SceneReadOptions, SceneReadReport, built_in, is_gltf, read_scene};
use lobe_shadow::{
    AnimationChoice, EntityDescription, Lamp, LampDescription, LampSource, SceneDescription, StillDescription,
    read_lamp,
};

use crate::files::part_files::{field_of, rigid_spheres};
use crate::scene::moving_lamp::MovingLamp;
use crate::scene::moving_part::{Motion, MovingPart};
use crate::scene::moving_scene::MovingScene;
use lobe_render::RenderError;

/// Bytes of a vertex and of a triangle of a scene, as files are counted when they are read.
const VERTEX: u64 = 64;
const TRIANGLE: u64 = 320;

impl MovingScene {
    /// Reads a [description](SceneDescription) and the files that it names. Of baked .glb files the transfer is read
    /// too; of those that an entity animates, [as far as it is true](Self::keep_transfer) of what the animation leaves
    /// at rest. With the scene come the files of triangles and the reports on them. All of them together are held
    /// against
    /// [`SceneReadOptions::max_bytes`].
    ///
    /// What stands still is one part, but for what is baked or has a field: that is a part by itself, which hides the
    /// sky from other still parts by its field alone.
    ///
    /// # Errors
    /// [`RenderError::Shadow`], [`RenderError::Prt`] and [`RenderError::Scene`] with those of the readers;
    /// [`RenderError::Invalid`] if a field or spheres are not of the part that they are named for, or a baked file
    /// cannot have what the options ask for.
    pub fn read(
        path: impl AsRef<Path>,
        options: &SceneReadOptions,
    ) -> Result<(Self, Vec<(PathBuf, SceneReadReport)>), RenderError> {
        let description = SceneDescription::read(path, options.allow_outside)?;
        // What moves is shaded by normals of vertices, and so is what it throws shadows on.
        let mut reader = Reader { options: options.clone().normal_maps(false), reports: Vec::new() };
        let mut moving = Self::without_parts();
        let mut plain: Vec<Scene> = Vec::new();
        for StillDescription { mesh, field, .. } in &description.still {
            let name = mesh.file_stem().unwrap_or_default().to_string_lossy();
            let mut part = reader.part(mesh, &name, Motion::Still)?;
            if part.transfer.is_none() && field.is_none() {
                plain.push(part.scene);
                continue;
            }
            part.field = field.as_ref().map(|file| field_of(&part, file)).transpose()?;
            moving.add(part);
        }
        match plain.len() {
            0 => {}
            1 => plain.into_iter().for_each(|scene| moving.add(MovingPart::new("still", scene, Motion::Still))),
            _ => moving.add(MovingPart::new("still", Scene::joined(plain)?, Motion::Still)),
        }
        for entity in description.entities {
            match &entity.animation {
                Some(animation) => {
                    let gltf = reader.open(&entity.mesh)?;
                    let animated = reader.animated(&entity, animation, gltf.as_ref())?;
                    let baked = gltf.map(|gltf| reader.baked_of(&gltf, animated.0.rest())).transpose()?.flatten();
                    let first = moving.parts().len();
                    moving.add_animated(&entity.name, animated, baked.as_ref(), entity.track)?;
                    moving.take_spheres(first..moving.parts().len(), &entity.spheres)?;
                }
                None => moving.add(reader.rigid(entity)?),
            }
        }
        let lamps = description.lamps.into_iter().map(|lamp| reader.lamp(lamp)).collect::<Result<_, _>>()?;
        Ok((moving.with_lamps(lamps), reader.reports))
    }
}

/// The reading of files one after the other, with the memory that is left.
struct Reader {
    options: SceneReadOptions,
    reports: Vec<(PathBuf, SceneReadReport)>,
}

impl Reader {
    /// A part that moves as a whole, with what it brings along.
    fn rigid(&mut self, entity: EntityDescription) -> Result<MovingPart, RenderError> {
        let mut part = self.part(&entity.mesh, &entity.name, Motion::Track(entity.track))?;
        part.field = entity.field.as_ref().map(|file| field_of(&part, file)).transpose()?;
        part.spheres = entity.spheres.first().map(|file| rigid_spheres(&part, file)).transpose()?;
        Ok(part)
    }

    /// A lamp; that of a surface is made later.
    fn lamp(&mut self, described: LampDescription) -> Result<MovingLamp, RenderError> {
        let LampDescription { name, source, track, .. } = described;
        match source {
            LampSource::Surface(surface) => Ok(MovingLamp::shaped(name, surface, track)),
            LampSource::File(file) => {
                let lamp = read_lamp(&file)?;
                let bytes = match &lamp {
                    Lamp::Still(field) => field.bytes(),
                    Lamp::Sequence(sequence) => sequence.patches().bytes(),
                };
                self.options.max_bytes = self.options.max_bytes.saturating_sub(bytes as u64);
                Ok(MovingLamp::new(name, lamp, track))
            }
        }
    }

    /// An open glTF file; none of another kind.
    fn open(&self, file: &Path) -> Result<Option<GltfReader>, RenderError> {
        let is_file = is_gltf(file) && !file.display().to_string().starts_with("built-in:");
        Ok(is_file.then(|| GltfReader::open(file, &self.options)).transpose()?)
    }

    /// A glTF file with one of its animations, and whether that begins anew.
    fn animated(
        &mut self,
        entity: &EntityDescription,
        animation: &AnimationChoice,
        gltf: Option<&GltfReader>,
    ) -> Result<(AnimatedScene, usize, bool), RenderError> {
        let file = &entity.mesh;
        if entity.field.is_some() {
            let message = "is animated: fields of the parts that it moves are made, none can be named for it";
            return Err(RenderError::invalid(file, message));
        }
        let name = file.display().to_string();
        let made = name.strip_prefix("built-in:").map(|known| {
            built_in::moving(known).ok_or_else(|| {
                let moving = built_in::MOVING_NAMES.join(" and ");
                RenderError::invalid(file, format!("has no animation: leave out `animation`; {moving} have one"))
            })
        });
        let scene = match made.transpose()? {
            Some(scene) => scene,
            None => {
                let (scene, report) = match gltf {
                    Some(gltf) => AnimatedScene::from_gltf(gltf)?,
                    None => AnimatedScene::read(file, &self.options)?,
                };
                self.reports.push((file.clone(), report));
                scene
            }
        };
        self.count(scene.rest(), 0);
        let animation = match animation {
            AnimationChoice::Name(name) => scene.animation(name)?,
            AnimationChoice::Number(number) => scene.animation_of_number(*number as usize)?,
        };
        Ok((scene, animation, entity.is_looped))
    }

    /// The transfer of an animated file's vertices with its recipe, if the file is baked.
    fn baked_of(&self, gltf: &GltfReader, rest: &Scene) -> Result<Option<BakedTransfer>, RenderError> {
        if !BakedTransfer::covers(gltf, rest) {
            return Ok(None);
        }
        let baked = BakedTransfer::of(gltf, rest)?;
        self.expect_not_straight_through(Path::new(gltf.name()))?;
        // What light went straight through in the bake lets it through nowhere else.
        let is_opaque = baked.recipe.straight_through != Some(true);
        Ok(is_opaque.then_some(baked))
    }

    /// Refuses a baked file where light is asked to go straight through.
    fn expect_not_straight_through(&self, file: &Path) -> Result<(), RenderError> {
        if !self.options.straight_through {
            return Ok(());
        }
        let message = "is baked, with or without light straight through it; bake its scene with --transparency";
        Err(RenderError::invalid(file, message))
    }

    /// Reads the triangles of a part, and their transfer if the file is baked.
    fn part(&mut self, file: &Path, name: &str, motion: Motion) -> Result<MovingPart, RenderError> {
        let part = self.read(file, name, motion)?;
        self.count(&part.scene, part.transfer.as_ref().map_or(0, |transfer| size_of_val(transfer.coefficients())));
        Ok(part)
    }

    /// Takes the bytes of a scene and of its transfer from those that are left.
    fn count(&mut self, scene: &Scene, transfer: usize) {
        let (vertices, triangles) = (scene.vertex_count() as u64, scene.triangle_count() as u64);
        let texels: usize = scene.textures().iter().map(|texture| texture.texels().len()).sum();
        let taken = VERTEX * vertices + TRIANGLE * triangles + (4 * texels + transfer) as u64;
        self.options.max_bytes = self.options.max_bytes.saturating_sub(taken);
    }

    fn read(&mut self, file: &Path, name: &str, motion: Motion) -> Result<MovingPart, RenderError> {
        if let Some(known) = file.display().to_string().strip_prefix("built-in:") {
            let scene = built_in::named(known).ok_or_else(|| RenderError::invalid(file, unknown(known)))?;
            return Ok(MovingPart::new(name, scene, motion));
        }
        let read = match is_gltf(file) {
            true => read_baked_or_scene(file, &self.options)?,
            false => {
                read_scene(file, &self.options).map(|(scene, report)| BakedOrScene::Scene(scene, Box::new(report)))?
            }
        };
        let (part, report) = match read {
            BakedOrScene::Baked(baked) => {
                self.expect_not_straight_through(file)?;
                let Baked { scene, transfer, direct, lightmap, recipe, report, .. } = *baked;
                // Light goes where it went in the bake.
                let scene = scene.with_straight_through(recipe.straight_through == Some(true));
                let paths = recipe.bake_options();
                let is_demodulated = paths.albedo == AlbedoMode::None;
                let part = MovingPart::new(name, scene, motion);
                let direct = direct.map(Arc::new);
                // A lightmap is of what stands still.
                let transfer = lightmap.is_none().then(|| Arc::new(transfer));
                (MovingPart { transfer, direct, is_demodulated, paths: Some(paths), ..part }, report)
            }
            BakedOrScene::Scene(scene, report) => (MovingPart::new(name, scene, motion), *report),
        };
        self.reports.push((file.to_path_buf(), report));
        Ok(part)
    }
}

/// What is said of a built-in scene that does not stand still, or is none.
fn unknown(name: &str) -> String {
    let (still, moving) = (built_in::NAMES.join(", "), built_in::MOVING_NAMES);
    if moving.contains(&name) {
        return "moves by an animation: expected an entity of it with an `animation`, such as 0".to_owned();
    }
    format!("there is no such scene; there are {still}, and with an `animation` {}", moving.join(" and "))
}
