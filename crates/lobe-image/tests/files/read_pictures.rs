//! Portable float maps, PNG and JPEG.

use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageFormat};
use lobe_image::{FileFormat, Picture, PictureReadOptions, PictureReadReport, read_picture_bytes};

fn read(bytes: &[u8]) -> (Picture, PictureReadReport) {
    read_picture_bytes(bytes, "test", &PictureReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// A portable float map with these numbers, the lowest row first.
pub(crate) fn pfm(header: &str, values: &[f32], bytes: fn(f32) -> [u8; 4]) -> Vec<u8> {
    [header.as_bytes(), &values.iter().flat_map(|v| bytes(*v)).collect::<Vec<_>>()].concat()
}

/// A picture of 16 x 8 as a file, in `color` of the `image` crate; red rises to the right, green downwards.
pub(crate) fn ldr(color: fn(DynamicImage) -> DynamicImage, format: ImageFormat) -> Vec<u8> {
    let picture = image::RgbImage::from_fn(16, 8, |x, y| image::Rgb([17 * x as u8, 36 * y as u8, 128]));
    let mut bytes = Cursor::new(Vec::new());
    color(DynamicImage::ImageRgb8(picture)).write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

#[test]
fn portable_float_maps_of_both_orders_and_colors_are_read() {
    let values: Vec<f32> = (0..6).map(|i| i as f32 - 0.5).collect();
    let rgb = |i: usize| [values[3 * i], values[3 * i + 1], values[3 * i + 2]];
    for (header, bytes) in
        [("PF\n2 1\n-1.0\n", f32::to_le_bytes as fn(f32) -> [u8; 4]), ("PF 2 1 1\n", f32::to_be_bytes)]
    {
        let (map, report) = read(&pfm(header, &values, bytes));
        assert_eq!(map.pixels(), [rgb(0), rgb(1)], "{header:?}");
        assert_eq!((report.format, report.negative, report.notes.len()), (FileFormat::Pfm, 1, 0), "{header:?}");
    }
    let (gray, _) = read(&pfm("Pf\n4 2\n-1\n", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0], f32::to_le_bytes));
    assert_eq!(gray.pixel(1, 0), [6.0, 6.0, 6.0], "the first row of the file is the lowest");
    assert_eq!(gray.pixel(3, 1), [4.0, 4.0, 4.0], "gray");
}

#[test]
fn the_scale_of_a_portable_float_map_is_a_factor_and_noted() {
    let (map, report) = read(&pfm("PF\n2 1\n-2.5\n", &[1.0; 7], f32::to_le_bytes));
    assert_eq!(map.pixel(0, 0), [2.5, 2.5, 2.5], "multiplied");
    assert!(report.notes[0].contains("2.5") && report.notes[1].contains("4 bytes"), "{:?}", report.notes);
}

#[test]
fn png_and_jpeg_are_decoded_from_srgb() {
    let linear = |c: f64| if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
    // With tolerances: rounding for PNG, the loss at the default quality for JPEG.
    let cases: [(&str, Vec<u8>, FileFormat, f64); 5] = [
        ("8 bits", ldr(|p| p, ImageFormat::Png), FileFormat::Png, 1e-7),
        ("8 bits and alpha", ldr(|p| p.to_rgba8().into(), ImageFormat::Png), FileFormat::Png, 1e-7),
        ("16 bits", ldr(|p| p.to_rgb16().into(), ImageFormat::Png), FileFormat::Png, 1e-7),
        ("16 bits and alpha", ldr(|p| p.to_rgba16().into(), ImageFormat::Png), FileFormat::Png, 1e-7),
        ("JPEG", ldr(|p| p, ImageFormat::Jpeg), FileFormat::Jpeg, 0.12),
    ];
    for (what, bytes, format, tolerance) in cases {
        let (map, report) = read(&bytes);
        assert_eq!((report.format, map.width(), map.height()), (format, 16, 8), "{what}");
        assert!(
            report.notes[0].contains("sRGB") && report.notes[0].contains("white is 1"),
            "{what}: {:?}",
            report.notes
        );
        assert_eq!(report.notes.len(), 1 + usize::from(what.contains("alpha")), "{what}: {:?}", report.notes);
        for (x, y) in [(0, 0), (15, 0), (0, 7), (9, 4)] {
            let expected = [17 * x, 36 * y, 128].map(|c| linear(c as f64 / 255.0));
            let found = map.pixel(x, y).map(f64::from);
            let error = (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f64::max);
            assert!(error < tolerance, "{what} at ({x}, {y}): {found:?} against {expected:?}");
        }
    }
}

#[test]
fn photographs_are_turned_as_the_camera_noted() {
    for orientation in 1..=8 {
        let (width, height) = if orientation > 4 { (8, 16) } else { (16, 8) };
        let stored = image::RgbImage::from_fn(width, height, |x, y| image::Rgb([15 * x as u8, 15 * y as u8, 128]));
        let mut upright = DynamicImage::ImageRgb8(stored);
        let mut jpeg = Cursor::new(Vec::new());
        upright.write_to(&mut jpeg, ImageFormat::Jpeg).unwrap();
        // Exif behind the first marker: one entry, tag 0x112, a short.
        let mut bytes = jpeg.into_inner();
        let mut exif = b"\xff\xe1\0\x22Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01".to_vec();
        exif.extend([0, orientation, 0, 0, 0, 0, 0, 0]);
        bytes.splice(2..2, exif);
        let (map, report) = read(&bytes);
        assert_eq!(report.notes.len(), 1 + usize::from(orientation > 1), "{orientation}: {:?}", report.notes);
        upright.apply_orientation(Orientation::from_exif(orientation).unwrap());
        let upright = upright.to_rgb8();
        assert_eq!((map.width(), map.height()), (16, 8), "orientation {orientation}");
        for (x, y) in [(0, 0), (15, 0), (0, 7), (15, 7), (9, 2)] {
            let linear = |c: u8| (f64::from(c) / 255.0).powf(2.2);
            let expected = upright.get_pixel(x, y).0.map(linear);
            let found = map.pixel(x as usize, y as usize).map(f64::from);
            let error = (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f64::max);
            assert!(error < 0.12, "orientation {orientation} at ({x}, {y}): {found:?} against {expected:?}");
        }
    }
}

#[test]
fn gray_pictures_are_read() {
    for (what, bytes) in [
        ("8 bits", ldr(|p| p.to_luma8().into(), ImageFormat::Png)),
        ("16 bits", ldr(|p| p.to_luma16().into(), ImageFormat::Png)),
        ("alpha", ldr(|p| p.to_luma_alpha8().into(), ImageFormat::Png)),
        ("JPEG", ldr(|p| p.to_luma8().into(), ImageFormat::Jpeg)),
    ] {
        let (map, _) = read(&bytes);
        let texel = map.pixel(12, 6);
        assert!(texel[0] == texel[1] && texel[1] == texel[2] && texel[1] > 0.1, "{what}: {texel:?}");
        assert!(map.pixel(0, 0)[0] < texel[0], "{what}: dark at the top left");
    }
}

#[test]
fn pictures_of_any_shape_are_read_when_asked_for() {
    let picture = image::RgbImage::from_fn(3, 5, |x, y| image::Rgb([255 * u8::from(x == 2 && y == 1), 0, 255]));
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::ImageRgb8(picture).write_to(&mut bytes, ImageFormat::Png).unwrap();
    let (picture, report) = read_picture_bytes(&bytes.into_inner(), "test", &PictureReadOptions::default()).unwrap();
    assert_eq!((picture.width(), picture.height(), report.levels), (3, 5, 1), "size");
    assert_eq!((picture.pixel(2, 1), picture.pixel(1, 1)), ([1.0, 0.0, 1.0], [0.0, 0.0, 1.0]), "texels in rows");
}
