//! Color profiles of the ICC: primaries, and the curve from values to light.
//!
//! Only profiles of three primaries with one curve are understood, the kind that cameras, phones and editors write: the tags `rXYZ`, `gXYZ`,
//! `bXYZ` and `rTRC`, `gTRC`, `bTRC` ([ICC 2022], 9.2 and 10). Profiles of tables, of gray and of inks are not.

use crate::picture::primaries::Primaries;
use crate::picture::srgb::srgb_decode;

/// Values of a curve are compared at this many places.
const PLACES: usize = 33;

/// Curves that differ by less are the same: profiles round to 16 bits, some tables have 1024 entries.
const SAME: f64 = 2e-3;

/// What a profile says.
pub(crate) struct Profile {
    pub(crate) primaries: Primaries,
    pub(crate) curve: Curve,
}

/// How values become light.
pub(crate) enum Curve {
    Srgb,
    Linear,
    /// The tag of the curve.
    Tag(Vec<u8>),
}

impl Curve {
    /// The light of a value, of which 1 is white. Negative values, colors outside of the gamut, lie mirrored.
    pub(crate) fn light(&self, value: f64) -> f64 {
        let light = match self {
            Self::Srgb => srgb_decode(value.abs()),
            Self::Linear => value.abs(),
            Self::Tag(tag) => light(tag, value.abs()).unwrap_or(value.abs()),
        };
        light.copysign(value)
    }

    fn of(tag: &[u8]) -> Option<Self> {
        let places = (0..PLACES).map(|k| k as f64 / (PLACES - 1) as f64);
        let values: Vec<_> = places.map(|value| Some((value, light(tag, value)?))).collect::<Option<_>>()?;
        let is = |curve: &dyn Fn(f64) -> f64| values.iter().all(|(value, light)| (light - curve(*value)).abs() < SAME);
        if values.iter().any(|(_, light)| !light.is_finite()) {
            return None;
        }
        Some(if is(&srgb_decode) {
            Self::Srgb
        } else if is(&|value| value) {
            Self::Linear
        } else {
            Self::Tag(tag.to_vec())
        })
    }
}

impl Profile {
    /// The profile in these bytes; none if it is of another kind or damaged.
    pub(crate) fn parse(bytes: &[u8]) -> Option<Self> {
        if bytes.get(16..24)? != b"RGB XYZ " || bytes.get(36..40)? != b"acsp" {
            return None;
        }
        let tags = Tags(bytes);
        let [red, green, blue] = [b"rXYZ", b"gXYZ", b"bXYZ"].map(|name| tags.xyz(name));
        let primaries = Primaries::of_profile([red?, green?, blue?])?;
        let [curve, others @ ..] = [b"rTRC", b"gTRC", b"bTRC"].map(|name| tags.find(name));
        let is_one = others.iter().all(|other| *other == curve);
        Some(Self { primaries, curve: Curve::of(curve.filter(|_| is_one)?)? })
    }
}

/// The table of tags of a profile: a name, where it is and its length.
struct Tags<'a>(&'a [u8]);

impl<'a> Tags<'a> {
    fn find(&self, name: &[u8; 4]) -> Option<&'a [u8]> {
        let count = word(self.0, 128)? as usize;
        let entries = self.0.get(132..)?.chunks_exact(12).take(count);
        let entry = entries.into_iter().find(|entry| entry.starts_with(name))?;
        let (start, length) = (word(entry, 4)? as usize, word(entry, 8)? as usize);
        self.0.get(start..start.checked_add(length)?)
    }

    fn xyz(&self, name: &[u8; 4]) -> Option<[f64; 3]> {
        let tag = self.find(name).filter(|tag| tag.starts_with(b"XYZ "))?;
        Some([fixed(tag, 8)?, fixed(tag, 12)?, fixed(tag, 16)?])
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_be_bytes(*bytes.get(at..)?.first_chunk()?))
}

/// A number with 16 bits behind the point.
fn fixed(bytes: &[u8], at: usize) -> Option<f64> {
    Some(f64::from(word(bytes, at)?.cast_signed()) / 65536.0)
}

/// The light of a value by a curve: a power, a table, or one of the functions of parameters.
fn light(curve: &[u8], value: f64) -> Option<f64> {
    let half = |at: usize| Some(f64::from(u16::from_be_bytes(*curve.get(at..)?.first_chunk()?)));
    if curve.starts_with(b"para") {
        let [g, a, b, c, d, e, f] = [0, 1, 2, 3, 4, 5, 6].map(|k| fixed(curve, 12 + 4 * k).unwrap_or(0.0));
        let power = |value: f64| (a * value + b).max(0.0).powf(g);
        return Some(match curve.get(8..10)? {
            [0, 0] => value.powf(g),
            [0, 1] => {
                if value >= -b / a {
                    power(value)
                } else {
                    0.0
                }
            }
            [0, 2] => {
                if value >= -b / a {
                    power(value) + c
                } else {
                    c
                }
            }
            [0, 3] => {
                if value >= d {
                    power(value)
                } else {
                    c * value
                }
            }
            [0, 4] => {
                if value >= d {
                    power(value) + e
                } else {
                    c * value + f
                }
            }
            _ => return None,
        });
    }
    match word(curve, 8).filter(|_| curve.starts_with(b"curv"))? as usize {
        0 => Some(value),
        1 => Some(value.powf(half(12)? / 256.0)),
        count => {
            let place = value * (count - 1) as f64;
            let first = (place as usize).min(count - 2);
            let (low, high) = (half(12 + 2 * first)?, half(14 + 2 * first)?);
            Some((low + (high - low) * (place - first as f64)) / 65535.0)
        }
    }
}
