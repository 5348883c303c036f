//! Environment maps as outputs: files, layouts of cubes, texel formats and levels.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::env::{
    CubeHandedness, CubeLayout, CubeMipChain, CubeWriteOptions, FaceFiles, MappedMap, Mapping, Resample,
    RoughnessLevels, TexelFormat, resample, write_cube, write_cube_faces, write_env,
};
use lobe::image::{FileFormat, ImageError, PictureWriteOptions};
use lobe::sh::{Rgb, ShVec};

use crate::args::names::names;
use crate::args::output;
use crate::args::picture::{PictureOutput, note_clamped, percent};
use crate::run::talk::Talk;

/// A map to write.
#[derive(Args)]
pub(crate) struct MapOutput {
    #[arg(short, long, value_name = "OUT", help = help())]
    output: MapFile,
    /// Of a cube in one picture: how its faces lie in it [default: horizontal-cross]
    #[arg(long, value_enum)]
    layout: Option<Layout>,
    /// Of a cube: make its faces for left-handed directions, as Direct3D and three.js want them
    #[arg(long)]
    left_handed: bool,
    /// Of .ktx2 and .dds: how a texel is stored [default: rgba16f, or rgba32f where that would lose more than 1 % of
    /// the light to suns above 65504; r11g11b10f in .ktx, which holds nothing else]
    #[arg(long, value_enum)]
    texels: Option<Texels>,
    /// Of .ktx2: compress with Zstandard
    #[arg(long)]
    zstd: bool,
    /// Of .ktx2, .dds and .ktx: with all smaller levels, each the mean of the one before [default: none; by convert
    /// those of IN, where IN is a texture of the same size]
    #[arg(long)]
    mips: bool,
    /// Of .exr: 16-bit half instead of 32-bit float
    #[arg(long)]
    half: bool,
}

fn help() -> String {
    let textures = FileFormat::names(FileFormat::is_texture);
    let map = format!(
        "The new map; a cube also as {textures}, or by FOLDER/PREFIX%.exr (or another ending) as six files px to nz"
    );
    PictureOutput::help(&map)
}

fn is_texture(path: &Path) -> bool {
    FileFormat::of_name(path).is_some_and(FileFormat::is_texture)
}

/// A file of a map, or six.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum MapFile {
    Picture(PictureOutput),
    Texture(PathBuf),
    Faces(FaceFiles),
}

impl FromStr for MapFile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let path = PathBuf::from(text);
        if is_texture(&path) {
            return Ok(Self::Texture(path));
        }
        if let Some(files) = FaceFiles::of(&path) {
            if format!("a.{}", files.extension()).parse::<PictureOutput>().is_err() {
                return Err(format!("expected % before {} for the six files of a cube", PictureOutput::endings()));
            }
            return Ok(Self::Faces(files));
        }
        match text.parse() {
            Ok(picture) => Ok(Self::Picture(picture)),
            Err(message) => Err(format!("{message}, or for a cube in {}", FileFormat::names(FileFormat::is_texture))),
        }
    }
}

names! {
    pub(crate) enum Layout for CubeLayout {
        HorizontalCross,
        VerticalCross,
        Row,
        Column,
    }
}

/// How a texel is stored in a texture.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum Texels {
    /// Half floats: three digits, to 65504
    Rgba16f,
    /// Floats: exact, twice the size
    Rgba32f,
    /// One exponent for three colors: half the size of rgba16f, to 65408
    Rgb9e5,
    /// Floats of 11, 11 and 10 bits: two digits, half the size of rgba16f, to 64512; as .ktx for Filament
    R11g11b10f,
    /// Blocks: an eighth of the size of rgba16f, two digits
    Bc6h,
}

impl From<Texels> for TexelFormat {
    fn from(texels: Texels) -> Self {
        match texels {
            Texels::Rgba16f => Self::Rgba16F,
            Texels::Rgba32f => Self::Rgba32F,
            Texels::Rgb9e5 => Self::Rgb9e5,
            Texels::R11g11b10f => Self::R11G11B10F,
            Texels::Bc6h => Self::Bc6h,
        }
    }
}

/// Bytes for each texel of a map while it is written, the map itself included, as measured: .exr has its channels and its bytes
/// beside it, .png a picture for looking at, a cube in one picture that picture, which is half empty.
pub(crate) const OF_PICTURE: u64 = 40;
const OF_PNG: u64 = 44;
const OF_FACES: u64 = 48;
const OF_CUBE_IN_PICTURE: u64 = 80;

/// The same of a chain of levels, in floats, which all take a third more than the first: without what it is encoded in.
const OF_CHAIN: u64 = 16;

/// The same of a map that is turned around for the other hand.
const OF_TURNED: u64 = 16;

impl MapOutput {
    /// A map in the usual form of its file.
    pub(crate) fn of(output: MapFile, left_handed: bool) -> Self {
        Self { output, layout: None, left_handed, texels: None, zstd: false, mips: false, half: false }
    }

    /// The most bytes that writing takes for each texel of a map in this mapping.
    pub(crate) fn bytes_of_texel(&self, mapping: Mapping) -> u64 {
        match &self.output {
            MapFile::Picture(_) if mapping == Mapping::Cube => OF_CUBE_IN_PICTURE,
            MapFile::Picture(picture) if !picture.is_light() => OF_PNG,
            MapFile::Picture(_) => OF_PICTURE,
            MapFile::Faces(_) => OF_FACES,
            MapFile::Texture(path) => self.bytes_of_texture(path),
        }
    }

    /// The same of a texture, whose texels are floats where the light asks for them.
    fn bytes_of_texture(&self, path: &Path) -> u64 {
        let encoded: u64 = match self.texels {
            _ if output::has_extension(path, "ktx") => 4,
            None | Some(Texels::Rgba32f) => 16,
            Some(Texels::Rgba16f) => 8,
            Some(Texels::Rgb9e5 | Texels::R11g11b10f) => 4,
            Some(Texels::Bc6h) => 1,
        };
        // Compressed, it lies beside that.
        let copies = if self.zstd { 2 } else { 1 };
        let turned = if self.left_handed { OF_TURNED } else { 0 };
        OF_CHAIN + (4 * copies * encoded).div_ceil(3) + turned
    }

    /// Whether the file can hold a cube only.
    pub(crate) fn is_cube_only(&self) -> bool {
        !matches!(self.output, MapFile::Picture(_))
    }

    /// Whether the faces of a cube are to lie in one picture.
    pub(crate) fn has_layout(&self) -> bool {
        self.layout.is_some()
    }

    /// Whether smaller levels are to be made.
    pub(crate) fn makes_levels(&self) -> bool {
        self.mips
    }

    /// Whether the file can hold several levels.
    pub(crate) fn is_texture(&self) -> bool {
        matches!(self.output, MapFile::Texture(_))
    }

    /// Whether the levels that a texture has can be written as they are.
    pub(crate) fn keeps_levels(&self) -> bool {
        self.is_texture() && !self.mips
    }

    /// Whether the file can hold several levels, or stands for one file for each.
    pub(crate) fn holds_levels(&self) -> bool {
        match &self.output {
            MapFile::Picture(_) => false,
            MapFile::Texture(_) => true,
            MapFile::Faces(files) => files.extension() != "png" && !self.left_handed,
        }
    }

    /// Refuses an output that could not be written or is an input, before any work is done for it.
    pub(crate) fn check(&self, mapping: Mapping, inputs: &[PathBuf]) -> anyhow::Result<()> {
        let is_texture = self.is_texture();
        let is_picture = matches!(self.output, MapFile::Picture(_));
        let ends_in = |kind: &str| matches!(&self.output, MapFile::Texture(path) if output::has_extension(path, kind));
        let is_exr = match &self.output {
            MapFile::Picture(picture) => picture.is_exr(),
            MapFile::Faces(files) => files.extension() == "exr",
            MapFile::Texture(_) => false,
        };
        if self.is_cube_only() && mapping != Mapping::Cube {
            bail!(
                "-o: this kind of file holds cubes only, not a map that is {mapping}; name a picture, or convert to cube"
            );
        }
        let ignored = [
            (
                self.layout.is_some() && !(is_picture && mapping == Mapping::Cube),
                "--layout: only of a cube in one picture",
            ),
            (self.left_handed && mapping != Mapping::Cube, "--left-handed: only of a cube"),
            (self.half && !is_exr, "--half: only of .exr"),
            (self.texels.is_some() && !is_texture, "--texels: only of .ktx2, .dds and .ktx"),
            (
                self.texels.is_some_and(|texels| texels != Texels::R11g11b10f) && ends_in("ktx"),
                "--texels: a .ktx holds r11g11b10f only",
            ),
            (self.zstd && !ends_in("ktx2"), "--zstd: only of .ktx2"),
            (self.mips && !is_texture, "--mips: only of .ktx2, .dds and .ktx"),
        ];
        if let Some((_, message)) = ignored.into_iter().find(|(is_ignored, _)| *is_ignored) {
            bail!("{message}; leave it out");
        }
        match &self.output {
            MapFile::Picture(picture) => picture.check(inputs),
            MapFile::Texture(path) => output::prepare_file(path, inputs),
            MapFile::Faces(files) => {
                let folder = files.folder();
                // The folders that are missing are made when there is something to put into them.
                let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
                match folder.ancestors().take_while(is_missing).last() {
                    Some(outermost) => output::prepare_file(outermost, inputs),
                    None => files.to_write().iter().try_for_each(|path| output::prepare_file(path, inputs)),
                }
            }
        }
    }

    /// Writes the map.
    pub(crate) fn write(&self, map: MappedMap, talk: Talk) -> anyhow::Result<()> {
        let options = PictureWriteOptions::default().half(self.half);
        match &self.output {
            MapFile::Picture(picture) if map.mapping() == Mapping::Cube => {
                let layout = self.layout.unwrap_or(Layout::HorizontalCross).into();
                let options = options.mapping(self.handedness().told_name().to_owned());
                picture.write(&map.into_cube_map()?.to_picture(layout, self.handedness()), &options, talk)
            }
            MapFile::Picture(picture) => picture.write_map(&map, &options, talk),
            MapFile::Texture(_) => {
                let cube = map.into_cube_map()?;
                let chain = if self.mips { CubeMipChain::averaged(cube) } else { CubeMipChain::single(cube) };
                self.write_chain(&chain, talk)
            }
            MapFile::Faces(files) => {
                let cube = map.into_cube_map()?;
                create_folder(files)?;
                let write = || write_cube_faces(files, &cube, self.handedness(), &options);
                let report = talk.while_waiting("write", write)?;
                let name = files.to_string();
                note_clamped(&name, report, talk);
                if files.extension() == "png" {
                    talk.note(&name, "tone-mapped for looking at, all faces alike; .exr holds the values");
                }
                Ok(())
            }
        }
    }

    /// Writes all levels of a chain: into a texture, or each as a lat-long picture of its own, noting what `level` says of it.
    /// A .ktx keeps the `light` for diffuse surfaces, too.
    pub(crate) fn write_levels(
        &self,
        chain: &CubeMipChain,
        light: Option<&ShVec<Rgb<f64>>>,
        level: impl Fn(usize) -> String,
        talk: Talk,
    ) -> anyhow::Result<()> {
        let MapFile::Faces(files) = &self.output else { return self.write_lit_chain(chain, light, talk) };
        create_folder(files)?;
        let options = PictureWriteOptions::default().half(self.half);
        for (k, path) in files.numbered(chain.levels().len()).iter().enumerate() {
            let (name, cube) = (path.display().to_string(), &chain.levels()[k]);
            // The horizon crosses four faces.
            let to = Resample::to(Mapping::LatLong, 4 * cube.size(), 2 * cube.size());
            let map = talk.watch("convert", |job| resample(cube, &to, job))?;
            note_clamped(&name, write_env(path, &map, &options)?, talk);
            talk.note(&name, &level(k));
        }
        Ok(())
    }

    /// Writes all levels of a chain; only a texture holds them.
    pub(crate) fn write_chain(&self, chain: &CubeMipChain, talk: Talk) -> anyhow::Result<()> {
        self.write_lit_chain(chain, None, talk)
    }

    /// Writes a chain, with the light that it was made from where the file has room for that.
    fn write_lit_chain(&self, chain: &CubeMipChain, light: Option<&ShVec<Rgb<f64>>>, talk: Talk) -> anyhow::Result<()> {
        let MapFile::Texture(path) = &self.output else {
            bail!("-o: a chain of levels is written as .ktx2, .dds or .ktx");
        };
        let name = path.display().to_string();
        let options = CubeWriteOptions::default().texels(self.texels.map(TexelFormat::from)).zstd(self.zstd);
        let options = options.handedness(self.handedness()).light(light.map(ShVec::to_fixed));
        let report = talk.while_waiting("write", || write_cube(path, chain, &options))?;
        note_clamped(&name, report, talk);
        if self.texels.is_none() && options.texels_for(path, chain) == TexelFormat::Rgba32F {
            let usual = TexelFormat::default();
            let lost = percent(chain.base().share_beyond(usual.largest()));
            let text = format!("written as RGBA32F: {usual} loses {lost} of the light; --texels rgba16f writes it so");
            talk.note(&name, &text);
        }
        Ok(())
    }

    /// Whether a prefiltered chain is kept with the light of diffuse surfaces: in .ktx, as Filament reads it.
    pub(crate) fn keeps_light(&self) -> bool {
        matches!(&self.output, MapFile::Texture(path) if output::has_extension(path, "ktx"))
    }

    /// The roughness of the levels of a prefiltered chain in this kind of file: what reads .ktx is Filament.
    pub(crate) fn usual_roughness(&self) -> RoughnessLevels {
        if self.keeps_light() { RoughnessLevels::Quadratic } else { RoughnessLevels::default() }
    }

    fn handedness(&self) -> CubeHandedness {
        if self.left_handed { CubeHandedness::Left } else { CubeHandedness::Right }
    }
}

/// Makes the folder of some files, if it is missing.
fn create_folder(files: &FaceFiles) -> Result<(), ImageError> {
    let folder = files.folder();
    std::fs::create_dir_all(folder).map_err(|source| ImageError::Io { place: folder.display().to_string(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_what_kind_of_file_it_is() {
        assert!(matches!("sky/%.exr".parse(), Ok(MapFile::Faces(_))), "six files");
        assert!(matches!("sky_%.png".parse(), Ok(MapFile::Faces(_))), "six files with a prefix");
        assert_eq!("a.KTX2".parse(), Ok(MapFile::Texture("a.KTX2".into())), "texture");
        assert!(matches!("a.exr".parse(), Ok(MapFile::Picture(_))), "picture");
        for bad in ["a", "a.txt", "%.jpg", "%", ""] {
            assert!(bad.parse::<MapFile>().is_err(), "{bad:?} was taken");
        }
    }
}
