//! Textures with bilinear lookup.

use std::sync::{Arc, OnceLock};

/// The continuation of a texture outside of the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub enum Wrap {
    /// Repeat the picture.
    #[default]
    Repeat,
    /// Repeat the picture, every other one mirrored.
    Mirror,
    /// Continue the texels of the border.
    Clamp,
}

/// A picture of eight bits a channel: sRGB color and linear alpha, or the parts of normals. Row 0 is at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    width: usize,
    height: usize,
    /// Shared: all poses of a scene have the same.
    texels: Arc<Vec<[u8; 4]>>,
    wrap: [Wrap; 2],
}

impl Texture {
    /// A picture of `width` × `height` texels, row by row from the top.
    ///
    /// # Panics
    /// If the number of texels is not `width * height`, or zero.
    #[must_use]
    pub fn new(width: usize, height: usize, texels: Vec<[u8; 4]>, wrap: [Wrap; 2]) -> Self {
        assert!(
            !texels.is_empty() && texels.len() == width * height,
            "expected {width} x {height} texels, found {}",
            texels.len()
        );
        Self { width, height, texels: Arc::new(texels), wrap }
    }

    /// Width in texels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in texels.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// The picture's values, row by row from the top.
    #[must_use]
    pub fn texels(&self) -> &[[u8; 4]] {
        &self.texels
    }

    /// The continuation outside of the unit square, along u and along v.
    #[must_use]
    pub fn wrap(&self) -> [Wrap; 2] {
        self.wrap
    }

    /// The picture as the bytes of a PNG file.
    ///
    /// # Panics
    /// If a side is longer than 2³² - 1 texels.
    #[must_use]
    pub fn to_png(&self) -> Vec<u8> {
        let [width, height] = [self.width, self.height].map(|n| u32::try_from(n).expect("a side of 2^32 texels"));
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_compression(png::Compression::Fast);
        encoder.set_filter(png::Filter::Adaptive);
        let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(self.texels.as_flattened()));
        match written {
            Ok(()) => bytes,
            Err(error) => unreachable!("memory takes every PNG: {error}"),
        }
    }

    /// Whether no texel has a hue.
    #[must_use]
    pub fn is_gray(&self) -> bool {
        self.texels.iter().all(|[r, g, b, _]| r == g && g == b)
    }

    /// Linear color and alpha at a point, (0, 0) being the top left corner; interpolated bilinearly in linear light.
    #[must_use]
    pub fn sample(&self, at: [f64; 2]) -> [f32; 4] {
        self.bilinear(at, |[r, g, b, a]| {
            [linear_from_srgb8(r), linear_from_srgb8(g), linear_from_srgb8(b), f32::from(a) / 255.0]
        })
    }

    /// The numbers at a point as they are stored, as parts of 255, interpolated bilinearly: those of a picture that holds no
    /// color, such as a [normal map](crate::NormalMap).
    #[must_use]
    pub(crate) fn sample_stored(&self, at: [f64; 2]) -> [f32; 4] {
        self.bilinear(at, |texel| texel.map(|c| f32::from(c) / 255.0))
    }

    fn bilinear(&self, [u, v]: [f64; 2], numbers: impl Fn([u8; 4]) -> [f32; 4]) -> [f32; 4] {
        let (x0, x1, fx) = neighbors(u, self.width, self.wrap[0]);
        let (y0, y1, fy) = neighbors(v, self.height, self.wrap[1]);
        let at = |x: usize, y: usize| numbers(self.texels[y * self.width + x]);
        let (a, b, c, d) = (at(x0, y0), at(x1, y0), at(x0, y1), at(x1, y1));
        let mix = |a: f32, b: f32, f: f32| a + (b - a) * f;
        std::array::from_fn(|k| mix(mix(a[k], b[k], fx), mix(c[k], d[k], fx), fy))
    }
}

/// The two texels on either side of a coordinate, and the weight of the second.
fn neighbors(coordinate: f64, size: usize, wrap: Wrap) -> (usize, usize, f32) {
    let n = size as f64;
    // Remove whole periods, so that the texel index stays small.
    let u = match wrap {
        Wrap::Repeat => coordinate.rem_euclid(1.0),
        Wrap::Mirror => coordinate.rem_euclid(2.0),
        Wrap::Clamp => coordinate.clamp(0.0, 1.0),
    };
    let x = u * n - 0.5;
    let below = x.floor();
    let place = |k: i64| {
        let m = size as i64;
        let k = match wrap {
            Wrap::Repeat => k.rem_euclid(m),
            Wrap::Mirror => {
                let k = k.rem_euclid(2 * m);
                if k < m { k } else { 2 * m - 1 - k }
            }
            Wrap::Clamp => k.clamp(0, m - 1),
        };
        k as usize
    };
    (place(below as i64), place(below as i64 + 1), (x - below) as f32)
}

/// Linear light of an 8-bit sRGB value (IEC 61966-2-1).
///
/// ```text
///   s ≤ 0.04045:  s / 12.92        else:  ((s + 0.055) / 1.055)^2.4
/// ```
pub(crate) fn linear_from_srgb8(value: u8) -> f32 {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| std::array::from_fn(|i| linear_from_srgb(i as f64 / 255.0)))[usize::from(value)]
}

/// The linear value of an encoded one from 0 to 1.
pub(crate) fn linear_from_srgb(s: f64) -> f32 {
    (if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_by_one(wrap: Wrap) -> Texture {
        Texture::new(2, 1, vec![[0, 0, 0, 255], [255, 255, 255, 0]], [wrap; 2])
    }

    #[test]
    fn texel_centers_give_their_texel_and_halfway_gives_the_mean_in_linear_light() {
        let texture = two_by_one(Wrap::Repeat);
        assert_eq!(texture.sample([0.25, 0.5]), [0.0, 0.0, 0.0, 1.0], "left center");
        assert_eq!(texture.sample([0.75, 0.5]), [1.0, 1.0, 1.0, 0.0], "right center");
        assert_eq!(texture.sample([0.5, 0.5]), [0.5, 0.5, 0.5, 0.5], "halfway");
    }

    #[test]
    fn stored_numbers_are_linear_between_texels_whatever_their_code() {
        let texture = Texture::new(2, 1, vec![[0, 51, 255, 255], [255, 102, 0, 255]], [Wrap::Repeat; 2]);
        assert_eq!(texture.sample_stored([0.25, 0.5]), [0.0, 0.2, 1.0, 1.0], "left center");
        let [x, y, z, _] = texture.sample_stored([0.375, 0.5]);
        assert!((x - 0.25).abs() + (y - 0.25).abs() + (z - 0.75).abs() < 1e-6, "a quarter on: {x}, {y}, {z}");
    }

    #[test]
    fn outside_of_the_unit_square_the_wrap_decides() {
        let red = |wrap, u: f64| two_by_one(wrap).sample([u, 0.5])[0];
        for (wrap, u, expected) in [
            (Wrap::Repeat, 1.25, 0.0),
            (Wrap::Repeat, -0.25, 1.0),
            (Wrap::Repeat, 0.0, 0.5),
            (Wrap::Mirror, 1.25, 1.0),
            (Wrap::Mirror, -0.25, 0.0),
            (Wrap::Mirror, 0.0, 0.0),
            (Wrap::Clamp, 7.0, 1.0),
            (Wrap::Clamp, -7.0, 0.0),
        ] {
            assert_eq!(red(wrap, u), expected, "{wrap:?} at {u}");
        }
    }

    #[test]
    fn srgb_is_decoded_by_its_standard() {
        assert_eq!(linear_from_srgb8(0), 0.0, "black");
        assert_eq!(linear_from_srgb8(255), 1.0, "white");
        // The gray that reflects 21.4 %: 127.5 / 255 lies between the two.
        let (below, above) = (linear_from_srgb8(127), linear_from_srgb8(128));
        assert!(below < 0.21404 && 0.21404 < above, "{below} < 0.21404 < {above}");
    }
}
