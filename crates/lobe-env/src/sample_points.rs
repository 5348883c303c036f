//! Where a map is looked at for each texel of another.

use std::f64::consts::{FRAC_1_PI, PI};
use std::ops::Range;

use lobe_sh::{Dir, Rotation};

use crate::atan::quick_atan2;
use crate::taps::Grid;
use crate::{Mapping, cube};

/// How far samples are apart, in source texels.
const SPACING: f64 = 1.0;
/// The least density, in parts of the mean one, for which samples are set closer.
const THINNEST: f64 = 1.0 / 64.0;
/// So many texels side by side share parabolas.
const RUN: usize = 16;
/// How far samples may lie beside their place, in texels of the source, and be off in weight, in parts of it.
const OFF_PARABOLA: f64 = 0.005;
/// The fewest samples along a side of a texel.
const LEAST: usize = 2;

/// A point of the source.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// In texels of the source from the upper left corner, always inside the picture and on the right face or disc.
    x: f32,
    y: f32,
    /// The solid angle for which it stands.
    pub(crate) weight: f32,
}

impl Sample {
    #[inline(always)]
    fn new([x, y]: [f64; 2], weight: f64, limits: &Limits) -> Self {
        let held = |c: f64, [least, most]: [f32; 2]| (c as f32).max(least).min(most);
        Self { x: held(x, limits.x), y: held(y, limits.y), weight: weight as f32 }
    }

    #[inline(always)]
    pub(crate) fn xy(&self) -> [f32; 2] {
        [self.x, self.y]
    }

    #[inline(always)]
    pub(crate) fn point(&self) -> [f64; 2] {
        [f64::from(self.x), f64::from(self.y)]
    }
}

/// The part of the source's picture that a sample may lie in.
#[derive(Clone, Copy, Debug)]
struct Limits {
    x: [f32; 2],
    y: [f32; 2],
}

/// Where the samples of a row lie in the source, and their weights: `a + b t + c t²`, `t` from 0 to 1.
#[derive(Clone, Copy, Debug)]
struct Parabolas {
    a: [f64; 3],
    b: [f64; 3],
    c: [f64; 3],
    limits: Limits,
}

impl Parabolas {
    /// Through the values at 0, 1/2 and 1.
    fn through(start: [f64; 3], middle: [f64; 3], end: [f64; 3], limits: Limits) -> Self {
        let b = [0, 1, 2].map(|k| 4.0 * middle[k] - 3.0 * start[k] - end[k]);
        let c = [0, 1, 2].map(|k| 2.0 * (start[k] - 2.0 * middle[k] + end[k]));
        Self { a: start, b, c, limits }
    }

    #[inline(always)]
    fn at(&self, t: f64) -> [f64; 3] {
        [0, 1, 2].map(|k| self.a[k] + t * (self.b[k] + t * self.c[k]))
    }

    /// The `n` samples of texel `i` of the run.
    #[inline(always)]
    fn add_texel(&self, i: usize, n: usize, samples: &mut Vec<Sample>) {
        let step = 1.0 / (RUN * n - 1) as f64;
        samples.extend((i * n..(i + 1) * n).map(|k| {
            let [x, y, weight] = self.at(k as f64 * step);
            Sample::new([x, y], weight, &self.limits)
        }));
    }
}

/// The samples of consecutive texels of the target.
pub(crate) struct Chunk {
    first: usize,
    parts: Vec<Part>,
    /// Those of all runs, one after the other: a tenth of the memory of their samples.
    rows: Vec<Parabolas>,
    /// Those of all single texels.
    samples: Vec<Sample>,
}

/// The next of a chunk's texels.
#[derive(Clone, Copy, Debug)]
enum Part {
    /// [`RUN`] texels of so many cells each: columns and rows.
    Run([u32; 2]),
    /// A texel of so many samples.
    Single(u32),
}

impl Chunk {
    /// Calls `texel(number, samples)` for every texel.
    pub(crate) fn for_each(&self, mut texel: impl FnMut(usize, &[Sample])) {
        let (mut rows, mut samples) = (self.rows.as_slice(), self.samples.as_slice());
        let (mut index, mut cells) = (self.first, Vec::new());
        for part in &self.parts {
            match *part {
                Part::Run([nx, ny]) => {
                    let (own, rest) = rows.split_at(ny as usize);
                    for i in 0..RUN {
                        cells.clear();
                        own.iter().for_each(|row| row.add_texel(i, nx as usize, &mut cells));
                        texel(index + i, &cells);
                    }
                    (rows, index) = (rest, index + RUN);
                }
                Part::Single(count) => {
                    let (own, rest) = samples.split_at(count as usize);
                    texel(index, own);
                    (samples, index) = (rest, index + 1);
                }
            }
        }
    }
}

/// A source and a target, and how the surroundings are turned between them.
pub(crate) struct Sampler {
    pub(crate) source: Grid,
    pub(crate) target: Grid,
    /// What becomes of the axes on the way from the target to the source.
    turn: Option<[[f64; 3]; 3]>,
    /// And back.
    turn_back: Option<[[f64; 3]; 3]>,
    /// Of the strips above the rows of a lat-long source, and of the one below the last.
    bends: Vec<f64>,
}

impl Sampler {
    pub(crate) fn new(source: Grid, target: Grid, rotation: Option<&Rotation>) -> Self {
        let axes = |r: &Rotation| [Dir::X, Dir::Y, Dir::Z].map(|axis| r.rotate_dir(axis).to_array());
        let turn = rotation.map(|r| axes(&r.inverse()));
        let factor = source.cotangent_factor();
        let bends = (0..source.height + 2).map(|y| factor * source.cotangent(y as f64 - 1.0)).collect();
        Self { source, target, turn, turn_back: rotation.map(axes), bends }
    }

    /// The direction in the source of a direction in the target.
    #[inline]
    pub(crate) fn to_source(&self, s: Dir) -> Dir {
        turned(self.turn.as_ref(), s)
    }

    /// The direction in the target of a direction in the source.
    pub(crate) fn to_target(&self, s: Dir) -> Dir {
        turned(self.turn_back.as_ref(), s)
    }

    /// About how many samples all texels have together.
    pub(crate) fn estimate(&self) -> usize {
        (LEAST * LEAST * self.target.len()).max((self.source.len() as f64 / (SPACING * SPACING)) as usize)
    }

    /// The samples of some texels.
    pub(crate) fn chunk(&self, texels: Range<usize>) -> Chunk {
        let mut chunk = Chunk { first: texels.start, parts: Vec::new(), rows: Vec::new(), samples: Vec::new() };
        let mut nodes = Vec::new();
        let mut index = texels.start;
        while index < texels.end {
            let texel = [index % self.target.width, index / self.target.width];
            let is_run = texel[0] + RUN <= self.target.width && index + RUN <= texels.end;
            let is_whole = |x: usize| !self.is_on_rim([x, texel[1]]);
            if is_run
                && is_whole(texel[0])
                && is_whole(texel[0] + RUN - 1)
                && let Some(cells) = self.add_run(texel, &mut chunk.rows)
            {
                chunk.parts.push(Part::Run(cells.map(|n| n as u32)));
                index += RUN;
                continue;
            }
            let before = chunk.samples.len();
            if self.is_on_rim(texel) {
                self.add_nodes(texel, &mut nodes, &mut chunk.samples);
            } else {
                self.add_grid(texel, &mut chunk.samples);
            }
            chunk.parts.push(Part::Single((chunk.samples.len() - before) as u32));
            index += 1;
        }
        chunk.parts.shrink_to_fit();
        chunk.rows.shrink_to_fit();
        chunk.samples.shrink_to_fit();
        chunk
    }

    /// A grid of cells for each of [`RUN`] texels side by side, on parabolas through three cells of each row; how many
    /// columns and rows of cells a texel has, or nothing where a fourth cell does not lie on them: at seams and poles.
    fn add_run(&self, [x, y]: [usize; 2], rows: &mut Vec<Parabolas>) -> Option<[usize; 2]> {
        let Grid { mapping, width, height } = self.target;
        let (centre, lengths) = axes(self.target, [x + RUN / 2, y])?;
        let spacing = SPACING * self.source_pitch(centre);
        let [nx, ny] = lengths.map(|length| ((length / spacing).ceil() as usize).max(LEAST));
        let area = 1.0 / (nx * ny * width * height) as f64;
        let (first, length) = (x as f64 + 0.5 / nx as f64, RUN as f64 - 1.0 / nx as f64);
        let before = rows.len();
        for j in 0..ny {
            let v = (y as f64 + (j as f64 + 0.5) / ny as f64) / height as f64;
            let look = |t: f64| {
                let s = mapping.dir_from_uv((first + t * length) / width as f64, v)?;
                let [x, y] = self.source_point(self.to_source(s));
                Some([x, y, area * mapping.density_towards(s)])
            };
            let (Some(a), Some(b), Some(c), Some(check)) = (look(0.0), look(0.5), look(1.0), look(0.25)) else {
                rows.truncate(before);
                return None;
            };
            let row = Parabolas::through(a, b, c, self.limits([b[0], b[1]]));
            let found = row.at(0.25);
            let is_near = |k: usize, most: f64| (found[k] - check[k]).abs() < most;
            if !(is_near(0, OFF_PARABOLA) && is_near(1, OFF_PARABOLA) && is_near(2, OFF_PARABOLA * check[2])) {
                rows.truncate(before);
                return None;
            }
            rows.push(row);
        }
        Some([nx, ny])
    }

    /// A grid of cells, each looked at in its middle.
    fn add_grid(&self, [x, y]: [usize; 2], samples: &mut Vec<Sample>) {
        let Grid { mapping, width, height } = self.target;
        let (w, h) = (1.0 / width as f64, 1.0 / height as f64);
        let Some((centre, lengths)) = axes(self.target, [x, y]) else { return };
        let spacing = SPACING * self.source_pitch(centre);
        let [nx, ny] = lengths.map(|length| ((length / spacing).ceil() as usize).max(LEAST));
        let (sx, sy) = (1.0 / nx as f64, 1.0 / ny as f64);
        let area = sx * sy * w * h;
        for j in 0..ny {
            let v = (y as f64 + (j as f64 + 0.5) * sy) * h;
            for i in 0..nx {
                let u = (x as f64 + (i as f64 + 0.5) * sx) * w;
                if let Some(s) = mapping.dir_from_uv(u, v) {
                    samples.push(self.sample(s, area * mapping.density_towards(s)));
                }
            }
        }
    }

    /// A texel that shows the rim of a disc: samples in the part that shows something, more of them along the radius,
    /// where a ball's texels are long.
    fn add_nodes(&self, texel: [usize; 2], nodes: &mut Vec<(Dir, f64)>, samples: &mut Vec<Sample>) {
        let Grid { mapping, width, height } = self.target;
        let few = midpoints(LEAST);
        crate::texel::nodes_into(mapping, [width, height], texel, &few, nodes);
        let Some((first, _)) = nodes.first() else { return };
        // The nodes lie half a cell from the ends: the texel reaches twice as far as they do.
        let reach = nodes.iter().map(|(s, _)| s.angle_to(*first)).fold(0.0, f64::max) * LEAST as f64;
        let spacing = SPACING * nodes.iter().map(|(s, _)| self.source_pitch(*s)).fold(PI, f64::min);
        let across = nodes.iter().map(|(_, weight)| weight).sum::<f64>() / reach.max(spacing);
        // The corners of a texel part it in two or more pieces.
        let [n_across, n_along] = [0.5 * across, reach].map(|length| ((length / spacing).ceil() as usize).max(LEAST));
        let rules = [midpoints(n_across), midpoints(n_along)];
        crate::texel::nodes_of_rules_into(mapping, [width, height], texel, [&rules[0], &rules[1]], nodes);
        samples.extend(nodes.iter().map(|(s, weight)| self.sample(*s, *weight)));
    }

    #[inline]
    fn sample(&self, s: Dir, weight: f64) -> Sample {
        let p = self.source_point(self.to_source(s));
        Sample::new(p, weight, &self.limits(p))
    }

    /// The root of the solid angle of a texel of the source.
    #[inline]
    fn source_pitch(&self, s: Dir) -> f64 {
        let density = self.source.mapping.density_towards(self.to_source(s)).max(4.0 * PI * THINNEST);
        (density / self.source.len() as f64).sqrt()
    }

    #[inline]
    fn source_point(&self, s: Dir) -> [f64; 2] {
        let Grid { mapping, width, height } = self.source;
        if mapping != Mapping::LatLong {
            return self.source.point(s);
        }
        let (x, y) = (s.x(), s.y());
        let u = 0.5 - 0.5 * FRAC_1_PI * quick_atan2(y, x);
        let v = FRAC_1_PI * quick_atan2((x * x + y * y).sqrt(), s.z());
        let row = v * height as f64;
        [u * width as f64, self.source.fair_row(row, self.bends[(row + 0.5) as usize])]
    }

    /// The least and the largest coordinates of the face or disc of the source that shows a point: rounding must not
    /// lead to the next one.
    #[inline]
    fn limits(&self, p: [f64; 2]) -> Limits {
        let Grid { mapping, width, height } = self.source;
        let (mut x, mut y) = ([0.0, width as f32], [0.0, height as f32]);
        match mapping {
            Mapping::Cube => {
                let face = ((p[1] / width as f64) as usize).min(cube::FACES - 1);
                y = [(face * width) as f32, (((face + 1) * width) as f32).next_down()];
            }
            Mapping::DualParaboloid => {
                let middle = 0.5 * width as f32;
                x = if p[0] < f64::from(middle) { [0.0, middle.next_down()] } else { [middle, x[1]] };
            }
            _ => {}
        }
        Limits { x, y }
    }

    /// Whether a part of the texel shows nothing, or it lies on two discs.
    fn is_on_rim(&self, [x, y]: [usize; 2]) -> bool {
        let Grid { mapping, width, height } = self.target;
        let discs = match mapping {
            Mapping::Sphere | Mapping::MirrorBall | Mapping::Angular => 1,
            Mapping::DualParaboloid => 2,
            _ => return false,
        };
        // Twice the distance from the centre of the disc, in texels.
        let disc = discs * x / width;
        let across = |x: usize| (discs * 2 * x) as f64 / width as f64 - (2 * disc + 1) as f64;
        let down = |y: usize| (2 * y) as f64 / height as f64 - 1.0;
        let far = |[a, b]: [f64; 2]| a.abs().max(b.abs());
        discs * (x + 1) > (disc + 1) * width
            || far([across(x), across(x + 1)]).hypot(far([down(y), down(y + 1)])) >= 1.0
    }
}

/// The direction of the centre of a texel that shows something everywhere, and about how long its two axes are, in
/// radians.
#[inline]
pub(crate) fn axes(grid: Grid, [x, y]: [usize; 2]) -> Option<(Dir, [f64; 2])> {
    let Grid { mapping, width, height } = grid;
    let (w, h) = (1.0 / width as f64, 1.0 / height as f64);
    let (u, v) = ((x as f64 + 0.5) * w, (y as f64 + 0.5) * h);
    let centre = mapping.dir_from_uv(u, v)?;
    let lengths = match mapping {
        Mapping::LatLong => [2.0 * PI * w * centre.x().hypot(centre.y()), PI * h],
        Mapping::Cube => {
            // Moving along an axis by da turns the direction by da √(1 + b²)/(1 + a² + b²), at most da/√(1 + a² + b²).
            let [x, y, z] = centre.to_array().map(f64::abs);
            [2.0 * w * x.max(y).max(z); 2]
        }
        _ => {
            // Nearly from edge to edge: the middles of the edges may lie on a fold.
            let across = |du: f64, dv: f64| {
                let (a, b) = (mapping.dir_from_uv(u - du, v - dv), mapping.dir_from_uv(u + du, v + dv));
                a.zip(b).map_or(PI, |(a, b)| a.angle_to(b))
            };
            [across(0.499 * w, 0.0), across(0.0, 0.499 * h)]
        }
    };
    Some((centre, lengths))
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

    #[test]
    fn samples_on_parabolas_lie_where_they_belong() {
        const STEP: usize = 97;
        for (from, to) in [(Mapping::LatLong, Mapping::Cube), (Mapping::Cube, Mapping::LatLong)] {
            let (source, target) =
                (Grid::new(from, 960, from.height_for(960)), Grid::new(to, 1536, to.height_for(1536)));
            let sampler = Sampler::new(source, target, None);
            let mut runs = 0;
            for index in (0..target.len()).step_by(RUN * STEP) {
                let [x, y] = [index % target.width, index / target.width];
                let mut rows = Vec::new();
                let Some([nx, ny]) = sampler.add_run([x, y], &mut rows) else { continue };
                runs += 1;
                let mut samples = Vec::new();
                (0..RUN).for_each(|i| rows.iter().for_each(|row| row.add_texel(i, nx, &mut samples)));
                for (k, sample) in samples.iter().enumerate() {
                    let (texel, cell) = (k / (nx * ny), k % (nx * ny));
                    let u = ((x + texel) as f64 + ((cell % nx) as f64 + 0.5) / nx as f64) / target.width as f64;
                    let v = (y as f64 + ((cell / nx) as f64 + 0.5) / ny as f64) / target.height as f64;
                    let [px, py] = sampler.source_point(to.dir_from_uv(u, v).unwrap());
                    let distance = (f64::from(sample.x) - px).abs().max((f64::from(sample.y) - py).abs());
                    assert!(distance < 2.0 * OFF_PARABOLA, "{from} to {to}, texel ({x}, {y}), sample {k}: {distance}");
                }
            }
            assert!(2 * STEP * runs * RUN > target.len(), "{from} to {to}: only {runs} runs");
        }
    }
}
