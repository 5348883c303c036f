//! Cube maps in six files, one for each face.

use std::path::{Path, PathBuf};

use lobe_image::{
    ImageError, PictureReadReport, PictureWriteOptions, PictureWriteReport, encode_picture, read_picture,
};
use lobe_io::{StagedFile, check_writable};
use lobe_sh::Rgb;

use crate::mapping::cube::FACES;
use crate::{CubeHandedness, CubeMap, EnvError, MapReadOptions};

/// The names of the faces +X, -X, +Y, -Y, +Z, -Z in the names of files.
pub const FACE_NAMES: [&str; FACES] = ["px", "nx", "py", "ny", "pz", "nz"];

/// The names that other programs give to the same faces; they are read, not written.
const OTHER_NAMES: [[&str; FACES]; 2] =
    [["posx", "negx", "posy", "negy", "posz", "negz"], ["right", "left", "top", "bottom", "front", "back"]];

/// The placeholder for the names of the faces in a path.
const ANY_FACE: &str = "%";

/// The folder and the extension of `FOLDER/%.EXT`, which stands for the six files of a cube.
#[must_use]
pub fn face_files(path: &Path) -> Option<(&Path, String)> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    (path.file_stem()? == ANY_FACE).then(|| (path.parent().unwrap_or(Path::new("")), extension))
}

/// The file of each of the faces +X, -X, +Y, -Y, +Z, -Z of a cube in a folder: `px` to `nz` with the given extension,
/// or `posx` to `negz`, or `right`, `left`, `top`, `bottom`, `front` and `back`, whichever has its first file there.
#[must_use]
pub fn cube_face_paths(folder: impl AsRef<Path>, extension: &str) -> [PathBuf; FACES] {
    let paths = |names: &[&str; FACES]| names.map(|name| folder.as_ref().join(format!("{name}.{extension}")));
    let own = paths(&FACE_NAMES);
    if own[0].exists() {
        return own;
    }
    OTHER_NAMES.iter().map(paths).find(|paths| paths[0].exists()).unwrap_or(own)
}

/// Reads a cube from the six files of a folder that [`cube_face_paths`] names, with the reports of the faces.
pub(crate) fn read_cube_faces(
    folder: &Path,
    extension: &str,
    options: &MapReadOptions,
) -> Result<(CubeMap, Vec<PictureReadReport>), EnvError> {
    let mut texels: Vec<Rgb<f32>> = Vec::new();
    let mut reports: Vec<PictureReadReport> = Vec::with_capacity(FACES);
    for path in cube_face_paths(folder, extension) {
        let (face, report) = read_picture(&path, &options.picture)?;
        let (width, height, size) = (face.width(), face.height(), reports.first().map_or(face.width(), |r| r.width));
        if (width, height) != (size, size) {
            let message = format!("a face of {size} x {size} expected, but this is {width} x {height}");
            return Err(ImageError::Invalid { place: path.display().to_string(), message }.into());
        }
        texels.extend(face.into_pixels::<Rgb<f32>>());
        reports.push(report);
    }
    Ok((CubeMap::new(reports[0].width, texels)?.of_handedness(options.handedness), reports))
}

/// Writes a cube as the files `px`, `nx`, `py`, `ny`, `pz` and `nz` of a folder, in a format of
/// [`write_env`](crate::write_env); the report counts over all faces.
///
/// The files are renamed into place when all six are on the disk: where one cannot be written, none is.
///
/// # Errors
/// As [`write_env`](crate::write_env).
pub fn write_cube_faces(
    folder: impl AsRef<Path>,
    extension: &str,
    cube: &CubeMap,
    handedness: CubeHandedness,
    options: &PictureWriteOptions,
) -> Result<PictureWriteReport, ImageError> {
    let io = |path: &Path, source| ImageError::Io { place: path.display().to_string(), source };
    let paths = FACE_NAMES.map(|name| folder.as_ref().join(format!("{name}.{extension}")));
    for path in &paths {
        check_writable(path).map_err(|e| io(path, e))?;
    }
    let mut report = PictureWriteReport::default();
    let mut staged = Vec::with_capacity(FACES);
    for (path, face) in paths.iter().zip(cube.faces(handedness)) {
        let (bytes, found) = encode_picture(path, cube.size(), &face, options)?;
        report.clamped += found.clamped;
        staged.push(StagedFile::write(path, |file| file.write_all(&bytes)).map_err(|e| io(path, e))?);
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
    use crate::{EnvMap, write_env};

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("lobe-cube-faces-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn six_files_are_named_by_a_percent_sign() {
        assert_eq!(face_files(Path::new("sky/%.exr")), Some((Path::new("sky"), "exr".to_owned())), "in a folder");
        assert_eq!(face_files(Path::new("%.hdr")), Some((Path::new(""), "hdr".to_owned())), "here");
        assert_eq!(face_files(Path::new("100%.exr")), None, "a name that ends so");
    }

    #[test]
    fn six_files_come_back_as_they_went_out() {
        let folder = folder("round-trip");
        let cube = CubeMap::from_fn(5, |s| Rgb::new(s.x() as f32 + 2.0, s.y() as f32 + 2.0, s.z() as f32 + 2.0));
        for handedness in [CubeHandedness::Left, CubeHandedness::Right] {
            let report = write_cube_faces(&folder, "exr", &cube, handedness, &PictureWriteOptions::default()).unwrap();
            assert_eq!(report.clamped, 0, "floats hold everything");
            let (back, _) = read_cube_faces(&folder, "exr", &MapReadOptions::default().handedness(handedness)).unwrap();
            assert!(back == cube, "{handedness:?}: the cube changed");
        }
        let (other, _) =
            read_cube_faces(&folder, "exr", &MapReadOptions::default().handedness(CubeHandedness::Left)).unwrap();
        assert!(other != cube, "faces written as right-handed are no left-handed ones");
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn where_one_face_cannot_be_written_none_is() {
        let folder = folder("together");
        let cubes = [1.0, 2.0].map(|light| CubeMap::from_fn(4, |_| Rgb::new(light, light, light)));
        let write =
            |cube| write_cube_faces(&folder, "exr", cube, CubeHandedness::Right, &PictureWriteOptions::default());
        let read = || {
            read_cube_faces(&folder, "exr", &MapReadOptions::default().handedness(CubeHandedness::Right))
                .map(|(cube, _)| cube)
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
    fn other_names_of_faces_are_read() {
        let cube = CubeMap::from_fn(4, |s| Rgb::new(s.x() as f32 + 2.0, s.y() as f32 + 2.0, s.z() as f32 + 2.0));
        for (k, names) in OTHER_NAMES.iter().enumerate() {
            let folder = folder(&format!("names-{k}"));
            write_cube_faces(&folder, "pfm", &cube, CubeHandedness::Right, &PictureWriteOptions::default()).unwrap();
            for (own, other) in FACE_NAMES.iter().zip(names) {
                std::fs::rename(folder.join(format!("{own}.pfm")), folder.join(format!("{other}.pfm"))).unwrap();
            }
            let read = read_cube_faces(&folder, "pfm", &MapReadOptions::default().handedness(CubeHandedness::Right));
            assert!(read.unwrap().0 == cube, "{names:?}");
            std::fs::remove_dir_all(folder).unwrap();
        }
    }

    #[test]
    fn faces_of_another_size_or_none_are_errors_of_one_line() {
        let folder = folder("sizes");
        let cube = CubeMap::from_fn(4, |_| Rgb::new(1.0, 1.0, 1.0));
        write_cube_faces(&folder, "pfm", &cube, CubeHandedness::Left, &PictureWriteOptions::default()).unwrap();
        let read = || read_cube_faces(&folder, "pfm", &MapReadOptions::default().handedness(CubeHandedness::Left));
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
