//! The binary tree by the surface area heuristic, from the root down: of the splits between bins the one of least expected cost.

use glam::Vec3A;
use rayon::prelude::*;

use crate::bvh::binary_tree::{BinaryNode, BinaryTree};
use crate::bvh::bins::{Bins, Extent, Grid, Primitive, Split, Volume};
use crate::bvh::lanes::WIDTH;
use crate::scene::scene::Bounds;

/// Subtrees of more boxes than this are built side by side.
const SIDE_BY_SIDE: usize = 8192;

/// Boxes that one thread reads at a time.
const CHUNK: usize = 16_384;

/// A split is poor where one side keeps more than this part of the boxes.
const POOR: f32 = 7.0 / 8.0;

/// A binary tree over the boxes of triangles, one at least. Its leaves have up to eight: they fill the blocks that rays read.
///
/// Boxes are sorted into bins by their centers, along each axis, and parted between those two bins where
///
/// ```text
///   A(left) ⌈N(left) / 8⌉ + A(right) ⌈N(right) / 8⌉
/// ```
///
/// is least: the area A of a box is in proportion to the rays that meet it, and ⌈N / 8⌉ blocks are the least that N triangles fill
/// [Wald 2007].
///
/// It takes n log n whatever the boxes are: where a split is poor, one side keeping nearly all, more often on the way to a leaf than a
/// balanced tree has levels, and where no split is between bins, boxes are halved by the order of their centers. What a thread does
/// depends on nothing that another does at the time, so the tree is the same for any number of threads.
pub(crate) fn build(corners: &[[[f32; 3]; 3]]) -> BinaryTree {
    let primitive = |(index, corners): (usize, &_)| Primitive::new(index as u32, corners);
    let mut primitives: Vec<_> = corners.par_iter().with_min_len(CHUNK).enumerate().map(primitive).collect();
    let volume = primitives.par_chunks(CHUNK).map(Volume::around).reduce(|| Volume::NOTHING, Volume::and);
    let poor_splits = primitives.len().ilog2() + 1;
    let mut nodes = Vec::new();
    Subtree { primitives: &mut primitives, first: 0, volume, poor_splits }.build(&mut nodes, &mut Bins::new());
    BinaryTree { nodes, order: primitives.par_iter().with_min_len(CHUNK).map(Primitive::index).collect() }
}

/// The tree of some of the triangles, with their indices among all.
pub(crate) fn build_of(corners: &[[[f32; 3]; 3]], some: &[u32]) -> BinaryTree {
    let mut tree = build(&some.iter().map(|&index| corners[index as usize]).collect::<Vec<_>>());
    tree.order.iter_mut().for_each(|index| *index = some[*index as usize]);
    tree
}

/// A subtree that is to be built.
struct Subtree<'a> {
    primitives: &'a mut [Primitive],
    /// The place of the first of them in the order.
    first: u32,
    volume: Volume,
    /// How many are left on the way down.
    poor_splits: u32,
}

impl Subtree<'_> {
    fn build(self, nodes: &mut Vec<BinaryNode>, bins: &mut Bins) {
        let (place, count) = (nodes.len(), self.primitives.len());
        let Extent { min, max } = self.volume.boxes;
        let bounds = Bounds { min: min.to_array(), max: max.to_array() };
        nodes.push(BinaryNode { bounds, first: self.first, count: count as u32, right: 0 });
        if count <= WIDTH {
            return;
        }
        let [left, right] = self.split(bins);
        if count <= SIDE_BY_SIDE {
            left.build(nodes, bins);
            nodes[place].right = (nodes.len() - place) as u32;
            right.build(nodes, bins);
        } else {
            let mut on_the_right = Vec::new();
            rayon::join(|| left.build(nodes, bins), || right.build(&mut on_the_right, &mut Bins::new()));
            nodes[place].right = (nodes.len() - place) as u32;
            nodes.append(&mut on_the_right);
        }
    }

    fn split(self, bins: &mut Bins) -> [Self; 2] {
        let count = self.primitives.len();
        let grid = Grid::new(&self.volume.centers, count);
        if count <= CHUNK {
            bins.clear(&grid);
            bins.add(&grid, self.primitives);
        } else {
            let binned = |chunk: &[Primitive]| {
                let mut bins = Bins::new();
                bins.add(&grid, chunk);
                bins
            };
            *bins = self.primitives.par_chunks(CHUNK).map(binned).reduce(Bins::new, |a, b| a.and(&b));
        }
        let is_poor = |split: &Split| split.left_count.max(count - split.left_count) as f32 > POOR * count as f32;
        match bins.best_split(&grid, |area, count| area * count.div_ceil(WIDTH as u32) as f32) {
            Some(split) if !is_poor(&split) => self.split_at(&grid, &split, 0),
            Some(split) if self.poor_splits > 0 => self.split_at(&grid, &split, 1),
            _ => self.halved(),
        }
    }

    fn split_at(self, grid: &Grid, split: &Split, poor: u32) -> [Self; 2] {
        partition(self.primitives, |p| grid.is_left(p, split));
        let (left, right) = self.primitives.split_at(split.left_count);
        let volumes = [(split.left, left), (split.right, right)]
            .map(|(boxes, primitives)| Volume { boxes, centers: Extent::of_centers(primitives) });
        self.parted(split.left_count, volumes, poor)
    }

    /// Halves by the order of centers along the axis where they spread most, of equal ones by index.
    fn halved(self) -> [Self; 2] {
        let half = self.primitives.len() / 2;
        let size: Vec3A = self.volume.centers.max - self.volume.centers.min;
        let axis = (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best });
        self.primitives.select_nth_unstable_by(half, |a, b| {
            a.center()[axis].total_cmp(&b.center()[axis]).then(a.index().cmp(&b.index()))
        });
        let (left, right) = self.primitives.split_at(half);
        let volumes = [left, right].map(Volume::around);
        self.parted(half, volumes, 0)
    }

    fn parted(self, left_count: usize, volumes: [Volume; 2], poor: u32) -> [Self; 2] {
        let poor_splits = self.poor_splits - poor;
        let (left, right) = self.primitives.split_at_mut(left_count);
        let [left_volume, right_volume] = volumes;
        [
            Self { primitives: left, volume: left_volume, poor_splits, ..self },
            Self { primitives: right, first: self.first + left_count as u32, volume: right_volume, poor_splits },
        ]
    }
}

/// Moves those to the front for which `is_left`. No branch depends on it: in most subtrees left and right alternate as if by
/// chance, and a mispredicted branch takes longer than the swap that it would save.
#[inline(always)]
fn partition(primitives: &mut [Primitive], is_left: impl Fn(&Primitive) -> bool) {
    let mut start = 0;
    for place in 0..primitives.len() {
        let is_left = is_left(&primitives[place]);
        primitives.swap(start, place);
        start += usize::from(is_left);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    /// Checks that each box is at one leaf, that leaves hold eight at most, and that boxes hold those of their children, no more;
    /// returns the depth.
    fn checked(name: &str, corners: &[[[f32; 3]; 3]]) -> usize {
        let tree = build(corners);
        let mut found = vec![0; corners.len()];
        let (mut open, mut depth) = (vec![(0, 1)], 0);
        while let Some((place, level)) = open.pop() {
            depth = depth.max(level);
            let node = &tree.nodes[place];
            let boxes = tree.boxes(place);
            let bounds = if node.is_leaf() {
                assert!((1..=WIDTH).contains(&boxes.len()), "{name}: {} boxes at a leaf", boxes.len());
                boxes.iter().for_each(|&index| found[index as usize] += 1);
                boxes
                    .iter()
                    .flat_map(|&index| corners[index as usize])
                    .map(|p| Bounds { min: p, max: p })
                    .collect::<Vec<_>>()
            } else {
                let children = tree.children(place);
                let [left, right] = children.map(|child| tree.boxes(child));
                assert_eq!(
                    [left, right].concat(),
                    boxes,
                    "{name}: the boxes of node {place} are those of its children"
                );
                open.extend(children.map(|child| (child, level + 1)));
                children.map(|child| tree.nodes[child].bounds).to_vec()
            };
            for axis in 0..3 {
                let min = bounds.iter().map(|b| b.min[axis]).fold(f32::INFINITY, f32::min);
                let max = bounds.iter().map(|b| b.max[axis]).fold(f32::NEG_INFINITY, f32::max);
                assert_eq!(
                    (node.bounds.min[axis], node.bounds.max[axis]),
                    (min, max),
                    "{name}: node {place}, axis {axis}"
                );
            }
        }
        assert!(found.iter().all(|&times| times == 1), "{name}: each box at one leaf");
        depth
    }

    fn triangles(count: usize, at: impl Fn(f32) -> [[f32; 3]; 2]) -> Vec<[[f32; 3]; 3]> {
        (0..count).map(|i| at(i as f32)).map(|[a, b]| [a, b, [a[0], b[1], a[2]]]).collect()
    }

    #[test]
    fn any_triangles_make_a_tree_of_logarithmic_depth() {
        let count = 50_000;
        let mut random = Random::new(31);
        let cases = [
            ("one", triangles(1, |_| [[0.0; 3], [1.0; 3]])),
            ("nine points", triangles(9, |_| [[1.0; 3]; 2])),
            ("all at one place", triangles(count, |_| [[0.0; 3], [1.0, 1.0, 0.0]])),
            ("nested", triangles(count, |i| [[-1.0 - i; 3], [1.0 + i; 3]])),
            ("from one corner", triangles(count, |i| [[0.0; 3], [1.0 + i; 3]])),
            ("parallel sticks", triangles(count, |i| [[0.0, i, 0.0], [1e6, i + 0.5, 1.0]])),
            ("a row", triangles(count, |i| [[i, 0.0, 0.0], [i + 1.0, 1.0, 0.0]])),
            // Each bin but the first is empty, or nearly so, wherever one looks closer.
            ("ever nearer", triangles(count, |i| [[0.9_f32.powf(i / 40.0), 0.0, 0.0], [0.9_f32.powf(i / 40.0); 3]])),
            ("as far as it goes", triangles(count, |i| [[1e15 * (i / 5e4), -1e15, 1e15], [-1e15, 1e15, 0.0]])),
            ("as small as it goes", triangles(count, |i| [[1e-45 * i, 0.0, 0.0], [0.0, 1e-45 * (5e4 - i), 0.0]])),
            ("by chance", (0..count).map(|_| [(); 3].map(|()| random.direction().map(|c| c as f32))).collect()),
        ];
        for (name, corners) in cases {
            let depth = checked(name, &corners);
            // As many poor splits as levels of a balanced tree; all others leave 7/8 of the boxes at most: 5.2 is 1 / log2(8/7).
            let most = 6.2 * (corners.len() as f64).log2() + 3.0;
            println!("{name}: {} triangles, depth {depth}", corners.len());
            assert!(depth as f64 <= most, "{name}: {} triangles at depth {depth}, more than {most}", corners.len());
        }
    }

    #[test]
    fn the_tree_is_the_same_for_any_number_of_threads() {
        let mut random = Random::new(32);
        // More than one thread bins at a time, with equal centers among them.
        let count = 3 * CHUNK + 5;
        let corners: Vec<[[f32; 3]; 3]> = (0..count)
            .map(|i| {
                let center = if i % 3 == 0 { [0.5; 3] } else { random.direction() };
                [(); 3].map(|()| std::array::from_fn(|k| (center[k] + 0.01 * (i % 7) as f64) as f32))
            })
            .collect();
        let [one, four] = [1, 4].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| build(&corners))
        });
        assert!(one.order == four.order, "the order of the triangles");
        let shape =
            |tree: &BinaryTree| tree.nodes.iter().map(|n| (n.bounds, n.first, n.count, n.right)).collect::<Vec<_>>();
        assert!(shape(&one) == shape(&four), "{} and {} nodes", one.nodes.len(), four.nodes.len());
    }

    #[test]
    fn parts_are_left_and_right_whatever_their_order() {
        let mut random = Random::new(33);
        for count in 0..40_usize {
            let mut primitives: Vec<_> = (0..count as u32).map(|i| Primitive::new(i, &[[0.0; 3]; 3])).collect();
            let sides: Vec<bool> = (0..count).map(|_| random.unit() < 0.4).collect();
            partition(&mut primitives, |p| sides[p.index() as usize]);
            let left_count = sides.iter().filter(|&&is_left| is_left).count();
            for (place, primitive) in primitives.iter().enumerate() {
                assert_eq!(sides[primitive.index() as usize], place < left_count, "place {place} of {count}");
            }
            let mut indices: Vec<_> = primitives.iter().map(Primitive::index).collect();
            indices.sort_unstable();
            assert!(indices.iter().copied().eq(0..count as u32), "none is lost of {count}");
        }
    }
}
