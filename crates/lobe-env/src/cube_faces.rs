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
