//! Pictures and maps row by row are those that are read whole: texels, reports and coefficients are equal, without a tolerance.
#![no_main]

use std::fs;
use std::io::Cursor;
use std::mem;
use std::path::PathBuf;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use lobe_env::{MapReadOptions, Mapping, project_map, project_map_file, read_map_bytes};
use lobe_fuzz::{let_decoders_panic, path_of_process};
use lobe_image::{
    ImageError, Nonfinite, Picture, PictureReadOptions, PictureReadReport, PictureRows, read_picture_bytes,
};

/// Small enough that no input takes long, large enough for rows that come in several parts, as few are together where fuzzing.
const MAX_TEXELS: usize = 1 << 11;

/// The orders of projections. Rows of fewer than four texels an order are read whole.
const ORDERS: [usize; 2] = [2, 5];

/// A file of this process.
static PATH: LazyLock<PathBuf> = LazyLock::new(|| path_of_process("map"));

/// The picture of all rows; none if it has to be read whole.
fn by_rows(bytes: &[u8], options: &PictureReadOptions) -> Result<Option<(Picture, PictureReadReport)>, ImageError> {
    let Some(mut rows) = PictureRows::new(Cursor::new(bytes), "fuzz", options)? else { return Ok(None) };
    let (width, height) = (rows.report().width, rows.report().height);
    let mut texels = vec![[0.0; 3]; width * height];
    let mut came = vec![false; height];
    while let Some(strips) = rows.next_strips()? {
        for strip in strips {
            let count = strip.texels.len() / width;
            let came = &mut came[strip.first_row..][..count];
            assert!(came.iter_mut().all(|row| !mem::replace(row, true)), "a row comes once");
            texels[strip.first_row * width..][..strip.texels.len()].copy_from_slice(&strip.texels);
        }
    }
    let report = rows.finish()?;
    Ok(Some((Picture::new(width, height, texels)?, report)))
}

/// The rows are the picture, or fail alike.
fn check_rows(bytes: &[u8], options: &PictureReadOptions) {
    if let Some(rows) = by_rows(bytes, options).map_err(|error| error.to_string()).transpose() {
        let whole = read_picture_bytes(bytes, "fuzz", options).map_err(|error| error.to_string());
        assert!(rows == whole, "by rows {:?}, whole {:?}", rows.map(|read| read.1), whole.map(|read| read.1));
    }
}

/// The projection of the file is that of the map, or both fail. Messages may differ: a system refuses a place in a file beyond 2⁶³, a
/// slice of bytes does not.
fn check_projection(bytes: &[u8], options: &MapReadOptions) {
    let name = PATH.display().to_string();
    let whole = read_map_bytes(bytes, &name, options);
    for order in ORDERS {
        match (project_map_file(&*PATH, order, options), &whole) {
            (Ok((light, found)), Ok((map, report))) => {
                assert_eq!(light, project_map(map.base(), order), "order {order}");
                assert_eq!(found, *report, "order {order}");
            }
            (Err(error), Err(_)) => {
                let line = error.to_string();
                assert!(line.starts_with(&name) && !line.contains('\n'), "{line:?}");
            }
            (by_rows, whole) => {
                let (by_rows, whole) = (by_rows.err(), whole.as_ref().err());
                panic!("order {order}: errors by rows {by_rows:?}, whole {whole:?}");
            }
        }
    }
}

fuzz_target!(init: let_decoders_panic(), |bytes: &[u8]| {
    fs::write(&*PATH, bytes).expect("the file can be written");
    let strict = PictureReadOptions::default().max_texels(MAX_TEXELS);
    let lenient = strict.clone().nonfinite(Nonfinite::Zero).to_rec_709(true);
    for (picture, mapping) in [(strict, None), (lenient, Some(Mapping::LatLong))] {
        check_rows(bytes, &picture);
        check_projection(bytes, &MapReadOptions::default().picture(picture).mapping(mapping));
    }
    fs::remove_file(&*PATH).expect("the file can be removed");
});
