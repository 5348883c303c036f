//! Normals of OBJ faces that have none: which corners share one, and what it is.

use std::collections::HashMap;

use glam::DVec3;

use crate::files::read_options::MissingNormals;
use crate::scene::flat::{FlatMesh, unit_normal};
use crate::scene::vertex_normals::weighted_normals;

/// How the normals of a face are made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) enum Smoothing {
    /// Round with all other faces of which the file says nothing, because no line `s` stands before them.
    #[default]
    Unsaid,
    /// Flat.
    Off,
    /// Round with the faces of the same group.
    Group(i64),
}

impl Smoothing {
    /// What a line `s` says by its first word; `None` where that is not understood.
    pub(crate) fn of(word: &str) -> Option<Self> {
        match (word, word.parse::<i64>()) {
            ("off", _) | (_, Ok(0)) => Some(Self::Off),
            ("on", _) => Some(Self::Group(1)),
            (_, group) => group.ok().map(Self::Group),
        }
    }

    /// What is made of it: the file decides unless the caller does.
    pub(crate) fn under(self, option: MissingNormals) -> Self {
        match option {
            MissingNormals::AsFormat => self,
            MissingNormals::Flat => Self::Off,
            MissingNormals::Smooth => Self::Unsaid,
        }
    }
}

/// What the corners that share a vertex have in common.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Key {
    Group(Smoothing),
    /// The normal of flat triangles.
    Plane([u32; 3]),
}

/// The vertices to be added, so that none has triangles of two groups or flat ones of two planes; `None` if nothing is to be done.
pub(crate) fn split(positions: &[[f32; 3]], triangles: &[[u32; 3]], smoothing: &[Smoothing]) -> Option<FlatMesh> {
    let is_round_everywhere = |first: Smoothing| first != Smoothing::Off && smoothing.iter().all(|&s| s == first);
    if smoothing.first().is_none_or(|&first| is_round_everywhere(first)) {
        return None;
    }
    Some(FlatMesh::of_keys(positions.len(), triangles, |t| match smoothing[t] {
        Smoothing::Off => unit_normal(positions, triangles[t]).map(Key::Plane),
        group => Some(Key::Group(group)),
    }))
}

/// The sums of the normals around each position, weighted by their angles there, of each group by itself.
///
/// Positions are those of the file: a corner that has other texture coordinates, or belongs to another material or part of the
/// object, is at the same one, so that its surface stays round there.
#[derive(Default)]
pub(crate) struct NormalSums {
    /// Those of the group that came first at a position, which is the only one nearly everywhere.
    first: Vec<Option<(Smoothing, DVec3)>>,
    others: HashMap<(u32, Smoothing), DVec3>,
}

impl NormalSums {
    /// The bytes of each position.
    pub(crate) const BYTES: u64 = size_of::<Option<(Smoothing, DVec3)>>() as u64;

    pub(crate) fn new(positions: usize) -> Self {
        Self { first: vec![None; positions], others: HashMap::new() }
    }

    /// Adds a triangle of a group, by its positions and where they are. Flat ones add nothing.
    pub(crate) fn add(&mut self, group: Smoothing, positions: [u32; 3], corners: [[f32; 3]; 3]) {
        if group == Smoothing::Off {
            return;
        }
        let Some(weighted) = weighted_normals(corners) else { return };
        for (position, normal) in positions.into_iter().zip(weighted) {
            let first = self.first[position as usize].get_or_insert((group, DVec3::ZERO));
            if first.0 == group {
                first.1 += normal;
            } else {
                *self.others.entry((position, group)).or_default() += normal;
            }
        }
    }

    /// The normal of a group at a position; zero where there is none, or the sum vanishes.
    pub(crate) fn normal(&self, group: Smoothing, position: u32) -> [f32; 3] {
        let sum = match self.first.get(position as usize) {
            Some(Some((first, sum))) if *first == group => Some(sum),
            _ => self.others.get(&(position, group)),
        };
        sum.copied().and_then(DVec3::try_normalize).unwrap_or_default().as_vec3().to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_name_a_group_or_none() {
        let cases = [
            ("off", Some(Smoothing::Off)),
            ("0", Some(Smoothing::Off)),
            ("1", Some(Smoothing::Group(1))),
            ("on", Some(Smoothing::Group(1))),
            ("4294967296", Some(Smoothing::Group(1 << 32))),
            ("round", None),
            ("", None),
        ];
        for (word, expected) in cases {
            assert_eq!(Smoothing::of(word), expected, "{word:?}");
        }
    }

    #[test]
    fn groups_at_one_position_have_sums_of_their_own() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let turned = [corners[0], corners[2], corners[1]];
        let mut sums = NormalSums::new(3);
        sums.add(Smoothing::Group(1), [0, 1, 2], corners);
        sums.add(Smoothing::Unsaid, [0, 2, 1], turned);
        assert_eq!(sums.normal(Smoothing::Group(1), 0), [0.0, 0.0, 1.0], "the first");
        assert_eq!(sums.normal(Smoothing::Unsaid, 0), [0.0, 0.0, -1.0], "another");
        assert_eq!(sums.normal(Smoothing::Group(2), 0), [0.0; 3], "one that is not there");
        sums.add(Smoothing::Off, [0, 1, 2], corners);
        assert_eq!(sums.normal(Smoothing::Off, 0), [0.0; 3], "flat ones share nothing");
        sums.add(Smoothing::Group(1), [0, 2, 1], turned);
        assert_eq!(sums.normal(Smoothing::Group(1), 0), [0.0; 3], "a sum that vanishes");
    }
}
