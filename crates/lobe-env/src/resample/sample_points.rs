//! Sample placement: the points of the source at which each target texel is sampled, and their weights.

use std::f64::consts::PI;
use std::ops::Range;

use lobe_sh::{Dir, Rotation};

use crate::mapping::form::bent;
use crate::mapping::grid::Grid;
use crate::resample::footprint::{Footprint, Footprints, Tile};
use crate::resample::patch::{Limits, Patch, Sample};

/// The distance of samples, in source texels.
const SPACING: f64 = 1.0;
/// The least density of source texels, relative to the mean, to which the distance of samples adapts.
const THINNEST: f64 = 1.0 / 64.0;
/// The most columns and rows of texels that share a patch.
const TILE: usize = 16;
/// A tile with fewer samples than this is sampled point by point: that is faster than a patch.
const LEAST_SAMPLES: usize = 32;
/// Where a patch interpolates, along each side of its tile.
const NODES: [f64; 3] = [0.0, 0.5, 1.0];
/// Where its error is measured: near the maxima of a cubic term.
const CHECKS: [f64; 2] = [0.25, 0.75];
/// The largest error of a patch there: of a position in heights of a source texel, of a weight relatively.
const OFF_PATCH: f64 = 0.005;
/// The fewest samples along a side of a texel.
const LEAST: usize = 2;

/// The samples of consecutive rows of the target.
#[derive(Default)]
pub(crate) struct Chunk {
    patches: Vec<Patch>,
    /// The texels without a patch, and the number of samples of each.
    singles: Vec<([u32; 2], u32)>,
    /// The samples of `singles`.
    samples: Vec<Sample>,
}

impl Chunk {
    /// Calls `each` for every texel of the wanted tiles, or for whole patches that have a window and may be seen
    /// through it. The order does not matter.
    #[inline(always)]
    pub(crate) fn for_each(
        &self,
        source: Grid,
        wants: impl Fn(Tile) -> bool,
        opens: impl Fn(Tile) -> bool,
        mut each: impl FnMut(Sampled<'_>),
    ) {
        for patch in &self.patches {
            match patch.window() {
                Some(window) if opens(patch.tile()) => each(Sampled::Patch(patch, window)),
                _ => patch.for_each_texel(source, &wants, |place, view| each(Sampled::Texel(place, view))),
            }
        }
        let (mut samples, mut views) = (self.samples.as_slice(), Footprints::default());
        for &(place, count) in &self.singles {
            let (own, rest) = samples.split_at(count as usize);
            samples = rest;
            let place = place.map(|n| n as usize);
            if wants(Tile::of_texel(place)) {
                views.clear();
                own.iter().for_each(|sample| sample.look(source, &mut views));
                each(Sampled::Texel(place, views.all()));
            }
        }
    }
}

/// Footprints of a part of the target.
pub(crate) enum Sampled<'a> {
    /// The footprint of the texel at a place in the picture.
    Texel([usize; 2], Footprint<'a>),
    /// The footprints of all texels of a patch, within a window onto the source.
    Patch(&'a Patch, Tile),
}

/// Source and target grids, and the rotation between them.
pub(crate) struct Sampler {
    pub(crate) source: Grid,
    pub(crate) target: Grid,
    /// The matrix from target to source directions.
    turn: Option<[[f64; 3]; 3]>,
    /// Its inverse.
    turn_back: Option<[[f64; 3]; 3]>,
    /// The bends of the strips above the rows of the source, and of the one below the last.
    bends: Vec<f64>,
}

impl Sampler {
    pub(crate) fn new(source: Grid, target: Grid, rotation: Option<&Rotation>) -> Self {
        let axes = |r: &Rotation| [Dir::X, Dir::Y, Dir::Z].map(|axis| r.rotate_dir(axis).to_array());
        let turn = rotation.map(|r| axes(&r.inverse()));
        let form = source.mapping.form();
        let bends = (0..source.height + 2).map(|y| form.bend(source.height, y as f64 - 1.0)).collect();
        Self { source, target, turn, turn_back: rotation.map(axes), bends }
    }

    /// The source direction of a target direction.
    #[inline]
    pub(crate) fn to_source(&self, s: Dir) -> Dir {
        turned(self.turn.as_ref(), s)
    }

    /// The target direction of a source direction.
    pub(crate) fn to_target(&self, s: Dir) -> Dir {
        turned(self.turn_back.as_ref(), s)
    }

    /// An estimate of the number of samples of all texels.
    pub(crate) fn estimate(&self) -> usize {
        (LEAST * LEAST * self.target.len()).max((self.source.len() as f64 / (SPACING * SPACING)) as usize)
    }

    /// The samples of some rows.
    pub(crate) fn chunk(&self, rows: Range<usize>) -> Chunk {
        let width = self.target.width;
        let (mut chunk, mut nodes) = (Chunk::default(), Vec::new());
        for y in rows.clone().step_by(TILE) {
            for x in (0..width).step_by(TILE) {
                let tile = Tile { x, y, width: TILE.min(width - x), height: TILE.min(rows.end - y) };
                self.add_tile(tile, &mut chunk, &mut nodes);
            }
        }
        chunk
    }

    /// Adds one patch; else patches for the quarters of the tile; else, at seams, poles and rims, single texels.
    fn add_tile(&self, tile: Tile, chunk: &mut Chunk, nodes: &mut Vec<(Dir, f64)>) {
        let cells = self.cells_of_tile(tile);
        if let Some([nx, ny]) = cells
            && nx * ny * tile.len() >= LEAST_SAMPLES
            && let Some(patch) = self.patch(tile, [nx, ny])
        {
            chunk.patches.push(patch);
        } else if tile.len() > 1 && cells.is_none_or(|[nx, ny]| nx * ny * tile.len() >= LEAST_SAMPLES) {
            tile.quarters().for_each(|quarter| self.add_tile(quarter, chunk, nodes));
        } else {
            for texel in (0..tile.len()).map(|i| [tile.x + i % tile.width, tile.y + i / tile.width]) {
                let before = chunk.samples.len();
                if self.is_on_rim(texel) {
                    self.add_nodes(texel, nodes, &mut chunk.samples);
                } else {
                    self.add_grid(texel, &mut chunk.samples);
                }
                chunk.singles.push((texel.map(|n| n as u32), (chunk.samples.len() - before) as u32));
            }
        }
    }

    /// Columns and rows of samples in each texel of a tile; `None` if one of its landmarks lies on a rim.
    fn cells_of_tile(&self, tile: Tile) -> Option<[usize; 2]> {
        tile.landmarks().into_iter().try_fold([0, 0], |[nx, ny], texel| {
            let [x, y] = if self.is_on_rim(texel) { None } else { self.cells(texel) }?;
            Some([nx.max(x), ny.max(y)])
        })
    }

    /// The patch through nine samples of a tile, with a grid of samples in each texel; `None` if four other samples are
    /// farther from it than allowed.
    fn patch(&self, tile: Tile, [nx, ny]: [usize; 2]) -> Option<Patch> {
        let Grid { mapping, width, height } = self.target;
        let form = mapping.form();
        let area = 1.0 / (nx * ny * width * height) as f64;
        let along = |start: usize, length: usize, n: usize, t: f64| {
            let cell = 1.0 / n as f64;
            start as f64 + 0.5 * cell + t * (length as f64 - cell)
        };
        let look = |t: f64, v: f64| {
            let (x, y) = (along(tile.x, tile.width, nx, t), along(tile.y, tile.height, ny, v));
            let s = form.dir_from_uv(x / width as f64, y / height as f64)?;
            let [x, y] = self.source_point(self.to_source(s));
            Some([x, y, area * form.density_towards(s)])
        };
        // Sample the tile at three times three nodes.
        let mut values = [[[0.0; 3]; 3]; 3];
        for (values, v) in values.iter_mut().zip(NODES) {
            for (value, t) in values.iter_mut().zip(NODES) {
                *value = look(t, v)?;
            }
        }
        // Interpolate them.
        let [x, y, _] = values[1][1];
        let patch = Patch::through(tile, [nx, ny], values, self.source, self.limits([x, y]));
        let aside = OFF_PATCH * self.source.mapping.form().texels_across(self.source.height, y);
        // Compare the patch with samples between the nodes.
        for (t, v) in CHECKS.into_iter().flat_map(|v| CHECKS.map(|t| (t, v))) {
            let (found, expected) = (patch.at(t, v), look(t, v)?);
            let is_near = |k: usize, most: f64| (found[k] - expected[k]).abs() < most;
            if !(is_near(0, aside) && is_near(1, OFF_PATCH) && is_near(2, OFF_PATCH * expected[2])) {
                return None;
            }
        }
        Some(patch)
    }

    /// Columns and rows of samples of a texel that no rim cuts.
    fn cells(&self, texel: [usize; 2]) -> Option<[usize; 2]> {
        let (center, lengths) = axes(self.target, texel)?;
        let spacing = SPACING * self.source_pitch(center);
        Some(lengths.map(|length| ((length / spacing).ceil() as usize).max(LEAST)))
    }

    /// Adds a grid of samples, each in the middle of its cell.
    fn add_grid(&self, [x, y]: [usize; 2], samples: &mut Vec<Sample>) {
        let Grid { mapping, width, height } = self.target;
        let form = mapping.form();
        let (w, h) = (1.0 / width as f64, 1.0 / height as f64);
        let Some([nx, ny]) = self.cells([x, y]) else { return };
        let (sx, sy) = (1.0 / nx as f64, 1.0 / ny as f64);
        let area = sx * sy * w * h;
        for j in 0..ny {
            let v = (y as f64 + (j as f64 + 0.5) * sy) * h;
            for i in 0..nx {
                let u = (x as f64 + (i as f64 + 0.5) * sx) * w;
                if let Some(s) = form.dir_from_uv(u, v) {
                    samples.push(self.sample(s, area * form.density_towards(s)));
                }
            }
        }
    }

    /// Adds samples of a texel that the rim of a disc cuts: in the part inside the disc, more of them along the radius,
    /// where the texels of a ball are long.
    fn add_nodes(&self, texel: [usize; 2], nodes: &mut Vec<(Dir, f64)>, samples: &mut Vec<Sample>) {
        let Grid { mapping, width, height } = self.target;
        // Measure the texel with few nodes.
        let few = midpoints(LEAST);
        crate::mapping::texel_quadrature::nodes_into(mapping, [width, height], texel, &few, nodes);
        let Some((first, _)) = nodes.first() else { return };
        // The nodes lie half a cell from the ends: the texel reaches twice as far as they do.
        let reach = nodes.iter().map(|(s, _)| s.angle_to(*first)).fold(0.0, f64::max) * LEAST as f64;
        let spacing = SPACING * nodes.iter().map(|(s, _)| self.source_pitch(*s)).fold(PI, f64::min);
        let across = nodes.iter().map(|(_, weight)| weight).sum::<f64>() / reach.max(spacing);
        // The corners divide a texel into two or more pieces.
        let [n_across, n_along] = [0.5 * across, reach].map(|length| ((length / spacing).ceil() as usize).max(LEAST));
        let rules = [midpoints(n_across), midpoints(n_along)];
        crate::mapping::texel_quadrature::nodes_of_rules_into(
            mapping,
            [width, height],
            texel,
            [&rules[0], &rules[1]],
            nodes,
        );
        // Sample the source at the nodes of rules as fine as its texels.
        samples.extend(nodes.iter().map(|(s, weight)| self.sample(*s, *weight)));
    }

    #[inline]
    fn sample(&self, s: Dir, weight: f64) -> Sample {
        let p = self.source_point(self.to_source(s));
        Sample::new([p[0], p[1], weight], &self.limits(p))
    }

    /// The square root of the solid angle of a source texel.
    #[inline]
    fn source_pitch(&self, s: Dir) -> f64 {
        let density = self.source.mapping.form().density_towards(self.to_source(s)).max(4.0 * PI * THINNEST);
        (density / self.source.len() as f64).sqrt()
    }

    #[inline]
    fn source_point(&self, s: Dir) -> [f64; 2] {
        let [x, y] = self.source.mapping.form().fast_point(self.source.size(), s);
        [x, bent(y, self.bends[(y + 0.5) as usize])]
    }

    /// The range of coordinates of the face or disc of the source that contains a point: rounding must not lead to the
    /// next one.
    #[inline]
    fn limits(&self, p: [f64; 2]) -> Limits {
        let [x, y] = self.source.mapping.form().limits(self.source.size(), p);
        Limits { x, y }
    }

    /// Whether the texel lies partly outside the discs, or on two of them.
    fn is_on_rim(&self, [x, y]: [usize; 2]) -> bool {
        let Grid { mapping, width, height } = self.target;
        let discs = mapping.form().discs();
        if discs == 0 {
            return false;
        }
        // Twice the distance from the center of the disc, in texels.
        let disc = discs * x / width;
        let across = |x: usize| (discs * 2 * x) as f64 / width as f64 - (2 * disc + 1) as f64;
        let down = |y: usize| (2 * y) as f64 / height as f64 - 1.0;
        let far = |[a, b]: [f64; 2]| a.abs().max(b.abs());
        discs * (x + 1) > (disc + 1) * width
            || far([across(x), across(x + 1)]).hypot(far([down(y), down(y + 1)])) >= 1.0
    }
}

/// The direction of the center of a texel that no rim cuts, and the approximate lengths of its two axes in radians.
#[inline]
pub(crate) fn axes(grid: Grid, [x, y]: [usize; 2]) -> Option<(Dir, [f64; 2])> {
    let form = grid.mapping.form();
    let (w, h) = (1.0 / grid.width as f64, 1.0 / grid.height as f64);
    let [u, v] = [(x as f64 + 0.5) * w, (y as f64 + 0.5) * h];
    let center = form.dir_from_uv(u, v)?;
    Some((center, form.lengths(grid.size(), [u, v], center)))
}

#[inline]
fn turned(turn: Option<&[[f64; 3]; 3]>, s: Dir) -> Dir {
    let Some([a, b, c]) = turn else { return s };
    Dir::from_unit([0, 1, 2].map(|k| s.x() * a[k] + s.y() * b[k] + s.z() * c[k]))
}

/// The midpoint rule on `[-1, 1]`.
pub(crate) fn midpoints(n: usize) -> Vec<(f64, f64)> {
    (0..n).map(|i| ((2 * i + 1) as f64 / n as f64 - 1.0, 2.0 / n as f64)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::mapping::Mapping;

    #[test]
    fn samples_of_patches_lie_where_they_belong() {
        const STEP: usize = 7;
        for (from, to) in [(Mapping::LatLong, Mapping::Cube), (Mapping::Cube, Mapping::LatLong)] {
            let (source, target) =
                (Grid::new(from, 960, from.height_for(960)), Grid::new(to, 1536, to.height_for(1536)));
            let sampler = Sampler::new(source, target, None);
            let tiles = (target.width / TILE) * (target.height / TILE);
            let (mut patches, mut windows, mut looked) = (0, 0, 0);
            for k in (0..tiles).step_by(STEP) {
                looked += 1;
                let (x, y) = (k % (target.width / TILE) * TILE, k / (target.width / TILE) * TILE);
                let tile = Tile { x, y, width: TILE, height: TILE };
                let cells = sampler.cells_of_tile(tile).unwrap();
                let Some(patch) = sampler.patch(tile, cells) else { continue };
                patches += 1;
                if let Some(window) = patch.window() {
                    windows += 1;
                    patch.for_each_texel_in(window, &mut Vec::new(), |place, quads| {
                        for first in quads.iter().map(|quad| quad.first as usize) {
                            let (column, row) = (first % window.width, first / window.width);
                            let is_inside = column + 1 < window.width && row + 1 < window.height;
                            assert!(is_inside, "{from} to {to}, texel {place:?}: ({column}, {row}) in {window:?}");
                        }
                    });
                }
                let [nx, ny] = cells;
                for (i, j) in (0..TILE * TILE).map(|k| (k % TILE, k / TILE)) {
                    let mut k = 0;
                    patch.for_each_sample([i, j], |sample| {
                        let u = ((x + i) as f64 + ((k % nx) as f64 + 0.5) / nx as f64) / target.width as f64;
                        let v = ((y + j) as f64 + ((k / nx) as f64 + 0.5) / ny as f64) / target.height as f64;
                        let (p, found) = (sampler.source_point(to.dir_from_uv(u, v).unwrap()), sample.point());
                        let across = source.mapping.form().texels_across(source.height, p[1]);
                        let distance = ((found[0] - p[0]) / across).abs().max((found[1] - p[1]).abs());
                        let place = (x + i, y + j);
                        assert!(distance < 2.0 * OFF_PATCH, "{from} to {to}, texel {place:?}, sample {k}: {distance}");
                        k += 1;
                    });
                }
            }
            assert!(2 * patches > looked, "{from} to {to}: only {patches} patches of {looked} tiles");
            assert!(10 * windows > 9 * patches, "{from} to {to}: only {windows} windows for {patches} patches");
        }
    }
}
