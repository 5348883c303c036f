//! Maps to read, in any mapping.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::env::{
    CubeHandedness, CubeLayout, CubeMap, CubeMipChain, EnvError, EnvFile, EnvMap, MapReadOptions, MapReadReport,
    MappedMap, Mapping, Nonfinite, Resample, cube_face_paths, read_cube_faces, read_env_file, resample,
};
use lobe::image::{Picture, PictureReadOptions, read_picture};

use crate::args::input::{BUNDLED, NonfiniteOption, PICTURES, explain, read_bundled, tell};
use crate::args::values;
use crate::run::talk::Talk;

/// 256 K x 128 K: more than any picture has; asking for more is a slip of the finger.
const MOST_TEXELS: usize = 1 << 35;

/// What stands for the six names px, nx, py, ny, pz and nz.
const ANY_FACE: &str = "%";

/// Where a map is, and how it shows its surroundings.
#[derive(Args)]
pub(crate) struct MapPath {
    /// The environment map: an .exr, .hdr, .pfm, .png or .jpg picture, a cube map as .ktx2 or .dds, FOLDER/%.exr (or
    /// another extension) for the six files px to nz, posx to negz, or right, left, top, bottom, front, back, or bundled:NAME
    #[arg(value_name = "IN")]
    path: PathBuf,
    /// How the picture shows the surroundings [default: what the file or its proportions tell: lat-long if it is twice as wide
    /// as high; a cube if it is a cross, a row or a column of six faces]
    #[arg(long, value_name = "MAPPING", value_enum)]
    from: Option<Form>,
    /// The faces of the cube were made for left-handed directions, as by Direct3D or three.js
    #[arg(long)]
    from_left_handed: bool,
    /// The most pixels that a picture may have; one that says it has more is refused. Each takes 12 bytes of memory, and up
    /// to as much again while a .hdr, .png or .jpg is decoded: 3.2 GB for the most that is read without this option
    #[arg(long, value_name = "N", default_value_t = MapReadOptions::default().max_texels, value_parser = max_texels)]
    max_texels: usize,
}

fn max_texels(text: &str) -> Result<usize, String> {
    values::whole(text, 1, MOST_TEXELS, "a number of pixels")
}

/// A map to compute with.
#[derive(Args)]
pub(crate) struct MapInput {
    #[command(flatten)]
    map: MapPath,
    #[command(flatten)]
    nonfinite: NonfiniteOption,
}

/// A map as a file holds it.
pub(crate) enum Levels {
    Single(MappedMap),
    Chain(CubeMipChain),
}

impl Levels {
    /// The largest level.
    pub(crate) fn base(&self) -> &MappedMap {
        match self {
            Self::Single(map) => map,
            Self::Chain(chain) => chain.base().as_ref(),
        }
    }

    /// The largest level, without the others.
    pub(crate) fn into_base(self) -> MappedMap {
        match self {
            Self::Single(map) => map,
            Self::Chain(chain) => chain.into_base().into(),
        }
    }
}

/// A mapping on the command line.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum Form {
    /// Longitude across, latitude down (Blinn and Newell)
    LatLong,
    /// Six faces
    Cube,
    /// The octahedron, unfolded
    Octahedral,
    /// The octahedron, unfolded so that all texels have the same solid angle
    EqualArea,
    /// The light probe: the distance from the middle is the angle
    Angular,
    /// OpenGL's sphere map
    Sphere,
    /// The photograph of a mirror ball
    MirrorBall,
    /// Two parabolic mirrors, side by side
    DualParaboloid,
}

impl From<Form> for Mapping {
    fn from(form: Form) -> Self {
        match form {
            Form::LatLong => Self::LatLong,
            Form::Cube => Self::Cube,
            Form::Octahedral => Self::Octahedral,
            Form::EqualArea => Self::EqualArea,
            Form::Angular => Self::Angular,
            Form::Sphere => Self::Sphere,
            Form::MirrorBall => Self::MirrorBall,
            Form::DualParaboloid => Self::DualParaboloid,
        }
    }
}

impl MapInput {
    /// The map at a path that says itself how it shows the surroundings.
    pub(crate) fn of(path: &Path) -> Self {
        let max_texels = MapReadOptions::default().max_texels;
        let map = MapPath { path: path.to_owned(), from: None, from_left_handed: false, max_texels };
        Self { map, nonfinite: NonfiniteOption::refuse() }
    }

    pub(crate) fn name(&self) -> String {
        self.map.name()
    }

    /// Reads the map, and tells what was found remarkable; pixels that are no numbers are treated as the options say.
    ///
    /// Of a chain of levels the largest is the map, and that there are others is noted.
    pub(crate) fn read(&self, talk: Talk) -> anyhow::Result<MappedMap> {
        Ok(self.base_of(self.read_levels(talk)?, talk))
    }

    /// Reads the map with its smaller levels, if it has any.
    pub(crate) fn read_levels(&self, talk: Talk) -> anyhow::Result<Levels> {
        Ok(self.map.read_with((&self.nonfinite).into(), talk)?.0)
    }

    /// The largest level; a note if there are others.
    pub(crate) fn base_of(&self, levels: Levels, talk: Talk) -> MappedMap {
        if let Levels::Chain(chain) = &levels
            && chain.levels().len() > 1
        {
            let dropped = match chain.levels().len() - 1 {
                1 => "the smaller level is left out".to_owned(),
                count => format!("the {count} smaller levels are left out"),
            };
            talk.note(&self.name(), &dropped);
        }
        levels.into_base()
    }

    /// Reads the map as a lat-long one; a map of another mapping is converted to about as many texels, and that is noted.
    pub(crate) fn read_lat_long(&self, talk: Talk) -> anyhow::Result<EnvMap> {
        self.to_lat_long(self.read(talk)?, talk)
    }

    /// The map that was read, as a lat-long one.
    pub(crate) fn to_lat_long(&self, map: MappedMap, talk: Talk) -> anyhow::Result<EnvMap> {
        if map.mapping() == Mapping::LatLong {
            return Ok(map.into_env_map()?);
        }
        let rows = size_like(&map, Mapping::LatLong);
        talk.note(&self.name(), &format!("converted from {} to {} x {rows} lat-long texels", map.mapping(), 2 * rows));
        Ok(resample(map, &Resample::to(Mapping::LatLong, 2 * rows, rows))?.into_env_map()?)
    }
}

impl MapPath {
    fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// Reads the map, and tells what was found remarkable.
    pub(crate) fn read_with(&self, nonfinite: Nonfinite, talk: Talk) -> anyhow::Result<(Levels, MapReadReport)> {
        let (map, report) = self.read_any(nonfinite, talk)?;
        let mapping = map.base().mapping();
        if self.from_left_handed && mapping != Mapping::Cube {
            bail!("--from-left-handed: only of a cube, but {} is {mapping}; leave it out", self.name());
        }
        Ok((map, report))
    }

    fn read_any(&self, nonfinite: Nonfinite, talk: Talk) -> anyhow::Result<(Levels, MapReadReport)> {
        let options = MapReadOptions::default().nonfinite(nonfinite).max_texels(self.max_texels);
        let name = self.name();
        if let Some(bundled) = name.strip_prefix(BUNDLED) {
            if self.from.is_some_and(|form| form != Form::LatLong) {
                bail!("--from: {name} is lat-long; leave the option out");
            }
            let (map, report) = read_bundled(bundled, &options)?;
            tell(&report, &name, talk);
            return Ok((Levels::Single(map.into()), report));
        }
        if name == "-" {
            bail!("-: pictures are read from files, not from stdin; name a {PICTURES} file");
        }
        if let Some((folder, extension)) = six_files(&self.path) {
            if self.from.is_some_and(|form| form != Form::Cube) {
                bail!("--from: {name} is a cube; leave the option out");
            }
            let (cube, reports) = read_cube_faces(folder, &extension, self.handedness(), &options)?;
            for (report, path) in reports.iter().zip(cube_face_paths(folder, &extension)) {
                tell(report, &path.display().to_string(), talk);
            }
            let [first, ..] = reports;
            return Ok((Levels::Single(cube.into()), first));
        }
        let (map, report) = match self.from {
            Some(form) if !is_texture(&self.path) => {
                let (picture, report) = read_picture(&self.path, &of_picture(&options)).map_err(EnvError::from)?;
                (Levels::Single(self.map_of(form, picture)?), report.into())
            }
            Some(form) if form != Form::Cube => bail!("--from: {name} is a cube map; leave the option out"),
            _ => self.read_as_it_is(&options, talk)?,
        };
        tell(&report, &name, talk);
        Ok((map, report))
    }

    /// Reads a file that says itself what it is, or whose proportions do.
    fn read_as_it_is(&self, options: &MapReadOptions, talk: Talk) -> anyhow::Result<(Levels, MapReadReport)> {
        let error = match read_env_file(&self.path, options) {
            Ok((EnvFile::LatLong(map), report)) => return Ok((Levels::Single(map.into()), report)),
            Ok((EnvFile::Cube(chain), report)) => {
                return Ok((Levels::Chain(chain.of_handedness(self.handedness())), report));
            }
            Err(error) => error,
        };
        let (picture, report) = match read_picture(&self.path, &of_picture(options)) {
            Ok(read) => read,
            // What is no picture of any shape is damaged, whatever its proportions.
            Err(damage) => return Err(explain(&self.path, if is_texture(&self.path) { error } else { damage.into() })),
        };
        if let Ok(layout) = CubeLayout::of_picture(picture.width(), picture.height()) {
            let text = format!("read as the six faces of a cube ({}); --from says otherwise", layout_name(layout));
            talk.note(&self.name(), &text);
            return Ok((Levels::Single(self.map_of(Form::Cube, picture)?), report.into()));
        }
        let (width, height) = (picture.width(), picture.height());
        bail!(
            "{}: a picture of {width} x {height} is neither lat-long (2:1) nor a cube (4:3, 3:4, 6:1 or 1:6); say what it is \
             with --from",
            self.name()
        )
    }

    fn map_of(&self, form: Form, picture: Picture) -> anyhow::Result<MappedMap> {
        let named = |error| anyhow::anyhow!("{}: {error}", self.name());
        if form == Form::Cube {
            return Ok(CubeMap::from_picture(&picture, self.handedness()).map_err(named)?.into());
        }
        MappedMap::new(form.into(), picture.width(), picture.height(), picture.into_pixels()).map_err(named)
    }

    fn handedness(&self) -> CubeHandedness {
        if self.from_left_handed { CubeHandedness::Left } else { CubeHandedness::Right }
    }
}

fn of_picture(options: &MapReadOptions) -> PictureReadOptions {
    PictureReadOptions::default().nonfinite(options.nonfinite).max_texels(options.max_texels)
}

fn layout_name(layout: CubeLayout) -> &'static str {
    match layout {
        CubeLayout::HorizontalCross => "a horizontal cross",
        CubeLayout::VerticalCross => "a vertical cross",
        CubeLayout::Row => "a row",
        CubeLayout::Column => "a column",
        _ => "a layout of its own",
    }
}

/// The size at which a map of another mapping has about as many texels on the sphere.
pub(crate) fn size_like(map: &MappedMap, mapping: Mapping) -> usize {
    if map.mapping() == mapping {
        return if mapping == Mapping::Cube { map.width() } else { map.height() };
    }
    let texels = shown(map.mapping()) * (map.width() * map.height()) as f64;
    let sides = if matches!(mapping, Mapping::LatLong | Mapping::DualParaboloid) { 2.0 } else { 1.0 };
    let faces = if mapping == Mapping::Cube { 6.0 } else { 1.0 };
    let size = (texels / (shown(mapping) * sides * faces)).sqrt();
    if mapping == Mapping::Cube { 1 << (size.log2().round() as u32) } else { (size.round() as usize).max(1) }
}

/// The part of a picture that shows something: of a square the disc in it, or all.
fn shown(mapping: Mapping) -> f64 {
    match mapping {
        Mapping::Sphere | Mapping::MirrorBall | Mapping::Angular | Mapping::DualParaboloid => {
            std::f64::consts::FRAC_PI_4
        }
        _ => 1.0,
    }
}

fn extension(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase()
}

pub(crate) fn is_texture(path: &Path) -> bool {
    ["ktx2", "dds"].contains(&extension(path).as_str())
}

/// The folder and the extension of `FOLDER/%.EXT`.
pub(crate) fn six_files(path: &Path) -> Option<(&Path, String)> {
    (path.file_stem()? == ANY_FACE).then(|| (path.parent().unwrap_or(Path::new("")), extension(path)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mapping_has_its_name_on_the_command_line() {
        for mapping in Mapping::ALL {
            let form = Form::from_str(mapping.name(), false).map(Mapping::from);
            assert_eq!(form, Ok(mapping), "{mapping}");
        }
    }

    #[test]
    fn six_files_are_named_by_a_percent_sign() {
        assert_eq!(six_files(Path::new("sky/%.exr")), Some((Path::new("sky"), "exr".to_owned())), "in a folder");
        assert_eq!(six_files(Path::new("%.hdr")), Some((Path::new(""), "hdr".to_owned())), "here");
        assert_eq!(six_files(Path::new("100%.exr")), None, "a name that ends so");
    }
}
