//! Seams: edges of smooth surfaces that two charts show, or one chart at two places.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use lobe_scene::{Hit, Scene};
use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};

use crate::receivers::lightmap::Lightmap;
use crate::receivers::texel_receivers::TexelReceivers;
use crate::receivers::vertex_key::vertex_key;
use crate::transfer::transfer::Transfer;

/// Places of a seam for each texel that it is long: between two that light between texels bends at is at least one.
const PLACES_PER_TEXEL: f64 = 4.0;

/// The most places of one seam: lightmaps have no more texels along a side.
const MOST_PLACES: f64 = 32768.0;

/// The end of an edge: position and normal.
type End = [[u32; 3]; 2];

/// An edge of a triangle, from the end that comes first by its key.
#[derive(Clone, Copy)]
struct Side {
    triangle: u32,
    corners: [usize; 2],
}

/// The differences of a lightmap across its seams, as weights of receivers: of each place one row.
pub(crate) struct Seams {
    edges: usize,
    /// The begin of each row, and the end of the last.
    starts: Vec<usize>,
    receivers: Vec<u32>,
    weights: Vec<f64>,
}

impl Seams {
    /// Those of a scene with its receivers.
    ///
    /// ```text
    ///   0 = Σ_k w_k(a) T_k - Σ_k w_k(b) T_k    at each place, which lies at a in one chart and at b in the other
    /// ```
    ///
    /// An edge is one of two triangles that have the positions and normals of both ends in common, and the material.
    pub(crate) fn new(scene: &Scene, texels: &TexelReceivers, lightmap: &Lightmap) -> Self {
        let pairs = pairs(scene);
        let shown = texels.dilated();
        let rows_of = |pair: &[Side; 2]| {
            let length = pair.iter().map(|side| side.length(scene)).fold(0.0, f64::max) * texels.width() as f64;
            let parts = (PLACES_PER_TEXEL * length).ceil().clamp(1.0, MOST_PLACES);
            let row = |part: f64| {
                let [a, b] = pair.map(|side| lightmap.texels_at(scene, &side.hit(part)));
                let negative = b.map(|(texel, weight)| (texel, -weight));
                let used = a.into_iter().chain(negative).filter(|&(_, weight)| weight != 0.0);
                used.map(|(texel, weight)| (shown[texel], weight)).collect::<Vec<_>>()
            };
            (0..=parts as usize).map(|k| row(k as f64 / parts)).collect::<Vec<_>>()
        };
        let found: Vec<Vec<Vec<(u32, f64)>>> = pairs.par_iter().map(rows_of).collect();
        let mut seams = Self { edges: pairs.len(), starts: vec![0], receivers: Vec::new(), weights: Vec::new() };
        for row in found.into_iter().flatten() {
            seams.receivers.extend(row.iter().map(|&(receiver, _)| receiver));
            seams.weights.extend(row.iter().map(|&(_, weight)| weight));
            seams.starts.push(seams.receivers.len());
        }
        seams
    }

    /// The number of edges.
    pub(crate) fn edges(&self) -> usize {
        self.edges
    }

    /// The receivers of each row with their weights.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (&[u32], &[f64])> {
        self.starts.windows(2).map(|ends| (&self.receivers[ends[0]..ends[1]], &self.weights[ends[0]..ends[1]]))
    }

    /// The receivers of all rows, in rising order.
    pub(crate) fn all_receivers(&self) -> Vec<u32> {
        let mut all = self.receivers.clone();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The largest difference of the constant coefficient at a place, as a part of its mean; 0 of what is black.
    pub(crate) fn largest_step(&self, transfer: &Transfer) -> f64 {
        let channels = transfer.channels().count();
        let constant = |receiver: u32, channel| f64::from(transfer.vector(receiver as usize, channel)[0]);
        let mean = mean_constant(transfer);
        let step = |(receivers, weights): (&[u32], &[f64])| {
            let of = |channel| receivers.iter().zip(weights).map(|(&r, w)| w * constant(r, channel)).sum::<f64>();
            (0..channels).map(|channel| of(channel).abs()).fold(0.0, f64::max)
        };
        let largest = self.rows().map(step).fold(0.0, f64::max);
        if mean > 0.0 { largest / mean } else { 0.0 }
    }
}

/// The mean of the constant coefficient over all receivers and channels.
pub(crate) fn mean_constant(transfer: &Transfer) -> f64 {
    let (receivers, channels) = (transfer.receivers(), transfer.channels().count());
    let of = |k: usize| f64::from(transfer.vector(k / channels, k % channels)[0]);
    (0..receivers * channels).map(of).sum::<f64>() / (receivers * channels).max(1) as f64
}

/// The two sides of each seam, by the order of triangles.
fn pairs(scene: &Scene) -> Vec<[Side; 2]> {
    let mut first_of: HashMap<(End, End, Option<usize>), Side> = HashMap::new();
    let (mut pairs, mut first) = (Vec::new(), 0);
    for mesh in scene.meshes() {
        let end = |i: u32| [mesh.positions(), mesh.normals()].map(|all| vertex_key(all[i as usize]));
        for (t, triangle) in mesh.triangles().iter().enumerate() {
            for [i, j] in [[0, 1], [1, 2], [2, 0]] {
                let (a, b) = (end(triangle[i]), end(triangle[j]));
                let side = Side { triangle: first + t as u32, corners: if a <= b { [i, j] } else { [j, i] } };
                match first_of.entry((a.min(b), a.max(b), mesh.material())) {
                    Entry::Vacant(free) => drop(free.insert(side)),
                    Entry::Occupied(other) => {
                        let pair = [*other.get(), side];
                        let [ours, theirs] = pair.map(|side| side.uvs(scene).map(vertex_key));
                        if ours != theirs {
                            pairs.push(pair);
                        }
                    }
                }
            }
        }
        first += mesh.triangles().len() as u32;
    }
    pairs
}

impl Side {
    /// The ends in the lightmap.
    fn uvs(self, scene: &Scene) -> [[f32; 2]; 2] {
        let (mesh, number) = scene.locate(self.triangle as usize);
        let mesh = &scene.meshes()[mesh];
        self.corners.map(|k| mesh.lightmap_uvs()[mesh.triangles()[number][k] as usize])
    }

    /// The length in the lightmap, whose side is 1.
    fn length(self, scene: &Scene) -> f64 {
        let [a, b] = self.uvs(scene).map(|uv| uv.map(f64::from));
        (a[0] - b[0]).hypot(a[1] - b[1])
    }

    /// The place at a part of the way from the first end to the second.
    fn hit(self, part: f64) -> Hit {
        let mut weights = [0.0; 3];
        weights[self.corners[0]] = 1.0 - part;
        weights[self.corners[1]] = part;
        Hit { t: 0.0, triangle: self.triangle, u: weights[1] as f32, v: weights[2] as f32 }
    }
}
