//! An open scene: its file is read once, whatever of it is asked for.

use anyhow::bail;
use lobe::prt::{BakedOrScene, BakedTransfer, baked_pose, is_baked};
use lobe::scene::{
    AnimatedScene, Entity, GltfDocument, GltfReader, Scene, ScenePose, SceneReadOptions, built_in, read_scene,
};

use crate::args::memory::MemoryLimit;
use crate::args::scene_input::{BUILT_IN, SceneInput, tell};
use crate::run::talk::Talk;

/// A scene that was given, with its glTF file if it is in one. What is read of it is noted.
pub(crate) struct OpenScene<'a> {
    pub(crate) input: &'a SceneInput,
    pub(crate) memory: &'a MemoryLimit,
    pub(crate) talk: Talk,
    gltf: Option<GltfReader>,
}

/// A scene that was read to be baked.
pub(crate) struct ReadScene {
    pub(crate) scene: Scene,
    /// All that its glTF file holds, if it is to be kept.
    pub(crate) document: Option<GltfDocument>,
    /// The pose of the scene, if its file poses it.
    pub(crate) pose: Option<ScenePose>,
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
        if let Some(built_in_name) = name.strip_prefix(BUILT_IN) {
            self.input.check_built_in_options()?;
            if self.input.is_built_in_motion() {
                bail!(
                    "{name}: moves; lobe render shows it, by --mode truth, fields or shexp, and lobe field and lobe spheres take one --entity NAME of it"
                );
            }
            let Some(scene) = built_in::named(built_in_name) else {
                let prefixed = |known: &str| format!("{BUILT_IN}{known}");
                let (known, moving) = (built_in::NAMES.map(prefixed), built_in::MOVING_NAMES.map(prefixed));
                bail!(
                    "{name}: there is no such scene in the program; there are {}; of lobe render also {}, which move",
                    known.join(", "),
                    moving.join(" and ")
                );
            };
            return Ok(scene);
        }
        if self.input.has_extension(&["json"]) {
            bail!(
                "{name}: only lobe render reads descriptions of scenes; expected a file named .gltf, .glb, .vrm, .obj or .ply"
            );
        }
        let (scene, report) = match &self.gltf {
            Some(gltf) => match baked_pose(gltf).filter(|_| self.input.pose.asked().is_none()) {
                Some(pose) => {
                    let (scene, mut report) = gltf.scene_in(&pose)?;
                    report.assumed_animation = None;
                    (scene, report)
                }
                None => gltf.scene()?,
            },
            None => read_scene(self.input.path(), &self.input.checked_options(self.memory)?)?,
        };
        tell(&report, &name, self.talk);
        Ok(scene)
    }

    /// Reads or makes a scene as it stands at the time that is asked for, and with it all that a glTF file holds, if
    /// that is to be kept.
    pub(crate) fn read(
        input: &SceneInput,
        memory: &MemoryLimit,
        keeps_document: bool,
        talk: Talk,
    ) -> anyhow::Result<ReadScene> {
        input.expect_no_time_unless_gltf()?;
        let mut open = OpenScene::new(input, memory, talk)?;
        let pose = open.has_poses().then(|| input.pose.pose());
        match open.gltf.take() {
            Some(gltf) if keeps_document => {
                let (scene, report, document) = gltf.into_scene_and_document()?;
                tell(&report, &input.name(), talk);
                Ok(ReadScene { scene, document: Some(document), pose })
            }
            Some(gltf) => {
                let (scene, report) = gltf.scene()?;
                tell(&report, &input.name(), talk);
                Ok(ReadScene { scene, document: None, pose })
            }
            None => Ok(ReadScene { scene: open.scene()?, document: None, pose }),
        }
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
            self.input.check_built_in_options()?;
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
