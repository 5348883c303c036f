//! Transfer matrices: incident light of glossy receivers, before it is reflected.

use lobe_sh::{Dir, Expansion as _, Rgb, ShVec, Zonal};

use crate::error::PrtError;
use crate::transfer::dot_rows::incident;
use crate::transfer::transfer::Channels;
use crate::transfer::transfer::{check_order, check_rows};

/// The transfer matrices of many points: from the light of the surroundings to the light incident at each.
///
/// ```text
///   L_in = M L,    M_ij = ∫_Ω yᵢ(s) (path that starts along s; yⱼ) ds
/// ```
///
/// Ω is the hemisphere above a receiver, or the sphere about a point in space. The light that arrives from s is that of
/// the surroundings where nothing is in the way, and what surfaces send on where they are hit: M holds shadows and
/// interreflections, and what is left to do is one convolution with the lobe of the reflection
/// [Sloan, Kautz and Snyder 2002]:
///
/// ```text
///   B(v) = Σ_lm α_l (M L)_lm y_lm(r),    α_l = √(4π/(2l+1)) G_l,    r = 2 (n·v) n - v
/// ```
///
/// G is the zonal expansion of the lobe, such as [`Zonal::phong`] or [`Zonal::ggx`], v the direction to the eye. `α_l`
/// are the lobe's convolution factors. The receiver's own reflectance is not in M: a mirror of reflectance F sends F B
/// back.
///
/// Stored point by point, channel by channel, row by row of equal i: `n⁴` numbers for a channel.
///
/// # What is exact
/// Under light of order n, but for the noise of the bake,
///
/// ```text
///   B(v) = ∫_Ω L_in(s) k_n(r·s) ds,    k_n(t) = Σ_{l<n} (2l+1)/4π α_l P_l(t)
/// ```
///
/// with all of the light that arrives, shadows, horizon and interreflections: rows above order n are not missed, since
/// the kernel `k_n` has no such bands. With nothing in the way and no horizon this is the convolution of the light with
/// the lobe about r. The path tracer finds the same: tests `glossy` of `lobe-render`.
///
/// # What is an approximation
/// * The lobe has n bands: a narrow one is blurred and rings.
/// * The lobe is the same at every angle, turned about r. Phong's is; that of microfacets grows long and narrow towards
///   grazing angles and leans away from r.
/// * Lobes are normalized, they send back all that arrives. Microfacets lose what is scattered more than once: for them
///   F is best the directional albedo, `A F₀ + B` of the split sum.
///
/// The error against path tracing for a white metal of GGX microfacets: RMS over the vertices of a ball over a
/// ground, three views each, two skies of order n, no bounces, in percent of the RMS of the truth. The second number of
/// each pair is with F as above (test `how_far_the_kernel_is_from_microfacets_is_what_the_documentation_says` of
/// `lobe-render`).
///
/// | α | n | seen within 40° of the normal | seen 54° to 69° from it |
/// |---|---|---|---|
/// | 0.1 | 4 | 21, 21 | 17, 20 |
/// | 0.2 | 4 | 21, 18 | 13, 15 |
/// | 0.3 | 4 | 30, 18 | 24, 17 |
/// | 0.3 | 6 | 33, 19 | 29, 20 |
/// | 0.5 | 4 | 63, 26 | 61, 35 |
/// | 0.7 | 4 | 108, 33 | 102, 55 |
/// | 1 | 4 | 202, 43 | 154, 75 |
///
/// So this is for surfaces that shine, α about 0.1 to 0.4; what is rougher is better taken as matte.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferMatrices {
    order: usize,
    channels: Channels,
    coefficients: Vec<f32>,
}

impl TransferMatrices {
    /// The matrices of `coefficients.len() / (order⁴ · channels)` points.
    ///
    /// # Errors
    /// As [`crate::Transfer::new`].
    pub fn new(order: usize, channels: Channels, coefficients: Vec<f32>) -> Result<Self, PrtError> {
        check_order(order)?;
        check_rows("transfer matrices", "point", order.pow(4) * channels.count(), &coefficients)?;
        Ok(Self { order, channels, coefficients })
    }

    /// Number of bands n; each matrix is n² × n².
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The channels: one matrix or three for each point.
    #[must_use]
    pub fn channels(&self) -> Channels {
        self.channels
    }

    /// Number of points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.coefficients.len() / (self.order.pow(4) * self.channels.count())
    }

    /// All coefficients: point by point, channel by channel, row by row.
    #[must_use]
    pub fn coefficients(&self) -> &[f32] {
        &self.coefficients
    }

    /// The matrix of a point for a channel, 0 for red, row by row; gray ones have one for all.
    ///
    /// # Panics
    /// If there is no such point or the channel is above 2.
    #[must_use]
    pub fn matrix(&self, point: usize, channel: usize) -> &[f32] {
        assert!(channel < 3, "channel {channel} of 3");
        let (count, size) = (self.channels.count(), self.order.pow(4));
        let start = (point * count + channel.min(count - 1)) * size;
        &self.coefficients[start..start + size]
    }

    /// The light that arrives at a point, `M L`, of the order of the matrices. Bands that only one of both has count as
    /// zero.
    ///
    /// # Panics
    /// If there is no such point.
    #[must_use]
    pub fn incident(&self, point: usize, light: &[Rgb<f64>]) -> ShVec<Rgb<f64>> {
        let bands = self.order * self.order;
        let mut incident = vec![Rgb::new(0.0, 0.0, 0.0); bands];
        let [red, green, blue] = [0, 1, 2].map(|c| self.matrix(point, c));
        for (i, sum) in incident.iter_mut().enumerate() {
            for (j, l) in light.iter().take(bands).enumerate() {
                let k = i * bands + j;
                let [r, g, b] = [red[k], green[k], blue[k]].map(f64::from);
                *sum += Rgb::new(r * l.r, g * l.g, b * l.b);
            }
        }
        ShVec::from_vec(incident).unwrap_or_else(|| unreachable!("n² coefficients"))
    }

    /// The light that arrives at every point: n² coefficients for each, point by point. As [`Self::incident`], in `f32` and with all
    /// threads; the sums have one order, which neither the threads nor the instructions of the machine change.
    ///
    /// # Panics
    /// If `out` has not n² places for each point.
    pub fn incident_into(&self, light: &[Rgb<f64>], out: &mut [Rgb<f32>]) {
        incident(&self.coefficients, self.order, self.channels.count(), light, out);
    }

    /// The radiance of a receiver with a lobe towards the eye.
    ///
    /// `normal` is that of the receiver, `to_eye` the direction to the eye, `lobe` the zonal expansion of the
    /// reflection, whose missing bands are zero. Nothing is sent below the surface. Negative values, which ringing
    /// makes, are kept.
    ///
    /// # Panics
    /// If there is no such point.
    #[must_use]
    pub fn exit_radiance(&self, point: usize, light: &[Rgb<f64>], lobe: &Zonal, normal: Dir, to_eye: Dir) -> Rgb<f64> {
        let cosine = normal.dot(to_eye);
        let (n, v) = (normal.to_array(), to_eye.to_array());
        let Some(reflected) = Dir::new([0, 1, 2].map(|k| 2.0 * cosine * n[k] - v[k])).filter(|_| cosine > 0.0) else {
            return Rgb::new(0.0, 0.0, 0.0);
        };
        let mut blurred = self.incident(point, light);
        lobe_sh::filter::convolve_in_place(blurred.coefficients_mut(), lobe);
        blurred.eval(reflected)
    }
}
