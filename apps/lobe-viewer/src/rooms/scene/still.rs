//! The still picture whose truth the room traces.

use std::sync::Arc;

use lobe::env::MappedMap;
use lobe::render::Surfaces;

use crate::loading::backdrop::Behind;
use crate::loading::bake::SceneData;
use crate::loading::mode::Mode;
use crate::rooms::scene::edits::{SceneEdits, SceneLamp};
use crate::rooms::truth::Still;
use crate::widgets::orbit::Orbit;

/// What the truth of a scene depends on. Metals shine where the picture has them shine; else all is matte, as transfer takes it.
pub(crate) fn still(
    data: &SceneData,
    (sky, behind): (Option<&Arc<MappedMap>>, Behind),
    edits: &SceneEdits,
    (orbit, size): (Orbit, [u32; 2]),
    (has_gloss, bounces): (bool, usize),
) -> Still {
    Still {
        data: data.clone(),
        emitters: Vec::new(),
        sky: sky.cloned(),
        behind,
        orbit,
        size,
        turn: edits.rotation(),
        strength: edits.sky_strength,
        lamps: edits.lamps.iter().filter(|lamp| lamp.is_on).map(SceneLamp::disc).collect(),
        bounces: if edits.mode == Mode::Shadowed { 0 } else { bounces },
        surfaces: if has_gloss { Surfaces::MetallicRoughness } else { Surfaces::Matte },
    }
}
