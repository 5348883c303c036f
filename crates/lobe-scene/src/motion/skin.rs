//! Skins: joints that carry the vertices of a mesh.

use glam::DMat4;

/// The joints of a skin.
#[derive(Clone, Debug)]
pub(crate) struct Skin {
    pub(crate) name: Option<String>,
    /// The nodes of the joints.
    pub(crate) joints: Vec<usize>,
    /// From the mesh's space, where it was bound, to that of each joint.
    pub(crate) inverse_binds: Vec<DMat4>,
}

impl Skin {
    /// The transforms from the space in which the mesh was bound to the scene, one for each joint.
    pub(crate) fn matrices(&self, worlds: &[DMat4]) -> Vec<DMat4> {
        self.joints.iter().zip(&self.inverse_binds).map(|(&joint, bind)| worlds[joint] * *bind).collect()
    }
}

/// The joints that carry each vertex, with weights.
#[derive(Clone, Debug, Default)]
pub(crate) struct Influences {
    /// The first of the pairs of each vertex, then the number of all pairs.
    starts: Vec<u32>,
    /// Joints and weights above zero, as the file has them.
    pairs: Vec<(u16, f32)>,
    /// The largest index of a joint.
    pub(crate) last_joint: u16,
    /// How many vertices have weights whose sum is off one by more than rounding, and by how much at most.
    pub(crate) off_one: (usize, f64),
    /// How many vertices have no weight above zero.
    pub(crate) without: usize,
}

/// The deviation of a sum of weights from one that is rounding, for each weight: that of the glTF validator.
const WEIGHT_ROUNDING: f64 = 2e-7;

impl Influences {
    /// The joints and weights of vertices, each a list of pairs; weights of zero are dropped. They need not sum to one:
    /// they are divided by their sum when they are used. A vertex whose weights are all zero follows the first joint that it
    /// names.
    ///
    /// Fails at a weight that is negative or no number, and at a vertex without pairs.
    pub(crate) fn new<V: IntoIterator<Item = (u16, f32)>>(vertices: impl Iterator<Item = V>) -> Result<Self, String> {
        let mut all = Self { starts: vec![0], ..Self::default() };
        for (vertex, pairs) in vertices.enumerate() {
            let (first, mut named) = (all.pairs.len(), None);
            for (joint, weight) in pairs {
                named = named.or(Some(joint));
                if !(weight.is_finite() && weight >= 0.0) {
                    return Err(format!("expected weights from 0 on, found {weight} at vertex {vertex}"));
                }
                if weight > 0.0 {
                    all.pairs.push((joint, weight));
                    all.last_joint = all.last_joint.max(joint);
                }
            }
            if all.pairs.len() == first {
                let Some(joint) = named else { return Err(format!("vertex {vertex} has no joint: bind it to one")) };
                all.pairs.push((joint, 1.0));
                (all.without, all.last_joint) = (all.without + 1, all.last_joint.max(joint));
            }
            let own = &all.pairs[first..];
            let off = (own.iter().map(|&(_, weight)| f64::from(weight)).sum::<f64>() - 1.0).abs();
            if off > WEIGHT_ROUNDING * own.len() as f64 {
                all.off_one = (all.off_one.0 + 1, all.off_one.1.max(off));
            }
            let Ok(end) = u32::try_from(all.pairs.len()) else {
                return Err(format!("expected fewer than 2^32 weights, found more at vertex {vertex}"));
            };
            all.starts.push(end);
        }
        Ok(all)
    }

    /// The joints of a vertex and their weights, which sum to one.
    pub(crate) fn of(&self, vertex: usize) -> impl Iterator<Item = (usize, f64)> {
        let pairs = &self.pairs[self.starts[vertex] as usize..self.starts[vertex + 1] as usize];
        let sum: f64 = pairs.iter().map(|&(_, weight)| f64::from(weight)).sum();
        pairs.iter().map(move |&(joint, weight)| (usize::from(joint), f64::from(weight) / sum))
    }

    /// Adds a vertex with the mean of the weights of two; false where there are too many.
    pub(crate) fn push_mean(&mut self, [a, b]: [usize; 2]) -> bool {
        let mut mean: Vec<(u16, f32)> = Vec::new();
        for (joint, weight) in self.of(a).chain(self.of(b)) {
            let half = (0.5 * weight) as f32;
            match mean.iter_mut().find(|(known, _)| usize::from(*known) == joint) {
                Some((_, sum)) => *sum += half,
                None => mean.push((joint as u16, half)),
            }
        }
        self.pairs.extend(mean);
        u32::try_from(self.pairs.len()).map(|end| self.starts.push(end)).is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_that_do_not_sum_to_one_are_divided_by_their_sum_and_counted() {
        let of = [vec![(3, 1.0), (0, 0.0)], vec![(1, 0.5), (2, 1.5)], vec![(0, 0.3), (1, 0.7)]];
        let influences = Influences::new(of.into_iter()).unwrap();
        assert_eq!(influences.of(0).collect::<Vec<_>>(), [(3, 1.0)], "a weight of zero is none");
        assert_eq!(influences.of(1).collect::<Vec<_>>(), [(1, 0.25), (2, 0.75)], "divided by 2");
        assert_eq!((influences.off_one, influences.last_joint), ((1, 1.0), 3), "0.3 + 0.7 is one but for a rounding");
    }

    #[test]
    fn a_vertex_without_weight_follows_the_first_joint_that_it_names() {
        let influences = Influences::new([vec![(4, 0.0), (7, 0.0)], vec![(1, 1.0)]].into_iter()).unwrap();
        assert_eq!(influences.of(0).collect::<Vec<_>>(), [(4, 1.0)], "the first");
        assert_eq!((influences.without, influences.last_joint, influences.off_one.0), (1, 4, 0), "counted once");
    }

    #[test]
    fn weights_that_say_nothing_are_refused() {
        let refusal = |weight| Influences::new([vec![(0, 1.0)], vec![(0, weight)]].into_iter()).unwrap_err();
        assert_eq!(refusal(-0.5), "expected weights from 0 on, found -0.5 at vertex 1", "negative");
        assert_eq!(refusal(f32::NAN), "expected weights from 0 on, found NaN at vertex 1", "no number");
        let none = Influences::new([Vec::new()].into_iter()).unwrap_err();
        assert_eq!(none, "vertex 0 has no joint: bind it to one", "nothing");
    }
}
