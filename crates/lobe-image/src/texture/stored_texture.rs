//! A texture whose headers are read: one picture or the six faces of a cube in each level, where they lie, and the
//! decoder of levels that all containers share.

use std::io::{self, Read};

use crate::error::ImageError;
use crate::header::decoded::{Decoded, PictureHead, check_size, invalid, reserve};
use crate::picture::primaries::Primaries;
use crate::pixel::Pixel;
use crate::texture::cube_texture::{CubeTexture, check_cube_size, mip_level_count, mip_level_size};
use crate::texture::stored_format::StoredFormat;

/// The faces of a cube.
pub(crate) const FACES: usize = 6;

/// The remark on an array that is taken for a cube.
pub(crate) const OF_AN_ARRAY: &str = "an array of 6 squares is taken for the faces +X, -X, +Y, -Y, +Z, -Z of a cube";

/// The remark on texels of bytes.
pub(crate) const OF_BYTES: &str = "white is 1, and whatever was brighter has been cut off";

/// What the headers of a texture say.
#[derive(Clone, Debug)]
pub(crate) struct StoredTexture {
    pub(crate) format: StoredFormat,
    /// Columns and rows of the largest level.
    pub(crate) size: [usize; 2],
    /// Pictures of a level: 6, or 1.
    pub(crate) faces: usize,
    pub(crate) levels: usize,
    /// The number of bytes at a multiple of which rows begin.
    pub(crate) alignment: usize,
    /// Whether the lowest row comes first.
    pub(crate) is_from_bottom: bool,
    pub(crate) notes: Vec<String>,
    pub(crate) mapping: Option<String>,
    pub(crate) primaries: Option<(String, Option<Primaries>)>,
}

impl StoredTexture {
    /// A texture without remarks. Refuses sides and levels that cannot be, before memory is allocated.
    pub(crate) fn new(
        format: StoredFormat,
        [width, height]: [u32; 2],
        faces: usize,
        levels: u32,
        max_texels: usize,
        name: &str,
    ) -> Result<Self, ImageError> {
        if faces == FACES {
            if width != height {
                return Err(invalid(name, format!("the faces of a cube are square, these are {width} x {height}")));
            }
            check_cube_size(width.into(), max_texels, name)?;
        } else {
            check_size(width.into(), height.into(), max_texels, name)?;
        }
        let (size, levels) = ([width as usize, height as usize], levels.max(1) as usize);
        let most = mip_level_count(size[0].max(size[1]));
        if levels > most {
            let what =
                if faces == FACES { format!("a cube map of size {width}") } else { format!("{width} x {height}") };
            return Err(invalid(name, format!("{what} has at most {most} levels, not {levels}")));
        }
        let (notes, mapping, primaries) = (Vec::new(), None, None);
        Ok(Self { format, size, faces, levels, alignment: 1, is_from_bottom: false, notes, mapping, primaries })
    }

    pub(crate) fn is_cube(&self) -> bool {
        self.faces == FACES
    }

    /// Columns and rows of a level.
    pub(crate) fn level_size(&self, level: usize) -> [usize; 2] {
        self.size.map(|side| mip_level_size(side, level))
    }

    /// The bytes of one picture of a level.
    pub(crate) fn picture_bytes(&self, level: usize) -> u64 {
        self.format.picture_bytes(self.level_size(level), self.alignment)
    }

    /// Memory for the texels of a level.
    pub(crate) fn reserved(&self, level: usize, name: &str) -> Result<Vec<Pixel>, ImageError> {
        let [width, height] = self.level_size(level);
        reserve(self.faces * width * height, name)
    }

    /// Reads one picture of a level and appends it to `texels`.
    pub(crate) fn read(&self, level: usize, source: &mut dyn Read, texels: &mut Vec<Pixel>) -> io::Result<()> {
        self.format.read_picture(self.level_size(level), self.alignment, source, texels)
    }

    /// The cube of decoded levels.
    pub(crate) fn cube(self, levels: Vec<Vec<Pixel>>) -> CubeTexture {
        let sizes = (0..levels.len()).map(|k| self.level_size(k)[0]).collect::<Vec<_>>();
        let Self { format, notes, mapping, primaries, .. } = self;
        let levels = sizes.into_iter().zip(levels).collect();
        CubeTexture { format: format.format, levels, notes, mapping, primaries }
    }

    /// The picture of the largest level; that there are others is noted.
    pub(crate) fn picture(self, mut texels: Vec<Pixel>) -> Decoded {
        let [width, height] = self.size;
        if self.is_from_bottom {
            for y in 0..height / 2 {
                let (above, below) = texels.split_at_mut((height - 1 - y) * width);
                above[y * width..][..width].swap_with_slice(&mut below[..width]);
            }
        }
        let mut head = PictureHead::new(width, height);
        head.notes = self.notes;
        head.notes.insert(0, format!("the texels are {}", self.format.format));
        if self.levels > 1 {
            head.notes.push(format!("{} smaller level(s) are left out", self.levels - 1));
        }
        head.mapping = self.mapping;
        match self.primaries {
            Some((_, Some(primaries))) => head.primaries = Some(("the primaries of the texture", primaries)),
            Some((name, None)) => head.unclear_primaries = Some(format!("the primaries {name} of the texture")),
            None => {}
        }
        Decoded { head, texels }
    }
}
