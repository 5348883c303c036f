//! PNG files: their bytes, and staged writing.

use std::fs;
use std::io::BufReader;
use std::path::Path;

use lobe_figures::{Ball, Balloon, CubeCross, lat_long_picture};
use lobe_image::{ImageError, Picture, Tone, srgb_decode};
use lobe_sh::{Dir, Rgb};

/// A function without symmetry.
fn f(s: Dir) -> f64 {
    (2.0 * s.x() - 0.7 * s.y()).sin() + s.y() * s.z() - 0.3
}

fn figures() -> Vec<Vec<u8>> {
    let color = |s: Dir| Rgb::new(f(s), 0.5 + 0.5 * s.y(), s.z());
    let pictures = [
        Balloon::new(70).picture(f),
        CubeCross::new(30).picture(f),
        Ball::new(50).lit(Rgb::new(0.1, 0.1, 0.1), color),
        lat_long_picture(60, 30, color),
        lat_long_picture(60, 30, color).resized(41, 7),
    ];
    pictures.iter().map(|picture| picture.to_png(&Tone::PHOTOGRAPH).expect("these pictures have pixels")).collect()
}

/// The columns and rows of a PNG file of three colors, and its bytes.
fn pixels_of(path: &Path) -> ((u32, u32), Vec<u8>) {
    let file = fs::File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().unwrap();
    assert_eq!(reader.output_color_type(), (png::ColorType::Rgb, png::BitDepth::Eight), "{}", path.display());
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    (reader.info().size(), pixels)
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let with = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(figures);
    let one = with(1);
    for threads in [2, 5] {
        for (i, (a, b)) in one.iter().zip(with(threads)).enumerate() {
            assert!(*a == b, "figure {i} differs between 1 and {threads} threads");
        }
    }
}

#[test]
fn a_file_holds_the_pixels_row_by_row_from_the_top() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.png");
    let level = |v: usize| srgb_decode(v as f64 / 255.0) as f32;
    let picture = Picture::from_fn(7, 5, |x, y| Rgb::new(level(30 * x), level(40 * y), level(255)));
    picture.write_png(&path, &Tone::PLAIN).unwrap();
    let (size, pixels) = pixels_of(&path);
    assert_eq!(size, (7, 5), "columns and rows");
    for (i, pixel) in pixels.as_chunks().0.iter().enumerate() {
        assert_eq!(*pixel, [30 * (i % 7) as u8, 40 * (i / 7) as u8, 255], "pixel {i}");
    }
}

#[test]
fn an_old_file_is_replaced_and_nothing_else_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.png");
    fs::write(&path, "old").unwrap();
    let picture = Picture::filled(4, 4, Rgb::new(0.5, 0.5, 0.5));
    picture.write_png(&path, &Tone::PLAIN).unwrap();
    assert_eq!(fs::read(&path).unwrap(), picture.to_png(&Tone::PLAIN).unwrap(), "the new file");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "files in the folder");
}

#[test]
fn a_picture_that_cannot_be_written_is_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("missing").join("picture.png");
    let error = Picture::filled(1, 1, Rgb::new(0.0, 0.0, 0.0)).write_png(&path, &Tone::PLAIN).unwrap_err();
    let text = error.to_string();
    assert!(matches!(error, ImageError::Io { .. }), "{error:?}");
    assert!(text.contains("picture.png: cannot write the picture: ") && !text.contains('\n'), "{text}");

    let empty = Picture::filled(0, 3, Rgb::new(0.0, 0.0, 0.0)).to_png(&Tone::PLAIN).unwrap_err().to_string();
    assert_eq!(empty, "a 0 x 3 picture as PNG: it has no pixels", "{empty}");
}
