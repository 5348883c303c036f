//! Pixel type and its arithmetic.

/// Linear red, green and blue; Rec. 709 primaries unless the file says otherwise.
pub type Pixel = [f32; 3];

/// Any type that converts to a [`Pixel`] without loss: the color of another crate need only be `Into<[f32; 3]>`.
///
/// So slices of such colors are encoded as they are, and vectors of them become pictures in place.
pub trait IntoPixel: Copy + Send + Sync + Into<Pixel> {}

impl<T: Copy + Send + Sync + Into<Pixel>> IntoPixel for T {}

/// Black.
pub(crate) const BLACK: Pixel = [0.0; 3];

/// In `f64`, for sums of many terms.
pub(crate) fn widened(c: Pixel) -> [f64; 3] {
    c.map(f64::from)
}

/// Rounded from `f64`.
pub(crate) fn narrowed(c: [f64; 3]) -> Pixel {
    c.map(|c| c as f32)
}

/// Every channel times `s`.
pub(crate) fn scaled(c: [f64; 3], s: f64) -> [f64; 3] {
    c.map(|c| c * s)
}

/// The sum of each channel.
pub(crate) fn add([r, g, b]: [f64; 3], [s, h, c]: [f64; 3]) -> [f64; 3] {
    [r + s, g + h, b + c]
}

/// Relative luminance `0.2126 r + 0.7152 g + 0.0722 b` (ITU-R BT.709).
pub(crate) fn luminance([r, g, b]: [f64; 3]) -> f64 {
    r * 0.2126 + g * 0.7152 + b * 0.0722
}

/// `(1 - t) a + t b`, with `t` clamped to `[0, 1]`.
#[must_use]
pub fn mix(a: impl IntoPixel, b: impl IntoPixel, t: f64) -> Pixel {
    let (a, b) = (a.into(), b.into());
    let t = t.clamp(0.0, 1.0) as f32;
    std::array::from_fn(|c| a[c] * (1.0 - t) + b[c] * t)
}
