//! Ends of the headers of portable float maps, as different programs write them.

use lobe_image::{ImageError, PictureReadOptions, read_picture_bytes};
use lobe_testkit::Random;

use crate::read_pictures::pfm;

/// Numbers of a picture of 4 x 2 texels, of which the first begins with the given byte as it is stored.
fn numbers(first_byte: u8, bytes: fn(f32) -> [u8; 4]) -> Vec<f32> {
    let mut random = Random::new(48);
    let mut numbers: Vec<f32> = (0..24).map(|_| (8.0 * random.signed()).exp2() as f32).collect();
    let mut stored = bytes(numbers[0]);
    stored[0] = first_byte;
    numbers[0] =
        if bytes(1.0) == 1.0_f32.to_le_bytes() { f32::from_le_bytes(stored) } else { f32::from_be_bytes(stored) };
    numbers
}

#[test]
fn texels_begin_where_the_length_of_the_file_says_whatever_ends_the_header() {
    let ends = ["\n", "\r\n", "\r", " ", "\t", " \n", "  \r\n", "\n\n", "\r\n\r\n", "\n      \n"];
    for (scale, bytes) in [("-1.0", f32::to_le_bytes as fn(f32) -> [u8; 4]), ("1.0", f32::to_be_bytes)] {
        // Bytes of texels that look like white space, and others.
        for first_byte in [0x0a, 0x0d, 0x20, 0x09, 0x3f, 0x41] {
            let numbers = numbers(first_byte, bytes);
            for end in ends {
                for lines in ["\n", "\r\n", "\r", " "] {
                    let header = format!("PF{lines}4 2{lines}{scale}{end}");
                    let read =
                        read_picture_bytes(&pfm(&header, &numbers, bytes), "a.pfm", &PictureReadOptions::default());
                    let (picture, report) = read.unwrap_or_else(|e| panic!("{header:?}, byte {first_byte:#x}: {e}"));
                    let found = [&picture.pixels()[4..], &picture.pixels()[..4]].concat();
                    assert_eq!(found.as_flattened(), numbers, "{header:?}, first byte {first_byte:#x}");
                    assert!(report.notes.is_empty(), "{header:?}, first byte {first_byte:#x}: {:?}", report.notes);
                }
            }
        }
    }
}

#[test]
fn bytes_behind_the_texels_do_not_move_them() {
    for first_byte in [0x0a, 0x0d, 0x3f] {
        let numbers = numbers(first_byte, f32::to_le_bytes);
        for end in ["\n", "\r\n"] {
            for behind in ["\n", "\r\n", "more"] {
                let header = format!("PF\n4 2\n-1{end}");
                let bytes = [pfm(&header, &numbers, f32::to_le_bytes), behind.into()].concat();
                let (picture, report) = read_picture_bytes(&bytes, "a.pfm", &PictureReadOptions::default()).unwrap();
                let found = [&picture.pixels()[4..], &picture.pixels()[..4]].concat();
                assert_eq!(found.as_flattened(), numbers, "{header:?}, first byte {first_byte:#x}, behind {behind:?}");
                assert!(report.notes[0].contains(&format!("{} bytes", behind.len())), "{header:?}: {:?}", report.notes);
            }
        }
    }
}

#[test]
fn comments_are_passed_and_a_file_that_is_cut_off_is_refused() {
    let header = "PF\n# by hand: 7 8\n4 2 # sides\n-1\n";
    let numbers = numbers(0x0a, f32::to_le_bytes);
    let bytes = pfm(header, &numbers, f32::to_le_bytes);
    let (picture, _) = read_picture_bytes(&bytes, "a.pfm", &PictureReadOptions::default()).unwrap();
    assert_eq!(picture.pixels()[4..].as_flattened(), &numbers[..12], "the lowest row");
    for header in [header, "PF\r\n4 2\r\n-1\r\n"] {
        let bytes = pfm(header, &numbers, f32::to_le_bytes);
        let error = read_picture_bytes(&bytes[..bytes.len() - 1], "a.pfm", &PictureReadOptions::default());
        assert!(matches!(error, Err(ImageError::Invalid { .. })), "{header:?}: {error:?}");
    }
}
