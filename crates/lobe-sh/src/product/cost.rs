//! What a product costs.

/// What a generated product multiplies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProductKind {
    /// Two expansions.
    General,
    /// An expansion with itself.
    Square,
    /// A zonal function about +z and an expansion.
    Zonal,
}

/// The operations of one generated product, see [`PRODUCT_COSTS`](crate::PRODUCT_COSTS).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProductCost {
    /// What is multiplied.
    pub kind: ProductKind,
    /// The orders of the factors and of the product.
    pub orders: [usize; 3],
    /// Multiplications, those by a constant included.
    pub multiplications: usize,
    /// Additions and subtractions.
    pub additions: usize,
}
