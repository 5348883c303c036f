//! OpenEXR pictures of any channels, written and read: transfer, variance, normals.
//!
//! Written in tiles of 64 x 64 texels, which the library compresses.

use std::io::Cursor;

use exr::meta::MetaData;
use exr::meta::header::{Header, LayerAttributes};
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, Encoding, FlatSamples, Image, Layer, LineOrder,
    ReadChannels as _, ReadLayers as _, SmallVec, Text, WritableImage as _, f16,
};

use crate::codec::file_format::FileFormat;
use crate::codec::read::guarded;
use crate::codec::read_exr::{check_table, check_windows};
use crate::error::ImageError;
use crate::header::decoded::{invalid, unsupported};

/// The most bytes that one byte of a file can stand for: PXR24 stores three of four bytes, deflate compresses 1032 : 1.
const MOST_BYTES_PER_BYTE: usize = 2048;

/// One part of an OpenEXR picture, with channels of floats of any meaning.
///
/// ```
/// use lobe_image::{ExrAttribute, ExrLayers};
///
/// let mut layers = ExrLayers::new(3, 2);
/// layers.channel("depth.Z", vec![1.0; 6]);
/// layers.attribute("unit", ExrAttribute::Text("m".to_owned()));
/// let bytes = layers.clone().into_bytes()?;
/// assert_eq!(ExrLayers::from_bytes(&bytes, "depth.exr")?, layers);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExrLayers {
    width: usize,
    height: usize,
    channels: Vec<(String, Vec<f32>)>,
    attributes: Vec<(String, ExrAttribute)>,
}

/// The value of an attribute of [`ExrLayers`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ExrAttribute {
    /// Text.
    Text(String),
    /// An integer.
    Integer(i32),
}

impl ExrLayers {
    /// A picture without channels.
    #[must_use]
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, ..Self::default() }
    }

    /// Adds a channel, `LAYER.NAME`, row by row from the top. The file lists channels by name.
    ///
    /// # Panics
    /// If there are not `width * height` values.
    pub fn channel(&mut self, name: impl Into<String>, values: Vec<f32>) {
        assert_eq!(values.len(), self.width * self.height, "values of a picture of {} x {}", self.width, self.height);
        self.channels.push((name.into(), values));
    }

    /// Adds an attribute.
    pub fn attribute(&mut self, name: impl Into<String>, value: ExrAttribute) {
        self.attributes.push((name.into(), value));
    }

    /// The first part of a file, with its channels of 16-bit and 32-bit floats and its attributes of text and integers.
    /// `name` stands for the file in messages.
    ///
    /// # Errors
    /// [`ImageError::Invalid`] if it is no OpenEXR file, is cut off, or claims more than its bytes can hold,
    /// [`ImageError::Unsupported`] if it is compressed by DWA or HTJ2K.
    pub fn from_bytes(bytes: &[u8], name: &str) -> Result<Self, ImageError> {
        guarded(FileFormat::OpenExr, name, || Self::decode(bytes, name))
    }

    /// The bytes of the numbers of a file in memory, to be asked before [`ExrLayers::from_bytes`]; a small file can hold many that
    /// are alike.
    ///
    /// # Errors
    /// As there.
    pub fn bytes_in_memory(bytes: &[u8], name: &str) -> Result<u64, ImageError> {
        let of_part = |header: &Header| {
            let numbers = header.layer_size.area().saturating_mul(header.channels.list.len());
            (numbers as u64).saturating_mul(size_of::<f32>() as u64)
        };
        let meta = guarded(FileFormat::OpenExr, name, || checked(bytes, name))?;
        Ok(meta.headers.iter().map(of_part).fold(0, u64::saturating_add))
    }

    fn decode(bytes: &[u8], name: &str) -> Result<Self, ImageError> {
        let broken = |error: exr::error::Error| invalid(name, format!("expected an OpenEXR picture: {error}"));
        let meta = checked(bytes, name)?;
        // Blocks compressed by DWA claim sizes of their own, which the library believes.
        let refused = |header: &Header| {
            use Compression::{DWAA, DWAB, HTJ2K32, HTJ2K256};
            matches!(header.compression, DWAA(_) | DWAB(_) | HTJ2K32 | HTJ2K256)
        };
        if meta.headers.iter().any(refused) {
            return Err(unsupported(name, "layers compressed by DWA or HTJ2K are not read; save with ZIP".into()));
        }
        // Decode.
        let read = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
        let image = read.all_attributes().non_parallel().from_buffered(Cursor::new(bytes)).map_err(broken)?;
        // Keep what is made of floats, text and integers.
        let layer = image.layer_data;
        let mut layers = Self::new(layer.size.width(), layer.size.height());
        for AnyChannel { name, sample_data, .. } in layer.channel_data.list {
            let values = match sample_data {
                FlatSamples::F32(values) => values,
                FlatSamples::F16(values) => values.into_iter().map(f16::to_f32).collect(),
                FlatSamples::U32(_) => continue,
            };
            if values.len() == layer.size.area() {
                layers.channel(name.to_string(), values);
            }
        }
        for (name, value) in layer.attributes.other {
            match value {
                AttributeValue::Text(text) => {
                    let text = String::from_utf8_lossy(text.bytes()).into_owned();
                    layers.attribute(name.to_string(), ExrAttribute::Text(text));
                }
                AttributeValue::I32(number) => layers.attribute(name.to_string(), ExrAttribute::Integer(number)),
                _ => {}
            }
        }
        Ok(layers)
    }

    /// The columns and rows of the picture.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// The values of a channel, row by row from the top; none if there is no such channel.
    #[must_use]
    pub fn get(&self, channel: &str) -> Option<&[f32]> {
        self.channels.iter().find(|(name, _)| name == channel).map(|(_, values)| values.as_slice())
    }

    /// The value of an attribute; none if there is no such one, or it is neither text nor an integer.
    #[must_use]
    pub fn get_attribute(&self, name: &str) -> Option<&ExrAttribute> {
        self.attributes.iter().find(|(found, _)| found == name).map(|(_, value)| value)
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// The reason why the format cannot hold the picture.
    pub fn into_bytes(self) -> Result<Vec<u8>, String> {
        let size = (self.width, self.height);
        // Reserve the size of the numbers: a growing vector holds up to three times as much for a while.
        let room = size_of::<f32>() * self.width * self.height * self.channels.len();
        let channels =
            self.channels.into_iter().map(|(name, values)| AnyChannel::new(name.as_str(), FlatSamples::F32(values)));
        let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = channels.collect();
        let mut attributes = LayerAttributes::default();
        for (name, value) in self.attributes {
            let value = match value {
                ExrAttribute::Text(text) => AttributeValue::Text(Text::from_slice_unchecked(text.as_bytes())),
                ExrAttribute::Integer(number) => AttributeValue::I32(number),
            };
            attributes.other.insert(Text::from(name.as_str()), value);
        }
        // Without an order of lines the library would write tiles in the order in which its threads happen to finish.
        let line_order = LineOrder::Increasing;
        let encoding = Encoding { compression: Compression::ZIP16, line_order, ..Encoding::default() };
        let image = Image::from_layer(Layer::new(size, attributes, encoding, AnyChannels::sort(channels)));
        let mut bytes = Cursor::new(Vec::with_capacity(room));
        image.write().to_buffered(&mut bytes).map_err(|error| error.to_string())?;
        Ok(bytes.into_inner())
    }
}

/// The headers of a file, whose claims are checked before anybody allocates what is claimed.
fn checked(bytes: &[u8], name: &str) -> Result<MetaData, ImageError> {
    check_windows(bytes, name)?;
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(|error| invalid(name, format!("expected an OpenEXR picture: {error}")))?;
    let claimed = |header: &Header| header.layer_size.area().saturating_mul(header.channels.bytes_per_pixel);
    let claimed = meta.headers.iter().map(claimed).fold(0, usize::saturating_add);
    if claimed > bytes.len().saturating_mul(MOST_BYTES_PER_BYTE) {
        let message = format!("damaged: a file of {} bytes claims to hold {claimed}", bytes.len());
        return Err(invalid(name, message));
    }
    check_table(&meta.headers, bytes.len() as u64, name)?;
    Ok(meta)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The end of the message that stands for a panic. In files of ZIP the library has none; see `tests/files/malformed.rs` for B44.
    const OF_PANIC: &str = "data is damaged and cannot be decoded";

    #[test]
    fn the_same_layers_are_the_same_bytes() {
        let mut layers = ExrLayers::new(300, 200);
        for name in ["a", "b", "c"] {
            layers.channel(name, (0..60000).map(|i| (i as f32).sin()).collect());
        }
        let first = layers.clone().into_bytes().unwrap();
        for time in 0..20 {
            assert!(layers.clone().into_bytes().unwrap() == first, "time {time}");
        }
    }

    #[test]
    fn files_of_other_kinds_damaged_ones_and_false_claims_are_refused_in_one_line() {
        let mut layers = ExrLayers::new(70, 3);
        layers.channel("a.X", (0..210).map(|i| i as f32).collect());
        let bytes = layers.into_bytes().unwrap();
        let refused = |bytes: &[u8]| ExrLayers::from_bytes(bytes, "a.exr").unwrap_err().to_string();
        for length in (0..bytes.len()).step_by(7) {
            let line = refused(&bytes[..length]);
            assert!(line.starts_with("a.exr: ") && !line.contains('\n'), "cut off after {length}: {line}");
            assert!(!line.ends_with(OF_PANIC), "cut off after {length}: a panic");
        }
        let mut huge = bytes.clone();
        let at = bytes.windows(10).position(|w| w == b"dataWindow").unwrap() + "dataWindow.box2i.....".len();
        huge[at + 8..at + 12].copy_from_slice(&(1_i32 << 26).to_le_bytes());
        let line = refused(&huge);
        assert!(line.contains("claims to hold"), "{line}");
        let line = refused(include_bytes!("../../tests/data/dwaa.exr"));
        assert!(line.contains("compressed by DWA"), "{line}");
    }

    #[test]
    fn what_a_file_takes_in_memory_is_known_before_it_is_decoded() {
        let mut layers = ExrLayers::new(512, 256);
        for name in ["a", "b", "c"] {
            layers.channel(name, vec![1.0; 512 * 256]);
        }
        let bytes = layers.into_bytes().unwrap();
        assert_eq!(ExrLayers::bytes_in_memory(&bytes, "a.exr").unwrap(), 3 * 4 * 512 * 256, "of {} bytes", bytes.len());
        let error = ExrLayers::bytes_in_memory(&bytes[..40], "a.exr").unwrap_err().to_string();
        assert!(error.starts_with("a.exr: "), "{error}");
    }

    #[test]
    fn no_byte_of_a_damaged_file_stops_the_program() {
        let mut layers = ExrLayers::new(9, 3);
        layers.channel("a.X", (0..27).map(|i| i as f32).collect());
        let bytes = layers.into_bytes().unwrap();
        for at in 0..bytes.len() {
            for value in [0, 1, 0x7f, 0xff] {
                let mut damaged = bytes.clone();
                damaged[at] = value;
                if let Err(error) = ExrLayers::from_bytes(&damaged, "a.exr") {
                    let line = error.to_string();
                    assert!(!line.contains('\n') && !line.ends_with(OF_PANIC), "byte {at} is {value}: {line}");
                }
            }
        }
    }
}
