//! Zonal transfer: a few lobes for each receiver, and their exit radiance under a light.

use std::f64::consts::PI;

use lobe_io::parallel;
use lobe_sh::basis::{Basis, band_range};
use lobe_sh::{Dir, Rgb, Rotation, Zonal};

use crate::error::PrtError;
use crate::transfer::transfer::check_order;
use crate::transfer::transfer::{Channels, Transfer};
use crate::zonal::lobes::MOST;

/// Receivers shaded or turned by a thread at a time: where they are shaded, the basis towards all their axes stays in the second-level
/// cache.
const CHUNK: usize = 128;

/// Transfer vectors as sums of a few functions that are symmetric about an axis ([Sloan 2005]).
///
/// ```text
///   T_lm ≈ Σ_k √(4π/(2l+1)) z_kl y_lm(d_k)        B = Σ_k Σ_l z_kl √(4π/(2l+1)) Σ_m L_lm y_lm(d_k)
/// ```
///
/// A surface that bends turns each of its points by another rotation. An expansion would have to be rotated there; of
/// lobes only the axes turn: that is what makes transfer locally deformable. Channels share the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct ZonalTransfer {
    order: usize,
    channels: Channels,
    lobes: usize,
    axes: Vec<[f32; 3]>,
    coefficients: Vec<f32>,
}

impl ZonalTransfer {
    /// The most lobes of a receiver.
    pub const MAX_LOBES: usize = MOST;

    /// From unit axes, receiver by receiver, and for every one of them its coefficients `z_l`, channel by channel, band
    /// by band.
    ///
    /// # Errors
    /// [`PrtError::Options`] if the order or the number of lobes is not 1 to 8; [`PrtError::Invalid`] if the numbers do
    /// not fit together, are not finite, or an axis is no unit vector to 1e-4.
    pub fn new(
        order: usize,
        channels: Channels,
        lobes: usize,
        axes: Vec<[f32; 3]>,
        coefficients: Vec<f32>,
    ) -> Result<Self, PrtError> {
        check_order(order)?;
        if !(1..=MOST).contains(&lobes) {
            return Err(PrtError::Options(format!("expected 1 to {MOST} lobes, found {lobes}")));
        }
        let invalid = |message: String| Err(PrtError::invalid("zonal transfer", message));
        if !axes.len().is_multiple_of(lobes) {
            return invalid(format!("expected {lobes} axes for each receiver, found {} in all", axes.len()));
        }
        let each = order * channels.count();
        if coefficients.len() != each * axes.len() {
            let (found, axes) = (coefficients.len(), axes.len());
            return invalid(format!("expected {each} coefficients for each of {axes} axes, found {found} in all"));
        }
        if let Some(bad) = axes.iter().find(|a| !is_unit(**a)) {
            return invalid(format!("expected unit axes, found {bad:?}"));
        }
        // A coefficient of transfer is no larger than the sum of those of its lobes, which so is finite.
        let most = f32::MAX / MOST as f32;
        if let Some(bad) = coefficients.iter().find(|z| z.is_nan() || z.abs() > most) {
            return invalid(format!("expected finite coefficients of at most {most:e}, found {bad}"));
        }
        Ok(Self { order, channels, lobes, axes, coefficients })
    }

    /// Number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The channels: one set of coefficients or three for each axis.
    #[must_use]
    pub fn channels(&self) -> Channels {
        self.channels
    }

    /// Lobes of each receiver.
    #[must_use]
    pub fn lobes(&self) -> usize {
        self.lobes
    }

    /// Number of receivers.
    #[must_use]
    pub fn receivers(&self) -> usize {
        self.axes.len() / self.lobes
    }

    /// The axes, receiver by receiver.
    #[must_use]
    pub fn axes(&self) -> &[[f32; 3]] {
        &self.axes
    }

    /// For every axis its coefficients `z_l`, channel by channel, band by band.
    #[must_use]
    pub fn coefficients(&self) -> &[f32] {
        &self.coefficients
    }

    /// Bytes of axes and coefficients.
    #[must_use]
    pub fn bytes(&self) -> usize {
        12 * self.axes.len() + 4 * self.coefficients.len()
    }

    /// The transfer vectors of one receiver, channel by channel.
    ///
    /// # Panics
    /// If there is no such receiver.
    #[must_use]
    pub fn decode(&self, receiver: usize) -> Vec<f32> {
        let (n, count) = (self.order * self.order, self.channels.count());
        let mut sum = vec![0.0_f64; n * count];
        let mut lobe = vec![0.0_f64; n];
        for k in receiver * self.lobes..(receiver + 1) * self.lobes {
            let axis = dir(self.axes[k]);
            for (c, sum) in sum.chunks_exact_mut(n).enumerate() {
                let z = &self.coefficients[(k * count + c) * self.order..][..self.order];
                Zonal::new(z.iter().map(|z| f64::from(*z)).collect()).towards_into(axis, 1.0_f64, &mut lobe);
                sum.iter_mut().zip(&lobe).for_each(|(sum, t)| *sum += t);
            }
        }
        sum.into_iter().map(|x| x as f32).collect()
    }

    /// The transfer vectors of all receivers.
    #[must_use]
    pub fn to_transfer(&self) -> Transfer {
        let rows: Vec<Vec<f32>> = parallel::map(self.receivers(), &|r| self.decode(r));
        Transfer::new(self.order, self.channels, rows.concat())
            .unwrap_or_else(|e| unreachable!("finite lobes make finite transfer: {e}"))
    }

    /// The same receivers, each turned by its own rotation: only the axes change.
    #[must_use]
    pub fn rotated(&self, rotation: impl Fn(usize) -> Rotation + Sync) -> Self {
        let mut turned = self.clone();
        turned.turn(&rotation);
        turned
    }

    fn turn(&mut self, rotation: &(dyn Fn(usize) -> Rotation + Sync)) {
        let lobes = self.lobes;
        parallel::rows(&mut self.axes, CHUNK * lobes, &|chunk, axes| {
            for (k, axes) in axes.chunks_exact_mut(lobes).enumerate() {
                let rotation = rotation(chunk * CHUNK + k);
                for axis in axes {
                    *axis = rotation.rotate_dir(dir(*axis)).to_array().map(|x| x as f32);
                }
            }
        });
    }

    /// The exit radiance of every receiver under a light, as [`Transfer::exit_radiance`] has it.
    ///
    /// # Panics
    /// If the light has no coefficients.
    #[must_use]
    pub fn exit_radiance(&self, light: &[Rgb<f64>]) -> Vec<Rgb<f32>> {
        let mut out = vec![Rgb::new(0.0, 0.0, 0.0); self.receivers()];
        self.exit_radiance_towards_into(&self.axes, light, &mut out);
        out
    }

    /// The same with other axes, those of a surface as it is bent now: for every receiver its own, turned as the
    /// receiver is.
    ///
    /// # Panics
    /// If the light has no coefficients, there are not as many axes as in [`ZonalTransfer::axes`], or `out` has not one
    /// place for each receiver.
    pub fn exit_radiance_towards_into(&self, axes: &[[f32; 3]], light: &[Rgb<f64>], out: &mut [Rgb<f32>]) {
        assert!(!light.is_empty(), "a light has at least one coefficient");
        assert_eq!(axes.len(), self.axes.len(), "as many axes as there are lobes");
        assert_eq!(out.len(), self.receivers(), "one place for each receiver");
        let light = self.scaled(light);
        let basis = Basis::<f32>::new(self.order);
        let each = self.lobes * self.channels.count() * self.order;
        parallel::rows(out, CHUNK, &|chunk, out| {
            let axes = &axes[chunk * CHUNK * self.lobes..][..out.len() * self.lobes];
            let coefficients = &self.coefficients[chunk * CHUNK * each..][..out.len() * each];
            self.shade_chunk(&basis, &light, axes, coefficients, out);
        });
    }

    /// `√(4π/(2l+1)) L_lm`, black where the light has no coefficient.
    fn scaled(&self, light: &[Rgb<f64>]) -> Vec<[f32; 3]> {
        let mut scaled = Vec::with_capacity(self.order * self.order);
        for l in 0..self.order {
            let factor = (4.0 * PI / (2 * l + 1) as f64).sqrt();
            for i in band_range(l) {
                let of_light = light.get(i).map_or([0.0; 3], |l| [l.r, l.g, l.b]);
                scaled.push(of_light.map(|x| (factor * x) as f32));
            }
        }
        scaled
    }

    fn shade_chunk(
        &self,
        basis: &Basis<f32>,
        light: &[[f32; 3]],
        axes: &[[f32; 3]],
        coefficients: &[f32],
        out: &mut [Rgb<f32>],
    ) {
        let count = axes.len();
        let [x, y, z] = [0, 1, 2].map(|c| axes.iter().map(|a| a[c]).collect::<Vec<f32>>());
        let mut values = vec![0.0_f32; self.order * self.order * count];
        basis.eval_many_into([&x, &y, &z], &mut values);
        let mut sums = vec![[0.0_f32; 3]; count];
        let mut band = vec![[0.0_f32; 3]; count];
        let channels = self.channels.count();
        for l in 0..self.order {
            band.fill([0.0; 3]);
            for i in band_range(l) {
                let light = light[i];
                for (band, y) in band.iter_mut().zip(&values[i * count..(i + 1) * count]) {
                    for c in 0..3 {
                        band[c] += light[c] * y;
                    }
                }
            }
            for (k, (sum, band)) in sums.iter_mut().zip(&band).enumerate() {
                for c in 0..3 {
                    sum[c] += band[c] * coefficients[(k * channels + c.min(channels - 1)) * self.order + l];
                }
            }
        }
        for (out, sums) in out.iter_mut().zip(sums.chunks_exact(self.lobes)) {
            let total = |c: usize| sums.iter().map(|sum| sum[c]).sum();
            *out = Rgb::new(total(0), total(1), total(2));
        }
    }
}

fn is_unit(axis: [f32; 3]) -> bool {
    let square: f64 = axis.iter().map(|x| f64::from(*x).powi(2)).sum();
    (square - 1.0).abs() < 1e-4
}

pub(crate) fn dir(axis: [f32; 3]) -> Dir {
    Dir::from_f32(axis).unwrap_or_else(|| unreachable!("axes are unit vectors, found {axis:?}"))
}
