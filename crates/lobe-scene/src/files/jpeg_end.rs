//! The end of a JPEG picture, which shows whether all of it is there.
//!
//! The decoder takes zeros for bits that are missing, so a picture that was cut off ends in gray. With ones behind the last scan it
//! does not: no Huffman code is all ones (ITU-T T.81, C.2), so that a decoder that gets there finds no code, and only one that has
//! decoded every block before does not get there. `lobe-image` reads photographs of light in the same way; neither crate uses the
//! other.

/// Bytes of ones: more than a decoder looks ahead, and more than the longest code with the longest number behind it.
const BEHIND: usize = 16;

const START_OF_SCAN: u8 = 0xda;
const END: u8 = 0xd9;

/// The picture with ones behind its last scan, and without what follows it in the file; `None` where no end is marked.
pub(crate) fn with_ones_behind(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut picture = bytes[..end(bytes)?].to_vec();
    // A byte of ones in a scan is followed by a zero.
    picture.extend([0xff, 0].repeat(BEHIND));
    picture.extend([0xff, END]);
    Some(picture)
}

/// Where the mark of the end is. It is found from segment to segment, because pictures within, such as a thumbnail, have their own.
fn end(bytes: &[u8]) -> Option<usize> {
    // Behind the mark of the start.
    let mut at = 2;
    loop {
        // Some programs leave a byte or more between segments.
        at += bytes.get(at..)?.iter().position(|byte| *byte == 0xff)?;
        let mark = *bytes.get(at + 1)?;
        match mark {
            END => return Some(at),
            // Any number of these may stand before a mark.
            0xff => at += 1,
            // Marks without a segment.
            0x01 | 0xd0..=0xd8 => at += 2,
            _ => {
                let length = usize::from(u16::from_be_bytes([*bytes.get(at + 2)?, *bytes.get(at + 3)?]));
                // The length counts its own two bytes.
                if length < 2 {
                    return None;
                }
                at += 2 + length;
                if mark == START_OF_SCAN {
                    at += scan_length(bytes.get(at..)?)?;
                }
            }
        }
    }
}

/// The length of a scan: up to a mark, unless it restarts the decoder or is a byte of ones in the data.
fn scan_length(bytes: &[u8]) -> Option<usize> {
    bytes.windows(2).position(|pair| pair[0] == 0xff && !matches!(pair[1], 0 | 0xff | 0xd0..=0xd7))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_is_that_of_the_picture_and_not_of_one_within_or_behind_it() {
        let thumbnail = [0xff, 0xe1, 0, 6, 0xff, 0xd8, 0xff, END];
        let scan = [0xff, START_OF_SCAN, 0, 2, 1, 0xff, 0, 0xff, 0xd3, 7];
        let whole = [&[0xff, 0xd8], &thumbnail[..], &scan, &[0xff, 0xff, END], &[0xff, 0xd8, 0xff, END]].concat();
        assert_eq!(end(&whole), Some(2 + 8 + 10 + 1), "behind the scan and one byte of filling");
        for length in 0..whole.len() - 4 {
            assert_eq!(end(&whole[..length]), None, "cut to {length} bytes");
        }
    }
}
