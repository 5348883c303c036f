//! All irradiance encodings in one enum, to loop over, and their errors.

use core::fmt;
use core::str::FromStr;

use crate::encoding::ahd::Ahd;
use crate::encoding::ambient_cube::AmbientCube;
use crate::encoding::h_basis::{HBasis4, HBasis6};
use crate::encoding::hemisphere::hemisphere_least_squares;
use crate::encoding::hl2::Hl2;
use crate::encoding::non_linear_l1::NonLinearL1;
use crate::encoding::zh3::{Zh3, Zh3Axis};
use crate::error::ShError;
use crate::expansion::{Expansion, Sh};
use crate::prelude::*;
use crate::rotation::Rotation;
use crate::rotation::rotation::tangent_frame;
use crate::scalar::{Coefficient, Real as _};
use crate::sphere::Dir;
use crate::sphere::point_sets::even_directions;

/// An encoding of irradiance in a few numbers. [`IrradianceEncoding::ALL`] lists them.
///
/// ```
/// use lobe_sh::encoding::IrradianceEncoding;
/// use lobe_sh::{Dir, Rgb, Rotation, Zonal};
///
/// let sun = Zonal::clamped_cosine(9).towards(Dir::X, Rgb::new(1.0, 0.9, 0.8));
/// for encoding in IrradianceEncoding::ALL {
///     let encoded = encoding.encode(&sun, Rotation::from_axis_angle(Dir::Y, 90.0_f64.to_radians()));
///     println!("{}, {} floats: {:?}", encoding.name(), encoding.floats(3), encoded.eval(Dir::X));
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IrradianceEncoding {
    /// Bands 0 and 1.
    Sh2,
    /// Bands 0 to 2.
    Sh3,
    /// Bands 0 to 2 and 4: order 5, whose band 3 has no part in irradiance.
    Sh5,
    /// [`NonLinearL1`].
    NonLinearL1,
    /// [`Zh3::hallucinated`].
    Zh3Hallucinated(Zh3Axis),
    /// [`Zh3::projected`].
    Zh3Projected(Zh3Axis),
    /// [`Zh3::solved`].
    Zh3Solved(Zh3Axis),
    /// [`AmbientCube::from_axes`].
    AmbientCubeAxes,
    /// [`AmbientCube::from_irradiance_sh`].
    AmbientCubeFitted,
    /// [`Ahd::linear`].
    AhdLinear,
    /// [`Ahd::solved`].
    AhdSolved,
    /// [`HBasis4`].
    HBasis4,
    /// [`HBasis6`].
    HBasis6,
    /// Bands 0 to 2 by [`hemisphere_least_squares`].
    HemisphereSh3,
    /// [`Hl2::from_directions`].
    Hl2,
    /// [`Hl2::linear`].
    Hl2Linear,
}

impl IrradianceEncoding {
    /// Every encoding: first those of the whole sphere, then those of a hemisphere.
    pub const ALL: [Self; 19] = [
        Self::Sh2,
        Self::Sh3,
        Self::Sh5,
        Self::NonLinearL1,
        Self::Zh3Hallucinated(Zh3Axis::Luminance),
        Self::Zh3Hallucinated(Zh3Axis::PerChannel),
        Self::Zh3Projected(Zh3Axis::Luminance),
        Self::Zh3Projected(Zh3Axis::PerChannel),
        Self::Zh3Solved(Zh3Axis::Luminance),
        Self::Zh3Solved(Zh3Axis::PerChannel),
        Self::AmbientCubeAxes,
        Self::AmbientCubeFitted,
        Self::AhdLinear,
        Self::AhdSolved,
        Self::HBasis4,
        Self::HBasis6,
        Self::HemisphereSh3,
        Self::Hl2,
        Self::Hl2Linear,
    ];

    /// A short name in lower case with hyphens.
    #[must_use]
    pub const fn name(self) -> &'static str {
        use Zh3Axis::{Luminance, PerChannel};
        match self {
            Self::Sh2 => "sh-2",
            Self::Sh3 => "sh-3",
            Self::Sh5 => "sh-5",
            Self::NonLinearL1 => "non-linear-l1",
            Self::Zh3Hallucinated(Luminance) => "zh3-hallucinated",
            Self::Zh3Hallucinated(PerChannel) => "zh3-hallucinated-per-channel",
            Self::Zh3Projected(Luminance) => "zh3",
            Self::Zh3Projected(PerChannel) => "zh3-per-channel",
            Self::Zh3Solved(Luminance) => "zh3-solved",
            Self::Zh3Solved(PerChannel) => "zh3-solved-per-channel",
            Self::AmbientCubeAxes => "ambient-cube-axes",
            Self::AmbientCubeFitted => "ambient-cube",
            Self::AhdLinear => "ahd-linear",
            Self::AhdSolved => "ahd",
            Self::HBasis4 => "h-4",
            Self::HBasis6 => "h-6",
            Self::HemisphereSh3 => "sh-3-hemisphere",
            Self::Hl2 => "hl2",
            Self::Hl2Linear => "hl2-linear",
        }
    }

    /// The count of numbers for an irradiance of `channels` channels; a direction counts as three.
    #[must_use]
    pub const fn floats(self, channels: usize) -> usize {
        match self {
            Self::Sh2 | Self::NonLinearL1 | Self::Zh3Hallucinated(_) | Self::HBasis4 => 4 * channels,
            Self::Zh3Projected(_) | Self::Zh3Solved(_) => 5 * channels,
            Self::AmbientCubeAxes | Self::AmbientCubeFitted | Self::HBasis6 => 6 * channels,
            Self::Sh3 | Self::HemisphereSh3 => 9 * channels,
            Self::Sh5 => 18 * channels,
            Self::AhdLinear | Self::AhdSolved => 2 * channels + 3,
            Self::Hl2 | Self::Hl2Linear => 3 * channels,
        }
    }

    /// True if it holds only the normals on one side of a surface, at most 90° from its geometric normal.
    #[must_use]
    pub const fn is_hemispherical(self) -> bool {
        matches!(self, Self::HBasis4 | Self::HBasis6 | Self::HemisphereSh3 | Self::Hl2 | Self::Hl2Linear)
    }

    /// Encodes an irradiance given by its expansion.
    ///
    /// `frame`, `world_from_tangent`, takes +z to the geometric normal; encodings of the whole sphere ignore it.
    /// Encodings that are published as samples ([`AmbientCube::from_axes`], [`Hl2::from_directions`]) sample the
    /// expansion, which therefore needs enough bands.
    #[must_use]
    pub fn encode<T: Coefficient>(self, irradiance: &impl Expansion<T>, frame: Rotation) -> EncodedIrradiance<T> {
        use EncodedIrradiance as E;
        let e = irradiance;
        match self {
            Self::Sh2 => E::Sh2(Sh::from_slice(e.coefficients())),
            Self::Sh3 => E::Sh3(Sh::from_slice(e.coefficients())),
            Self::Sh5 => E::Sh5(four_bands(e)),
            Self::NonLinearL1 => E::NonLinearL1(NonLinearL1::from_irradiance_sh(e)),
            Self::Zh3Hallucinated(axis) => E::Zh3(Zh3::hallucinated(e, axis)),
            Self::Zh3Projected(axis) => E::Zh3(Zh3::projected(e, axis)),
            Self::Zh3Solved(axis) => E::Zh3(Zh3::solved(e, axis)),
            Self::AmbientCubeAxes => E::AmbientCube(AmbientCube::from_axes(|n| e.eval(n))),
            Self::AmbientCubeFitted => E::AmbientCube(AmbientCube::from_irradiance_sh(e)),
            Self::AhdLinear => E::Ahd(Ahd::linear(e)),
            Self::AhdSolved => E::Ahd(Ahd::solved(e)),
            Self::HBasis4 => E::HBasis4(HBasis4::from_irradiance_sh(e, frame)),
            Self::HBasis6 => E::HBasis6(HBasis6::from_irradiance_sh(e, frame)),
            Self::HemisphereSh3 => {
                let fit = hemisphere_least_squares(3, frame.rotate_dir(Dir::Z), e);
                E::Sh3(Sh::from_slice(fit.coefficients()))
            }
            Self::Hl2 => E::Hl2(Hl2::from_directions(frame, |n| e.eval(n))),
            Self::Hl2Linear => E::Hl2(Hl2::linear(e, frame)),
        }
    }
}

/// Bands 0 to 2 and 4; band 3, of which the clamped cosine lets nothing through, is zero.
fn four_bands<T: Coefficient>(e: &impl Expansion<T>) -> Sh<25, T> {
    let mut bands = Sh::<25, T>::from_slice(e.coefficients());
    bands.band_mut(3).fill(T::ZERO);
    bands
}

impl fmt::Display for IrradianceEncoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for IrradianceEncoding {
    type Err = ShError;

    /// The encoding of a [name](Self::name).
    fn from_str(name: &str) -> Result<Self, ShError> {
        let found = Self::ALL.into_iter().find(|encoding| encoding.name() == name);
        let known = || Self::ALL.map(Self::name).join(", ");
        found.ok_or_else(|| ShError::Options(format!("expected one of {}; found '{name}'", known())))
    }
}

/// The result of [`IrradianceEncoding::encode`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum EncodedIrradiance<T = f32> {
    /// Bands 0 and 1.
    Sh2(Sh<4, T>),
    /// Bands 0 to 2.
    Sh3(Sh<9, T>),
    /// Bands 0 to 4; band 3 is zero.
    Sh5(Sh<25, T>),
    /// Bands 0 and 1, evaluated non-linearly.
    NonLinearL1(NonLinearL1<T>),
    /// Bands 0 and 1 and a zonal coefficient.
    Zh3(Zh3<T>),
    /// Six colors.
    AmbientCube(AmbientCube<T>),
    /// A constant and a directional light.
    Ahd(Ahd<T>),
    /// Four coefficients of a hemisphere.
    HBasis4(HBasis4<T>),
    /// Six coefficients of a hemisphere.
    HBasis6(HBasis6<T>),
    /// Three colors of a hemisphere.
    Hl2(Hl2<T>),
}

impl<T: Coefficient> EncodedIrradiance<T> {
    /// The numbers that are kept, by name: of a coefficient or a color its channels, of a direction x, y and z. Coefficients are
    /// counted from 0, those of a hemisphere from 1, as their sources do; of order 5 band 3 is not among them. The zonal coefficients of a hallucinated [`Zh3`] are among them,
    /// though a shader can find them again.
    #[must_use]
    pub fn numbers(&self) -> Vec<(String, Vec<f64>)> {
        let channels = |value: &T| -> Vec<f64> { (0..T::CHANNELS).map(|c| value.channel(c).to_f64()).collect() };
        let one = |name: &str, value: &T| (name.into(), channels(value));
        let counted = |name: &str, first: usize, all: &[T]| -> Vec<(String, Vec<f64>)> {
            all.iter().enumerate().map(|(k, value)| (format!("{name}_{}", first + k), channels(value))).collect()
        };
        match self {
            Self::Sh2(e) => counted("E", 0, e.coefficients()),
            Self::Sh3(e) => counted("E", 0, e.coefficients()),
            Self::Sh5(e) => {
                let mut numbers = counted("E", 0, &e.coefficients()[..9]);
                numbers.extend(counted("E", 16, e.band(4)));
                numbers
            }
            Self::NonLinearL1(e) => counted("E", 0, e.linear.coefficients()),
            Self::Zh3(e) => {
                let mut numbers = counted("E", 0, e.linear.coefficients());
                numbers.push(one("zonal", &e.zonal));
                numbers
            }
            Self::AmbientCube(e) => {
                let faces = ["+x", "-x", "+y", "-y", "+z", "-z"];
                faces.into_iter().zip(&e.faces).map(|(name, value)| one(name, value)).collect()
            }
            Self::Ahd(e) => vec![
                one("ambient", &e.ambient),
                one("highlight", &e.highlight),
                ("direction".into(), e.direction.to_array().to_vec()),
            ],
            Self::HBasis4(e) => counted("H", 1, &e.coefficients),
            Self::HBasis6(e) => counted("H", 1, &e.coefficients),
            Self::Hl2(e) => counted("c", 1, &e.colors),
        }
    }

    /// The irradiance of a surface with normal `n`.
    #[must_use]
    pub fn eval(&self, n: Dir) -> T {
        match self {
            Self::Sh2(e) => e.eval(n),
            Self::Sh3(e) => e.eval(n),
            Self::Sh5(e) => e.eval(n),
            Self::NonLinearL1(e) => e.eval(n),
            Self::Zh3(e) => e.eval(n),
            Self::AmbientCube(e) => e.eval(n),
            Self::Ahd(e) => e.eval(n),
            Self::HBasis4(e) => e.eval(n),
            Self::HBasis6(e) => e.eval(n),
            Self::Hl2(e) => e.eval(n),
        }
    }
}

/// The number of surfaces over which the error of a hemispherical encoding is averaged.
const SURFACES: usize = 32;

/// The error of an encoding over all normals and channels; `mean`, `rms` and `max` in units of the mean irradiance over
/// all channels and normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncodingError {
    /// The mean of `|found - true|`.
    pub mean: f64,
    /// The root of the mean of `(found - true)²`.
    pub rms: f64,
    /// The largest `|found - true|`.
    pub max: f64,
    /// The lowest irradiance, in the unit of the values: negative if the encoding rings.
    pub lowest: f64,
}

/// Encodes `irradiance` and compares it with the true values, given for normals that cover the sphere evenly.
///
/// A hemispherical encoding is made for 32 surfaces whose normals cover the sphere evenly, and compared for the normals
/// within 90° of each. Without values the errors are NaN; if the mean irradiance is 0, they are NaN or infinite.
#[must_use]
pub fn encoding_error<T: Coefficient>(
    encoding: IrradianceEncoding,
    irradiance: &impl Expansion<T>,
    truth: &[(Dir, T)],
) -> EncodingError {
    let channels = |value: T| (0..T::CHANNELS).map(move |c| value.widen().channel(c));
    let count = (truth.len() * T::CHANNELS) as f64;
    let unit = truth.iter().flat_map(|(_, e)| channels(*e)).sum::<f64>() / count;
    let frames = match encoding.is_hemispherical() {
        true => even_directions(SURFACES).map(|normal| Some((normal, tangent_frame(normal)))).collect(),
        false => vec![None],
    };
    let (mut sum, mut squares, mut terms) = (0.0, 0.0, 0_usize);
    let (mut max, mut lowest) = (0.0, f64::INFINITY);
    for surface in frames {
        let encoded = encoding.encode(irradiance, surface.map_or(Rotation::IDENTITY, |(_, frame)| frame));
        for (n, expected) in truth.iter().filter(|(n, _)| surface.is_none_or(|(normal, _)| n.dot(normal) >= 0.0)) {
            for (a, b) in channels(encoded.eval(*n)).zip(channels(*expected)) {
                let error = (a - b).abs();
                sum += error;
                squares += error * error;
                terms += 1;
                // NaN is larger than anything.
                max = if error.is_nan() || error > max { error } else { max };
                lowest = if a.is_nan() || a < lowest { a } else { lowest };
            }
        }
    }
    let terms = terms as f64;
    EncodingError { mean: sum / terms / unit, rms: (squares / terms).sqrt() / unit, max: max / unit, lowest }
}
