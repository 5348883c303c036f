//! Maps of what suns see: where they lie, and what draws them.

use std::sync::Mutex;

use bytemuck::{Pod, Zeroable};
use lobe_env::{SceneLight, Sun};
use lobe_scene::Scene;
use lobe_sh::sphere::vector::{Vec3, add, cross, dot, normalized, scale, sub};

use crate::context::locked;
use crate::error::GpuError;
use crate::renderer::kernel::Slot;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::scene_view::scene_buffers::surface_reads;
use crate::scene_view::suns_apart::SunsApart;
use crate::scene_view::surface_pass::{Corners, SurfacePass, whole};
use crate::scene_view::surface_pieces::SurfacePieces;

/// Texels around a map into which nothing is drawn, so that rounding leads no triangle out of it.
const BORDER: u32 = 2;

/// Texels along the side of a map at least, with both borders.
const LEAST_SIDE: u32 = 16;

/// Half the extent of a scene along an axis, at least, over its largest coordinate and its largest extent: a flat
/// scene has room for rounding.
const LEAST_EXTENT: f64 = 1e-4;

/// The depths of all maps, and the indices that are drawn.
pub(crate) const DEPTHS: &str = "sun depths";
const INDICES: &str = "indices for suns";

/// A sun in the WGSL module `sun_shadow`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct SunShape {
    right: [f32; 4],
    up: [f32; 4],
    towards: [f32; 4],
    middle: [f32; 4],
    irradiance: [f32; 4],
    tile: [f32; 4],
    texture: [f32; 4],
}

/// All of them, in the module `sun_light`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct SunsShape {
    count: [u32; 4],
    all: [SunShape; SunsApart::MOST],
}

/// The suns of a view.
#[derive(Debug)]
pub(crate) struct SunMaps {
    /// Suns at most, and those with maps.
    most: usize,
    maps: usize,
    origin: Vec3,
    lit: Mutex<LitBy>,
}

/// What the maps depend on.
#[derive(Clone, Debug)]
struct LitBy {
    suns: Vec<Sun>,
    bounds: [[f64; 3]; 2],
    side: u32,
}

impl SunMaps {
    /// Makes the uniforms. Until it is lit the scene has no suns.
    pub(crate) fn add_to(
        renderer: &mut Renderer,
        scene: &Scene,
        suns: &SunsApart<'_>,
        side: u32,
    ) -> Result<Self, GpuError> {
        let (most, maps) = (suns.count(), suns.maps());
        let lit = Mutex::new(LitBy { suns: Vec::new(), bounds: scene.world_bounds(), side });
        let made = Self { most, maps, origin: scene.origin(), lit };
        if most > 0 {
            renderer.uniform("suns", &SunsShape::zeroed())?;
        }
        for number in 0..maps {
            renderer.uniform(&format!("sun {number}"), &SunShape::zeroed())?;
        }
        made.update(renderer)?;
        Ok(made)
    }

    /// The most suns that are shown.
    pub(crate) fn most(&self) -> usize {
        self.most
    }

    /// Sets the suns of a light, no more than there may be.
    pub(crate) fn light(&self, renderer: &Renderer, light: &SceneLight) -> Result<(), GpuError> {
        locked(&self.lit).suns = light.suns().to_vec();
        self.update(renderer)
    }

    /// Sets the box around a scene that has moved.
    pub(crate) fn bound(&self, renderer: &Renderer, bounds: [[f64; 3]; 2]) -> Result<(), GpuError> {
        locked(&self.lit).bounds = bounds;
        self.update(renderer)
    }

    /// Sets the side of a map in texels.
    pub(crate) fn resize(&self, renderer: &Renderer, side: u32) -> Result<(), GpuError> {
        locked(&self.lit).side = side;
        self.update(renderer)
    }

    fn update(&self, renderer: &Renderer) -> Result<(), GpuError> {
        if self.most == 0 {
            return Ok(());
        }
        let LitBy { suns, bounds, side } = locked(&self.lit).clone();
        let mut all = SunsShape::zeroed();
        all.count[0] = suns.len().min(self.most) as u32;
        let texture = texture_size(self.maps.max(1), side);
        for (number, sun) in suns.iter().take(self.most).enumerate() {
            let mut shape = shape(sun, bounds, self.origin);
            let [column, row] = tile(number);
            shape.tile = [column * side, row * side, side, BORDER].map(|texels| texels as f32);
            shape.texture = [texture[0] as f32, texture[1] as f32, 0.0, 0.0];
            all.all[number] = shape;
            if number < self.maps {
                renderer.update(&format!("sun {number}"), &[shape])?;
            }
        }
        renderer.update("suns", &[all])
    }

    /// The size of the texture with all maps; none if there are no maps.
    ///
    /// # Errors
    /// [`GpuError::Options`] if a map would be smaller than its border.
    pub(crate) fn texture(maps: usize, side: u32) -> Result<Option<[u32; 2]>, GpuError> {
        match maps {
            0 => Ok(None),
            _ if side < LEAST_SIDE => Err(GpuError::Options(format!(
                "expected maps of shadows of {LEAST_SIDE} texels along each side at least, found {side}"
            ))),
            _ => Ok(Some(texture_size(maps, side))),
        }
    }

    /// The passes that draw the maps, after what they bind was uploaded.
    pub(crate) fn passes(
        &self,
        renderer: &mut Renderer,
        scene: &Scene,
        surfaces: &SurfacePieces,
    ) -> Result<Vec<SurfacePass>, GpuError> {
        let mut passes = Vec::new();
        if self.maps == 0 {
            return Ok(passes);
        }
        let end = if scene.has_holes() { 0 } else { upload_indices(renderer, surfaces)? };
        for number in 0..self.maps {
            let (name, sun) = (format!("shadows of sun {number}"), (whole(&format!("sun {number}")), Slot::Uniform));
            if !scene.has_holes() {
                let (shader, corners) =
                    (Shader::new(&["draw_sun_shadow"]), Corners::Indexed(0..end, INDICES, &["vertices"]));
                passes.push(SurfacePass { name, shader, reads: vec![sun], corners });
                continue;
            }
            for piece in &surfaces.pieces {
                let mut reads = vec![sun.clone()];
                reads.extend(surface_reads(scene, surfaces, piece));
                let shader = Shader::new(&["draw_masked_sun_shadow"]);
                let corners = Corners::Numbered(0..3 * piece.triangles.len() as u32);
                passes.push(SurfacePass { name: surfaces.name(piece, &name), shader, reads, corners });
            }
        }
        Ok(passes)
    }
}

/// Uploads the places of the corners of all triangles; returns how many there are.
fn upload_indices(renderer: &mut Renderer, surfaces: &SurfacePieces) -> Result<u32, GpuError> {
    let mut indices = Vec::with_capacity(3 * surfaces.corners.len());
    for piece in &surfaces.pieces {
        let first = piece.places.items.start as u32;
        indices.extend(
            surfaces.corners[piece.triangles.clone()].iter().flat_map(|c| [c[0], c[1], c[2]].map(|c| first + c)),
        );
    }
    renderer.upload_indices(INDICES, &indices)?;
    Ok(indices.len() as u32)
}

/// Column and row of the map of a sun.
fn tile(number: usize) -> [u32; 2] {
    [number as u32 % 2, number as u32 / 2]
}

fn texture_size(maps: usize, side: u32) -> [u32; 2] {
    let maps = maps as u32;
    [side.saturating_mul(maps.min(2)), side.saturating_mul(maps.div_ceil(2))]
}

/// What shaders know of a sun over a box in the world.
///
/// ```text
///   right = z × s        up = s × right        s: direction to the sun
/// ```
///
/// The map covers the box along each axis as it is seen from the sun, so that one low above the horizon has as many
/// rows for a short shadow as for a long one.
fn shape(sun: &Sun, [min, max]: [[f64; 3]; 2], origin: Vec3) -> SunShape {
    let s = sun.direction.to_array();
    let horizontal = [-s[1], s[0], 0.0];
    let right = if horizontal == [0.0; 3] { [0.0, -1.0, 0.0] } else { normalized(horizontal) };
    let axes = [right, cross(s, right), s];
    let half = scale(sub(max, min), 0.5);
    let middle = add(min, half);
    let largest =
        [half, sub(middle, origin)].concat().into_iter().fold(f64::MIN_POSITIVE.sqrt(), |a, b| a.max(b.abs()));
    let extent = |axis: Vec3| dot(axis.map(f64::abs), half).max(LEAST_EXTENT * largest) * (1.0 + LEAST_EXTENT);
    let [right, up, towards] = axes.map(|axis| {
        let [x, y, z] = axis.map(|c| c as f32);
        [x, y, z, extent(axis) as f32]
    });
    let (sine, cosine) = (0.5 * sun.angular_diameter).sin_cos();
    let [x, y, z] = sub(middle, origin).map(|c| c as f32);
    let [r, g, b] = sun.irradiance.to_array().map(|c| c as f32);
    SunShape {
        right,
        up,
        towards,
        // A disc of a half sphere and more is as one that is a little less.
        middle: [x, y, z, (sine / cosine.max(LEAST_EXTENT)) as f32],
        irradiance: [r, g, b, sine as f32],
        ..SunShape::zeroed()
    }
}
