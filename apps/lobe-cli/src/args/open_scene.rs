//! An open scene: its file is read once, whatever of it is asked for.

use anyhow::bail;
use lobe::prt::{BakedOrScene, BakedTransfer, baked_pose, is_baked};
use lobe::scene::{AnimatedScene, BUILT_IN, Entity, GltfReader, Scene, SceneReadOptions, built_in};

use crate::args::memory::MemoryLimit;
use crate::args::scene_input::{SceneInput, tell};
use crate::run::option_names::in_flags;
use crate::run::talk::Talk;

/// A scene that was given, with its glTF file if it is in one. What is read of it is noted.
pub(crate) struct OpenScene<'a> {
    pub(crate) input: &'a SceneInput,
    pub(crate) memory: &'a MemoryLimit,
    pub(crate) talk: Talk,
    gltf: Option<GltfReader>,
}

impl<'a> OpenScene<'a> {
    /// Opens the file, if it is in one.
    pub(crate) fn new(input: &'a SceneInput, memory: &'a MemoryLimit, talk: Talk) -> anyhow::Result<Self> {
        Self::by(&input.checked_options(memory)?, input, memory, talk)
    }

    /// The same for work that shades nothing: textures of normals are not read.
    pub(crate) fn of_shapes(input: &'a SceneInput, memory: &'a MemoryLimit, talk: Talk) -> anyhow::Result<Self> {
        Self::by(&input.checked_options(memory)?.normal_maps(false), input, memory, talk)
    }

    fn by(
        options: &SceneReadOptions,
        input: &'a SceneInput,
        memory: &'a MemoryLimit,
        talk: Talk,
    ) -> anyhow::Result<Self> {
        let gltf = input.is_gltf().then(|| GltfReader::open(input.path(), options)).transpose()?;
        Ok(Self { input, memory, talk, gltf })
    }

    /// Whether animations, skins or morph targets of a glTF file change how the scene stands.
    pub(crate) fn has_poses(&self) -> bool {
        self.gltf.as_ref().is_some_and(GltfReader::has_poses)
    }

    /// The scene as it stands at the time that is asked for; a baked one else as it was baked.
    pub(crate) fn scene(self) -> anyhow::Result<Scene> {
        let name = self.input.name();
        let Some(gltf) = &self.gltf else {
            let read = self.input.source()?.read(self.memory.bytes(), false)?;
            read.remarks.iter().for_each(|text| self.talk.note(&name, &in_flags(text)));
            return Ok(read.scene);
        };
        let (scene, report) = match baked_pose(gltf).filter(|_| self.input.pose.asked().is_none()) {
            Some(pose) => {
                let (scene, mut report) = gltf.scene_in(&pose)?;
                report.assumed_animation = None;
                (scene, report)
            }
            None => gltf.scene()?,
        };
        tell(&report, &name, self.talk);
        Ok(scene)
    }

    /// The scene, and with it the transfer that a baked glTF file holds.
    pub(crate) fn baked_or_scene(self) -> anyhow::Result<BakedOrScene> {
        let Some(gltf) = &self.gltf else { return Ok(self.scene()?.into()) };
        self.expect_not_straight_through()?;
        if let Some(option) = self.input.pose.asked().filter(|_| is_baked(gltf)) {
            bail!("{option}: {} is baked in one pose; bake its scene with the option", self.input.name());
        }
        let read = BakedOrScene::of(gltf)?;
        match &read {
            BakedOrScene::Baked(baked) => {
                baked.report.notes.iter().for_each(|note| self.talk.note(gltf.name(), note));
            }
            BakedOrScene::Scene(_, report) => tell(report, gltf.name(), self.talk),
        }
        Ok(read)
    }

    /// The scene with what moves it: nothing, unless it is a glTF file or one of the program that moves. With it, if it is of use, the
    /// transfer that a baked file holds.
    pub(crate) fn animated(self, takes_transfer: bool) -> anyhow::Result<(AnimatedScene, Option<BakedTransfer>)> {
        if let Some(made) = self.input.name().strip_prefix(BUILT_IN).and_then(built_in::moving) {
            self.input.source()?;
            return Ok((made, None));
        }
        let Some(gltf) = &self.gltf else { return Ok((AnimatedScene::still(self.scene()?), None)) };
        self.expect_not_straight_through()?;
        let (animated, report) = AnimatedScene::from_gltf(gltf)?;
        tell(&report, gltf.name(), self.talk);
        let rest = animated.rest();
        let is_taken = takes_transfer && BakedTransfer::covers(gltf, rest);
        let baked = is_taken.then(|| BakedTransfer::of(gltf, rest));
        Ok((animated, baked.transpose()?))
    }

    /// One entity in its own frame, in the shape that its skin was bound to, with what moves it. Without a name, it
    /// is the scene as it stands at the time that is asked for.
    ///
    /// If that scene is posed, a note says that its result does not follow. The note ends with `if_posed`.
    pub(crate) fn whole_or_entity(
        self,
        entity: Option<&str>,
        if_posed: &str,
    ) -> anyhow::Result<(Scene, Option<(AnimatedScene, Entity)>)> {
        self.input.expect_no_time_unless_gltf()?;
        if let Some(name) = entity {
            if let Some(option) = self.input.pose.asked() {
                bail!(
                    "{option}: --entity takes a part in its own frame, which no animation moves; leave one of them out"
                );
            }
            let (animated, _) = self.animated(false)?;
            let entity = animated.entity(name)?.clone();
            return Ok((animated.own_scene(&entity)?, Some((animated, entity))));
        }
        if self.has_poses() {
            let text = format!("is posed by animations, skins or morph targets, whose motion {if_posed}");
            self.talk.note(&self.input.name(), &text);
        }
        Ok((self.scene()?, None))
    }

    /// Refuses a baked file where light is asked to go straight through.
    fn expect_not_straight_through(&self) -> anyhow::Result<()> {
        if self.input.is_see_through() && self.gltf.as_ref().is_some_and(is_baked) {
            bail!("--transparency: {} is baked, with or without; bake its scene with the option", self.input.name());
        }
        Ok(())
    }
}
