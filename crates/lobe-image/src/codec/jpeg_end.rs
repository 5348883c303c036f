//! The end of a JPEG picture, and whether all before it is there.
//!
//! The decoder takes zeros for the bits that a scan lacks, and a picture that is cut off comes out gray where it ends. So it
//! is given the picture with other bits behind the last scan: ones. No Huffman code is all ones (ITU-T T.81, C.2), so a
//! decoder that needs them finds no code and says so, while one that has read every block never gets to them.

/// More bytes of ones than a decoder looks ahead, or takes for the longest code with its longest number.
const BEHIND: usize = 16;

const START_OF_SCAN: u8 = 0xda;
const END: u8 = 0xd9;

/// The picture with ones behind its last scan and nothing behind its end, such as the second picture of a camera;
/// `None` where it has no end. Pictures within a picture, such as a thumbnail, have ends of their own, which do not count.
pub(crate) fn with_ones_behind(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut picture = bytes[..end(bytes)?].to_vec();
    picture.extend([0xff, 0].repeat(BEHIND));
    picture.extend([0xff, END]);
    Some(picture)
}

/// Where the mark of the end stands, from segment to segment.
fn end(bytes: &[u8]) -> Option<usize> {
    // Behind the mark of the beginning.
    let mut at = 2;
    loop {
        let [0xff, mark] = *bytes.get(at..at + 2)? else { return None };
        match mark {
            END => return Some(at),
            // A mark may be preceded by any number of these.
            0xff => at += 1,
            // Marks without a segment.
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

/// The bytes of a scan: up to a mark other than those of restarts. A byte of ones in the data is followed by a zero.
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
