//! Pictures that are stored turned or mirrored.

use crate::error::ImageError;
use crate::header::decoded::reserve;
use crate::pixel::Pixel;

/// How a picture is stored, by the numbers 1 to 8 of the tag `Orientation` of Exif (CIPA DC-008, 4.6.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Orientation(u16);

impl Orientation {
    pub(crate) const UPRIGHT: Self = Self(1);

    /// That of a number of the tag; upright where there is none or another.
    pub(crate) fn of_number(number: Option<u16>) -> Self {
        number.filter(|number| (1..=8).contains(number)).map_or(Self::UPRIGHT, Self)
    }

    /// The tag in the first directory of a block of Exif, which is a TIFF file; upright without one.
    pub(crate) fn of_exif(exif: &[u8]) -> Self {
        Self::tag(exif).map(Self).unwrap_or(Self::UPRIGHT)
    }

    /// That of a Radiance picture whose scan lines follow one another along the first axis, and their texels along the
    /// second; none where these are no two axes. `+X` goes right, `+Y` up.
    pub(crate) fn of_axes(first: &str, second: &str) -> Option<Self> {
        Some(Self(match (first, second) {
            ("-Y", "+X") => 1,
            ("-Y", "-X") => 2,
            ("+Y", "-X") => 3,
            ("+Y", "+X") => 4,
            ("+X", "-Y") => 5,
            ("-X", "-Y") => 6,
            ("-X", "+Y") => 7,
            ("+X", "+Y") => 8,
            _ => return None,
        }))
    }

    fn tag(exif: &[u8]) -> Option<u16> {
        let is_big = match exif.first_chunk()? {
            b"II*\0" => false,
            b"MM\0*" => true,
            _ => return None,
        };
        let short = |at: usize| {
            let bytes = *exif.get(at..)?.first_chunk()?;
            Some(if is_big { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) })
        };
        let long = |at: usize| {
            let bytes = *exif.get(at..)?.first_chunk()?;
            Some(if is_big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
        };
        let directory = long(4)? as usize;
        // An entry has its tag, its type (3 is a short), the number of values, and the value.
        let mut entries = (0..short(directory)?).map(|k| directory + 2 + 12 * usize::from(k));
        let entry = entries.find(|at| short(*at) == Some(0x112))?;
        let is_one_short = short(entry + 2)? == 3 && long(entry + 4)? == 1;
        short(entry + 8).filter(|number| is_one_short && (1..=8).contains(number))
    }

    /// Columns and rows of the upright picture; from 5 on the stored one lies on its side.
    pub(crate) fn upright_size(self, [width, height]: [usize; 2]) -> [usize; 2] {
        if self.0 >= 5 { [height, width] } else { [width, height] }
    }

    /// The texels of the upright picture, which has the given size, from those of the stored one.
    pub(crate) fn upright(self, stored: &[Pixel], size: [usize; 2], name: &str) -> Result<Vec<Pixel>, ImageError> {
        let ([width, height], [columns, _]) = (size, self.upright_size(size));
        let (right, bottom) = (width - 1, height - 1);
        // The column and row of a texel in the stored picture.
        let place = |x: usize, y: usize| match self.0 {
            2 => [right - x, y],
            3 => [right - x, bottom - y],
            4 => [x, bottom - y],
            5 => [y, x],
            6 => [y, right - x],
            7 => [bottom - y, right - x],
            8 => [bottom - y, x],
            _ => [x, y],
        };
        let mut texels = reserve(width * height, name)?;
        for y in 0..height {
            texels.extend((0..width).map(|x| {
                let [x, y] = place(x, y);
                stored[y * columns + x]
            }));
        }
        Ok(texels)
    }
}
