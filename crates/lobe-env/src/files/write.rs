//! Writers of maps.

use std::path::Path;

use derive_setters::Setters;
use lobe_image::{
    ImageError, PictureWriteOptions, PictureWriteReport, TexelFormat, TextureNotes, encode_cube_texture,
    encode_picture, write_cube_texture, write_pixels,
};
use lobe_sh::encoding::EngineForm;
use lobe_sh::rotation::Axis;
use lobe_sh::{Rgb, ShL2};

use crate::map::cube_handedness::CubeHandedness;
use crate::map::cube_mip_chain::CubeMipChain;
use crate::map::mapped_map::MappedMap;

/// Writes a map as a picture in its mapping; [`lobe_image::write_picture`] lists the formats.
///
/// Where the proportions of the picture do not tell the mapping ([`MappedMap::untold_mapping`]), the file keeps its name, and
/// [`read_map`](crate::read_map()) finds it again.
///
/// # Errors
/// Those of [`lobe_image::write_picture`].
pub fn write_env(
    path: impl AsRef<Path>,
    map: &MappedMap,
    options: &PictureWriteOptions,
) -> Result<PictureWriteReport, ImageError> {
    let report = write_pixels(path, map.width(), map.texels(), &with_mapping(options, map))?;
    Ok(of_directions(report, map))
}

/// The bytes that [`write_env`] writes; the extension of the path says the format.
///
/// # Errors
/// Those of [`lobe_image::encode_picture`].
pub fn encode_env(
    path: &Path,
    map: &MappedMap,
    options: &PictureWriteOptions,
) -> Result<(Vec<u8>, PictureWriteReport), ImageError> {
    let (bytes, report) = encode_picture(path, map.width(), map.texels(), &with_mapping(options, map))?;
    Ok((bytes, of_directions(report, map)))
}

/// The report with the share of the light of all directions; only halves lose light.
fn of_directions(mut report: PictureWriteReport, map: &MappedMap) -> PictureWriteReport {
    if report.lost > 0.0 {
        report.lost = map.share_beyond(TexelFormat::Rgba16F.largest());
    }
    report
}

/// The options with the name of the mapping, where a picture in it does not tell.
fn with_mapping(options: &PictureWriteOptions, map: &MappedMap) -> PictureWriteOptions {
    let mut options = options.clone();
    options.mapping = options.mapping.or_else(|| map.untold_mapping().map(str::to_owned));
    options
}

/// Options of writing a cube map.
#[derive(Clone, Debug, Default, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct CubeWriteOptions {
    /// The texel format; by default half floats, or floats where those would lose more than
    /// [`CubeWriteOptions::MOST_LOST`] of the light. A `.ktx` holds R11G11B10F only.
    #[setters(into)]
    pub texels: Option<TexelFormat>,
    /// Compress `.ktx2` with Zstandard, without loss.
    pub zstd: bool,
    /// The handedness for which the faces are made; only `.ktx2` has room to say which. Default: right.
    pub handedness: CubeHandedness,
    /// The light of the map, in Lobe's frame: a `.ktx` keeps it in Filament's form, under the key `sh`, for diffuse
    /// surfaces. Of the map itself, not of its levels. Default: none.
    pub light: Option<ShL2<Rgb<f64>>>,
}

impl CubeWriteOptions {
    /// The most of the light that the format loses which is chosen by default, 1 %: an error that is seen in no
    /// picture.
    pub const MOST_LOST: f64 = 0.01;

    /// The texel format in which a chain is written to a path.
    #[must_use]
    pub fn texels_for(&self, path: &Path, chain: &CubeMipChain) -> TexelFormat {
        let is_ktx1 = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ktx"));
        let usual = TexelFormat::default();
        self.texels.unwrap_or_else(|| match chain.base().share_beyond(usual.largest()) {
            _ if is_ktx1 => TexelFormat::R11G11B10F,
            lost if lost > Self::MOST_LOST => TexelFormat::Rgba32F,
            _ => usual,
        })
    }
}

/// Writes a cube map with all its levels as `.ktx2`, `.dds` or `.ktx`, depending on the extension; see [`write_cube_texture`].
///
/// # Errors
/// Those of [`write_cube_texture`].
pub fn write_cube(
    path: impl AsRef<Path>,
    chain: &CubeMipChain,
    options: &CubeWriteOptions,
) -> Result<PictureWriteReport, ImageError> {
    with_levels(path.as_ref(), chain, options, |levels, texels, notes| {
        write_cube_texture(&path, levels, texels, options.zstd, notes).map(|report| ((), report))
    })
    .map(|((), report)| report)
}

/// The bytes that [`write_cube`] writes; the extension of the path says the format.
///
/// # Errors
/// Those of [`lobe_image::encode_cube_texture`].
pub fn encode_cube(
    path: &Path,
    chain: &CubeMipChain,
    options: &CubeWriteOptions,
) -> Result<(Vec<u8>, PictureWriteReport), ImageError> {
    with_levels(path, chain, options, |levels, texels, notes| {
        encode_cube_texture(path, levels, texels, options.zstd, notes)
    })
}

/// What `write` makes of the levels of a chain, and the report with the share of the light of all directions.
fn with_levels<T>(
    path: &Path,
    chain: &CubeMipChain,
    options: &CubeWriteOptions,
    write: impl FnOnce(
        &[(usize, &[Rgb<f32>])],
        TexelFormat,
        &TextureNotes<'_>,
    ) -> Result<(T, PictureWriteReport), ImageError>,
) -> Result<(T, PictureWriteReport), ImageError> {
    let texels = options.texels_for(path, chain);
    let is_left = options.handedness == CubeHandedness::Left;
    let turned = is_left.then(|| chain.clone().of_handedness(options.handedness));
    let levels = turned.as_ref().unwrap_or(chain).levels();
    let levels: Vec<_> = levels.iter().map(|level| (level.size(), level.texels())).collect();
    let sh = options.light.as_ref().map(|light| {
        let light = if is_left { light.mirrored(Axis::X) } else { *light };
        EngineForm::Filament.encode(&light).map(Rgb::to_array)
    });
    let notes = TextureNotes { mapping: options.handedness.mapping_name(), sh };
    let (written, mut report) = write(&levels, texels, &notes)?;
    if report.lost > 0.0 {
        report.lost = chain.base().share_beyond(texels.largest());
    }
    Ok((written, report))
}
