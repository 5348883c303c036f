//! Cube maps in six files, one for each face.

use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};

use lobe_image::{
    ImageError, Picture, PictureReadReport, PictureWriteOptions, PictureWriteReport, ReadOption, TexelFormat, Tone,
    encode_picture, read_picture,
};
use lobe_io::{StagedFile, check_writable};
use lobe_sh::Rgb;

use crate::error::EnvError;
use crate::files::face_names::{AXES, Around, SIDES, all_names, cubes_among};
use crate::files::read_options::{FaceAssumption, MapReadOptions};
use crate::map::cube_handedness::CubeHandedness;
use crate::map::cube_layout::CubeLayout;
use crate::map::cube_map::CubeMap;
use crate::map::face_order::{FaceNames, FaceOrder};
use crate::mapping::cube::FACES;

/// The placeholder for the names of the faces in a path.
const ANY_FACE: char = '%';

/// The files that a path with a percent sign stands for, `sky/%.exr`, `sky_%.png`: the six of a cube, or numbered ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FaceFiles {
    folder: PathBuf,
    before: String,
    after: String,
}

impl FaceFiles {
    /// The files of a path; none if its last part has no percent sign or several, or there is a file of that name.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let (before, after) = path.file_name()?.to_str()?.split_once(ANY_FACE)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let files = Self { folder, before: before.to_owned(), after: after.to_owned() };
        (!after.contains(ANY_FACE) && !path.exists()).then_some(files)
    }

    /// The files of a path that is read: those of a percent sign as [`FaceFiles::of`], and those of a folder with the six faces of
    /// a cube, under any names that are read. None of the path of a file.
    ///
    /// # Errors
    /// [`ImageError::Invalid`] for a folder with the faces of no cube, or of several; [`ImageError::Io`] if it cannot be listed.
    pub fn of_input(path: &Path) -> Result<Option<Self>, ImageError> {
        if !path.is_dir() {
            return Ok(Self::of(path));
        }
        let place = path.display().to_string();
        let mut cubes = Self::in_folder(path).map_err(|source| ImageError::Io { place: place.clone(), source })?;
        let message = match &cubes[..] {
            [_] => return Ok(cubes.pop()),
            [] => format!(
                "this is a folder without the six faces of a cube; name a picture, or the faces with {ANY_FACE}"
            ),
            [first, second, ..] => format!("there are the faces of several cubes here; name one: {first} or {second}"),
        };
        Err(ImageError::Invalid { place, message })
    }

    /// The cubes of which all six faces are in a folder, two at most.
    fn in_folder(folder: &Path) -> std::io::Result<Vec<Self>> {
        let names = folder.read_dir()?.map(|entry| Ok(entry?.file_name().into_string().ok()));
        let names: BTreeSet<String> = names.flat_map(Result::transpose).collect::<std::io::Result<_>>()?;
        let is_there = |name: &str| names.contains(name);
        let mut found: Vec<(Self, [PathBuf; FACES])> = Vec::new();
        for Around { before, after } in cubes_among(&names, is_there) {
            let files = Self { folder: folder.to_owned(), before, after };
            let Some((faces, _)) = files.to_read_of(is_there) else { continue };
            // The same files may be found by several names.
            if found.iter().all(|(_, others)| *others != faces) && faces.iter().all(|face| face.is_file()) {
                found.push((files, faces));
            }
            if found.len() > 1 {
                break;
            }
        }
        Ok(found.into_iter().map(|(files, _)| files).collect())
    }

    /// The folder of the files.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The extension of the files, in lower case.
    #[must_use]
    pub fn extension(&self) -> String {
        self.after.rsplit_once('.').map_or(String::new(), |(_, extension)| extension.to_ascii_lowercase())
    }

    fn named(&self, names: &[String; FACES]) -> [PathBuf; FACES] {
        names.each_ref().map(|name| self.folder.join(self.file_name(name)))
    }

    fn file_name(&self, face: &str) -> String {
        format!("{}{face}{}", self.before, self.after)
    }

    /// The files of numbered pictures: 0, 1 and so on in the place of the percent sign.
    #[must_use]
    pub fn numbered(&self, count: usize) -> Vec<PathBuf> {
        (0..count).map(|k| self.folder.join(self.file_name(&k.to_string()))).collect()
    }

    /// The files of the faces +X, -X, +Y, -Y, +Z, -Z that are written: `px` to `nz` in the place of the percent sign.
    #[must_use]
    pub fn to_write(&self) -> [PathBuf; FACES] {
        self.named(&AXES[0].map(str::to_owned))
    }

    /// The files of the faces that are read, of which most are there; none if none is. In the place of the percent sign
    /// are `px` to `nz` or to `mz`, `posx` to `negz`, `xpos` to `zneg`, `+x` to `-z`; `right`, `left`, `top` or `up`,
    /// `bottom` or `down`, `front` and `back`; `rt`, `lf`, `up`, `dn`, `ft` and `bk`; `r`, `l`, `u`, `d`, `f` and `b`;
    /// or six numbers from 0 or 1 on, of one to four digits. Letters may be large.
    #[must_use]
    pub fn to_read(&self) -> Option<[PathBuf; FACES]> {
        self.found().map(|(files, _)| files)
    }

    /// The files of the faces that are read, and what they are named by; no kind of name of numbers.
    fn found(&self) -> Option<([PathBuf; FACES], Option<FaceNames>)> {
        self.to_read_of(|name| self.folder.join(name).exists())
    }

    /// The same of the names that are there.
    fn to_read_of(&self, is_there: impl Fn(&str) -> bool) -> Option<([PathBuf; FACES], Option<FaceNames>)> {
        let mut best = (0, None);
        for (names, kind) in all_names() {
            let there = names.iter().filter(|name| is_there(&self.file_name(name))).count();
            // Of several with as many files, the first.
            if there > best.0 {
                best = (there, Some((self.named(&names), kind)));
            }
        }
        best.1
    }
}

impl fmt::Display for FaceFiles {
    /// The path with its percent sign.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.folder.join(format!("{}{ANY_FACE}{}", self.before, self.after));
        write!(f, "{}", path.display())
    }
}

/// Reads a cube from [six files](FaceFiles::to_read), with the reports of the faces, and what was assumed of them.
pub(crate) fn read_cube_faces(
    files: &FaceFiles,
    options: &MapReadOptions,
) -> Result<(CubeMap, Vec<PictureReadReport>, Option<FaceAssumption>), EnvError> {
    let invalid = |path: &Path, message| ImageError::Invalid { place: path.display().to_string(), message };
    let Some((paths, kind)) = files.found() else {
        let tried: Vec<String> = AXES.iter().chain(&SIDES).map(|names| names.join(" ")).collect();
        let message =
            format!("none of the six files is there; tried for {ANY_FACE}: {}, or 0 1 2 3 4 5", tried.join(", or "));
        return Err(ImageError::Invalid { place: files.to_string(), message }.into());
    };
    let all = &options.picture;
    let each = all.clone().max_texels(all.max_texels / FACES).max_bytes(all.max_bytes / FACES as u64);
    let mut options = options.clone();
    let mut faces: [Vec<Rgb<f32>>; FACES] = Default::default();
    let mut reports: Vec<PictureReadReport> = Vec::with_capacity(FACES);
    for (path, texels) in paths.iter().zip(&mut faces) {
        let (face, mut report) = read_picture(path, &each).map_err(of_a_sixth)?;
        let (width, height, size) = (face.width(), face.height(), reports.first().map_or(face.width(), |r| r.width));
        if (width, height) != (size, size) {
            let message = format!("a face of {size} x {size} expected, but this is {width} x {height}");
            return Err(invalid(path, message).into());
        }
        if reports.is_empty() {
            options = options.for_file(report.mapping.as_deref(), &mut report.notes);
        }
        *texels = face.into_pixels::<Rgb<f32>>();
        reports.push(report);
    }
    let is_open = options.leaves_faces_open();
    let order = match (options.faces, kind) {
        // The names tell which is which.
        (Some(order), Some(FaceNames::Sides)) if order.names() == FaceNames::Sides => {
            FaceOrder::usual(FaceNames::Sides)
        }
        (Some(order), _) => order,
        (None, Some(FaceNames::Sides)) if is_open && reports[0].mapping.is_none() => FaceOrder::usual(FaceNames::Sides),
        (None, _) => FaceOrder::usual(FaceNames::Axes),
    };
    let assumed = match order.names() {
        FaceNames::Axes => FaceAssumption::RightHanded,
        FaceNames::Sides => FaceAssumption::Photographs,
    };
    let cube = order.cube(reports[0].width, faces, options.hand())?;
    let is_told = reports[0].mapping.is_some();
    Ok((cube, reports, (is_open && !is_told).then_some(assumed)))
}

/// Says of a limit that it is a sixth: all faces are held together.
fn of_a_sixth(error: ImageError) -> ImageError {
    match error {
        ImageError::Refused { place, message, option: option @ (ReadOption::MaxTexels | ReadOption::MaxBytes) } => {
            let message = format!("{message}: a sixth of all, since the six faces are held together");
            ImageError::Refused { place, message, option }
        }
        other => other,
    }
}

/// Writes a cube as [six files](FaceFiles::to_write), in a format of [`write_env`](crate::write_env), or as `.png`, tone-mapped
/// for looking at with one exposure for all faces; the report counts over all faces. All formats but `.pfm` keep the handedness.
///
/// The files are renamed into place, one after another, when all six are on the disk: where one cannot be written, none is.
///
/// # Errors
/// As [`write_env`](crate::write_env).
pub fn write_cube_faces(
    files: &FaceFiles,
    cube: &CubeMap,
    handedness: CubeHandedness,
    options: &PictureWriteOptions,
) -> Result<PictureWriteReport, ImageError> {
    let io = |path: &Path, source| ImageError::Io { place: path.display().to_string(), source };
    let options = options.clone().mapping(handedness.told_name().to_owned());
    let paths = files.to_write();
    for path in &paths {
        check_writable(path).map_err(|e| io(path, e))?;
    }
    let is_shown = files.extension() == "png";
    let tone = is_shown.then(|| Tone::PHOTOGRAPH.fixed_for(&cube.to_picture(CubeLayout::Row, handedness)));
    let mut report = PictureWriteReport::default();
    let mut staged = Vec::with_capacity(FACES);
    for (path, face) in paths.iter().zip(cube.faces(handedness)) {
        let bytes = if let Some(tone) = &tone {
            Picture::new(cube.size(), cube.size(), face)?.to_png_with(tone, options.mapping.as_deref())?
        } else {
            let (bytes, found) = encode_picture(path, cube.size(), &face, &options)?;
            report.clamped += found.clamped;
            bytes
        };
        staged.push(StagedFile::write(path, |file| file.write_all(&bytes)).map_err(|e| io(path, e))?);
    }
    if options.half && report.clamped > 0 {
        report.lost = cube.share_beyond(TexelFormat::Rgba16F.largest());
    }
    for (path, file) in paths.iter().zip(staged) {
        file.publish().map_err(|e| io(path, e))?;
    }
    Ok(report)
}

#[cfg(test)]
mod tests {
    use lobe_image::PictureReadOptions;
    use lobe_sh::Rgb;

    use super::*;
    use crate::files::write::write_env;
    use crate::map::env_map::EnvMap;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("lobe-cube-faces-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn files(folder: &Path, extension: &str) -> FaceFiles {
        FaceFiles::of(&folder.join(format!("%.{extension}"))).unwrap()
    }

    #[test]
    fn six_files_are_named_by_a_percent_sign() {
        let named = |path: &str| FaceFiles::of(Path::new(path)).map(|files| files.to_write()[3].display().to_string());
        assert_eq!(named("sky/%.exr").as_deref(), Some("sky/ny.exr"), "in a folder");
        assert_eq!(named("%.hdr").as_deref(), Some("ny.hdr"), "here");
        assert_eq!(named("a/sky_%_0.EXR").as_deref(), Some("a/sky_ny_0.EXR"), "with a prefix");
        assert_eq!(named("sky.exr"), None, "a file");
        assert_eq!(named("100%/sky.exr"), None, "a folder of that name");
        let folder = folder("percent");
        std::fs::write(folder.join("100%.exr"), "").unwrap();
        assert_eq!(FaceFiles::of(&folder.join("100%.exr")), None, "a file that is there");
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn faces_are_found_by_prefix_and_any_names_and_the_names_that_were_tried_are_told() {
        let cube = CubeMap::from_fn(4, |s| Rgb::new(s.x() as f32 + 2.0, s.y() as f32 + 2.0, s.z() as f32 + 2.0));
        let folder = folder("prefix");
        let files = FaceFiles::of(&folder.join("sky_%.pfm")).unwrap();
        let message = read_cube_faces(&files, &MapReadOptions::default()).unwrap_err().to_string();
        assert!(
            message.contains("sky_%.pfm")
                && message.contains("px mx py")
                && message.contains("rt lf up")
                && message.contains("0 1 2"),
            "{message}"
        );
        write_cube_faces(&files, &cube, CubeHandedness::Right, &PictureWriteOptions::default()).unwrap();
        let photographs = MapReadOptions::default().faces(FaceOrder::usual(FaceNames::Sides));
        let axes = MapReadOptions::default().faces(FaceOrder::usual(FaceNames::Axes));
        let as_photographs = {
            let faces = cube.faces(CubeHandedness::Right);
            FaceOrder::usual(FaceNames::Sides).cube(4, faces, CubeHandedness::Right).unwrap()
        };
        let mut written = AXES[0].map(str::to_owned);
        for (names, kind) in all_names().collect::<Vec<_>>() {
            let file = |name: &str| folder.join(format!("sky_{name}.pfm"));
            // Two steps: numbers from 0 are those from 1.
            written.iter().for_each(|old| std::fs::rename(file(old), file(&format!("{old}~"))).unwrap());
            written
                .iter()
                .zip(&names)
                .for_each(|(old, new)| std::fs::rename(file(&format!("{old}~")), file(new)).unwrap());
            let read = |options: &MapReadOptions| read_cube_faces(&files, options).unwrap();
            let (read_by_default, _, assumed) = read(&MapReadOptions::default());
            let expected = if kind == Some(FaceNames::Sides) { &as_photographs } else { &cube };
            assert!(read_by_default == *expected, "{names:?}");
            let is_of_sides = assumed == Some(FaceAssumption::Photographs);
            assert_eq!(is_of_sides, kind == Some(FaceNames::Sides), "{names:?}: {assumed:?}");
            assert!(read(&photographs).0 == as_photographs && read(&axes).0 == cube, "{names:?} as told");
            assert_eq!(read(&axes).2, None, "{names:?}: told, not assumed");
            let found = FaceFiles::of_input(&folder).unwrap().and_then(|found| found.to_read());
            assert_eq!(found, files.to_read(), "{names:?} in a folder");
            written = names;
        }
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_folder_of_six_faces_stands_for_them_and_is_told_if_it_has_others() {
        let cube = CubeMap::from_fn(2, |s| Rgb::new(s.x() as f32 + 2.0, s.y() as f32 + 2.0, s.z() as f32 + 2.0));
        let folder = folder("whole");
        let told = || FaceFiles::of_input(&folder).unwrap_err().to_string();
        std::fs::write(folder.join("px.txt"), "a note").unwrap();
        assert!(told().contains("without the six faces of a cube"), "{}", told());
        let write = |name: &str| {
            let files = FaceFiles::of(&folder.join(name)).unwrap();
            write_cube_faces(&files, &cube, CubeHandedness::Right, &PictureWriteOptions::default()).unwrap();
        };
        // The name of a face stands in it twice.
        write("px_%.pfm");
        let found = FaceFiles::of_input(&folder).unwrap().unwrap();
        assert_eq!(found.to_string(), folder.join("px_%.pfm").display().to_string(), "the cube");
        let (read, report) = crate::read_map(&folder, &MapReadOptions::default()).unwrap();
        assert_eq!((read.base().mapping(), report.faces.len()), (crate::Mapping::Cube, 6), "and its faces");
        write("%.hdr");
        assert!(told().contains("several cubes here; name one: ") && told().contains("%.hdr"), "{}", told());
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn faces_named_by_sides_are_no_photographs_where_a_handedness_is_given() {
        let folder = folder("sides");
        let cube = CubeMap::from_fn(4, dice);
        for hand in [CubeHandedness::Right, CubeHandedness::Left] {
            // Portable float maps say nothing of themselves.
            write_cube_faces(&files(&folder, "pfm"), &cube, hand, &PictureWriteOptions::default()).unwrap();
            for (axis, side) in AXES[0].iter().zip(SIDES[0]) {
                let file = |name: &str| folder.join(format!("{name}.pfm"));
                std::fs::rename(file(axis), file(side)).unwrap();
            }
            let (read, _, assumed) =
                read_cube_faces(&files(&folder, "pfm"), &MapReadOptions::default().handedness(hand)).unwrap();
            assert!(read == cube && assumed.is_none(), "{hand:?}: {assumed:?}");
        }
        // The option holds against the file too, and that is said.
        write_cube_faces(&files(&folder, "exr"), &cube, CubeHandedness::Left, &PictureWriteOptions::default()).unwrap();
        let options = MapReadOptions::default().handedness(CubeHandedness::Right);
        let (read, reports, _) = read_cube_faces(&files(&folder, "exr"), &options).unwrap();
        let notes = &reports[0].notes;
        assert!(read != cube && notes.iter().any(|note| note.contains("taken for right-handed")), "{notes:?}");
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn six_faces_are_held_against_the_limits_together() {
        let folder = folder("limits");
        write_cube_faces(
            &files(&folder, "pfm"),
            &CubeMap::from_fn(8, dice),
            CubeHandedness::Right,
            &PictureWriteOptions::default(),
        )
        .unwrap();
        let read = |picture: PictureReadOptions| {
            read_cube_faces(&files(&folder, "pfm"), &MapReadOptions::default().picture(picture))
        };
        // A face of 8 x 8 texels is a file of 780 bytes and some in the header.
        const FILE: u64 = 8 * 8 * 12 + 64;
        let limits = PictureReadOptions::default().max_texels(6 * 8 * 8).max_bytes(6 * FILE);
        assert!(read(limits.clone()).is_ok(), "all of them fit");
        for (limits, expected) in [
            (limits.clone().max_texels(6 * 8 * 8 - 1), ReadOption::MaxTexels),
            (limits.max_bytes(6 * 767), ReadOption::MaxBytes),
        ] {
            let EnvError::Image(ImageError::Refused { message, option, .. }) = read(limits).unwrap_err() else {
                panic!("not refused");
            };
            assert!(option == expected && message.contains("a sixth of all"), "{option:?}: {message}");
        }
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn frames_of_a_film_are_no_cube_and_six_numbers_behind_a_letter_are() {
        let folder = folder("film");
        let touch = |name: String| std::fs::write(folder.join(name), "").unwrap();
        (0..96).for_each(|k| touch(format!("frame_{k:04}.exr")));
        let message = FaceFiles::of_input(&folder).unwrap_err().to_string();
        assert!(message.contains("without the six faces of a cube"), "{message}");
        (0..FACES).for_each(|k| touch(format!("face{k}.png")));
        let found = FaceFiles::of_input(&folder).unwrap().unwrap();
        assert_eq!(found.to_string(), folder.join("face%.png").display().to_string(), "beside the film");
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn pictures_for_looking_at_share_one_exposure() {
        let light = |s: lobe_sh::Dir| if s.z() > 0.9 { Rgb::new(4.0, 4.0, 4.0) } else { Rgb::new(0.1, 0.1, 0.1) };
        let folder = folder("png");
        let files = files(&folder, "png");
        write_cube_faces(&files, &CubeMap::from_fn(8, light), CubeHandedness::Right, &PictureWriteOptions::default())
            .unwrap();
        let (back, ..) = read_cube_faces(&files, &MapReadOptions::default()).unwrap();
        assert!(back.texel(2, 4, 4).g > 3.0 * back.texel(3, 4, 4).g, "up is brighter than down");
        assert_eq!(back.texel(3, 4, 4), back.texel(0, 4, 4), "dark faces look alike");
        std::fs::remove_dir_all(folder).unwrap();
    }

    /// Light that every format holds exactly, another at each face.
    fn dice(s: lobe_sh::Dir) -> Rgb<f32> {
        let sides = [s.x(), s.y(), s.z()].map(|c| if c > 0.0 { 1.0 } else { 2.0 });
        Rgb::new(sides[0], sides[1], sides[2])
    }

    #[test]
    fn six_files_come_back_as_they_went_out() {
        let folder = folder("round-trip");
        let cube = CubeMap::from_fn(5, |s| Rgb::new(s.x() as f32 + 2.0, s.y() as f32 + 2.0, s.z() as f32 + 2.0));
        for handedness in [CubeHandedness::Left, CubeHandedness::Right] {
            let report =
                write_cube_faces(&files(&folder, "exr"), &cube, handedness, &PictureWriteOptions::default()).unwrap();
            assert_eq!(report.clamped, 0, "floats hold everything");
            let (back, ..) =
                read_cube_faces(&files(&folder, "exr"), &MapReadOptions::default().handedness(handedness)).unwrap();
            assert!(back == cube, "{handedness:?}: the cube changed");
        }
        let (other, ..) =
            read_cube_faces(&files(&folder, "exr"), &MapReadOptions::default().handedness(CubeHandedness::Left))
                .unwrap();
        assert!(other != cube, "faces written as right-handed are no left-handed ones");
        for (extension, is_kept) in [("exr", true), ("hdr", true), ("pfm", false)] {
            let files = files(&folder, extension);
            let write = PictureWriteOptions::default();
            write_cube_faces(&files, &CubeMap::from_fn(4, dice), CubeHandedness::Left, &write).unwrap();
            let (back, reports, _) = read_cube_faces(&files, &MapReadOptions::default()).unwrap();
            assert_eq!(back == CubeMap::from_fn(4, dice), is_kept, "{extension}: {:?}", reports[0].notes);
        }
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn where_one_face_cannot_be_written_none_is() {
        let folder = folder("together");
        let cubes = [1.0, 2.0].map(|light| CubeMap::from_fn(4, |_| Rgb::new(light, light, light)));
        let write = |cube| {
            write_cube_faces(&files(&folder, "exr"), cube, CubeHandedness::Right, &PictureWriteOptions::default())
        };
        let read = || {
            read_cube_faces(&files(&folder, "exr"), &MapReadOptions::default().handedness(CubeHandedness::Right))
                .map(|(cube, ..)| cube)
        };
        write(&cubes[0]).unwrap();
        // A folder in the place of the last face.
        std::fs::remove_file(folder.join("nz.exr")).unwrap();
        std::fs::create_dir(folder.join("nz.exr")).unwrap();
        let message = write(&cubes[1]).unwrap_err().to_string();
        assert!(message.contains("nz.exr") && !message.contains('\n'), "{message}");
        let count = std::fs::read_dir(&folder).unwrap().count();
        assert_eq!(count, 6, "nothing temporary is left");
        let px = read_picture(folder.join("px.exr"), &PictureReadOptions::default()).unwrap().0;
        assert_eq!(px.pixel(0, 0)[1], 1.0, "the first face is still the old one");
        std::fs::remove_dir(folder.join("nz.exr")).unwrap();
        write(&cubes[1]).unwrap();
        assert!(read().unwrap() == cubes[1], "then all are written");
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn faces_of_another_size_or_none_are_errors_of_one_line() {
        let folder = folder("sizes");
        let cube = CubeMap::from_fn(4, |_| Rgb::new(1.0, 1.0, 1.0));
        write_cube_faces(&files(&folder, "pfm"), &cube, CubeHandedness::Left, &PictureWriteOptions::default()).unwrap();
        let read =
            || read_cube_faces(&files(&folder, "pfm"), &MapReadOptions::default().handedness(CubeHandedness::Left));
        for (name, (w, h)) in [("py", (5, 5)), ("px", (4, 2)), ("nz", (2, 2))] {
            let path = folder.join(format!("{name}.pfm"));
            let kept = std::fs::read(&path).unwrap();
            let map = EnvMap::from_fn(w, h, |_| Rgb::new(1.0, 1.0, 1.0));
            write_env(&path, &map, &PictureWriteOptions::default()).unwrap();
            let message = read().unwrap_err().to_string();
            let expected = format!("a face of 4 x 4 expected, but this is {w} x {h}");
            assert!(message.contains(&expected) && !message.contains('\n'), "{name}: {message}");
            std::fs::write(&path, kept).unwrap();
        }
        std::fs::remove_file(folder.join("pz.pfm")).unwrap();
        let message = read().unwrap_err().to_string();
        assert!(message.contains("pz.pfm") && !message.contains('\n'), "{message}");
        std::fs::remove_dir_all(folder).unwrap();
    }
}
