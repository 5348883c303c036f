//! A square texture over `[-1, 1]²` with bilinear lookup.

use lobe_io::parallel;
use lobe_sh::{Coefficient, Rgb};

/// Colors over the square `[-1, 1]²`; `x` to the right, `y` upwards, the first row at the top.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SquareTexture {
    size: usize,
    texels: Vec<Rgb<f32>>,
}

impl SquareTexture {
    /// The texture with the values of `f(x, y)` at the centers of its texels.
    pub(crate) fn from_fn(size: usize, f: &(dyn Fn(f64, f64) -> Rgb<f32> + Sync)) -> Self {
        assert!(size > 0, "a texture needs texels");
        let at = |i: usize| 2.0 * (i as f64 + 0.5) / size as f64 - 1.0;
        Self { size, texels: parallel::map(size * size, &|i| f(at(i % size), -at(i / size))) }
    }

    /// The bilinear value at `(x, y)`; beyond the outermost centers, theirs.
    pub(crate) fn lookup(&self, x: f64, y: f64) -> Rgb<f32> {
        let last = self.size - 1;
        let split = |t: f64| {
            let place = (0.5 * (t + 1.0) * self.size as f64 - 0.5).clamp(0.0, last as f64);
            let low = (place as usize).min(last);
            (low, (low + 1).min(last), (place - low as f64) as f32)
        };
        let ((x0, x1, tx), (y0, y1, ty)) = (split(x), split(-y));
        let row = |y: usize| {
            let (a, b) = (self.texels[y * self.size + x0], self.texels[y * self.size + x1]);
            a.scale(1.0 - tx) + b.scale(tx)
        };
        row(y0).scale(1.0 - ty) + row(y1).scale(ty)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_function_comes_back_between_the_outermost_centers() {
        let texture = SquareTexture::from_fn(8, &|x, y| Rgb::new(x as f32, y as f32, 1.0));
        for k in 0..=20 {
            let (x, y) = (0.0875 * f64::from(k) - 0.875, 0.8 - 0.07 * f64::from(k));
            let found = texture.lookup(x, y);
            let off = (f64::from(found.r) - x).abs().max((f64::from(found.g) - y).abs());
            assert!(off < 1e-6, "({x}, {y}) came back as {found:?}");
        }
        assert_eq!(texture.lookup(-3.0, 3.0), texture.lookup(-0.875, 0.875), "beyond the upper left corner");
    }
}
