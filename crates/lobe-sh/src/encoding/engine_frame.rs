//! The frames in which engines have their worlds, and the way there from Lobe's.

use crate::expansion::ShVec;
use crate::rotation::{Axis, AxisPermutation};
use crate::scalar::Coefficient;
use crate::sphere::Dir;

/// The frame of an engine's world: which axis is up, and its handedness.
///
/// The way there is that of the engine's own importer of glTF: what a glTF file shows at `(x, y, z)` stands at the
/// vector of the table, and light that comes along is in the same frame.
///
/// ```text
///   YUp             (x, y, z)     glTF, three.js, PlayCanvas, Filament, bevy, Godot, Mitsuba
///   YUpLeftHanded   (-x, y, z)    Babylon.js, Unity
///   ZUp             (x, -z, y)    Blender, and Lobe itself
///   ZUpLeftHanded   (x, z, y)     Unreal Engine
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum EngineFrame {
    /// y up, right-handed.
    YUp,
    /// y up, left-handed.
    YUpLeftHanded,
    /// z up, right-handed.
    ZUp,
    /// z up, left-handed.
    ZUpLeftHanded,
}

impl EngineFrame {
    /// The rotation and the mirror that lead there from Lobe's frame, one after the other.
    fn steps(self) -> (AxisPermutation, Option<Axis>) {
        match self {
            Self::YUp => (AxisPermutation::Y_UP_FROM_Z_UP, None),
            Self::YUpLeftHanded => (AxisPermutation::Y_UP_FROM_Z_UP, Some(Axis::X)),
            Self::ZUp => (AxisPermutation::IDENTITY, None),
            Self::ZUpLeftHanded => (AxisPermutation::IDENTITY, Some(Axis::Y)),
        }
    }

    /// The permutation that leads there from Lobe's frame.
    #[must_use]
    pub fn from_lobe(self) -> AxisPermutation {
        let (turn, mirror) = self.steps();
        mirror.map_or(turn, |axis| turn.then(AxisPermutation::mirror(axis)))
    }

    /// A direction of Lobe's frame.
    #[must_use]
    pub fn dir(self, s: Dir) -> Dir {
        self.from_lobe().apply_to_dir(s)
    }

    /// A function of Lobe's frame.
    #[must_use]
    pub fn expansion<T: Coefficient>(self, f: &ShVec<T>) -> ShVec<T> {
        f.permuted(&self.from_lobe())
    }

    /// A function of this frame, in Lobe's.
    #[must_use]
    pub fn to_lobe<T: Coefficient>(self, f: &ShVec<T>) -> ShVec<T> {
        f.permuted(&self.from_lobe().inverse())
    }

    /// The frame in words.
    #[must_use]
    pub fn description(self) -> &'static str {
        match self {
            Self::YUp => "y up, right-handed, as glTF",
            Self::YUpLeftHanded => "y up, left-handed; (x, y, z) of glTF stands at (-x, y, z)",
            Self::ZUp => "z up, right-handed; (x, y, z) of glTF stands at (x, -z, y)",
            Self::ZUpLeftHanded => "z up, left-handed; (x, y, z) of glTF stands at (x, z, y)",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_of_gltf_stand_where_the_table_says() {
        let lobe_from_gltf = AxisPermutation::Z_UP_FROM_Y_UP;
        for (frame, place) in [
            (EngineFrame::YUp, [0.48, -0.6, 0.64]),
            (EngineFrame::YUpLeftHanded, [-0.48, -0.6, 0.64]),
            (EngineFrame::ZUp, [0.48, -0.64, -0.6]),
            (EngineFrame::ZUpLeftHanded, [0.48, 0.64, -0.6]),
        ] {
            let found = frame.dir(lobe_from_gltf.apply_to_dir(Dir::from_unit([0.48, -0.6, 0.64]))).to_array();
            let error = (0..3).map(|k| (found[k] - place[k]).abs()).fold(0.0, f64::max);
            assert!(error < 1e-15, "{frame:?}: {found:?}, expected {place:?}");
        }
    }
}
