//! Projection of a map file that is not held in memory.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use lobe_image::{PictureReadReport, PictureRows, RowStrip};
use lobe_sh::{Rgb, ShVec};

use crate::error::EnvError;
use crate::files::bundled;
use crate::files::cube_faces::FaceFiles;
use crate::files::read_map::{read_map, told_by_file, unusual_lat_long};
use crate::files::read_options::{MapReadOptions, MapReadReport};
use crate::mapping::mapping::Mapping;
use crate::projection::lat_long_projector::LatLongProjector;
use crate::projection::project_map::project_map;

/// The highest order at which sums along single rows are the quickest way; above, all rows are needed at once.
const HIGHEST_ORDER_BY_ROWS: usize = 16;

/// The texels of 12 bytes that take as much room as the sums of one order along a row, two colors of `f64`.
const COLUMNS_OF_SUMS: usize = 4;

/// [`project_map`] of the map in a file, with the report of [`read_map`].
///
/// A lat-long map in a Radiance, portable float map or scan-line OpenEXR file is projected while it is decoded: to order 16 and a quarter of its width, neither the file
/// nor the picture is in memory as a whole. The coefficients have the same bits as those of `project_map` of the map that `read_map`
/// returns, the report and the errors are the same (test `a_file_by_rows_has_the_projection_and_the_report_of_its_map`).
///
/// ```
/// use lobe_env::{MapReadOptions, bundled, project_env, project_map_file};
///
/// let (light, report) = project_map_file("bundled:sunset", 3, &MapReadOptions::default())?;
/// assert_eq!(light, project_env(&bundled::sunset().map(), 3));
/// assert_eq!(report.picture.width, 512);
/// # Ok::<(), lobe_env::EnvError>(())
/// ```
///
/// # Errors
/// As [`read_map`].
pub fn project_map_file(
    path: impl AsRef<Path>,
    order: usize,
    options: &MapReadOptions,
) -> Result<(ShVec<Rgb<f64>>, MapReadReport), EnvError> {
    let path = path.as_ref();
    if order <= HIGHEST_ORDER_BY_ROWS
        && let Some((rows, told)) = rows_of_lat_long(path, order, options)?
    {
        return project_rows_of_file(rows, told, order, path, options);
    }
    let (map, report) = read_map(path, options)?;
    Ok((project_map(map.base(), order), report))
}

/// The rows of a lat-long map, and what the file says of the mapping.
type ToldRows = (PictureRows<BufReader<File>>, Vec<String>);

/// The rows of a file as they come; none if it is no lat-long map, or has to be read whole.
fn rows_of_lat_long(path: &Path, order: usize, options: &MapReadOptions) -> Result<Option<ToldRows>, EnvError> {
    let is_bundled = path.display().to_string().starts_with(bundled::PREFIX);
    let is_part = options.elevations.is_some() || options.fisheye.is_some() || options.faces.is_some();
    if is_bundled || is_part || FaceFiles::of_input(path)?.is_some() {
        return Ok(None);
    }
    let Some(rows) = PictureRows::open(path, &options.picture)? else { return Ok(None) };
    let PictureReadReport { width, height, envmap, mapping, panorama, .. } = rows.report();
    if !panorama.is_empty() {
        return Ok(None);
    }
    let kept = mapping.as_deref().and_then(Mapping::from_name);
    let told = match (options.asked(), envmap, kept) {
        // A name that tells of no mapping may tell of the hands of a cube.
        (None, None, None) if mapping.is_some() => return Ok(None),
        (Some(Mapping::LatLong), _, _) => Vec::new(),
        (None, None, Some(Mapping::LatLong)) => vec![told_by_file(Mapping::LatLong)],
        (None, None, None) if *width == 2 * height => Vec::new(),
        _ => return Ok(None),
    };
    // The sums of a row take more room than its texels.
    let is_narrow = *width < COLUMNS_OF_SUMS * order;
    Ok((!is_narrow).then_some((rows, told)))
}

fn project_rows_of_file<R: Read + Seek + Send>(
    mut rows: PictureRows<R>,
    told: Vec<String>,
    order: usize,
    path: &Path,
    options: &MapReadOptions,
) -> Result<(ShVec<Rgb<f64>>, MapReadReport), EnvError> {
    let (width, height) = (rows.report().width, rows.report().height);
    let mut projector = LatLongProjector::new(width, height, order);
    let mut add = |strips: Vec<RowStrip>| {
        for strip in strips {
            let texels: Vec<Rgb<f32>> = strip.texels.into_iter().map(Rgb::from).collect();
            projector.add_rows(strip.first_row, &texels);
        }
    };
    let mut strips = rows.next_strips()?;
    while let Some(decoded) = strips {
        // Rows are projected while the next ones are decoded.
        let (next, ()) = rayon::join(|| rows.next_strips(), || add(decoded));
        strips = next?;
    }
    let mut report: MapReadReport = rows.finish()?.into();
    report.picture.notes.extend(unusual_lat_long(width, height));
    report.told = told;
    options.check_handedness(Mapping::LatLong, &path.display().to_string())?;
    Ok((projector.expansion(), report))
}
