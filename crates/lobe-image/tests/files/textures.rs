//! Textures of other programs: one picture, three channels, version 1 of KTX, and cubes that are told otherwise.

use half::f16;
use lobe_image::{
    CubeTexture, FileFormat, ImageError, Picture, PictureReadOptions, PictureReadReport, PictureWriteOptions,
    TexelFormat, TextureNotes, encode_picture, is_cube_texture_bytes, read_cube_texture_bytes,
    read_texture_picture_bytes, srgb_decode, write_cube_texture,
};

use crate::cubes::{all_levels, colored_faces, encoded, levels};

fn cube(bytes: &[u8]) -> Result<(CubeTexture, PictureReadReport), ImageError> {
    read_cube_texture_bytes(bytes, "test", &PictureReadOptions::default())
}

fn picture(bytes: &[u8]) -> (Picture, PictureReadReport) {
    read_texture_picture_bytes(bytes, "test", &PictureReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// A KTX2 file of one level without a descriptor, which readers do not need: Vulkan's number of the format, columns and
/// rows, layers and faces.
fn ktx2(format: u32, [width, height]: [u32; 2], [layers, faces]: [u32; 2], keys: &[u8], data: &[u8]) -> Vec<u8> {
    let (places, start) = (104_u32, 104 + keys.len() as u64);
    let kvd = if keys.is_empty() { 0 } else { places };
    let words = [format, 1, width, height, 0, layers, faces, 1, 0, 0, 0, kvd, keys.len() as u32];
    let longs = [0, 0, start, data.len() as u64, data.len() as u64];
    let mut bytes = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    bytes.extend(longs.iter().flat_map(|long: &u64| long.to_le_bytes()));
    [&bytes, keys, data].concat()
}

/// A KTX file of one level in either byte order: OpenGL's type and its size, format, internal format, columns and rows,
/// elements and faces, and the pictures of the level.
fn ktx1(is_big: bool, gl: [u32; 4], size: [u32; 2], [elements, faces]: [u32; 2], pictures: &[Vec<u8>]) -> Vec<u8> {
    let word = |word: u32| if is_big { word.to_be_bytes() } else { word.to_le_bytes() };
    let [gl_type, type_size, format, internal] = gl;
    let numbers =
        [0x0403_0201, gl_type, type_size, format, internal, format, size[0], size[1], 0, elements, faces, 1, 0];
    let mut bytes = b"\xabKTX 11\xbb\r\n\x1a\n".to_vec();
    bytes.extend(numbers.into_iter().flat_map(word));
    bytes.extend(word(pictures[0].len() as u32));
    [bytes, pictures.concat()].concat()
}

/// The numbers of a picture, row after row.
fn numbers(texels: &[[f32; 3]]) -> impl Iterator<Item = f32> + '_ {
    texels.as_flattened().iter().copied()
}

#[test]
fn cubes_of_three_channels_are_read() {
    let texels = colored_faces(4);
    let halves: Vec<u8> = numbers(&texels).flat_map(|c| f16::from_f32(c).to_le_bytes()).collect();
    let floats: Vec<u8> = numbers(&texels).flat_map(f32::to_le_bytes).collect();
    for (format, data, texel_format, tolerance) in
        [(90, halves, TexelFormat::Rgb16F, 5e-4), (106, floats, TexelFormat::Rgb32F, 0.0)]
    {
        let (found, report) = cube(&ktx2(format, [4, 4], [0, 6], &[], &data)).unwrap();
        assert_eq!((found.format, report.notes.len()), (texel_format, 1), "{texel_format}: {:?}", report.notes);
        for (a, b) in numbers(&found.levels[0].1).zip(numbers(&texels)) {
            assert!((a / b - 1.0).abs() <= tolerance, "{texel_format}: {a} for {b}");
        }
    }
}

#[test]
fn bytes_are_read_as_light_or_as_srgb_in_any_order() {
    let bytes: Vec<u8> = (0..6 * 9 * 3).map(|i| (i * 37 % 256) as u8).collect();
    for (format, channels, is_bgr, is_srgb) in [
        (23, 3, false, false),
        (29, 3, false, true),
        (30, 3, true, false),
        (36, 3, true, true),
        (37, 4, false, false),
        (43, 4, false, true),
        (44, 4, true, false),
        (50, 4, true, true),
    ] {
        let stored: Vec<u8> = bytes
            .chunks(3)
            .flat_map(|texel| {
                let mut texel = texel.to_vec();
                if is_bgr {
                    texel.reverse();
                }
                texel.resize(channels, 255);
                texel
            })
            .collect();
        let (found, report) = cube(&ktx2(format, [3, 3], [0, 6], &[], &stored)).unwrap();
        for (found, byte) in numbers(&found.levels[0].1).zip(&bytes) {
            let value = f64::from(*byte) / 255.0;
            let expected = if is_srgb { srgb_decode(value) } else { value } as f32;
            assert_eq!(found, expected, "format {format}, byte {byte}");
        }
        assert!(report.notes[1].contains("white is 1"), "format {format}: {:?}", report.notes);
    }
}

#[test]
fn a_texture_of_one_picture_is_read_as_a_picture() {
    let texels: Vec<[f32; 3]> = (0..32).map(|i| [i as f32, 0.5, (i % 8) as f32]).collect();
    let floats: Vec<u8> = numbers(&texels).flat_map(f32::to_le_bytes).collect();
    let key = |value: &[u8]| [&18_u32.to_le_bytes()[..], b"KTXorientation\0", value, b"\0\0\0"].concat();
    for (keys, is_turned) in [(vec![], false), (key(b"rd\0"), false), (key(b"ru\0"), true)] {
        let bytes = ktx2(106, [8, 4], [0, 1], &keys, &floats);
        assert!(!is_cube_texture_bytes(&bytes, "test", &PictureReadOptions::default()).unwrap(), "one picture");
        let (found, report) = picture(&bytes);
        assert_eq!((found.width(), found.height(), report.format), (8, 4, FileFormat::Ktx2), "size");
        for y in 0..4 {
            let row = if is_turned { 3 - y } else { y };
            let expected = &texels[8 * row..][..8];
            assert_eq!(&found.pixels()[8 * y..][..8], expected, "row {y}, from the bottom {is_turned}");
        }
        let error = cube(&bytes).unwrap_err();
        assert!(matches!(&error, ImageError::Unsupported { message, .. } if message.contains("6 faces")), "{error}");
    }
    // A DDS file of one picture, by the code of Direct3D 9 for four floats.
    let mut dds = encoded("a.dds", &levels(&[1]), TexelFormat::Rgba32F, false)[..128].to_vec();
    dds[12..20].copy_from_slice([4_u32, 8].map(u32::to_le_bytes).as_flattened());
    dds[112..116].fill(0);
    dds.extend(texels.iter().flat_map(|[r, g, b]| [*r, *g, *b, 1.0]).flat_map(f32::to_le_bytes));
    let (found, report) = picture(&dds);
    assert_eq!((found.width(), found.height(), found.pixels()), (8, 4, texels.as_slice()), "DDS");
    assert_eq!(report.notes, ["the texels are RGBA32F"], "DDS");
    let error = read_texture_picture_bytes(
        &encoded("a.dds", &levels(&[1]), TexelFormat::Rgba32F, false),
        "test",
        &PictureReadOptions::default(),
    );
    assert!(matches!(error, Err(ImageError::Unsupported { .. })), "a cube is no picture: {error:?}");
}

#[test]
fn cubes_are_found_by_any_header_that_says_so() {
    let chain = levels(&[4]);
    let bytes = encoded("a.dds", &chain, TexelFormat::Rgb9e5, false);
    let expected = cube(&bytes).unwrap().0.levels;
    let patched = |words: &[(usize, u32)]| {
        let mut bytes = bytes.clone();
        words.iter().for_each(|(at, word)| bytes[*at..][..4].copy_from_slice(&word.to_le_bytes()));
        bytes
    };
    // The flag of Direct3D 10 is missing; then that and the flags of Direct3D 9, of an array of six pictures; then only
    // those.
    for (what, words) in [
        ("no flag of Direct3D 10", vec![(136, 0)]),
        ("an array of six", vec![(136, 0), (140, 6)]),
        ("an array of six without flags", vec![(136, 0), (140, 6), (112, 0)]),
        ("six faces counted as six cubes", vec![(140, 6)]),
        ("no flags of Direct3D 9", vec![(112, 0)]),
    ] {
        let (found, report) = cube(&patched(&words)).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_eq!(found.levels, expected, "{what}");
        let noted = report.notes.len() == 2;
        assert_eq!(noted, what != "no flags of Direct3D 9", "{what}: {:?}", report.notes);
    }
    let floats: Vec<u8> = numbers(&chain[0].1).flat_map(f32::to_le_bytes).collect();
    let (found, report) = cube(&ktx2(106, [4, 4], [6, 1], &[], &floats)).unwrap();
    assert!(found.levels == chain && report.notes[1].contains("an array of 6"), "KTX2: {:?}", report.notes);
    for layers in [2, 12] {
        let error = cube(&ktx2(106, [4, 4], [layers, 1], &[], &floats)).unwrap_err().to_string();
        assert!(error.contains(&format!("array of {layers}")), "{error}");
    }
}

#[test]
fn a_ktx_of_version_1_is_read_with_its_levels_as_it_was_written() {
    for size in [1, 2, 5, 8] {
        let chain = all_levels(size);
        let (found, report) = cube(&encoded("a.ktx", &chain, TexelFormat::R11G11B10F, false)).unwrap();
        assert_eq!(report.format, FileFormat::Ktx, "{size}");
        for ((side, found), (_, expected)) in found.levels.iter().zip(&chain) {
            for (a, b) in numbers(found).zip(numbers(expected)) {
                assert!((a / b - 1.0).abs() <= 1.0 / 64.0, "{size}, level {side}: {a} for {b}");
            }
        }
    }
}

#[test]
fn a_ktx_of_version_1_is_read_in_both_byte_orders_with_the_padding_of_its_rows() {
    let texels = colored_faces(3);
    let (float_type, half_type, rgb_format, rgba_format) = (0x1406, 0x140b, 0x1907, 0x1908);
    for is_big in [false, true] {
        let half = |c: f32| if is_big { f16::from_f32(c).to_be_bytes() } else { f16::from_f32(c).to_le_bytes() };
        let float = |c: f32| if is_big { c.to_be_bytes() } else { c.to_le_bytes() };
        // Rows of three texels of three halves have 18 bytes, which are padded to 20.
        let padded = |row: &[[f32; 3]]| [numbers(row).flat_map(half).collect::<Vec<u8>>(), vec![0; 2]].concat();
        let faces = |row: &dyn Fn(&[[f32; 3]]) -> Vec<u8>| -> Vec<Vec<u8>> {
            texels.chunks(9).map(|face| face.chunks(3).flat_map(row).collect()).collect()
        };
        let with_alpha = |row: &[[f32; 3]]| -> Vec<u8> {
            row.iter().flat_map(|[r, g, b]| [*r, *g, *b, 1.0]).flat_map(float).collect()
        };
        let rgb = ktx1(is_big, [half_type, 2, rgb_format, 0x881b], [3, 3], [0, 6], &faces(&padded));
        let rgba = ktx1(is_big, [float_type, 4, rgba_format, 0x8814], [3, 3], [0, 6], &faces(&with_alpha));
        for (what, bytes, format) in [("RGB16F", rgb, TexelFormat::Rgb16F), ("RGBA32F", rgba, TexelFormat::Rgba32F)] {
            let (found, _) = cube(&bytes).unwrap_or_else(|e| panic!("{what}, big {is_big}: {e}"));
            assert_eq!(found.format, format, "{what}, big {is_big}");
            for (a, b) in numbers(&found.levels[0].1).zip(numbers(&texels)) {
                assert!((a / b - 1.0).abs() < 5e-4, "{what}, big {is_big}: {a} for {b}");
            }
            for length in (0..bytes.len()).step_by(7) {
                let error = cube(&bytes[..length]).unwrap_err().to_string();
                assert!(!error.contains('\n') && error.starts_with("test: "), "cut to {length}: {error}");
            }
        }
    }
}

/// A picture of three columns and two rows, or the faces of a cube of three, of RGB in bytes: 9 in a row.
fn odd(is_cube: bool) -> (Vec<Vec<u8>>, [u32; 2]) {
    let (pictures, rows) = if is_cube { (6, 3) } else { (1, 2) };
    let bytes = |k: usize| (0..9 * rows as usize).map(|i| (40 * k + i) as u8).collect();
    ((0..pictures).map(bytes).collect(), [3, rows])
}

#[test]
fn ktx_rows_begin_where_the_bytes_of_the_level_say() {
    const RGB8: [u32; 4] = [0x1401, 1, 0x1907, 0x8051];
    let row_padded = |picture: &Vec<u8>| picture.chunks(9).flat_map(|row| [row, &[7; 3]].concat()).collect::<Vec<u8>>();
    let face_padded = |picture: &Vec<u8>| [picture.as_slice(), &[7; 1]].concat();
    let light = |byte: &u8| (f64::from(*byte) / 255.0) as f32;
    for is_big in [false, true] {
        let (pictures, size) = odd(false);
        let expected: Vec<f32> = pictures.concat().iter().map(light).collect();
        for stored in [pictures[0].clone(), row_padded(&pictures[0])] {
            let (found, _) = picture(&ktx1(is_big, RGB8, size, [0, 1], std::slice::from_ref(&stored)));
            assert_eq!(found.pixels().as_flattened(), expected, "a picture of {} bytes", stored.len());
        }
        let (faces, size) = odd(true);
        let expected: Vec<f32> = faces.concat().iter().map(light).collect();
        let with_size = |size_of_level: u32, pictures: &[Vec<u8>], counts| {
            let mut bytes = ktx1(is_big, RGB8, size, counts, pictures);
            let word = if is_big { size_of_level.to_be_bytes() } else { size_of_level.to_le_bytes() };
            bytes[64..68].copy_from_slice(&word);
            bytes
        };
        let padded: Vec<_> = faces.iter().map(row_padded).collect();
        let of_four: Vec<_> = faces.iter().map(face_padded).collect();
        for (what, bytes) in [
            ("padded rows, a face", with_size(36, &padded, [0, 6])),
            ("padded rows, all faces", with_size(6 * 36, &padded, [1, 6])),
            ("an array, padded", with_size(6 * 36, &padded, [6, 1])),
            ("rows side by side, faces at multiples of four", with_size(27, &of_four, [0, 6])),
            ("an array side by side", with_size(6 * 27, &faces, [6, 1])),
        ] {
            assert_eq!(cube(&bytes).unwrap().0.levels[0].1.as_flattened(), expected, "{what}");
        }
        let line = cube(&with_size(30, &padded, [0, 6])).unwrap_err().to_string();
        assert!(line.contains("level 0: expected 36 bytes for each face, the file says 30"), "{line}");
    }
}

#[test]
fn an_orientation_of_ktx_is_honored_or_refused() {
    const RGB8: [u32; 4] = [0x1401, 1, 0x1907, 0x8051];
    let with = |value: &str, is_cube: bool| {
        let (mut pictures, size) = odd(is_cube);
        pictures.iter_mut().for_each(|picture| picture.resize(picture.len().next_multiple_of(4), 7));
        let mut bytes = ktx1(false, RGB8, size, if is_cube { [0, 6] } else { [0, 1] }, &pictures);
        let mut entry = [b"KTXorientation\0", value.as_bytes(), b"\0"].concat();
        let length = entry.len() as u32;
        entry.resize(entry.len().next_multiple_of(4), 0);
        bytes[60..64].copy_from_slice(&(entry.len() as u32 + 4).to_le_bytes());
        bytes.splice(64..64, [&length.to_le_bytes()[..], &entry].concat());
        bytes
    };
    let first = |value| picture(&with(value, false)).0.pixels()[0][0];
    let (top, bottom) = (0.0, (9.0 / 255.0) as f32);
    for (value, expected) in [("S=r,T=d", top), ("S=r,T=u", bottom), ("S=r,T=d,R=i", top)] {
        assert_eq!(first(value), expected, "{value}");
    }
    assert!(cube(&with("S=r,T=d", true)).is_ok(), "a cube as it is");
    for (value, is_cube) in [("S=l,T=d", false), ("S=l,T=u", false), ("S=r,T=u", true), ("S=l,T=d", true), ("", false)]
    {
        let bytes = with(value, is_cube);
        let read = if is_cube {
            cube(&bytes).map(|_| ())
        } else {
            read_texture_picture_bytes(&bytes, "test", &PictureReadOptions::default()).map(|_| ())
        };
        let Err(ImageError::Unsupported { message, .. }) = &read else { panic!("{value}: {read:?}") };
        assert!(message.contains("orientation \"S=r,T=d\" expected"), "{value}: {message}");
    }
}

#[test]
fn ktx_files_of_other_things_are_refused_by_name() {
    let data = vec![vec![0; 6 * 4 * 4 * 4]];
    let refused = |gl, size, counts| cube(&ktx1(false, gl, size, counts, &data)).unwrap_err().to_string();
    let rgba8 = [0x1401, 1, 0x1908, 0x8058];
    assert!(refused([0, 1, 0, 0x8d64], [4, 4], [0, 6]).contains("internal format 0x8d64"), "ETC");
    assert!(refused(rgba8, [4, 4], [2, 6]).contains("6 face(s) of 2 element(s)"), "an array of cubes");
    assert!(refused(rgba8, [4, 2], [0, 6]).contains("square, these are 4 x 2"), "no squares");
    assert!(refused(rgba8, [100_000, 100_000], [0, 6]).contains("limit"), "too large");
    let line = refused(rgba8, [4096, 4096], [0, 6]);
    assert!(line.contains("level 0: expected 67108864 bytes for each face, the file says 384"), "a promise: {line}");
}

#[test]
fn the_share_of_the_light_that_a_format_loses_is_told() {
    let folder = tempfile::tempdir().unwrap();
    // A sun of a million in one texel of 96 that are 1: the rest has 3 (95) of 1e6 + 2 + 285.
    let mut texels = vec![[1.0_f32; 3]; 96];
    texels[5][0] = 1e6;
    let all = 1e6 + 2.0 + 3.0 * 95.0;
    for (format, largest) in [
        (TexelFormat::Rgba32F, f64::INFINITY),
        (TexelFormat::Rgba16F, 65504.0),
        (TexelFormat::Rgb9e5, 65408.0),
        (TexelFormat::R11G11B10F, 64512.0),
        (TexelFormat::Bc6h, 65504.0),
    ] {
        let expected = f64::max(1e6 - largest, 0.0) / all;
        let report = write_cube_texture(
            folder.path().join("a.dds"),
            &[(4, texels.as_slice())],
            format,
            false,
            &TextureNotes::default(),
        );
        let lost = report.unwrap().lost;
        assert!((lost - expected).abs() < 1e-9, "{format}: {lost} for {expected}");
    }
    for (name, half, largest) in
        [("a.exr", true, 65504.0), ("a.exr", false, 1e6), ("a.hdr", false, 1e6), ("a.pfm", false, 1e6)]
    {
        let options = PictureWriteOptions::default().half(half);
        let (_, report) = encode_picture(name.as_ref(), 12, &texels, &options).unwrap();
        let expected = (1e6 - largest) / all;
        assert!((report.lost - expected).abs() < 1e-9, "{name}, half {half}: {} for {expected}", report.lost);
    }
}
