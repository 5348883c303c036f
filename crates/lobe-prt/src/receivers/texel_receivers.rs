//! Texel receivers: conservative rasterization of a scene into the texels of a lightmap.

use std::collections::VecDeque;
use std::ops::Range;
use std::path::Path;

use glam::{DVec2, DVec3};
use lobe_io::IoError;
use lobe_scene::{Hit, Scene};

use crate::error::PrtError;
use crate::receivers::beyond_walls::{Picture, Shown, moved_points};
use crate::receivers::charts::charts;
use crate::receivers::inset::{inset_distance, step, wide};
use crate::receivers::planes::Planes;
use crate::receivers::receivers::Receivers;
use crate::receivers::texel_rows::TexelRows;
use crate::transfer::transfer::Transfer;
use crate::transfer::transfer_rows::TransferRows;

/// The widest lightmap.
const MOST_TEXELS: usize = 1 << 14;

/// A center lies within a triangle if it is so far from its edges, in texels: more than what rounding moves the texture
/// coordinates of an edge. No center lies within two triangles.
const OVERLAP: f64 = 0.01;

/// Triangles this near to the center of a texel may show in it: half the diagonal.
const REACH: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The largest distance of texture coordinates from the unit square: rounding.
const OUTSIDE: f32 = 1e-4;

/// Receivers at the texels of a square picture that the triangles of a scene are unfolded into.
///
/// A texel whose center is in a triangle takes that place; one that only touches triangles takes the nearest place of
/// the nearest, so that a picture shown between texels is right up to the seams. All meshes share the picture, in their
/// texture coordinates of set 1, or of set 0 where they have no set 1.
///
/// A floor that goes on behind a wall brings no light through. At the border of a chart, texels whose places lie beyond
/// a wall, no farther than two texels, are moved in front of it. Farther parts stay, except for the texels next to the
/// wall: these move to the side that sees less than half as much of the sky.
///
/// Normals are those at the places of the texels, tilted by normal maps: what is finer than a texel is seen at its center alone.
#[derive(Clone, Debug, PartialEq)]
pub struct TexelReceivers {
    width: usize,
    texels: Vec<u32>,
    triangles: Vec<u32>,
    receivers: Receivers,
}

/// The place that a texel shows.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// From the center of the texel, in texels; 0 if it is inside.
    distance: f64,
    /// The depth of the center inside the triangle; 0 if it is outside.
    depth: f64,
    triangle: u32,
    u: f32,
    v: f32,
}

impl TexelReceivers {
    /// The most bytes that the texels of a picture of `width` × `width` take, while they are looked for and after.
    #[must_use]
    pub fn bytes_for(width: usize) -> u64 {
        // The place, what is known of the texel and of its receiver, and its plane.
        let receiver = size_of::<[u32; 2]>() + size_of::<[[f32; 3]; 3]>();
        let texel = size_of::<Option<Place>>() + receiver + size_of::<([u32; 2], [f32; 3])>();
        // And its depth within its chart.
        (texel as u64 + 1).saturating_mul(width as u64 * width as u64)
    }

    /// The receivers of a picture of `width` × `width` texels.
    ///
    /// # Errors
    /// [`PrtError::Options`] if the width is not 1 to 2¹⁴; [`PrtError::Invalid`] if a mesh has no texture coordinates,
    /// they leave the unit square, or the center of a texel is in two triangles.
    pub fn new(scene: &Scene, width: usize) -> Result<Self, PrtError> {
        let places = places_of(scene, width)?;
        let mut texels = Self::at(scene, width, &places)?;
        texels.move_from_beyond_walls(scene, &places);
        Ok(texels)
    }

    /// Why a scene's own texture coordinates cannot hold a lightmap of this width, if they cannot.
    ///
    /// # Errors
    /// As [`TexelReceivers::new`].
    pub fn check(scene: &Scene, width: usize) -> Result<(), PrtError> {
        places_of(scene, width).map(drop)
    }

    /// The same at the places that the unfolding gives them, beyond walls too.
    pub(crate) fn as_unfolded(scene: &Scene, width: usize) -> Result<Self, PrtError> {
        Self::at(scene, width, &places_of(scene, width)?)
    }

    /// Moves receivers that lie beyond a wall in front of it.
    fn move_from_beyond_walls(&mut self, scene: &Scene, places: &[Option<Place>]) {
        let shown = |texel: usize| {
            let Place { distance, triangle, u, v, .. } = places[texel]?;
            Some(Shown { hit: Hit { t: 0.0, triangle, u, v }, is_inside: distance == 0.0 })
        };
        let picture = Picture { width: self.width, shown: &shown, charts: &charts(scene) };
        let points = (&self.texels[..], self.receivers.positions());
        for (receiver, position) in moved_points(scene, &picture, points, inset_distance(scene)) {
            self.receivers.move_to(receiver, position);
        }
    }

    fn at(scene: &Scene, width: usize, places: &[Option<Place>]) -> Result<Self, PrtError> {
        let distance = inset_distance(scene);
        // Reserve no more memory than is needed.
        let count = places.iter().flatten().count();
        let (mut texels, mut triangles) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let [mut positions, mut normals, mut albedos] = [0; 3].map(|_| Vec::with_capacity(count));
        let mut planes = Planes::with_capacity(count);
        for (texel, place) in places.iter().enumerate() {
            let Some(Place { depth, triangle, u, v, .. }) = *place else { continue };
            let surface = scene.surface(&Hit { t: 0.0, triangle, u, v });
            let (mesh, number) = scene.locate(triangle as usize);
            let middle = scene.meshes()[mesh].corners(number).map(wide).iter().sum::<DVec3>() / 3.0;
            let position = wide(surface.position);
            texels.push(texel as u32);
            triangles.push(triangle);
            // Move places at the edge of a triangle inwards: they may lie in a wall, as vertices may.
            let moved = if depth < OVERLAP { step(position, middle - position, distance) } else { surface.position };
            positions.push(moved);
            normals.push(surface.shading_normal);
            planes.push(surface.shading_normal, surface.vertex_normal, surface.geometric_normal);
            // At an edge the weight of a corner may be below zero by a rounding.
            albedos.push([0, 1, 2].map(|c| surface.base_color[c].max(0.0)));
        }
        let receivers = Receivers::new(positions, normals, albedos)?.on(planes);
        Ok(Self { width, texels, triangles, receivers })
    }

    /// Width and height of the picture in texels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// The receivers to bake, one for each texel of [`TexelReceivers::texels`].
    #[must_use]
    pub fn receivers(&self) -> &Receivers {
        &self.receivers
    }

    /// The texels that triangles touch, `y · width + x`, row 0 at the top where v is 0.
    #[must_use]
    pub fn texels(&self) -> &[u32] {
        &self.texels
    }

    /// The triangle that each of these texels shows, by its number in the scene.
    #[must_use]
    pub fn triangles(&self) -> &[u32] {
        &self.triangles
    }

    /// For every texel of the picture, row by row, the receiver it shows: its own, or that of a nearest texel that has
    /// one, counted in steps to the eight neighbors.
    #[must_use]
    pub fn dilated(&self) -> Vec<u32> {
        const NONE: u32 = u32::MAX;
        let width = self.width;
        let mut shown = vec![NONE; width * width];
        let mut queue = VecDeque::with_capacity(self.texels.len());
        for (receiver, &texel) in self.texels.iter().enumerate() {
            shown[texel as usize] = receiver as u32;
            queue.push_back(texel);
        }
        while let Some(texel) = queue.pop_front() {
            let texel = texel as usize;
            let (x, y) = (texel % width, texel / width);
            for row in y.saturating_sub(1)..(y + 2).min(width) {
                for column in x.saturating_sub(1)..(x + 2).min(width) {
                    let next = row * width + column;
                    if shown[next] == NONE {
                        shown[next] = shown[texel];
                        queue.push_back(next as u32);
                    }
                }
            }
        }
        shown
    }

    /// The transfer of every texel of the picture, row by row, from that of the receivers, which it is read from.
    ///
    /// # Errors
    /// [`PrtError::Invalid`] if the transfer is of another number of receivers.
    pub fn rows<'a>(&self, transfer: &'a dyn TransferRows) -> Result<TexelRows<'a>, PrtError> {
        self.expect_receivers(transfer.receivers())?;
        Ok(TexelRows::new(self.dilated(), transfer))
    }

    /// Refuses transfer of another number of receivers.
    pub(crate) fn expect_receivers(&self, found: usize) -> Result<(), PrtError> {
        let expected = self.receivers.len();
        if expected == found {
            return Ok(());
        }
        Err(PrtError::invalid("lightmap", format!("expected transfer of {expected} texels, found {found}")))
    }

    /// [`TexelReceivers::rows`], all of them in memory.
    ///
    /// # Errors
    /// As there.
    pub fn picture(&self, transfer: &Transfer) -> Result<Transfer, PrtError> {
        let rows = self.rows(transfer)?;
        let mut coefficients = vec![0.0; rows.receivers() * rows.row_len()];
        let read = rows.read_rows(0, &mut coefficients);
        read.map_err(|source| IoError::io(Path::new("lightmap"), source))?;
        Transfer::new(transfer.order(), transfer.channels(), coefficients)
    }
}

/// The place that each texel shows, the nearest of all triangles.
fn places_of(scene: &Scene, width: usize) -> Result<Vec<Option<Place>>, PrtError> {
    if !(1..=MOST_TEXELS).contains(&width) {
        return Err(PrtError::Options(format!("expected a width of 1 to {MOST_TEXELS} texels, found {width}")));
    }
    // Find the nearest place of each texel, triangle by triangle.
    let mut places: Vec<Option<Place>> = vec![None; width * width];
    let mut first = 0;
    for mesh in scene.meshes() {
        let uvs = mesh.lightmap_uvs();
        let place = || format!("mesh `{}`", mesh.name());
        if uvs.is_empty() {
            let message = "it has no texture coordinates for a lightmap; unfold it into a set of its own";
            return Err(PrtError::invalid(&place(), message));
        }
        for (t, triangle) in mesh.triangles().iter().enumerate() {
            let corners = triangle.map(|i| uvs[i as usize]);
            let is_inside = |c: &f32| (-OUTSIDE..=1.0 + OUTSIDE).contains(c);
            if !corners.as_flattened().iter().all(is_inside) {
                let message = format!("expected texture coordinates in the unit square, found {corners:?}");
                return Err(PrtError::invalid(&place(), message));
            }
            draw(&mut places, width, corners, (first + t) as u32).map_err(|(x, y)| {
                let message = format!("triangles overlap in the lightmap at texel {x}, {y}; unfold them apart");
                PrtError::invalid(&place(), message)
            })?;
        }
        first += mesh.triangles().len();
    }
    Ok(places)
}

/// Gives all texels near a triangle their place on it, where they have no nearer one. An error at a texel that is
/// inside of another already.
fn draw(
    places: &mut [Option<Place>],
    width: usize,
    corners: [[f32; 2]; 3],
    triangle: u32,
) -> Result<(), (usize, usize)> {
    let corners = corners.map(|c| DVec2::from(c.map(f64::from)) * width as f64);
    for (y, columns) in rows_near(corners, width) {
        for x in columns {
            // Find the place of the triangle nearest to the center of the texel.
            let found = nearest(corners, DVec2::new(x as f64 + 0.5, y as f64 + 0.5), triangle);
            let place = &mut places[y * width + x];
            // Refuse centers that lie inside of two triangles.
            if let Some(other) = place
                && found.depth > OVERLAP
                && other.depth > OVERLAP
            {
                return Err((x, y));
            }
            // Keep the place if it is nearer, or deeper inside, than that of other triangles.
            let is_nearer = place.is_none_or(|other| (found.distance, -found.depth) < (other.distance, -other.depth));
            if found.distance <= REACH && is_nearer {
                *place = Some(found);
            }
        }
    }
    Ok(())
}

/// The rows of a picture near a triangle, each with the columns there: those within [`REACH`], and few others.
///
/// A row has its columns from the part of the triangle that is as near to it: slivers along a diagonal have as many
/// texels as they are long, whatever their box.
fn rows_near(corners: [DVec2; 3], width: usize) -> impl Iterator<Item = (usize, Range<usize>)> {
    // Centers are at halves.
    let near = move |(min, max): (f64, f64)| {
        let first = (min - REACH - 0.5).ceil().max(0.0) as usize;
        first..((max + REACH + 0.5).floor().max(0.0) as usize).min(width)
    };
    let bounds = |(a, b): (f64, f64), c: f64| (a.min(c), b.max(c));
    let rows = near(corners.iter().map(|c| c.y).fold((f64::MAX, f64::MIN), bounds));
    rows.map(move |y| {
        let (top, bottom) = (y as f64 + 0.5 - REACH, y as f64 + 0.5 + REACH);
        let mut columns = (f64::MAX, f64::MIN);
        for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (corners[i], corners[j])) {
            if from.y.min(to.y) > bottom || from.y.max(to.y) < top {
                continue;
            }
            for end in [from.y, to.y].map(|c| c.clamp(top, bottom)) {
                let part = if from.y == to.y { 0.0 } else { ((end - from.y) / (to.y - from.y)).clamp(0.0, 1.0) };
                columns = bounds(columns, from.lerp(to, part).x);
            }
            if from.y == to.y {
                columns = bounds(columns, to.x);
            }
        }
        (y, near(columns))
    })
}

/// The place of a triangle that is nearest to a point.
fn nearest([a, b, c]: [DVec2; 3], point: DVec2, triangle: u32) -> Place {
    let area = (b - a).perp_dot(c - a);
    // Take the distances from the edges, positive inside: as areas they are the weights of the opposite corners.
    let edges = [(b, c), (c, a), (a, b)];
    let signed = edges.map(|(p, q)| (q - p).perp_dot(point - p) * area.signum());
    if area != 0.0 && signed.iter().all(|&s| s >= 0.0) {
        let depth = (0..3).map(|k| signed[k] / edges[k].0.distance(edges[k].1)).fold(f64::MAX, f64::min);
        let (u, v) = (signed[1] / area.abs(), signed[2] / area.abs());
        return Place { distance: 0.0, depth, triangle, u: u as f32, v: v as f32 };
    }
    let on_edge = |k: usize| {
        let (p, q) = edges[k];
        let part = ((point - p).dot(q - p) / (q - p).length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        // Edge k goes from corner k + 1 to corner k + 2.
        let mut weights = [0.0; 3];
        weights[(k + 1) % 3] = 1.0 - part;
        weights[(k + 2) % 3] = part;
        let distance = p.lerp(q, part).distance(point);
        Place { distance, depth: 0.0, triangle, u: weights[1] as f32, v: weights[2] as f32 }
    };
    [on_edge(1), on_edge(2)].into_iter().fold(on_edge(0), |best, p| if p.distance < best.distance { p } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_texels_that_a_triangle_touches_are_near_it() {
        const WIDTH: usize = 24;
        let mut random = lobe_testkit::Random::new(7);
        for number in 0..400 {
            let mut corners = [DVec2::ZERO; 3].map(|_| DVec2::new(random.unit(), random.unit()) * WIDTH as f64);
            match number % 4 {
                // Level edges, triangles without area, and points.
                1 => corners[1].y = corners[0].y,
                2 => corners[2] = corners[0].lerp(corners[1], 0.3),
                3 => corners = [corners[0]; 3],
                _ => {}
            }
            let mut is_near = [false; WIDTH * WIDTH];
            for (y, columns) in rows_near(corners, WIDTH) {
                columns.for_each(|x| is_near[y * WIDTH + x] = true);
            }
            for (texel, &is_near) in is_near.iter().enumerate() {
                let center = DVec2::new((texel % WIDTH) as f64 + 0.5, (texel / WIDTH) as f64 + 0.5);
                let distance = nearest(corners, center, 0).distance;
                assert!(is_near || distance > REACH - 1e-9, "{corners:?}: {center} is at {distance}");
            }
        }
    }

    #[test]
    fn slivers_have_as_many_texels_as_they_are_long() {
        const WIDTH: usize = 4096;
        let end = DVec2::splat(WIDTH as f64);
        for middle in [end * 0.5, end * 0.5 + DVec2::new(0.1, 0.0)] {
            let count: usize = rows_near([DVec2::ZERO, middle, end], WIDTH).map(|(_, columns)| columns.len()).sum();
            assert!(count < 5 * WIDTH, "{count} texels near a sliver by {middle}, {WIDTH} long");
        }
    }
}
