//! Openness of a point towards a lobe of directions, by transfer without reflections.

use std::borrow::Borrow;
use std::f64::consts::{FRAC_1_PI, PI};

use lobe_env::LobeFactors;
use lobe_prt::{AlbedoMode, AnyTransfer, Transfer};
use lobe_sh::basis::eval_basis;
use lobe_sh::{Coefficient as _, Dir, Rgb, Zonal};

use crate::scene_view::prt_shading::SurfaceTransfer;
use crate::scene_view::scene_picture::SceneHit;
use crate::scene_view::surface_model::Surroundings;

/// The openness of receivers.
///
/// ```text
///   O(a, α) = Σᵢ k_l Dᵢ yᵢ(a) / Σᵢ k_l Cᵢ yᵢ(a)          D: transfer of visibility   C: of the whole hemisphere
/// ```
///
/// `k_l` blurs by the lobe of GGX of this α about the axis `a`, so that `O` is the mean of the visibility under the
/// lobe, weighted by the cosine at the surface: specular occlusion. Nothing is known of a black surface whose transfer
/// holds the albedo, which is taken for open.
pub struct Openness<T = Transfer> {
    transfer: T,
    albedo: AlbedoMode,
    factors: LobeFactors,
    /// The clamped cosine.
    cosine: Zonal,
}

impl<'a> Openness<&'a Transfer> {
    /// That of transfer in its plain form; none of other forms.
    pub(crate) fn of(transfer: &'a SurfaceTransfer, albedo: AlbedoMode) -> Option<Self> {
        match transfer {
            SurfaceTransfer::Matte(AnyTransfer::Plain(transfer)) => Some(Self::new(transfer, albedo)),
            _ => None,
        }
    }
}

impl<T: Borrow<Transfer>> Openness<T> {
    /// That of transfer without reflections, which holds the albedo or not.
    pub fn new(transfer: T, albedo: AlbedoMode) -> Self {
        let order = transfer.borrow().order();
        let factors = LobeFactors::new(order);
        Self { transfer, albedo, factors, cosine: Zonal::clamped_cosine(order) }
    }

    /// What is around a hit for a lobe about this axis, of this roughness. Receivers are those around it, whose weights
    /// sum to 1;
    /// `others` is the radiance of a matte surface of its albedo there by what all other surfaces send.
    ///
    /// # Panics
    /// If there is no such receiver.
    pub fn surroundings(
        &self,
        hit: &SceneHit<'_>,
        (axis, roughness): (Dir, f64),
        receivers: impl Iterator<Item = (usize, f64)>,
        others: Rgb<f64>,
    ) -> Surroundings {
        let albedo = if self.albedo == AlbedoMode::None { Rgb::splat(1.0) } else { hit.albedo };
        // The channel that is known best.
        let [r, g, b] = albedo.to_array();
        let channel = [r, g, b].iter().position(|&c| c >= r.max(g).max(b)).unwrap_or(0);
        let best = albedo.to_array()[channel];
        if best <= 0.0 {
            return Surroundings::UNKNOWN;
        }
        let transfer = self.transfer.borrow();
        let channel = channel.min(transfer.channels().count() - 1);
        let factors = self.factors.at(roughness);
        let basis = eval_basis(axis, transfer.order());
        // The transfer of visibility, towards the axis and as a whole.
        let (mut along, mut ambient) = (0.0, 0.0);
        for (receiver, weight) in receivers {
            let row = transfer.vector(receiver, channel);
            for (l, factor) in factors.iter().enumerate() {
                let band = l * l..(l + 1) * (l + 1);
                along += weight * factor * band.map(|i| f64::from(row[i]) * basis[i]).sum::<f64>();
            }
            ambient += weight * f64::from(row[0]) * (4.0 * PI).sqrt();
        }
        let (along, ambient) = (along / best, (ambient / best).clamp(0.0, 1.0));
        // That of the whole hemisphere.
        let blurred = self.cosine.coefficients().iter().zip(&factors).map(|(z, factor)| z * factor * FRAC_1_PI);
        let above = Zonal::new(blurred.collect()).eval(hit.vertex_normal().dot(axis));
        let open = if above > LobeFactors::LEAST_ABOVE * FRAC_1_PI { (along / above).clamp(0.0, 1.0) } else { ambient };
        let part = (1.0 - ambient).max(LobeFactors::LEAST_HIDDEN).recip();
        let divided = |sum: f64, albedo: f64| if albedo > 0.0 { (part * sum / albedo).max(0.0) } else { 0.0 };
        let others = Rgb::new(divided(others.r, albedo.r), divided(others.g, albedo.g), divided(others.b, albedo.b));
        Surroundings { open, ambient: Some(ambient), others }
    }
}
