//! The size of pictures.

/// The size of pictures, which the number of paths and of rays follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels across a ball.
    pub(crate) ball: usize,
    /// Pixels across a lat-long picture.
    pub(crate) picture: usize,
}

impl Size {
    /// Pictures in which nothing can be seen, for tests.
    #[doc(hidden)]
    pub const LEAST: Self = Self { ball: 16, picture: 64 };
    /// Small pictures.
    pub const QUICK: Self = Self { ball: 80, picture: 256 };
    /// Pictures of half again the width.
    pub const USUAL: Self = Self { ball: 120, picture: 384 };
    /// Pictures of twice the width.
    pub const FULL: Self = Self { ball: 160, picture: 512 };
}
