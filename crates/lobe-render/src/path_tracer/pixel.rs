//! A pixel of a traced picture.

use lobe_sh::Rgb;

/// The channels of a traced pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel {
    pub(crate) mean: Rgb<f32>,
    pub(crate) variance: Rgb<f32>,
    pub(crate) albedo: Rgb<f32>,
    pub(crate) normal: Rgb<f32>,
    pub(crate) depth: f32,
    pub(crate) coverage: f32,
}

impl Pixel {
    pub(crate) fn to_numbers(self) -> [f32; 14] {
        let Self { mean: m, variance: v, albedo: a, normal: n, depth, coverage } = self;
        [m.r, m.g, m.b, v.r, v.g, v.b, a.r, a.g, a.b, n.r, n.g, n.b, depth, coverage]
    }

    pub(crate) fn from_numbers(x: [f32; 14]) -> Self {
        let [mean, variance, albedo, normal] = [0, 3, 6, 9].map(|k| Rgb::new(x[k], x[k + 1], x[k + 2]));
        Self { mean, variance, albedo, normal, depth: x[12], coverage: x[13] }
    }
}
