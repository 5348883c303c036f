//! Environments of Babylon.js, `.env` of version 1: a prefiltered cube as small pictures, and the light of diffuse
//! surfaces as a polynomial.
//!
//! ```text
//!   86 16 87 96 f6 d6 96 36      eight bytes
//!   JSON and a zero              version, width, irradiance, specular: lengths and positions of the pictures
//!   pictures                     RGBD in PNG; level after level down to 1 texel, six faces +X, -X, +Y, -Y, +Z, -Z each
//! ```
//!
//! The pictures are the faces of a left-handed cube with the lowest row on top. The polynomial of `irradiance` is not
//! that of E: Babylon's reader makes `B_i = A_l S_i / π` of it ([`EngineForm::Babylon`]), the inverse of
//!
//! ```text
//!   x = -2 c_2 B_3/π      y = -2 c_2 B_1/π      z = 2 c_2 B_2/π
//!   xx, yy = (c_4 B_0 - c_5 B_6 ± c_1 B_8)/π    zz = (c_4 B_0 + 2 c_5 B_6)/π
//!   yz = -2 c_1 B_5/π     zx = -2 c_1 B_7/π     xy = 2 c_1 B_4/π
//! ```
//!
//! with `c_1` to `c_5` of [`IrradiancePolynomial`]. Facts from Babylon.js 9.35, `sphericalPolynomial` and
//! `environmentTextureTools`, seen to hold by running it (`peers/engines`).

use std::f64::consts::PI;

use lobe_image::{ImageError, PictureWriteReport, RGBD_MAX, encode_rgbd, mip_level_count};
use lobe_io::parallel;
use lobe_sh::encoding::{EngineForm, IrradiancePolynomial};
use lobe_sh::{Coefficient as _, Rgb, ShL2};
use serde::{Deserialize, Serialize};

use crate::error::EnvError;
use crate::map::cube_handedness::CubeHandedness;
use crate::map::cube_mip_chain::CubeMipChain;
use crate::mapping::cube::FACES;
use crate::prefilter::roughness_levels::BABYLON_SCALE;

/// The first eight bytes.
const MAGIC: [u8; 8] = [0x86, 0x16, 0x87, 0x96, 0xf6, 0xd6, 0x96, 0x36];

/// The description in front of the pictures.
#[derive(Serialize, Deserialize)]
struct Manifest {
    version: u32,
    width: usize,
    irradiance: Option<Polynomial>,
    specular: Specular,
}

#[derive(Serialize, Deserialize)]
struct Polynomial {
    x: [f64; 3],
    y: [f64; 3],
    z: [f64; 3],
    xx: [f64; 3],
    yy: [f64; 3],
    zz: [f64; 3],
    yz: [f64; 3],
    zx: [f64; 3],
    xy: [f64; 3],
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Specular {
    mipmaps: Vec<Place>,
    #[serde(default)]
    lod_generation_scale: f64,
}

/// Where a picture lies behind the zero.
#[derive(Serialize, Deserialize)]
struct Place {
    length: usize,
    #[serde(default)]
    position: usize,
}

/// The bytes of a `.env` file: a chain down to faces of one texel, whose roughness is that of
/// [`RoughnessLevels::Babylon`](crate::RoughnessLevels::Babylon), and the light that it was made from. The report
/// counts texels beyond 0 to 255, which are clamped.
///
/// # Errors
/// [`EnvError::Options`] if the faces have no power of two as their size, or levels are missing.
pub fn encode_babylon_env(
    chain: &CubeMipChain,
    light: &ShL2<Rgb<f64>>,
) -> Result<(Vec<u8>, PictureWriteReport), EnvError> {
    let size = chain.base().size();
    let (expected, found) = (mip_level_count(size), chain.levels().len());
    if !size.is_power_of_two() || found != expected {
        let text = format!("a .env has faces of 2^n texels with all levels, not of {size} with {found} levels");
        return Err(EnvError::Options(text));
    }
    let turned: Vec<_> = chain.levels().iter().map(|level| level.faces(CubeHandedness::Left)).collect();
    let encode = |i: usize| {
        let level = &chain.levels()[i / FACES];
        let face = &turned[i / FACES][i % FACES];
        let rows: Vec<Rgb<f32>> = face.chunks(level.size()).rev().flatten().copied().collect();
        encode_rgbd(level.size(), &rows)
    };
    let pictures = parallel::map(FACES * found, &encode).into_iter().collect::<Result<Vec<_>, ImageError>>()?;
    let mut position = 0;
    let mipmaps = pictures.iter().map(|(bytes, _)| {
        let place = Place { length: bytes.len(), position };
        position += bytes.len();
        place
    });
    let specular = Specular { mipmaps: mipmaps.collect(), lod_generation_scale: BABYLON_SCALE };
    let manifest = Manifest { version: 1, width: size, irradiance: Some(Polynomial::of(light)), specular };
    let json = serde_json::to_vec(&manifest).map_err(|error| EnvError::Options(error.to_string()))?;
    let mut bytes = [&MAGIC[..], &json, &[0]].concat();
    let mut report = PictureWriteReport::default();
    for (picture, clamped) in pictures {
        bytes.extend(picture);
        report.clamped += clamped;
    }
    report.lost = chain.base().share_beyond(RGBD_MAX);
    Ok((bytes, report))
}

/// Whether bytes begin as a `.env` of Babylon.js.
pub(crate) fn is_babylon_env(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// The light of diffuse surfaces in a `.env` of version 1 or 2.
pub(crate) fn light_of_babylon_env(bytes: &[u8], name: &str) -> Result<ShL2<Rgb<f64>>, EnvError> {
    let (manifest, _) = manifest(bytes, name)?;
    let polynomial = manifest.irradiance.ok_or_else(|| invalid(name, "it has no irradiance as a polynomial"))?;
    Ok(polynomial.light())
}

/// The description, and the bytes behind it.
fn manifest<'a>(bytes: &'a [u8], name: &str) -> Result<(Manifest, &'a [u8]), EnvError> {
    let rest = bytes.strip_prefix(&MAGIC).ok_or_else(|| invalid(name, "its first eight bytes are others"))?;
    let end = rest.iter().position(|byte| *byte == 0);
    let end = end.ok_or_else(|| invalid(name, "the file ends early: the description is not all there"))?;
    let manifest = serde_json::from_slice(&rest[..end]).map_err(|error| invalid(name, &error.to_string()))?;
    Ok((manifest, &rest[end + 1..]))
}

fn invalid(name: &str, message: &str) -> EnvError {
    ImageError::Invalid { place: name.to_owned(), message: format!("damaged .env of Babylon.js: {message}") }.into()
}

impl Polynomial {
    fn of(light: &ShL2<Rgb<f64>>) -> Self {
        let b = EngineForm::Babylon.encode(light).map(|color| color.scale(1.0 / PI));
        let [c_1, c_2, _, c_4, c_5] = IrradiancePolynomial::constants();
        let linear = |i: usize, sign: f64| b[i].scale(sign * 2.0 * c_2).to_array();
        let mixed = |i: usize, sign: f64| b[i].scale(sign * 2.0 * c_1).to_array();
        let pure = |of_6: f64, of_8: f64| (b[0].scale(c_4) + b[6].scale(of_6) + b[8].scale(of_8)).to_array();
        Self {
            x: linear(3, -1.0),
            y: linear(1, -1.0),
            z: linear(2, 1.0),
            xx: pure(-c_5, c_1),
            yy: pure(-c_5, -c_1),
            zz: pure(2.0 * c_5, 0.0),
            yz: mixed(5, -1.0),
            zx: mixed(7, -1.0),
            xy: mixed(4, 1.0),
        }
    }

    fn light(&self) -> ShL2<Rgb<f64>> {
        let [c_1, c_2, _, c_4, c_5] = IrradiancePolynomial::constants();
        let scaled = |values: &[f64; 3], factor: f64| Rgb::from(*values).scale(PI * factor);
        let linear = |values, sign: f64| scaled(values, sign / (2.0 * c_2));
        let mixed = |values, sign: f64| scaled(values, sign / (2.0 * c_1));
        let [xx, yy, zz] = [&self.xx, &self.yy, &self.zz].map(|values| scaled(values, 1.0));
        let colors = [
            (xx + yy + zz).scale(1.0 / (3.0 * c_4)),
            linear(&self.y, -1.0),
            linear(&self.z, 1.0),
            linear(&self.x, -1.0),
            mixed(&self.xy, 1.0),
            mixed(&self.yz, -1.0),
            (zz.scale(2.0) - xx - yy).scale(1.0 / (6.0 * c_5)),
            mixed(&self.zx, -1.0),
            (xx - yy).scale(1.0 / (2.0 * c_1)),
        ];
        EngineForm::Babylon.decode(&colors)
    }
}

#[cfg(test)]
mod tests {
    use lobe_image::mip_level_size;
    use lobe_sh::Expansion as _;
    use lobe_testkit::Random;

    use super::*;
    use crate::map::cube_map::CubeMap;

    /// A picture as Babylon.js decodes it: (c/255)^2.2 / D, rows from the lowest on.
    fn decoded(png: &[u8]) -> Vec<Rgb<f32>> {
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut samples = vec![0; reader.output_buffer_size().unwrap()];
        let size = reader.next_frame(&mut samples).unwrap().width as usize;
        let light = |[r, g, b, d]: &[u8; 4]| {
            Rgb::from([*r, *g, *b].map(|c| (f32::from(c) / 255.0).powf(2.2) * 255.0 / f32::from(*d)))
        };
        let texels: Vec<_> = samples.as_chunks::<4>().0.iter().map(light).collect();
        texels.chunks(size).rev().flatten().copied().collect()
    }

    fn light() -> ShL2<Rgb<f64>> {
        let values = Random::new(3).signed_vec(27);
        ShL2::from(std::array::from_fn(|i| Rgb::new(values[3 * i], values[3 * i + 1], values[3 * i + 2])))
    }

    fn chain(size: usize) -> CubeMipChain {
        CubeMipChain::averaged(CubeMap::from_fn(size, |s| {
            Rgb::new(1.5 + s.x() as f32, 2.0 + s.y() as f32, (3.0 * s.z() as f32).exp())
        }))
    }

    #[test]
    fn chain_and_light_come_back() {
        let (chain, light) = (chain(16), light());
        let (bytes, report) = encode_babylon_env(&chain, &light).unwrap();
        assert_eq!(report, PictureWriteReport::default(), "nothing is clamped");
        let back = light_of_babylon_env(&bytes, "test").unwrap();
        for (i, (a, b)) in back.coefficients().iter().zip(light.coefficients()).enumerate() {
            let error = (*a - *b).to_array().into_iter().map(f64::abs).max_by(f64::total_cmp).unwrap();
            assert!(error < 1e-14, "coefficient {i}: {a:?}, expected {b:?}");
        }
        let (manifest, data) = manifest(&bytes, "test").unwrap();
        let pictures = manifest.specular.mipmaps;
        assert_eq!(pictures.len(), FACES * chain.levels().len(), "a picture for each face of each level");
        for (k, (places, expected)) in pictures.chunks(FACES).zip(chain.levels()).enumerate() {
            let faces = std::array::from_fn(|face| {
                let Place { length, position } = places[face];
                decoded(&data[position..position + length])
            });
            let found = CubeMap::from_handed_faces(mip_level_size(16, k), &faces, CubeHandedness::Left).unwrap();
            for (a, b) in found.texels().iter().zip(expected.texels()) {
                // Eight bits of the root of 2.2, divided by D.
                let most = 0.005 * b.r.max(b.g).max(b.b).max(1.0);
                let error = (*a - *b).to_array().into_iter().map(f32::abs).max_by(f32::total_cmp).unwrap();
                assert!(error < most, "level {k}: {a:?}, expected {b:?}");
            }
        }
    }

    #[test]
    fn the_polynomial_is_read_by_the_constants_of_babylon() {
        // Those of its FromPolynomial, six digits; B_i over π.
        let light = light();
        let b = EngineForm::Babylon.encode(&light);
        let p = Polynomial::of(&light);
        let of = |c: usize| {
            [
                0.376127 * (p.xx[c] + p.yy[c]) + 0.376126 * p.zz[c],
                -0.977204 * p.y[c],
                0.977204 * p.z[c],
                -0.977204 * p.x[c],
                1.16538 * p.xy[c],
                -1.16538 * p.yz[c],
                1.34567 * p.zz[c] - 0.672834 * (p.xx[c] + p.yy[c]),
                -1.16538 * p.zx[c],
                1.16538 * (p.xx[c] - p.yy[c]),
            ]
        };
        for (i, b) in b.iter().enumerate() {
            let found = Rgb::from_channels(|c| PI * of(c)[i]);
            let error = (found - *b).to_array().into_iter().fold(0.0, |worst: f64, e| worst.max(e.abs()));
            assert!(error < 2e-5, "B_{i}: {found:?}, expected {b:?}");
        }
    }

    #[test]
    fn damaged_files_are_refused() {
        let (bytes, _) = encode_babylon_env(&chain(2), &light()).unwrap();
        let error = |bytes: &[u8]| light_of_babylon_env(bytes, "test").unwrap_err().to_string();
        for (what, damaged) in [("without a zero", &bytes[..40]), ("other", &b"PNG"[..])] {
            let said = error(damaged);
            assert!(said.starts_with("test: damaged"), "{what}: {said}");
        }
        assert!(
            encode_babylon_env(&CubeMipChain::single(chain(4).into_base()), &light()).is_err(),
            "levels are missing"
        );
    }
}
