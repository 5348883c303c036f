//! Attributes at the middles of edges.

use std::collections::BTreeMap;

use glam::DVec3;

/// The value of an attribute in the middle of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Middle {
    /// The mean of the ends.
    Mean,
    /// The direction of the mean, a unit vector.
    Unit,
    /// The same of three numbers; the fourth is that of the first end.
    Tangent,
    /// The value of the first end: numbers that are names, whose mean means nothing.
    First,
}

impl Middle {
    /// What an attribute needs: one of this name, whole numbers being fractions of their largest or counted.
    pub(crate) fn of(name: &str, is_counted: bool) -> Self {
        let is_id = ["_FEATURE_ID", "_BATCHID", "JOINTS"].iter().any(|id| name.starts_with(id));
        match name {
            "NORMAL" => Self::Unit,
            "TANGENT" => Self::Tangent,
            _ if is_id || (name.starts_with('_') && is_counted) => Self::First,
            _ => Self::Mean,
        }
    }

    /// Appends the values at the middles of edges to those of vertices, of `size` numbers each.
    ///
    /// Directions are normalized when all are there, so that they are those of interpolation over the whole triangle.
    /// Opposite ones, whose mean is zero, leave the direction of the first end.
    pub(crate) fn append(self, values: &mut Vec<f32>, size: usize, halved: &[[u32; 2]]) {
        let first = values.len();
        for &[a, b] in halved {
            let [a, b] = [a, b].map(|end| end as usize * size);
            for k in 0..size {
                let is_first = self == Self::First || (self == Self::Tangent && k == 3);
                let middle = 0.5 * (f64::from(values[a + k]) + f64::from(values[b + k]));
                values.push(if is_first { values[a + k] } else { middle as f32 });
            }
        }
        if size < 3 || !matches!(self, Self::Unit | Self::Tangent) {
            return;
        }
        for (number, &[a, _]) in halved.iter().enumerate() {
            let at = first + number * size;
            let direction = |at: usize| DVec3::from(std::array::from_fn(|k| f64::from(values[at + k])));
            let unit = direction(at).try_normalize().unwrap_or_else(|| direction(a as usize * size));
            values[at..at + 3].copy_from_slice(&unit.as_vec3().to_array());
        }
    }
}

/// Joints of a vertex with their weights.
pub(crate) type Influences = Vec<(u16, f32)>;

/// Appends the joints at the middles of edges: those of both ends with half of their weights. Of more than `most` the
/// heaviest remain, of equals those with the smaller numbers, and share the weight of all.
pub(crate) fn append_influences(influences: &mut Vec<Influences>, most: usize, halved: &[[u32; 2]]) {
    for ends in halved {
        let mut sums = BTreeMap::<u16, f64>::new();
        for &(joint, weight) in ends.iter().flat_map(|&end| &influences[end as usize]) {
            *sums.entry(joint).or_default() += 0.5 * f64::from(weight);
        }
        let mut middle: Vec<(u16, f64)> = sums.into_iter().filter(|&(_, weight)| weight != 0.0).collect();
        let total: f64 = middle.iter().map(|(_, weight)| weight).sum();
        middle.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        middle.truncate(most);
        let left: f64 = middle.iter().map(|(_, weight)| weight).sum();
        influences.push(middle.into_iter().map(|(joint, weight)| (joint, (weight * (total / left)) as f32)).collect());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_at_middles_are_those_of_interpolation_however_often_edges_are_halved() {
        // 2 is halfway from 0 to 1, 3 halfway from 2 to 1.
        let halved = [[0, 1], [2, 1]];
        let after = |rule: Middle, values: &[f32], size| {
            let mut values = values.to_vec();
            rule.append(&mut values, size, &halved);
            values
        };
        assert_eq!(after(Middle::Mean, &[0.0, 8.0, 4.0, 0.0], 2)[4..], [2.0, 4.0, 3.0, 2.0], "means");
        assert_eq!(after(Middle::First, &[7.0, 9.0], 1)[2..], [7.0, 7.0], "names");
        let normals = after(Middle::Unit, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0], 3);
        let quarter = DVec3::new(0.25, 0.75, 0.0).normalize().as_vec3().to_array();
        assert_eq!(normals[9..], quarter, "a quarter of the way, as shading interpolates it");
        let tangents = after(Middle::Tangent, &[1.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0, 1.0], 4);
        assert_eq!(tangents[8..12], [1.0, 0.0, 0.0, -1.0], "opposite directions leave that of the first end");
        let mut copied = vec![0.1, 0.7];
        Middle::Mean.append(&mut copied, 1, &[[1, 1]]);
        assert_eq!(copied, [0.1, 0.7, 0.7], "one vertex twice is a copy");
        assert_eq!(after(Middle::Mean, &[f32::MAX, f32::MAX], 1)[2..], [f32::MAX; 2], "no overflow");
    }

    #[test]
    fn joints_at_middles_are_those_of_both_ends_or_the_heaviest_of_them() {
        let mut two = vec![vec![(3, 0.75), (1, 0.25)], vec![(3, 0.5), (2, 0.5)]];
        append_influences(&mut two, 4, &[[0, 1]]);
        assert_eq!(two[2], [(3, 0.625), (2, 0.25), (1, 0.125)], "all three");
        let mut many = vec![vec![(0, 0.5), (1, 0.5)], vec![(2, 0.75), (3, 0.25)]];
        append_influences(&mut many, 2, &[[0, 1]]);
        let found: Vec<u16> = many[2].iter().map(|&(joint, _)| joint).collect();
        let total: f32 = many[2].iter().map(|&(_, weight)| weight).sum();
        assert_eq!((found, total), (vec![2, 0], 1.0), "the heaviest, with the weight of all");
    }

    #[test]
    fn names_of_features_and_joints_are_not_averaged_and_other_attributes_are() {
        let of = |name| Middle::of(name, false);
        assert_eq!((of("_FEATURE_ID_0"), of("JOINTS_1")), (Middle::First, Middle::First), "names");
        assert_eq!((of("POSITION"), of("TEXCOORD_3"), of("_HEAT")), (Middle::Mean, Middle::Mean, Middle::Mean));
        assert_eq!(Middle::of("_LAYER", true), Middle::First, "whole numbers");
        assert_eq!((of("NORMAL"), of("TANGENT")), (Middle::Unit, Middle::Tangent), "directions");
    }
}
