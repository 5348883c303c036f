//! Coincident triangles that a tree need not hold: a tree cannot part them, so that each ray would meet all of them.

use rayon::prelude::*;

use crate::scene::scene::Scene;

/// The most see-through triangles at one place that a tree holds: so many films of any kind let no light through that is seen.
const MOST_FILMS: usize = 64;

/// The triangles of a scene that a tree leaves out.
#[derive(Clone, Debug, Default)]
pub(crate) struct LeftOut {
    /// Each triangle that is left out, in their order, with one at its place that is not.
    pairs: Vec<[u32; 2]>,
}

/// Corners in an order of their own, and whether they run around as they were.
type Sorted = ([[u32; 3]; 3], bool);

impl LeftOut {
    /// Finds triangles that add nothing to others with the same corners.
    ///
    /// Rays hit the first of them. All behind one without holes are left out, except the first that runs around the
    /// other way. Films beyond a number are left out too.
    ///
    /// In n log n.
    pub(crate) fn of(scene: &Scene, corners: &[[[f32; 3]; 3]]) -> Self {
        let mut by_place: Vec<(u64, u32)> =
            corners.par_iter().enumerate().map(|(index, corners)| (hash(&sorted(corners)), index as u32)).collect();
        by_place.par_sort_unstable();
        if by_place.windows(2).all(|pair| pair[0].0 != pair[1].0) {
            return Self::default();
        }
        let mut pairs = Vec::new();
        for alike in by_place.chunk_by(|a, b| a.0 == b.0).filter(|alike| alike.len() > 1) {
            let mut at: Vec<(Sorted, u32)> =
                alike.iter().map(|&(_, index)| (sorted(&corners[index as usize]), index)).collect();
            // By place first, should two have the same hash, then in the order of the scene.
            at.sort_unstable_by_key(|&((place, _), index)| (place, index));
            for layers in at.chunk_by(|a, b| a.0.0 == b.0.0) {
                push_redundant(scene, layers, &mut pairs);
            }
        }
        pairs.sort_unstable();
        Self { pairs }
    }

    /// Whether none is left out.
    pub(crate) fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// The triangles that are not left out, of `count`.
    pub(crate) fn others(&self, count: usize) -> Vec<u32> {
        let mut left_out = self.pairs.iter().map(|pair| pair[0]).peekable();
        (0..count as u32).filter(|&index| left_out.next_if_eq(&index).is_none()).collect()
    }

    /// Whether all of them are still at the place of the other, in another pose.
    pub(crate) fn are_at_their_places(&self, corners: &[[[f32; 3]; 3]]) -> bool {
        self.pairs.par_iter().all(|pair| {
            let [(left_out, side), (other, other_side)] = pair.map(|index| sorted(&corners[index as usize]));
            left_out == other && side == other_side
        })
    }
}

/// Adds the layers at one place that are left out, each with the first of its side.
fn push_redundant(scene: &Scene, layers: &[(Sorted, u32)], pairs: &mut Vec<[u32; 2]>) {
    let mut first: [Option<u32>; 2] = [None; 2];
    let mut is_closed = [false; 2];
    let mut films = 0;
    for &((_, side), index) in layers {
        let has_holes = scene.material(scene.locate(index as usize).0).has_holes();
        let own = usize::from(side);
        // What is behind a layer without holes is never reached, and one more of the same side neither.
        let is_hidden = is_closed[own] || (has_holes && (is_closed[1 - own] || films >= MOST_FILMS));
        match first[own] {
            Some(first) if is_hidden => pairs.push([index, first]),
            _ => {
                first[own] = first[own].or(Some(index));
                is_closed[own] |= !has_holes;
                films += usize::from(has_holes);
            }
        }
    }
}

fn sorted(corners: &[[f32; 3]; 3]) -> Sorted {
    // Zero has two signs.
    let mut bits = corners.map(|p| p.map(|c| (c + 0.0).to_bits()));
    let mut is_even = true;
    for (a, b) in [(0, 1), (1, 2), (0, 1)] {
        if bits[a] > bits[b] {
            bits.swap(a, b);
            is_even = !is_even;
        }
    }
    (bits, is_even)
}

fn hash((corners, _): &Sorted) -> u64 {
    corners.as_flattened().iter().fold(0, |hash: u64, &word| {
        let hash = (hash ^ u64::from(word)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        hash ^ hash >> 29
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::bvh::Bvh;
    use crate::scene::material::{Alpha, Material};
    use crate::scene::mesh::{Mesh, MeshParts};
    use crate::scene::ray::{Hit, Ray};

    const CORNERS: [[f32; 3]; 3] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];

    /// A mesh of each material, with as many triangles at one place, every other one the other way around if they `turn`.
    fn layers(of: &[(usize, Material)], turn: bool) -> Scene {
        let mesh = |(index, (count, _)): (usize, &(usize, Material))| {
            let triangle = |k: usize| if turn && k % 2 == 1 { [1, 0, 2] } else { [[0, 1, 2], [1, 2, 0]][k % 2] };
            let triangles = (0..*count).map(triangle).collect();
            let parts = MeshParts { positions: CORNERS.to_vec(), triangles, ..MeshParts::default() };
            Mesh::new(MeshParts { material: Some(index), ..parts }).unwrap()
        };
        let meshes = of.iter().enumerate().map(mesh).collect();
        Scene::new(meshes, of.iter().map(|(_, material)| material.clone()).collect(), vec![]).unwrap()
    }

    fn left_out(scene: &Scene) -> usize {
        LeftOut::of(scene, &scene.corners().collect::<Vec<_>>()).pairs.len()
    }

    fn film() -> Material {
        Material { alpha: Alpha::Blend, straight_through: true, base_color: [1.0, 1.0, 1.0, 0.5], ..Material::WHITE }
    }

    #[test]
    fn of_layers_at_one_place_a_tree_holds_those_that_rays_can_tell_apart() {
        for (of, turn, expected) in [
            (vec![(1, Material::WHITE)], false, 0),
            (vec![(500, Material::WHITE)], false, 499),
            (vec![(500, Material::WHITE)], true, 498),
            (vec![(3, film()), (5, Material::WHITE), (7, film())], false, 4 + 7),
            (vec![(500, film())], false, 500 - MOST_FILMS),
        ] {
            let scene = layers(&of, turn);
            assert_eq!(left_out(&scene), expected, "{:?}, turned: {turn}", of.iter().map(|o| o.0).collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_first_of_layers_is_hit_whatever_is_left_out() {
        let scene = layers(&[(1000, Material::WHITE)], true);
        let ray = Ray::new([0.0, 0.0, 2.0], [0.0, 0.0, -1.0]);
        let found = Bvh::new(&scene).closest(&ray);
        let all = Bvh::from_corners(&scene.corners().collect::<Vec<_>>()).closest(&ray);
        assert_eq!(found, all, "against a tree of all");
        assert!(matches!(found, Some(Hit { triangle: 0, .. })), "{found:?}");
    }

    #[test]
    fn layers_that_a_pose_parts_are_there_again() {
        let scene = layers(&[(2, Material::WHITE), (1, Material::WHITE)], false);
        let mut bvh = Bvh::new(&scene);
        let (mut meshes, materials, textures) = scene.into_parts();
        meshes[1] = meshes[1].clone().with_positions(|[x, y, z]| [x, y, z + 1.0]);
        let posed = Scene::new(meshes, materials, textures).unwrap();
        bvh.refit(&posed);
        let hit = bvh.closest(&Ray::new([0.0, 0.0, 2.0], [0.0, 0.0, -1.0]));
        assert!(matches!(hit, Some(Hit { triangle: 2, .. })), "{hit:?}: the third has risen");
    }
}
