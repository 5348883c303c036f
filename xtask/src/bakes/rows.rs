//! The rows of the table: scenes, and the view of each.

use std::path::{Path, PathBuf};

use crate::bakes::glb::glb_of;
use crate::bakes::scenes;
use crate::bakes::shapes::Shapes;
use crate::corpus::package_folder;

/// Where a scene comes from.
enum Origin {
    /// It is made here.
    Made(fn() -> Shapes),
    /// A name that the command knows.
    BuiltIn(&'static str),
    /// A package of the corpus, and a file in it.
    Package(&'static str, &'static str),
}

/// A row of the table.
pub(super) struct Row {
    pub(super) name: &'static str,
    origin: Origin,
    /// Options of the view; none show all of the scene.
    pub(super) view: &'static str,
    /// Paths through each pixel of each half of the reference.
    pub(super) paths: u32,
}

/// Paths of a view into a room, where most of the light comes by reflections.
const INSIDE: u32 = 160;

/// Paths of a view from outside.
const OUTSIDE: u32 = 48;

const ASSETS: &str = "@pmndrs/assets";
const PROFILES: &str = "@webxr-input-profiles/assets";

pub(super) const ROWS: &[Row] = &[
    made("box with a knot", scenes::cornell, "--eye 0,-4.2,1 --target 0,0,1 --fov 34", 96),
    made("room", scenes::room, "--eye -2.6,-2.1,1.9 --target 0.9,0.9,0.7 --fov 70", INSIDE),
    made("robot", scenes::robot, "--eye -1.6,-4.4,1.9 --target 0,0,1.25 --fov 36", OUTSIDE),
    file("bunny", ASSETS, "package/models/bunny.glb"),
    Row { name: "hall", origin: Origin::BuiltIn("built-in:columns"), view: "", paths: 96 },
    file("controller of a headset", PROFILES, "package/dist/profiles/oculus-touch-v3/left.glb"),
    file("controller with a strap", PROFILES, "package/dist/profiles/valve-index/left.glb"),
    file("monkey", ASSETS, "package/models/suzi.glb"),
    file("logo of boxes", ASSETS, "package/models/pmndrs.glb"),
    made("house, inside", scenes::house, "--eye -0.4,-2.2,1.7 --target -3.2,1.2,0.9 --fov 75", INSIDE),
    made("house, outside", scenes::house, "--eye -8,-11,6 --target 0,0,1.2", OUTSIDE),
    made("room of boxes", scenes::room_of_boxes, "--eye 1.6,-1.7,1.6 --target -0.4,1,0.8 --fov 75", INSIDE),
    made("rods in a block", scenes::rods, "--eye 2.2,-3.6,2.4 --target 0,0,0", OUTSIDE),
    made("ball on a plate", scenes::plate, "--eye 1.5,-4.6,3 --target 0,0,0.2", OUTSIDE),
];

const fn made(name: &'static str, scene: fn() -> Shapes, view: &'static str, paths: u32) -> Row {
    Row { name, origin: Origin::Made(scene), view, paths }
}

const fn file(name: &'static str, package: &'static str, path: &'static str) -> Row {
    Row { name, origin: Origin::Package(package, path), view: "", paths: OUTSIDE }
}

impl Row {
    /// The name as part of a file's name.
    pub(super) fn file_name(&self) -> String {
        self.name.chars().filter(|c| *c != ',').map(|c| if c == ' ' { '-' } else { c }).collect()
    }

    /// What the command reads: a name, or a file that is written to the folder or fetched.
    pub(super) fn scene(&self, folder: &Path) -> Result<PathBuf, String> {
        match self.origin {
            Origin::BuiltIn(name) => Ok(name.into()),
            Origin::Package(package, path) => Ok(package_folder(package)?.join(path)),
            Origin::Made(scene) => {
                let path = folder.join(format!("{}.glb", self.file_name()));
                let written = std::fs::write(&path, glb_of(&scene()));
                written.map(|()| path.clone()).map_err(|error| format!("{}: {error}", path.display()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_are_distinct_and_need_no_quotes() {
        let mut names: Vec<String> = ROWS.iter().map(Row::file_name).collect();
        let plain = |name: &String| name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-');
        assert!(names.iter().all(plain), "{names:?}");
        names.sort();
        names.dedup();
        assert_eq!(names.len(), ROWS.len(), "{names:?}");
    }

    #[test]
    fn scenes_that_are_made_are_of_the_sizes_that_they_are_there_for() {
        let triangles = |of: Shapes| of.parts.iter().map(|part| part.triangles.len()).sum::<usize>();
        let counts = [scenes::room(), scenes::house(), scenes::room_of_boxes()].map(triangles);
        assert_eq!(counts, [5648, 662, 132], "triangles");
        let glb = glb_of(&scenes::room_of_boxes());
        assert_eq!(
            glb.len(),
            u32::from_le_bytes([glb[8], glb[9], glb[10], glb[11]]) as usize,
            "the length of the file"
        );
    }
}
