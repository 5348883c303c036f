//! OpenEXR decoder.

use std::collections::{HashMap, HashSet};
use std::io::{Cursor, Read, Seek, SeekFrom};
use std::sync::Arc;

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::reader::{ChunksReader, FilteredChunksReader};
use exr::block::{self, BlockIndex};
use exr::error::Error as ExrError;
use exr::meta::attribute::{AttributeValue, ChannelList, EnvironmentMap, SampleType, Text};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{Compression, Vec2};
use rayon::prelude::*;

use crate::codec::exr_block::{Block, Windows, explain};
use crate::error::ImageError;
use crate::header::decoded::{Decoded, EnvmapAttribute, PictureHead, RowStrip, invalid, io, reserve, unsupported};
use crate::header::exr_unused;
use crate::header::xmp::{self, Panorama};
use crate::picture::png::MAPPING_KEY;
use crate::picture::primaries::Primaries;
use crate::pixel::BLACK;

/// The most texels of the blocks that are decoded at a time, in parallel, but for one block that is larger; as many are held
/// compressed, and again as many decoded. A constant, so that errors do not depend on the number of threads.
const TEXELS_TOGETHER: usize = if cfg!(fuzzing) { 1 << 5 } else { 1 << 19 };

/// The same of blocks that are not compressed, which are only copied: few enough that what is read is still in the
/// cache, and that their memory is used again. The pages of larger batches come new from the system each time, and
/// clearing them takes longer than all else.
const RAW_TEXELS_TOGETHER: usize = if cfg!(fuzzing) { 1 << 4 } else { 1 << 15 };

/// The bit of the version field that says "at least one part is deep".
const DEEP_FLAG: u32 = 0x800;

/// The largest compression ratio. Deflate reaches 1032, and PXR24 stores three of four bytes; runs of PIZ's Huffman
/// code reach 453; RLE 64; B44A 11.
const MOST_BYTES_PER_BYTE: u64 = 2048;

/// The same for DWAA and DWAB: two bytes for an 8 x 8 block of one value in `float`, 256 bytes, before deflate.
const MOST_BYTES_PER_BYTE_DWA: u64 = 1 << 17;

/// A DWA chunk begins with eleven 64-bit numbers: its version, nine sizes, and a choice.
const DWA_SIZES: std::ops::Range<usize> = 1..10;

/// The length within which windows are looked for before the headers are parsed; only crafted files have longer
/// headers.
const HEADERS: usize = 1 << 14;

/// Decodes an OpenEXR picture; `name` stands for the file in messages.
pub(crate) fn decode(bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
    let (mut blocks, head) = ExrBlocks::open(Cursor::new(bytes), bytes.len() as u64, name, max_texels)?;
    let mut decoded = blocks.next_blocks()?;
    let mut texels = reserve(head.width * head.height, name)?;
    while !decoded.is_empty() {
        // A batch of blocks is copied while the next one is decoded.
        let windows = blocks.windows;
        let (next, ()) = rayon::join(|| blocks.next_blocks(), || windows.blit(&decoded, &mut texels));
        decoded = next?;
    }
    texels.resize(head.width * head.height, BLACK);
    Ok(Decoded { head, texels })
}

/// An OpenEXR picture whose headers are read and whose blocks are to come, in the order of the file.
pub(crate) struct ExrBlocks<R> {
    name: String,
    chunks: FilteredChunksReader<R>,
    meta: Arc<MetaData>,
    part: usize,
    /// Places of red, green and blue in the list of channels.
    rgb: [usize; 3],
    windows: Windows,
    /// The positions of blocks that are to come.
    expected: HashSet<(usize, usize)>,
    /// Blocks that are read and not decoded; none before the first.
    read: Option<Vec<Chunk>>,
}

impl<R: Read + Seek + Send> ExrBlocks<R> {
    /// The blocks of a source of `length` bytes, and what its headers say.
    pub(crate) fn open(
        mut source: R,
        length: u64,
        name: &str,
        max_texels: usize,
    ) -> Result<(Self, PictureHead), ImageError> {
        let mut start = Vec::new();
        source.by_ref().take(HEADERS as u64).read_to_end(&mut start).map_err(|e| io(name, e))?;
        source.seek(SeekFrom::Start(0)).map_err(|e| io(name, e))?;
        if let Some(version) = start.get(4..8)
            && u32::from_le_bytes([version[0], version[1], version[2], version[3]]) & DEEP_FLAG != 0
        {
            return Err(unsupported(name, "deep data is not read; flatten the picture".into()));
        }
        check_windows(&start, name)?;
        let reader = block::read(source, false).map_err(|e| explain(e, name))?;
        let headers = reader.headers();
        let (part, channels) = color_part(headers, name)?;
        let windows = Windows::of(&headers[part], max_texels, name)?;
        check_table(headers, length, name)?;
        let head = head(headers, part, &channels, &windows);
        let mut expected = HashSet::new();
        let chunks = reader.filter_chunks(false, |_, _, block| {
            let wanted = windows.want(&block, part);
            if wanted {
                expected.insert((block.pixel_position.0, block.pixel_position.1));
            }
            wanted
        });
        let chunks = chunks.map_err(|e| explain(e, name))?;
        let meta = Arc::new(chunks.meta_data().clone());
        let rgb = channels.rgb;
        Ok((Self { name: name.to_owned(), chunks, meta, part, rgb, windows, expected, read: None }, head))
    }

    /// Whether blocks are whole rows of the data window.
    pub(crate) fn are_rows(&self) -> bool {
        self.meta.headers[self.part].blocks == BlockDescription::ScanLines
    }

    /// The next rows; none at the end. Those outside of the data window, which are black, do not come.
    ///
    /// Panics if blocks are no rows.
    pub(crate) fn next_strips(&mut self) -> Result<Vec<RowStrip>, ImageError> {
        assert!(self.are_rows(), "tiles are no rows");
        let windows = self.windows;
        Ok(self.next_blocks()?.into_iter().map(|block| windows.band(block)).collect())
    }

    /// The next blocks; none at the end. They are decoded while those behind them are read.
    fn next_blocks(&mut self) -> Result<Vec<Block>, ImageError> {
        let read = match self.read.take() {
            Some(read) => read,
            None => self.read_chunks()?,
        };
        let (meta, rgb, name) = (Arc::clone(&self.meta), self.rgb, self.name.clone());
        let (blocks, next) = rayon::join(|| decoded(read, &meta, rgb, &name), || self.read_chunks());
        let blocks = blocks?;
        self.read = Some(next?);
        debug_assert!(!blocks.is_empty() || self.expected.is_empty(), "all that are expected are read, none twice");
        Ok(blocks)
    }

    /// As many blocks as are decoded together, which are checked.
    fn read_chunks(&mut self) -> Result<Vec<Chunk>, ImageError> {
        let Self { name, chunks, meta, part, windows, expected, .. } = self;
        let block = meta.headers[*part].max_block_pixel_size();
        let area = block.0.min(windows.data_size.0).saturating_mul(block.1.min(windows.data_size.1));
        let texels = match meta.headers[*part].compression {
            Compression::Uncompressed => RAW_TEXELS_TOGETHER,
            _ => TEXELS_TOGETHER,
        };
        let together = (texels / area.max(1)).max(1);
        let checked = |chunk: Result<Chunk, ExrError>| {
            let chunk = chunk.map_err(|e| explain(e, name))?;
            check_chunk(&chunk, meta, |block| windows.want(block, *part), expected, name)?;
            Ok(chunk)
        };
        chunks.by_ref().take(together).map(checked).collect()
    }
}

/// The colors of blocks that are read, decoded in parallel; or the error of the first that has one.
fn decoded(read: Vec<Chunk>, meta: &MetaData, rgb: [usize; 3], name: &str) -> Result<Vec<Block>, ImageError> {
    // Together first: of parallel results `rayon` would give the error that happens to come first.
    let blocks: Vec<_> = read.into_par_iter().map(|chunk| Block::decode(chunk, meta, rgb)).collect();
    blocks.into_iter().map(|block| block.map_err(|e| explain(e, name))).collect()
}

/// What the headers say of the picture.
fn head(headers: &[Header], part: usize, channels: &ColorChannels, windows: &Windows) -> PictureHead {
    let header = &headers[part];
    let envmap = header.own_attributes.environment_map.map(|kind| match kind {
        EnvironmentMap::LatitudeLongitude => EnvmapAttribute::LatLong,
        EnvironmentMap::Cube => EnvmapAttribute::Cube,
    });
    let mapping = match header.own_attributes.other.get(&Text::from(MAPPING_KEY)) {
        Some(AttributeValue::Text(text)) => Some(text.to_string()),
        _ => None,
    };
    let chromaticities = header.shared_attributes.chromaticities;
    let primaries = chromaticities.and_then(|c| {
        let point = |p: Vec2<f32>| [p.0, p.1].map(f64::from);
        Some(("the chromaticities", Primaries::new(point(c.red), point(c.green), point(c.blue), point(c.white))?))
    });
    let mut notes = notes(headers, part, channels, windows);
    let panorama = panorama(header, &mut notes);
    let unclear = chromaticities.filter(|_| primaries.is_none()).map(|_| "the attribute chromaticities".to_owned());
    PictureHead {
        notes,
        envmap,
        mapping,
        panorama,
        primaries,
        unclear_primaries: unclear,
        ..PictureHead::new(windows.width, windows.height)
    }
}

/// The properties of a panorama: in a packet of XMP, or each as an attribute, as programs keep them that convert a
/// photograph.
fn panorama(header: &Header, notes: &mut Vec<String>) -> Panorama {
    let mut panorama = Panorama::new();
    for (name, value) in &header.own_attributes.other {
        let (name, value) = (
            name.to_string(),
            match value {
                AttributeValue::Text(text) => text.to_string(),
                AttributeValue::I32(number) => number.to_string(),
                AttributeValue::F32(number) => number.to_string(),
                AttributeValue::F64(number) => number.to_string(),
                _ => continue,
            },
        );
        if let Some(name) = name.strip_prefix("GPano:") {
            xmp::add(name, &value, &mut panorama);
        } else if name.to_ascii_lowercase().ends_with("xmp") {
            xmp::add_packet(value.as_bytes(), &mut panorama, notes);
        }
    }
    panorama
}

/// Refuses windows that end before they begin: the library would swap the ends.
pub(crate) fn check_windows(bytes: &[u8], name: &str) -> Result<(), ImageError> {
    let headers = &bytes[..bytes.len().min(HEADERS)];
    for attribute in ["dataWindow\0box2i\0\x10\0\0\0", "displayWindow\0box2i\0\x10\0\0\0"] {
        let key = attribute.as_bytes();
        for at in (0..headers.len()).filter(|at| headers[*at..].starts_with(key)) {
            let numbers = headers[at + key.len()..].as_chunks::<4>().0.iter().map(|n| i32::from_le_bytes(*n));
            let corners: Vec<i32> = numbers.take(4).collect();
            if let [x0, y0, x1, y1] = corners[..]
                && (x1 < x0 || y1 < y0)
            {
                let what = attribute.split('\0').next().unwrap_or_default();
                let message = format!("the {what} ends before it begins: ({x0}, {y0}) to ({x1}, {y1})");
                return Err(invalid(name, message));
            }
        }
    }
    Ok(())
}

/// Refuses a file shorter than the table of its blocks, before any work for each of them.
pub(crate) fn check_table(headers: &[Header], length: u64, name: &str) -> Result<(), ImageError> {
    let blocks = headers.iter().fold(0_u64, |sum, header| sum.saturating_add(header.chunk_count as u64));
    if blocks.saturating_mul(size_of::<u64>() as u64) > length {
        let message = format!("the file ends early: the table of its {blocks} blocks is not all there");
        return Err(invalid(name, message));
    }
    Ok(())
}

/// The color channels of a part.
struct ColorChannels {
    /// Indices of red, green and blue in the list of channels; three times the same for luminance.
    rgb: [usize; 3],
    /// Their names, for notes.
    names: String,
}

/// The first part that has color, with its channels.
fn color_part(headers: &[Header], name: &str) -> Result<(usize, ColorChannels), ImageError> {
    for (part, header) in headers.iter().enumerate() {
        if let Some(channels) = color_channels(&header.channels) {
            check_channels(header, &channels, name)?;
            return Ok((part, channels));
        }
    }
    let found: Vec<String> =
        headers.iter().flat_map(|h| &h.channels.list).map(|c| c.name.to_string()).take(12).collect();
    let message = format!("channels R, G, B or Y expected (also as layer.R ..), found {}", found.join(", "));
    Err(unsupported(name, message))
}

/// The channels `R`, `G`, `B` of the first layer that has all three, the layer without a name first; or else `Y`.
fn color_channels(channels: &ChannelList) -> Option<ColorChannels> {
    let names: Vec<String> = channels.list.iter().map(|c| c.name.to_string()).collect();
    let rgb = color_places(names.iter().map(String::as_str))?;
    let shown = if rgb[0] == rgb[1] { &rgb[..1] } else { &rgb[..] };
    Some(ColorChannels { rgb, names: shown.iter().map(|i| names[*i].as_str()).collect::<Vec<_>>().join(", ") })
}

/// The channels of a layer that are color, by their places.
#[derive(Default)]
struct Layer {
    /// Whether the layer has a name, and the place of its first channel: the order of layers.
    rank: (bool, usize),
    rgb: [Option<usize>; 3],
    y: Option<usize>,
}

/// The places of red, green and blue among the names of all channels; three times that of luminance. Names are asked for once, as
/// a file can have as many as it has room for (`color_is_found_by_one_look_at_each_channel`).
fn color_places<'a>(names: impl Iterator<Item = &'a str>) -> Option<[usize; 3]> {
    let mut layers: HashMap<&str, Layer> = HashMap::new();
    for (place, name) in names.enumerate() {
        let (layer, channel) = name.split_at(name.rfind('.').map_or(0, |dot| dot + 1));
        let entry = || Layer { rank: (!layer.is_empty(), place), ..Layer::default() };
        let layer = layers.entry(layer).or_insert_with(entry);
        let slot = match channel {
            "R" => &mut layer.rgb[0],
            "G" => &mut layer.rgb[1],
            "B" => &mut layer.rgb[2],
            "Y" => &mut layer.y,
            _ => continue,
        };
        slot.get_or_insert(place);
    }
    let all = |layer: &Layer| Some([layer.rgb[0]?, layer.rgb[1]?, layer.rgb[2]?]);
    let first = |places: &dyn Fn(&Layer) -> Option<[usize; 3]>| {
        let found = layers.values().filter_map(|layer| Some((layer.rank, places(layer)?)));
        found.min().map(|(_, places)| places)
    };
    first(&all).or_else(|| first(&|layer| layer.y.map(|y| [y; 3])))
}

/// Refuses unsupported types and subsampling of the chosen channels.
fn check_channels(header: &Header, channels: &ColorChannels, name: &str) -> Result<(), ImageError> {
    let list = &header.channels.list;
    let has = |suffix: &str| list.iter().any(|c| c.name.to_string().rsplit('.').next() == Some(suffix));
    if channels.rgb[0] == channels.rgb[1] && (has("RY") || has("BY")) {
        return Err(unsupported(name, "luminance-chroma channels (Y, RY, BY) are not read; convert to R, G, B".into()));
    }
    if let Some(c) = channels.rgb.iter().map(|i| &list[*i]).find(|c| c.sample_type == SampleType::U32) {
        return Err(unsupported(name, format!("channel {} holds integers; half or float expected", c.name)));
    }
    if let Some(c) = list.iter().find(|c| c.sampling.0 != 1 || c.sampling.1 != 1) {
        return Err(unsupported(name, format!("channel {} is subsampled; full resolution expected", c.name)));
    }
    if matches!(header.compression, Compression::HTJ2K32 | Compression::HTJ2K256) {
        return Err(unsupported(name, "HTJ2K compression is not read; save with ZIP".into()));
    }
    Ok(())
}

/// Remarks for the caller.
fn notes(headers: &[Header], part: usize, channels: &ColorChannels, windows: &Windows) -> Vec<String> {
    let header = &headers[part];
    let mut notes = Vec::new();
    if headers.len() > 1 {
        let name = header.own_attributes.layer_name.as_ref().map(ToString::to_string).unwrap_or_default();
        notes.push(format!("part {part} ({name:?}) of {} is read", headers.len()));
    }
    if channels.names != "B, G, R" && channels.names != "R, G, B" {
        notes.push(format!("channels {} are read", channels.names));
    }
    let list = &header.channels.list;
    if list.iter().any(|c| c.name.to_string().rsplit('.').next() == Some("A")) {
        notes.push("alpha is ignored".into());
    }
    notes.extend(exr_unused::notes(header, channels.rgb));
    let aspect = header.shared_attributes.pixel_aspect;
    if aspect != 1.0 {
        notes.push(format!("pixelAspectRatio={aspect} of the header is ignored"));
    }
    if !windows.is_data_equal_to_display() {
        let ((x, y), (w, h)) = (windows.offset, windows.data_size);
        notes.push(format!("the data window is {w} x {h} at ({x}, {y}) of the display window; outside it is black"));
    }
    notes
}

/// Checks before decoding that a block is expected, occurs for the first time, and can hold its claimed size.
fn check_chunk(
    chunk: &Chunk,
    meta: &MetaData,
    wanted: impl Fn(&BlockIndex) -> bool,
    expected: &mut HashSet<(usize, usize)>,
    name: &str,
) -> Result<(), ImageError> {
    let header = &meta.headers[chunk.layer_index];
    let (index, stored) = locate(chunk, header).map_err(|e| explain(e, name))?;
    if !wanted(&index) || !expected.remove(&(index.pixel_position.0, index.pixel_position.1)) {
        let message = "the table of blocks is damaged: a block is there twice or in a wrong place";
        return Err(invalid(name, message.into()));
    }
    check_claims(header, &index, stored, name)
}

/// Checks that the claimed size of a block is possible for its bytes; the library allocates what is claimed.
fn check_claims(header: &Header, index: &BlockIndex, stored: &[u8], name: &str) -> Result<(), ImageError> {
    let damaged = |claimed: u64| {
        let message = format!("damaged: a block of {} bytes claims to hold {claimed}", stored.len());
        Err(invalid(name, message))
    };
    let dwa = matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_));
    let ratio = if dwa { MOST_BYTES_PER_BYTE_DWA } else { MOST_BYTES_PER_BYTE };
    let bytes_per_pixel = header.channels.bytes_per_pixel as u64;
    let claimed = (index.pixel_size.area() as u64).saturating_mul(bytes_per_pixel);
    if claimed > (stored.len() as u64).saturating_mul(ratio) {
        return damaged(claimed);
    }
    if dwa && claimed != stored.len() as u64 {
        // No section is longer than twice the samples of whole 8 x 8 blocks: run lengths at their worst.
        let (w, h) = (index.pixel_size.0.next_multiple_of(8), index.pixel_size.1.next_multiple_of(8));
        let limit = 2 * bytes_per_pixel * w as u64 * h as u64;
        let sizes = stored.as_chunks::<8>().0.iter().map(|n| u64::from_le_bytes(*n));
        if let Some(size) = sizes.take(DWA_SIZES.end).skip(DWA_SIZES.start).find(|size| *size > limit) {
            return damaged(size);
        }
    }
    Ok(())
}

/// The position of a chunk, and its bytes.
fn locate<'a>(chunk: &'a Chunk, header: &Header) -> Result<(BlockIndex, &'a [u8]), ExrError> {
    let tile = header.get_block_data_indices(&chunk.compressed_block)?;
    // The library asserts on missing levels.
    if tile.level_index.0 != 0 || tile.level_index.1 != 0 {
        return Err(ExrError::Invalid("a block of a smaller level where the largest belongs".into()));
    }
    let stored = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Err(ExrError::NotSupported("deep data".into())),
    };
    let bounds = header.get_absolute_block_pixel_coordinates(tile)?;
    let index = BlockIndex {
        layer: chunk.layer_index,
        pixel_position: bounds.position.to_usize("block position")?,
        pixel_size: bounds.size,
        level: tile.level_index,
    };
    Ok((index, stored))
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn color_is_found_by_one_look_at_each_channel() {
        let layers = 20_000;
        let mut names: Vec<String> = (0..layers).map(|k| format!("layer{k}.Z")).collect();
        for last in [None, Some(["end.B", "end.G", "end.R"])] {
            names.extend(last.into_iter().flatten().map(str::to_owned));
            let looks = Cell::new(0);
            let counted = names.iter().inspect(|_| looks.set(looks.get() + 1)).map(String::as_str);
            assert_eq!(color_places(counted), last.map(|_| [layers + 2, layers + 1, layers]), "{last:?}");
            assert_eq!(looks.get(), names.len(), "looks at names, of {} channels", names.len());
        }
    }

    #[test]
    fn the_layer_without_a_name_comes_first_and_color_before_luminance() {
        let places = |names: &[&str]| color_places(names.iter().copied());
        assert_eq!(places(&["a.B", "a.G", "a.R", "B", "G", "R"]), Some([5, 4, 3]), "no name first");
        assert_eq!(places(&["b.B", "b.G", "b.R", "a.B", "a.G", "a.R"]), Some([2, 1, 0]), "in the order of the file");
        assert_eq!(places(&["Y", "a.B", "a.G", "a.R"]), Some([3, 2, 1]), "color before luminance");
        assert_eq!(places(&["a.b.Y", "Z", "B", "G"]), Some([0; 3]), "luminance of a layer in a layer");
        assert_eq!(places(&["B", "G", "a.R", "RR"]), None, "no layer has all");
    }
}
