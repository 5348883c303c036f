//! Transfer of some places of a scene: of the backs of double-sided surfaces that a view shows, as most files hold that
//! of fronts alone, and of the direct light of suns.

use std::sync::atomic::{AtomicBool, Ordering};

use lobe_io::Job;
use lobe_prt::{BakeOptions, BakedBacks, FinishOptions, FittedVertices, TexelReceivers, Transfer, bake};
use lobe_scene::{Bvh, Scene};
use lobe_sh::{Coefficient as _, Dir, Rgb, ShVec};

use crate::camera::camera::Camera;
use crate::error::RenderError;
use crate::scene_view::prt_shading::{LitReceivers, Places, SurfaceTransfer};
use crate::scene_view::scene_picture::ray_cast;
use crate::scene_view::scene_picture::{SceneHit, ViewOptions};

/// The transfer of some places on one of their sides.
pub(crate) struct PlacedTransfer {
    /// The receiver of each place; [`NONE`] where there is none.
    receivers: Vec<u32>,
    pub(crate) transfer: SurfaceTransfer,
}

const NONE: u32 = u32::MAX;

impl PlacedTransfer {
    /// The transfer of all vertices.
    pub(crate) fn at_vertices(transfer: Transfer) -> Self {
        Self {
            receivers: (0..transfer.receivers() as u32).collect(),
            transfer: SurfaceTransfer::Matte(transfer.into()),
        }
    }

    /// Bakes the fronts of all places; vertices are fitted, texels finished.
    pub(crate) fn fronts(
        (scene, bvh): (&Scene, &Bvh),
        places: &Places,
        (options, finish): (&BakeOptions, &FinishOptions),
        job: Job<'_>,
    ) -> Result<Self, RenderError> {
        match places {
            Places::Vertices => {
                let transfer = SurfaceTransfer::fit(&FittedVertices::all(scene)?, bvh, options, false, job)?.0;
                Ok(Self { receivers: (0..scene.vertex_count() as u32).collect(), transfer })
            }
            Places::Texels(lightmap) => {
                let texels = TexelReceivers::new(scene, lightmap.width())?;
                let (transfer, _) = bake(scene, bvh, texels.receivers(), options, job)?;
                let transfer = match finish.is_asked() {
                    true => texels.finished(scene, transfer, finish)?.0,
                    false => transfer,
                };
                Ok(Self { receivers: texels.dilated(), transfer: SurfaceTransfer::Matte(transfer.into()) })
            }
        }
    }

    /// Bakes the backs of `seen`, places in rising order; vertices are fitted.
    pub(crate) fn backs(
        (scene, bvh): (&Scene, &Bvh),
        places: &Places,
        seen: &[usize],
        options: &BakeOptions,
        is_glossy: bool,
        job: Job<'_>,
    ) -> Result<Self, RenderError> {
        let mut receivers = vec![NONE; places.count(scene)];
        let transfer = match places {
            Places::Vertices => {
                (0..).zip(seen).for_each(|(receiver, &vertex)| receivers[vertex] = receiver);
                let backs = FittedVertices::backs(scene, seen)?;
                SurfaceTransfer::fit(&backs, bvh, options, is_glossy, job)?.0
            }
            Places::Texels(lightmap) => {
                // List each receiver that is needed once: texels between triangles show a neighbor's.
                let texels = TexelReceivers::new(scene, lightmap.width())?;
                let front_of = texels.dilated();
                let mut needed: Vec<usize> = seen.iter().map(|&place| front_of[place] as usize).collect();
                needed.sort_unstable();
                needed.dedup();
                // Let every texel know its receiver in that list.
                for &place in seen {
                    receivers[place] = needed.partition_point(|&front| front < front_of[place] as usize) as u32;
                }
                let backs = texels.receivers().backs(&needed)?;
                SurfaceTransfer::bake(scene, bvh, &backs, options, is_glossy, job)?.0
            }
        };
        Ok(Self { receivers, transfer })
    }

    /// The backs of these vertices of a scene, which a file holds.
    pub(crate) fn of_file(scene: &Scene, BakedBacks { vertices, transfer }: BakedBacks) -> Self {
        let mut receivers = vec![NONE; scene.vertex_count()];
        for (receiver, vertex) in vertices.into_iter().enumerate() {
            receivers[vertex] = receiver as u32;
        }
        Self { receivers, transfer: SurfaceTransfer::Matte(transfer.into()) }
    }

    /// The receiver of a place, if that was baked.
    pub(crate) fn receiver(&self, place: usize) -> Option<usize> {
        Some(self.receivers[place]).filter(|&receiver| receiver != NONE).map(|receiver| receiver as usize)
    }

    /// Takes what these places send back of a light from what they send back by other transfer, where all are matte.
    pub(crate) fn subtract_from(&self, all: &mut LitReceivers, light: &ShVec<Rgb<f64>>) {
        let (LitReceivers::Matte(all), LitReceivers::Matte(part)) = (all, self.transfer.lit(light, None)) else {
            return;
        };
        for (place, all) in all.iter_mut().enumerate() {
            if let Some(receiver) = self.receiver(place) {
                *all -= part[receiver];
            }
        }
    }

    /// The places that were baked, in rising order.
    pub(crate) fn places(&self) -> Vec<usize> {
        (0..self.receivers.len()).filter(|&place| self.receiver(place).is_some()).collect()
    }
}

/// The vertices around all places where a view shows a double-sided surface from behind, in rising order.
///
/// # Errors
/// As [`scene_picture`](fn@crate::scene_picture).
pub fn vertex_backs_in_view(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    view: &ViewOptions,
    job: Job<'_>,
) -> Result<Vec<usize>, RenderError> {
    backs_in_view(scene, bvh, camera, view, &Places::Vertices, job)
}

/// The places around all hits of double-sided surfaces from behind, in rising order.
pub(crate) fn backs_in_view(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    view: &ViewOptions,
    places: &Places,
    job: Job<'_>,
) -> Result<Vec<usize>, RenderError> {
    if !(0..scene.meshes().len()).any(|mesh| scene.material(mesh).double_sided) {
        return Ok(Vec::new());
    }
    let seen: Vec<AtomicBool> = (0..places.count(scene)).map(|_| AtomicBool::new(false)).collect();
    let mark = |hit: &SceneHit<'_>| {
        if !hit.is_front {
            for (place, _) in places.around(scene, hit) {
                seen[place].store(true, Ordering::Relaxed);
            }
        }
        Rgb::ZERO
    };
    // Of the same rays as the picture: that of neither depends on the light.
    ray_cast(scene, bvh, camera, view, &|_: Dir| Rgb::ZERO, &mark, job)?;
    Ok((0..seen.len()).filter(|&place| seen[place].load(Ordering::Relaxed)).collect())
}
