//! The rooms of the window: one list, which the bar, the keys, files that are opened and what is kept go by.

use std::path::Path;

use eframe::egui::{Key, Ui};
use serde::{Deserialize, Serialize};

use crate::loading::cache::UserFolder;
use crate::loading::file_kind::FileKind;
use crate::rooms::functions::edits::FunctionsEdits;
use crate::rooms::functions::functions_room::FunctionsRoom;
use crate::rooms::motion::edits::MotionEdits;
use crate::rooms::motion::motion_room::MotionRoom;
use crate::rooms::room::Room;
use crate::rooms::scene::edits::SceneEdits;
use crate::rooms::scene::scene_room::SceneRoom;
use crate::rooms::sky::edits::SkyEdits;
use crate::rooms::sky::sky_room::SkyRoom;
use crate::widgets::gpu::Gpu;
use crate::widgets::orbit::Orbit;

/// The rooms by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum RoomName {
    /// A baked scene under a turning sky.
    #[default]
    Scene,
    /// An environment and its expansions.
    Sky,
    /// Functions on the sphere.
    Functions,
    /// What moves.
    Motion,
}

impl RoomName {
    /// All of them, in the order of the bar.
    pub const ALL: [Self; 4] = [Self::Scene, Self::Sky, Self::Functions, Self::Motion];

    /// The name in the bar.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Scene => "Scene",
            Self::Sky => "Sky",
            Self::Functions => "Functions",
            Self::Motion => "Motion",
        }
    }
}

impl RoomName {
    /// The key that opens it, with Ctrl: its number in the bar.
    pub(crate) fn key(self) -> Key {
        match self {
            Self::Scene => Key::Num1,
            Self::Sky => Key::Num2,
            Self::Functions => Key::Num3,
            Self::Motion => Key::Num4,
        }
    }
}

/// What is kept of the rooms: the changes in each, and its camera.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct KeptRooms {
    /// Changes in the room of scenes.
    pub scene: SceneEdits,
    /// The camera there.
    pub orbit: Option<Orbit>,
    /// Changes in the room of functions.
    pub functions: FunctionsEdits,
    /// The camera there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub functions_orbit: Option<Orbit>,
    /// Changes in the room of skies.
    pub sky: SkyEdits,
    /// The camera there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sky_orbit: Option<Orbit>,
    /// Changes in the room of motion.
    pub motion: MotionEdits,
    /// The camera there; none before a scene was seen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion_orbit: Option<Orbit>,
}

impl KeptRooms {
    /// Brings every number into the range that its control has, whoever wrote the file.
    pub(crate) fn check(&mut self) {
        let orbits = [&mut self.orbit, &mut self.functions_orbit, &mut self.sky_orbit, &mut self.motion_orbit];
        for orbit in orbits {
            // Without one the scene is framed.
            *orbit = orbit.filter(Orbit::is_in_reach);
            orbit.iter_mut().for_each(Orbit::check);
        }
        self.scene.check();
        self.functions.check();
        self.sky.check();
        self.motion.check();
    }
}

/// The rooms.
pub(crate) struct Rooms {
    pub(crate) scene: SceneRoom,
    pub(crate) sky: SkyRoom,
    pub(crate) functions: FunctionsRoom,
    pub(crate) motion: MotionRoom,
}

impl Rooms {
    /// The rooms as they were left.
    pub(crate) fn new(kept: KeptRooms, folder: UserFolder) -> Self {
        Self {
            scene: SceneRoom::new(kept.scene, kept.orbit, folder),
            sky: SkyRoom::new(kept.sky).seen_from(kept.sky_orbit),
            functions: FunctionsRoom::new(kept.functions).seen_from(kept.functions_orbit),
            motion: MotionRoom::new(kept.motion).seen_from(kept.motion_orbit),
        }
    }

    /// What is to be kept of them.
    pub(crate) fn kept(&self) -> KeptRooms {
        KeptRooms {
            scene: self.scene.edits().clone(),
            orbit: Some(*self.scene.orbit()),
            functions: self.functions.edits().clone(),
            functions_orbit: Some(*self.functions.orbit()),
            sky: self.sky.edits().clone(),
            sky_orbit: Some(*self.sky.orbit()),
            motion: self.motion.edits().clone(),
            motion_orbit: self.motion.orbit_of_scene(),
        }
    }

    /// One of them.
    pub(crate) fn get_mut(&mut self, name: RoomName) -> &mut dyn Room {
        match name {
            RoomName::Scene => &mut self.scene,
            RoomName::Sky => &mut self.sky,
            RoomName::Functions => &mut self.functions,
            RoomName::Motion => &mut self.motion,
        }
    }

    /// Does something to each, in the order of the bar.
    pub(crate) fn each(&mut self, mut work: impl FnMut(&mut dyn Room)) {
        RoomName::ALL.into_iter().for_each(|name| work(self.get_mut(name)));
    }

    /// Shows one of them.
    pub(crate) fn ui(&mut self, name: RoomName, ui: &mut Ui, gpu: Option<&Gpu>) {
        let sky = self.scene.sky().cloned();
        self.get_mut(name).ui(ui, gpu, sky.as_ref());
    }

    /// The room in which a file of this kind is seen: that in front, if it can.
    fn seen_in(&mut self, front: RoomName, kind: FileKind) -> RoomName {
        let mut able = [front].into_iter().chain(RoomName::ALL);
        able.find(|name| self.get_mut(*name).shows().contains(&kind)).unwrap_or(front)
    }

    /// Opens a file, and returns the room in which it is seen: that in front, if it can. Another room may hold it, as that
    /// of scenes holds the sky of all.
    pub(crate) fn open(&mut self, front: RoomName, path: &Path, kind: FileKind) -> anyhow::Result<RoomName> {
        let front = self.seen_in(front, kind);
        for name in [front].into_iter().chain(RoomName::ALL.into_iter().filter(|name| *name != front)) {
            if self.get_mut(name).shows().contains(&kind) && self.get_mut(name).open(path, kind)? {
                break;
            }
        }
        Ok(front)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_seen_in_the_room_in_front_or_in_the_first_that_shows_them() {
        use RoomName::{Functions, Motion, Scene, Sky};
        let mut rooms = Rooms::new(KeptRooms::default(), UserFolder::none());
        for (kind, seen) in [
            (FileKind::Scene, [Scene, Scene, Scene, Motion]),
            (FileKind::Sky, [Scene, Sky, Scene, Motion]),
            (FileKind::Transfer, [Scene; 4]),
            (FileKind::Matrices, [Scene; 4]),
            (FileKind::Function, [Functions; 4]),
            (FileKind::Description, [Motion; 4]),
            (FileKind::Field, [Motion; 4]),
            (FileKind::Spheres, [Motion; 4]),
        ] {
            for (front, seen) in RoomName::ALL.into_iter().zip(seen) {
                assert_eq!(rooms.seen_in(front, kind), seen, "{kind:?} with {front:?} in front");
            }
        }
    }
}
