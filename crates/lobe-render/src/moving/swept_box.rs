//! The box that the moving parts of a scene sweep.

use lobe_scene::{Mesh, PosedScene};
use lobe_shadow::Placement;

use crate::{Motion, MovingPart, MovingScene, RenderError};

/// Times from the first to the last key at which a part is looked at, beside the keys of its track. What it does in between is
/// not known; grids reach a little farther.
const TIMES: usize = 33;

/// The box of all parts that move, over all of the scene's [span](MovingScene::span); none if nothing moves.
pub(crate) fn swept_box(scene: &MovingScene) -> Result<Option<[[f64; 3]; 2]>, RenderError> {
    let [begin, end] = scene.span();
    let mut times: Vec<f64> =
        (0..TIMES).map(|k| k as f64 / (TIMES - 1) as f64).map(|t| (1.0 - t) * begin + t * end).collect();
    times.dedup();
    let mut swept = Swept::new();
    for part in scene.parts() {
        if let Motion::Track(track) = &part.motion {
            let corners = corners(part.scene.world_bounds());
            for time in times.iter().copied().chain(track.keys().iter().map(|key| key.time)) {
                let placement = track.at(time);
                corners.iter().for_each(|corner| swept.add(placement.to_world(*corner)));
            }
        }
    }
    for time in times {
        swept.add_posed(scene, time)?;
    }
    Ok(swept.0)
}

fn corners([min, max]: [[f64; 3]; 2]) -> [[f64; 3]; 8] {
    std::array::from_fn(|corner| std::array::from_fn(|k| if corner >> k & 1 == 1 { max[k] } else { min[k] }))
}

struct Swept(Option<[[f64; 3]; 2]>);

impl Swept {
    fn new() -> Self {
        Self(None)
    }

    fn add(&mut self, p: [f64; 3]) {
        let [min, max] = self.0.get_or_insert([p, p]);
        for k in 0..3 {
            min[k] = min[k].min(p[k]);
            max[k] = max[k].max(p[k]);
        }
    }

    /// Adds the parts that an animation moves.
    fn add_posed(&mut self, scene: &MovingScene, time: f64) -> Result<(), RenderError> {
        if let Some(posed) = scene.posed(time)? {
            self.add_entities(scene.parts(), &posed, &Placement::IDENTITY);
        }
        for carried in scene.carried(time) {
            let (parts, posed, by) = carried?;
            self.add_entities(&scene.parts()[parts], &posed, &by);
        }
        Ok(())
    }

    fn add_entities(&mut self, parts: &[MovingPart], posed: &PosedScene, by: &Placement) {
        let (meshes, origin) = (posed.scene().meshes(), posed.scene().origin());
        for entity in parts.iter().filter_map(MovingPart::entity) {
            for p in meshes[entity.meshes()].iter().flat_map(Mesh::positions) {
                self.add(by.to_world(std::array::from_fn(|k| f64::from(p[k]) + origin[k])));
            }
        }
    }
}
