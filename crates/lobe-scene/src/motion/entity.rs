//! Entities: what a scene in motion consists of.

use std::ops::Range;

/// The meshes that one node shows, and whether they move.
#[derive(Clone, Debug, PartialEq)]
pub struct Entity {
    pub(crate) name: Option<String>,
    pub(crate) node: usize,
    pub(crate) kind: EntityKind,
    pub(crate) meshes: Range<usize>,
    pub(crate) vertices: Range<usize>,
    pub(crate) skin: Option<usize>,
}

/// Whether an entity moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum EntityKind {
    /// Nothing moves it.
    Static,
    /// It moves as a whole: its vertices keep their places in its own frame.
    Rigid,
    /// A skin or morph targets deform it.
    Deformed,
}

impl Entity {
    /// The name of the node; many have none.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// The index of the node that shows it.
    #[must_use]
    pub fn node(&self) -> usize {
        self.node
    }

    /// Whether any of the scene's animations moves or deforms it.
    #[must_use]
    pub fn kind(&self) -> EntityKind {
        self.kind
    }

    /// The indices of its meshes in the scene.
    #[must_use]
    pub fn meshes(&self) -> Range<usize> {
        self.meshes.clone()
    }

    /// The indices of its vertices, counted through all meshes of the scene in their order.
    #[must_use]
    pub fn vertices(&self) -> Range<usize> {
        self.vertices.clone()
    }

    /// The skin that carries it, an index for [`AnimatedScene::skins`](crate::AnimatedScene::skins).
    #[must_use]
    pub fn skin(&self) -> Option<usize> {
        self.skin
    }
}
