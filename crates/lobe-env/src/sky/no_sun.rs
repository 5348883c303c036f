//! Why a map has no sun, or no further one.

use std::fmt;

use lobe_sh::Dir;

/// The property of a sun that the brightest place of a map lacks.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoSun {
    /// Nothing shines.
    Dark,
    /// It is only `times` as bright as the mean of the map ([`SunOptions::min_peak`](crate::SunOptions::min_peak)).
    Dim {
        /// Where it is.
        at: Dir,
        /// How many times as bright it is.
        times: f64,
    },
    /// It is too large ([`SunOptions::max_radius`](crate::SunOptions::max_radius)).
    Large {
        /// Where it is.
        at: Dir,
        /// Its radius in radians, as far as it was looked at.
        radius: f64,
    },
    /// It is only `times` as bright as what surrounds it
    /// ([`SunOptions::min_contrast`](crate::SunOptions::min_contrast)).
    Faint {
        /// Where it is.
        at: Dir,
        /// How many times as bright it is.
        times: f64,
    },
    /// Many places near it are as bright, or nothing else is left around it.
    Crowded {
        /// Where it is.
        at: Dir,
    },
}

impl fmt::Display for NoSun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = |at: &Dir| {
            let [x, y, z] = at.to_array().map(|c| c + 0.0);
            format!("the brightest place, towards {x:.3},{y:.3},{z:.3},")
        };
        match self {
            Self::Dark => f.write_str("nothing shines"),
            Self::Dim { at, times } => write!(f, "{} is {times:.3} times as bright as the mean", place(at)),
            Self::Large { at, radius } => {
                write!(f, "{} has a radius of {:.1}° or more", place(at), radius.to_degrees())
            }
            Self::Faint { at, times } => write!(f, "{} is {times:.3} times as bright as what surrounds it", place(at)),
            Self::Crowded { at } => write!(f, "{} has many others beside it", place(at)),
        }
    }
}
