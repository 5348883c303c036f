//! Detection of truncated JPEG files.
//!
//! The decoder replaces missing bits of a scan by zeros, so a truncated picture ends in gray. To detect this, the last
//! scan is padded with ones. No Huffman code is all ones (ITU-T T.81, C.2): a decoder that reads the padding finds no
//! code and reports an error, while one that has decoded every block never gets there.

/// Bytes of padding: more than a decoder looks ahead, and more than the longest code with its longest number.
const BEHIND: usize = 16;

const START_OF_SCAN: u8 = 0xda;
const END: u8 = 0xd9;

/// The picture with ones after its last scan and without trailing data, such as the second picture of a camera; `None`
/// without an end marker. Markers of embedded pictures, such as a thumbnail, do not count.
pub(crate) fn with_ones_behind(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut picture = bytes[..end(bytes)?].to_vec();
    picture.extend([0xff, 0].repeat(BEHIND));
    picture.extend([0xff, END]);
    Some(picture)
}

/// The bytes behind the end marker of a picture; `None` without one.
pub(crate) fn behind(bytes: &[u8]) -> Option<&[u8]> {
    bytes.get(end(bytes)? + 2..)
}

/// The offset of the end marker, found from segment to segment.
fn end(bytes: &[u8]) -> Option<usize> {
    // Skip the start marker.
    let mut at = 2;
    loop {
        let [0xff, mark] = *bytes.get(at..at + 2)? else { return None };
        match mark {
            END => return Some(at),
            // A marker may be preceded by any number of these.
            0xff => at += 1,
            // Markers without a segment.
            0x01 | 0xd0..=0xd8 => at += 2,
            _ => {
                let length = usize::from(u16::from_be_bytes([*bytes.get(at + 2)?, *bytes.get(at + 3)?]));
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

/// The length of a scan: up to a marker other than a restart. A byte of ones in the data is followed by a zero.
fn scan_length(bytes: &[u8]) -> Option<usize> {
    bytes.windows(2).position(|pair| pair[0] == 0xff && !matches!(pair[1], 0 | 0xff | 0xd0..=0xd7))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_end_of_the_picture_itself_counts() {
        let thumbnail = [0xff, 0xe1, 0, 6, 0xff, 0xd8, 0xff, END];
        let scan = [0xff, START_OF_SCAN, 0, 2, 1, 0xff, 0, 0xff, 0xd3, 7];
        let whole = [&[0xff, 0xd8], &thumbnail[..], &scan, &[0xff, 0xff, END], b"more"].concat();
        assert_eq!(end(&whole), Some(2 + 8 + 10 + 1), "behind the scan and one byte of filling");
        for length in 0..whole.len() - 5 {
            assert_eq!(end(&whole[..length]), None, "cut to {length} bytes");
        }
    }
}
