//! The conventions of known libraries.

use core::fmt;

use crate::convention::BasisNormalization::{FourPi, MaxN, Orthonormal, Schmidt, Unnormalized};
use crate::convention::convention::{Convention, Harmonics, Meaning, PolarAxis};
use crate::convention::layout::CoefficientLayout;
use crate::convention::normalization::BasisNormalization;
use crate::error::ShError;
use crate::prelude::*;

/// A convention with its name in commands, Python and messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NamedConvention {
    name: &'static str,
    convention: Convention,
    description: &'static str,
    tried: &'static str,
}

/// An entry of the table.
const fn entry(
    name: &'static str,
    convention: Convention,
    description: &'static str,
    tried: &'static str,
) -> NamedConvention {
    NamedConvention { name, convention, description, tried }
}

/// A convention with one thing otherwise.
impl Convention {
    const fn complex(self) -> Self {
        Self { harmonics: Harmonics::Complex, ..self }
    }

    const fn scaled(self, normalization: BasisNormalization) -> Self {
        Self { normalization, ..self }
    }

    const fn with_phase(self, phase: bool) -> Self {
        Self { phase, ..self }
    }

    const fn laid_out(self, layout: CoefficientLayout) -> Self {
        Self { layout, ..self }
    }
}

/// Real, one band after the other, without the phase.
const PLAIN: Convention = Convention::LOBE.with_phase(false);
const PYSHTOOLS: Convention = PLAIN.scaled(FourPi).laid_out(CoefficientLayout::Cilm);
const SHTNS: Convention = Convention::LOBE.complex().laid_out(CoefficientLayout::OrderMajor);
const SCIPY: Convention = Convention::LOBE.complex().laid_out(CoefficientLayout::NegativeEnd);
const E3NN: Convention = Convention { polar_axis: PolarAxis::Y, ..PLAIN };
const AMBIX: Convention = Convention { meaning: Meaning::Projection, ..PLAIN.scaled(Schmidt) };
const FUMA: Convention = AMBIX.scaled(MaxN).laid_out(CoefficientLayout::FuMa);

const OF_PYSHTOOLS: &str = "pyshtools 4.14.1";
const OF_SHTNS: &str = "SHTns 3.7.5";
const OF_E3NN: &str = "e3nn-jax 0.21.0";
const OF_AMBISONICS: &str = "spharpy 1.0.1";

impl NamedConvention {
    /// All of them, an entry each.
    #[rustfmt::skip]
    pub const ALL: &'static [Self] = &[
        entry("pyshtools", PYSHTOOLS, "SHCoeffs of geodesy, its default: real, 4π, no phase", OF_PYSHTOOLS),
        entry("pyshtools-phase", PYSHTOOLS.with_phase(true), "the same with csphase=-1", OF_PYSHTOOLS),
        entry("pyshtools-orthonormal", PYSHTOOLS.scaled(Orthonormal), "normalization='ortho'", OF_PYSHTOOLS),
        entry("pyshtools-schmidt", PYSHTOOLS.scaled(Schmidt), "normalization='schmidt', as in geomagnetism", OF_PYSHTOOLS),
        entry("pyshtools-unnormalized", PYSHTOOLS.scaled(Unnormalized), "normalization='unnorm', to degree 85", OF_PYSHTOOLS),
        entry("pyshtools-complex", PYSHTOOLS.complex(), "complex, 4π, no phase", OF_PYSHTOOLS),
        entry("pyshtools-quantum", PYSHTOOLS.complex().scaled(Orthonormal).with_phase(true), "complex, normalization='ortho', csphase=-1", OF_PYSHTOOLS),
        entry("shtns", SHTNS, "its default: complex, m >= 0, orthonormal, with the phase", OF_SHTNS),
        entry("shtns-4pi", SHTNS.scaled(FourPi), "norm=sht_fourpi", OF_SHTNS),
        entry("shtns-schmidt", SHTNS.scaled(Schmidt), "norm=sht_schmidt", OF_SHTNS),
        entry("shtns-schmidt-no-phase", SHTNS.scaled(Schmidt).with_phase(false), "norm=sht_schmidt + SHT_NO_CS_PHASE", OF_SHTNS),
        entry("healpy", SHTNS, "alm of HEALPix with lmax = mmax: complex, m >= 0, orthonormal, with the phase", "healpy 1.20.1"),
        entry("scipy", SCIPY, "factors of scipy.special.sph_harm_y_all: complex, all m", "SciPy 1.17.1"),
        entry("sphericart", PLAIN, "real, orthonormal, no phase", "sphericart 2.0.4"),
        entry("e3nn", E3NN, "normalization='integral': real, orthonormal, no phase, polar axis y", OF_E3NN),
        entry("e3nn-component", E3NN.scaled(FourPi), "normalization='component'", OF_E3NN),
        entry("e3nn-norm", E3NN.scaled(Schmidt), "normalization='norm'", OF_E3NN),
        entry("ambix", AMBIX, "signals of Ambisonics, ACN order and SN3D", OF_AMBISONICS),
        entry("ambisonics-n3d", AMBIX.scaled(FourPi), "signals of Ambisonics, ACN order and N3D", OF_AMBISONICS),
        entry("fuma", FUMA, "signals of Ambisonics, W X Y Z R .. Q and maxN, to degree 3", "lengths of spharpy 1.0.1, order of Malham 2003"),
    ];

    /// The convention of this name.
    ///
    /// # Errors
    /// If there is none; the message lists all.
    pub fn find(name: &str) -> Result<&'static Self, ShError> {
        Self::ALL.iter().find(|named| named.name == name).ok_or_else(|| {
            let names = Self::ALL.iter().map(|named| named.name).collect::<Vec<_>>().join(", ");
            ShError::Options(format!("expected one of {names}, found {name:?}"))
        })
    }

    /// The name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// What the numbers are.
    #[must_use]
    pub const fn convention(&self) -> Convention {
        self.convention
    }

    /// The convention in a few words.
    #[must_use]
    pub const fn description(&self) -> &'static str {
        self.description
    }

    /// The library and its version that has evaluated such numbers.
    #[must_use]
    pub const fn tried(&self) -> &'static str {
        self.tried
    }
}

impl fmt::Display for NamedConvention {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_found_and_stands_once() {
        for (k, named) in NamedConvention::ALL.iter().enumerate() {
            assert_eq!(NamedConvention::find(named.name()).unwrap(), named, "{named}");
            assert!(NamedConvention::ALL[..k].iter().all(|other| other.name != named.name), "{named} stands twice");
            assert!(!named.description().is_empty() && !named.tried().is_empty(), "{named}");
        }
        let error = NamedConvention::find("mathematica").unwrap_err().to_string();
        assert!(error.contains("pyshtools, pyshtools-phase") && error.contains("mathematica"), "{error}");
    }
}
