//! A scene as a job names it: its file is opened once, whatever of it is asked for.

use lobe_io::{Job, JobOptions as _, OptionError};
use lobe_scene::{AnimatedScene, GltfReader, Scene, SceneReadReport, SceneSource, built_in};

use crate::error::PrtError;
use crate::files::read_baked::{BakedOrScene, BakedTransfer, baked_pose, is_baked};

/// An open scene, with its glTF file if it is in one. The job of each function hears what a user should know of it.
pub struct OpenScene {
    source: SceneSource,
    max_bytes: u64,
    gltf: Option<GltfReader>,
}

impl OpenScene {
    /// Opens the file, if the scene is in one.
    ///
    /// # Errors
    /// [`PrtError::OfJob`] for options that the scene has no use for; [`PrtError::Scene`] if the file cannot be read.
    pub fn new(source: SceneSource, max_bytes: u64) -> Result<Self, PrtError> {
        source.check()?;
        let gltf =
            source.is_gltf().then(|| GltfReader::open(&source.scene, &source.read_options(max_bytes))).transpose()?;
        Ok(Self { source, max_bytes, gltf })
    }

    /// Where the scene is, and how it is read.
    #[must_use]
    pub fn source(&self) -> &SceneSource {
        &self.source
    }

    /// Whether animations, skins or morph targets of a glTF file change how the scene stands.
    #[must_use]
    pub fn has_poses(&self) -> bool {
        self.gltf.as_ref().is_some_and(GltfReader::has_poses)
    }

    /// The scene as it stands at the time that is asked for; a baked one else as it was baked.
    ///
    /// # Errors
    /// Those of [`SceneSource::read`].
    pub fn scene(self, work: &mut Job<'_>) -> Result<Scene, PrtError> {
        let name = self.source.name();
        let Some(gltf) = &self.gltf else {
            let read = self.source.read(self.max_bytes, false)?;
            read.remarks.iter().for_each(|text| work.note(&name, text));
            return Ok(read.scene);
        };
        let (scene, report) = match baked_pose(gltf).filter(|_| self.source.option_of_pose().is_none()) {
            Some(pose) => {
                let (scene, mut report) = gltf.scene_in(&pose)?;
                report.assumed_animation = None;
                (scene, report)
            }
            None => gltf.scene()?,
        };
        note(&report, &name, work);
        Ok(scene)
    }

    /// The scene, and with it the transfer that a baked glTF file holds.
    ///
    /// # Errors
    /// [`PrtError::OfJob`] for a time or for light straight through surfaces of a baked file, which is baked in one way;
    /// else those of [`BakedOrScene::of`].
    pub fn baked_or_scene(self, work: &mut Job<'_>) -> Result<BakedOrScene, PrtError> {
        let Some(gltf) = &self.gltf else { return Ok(self.scene(work)?.into()) };
        self.expect_not_straight_through()?;
        if let Some(option) = self.source.option_of_pose().filter(|_| is_baked(gltf)) {
            let message = format!("{} is baked in one pose; bake its scene with the option", self.source.name());
            return Err(OptionError::new(option, message).into());
        }
        let read = BakedOrScene::of(gltf)?;
        match &read {
            BakedOrScene::Baked(baked) => baked.report.notes.iter().for_each(|text| work.note(gltf.name(), text)),
            BakedOrScene::Scene(_, report) => note(report, gltf.name(), work),
        }
        Ok(read)
    }

    /// The scene with what moves it: nothing, unless it is a glTF file or a built-in scene that moves. With it, if it is
    /// of use, the transfer that a baked file holds.
    ///
    /// # Errors
    /// [`PrtError::OfJob`] for light straight through surfaces of a baked file; else those of
    /// [`AnimatedScene::from_gltf`] and [`BakedTransfer::of`].
    pub fn animated(
        self,
        takes_transfer: bool,
        work: &mut Job<'_>,
    ) -> Result<(AnimatedScene, Option<BakedTransfer>), PrtError> {
        if let Some(made) = self.source.built_in_name().and_then(built_in::moving) {
            return Ok((made, None));
        }
        let Some(gltf) = &self.gltf else { return Ok((AnimatedScene::still(self.scene(work)?), None)) };
        self.expect_not_straight_through()?;
        let (animated, report) = AnimatedScene::from_gltf(gltf)?;
        note(&report, gltf.name(), work);
        let rest = animated.rest();
        let is_taken = takes_transfer && BakedTransfer::covers(gltf, rest);
        let baked = is_taken.then(|| BakedTransfer::of(gltf, rest)).transpose()?;
        Ok((animated, baked))
    }

    /// Refuses a baked file where light is asked to go straight through.
    fn expect_not_straight_through(&self) -> Result<(), PrtError> {
        if self.source.transparency && self.gltf.as_ref().is_some_and(is_baked) {
            let name = self.source.name();
            let message = format!("{name} is baked, with or without; bake its scene with the option");
            return Err(OptionError::new("transparency", message).into());
        }
        Ok(())
    }
}

/// Tells the findings of reading a file.
fn note(report: &SceneReadReport, name: &str, work: &mut Job<'_>) {
    report.remarks_with_options().iter().for_each(|text| work.note(name, text));
}
