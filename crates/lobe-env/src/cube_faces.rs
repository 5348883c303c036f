//! A cube as six files, one for each face.

use std::path::{Path, PathBuf};

use crate::cube::FACES;
use crate::{CubeHandedness, CubeMap, EnvError, EnvMap, ReadOptions, ReadReport, WriteOptions, WriteReport};
use crate::{read_raster, write_env};

/// The names of the faces +X, -X, +Y, -Y, +Z, -Z in the names of files.
pub const FACE_NAMES: [&str; FACES] = ["px", "nx", "py", "ny", "pz", "nz"];

/// The files `px`, `nx`, `py`, `ny`, `pz` and `nz` with the given extension in a folder.
fn paths(folder: &Path, extension: &str) -> [PathBuf; FACES] {
    FACE_NAMES.map(|name| folder.join(format!("{name}.{extension}")))
}

/// Reads a cube from the files `px`, `nx`, `py`, `ny`, `pz` and `nz` of a folder, in any format of
/// [`read_env`](crate::read_env); the reports are those of the faces.
///
/// # Errors
/// As [`read_raster`]; [`EnvError::Invalid`] if a face is not square, or not of the size of the first.
pub fn read_cube_faces(
    folder: impl AsRef<Path>,
    extension: &str,
    handedness: CubeHandedness,
    options: &ReadOptions,
) -> Result<(CubeMap, [ReadReport; FACES]), EnvError> {
    let mut faces = Vec::with_capacity(FACES);
    let mut reports = Vec::with_capacity(FACES);
    let mut size = 0;
    for path in paths(folder.as_ref(), extension) {
        let (face, report) = read_raster(&path, options)?;
        size = if faces.is_empty() { face.width } else { size };
        if (face.width, face.height) != (size, size) {
            let message = format!("a face of {size} x {size} expected, but this is {} x {}", face.width, face.height);
            return Err(EnvError::Invalid { file: path.display().to_string(), message });
        }
        faces.push(face.texels);
        reports.push(report);
    }
    let (Ok(faces), Ok(reports)) = (faces.try_into(), reports.try_into()) else { unreachable!("six files were read") };
    Ok((CubeMap::from_handed_faces(size, faces, handedness)?, reports))
}

/// Writes a cube as the files `px`, `nx`, `py`, `ny`, `pz` and `nz` of a folder, in a format of [`write_env`]; the
/// report counts over all faces.
///
/// # Errors
/// As [`write_env`].
pub fn write_cube_faces(
    folder: impl AsRef<Path>,
    extension: &str,
    cube: &CubeMap,
    handedness: CubeHandedness,
    options: &WriteOptions,
) -> Result<WriteReport, EnvError> {
    let mut report = WriteReport::default();
    for (path, face) in paths(folder.as_ref(), extension).iter().zip(cube.faces(handedness)) {
        // The writer asks for a picture and does not look at directions.
        report.clamped += write_env(path, &EnvMap::new(cube.size(), cube.size(), face)?, options)?.clamped;
    }
    Ok(report)
}

#[cfg(test)]
mod tests {
    use lobe_sh::Rgb;

    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("lobe-cube-faces-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn six_files_come_back_as_they_went_out() {
        let folder = folder("round-trip");
        let cube = CubeMap::from_fn(5, |s| Rgb::new(s.x() as f32 + 2.0, s.y() as f32 + 2.0, s.z() as f32 + 2.0));
        for handedness in [CubeHandedness::Left, CubeHandedness::Right] {
            let report = write_cube_faces(&folder, "exr", &cube, handedness, &WriteOptions::default()).unwrap();
            assert_eq!(report.clamped, 0, "floats hold everything");
            let (back, _) = read_cube_faces(&folder, "exr", handedness, &ReadOptions::default()).unwrap();
            assert!(back == cube, "{handedness:?}: the cube changed");
        }
        let (other, _) = read_cube_faces(&folder, "exr", CubeHandedness::Left, &ReadOptions::default()).unwrap();
        assert!(other != cube, "faces written as right-handed are no left-handed ones");
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn faces_of_another_size_or_none_are_errors_of_one_line() {
        let folder = folder("sizes");
        let cube = CubeMap::from_fn(4, |_| Rgb::new(1.0, 1.0, 1.0));
        write_cube_faces(&folder, "pfm", &cube, CubeHandedness::Left, &WriteOptions::default()).unwrap();
        let read = || read_cube_faces(&folder, "pfm", CubeHandedness::Left, &ReadOptions::default());
        for (name, (w, h)) in [("py", (5, 5)), ("px", (4, 2)), ("nz", (2, 2))] {
            let path = folder.join(format!("{name}.pfm"));
            let kept = std::fs::read(&path).unwrap();
            let map = EnvMap::from_fn(w, h, |_| Rgb::new(1.0, 1.0, 1.0));
            write_env(&path, &map, &WriteOptions::default()).unwrap();
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
