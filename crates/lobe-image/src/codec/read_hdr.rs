//! Radiance (.hdr) decoder: the header is read by `hdr_header`, rows are decoded by `rgbe`.

use std::io::Read;

use crate::codec::lookahead::Lookahead;
use crate::codec::rgbe::{self, RowError};
use crate::error::ImageError;
use crate::header::decoded::{Decoded, PictureHead, check_size, invalid, io, reserve};
use crate::header::hdr_header::{Colors, HdrHeader, WHITE_EFFICACY, damaged};
use crate::header::orientation::Orientation;
use crate::picture::primaries::{Matrix, Primaries, transformed};
use crate::pixel::Pixel;

/// The longest header: a thousand commands that made the picture, line by line.
const MOST_HEADER: usize = 1 << 20;

/// The fault of a file whose line ends were converted, and with them the bytes of texels that look like line ends.
const SENT_AS_TEXT: &str =
    "the file seems to have been sent or saved as text, with line ends of CRLF; take the original";

/// Decodes a Radiance picture; `name` stands for the file in messages.
pub(crate) fn decode(bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
    let (mut rows, head) = HdrRows::open(bytes, bytes.len() as u64, name, max_texels)?;
    let mut texels: Vec<Pixel> = reserve(head.width * head.height, name)?;
    rows.next_rows_into(rows.height, &mut texels)?;
    if !rows.are_upright() {
        texels = rows.orientation.upright(&texels, [head.width, head.height], name)?;
    }
    Ok(Decoded { head, texels })
}

/// A Radiance picture whose header is read and whose rows are to come as they are stored.
pub(crate) struct HdrRows<R> {
    bytes: Lookahead<R>,
    name: String,
    /// Rows as they are stored.
    height: usize,
    orientation: Orientation,
    /// The row that comes next.
    next_row: usize,
    /// From stored values to radiance.
    factors: Pixel,
    /// From colors in XYZ to those of Radiance; none where these are stored.
    from_xyz: Option<Matrix>,
    steps: Box<[f32; 256]>,
    row: Vec<[u8; 4]>,
    /// Whether lines end with CRLF, as Windows has it.
    has_crlf: bool,
}

impl<R: Read> HdrRows<R> {
    /// The rows of a source of `length` bytes, and what its header says.
    pub(crate) fn open(
        source: R,
        length: u64,
        name: &str,
        max_texels: usize,
    ) -> Result<(Self, PictureHead), ImageError> {
        let mut bytes = Lookahead::new(source);
        let header = bytes.parse(|rest, has_ended| {
            let length = rest.len();
            let header = HdrHeader::parse(rest, name);
            // A header is whole if anything follows.
            if !has_ended && rest.is_empty() && length >= MOST_HEADER {
                return Some(Err(damaged(name, &format!("its header does not end within {MOST_HEADER} bytes"))));
            }
            (has_ended || !rest.is_empty()).then_some(header)
        });
        let cut_off = || invalid(name, "the file ends early: the header is not all there".into());
        let header = header.map_err(|source| io(name, source))?.ok_or_else(cut_off)??;
        let (width, height) = check_size(header.columns, header.rows, max_texels, name)?;
        let (least, there) = (least_bytes(width, height), length.saturating_sub(bytes.position()));
        let orientation = header.orientation;
        let [upright_width, upright_height] = orientation.upright_size([width, height]);
        if there < least {
            let message = format!(
                "the file ends early: {upright_width} x {upright_height} texels need {least} bytes at the least, \
                 {there} are there"
            );
            return Err(invalid(name, message));
        }
        let mut head = PictureHead::new(upright_width, upright_height);
        let factors = header.tell(name, &mut head)?;
        let from_xyz = (header.colors == Colors::Xyz)
            .then(|| Primaries::RADIANCE.of_xyz().map(|row| row.map(|number| number / WHITE_EFFICACY)));
        let mut row = reserve(width, name)?;
        row.resize(width, [0; 4]);
        let (steps, has_crlf, name) = (Box::new(rgbe::steps()), header.has_crlf, name.to_owned());
        Ok((Self { bytes, name, height, orientation, next_row: 0, factors, from_xyz, steps, row, has_crlf }, head))
    }

    /// Whether rows come from the top, and their texels from the left.
    pub(crate) fn are_upright(&self) -> bool {
        self.orientation == Orientation::UPRIGHT
    }

    /// The row that comes next.
    pub(crate) fn next_row(&self) -> usize {
        self.next_row
    }

    /// Adds the next `count` rows, or all that are left, to `texels`.
    pub(crate) fn next_rows_into(&mut self, count: usize, texels: &mut Vec<Pixel>) -> Result<(), ImageError> {
        let Self { bytes, name, height, next_row, factors, from_xyz, steps, row, has_crlf, .. } = self;
        let ends = || invalid(name, "the file ends early: rows of the picture are missing".into());
        for _ in 0..count.min(*height - *next_row) {
            let read = bytes.parse(|rest, has_ended| match rgbe::read_row(rest, row) {
                Err(RowError::Ends) if !has_ended => None,
                read => Some(read),
            });
            let read = read.map_err(|source| io(name, source))?.ok_or_else(ends)?;
            read.map_err(|error| match error {
                _ if *has_crlf => damaged(name, SENT_AS_TEXT),
                RowError::Ends => ends(),
                RowError::Damaged(what) => damaged(name, &what),
            })?;
            texels.extend(row.iter().map(|texel| {
                let [r, g, b] = rgbe::decode(*texel, steps);
                let color = [r * factors[0], g * factors[1], b * factors[2]];
                from_xyz.map_or(color, |matrix| transformed(&matrix, color.map(f64::from)).map(|c| c as f32))
            }));
            *next_row += 1;
        }
        // Each texel byte that was converted is one byte more.
        if *has_crlf && next_row == height && !bytes.is_at_end().map_err(|source| io(name, source))? {
            return Err(damaged(name, SENT_AS_TEXT));
        }
        Ok(())
    }
}

/// The least number of bytes of a picture.
///
/// The densest rows are those of the old encoding: one texel of four bytes, then one repeat count for each digit of
/// `width - 1` in base 256, four bytes each.
fn least_bytes(width: usize, height: usize) -> u64 {
    let digits = (width - 1).checked_ilog(256).map_or(0, |digits| u64::from(digits) + 1);
    4 * (1 + digits) * height as u64
}
