//! The binary tree from which wide nodes are made.

use crate::scene::scene::Bounds;

/// A binary tree over boxes. Subtrees are contiguous: a node, its left subtree, its right one; so are their boxes in `order`.
#[derive(Clone, Debug, Default)]
pub(crate) struct BinaryTree {
    /// The root first.
    pub(crate) nodes: Vec<BinaryNode>,
    /// The indices of the boxes, leaf by leaf.
    pub(crate) order: Vec<u32>,
}

/// A node of a [`BinaryTree`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct BinaryNode {
    pub(crate) bounds: Bounds,
    /// The place of its first box in the order, and how many it has.
    pub(crate) first: u32,
    pub(crate) count: u32,
    /// How many places the right child stands behind the node, the left one just behind it; 0 for a leaf.
    pub(crate) right: u32,
}

impl BinaryNode {
    pub(crate) fn is_leaf(&self) -> bool {
        self.right == 0
    }
}

impl BinaryTree {
    /// The two children of an inner node.
    pub(crate) fn children(&self, node: usize) -> [usize; 2] {
        [node + 1, node + self.nodes[node].right as usize]
    }

    /// The boxes of a subtree, as indices.
    pub(crate) fn boxes(&self, node: usize) -> &[u32] {
        let BinaryNode { first, count, .. } = self.nodes[node];
        &self.order[first as usize..(first + count) as usize]
    }
}
