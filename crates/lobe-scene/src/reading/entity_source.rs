//! One entity of a scene as a job names it, in its own frame.

use lobe_io::{JobOptions as _, OptionError};

use crate::built_in;
use crate::error::SceneError;
use crate::files::read_options::SceneReadOptions;
use crate::motion::animated_scene::AnimatedScene;
use crate::motion::entity::Entity;
use crate::reading::gltf_reader::GltfReader;
use crate::reading::scene_source::SceneSource;
use crate::scene::scene::Scene;

/// A scene, or one entity of it.
#[derive(Debug)]
#[non_exhaustive]
pub struct ReadEntity {
    /// The scene as it stands at the time that is asked for; or the entity in its own frame, in the shape that its skin
    /// was bound to.
    pub scene: Scene,
    /// The entity that was asked for, with what moves it.
    pub entity: Option<(AnimatedScene, Entity)>,
    /// Whether the scene is one pose of several.
    pub is_posed: bool,
    /// What a user should know, each in one line. Options have `@` before their names.
    pub remarks: Vec<String>,
}

impl SceneSource {
    /// Reads the shapes of a scene, without textures of normals, or those of one entity, by name or number.
    ///
    /// # Errors
    /// Those of [`SceneSource::read`] and [`AnimatedScene::entity`]; [`SceneError::OfJob`] for the time of an entity in
    /// its own frame, which no animation moves.
    pub fn read_entity(&self, entity: Option<&str>, max_bytes: u64) -> Result<ReadEntity, SceneError> {
        let options = self.read_options(max_bytes).normal_maps(false);
        let Some(name) = entity else {
            let read = self.read_with(&options, false)?;
            let is_posed = read.pose.is_some();
            return Ok(ReadEntity { scene: read.scene, entity: None, is_posed, remarks: read.remarks });
        };
        if let Some(option) = self.option_of_pose() {
            let text = "@entity takes a part in its own frame, which no animation moves; leave one of them out";
            return Err(OptionError::new(option, text).into());
        }
        let (animated, remarks) = self.read_animated(&options)?;
        let entity = animated.entity(name)?.clone();
        let scene = animated.own_scene(&entity)?;
        Ok(ReadEntity { scene, entity: Some((animated, entity)), is_posed: false, remarks })
    }

    /// Reads a scene with what moves it: nothing, unless it is a glTF file or a built-in scene that moves.
    fn read_animated(&self, options: &SceneReadOptions) -> Result<(AnimatedScene, Vec<String>), SceneError> {
        self.check()?;
        if let Some(made) = self.built_in_name().and_then(built_in::moving) {
            return Ok((made, Vec::new()));
        }
        if !self.is_gltf() {
            let read = self.read_with(options, false)?;
            return Ok((AnimatedScene::still(read.scene), read.remarks));
        }
        let (animated, report) = AnimatedScene::from_gltf(&GltfReader::open(&self.scene, options)?)?;
        Ok((animated, report.remarks_with_options()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::scene_source::BUILT_IN;

    #[test]
    fn an_entity_of_what_moves_is_read_in_its_own_frame() {
        let source = SceneSource::of(format!("{BUILT_IN}three-objects"));
        let all = source.read_animated(&source.read_options(u64::MAX)).unwrap().0;
        let name = all.entities()[0].name().unwrap().to_owned();
        let read = source.read_entity(Some(&name), u64::MAX).unwrap();
        assert_eq!(read.entity.unwrap().1.name(), Some(&*name));
        assert!(read.scene.triangle_count() > 0 && !read.is_posed);
        let error = source.clone().time(Some(1.0)).read_entity(Some(&name), u64::MAX).unwrap_err().to_string();
        assert!(error.starts_with("time: entity takes a part in its own frame"), "{error}");
        let error = source.read_entity(Some("nobody"), u64::MAX).unwrap_err().to_string();
        assert!(error.contains("nobody"), "{error}");
        let error = source.read_entity(None, u64::MAX).unwrap_err().to_string();
        assert!(error.contains("moves; "), "{error}");
    }
}
