//! The backs of double-sided surfaces, as far as a picture shows them.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::bail;
use lobe::prt::{BakeOptions, Receivers, TexelReceivers};
use lobe::render::{Camera, RenderError, SceneHit, ViewOptions, scene_picture};
use lobe::scene::{Bvh, Scene};
use lobe::sh::{Coefficient as _, Dir, Rgb};

use crate::render::transfer::{Places, Response};
use crate::run::ctrl_c;
use crate::run::talk::Talk;

/// Steps of the line of progress.
const STEPS: f64 = 1000.0;

/// What the backs of some places do to light.
pub(crate) struct Backs {
    /// The number of a place's receiver; [`NONE`] for one that is not seen from behind.
    receivers: Vec<u32>,
    pub(crate) response: Response,
}

const NONE: u32 = u32::MAX;

impl Backs {
    /// Bakes the backs of `seen`, places in rising order.
    pub(crate) fn bake(
        scene: &Scene,
        bvh: &Bvh,
        places: &Places,
        seen: &[usize],
        options: &BakeOptions,
        is_glossy: bool,
        talk: Talk,
    ) -> anyhow::Result<Self> {
        // Texels between triangles show a neighbor's receiver.
        let (fronts, front_of, count) = match places {
            Places::Vertices => (Receivers::at_vertices(scene)?, None, scene.vertex_count()),
            Places::Texels(lightmap) => {
                let texels = TexelReceivers::new(scene, lightmap.width())?;
                (texels.receivers().clone(), Some(texels.dilated()), lightmap.width().pow(2))
            }
        };
        let front_of = |place: usize| front_of.as_ref().map_or(place, |front_of| front_of[place] as usize);
        let mut which: Vec<usize> = seen.iter().map(|&place| front_of(place)).collect();
        which.sort_unstable();
        which.dedup();
        let mut receivers = vec![NONE; count];
        for &place in seen {
            receivers[place] = which.partition_point(|&front| front < front_of(place)) as u32;
        }
        let response = Response::bake(scene, bvh, &fronts.backs(&which)?, options, is_glossy, talk)?;
        Ok(Self { receivers, response })
    }

    /// The number of the receiver at the back of a place that is seen from behind.
    pub(crate) fn receiver(&self, place: usize) -> usize {
        self.receivers[place] as usize
    }
}

/// The places around all hits of double-sided surfaces from behind, in rising order.
pub(crate) fn seen_from_behind(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    view: &ViewOptions,
    places: &Places,
    talk: Talk,
) -> anyhow::Result<Vec<usize>> {
    if !(0..scene.meshes().len()).any(|mesh| scene.material(mesh).double_sided) {
        return Ok(Vec::new());
    }
    let count = match places {
        Places::Vertices => scene.vertex_count(),
        Places::Texels(lightmap) => lightmap.width().pow(2),
    };
    let seen: Vec<AtomicBool> = (0..count).map(|_| AtomicBool::new(false)).collect();
    let mark = |hit: &SceneHit<'_>| {
        if !hit.is_front {
            for (place, _) in places.around(scene, hit) {
                seen[place].store(true, Ordering::Relaxed);
            }
        }
        Rgb::ZERO
    };
    ctrl_c::watch();
    let line = talk.progress("look");
    let looked = scene_picture(
        scene,
        bvh,
        camera,
        view,
        |_: Dir| Rgb::ZERO,
        mark,
        |part| {
            line.show((part * STEPS) as usize, STEPS as usize, None, None);
            ctrl_c::go_on()
        },
    );
    drop(line);
    match looked {
        Err(RenderError::Cancelled) => bail!("stopped before the first picture; nothing is kept"),
        other => other?,
    };
    Ok((0..count).filter(|&place| seen[place].load(Ordering::Relaxed)).collect())
}
