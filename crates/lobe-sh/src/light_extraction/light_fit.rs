//! The least-squares fit of directional lights and ambient light to an expansion.

use core::f64::consts::PI;

use crate::basis::eval_basis;
use crate::basis::legendre::legendre_all;
use crate::error::ShError;
use crate::expansion::sh_vec::widened;
use crate::expansion::zonal::zonal_norm;
use crate::expansion::{Expansion, ShVec, Zonal};
use crate::light::normalization::directional_normalization;
use crate::prelude::*;
use crate::scalar::{Coefficient, Real as _};
use crate::scalar::{luminance, weighted_sum};
use crate::solver::matrix::Matrix;
use crate::solver::nnls::{NormalEquations, least_squares_solution, nnls};
use crate::sphere::Dir;

/// A light from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DirectionalLight<T> {
    /// Towards the light.
    pub dir: Dir,
    /// The radiance that a white diffuse surface facing the light reflects, computed from the truncated expansion as
    /// with
    /// [`Normalization::Projected`](crate::light::Normalization::Projected).
    pub intensity: T,
}

/// Lights found in an expansion, and the residual.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct LightFit<T> {
    /// The order of the expansion; the unit of the intensities depends on it.
    pub order: usize,
    /// The lights, the brightest first; those of [`fit_lights`](crate::light_extraction::fit_lights) in the order of their directions.
    pub lights: Vec<DirectionalLight<T>>,
    /// The radiance of the ambient light.
    pub ambient: T,
    /// The energy of the difference from the expansion, weighted like [`LightFit::energy`].
    pub residual: T,
    /// The sum of the squared coefficients, weighted by the [`LightMetric`].
    pub energy: T,
}

impl<T: Coefficient<Scalar = f64>> LightFit<T> {
    /// The expansion of the lights and the ambient light.
    #[must_use]
    pub fn to_sh(&self) -> ShVec<T> {
        let mut f = ShVec::zero(self.order);
        if let Some(first) = Expansion::coefficients_mut(&mut f).first_mut() {
            *first = self.ambient.scale((4.0 * PI).sqrt());
        }
        let normalization = directional_normalization(self.order);
        for light in &self.lights {
            f += &ShVec::impulse(self.order, light.dir, light.intensity.scale(normalization));
        }
        f
    }
}

/// The metric in which lights approximate an expansion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum LightMetric {
    /// The irradiance over all normals: band `l` has the weight `(A_l/π)²`, so that bands 3, 5, 7 .. do not count.
    #[default]
    Irradiance,
    /// The radiance: all bands have the weight 1.
    Radiance,
}

/// The least-squares problem of lights in given directions, for one expansion.
///
/// With `L_d = N Σ_i y_i(d) y_i` the normalized light, `w_l` the weight of the metric and the DC term kept apart,
///
/// ```text
///   L_d · L_e = N² Σ_l w_l² (2l+1)/4π P_l(d·e)        L_d · f = N Σ_i w_l² f_i y_i(d)
///   L_d · L_a = N w_0²                                L_a · L_a = 4π w_0²        L_a · f = 2√π w_0² f_0
/// ```
pub(crate) struct LightProblem<T: Coefficient> {
    pub(crate) f: ShVec<T::Wide>,
    pub(crate) equations: LightEquations,
}

/// What a [`LightProblem`] is apart from its expansion. Not generic, so that the solvers are compiled in this crate
/// alone.
pub(crate) struct LightEquations {
    pub(crate) normalization: f64,
    /// `w_l²`.
    weights: Vec<f64>,
    pub(crate) non_negative: bool,
}

impl<T: Coefficient> LightProblem<T> {
    /// # Errors
    /// [`ShError::Options`] below order 2 and for coefficients that are not finite.
    pub(crate) fn new(f: &impl Expansion<T>, metric: LightMetric, non_negative: bool) -> Result<Self, ShError> {
        let order = f.order();
        if order < 2 {
            return Err(ShError::Options(format!(
                "lights have a direction from order 2 on, this expansion has order {order}"
            )));
        }
        for (i, c) in f.coefficients().iter().enumerate() {
            if let Some(bad) = (0..T::CHANNELS).map(|k| c.channel(k).to_f64()).find(|x| !x.is_finite()) {
                return Err(ShError::Options(format!(
                    "coefficient {i} of the expansion is {bad}; lights need finite ones"
                )));
            }
        }
        Ok(Self { f: widened(f), equations: LightEquations::new(order, metric, non_negative) })
    }

    /// `L_d · f` without DC.
    fn light_by_function(&self, d: Dir) -> T::Wide {
        let y = eval_basis(d, self.equations.order());
        let terms = self.f.coefficients().iter().zip(y).zip(self.equations.coefficient_weights());
        weighted_sum(terms.skip(1).map(|((f, y), w)| (*f, w * y))).scale(self.equations.normalization)
    }

    /// `Σ w_l² f_i²`, channel by channel.
    pub(crate) fn energy_of(&self, f: &ShVec<T::Wide>) -> T::Wide {
        weighted_sum(f.coefficients().iter().map(|f| *f * *f).zip(self.equations.coefficient_weights()))
    }

    /// The least-squares intensities and ambient light for these directions, in their order, lights of zero intensity
    /// included.
    ///
    /// Without constraints the ambient light takes up the whole DC term, and the other bands alone determine the
    /// lights.
    pub(crate) fn solve(&self, dirs: &[Dir]) -> LightFit<T::Wide> {
        let mut products: Vec<T::Wide> = dirs.iter().map(|d| self.light_by_function(*d)).collect();
        products.push(self.f[0]);
        let channel = |c: usize| products.iter().map(|x| x.channel(c)).collect();
        let products: Vec<Vec<f64>> = (0..T::CHANNELS).map(channel).collect();
        let channels = self.equations.solve(dirs, &products);
        let unknown = |i: usize| T::Wide::from_channels(|c| channels[c][i]);
        let lights = dirs.iter().enumerate().map(|(i, dir)| DirectionalLight { dir: *dir, intensity: unknown(i) });
        let mut fit = LightFit {
            order: self.equations.order(),
            lights: lights.collect(),
            ambient: unknown(dirs.len()),
            residual: T::Wide::ZERO,
            energy: self.energy_of(&self.f),
        };
        fit.residual = self.energy_of(&self.residual_of(&fit));
        fit
    }

    /// The expansion less that of the lights.
    pub(crate) fn residual_of(&self, fit: &LightFit<T::Wide>) -> ShVec<T::Wide> {
        &self.f - &fit.to_sh()
    }

    /// Lights of no intensity dropped, the brightest first.
    pub(crate) fn tidy(fit: &mut LightFit<T::Wide>) {
        fit.lights.retain(|light| light.intensity != T::Wide::ZERO);
        fit.lights.sort_by(|a, b| luminance(b.intensity).total_cmp(&luminance(a.intensity)));
    }
}

impl LightEquations {
    fn new(order: usize, metric: LightMetric, non_negative: bool) -> Self {
        let weights = match metric {
            LightMetric::Irradiance => {
                Zonal::clamped_cosine(order).convolution_factors().iter().map(|a| (a / PI).powi(2)).collect()
            }
            LightMetric::Radiance => vec![1.0; order],
        };
        Self { normalization: directional_normalization(order), weights, non_negative }
    }

    pub(crate) fn order(&self) -> usize {
        self.weights.len()
    }

    /// The weight of every coefficient, `w_l²`.
    pub(crate) fn coefficient_weights(&self) -> impl Iterator<Item = f64> + '_ {
        self.weights.iter().enumerate().flat_map(|(l, w)| core::iter::repeat_n(*w, 2 * l + 1))
    }

    /// `L_d · L_e` without DC, from `d·e`.
    fn light_by_light(&self, cosine: f64) -> f64 {
        let bands = legendre_all(self.order(), cosine).zip(&self.weights).enumerate().skip(1);
        self.normalization.powi(2) * bands.map(|(l, (p, w))| w * zonal_norm(l).powi(2) * p).sum::<f64>()
    }

    /// The intensities, and behind them the ambient light, of every channel.
    ///
    /// `products` has for each channel `L_d · f` without DC of every direction, and behind them `f_0`.
    fn solve(&self, dirs: &[Dir], products: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let count = dirs.len();
        // The DC terms of a light and of ambient light of radiance 1, whose diagonal element is 4π.
        let dc = self.normalization * zonal_norm(0);
        let ambient_unit = (4.0 * PI).sqrt();
        let w_0 = self.weights[0];
        let gram = Matrix::from_fn(count + 1, count + 1, |i, j| match (i < count, j < count) {
            (true, true) => self.light_by_light(dirs[i].dot(dirs[j]).clamp(-1.0, 1.0)) + w_0 * dc * dc,
            (false, false) => w_0 * ambient_unit * ambient_unit,
            _ => w_0 * dc * ambient_unit,
        });
        let channel = |products: &Vec<f64>| {
            let (lights, f_0) = (&products[..count], products[count]);
            if self.non_negative {
                let right = lights.iter().map(|light| light + w_0 * dc * f_0);
                let right: Vec<f64> = right.chain([w_0 * ambient_unit * f_0]).collect();
                nnls(&NormalEquations { gram: &gram, right: &right })
            } else {
                let bands = Matrix::from_fn(count, count, |i, j| gram[(i, j)] - w_0 * dc * dc);
                let x = least_squares_solution(&bands, lights);
                let ambient = (f_0 - dc * x.iter().sum::<f64>()) / ambient_unit;
                x.into_iter().chain([ambient]).collect()
            }
        };
        products.iter().map(channel).collect()
    }
}

/// All channels together.
pub(crate) fn total<T: Coefficient<Scalar = f64>>(value: T) -> f64 {
    (0..T::CHANNELS).map(|c| value.channel(c)).sum()
}
