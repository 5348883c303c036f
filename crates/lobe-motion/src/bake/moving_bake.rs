//! Baking what the parts of a moving scene lack: transfer, fields, spheres, and grids of visibility.

use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use derive_setters::Setters;
use lobe_io::Job;
use lobe_prt::{AlbedoMode, BakeOptions, bake_vertices, scene_hash};
use lobe_scene::Bvh;
use lobe_shadow::{
    FieldOptions, Lamp, RadianceField, RadianceOptions, Solid, SphereFitOptions, SphereSet, bake_field, fit_spheres,
};

use crate::bake::swept_box::swept_box;
use crate::baked::part_backs::PartBacks;
use crate::baked::sphere_albedo::sphere_albedos;
use crate::baked::visibility_grid::{VisibilityGrid, VisibilityGridOptions};
use crate::moving_options::MovingMethod;
use crate::scene::moving_part::{Motion, MovingPart};
use crate::scene::moving_scene::MovingScene;
use lobe_render::{RenderError, transfer_bytes};

/// Options of [`MovingScene::bake`].
#[derive(Clone, Debug, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct MovingBakeOptions {
    /// Of the transfer of each part from itself.
    pub transfer: BakeOptions,
    /// Whether the part of the transfer without reflections is baked, too, so that suns cast shadows by rays.
    pub direct: bool,
    /// Of occlusion fields.
    pub field: FieldOptions,
    /// Of sphere sets.
    pub spheres: SphereFitOptions,
    /// The number of spheres of parts that change their shape; if none, that of the others.
    pub deformed_spheres: Option<usize>,
    /// Of what the parts that stand still leave visible in the box that the others sweep.
    pub visibility: VisibilityGridOptions,
    /// Whether what stands still hides the sky from what moves. If not, it only receives shadows, and what moves in a
    /// room is lit through the roof.
    pub still_hides: bool,
}

/// Spheres fitted to a part unless others are asked for: of three objects over a ground, pictures of direct light are
/// 38.6 dB from traced paths with 4 spheres each, and 39.3 with 16 and with 64.
const SPHERES: usize = 16;

/// And to a part that changes its shape: fewer are thicker than the limbs that they stand for. Pictures of a walking
/// figure are 38.4 dB from traced paths without shadows, 37.7 with 16 spheres, and 40.4 with 64 (example `skins`, the
/// mean of three times).
const DEFORMED_SPHERES: usize = 64;

/// Bytes of a point that spheres are fitted to, while they are.
const FIT_SAMPLE: u64 = 100;

/// Bytes of a vertex of a scene and of a triangle with its tree, as files are counted when they are read.
const VERTEX: u64 = 64;
const TRIANGLE: u64 = 320;

/// Copies of all vertices that a moment makes: those in place, those put together, and as receivers of light.
const COPIES: u64 = 3;

impl Default for MovingBakeOptions {
    /// The defaults of each bake, of 16 spheres, and of 64 for parts that change their shape; the albedo of each pixel
    /// is left to the picture, so that textures keep their detail.
    fn default() -> Self {
        Self {
            transfer: BakeOptions::default().albedo(AlbedoMode::None),
            direct: false,
            field: FieldOptions::default(),
            spheres: SphereFitOptions::default().count(SPHERES),
            deformed_spheres: Some(DEFORMED_SPHERES),
            visibility: VisibilityGridOptions::default(),
            still_hides: true,
        }
    }
}

impl MovingBakeOptions {
    fn spheres_of(&self, part: &MovingPart) -> SphereFitOptions {
        let deformed = self.deformed_spheres.filter(|_| !part.is_rigid());
        self.spheres.clone().count(deformed.unwrap_or(self.spheres.count))
    }
}

/// The kinds of bakes of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PartBakeKind {
    /// Transfer of the vertices from the part alone, [fitted](lobe_prt::bake_vertices) to points all over its
    /// triangles.
    Transfer,
    /// The part of the transfer without reflections.
    Direct,
    /// An occlusion field.
    Field,
    /// A sphere set.
    Spheres,
    /// A grid of visibility.
    Visibility,
}

/// One bake that parts of a moving scene lack. It prints as what it is, such as "the field of `ball`".
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PartBake {
    /// What is baked.
    pub kind: PartBakeKind,
    /// The part that is baked, and others of the same shape, which share it.
    pub parts: Vec<usize>,
    /// The name of the first.
    pub name: String,
}

impl PartBakeKind {
    fn name(self) -> &'static str {
        match self {
            Self::Transfer => "transfer",
            Self::Direct => "direct transfer",
            Self::Field => "field",
            Self::Spheres => "spheres",
            Self::Visibility => "visibility",
        }
    }
}

impl fmt::Display for PartBake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the {} of `{}`", self.kind.name(), self.name)
    }
}

impl PartBake {
    /// The file of its results among those of one scene, whose names begin with `path`.
    #[must_use]
    pub fn checkpoint(&self, path: &Path) -> PathBuf {
        let mut name = path.to_path_buf().into_os_string();
        name.push(format!(".{}-{}", self.kind.name().replace(' ', "-"), self.parts[0]));
        name.into()
    }
}

impl MovingScene {
    /// The bakes that `method` needs and that parts do not have yet: transfer of those that keep their shape, and what
    /// each hides the sky by. Parts of the same shape share one.
    ///
    /// A part that has a field or spheres hides the sky by them. One that keeps its shape but encloses no volume gets a
    /// field by either method; one that is deformed gets nothing then, and hides nothing
    /// ([`MovingScene::hides_nothing`]).
    #[must_use]
    pub fn lacking(&self, method: MovingMethod, options: &MovingBakeOptions) -> Vec<PartBake> {
        let (mut bakes, mut known) = (Vec::<PartBake>::new(), HashMap::new());
        let keys = self
            .parts()
            .iter()
            .map(|part| (self.parts().len() > 1).then(|| (scene_hash(&part.scene), part.scene.origin())));
        let keys: Vec<_> = keys.map(|key| key.map(|(hash, origin)| (hash, origin.map(f64::to_bits)))).collect();
        let has_moving = self.parts().iter().any(|part| !matches!(part.motion, Motion::Still));
        for (index, part) in self.parts().iter().enumerate() {
            let is_still = matches!(part.motion, Motion::Still);
            let transfer = (part.is_rigid() && part.transfer.is_none()).then_some(PartBakeKind::Transfer);
            let hides = match part.hides_by(method) {
                Some(_) => None,
                None if is_still => (options.still_hides && has_moving).then_some(PartBakeKind::Visibility),
                None => hides_by(part, method),
            };
            let direct = (options.direct && part.is_rigid() && part.direct.is_none()).then_some(PartBakeKind::Direct);
            for kind in transfer.into_iter().chain(direct).chain(hides) {
                // Spheres of what is deformed are bound to its own joints.
                let is_shared = part.is_rigid() && kind != PartBakeKind::Visibility && part.kept.is_none();
                let key = keys[index].clone().filter(|_| is_shared);
                let found = key.map(|key| *known.entry((kind, key)).or_insert(bakes.len()));
                match found.and_then(|bake| bakes.get_mut(bake)) {
                    Some(bake) => bake.parts.push(index),
                    None => bakes.push(PartBake { kind, parts: vec![index], name: part.name.clone() }),
                }
            }
        }
        bakes
    }

    /// The names of parts that move and hide no sky, as they are now.
    pub fn hides_nothing(&self, method: MovingMethod) -> impl Iterator<Item = &str> {
        let moving = self.parts().iter().filter(|part| !matches!(part.motion, Motion::Still));
        moving.filter(move |part| part.hides_by(method).is_none()).map(|part| part.name.as_str())
    }

    /// Does one of the bakes that are [lacking](Self::lacking). It can be kept in a file, [one for
    /// each](PartBake::checkpoint).
    ///
    /// # Errors
    /// [`RenderError::Part`] around those of the bakes, [`RenderError::Cancelled`] if the watch of the job said to
    /// stop.
    pub fn bake_part(&mut self, bake: &PartBake, options: &MovingBakeOptions, job: Job<'_>) -> Result<(), RenderError> {
        self.baked(bake, options, job).map_err(|error| error.of_part(&bake.name))
    }

    fn baked(&mut self, of: &PartBake, options: &MovingBakeOptions, job: Job<'_>) -> Result<(), RenderError> {
        let part = &self.parts()[of.parts[0]];
        match of.kind {
            PartBakeKind::Transfer => {
                let (transfer, paths) = match &part.kept {
                    Some(kept) => (kept.completed(&part.scene, job)?, kept.options.clone()),
                    None => {
                        let bvh = Bvh::new(&part.scene);
                        let (transfer, report) = bake_vertices(&part.scene, &bvh, &options.transfer, job)?;
                        (transfer, options.transfer.clone().samples(report.samples))
                    }
                };
                let transfer = Arc::new(transfer);
                self.share(of, |part| {
                    (part.transfer, part.is_demodulated) =
                        (Some(Arc::clone(&transfer)), paths.albedo == AlbedoMode::None);
                    part.paths = Some(paths.clone());
                });
            }
            PartBakeKind::Direct => {
                let paths = part.paths.clone().unwrap_or_else(|| options.transfer.clone());
                let albedo = if part.is_demodulated { AlbedoMode::None } else { AlbedoMode::Vertex };
                // Without reflections the direct part is all.
                let all = part.transfer.clone().filter(|_| paths.most_bounces() == 0);
                let direct = match all {
                    Some(all) => all,
                    None => {
                        let paths = paths.of_direct_part(None).albedo(albedo);
                        Arc::new(bake_vertices(&part.scene, &Bvh::new(&part.scene), &paths, job)?.0)
                    }
                };
                self.share(of, |part| part.direct = Some(Arc::clone(&direct)));
            }
            PartBakeKind::Field => {
                let field = Arc::new(bake_field(&part.scene, &options.field, job)?.0);
                self.share(of, |part| part.field = Some(Arc::clone(&field)));
            }
            PartBakeKind::Spheres => {
                let spheres = Arc::new(self.fitted_spheres(of.parts[0], &options.spheres_of(part), job)?);
                self.share(of, |part| part.spheres = Some(Arc::clone(&spheres)));
            }
            PartBakeKind::Visibility => {
                let Some(swept) = swept_box(self)? else { return Ok(()) };
                let grid = Arc::new(VisibilityGrid::bake(&part.scene, swept, &options.visibility, job)?);
                self.share(of, |part| part.visibility = Some(Arc::clone(&grid)));
            }
        }
        Ok(())
    }

    /// Spheres as large as a part, which follow what deforms it.
    fn fitted_spheres(
        &self,
        index: usize,
        options: &SphereFitOptions,
        mut job: Job<'_>,
    ) -> Result<SphereSet, RenderError> {
        let part = &self.parts()[index];
        let (Motion::Deformed(entity), Some(rig)) = (&part.motion, self.rig_of(index)) else {
            return Ok(fit_spheres(&part.scene, options, job)?.0.with_silhouette_of(&part.scene));
        };
        // Spheres shrink with what morph targets stretch.
        let widest = rig.morphed_scene(entity, &rig.widest_weights(entity)?)?;
        let (spheres, _) = fit_spheres(&widest, options, job.reborrow())?;
        Ok(spheres.bind_to(rig, entity, &mut job)?.with_silhouette_of(&widest))
    }

    fn share(&mut self, bake: &PartBake, set: impl Fn(&mut MovingPart)) {
        bake.parts.iter().for_each(|part| set(&mut self.parts_mut()[*part]));
    }

    /// Does all bakes that are [lacking](Self::lacking), one after the other, finds the color of all spheres, and makes
    /// the light of lamps. Files of fields,
    /// spheres and transfer can be had beforehand.
    ///
    /// The steps of `job` are those of one bake after the other. Its file is the beginning of the names of one file for
    /// [each](PartBake::checkpoint).
    ///
    /// # Errors
    /// As [`MovingScene::bake_part`].
    pub fn bake(
        &mut self,
        method: MovingMethod,
        options: &MovingBakeOptions,
        mut job: Job<'_>,
    ) -> Result<(), RenderError> {
        for bake in self.lacking(method, options) {
            let file = job.checkpoint().map(|path| bake.checkpoint(path));
            let one = job.reborrow();
            self.bake_part(&bake, options, if let Some(file) = file { one.kept_in(file) } else { one })?;
        }
        self.color_spheres();
        self.bake_lamps(options.transfer.order)
    }

    /// Finds the albedo of the surface that each sphere stands for, which
    /// [`MovingOptions::bounce`](crate::MovingOptions) needs; without it, all spheres of a part have the mean of the
    /// vertices.
    pub fn color_spheres(&mut self) {
        for part in self.parts_mut() {
            if let Some(spheres) = part.spheres.as_deref().filter(|spheres| part.sphere_albedos.len() != spheres.len())
            {
                part.sphere_albedos = sphere_albedos(&part.scene, spheres);
            }
        }
    }

    /// Makes the light of lamps that are surfaces and have none yet, or of fewer bands, on the default sample points.
    ///
    /// # Errors
    /// [`RenderError::Shadow`] with those of [`RadianceField::around`].
    pub fn bake_lamps(&mut self, order: usize) -> Result<(), RenderError> {
        for lamp in self.lamps_mut() {
            let Some(surface) = &lamp.surface else { continue };
            if lamp.lamp.as_ref().is_none_or(|lamp| lamp.order() < order) {
                let field = RadianceField::around(surface, &RadianceOptions::default().order(order))?;
                lamp.lamp = Some(Arc::new(Lamp::Still(field)));
            }
        }
        Ok(())
    }

    /// Bakes the backs of vertices that a view shows ([`backs_in_view`](Self::backs_in_view)), beside those that are
    /// baked already: without this, parts that keep their shape do not hide the sky from their own backs. Of parts that
    /// came with their transfer, too; it cannot be kept in a file. Those that were baked with other options are
    /// dropped.
    ///
    /// # Errors
    /// As [`MovingScene::bake_part`].
    ///
    /// # Panics
    /// If a vertex is not one of the scene.
    pub fn bake_backs(&mut self, seen: &[usize], options: &BakeOptions, mut job: Job<'_>) -> Result<(), RenderError> {
        job.expect_no_checkpoint().map_err(RenderError::Options)?;
        let mut first = 0;
        for part in self.parts_mut() {
            let end = first + part.scene.vertex_count();
            let range = seen.partition_point(|v| *v < first)..seen.partition_point(|v| *v < end);
            let albedo = if part.is_demodulated { AlbedoMode::None } else { AlbedoMode::Vertex };
            let options = options.clone().albedo(albedo);
            part.backs = part.backs.take().filter(|backs| backs.is_of(&options, part.direct.is_some()));
            let is_new = |vertex: &usize| part.backs.as_ref().is_none_or(|backs| !backs.has(*vertex));
            let new: Vec<usize> = seen[range].iter().map(|vertex| vertex - first).filter(is_new).collect();
            first = end;
            if new.is_empty() || !part.is_rigid() || part.transfer.is_none() {
                continue;
            }
            let backs = PartBacks::bake(
                part.backs.as_deref(),
                &part.scene,
                (&new, part.direct.is_some()),
                &options,
                job.reborrow(),
            );
            part.backs = Some(Arc::new(backs.map_err(|error| error.of_part(&part.name))?));
        }
        Ok(())
    }

    /// The least number of bands of the transfer and the fields that parts, and of the light that lamps, have already;
    /// none if there are none.
    #[must_use]
    pub fn order(&self) -> Option<usize> {
        let of_part = |part: &MovingPart| {
            let transfer = part.transfer.as_ref().map(|transfer| transfer.order());
            let transfer = transfer.or(part.kept.as_ref().map(|kept| kept.order()));
            transfer.into_iter().chain(part.field.as_ref().map(|field| field.order())).min()
        };
        let of_lamps = self.lamps().iter().filter_map(|lamp| lamp.lamp.as_ref().map(|lamp| lamp.order()));
        self.parts().iter().filter_map(of_part).chain(of_lamps).min()
    }

    /// Refuses more bands than the transfer, the fields and the light have that parts and lamps have already.
    ///
    /// # Errors
    /// [`RenderError::Options`] that says of which part.
    pub fn expect_order(&self, order: usize) -> Result<(), RenderError> {
        expect_order(self.parts(), order)?;
        let mut made = self.lamps().iter().filter(|lamp| lamp.surface.is_none());
        made.try_for_each(|lamp| lamp.expect_order(order))
    }

    /// The most bytes that the bakes take, each with what those before it have left, and then a moment with its
    /// picture's vertices.
    #[must_use]
    pub fn bytes(&self, bakes: &[PartBake], options: &MovingBakeOptions) -> u64 {
        let bakes = bakes.iter().map(|bake| bytes_of(bake, &self.parts()[bake.parts[0]], options));
        let moment = self.parts().iter().map(|part| {
            let numbers = (4 * options.field.order * options.field.order * size_of::<f32>()) as u64;
            let vertex = COPIES * VERTEX + numbers;
            let vertices = vertex.saturating_mul(part.scene.vertex_count() as u64);
            vertices.saturating_add(TRIANGLE.saturating_mul(part.scene.triangle_count() as u64))
        });
        let lamps = self.lamps().iter().filter(|lamp| lamp.lamp.is_none()).map(|_| {
            let RadianceOptions { spheres, cells, .. } = RadianceOptions::default();
            let order = options.transfer.order;
            (3 * size_of::<f32>() * order * (order + 1) * spheres * (cells + 1).pow(2)) as u64
        });
        bakes.chain(moment).chain(lamps).fold(0, u64::saturating_add)
    }
}

/// Refuses more bands than parts have.
pub(crate) fn expect_order(parts: &[MovingPart], order: usize) -> Result<(), RenderError> {
    for part in parts {
        let transfer = part.transfer.as_ref().map(|transfer| transfer.order());
        let transfer = transfer.or(part.kept.as_ref().map(|kept| kept.order())).map(|order| ("transfer", order));
        let field = part.field.as_ref().map(|field| ("field", field.order()));
        let visibility = part.visibility.as_ref().map(|grid| ("grid of visibility", grid.order()));
        let mut all = transfer.into_iter().chain(field).chain(visibility);
        if let Some((what, found)) = all.find(|(_, found)| *found < order) {
            return Err(RenderError::Options(format!(
                "`{}`: expected its {what} to have {order} bands at least, found {found}; ask for order {found}, or bake it to a \
                 higher one",
                part.name
            )));
        }
    }
    Ok(())
}

/// What a part that has nothing to hide the sky by gets.
fn hides_by(part: &MovingPart, method: MovingMethod) -> Option<PartBakeKind> {
    match method {
        MovingMethod::Fields if part.is_rigid() => Some(PartBakeKind::Field),
        _ if Solid::of_scene(&part.scene).is_ok() => Some(PartBakeKind::Spheres),
        _ => part.is_rigid().then_some(PartBakeKind::Field),
    }
}

fn bytes_of(bake: &PartBake, part: &MovingPart, options: &MovingBakeOptions) -> u64 {
    let work = match bake.kind {
        PartBakeKind::Transfer | PartBakeKind::Direct => {
            transfer_bytes(&part.scene, part.scene.vertex_count(), &options.transfer, false)
        }
        PartBakeKind::Field => {
            let FieldOptions { order, spheres, cells, .. } = options.field;
            // Rows are held as they are found, and as the field has them.
            let points = (cells + 1).saturating_pow(2).saturating_mul(spheres) as u64;
            points.saturating_mul((2 * size_of::<f32>() * order * (order + 1)) as u64)
        }
        PartBakeKind::Spheres => FIT_SAMPLE.saturating_mul(options.spheres.samples as u64),
        PartBakeKind::Visibility => {
            let VisibilityGridOptions { order, points, .. } = options.visibility;
            (points as u64).saturating_mul((2 * size_of::<f32>() * order * order) as u64)
        }
    };
    work.saturating_add(TRIANGLE.saturating_mul(part.scene.triangle_count() as u64))
}
