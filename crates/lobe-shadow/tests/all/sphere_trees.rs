//! Hierarchies of spheres.

use lobe_shadow::{SphereHierarchy, SphereSet};
use lobe_testkit::Random;

fn set(count: usize) -> SphereSet {
    let mut random = Random::new(9);
    let centers = (0..count).map(|_| std::array::from_fn(|_| 10.0 + random.signed() as f32)).collect();
    SphereSet::new(centers, (0..count).map(|_| 0.2 * random.unit() as f32).collect()).unwrap()
}

#[test]
fn parents_contain_their_children_and_every_sphere_is_below_the_root_once() {
    for (count, arity) in [(1, 2), (2, 2), (7, 4), (100, 2), (100, 8)] {
        let set = set(count);
        let tree = SphereHierarchy::new(&set, arity).unwrap();
        let mut leaves = tree.leaves().to_vec();
        leaves.sort_unstable();
        assert_eq!(leaves, (0..count as u32).collect::<Vec<_>>(), "{count} spheres, {arity} children");
        for (index, node) in tree.nodes().iter().enumerate() {
            assert!(node.children as usize <= arity && node.children != 1, "{node:?}");
            if node.is_leaf() {
                let sphere = tree.leaves_below(index)[0] as usize;
                assert_eq!((node.center, node.radius), (set.centers()[sphere], set.radii()[sphere]), "{node:?}");
            }
            for &leaf in tree.leaves_below(index) {
                let leaf = leaf as usize;
                let square: f64 = (0..3).map(|k| f64::from(node.center[k] - set.centers()[leaf][k]).powi(2)).sum();
                let reach = square.sqrt() + f64::from(set.radii()[leaf]);
                assert!(reach <= f64::from(node.radius) * (1.0 + 1e-6) + 1e-6, "{node:?}: sphere {leaf} at {reach}");
            }
        }
        assert_eq!(SphereHierarchy::new(&set, arity).unwrap(), tree, "made again");
        let again = SphereHierarchy::from_parts(tree.nodes().to_vec(), tree.leaves().to_vec()).unwrap();
        assert_eq!(again, tree, "from its parts");
    }
}

#[test]
fn near_spheres_are_joined_before_far_ones() {
    let set = SphereSet::new(vec![[0.0; 3], [8.0, 0.0, 0.0], [1.0, 0.0, 0.0], [9.0, 0.0, 0.0]], vec![0.1; 4]).unwrap();
    let tree = SphereHierarchy::new(&set, 2).unwrap();
    let below: Vec<Vec<u32>> = (1..3)
        .map(|node| {
            let mut leaves = tree.leaves_below(node).to_vec();
            leaves.sort_unstable();
            leaves
        })
        .collect();
    assert!(below.contains(&vec![0, 2]) && below.contains(&vec![1, 3]), "{below:?}");
    assert_eq!(tree.children(0).len(), 2, "children of the root");
}

#[test]
fn what_is_no_tree_is_refused() {
    let tree = SphereHierarchy::new(&set(5), 2).unwrap();
    let refusal = |change: &dyn Fn(&mut Vec<lobe_shadow::SphereNode>, &mut Vec<u32>)| {
        let (mut nodes, mut leaves) = (tree.nodes().to_vec(), tree.leaves().to_vec());
        change(&mut nodes, &mut leaves);
        let message = SphereHierarchy::from_parts(nodes, leaves).unwrap_err().to_string();
        assert!(message.starts_with("expected ") && !message.contains('\n'), "{message}");
    };
    refusal(&|nodes, _| nodes.clear());
    refusal(&|_, leaves| leaves[0] = leaves[1]);
    refusal(&|_, leaves| leaves[0] = u32::MAX);
    refusal(&|nodes, _| nodes[0].first_child = 0);
    refusal(&|nodes, _| nodes[0].children = u32::MAX);
    refusal(&|nodes, _| nodes[0].leaf_count = 4);
    refusal(&|nodes, _| nodes[0].radius *= 0.5);
    refusal(&|nodes, _| nodes[0].radius = f32::NAN);
    refusal(&|nodes, _| nodes[1].radius = -1.0);
    refusal(&|nodes, _| nodes.truncate(nodes.len() - 1));
    refusal(&|nodes, _| nodes.push(nodes[nodes.len() - 1]));
    let refusal = |set: &SphereSet, arity| SphereHierarchy::new(set, arity).unwrap_err().to_string();
    assert_eq!(refusal(&SphereSet::default(), 2), "expected 1 to 16384 spheres, found 0", "an empty set");
    assert_eq!(refusal(&set(2), 1), "expected 2 to 64 children, found 1", "one child");
}
