//! Environment maps as inputs: files and their mappings, layouts and handedness.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use lobe::env::{
    CubeHandedness, CubeLayout, EnvError, EnvMap, FaceAssumption, FaceFiles, FaceOrder, LoadedMap, MapReadOptions,
    MapReadReport, MappedMap, Mapping, Nonfinite, Padding, project_map_file, read_map,
};
use lobe::image::PictureReadOptions;
use lobe::sh::{Rgb, ShVec};

use crate::args::fisheye::FisheyeInput;
use crate::args::input::{NonfiniteOption, READING, explain, pictures, tell};
use crate::args::memory::{DEFAULT_GIB, MemoryLimit};
use crate::args::names::names;
use crate::args::values;
use crate::run::talk::Talk;

/// 256 K x 128 K: more than any picture has. A larger number is taken for a typing error.
const MOST_TEXELS: usize = 1 << 35;

/// Bytes for each texel of the larger of two maps while one becomes the other, and for each of the smaller one, as
/// measured: 12 of the map, and of the larger one its light in double precision and what it is balanced by.
pub(crate) const OF_LARGER: u64 = 40;
pub(crate) const OF_SMALLER: u64 = OF_MAP;

/// Bytes for each texel of a map.
pub(crate) const OF_MAP: u64 = 12;

/// Help of the input.
fn help() -> String {
    let files = pictures();
    format!(
        "The environment map: {files}, FOLDER/PREFIX%.exr (or another ending; or FOLDER alone) for the six files of a \
         cube, or bundled:NAME. The files are named px to nz or mz, posx to negz, or as photographs right, left, top or up, \
         bottom or down, front, back, or rt, lf, up, dn, ft, bk, or r, l, u, d, f, b, or with numbers from 0 or 1 on"
    )
}

/// Where a map is, and how it shows its surroundings.
#[derive(Args)]
pub(crate) struct MapPath {
    #[arg(value_name = "IN", help = help())]
    path: PathBuf,
    /// How the picture shows the surroundings [default: what the file or its proportions tell: lat-long if it is twice as wide
    /// as high; a cube if it is a cross, a row or a column of six faces]
    #[arg(long, value_name = "MAPPING", value_parser = mapping())]
    from: Option<Mapping>,
    /// The faces of the cube were made for left-handed directions, as by Direct3D or three.js [default: what the file says; those
    /// that lobe wrote do, but .dds and .pfm]
    #[arg(long)]
    #[arg(help_heading = READING, hide_short_help = true)]
    from_left_handed: bool,
    /// The faces of a cube in their order in the picture or the numbered files, as front,right,back,left,up,down or in
    /// letters FRBLUD: names of sides for photographs, with front in the middle of the panorama; or px,nx,py,ny,pz,nz.
    /// Sheets of 3:2 and 2:3 are cubes only by this or --from cube [default: what the names of files tell, else
    /// px,nx,py,ny,pz,nz]
    #[arg(long, value_name = "ORDER")]
    #[arg(help_heading = READING, hide_short_help = true)]
    faces: Option<FaceOrder>,
    /// Of a cropped panorama, which shows all around but not all of the height: the degrees that it is high, half of them
    /// above the horizon, or the lowest and the highest elevation that it shows
    #[arg(long, value_name = "DEG|LOW,HIGH", value_parser = elevations, allow_hyphen_values = true, group = "shown_part")]
    #[arg(help_heading = READING, hide_short_help = true)]
    vertical_fov: Option<[f64; 2]>,
    #[command(flatten)]
    fisheye: FisheyeInput,
    /// With --vertical-fov: what is above and below the picture; with --fisheye: what is outside of its circle
    #[arg(long, value_name = "WHAT", value_enum, default_value = "black", requires = "shown_part")]
    #[arg(help_heading = READING, hide_short_help = true)]
    padding: Filling,
    /// Convert colors of other primaries, where the file tells them, to those of Rec. 709 (sRGB)
    #[arg(long)]
    #[arg(help_heading = READING, hide_short_help = true)]
    to_rec709: bool,
    /// Refuse a map whose file, or whose pixels, take more memory than this, in GiB, and work on it that takes more. A
    /// file that is not read row by row is refused by its length, before it is read. Work that is refused says how many
    /// bytes it takes
    #[arg(long, value_name = "GIB", default_value_t = DEFAULT_GIB, value_parser = values::positive)]
    #[arg(help_heading = READING, hide_short_help = true)]
    max_memory: f64,
    /// The most pixels that a picture may have; one that says it has more is refused. Each takes up to 28 bytes of memory while it
    /// is read, with its file, and 12 then
    #[arg(long, value_name = "N", default_value_t = PictureReadOptions::default().max_texels, value_parser = max_texels)]
    #[arg(help_heading = READING, hide_short_help = true)]
    max_texels: usize,
}

/// The elevations of `DEG` or `LOW,HIGH`, in radians.
fn elevations(text: &str) -> Result<[f64; 2], String> {
    let degrees = match text.contains(',') {
        true => values::numbers(text)?,
        false => values::finite(text).map(|whole| [-0.5 * whole, 0.5 * whole])?,
    };
    match degrees {
        [low, high] if -90.0 <= low && low < high && high <= 90.0 => Ok(degrees.map(f64::to_radians)),
        _ => Err("expected up to 180 degrees, or two elevations that rise within -90 to 90".to_owned()),
    }
}

names! {
    /// What a picture of a part does not show.
    enum Filling for Padding {
        /// No light
        Black,
        /// The light of the nearest row, or of the nearest point of the circle, or of the last pixel of the picture towards there
        Edge,
    }
}

pub(crate) fn max_texels(text: &str) -> Result<usize, String> {
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

/// Reads a mapping by its name; help pages list all of them.
pub(crate) fn mapping() -> impl TypedValueParser<Value = Mapping> {
    let known = Mapping::ALL.map(|mapping| PossibleValue::new(mapping.name()).help(mapping.description()));
    PossibleValuesParser::new(known).try_map(|name| Mapping::from_name(&name).ok_or("no mapping has this name"))
}

impl MapInput {
    /// The map at a path, whose mapping the file or its proportions tell, and which takes no more memory than `limit`.
    pub(crate) fn of(path: &Path, limit: &MemoryLimit) -> Self {
        let (max_texels, max_memory) = (PictureReadOptions::default().max_texels, limit.gib());
        let (from, vertical_fov, padding) = (None, None, Filling::Black);
        let (from_left_handed, to_rec709) = (false, false);
        let path = path.to_owned();
        let (fisheye, faces) = (FisheyeInput::none(), None);
        let map = MapPath {
            path,
            from,
            from_left_handed,
            faces,
            vertical_fov,
            fisheye,
            padding,
            to_rec709,
            max_memory,
            max_texels,
        };
        Self { map, nonfinite: NonfiniteOption::refuse() }
    }

    pub(crate) fn name(&self) -> String {
        self.map.name()
    }

    /// The limit for work on the map.
    pub(crate) fn memory(&self) -> MemoryLimit {
        MemoryLimit::of(self.map.max_memory)
    }

    /// Refuses work on a map that was read, if it takes more memory than allowed: `bytes` for each of its texels, the
    /// map included.
    pub(crate) fn check_work(&self, what: &str, map: &MappedMap, bytes: u64) -> anyhow::Result<()> {
        let (width, height) = (map.width() as u64, map.height() as u64);
        let what = format!("{what} a map of {width} x {height} texels");
        self.memory().check(&what, bytes.saturating_mul(width).saturating_mul(height), "a smaller map")
    }

    /// The files that are read.
    pub(crate) fn files(&self) -> anyhow::Result<Vec<PathBuf>> {
        let faces = FaceFiles::of_input(&self.map.path)?.and_then(|files| files.to_read());
        Ok(faces.map_or_else(|| vec![self.map.path.clone()], |faces| faces.to_vec()))
    }

    /// Reads the map, and notes the findings; pixels that are no numbers are treated as the options say.
    ///
    /// Of a chain of levels the largest is the map, and that there are others is noted.
    pub(crate) fn read(&self, talk: Talk) -> anyhow::Result<MappedMap> {
        Ok(self.base_of(self.read_levels(talk)?, talk))
    }

    /// Reads the map with its smaller levels, if it has any.
    pub(crate) fn read_levels(&self, talk: Talk) -> anyhow::Result<LoadedMap> {
        Ok(self.map.read_with((&self.nonfinite).into(), talk)?.0)
    }

    /// The expansion of the map, which is not read whole where the file comes by rows; notes as by [`MapInput::read`].
    pub(crate) fn project(&self, order: usize, talk: Talk) -> anyhow::Result<ShVec<Rgb<f64>>> {
        let project = |path: &Path, options: &MapReadOptions| project_map_file(path, order, options);
        let (f, report) = self.map.find("project", (&self.nonfinite).into(), talk, project)?;
        self.note_dropped(report.picture.levels, talk);
        Ok(f)
    }

    /// The largest level; a note if there are others.
    pub(crate) fn base_of(&self, levels: LoadedMap, talk: Talk) -> MappedMap {
        if let LoadedMap::Chain(chain) = &levels {
            self.note_dropped(chain.levels().len(), talk);
        }
        levels.into_base()
    }

    /// A note if a file has more levels than the largest one, which is used.
    fn note_dropped(&self, levels: usize, talk: Talk) {
        match levels {
            ..2 => {}
            2 => talk.note(&self.name(), "the smaller level is left out"),
            _ => talk.note(&self.name(), &format!("the {} smaller levels are left out", levels - 1)),
        }
    }

    /// Reads the map as a lat-long one; a map of another mapping is converted to about as many texels, and that is
    /// noted.
    pub(crate) fn read_lat_long(&self, talk: Talk) -> anyhow::Result<EnvMap> {
        self.to_lat_long(self.read(talk)?, talk)
    }

    /// The map that was read, as a lat-long one.
    pub(crate) fn to_lat_long(&self, map: MappedMap, talk: Talk) -> anyhow::Result<EnvMap> {
        if map.mapping() == Mapping::LatLong {
            return Ok(map.into_env_map()?);
        }
        self.check_work("converting", &map, OF_LARGER + OF_SMALLER)?;
        let rows = map.size_like(Mapping::LatLong);
        talk.note(&self.name(), &format!("converted from {} to {} x {rows} lat-long texels", map.mapping(), 2 * rows));
        Ok(talk.watch("convert", |job| map.into_lat_long(job))?)
    }
}

impl MapPath {
    fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// Reads the map, and notes the findings.
    pub(crate) fn read_with(&self, nonfinite: Nonfinite, talk: Talk) -> anyhow::Result<(LoadedMap, MapReadReport)> {
        self.find("read", nonfinite, talk, |path: &Path, options: &MapReadOptions| read_map(path, options))
    }

    /// What `find` finds in the file, and the report of reading it, whose findings are noted.
    fn find<T: Send>(
        &self,
        what: &'static str,
        nonfinite: Nonfinite,
        talk: Talk,
        find: impl FnOnce(&Path, &MapReadOptions) -> Result<(T, MapReadReport), EnvError> + Send,
    ) -> anyhow::Result<(T, MapReadReport)> {
        if self.name() == "-" {
            bail!("-: pictures are read from files, not from stdin; name a file ({})", pictures());
        }
        let options = self.options(nonfinite);
        let (found, report) =
            talk.while_waiting(what, || find(&self.path, &options)).map_err(|e| explain(&self.path, e))?;
        self.tell_all(&report, talk)?;
        Ok((found, report))
    }

    fn options(&self, nonfinite: Nonfinite) -> MapReadOptions {
        let memory = MemoryLimit::of(self.max_memory);
        let picture = PictureReadOptions::default().nonfinite(nonfinite).max_texels(self.max_texels);
        let picture = picture.max_bytes(memory.bytes()).to_rec_709(self.to_rec709);
        MapReadOptions::default()
            .picture(picture)
            .mapping(self.from)
            .elevations(self.vertical_fov)
            .fisheye(self.fisheye.options())
            .padding(self.padding.into())
            .handedness(self.from_left_handed.then_some(CubeHandedness::Left))
            .faces(self.faces)
    }

    fn tell_all(&self, report: &MapReadReport, talk: Talk) -> anyhow::Result<()> {
        let name = self.name();
        if let Some(layout) = report.layout {
            let text = format!("read as the six faces of a cube ({}); --from says otherwise", layout_name(layout));
            talk.note(&name, &text);
        }
        if let Some(assumed) = report.assumed {
            talk.note(&name, &format!("{assumed}; {}", turned_by(assumed)));
        }
        report.told.iter().for_each(|remark| talk.note(&name, remark));
        match FaceFiles::of_input(&self.path)?.and_then(|files| files.to_read()) {
            Some(paths) => {
                for (face, path) in report.faces.iter().zip(paths) {
                    tell(face, &path.display().to_string(), talk);
                }
            }
            None => tell(&report.picture, &name, talk),
        }
        Ok(())
    }
}

/// The options that say something else of faces than what was assumed.
fn turned_by(assumed: FaceAssumption) -> &'static str {
    match assumed {
        FaceAssumption::Photographs => "--faces px,nx,py,ny,pz,nz takes them by axes",
        _ => {
            "--from-left-handed says that letters in them can be read, --faces ORDER, as front,right,back,left,up,down, that they \
             are photographs"
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_of_view_is_given_in_degrees_around_the_horizon_or_by_both_ends() {
        let degrees = |text| elevations(text).map(|range| range.map(|angle| angle.to_degrees().round()));
        assert_eq!(degrees("60"), Ok([-30.0, 30.0]), "around the horizon");
        assert_eq!(degrees("-20,45"), Ok([-20.0, 45.0]), "both ends");
        for bad in ["0", "-10", "181", "20,10", "-91,0", "1,2,3", "x"] {
            assert!(elevations(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn every_mapping_is_read_by_its_name_and_stands_in_the_help() {
        let parser = mapping();
        let listed: Vec<PossibleValue> = parser.possible_values().unwrap().collect();
        assert_eq!(listed.len(), Mapping::ALL.len(), "{listed:?}");
        for (mapping, listed) in Mapping::ALL.into_iter().zip(listed) {
            let read = parser.parse_ref(&clap::Command::new("lobe"), None, mapping.name().as_ref());
            assert_eq!(read.unwrap(), mapping, "{mapping}");
            let help = listed.get_help().map(ToString::to_string);
            assert_eq!(
                (listed.get_name(), help.as_deref()),
                (mapping.name(), Some(mapping.description())),
                "{mapping}"
            );
        }
    }
}
