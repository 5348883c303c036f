//! Small OpenEXR files, written with the `exr` library.

use std::io::Cursor;

use exr::meta::attribute::Chromaticities;
use exr::prelude::*;

/// A channel for [`exr_file`]: a name and one number for each texel of the data window.
pub(crate) struct Plane {
    pub(crate) name: &'static str,
    pub(crate) sample_type: SampleType,
    pub(crate) values: Vec<f32>,
}

/// A part for [`exr_file`].
pub(crate) struct Part {
    pub(crate) name: &'static str,
    pub(crate) encoding: Encoding,
    /// Position and size of the data window.
    pub(crate) position: (i32, i32),
    pub(crate) size: (usize, usize),
    pub(crate) planes: Vec<Plane>,
}

pub(crate) const SCAN_LINES: Encoding =
    Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };

/// The value of a test picture: smooth, different in every channel, within the range of `half`.
pub(crate) fn value(channel: usize, x: usize, y: usize) -> f32 {
    f16::from_f32(0.25 + channel as f32 + 0.125 * x as f32 + (0.5 * y as f32).sin().abs()).to_f32()
}

/// The channels of these names with [`value`]s of the first, second and third.
pub(crate) fn planes(names: &[&'static str], sample_type: SampleType, (w, h): (usize, usize)) -> Vec<Plane> {
    let plane = |(c, name): (usize, &&'static str)| Plane {
        name,
        sample_type,
        values: (0..w * h).map(|i| value(c, i % w, i / w)).collect(),
    };
    names.iter().enumerate().map(plane).collect()
}

/// A part that fills a picture of `size`, with channels R, G, B in `half`.
pub(crate) fn rgb_part(size: (usize, usize)) -> Part {
    let planes = planes(&["R", "G", "B"], SampleType::F16, size);
    Part { name: "color", encoding: SCAN_LINES, position: (0, 0), size, planes }
}

/// The file with these parts and a display window of `display` at the origin.
pub(crate) fn exr_file(display: (usize, usize), parts: Vec<Part>) -> Vec<u8> {
    let layers: Vec<_> = parts
        .into_iter()
        .map(|part| {
            let channels = part.planes.into_iter().map(|p| AnyChannel::new(p.name, samples(p.sample_type, &p.values)));
            let attributes = LayerAttributes::named(part.name).with_position(Vec2(part.position.0, part.position.1));
            Layer::new(part.size, attributes, part.encoding, AnyChannels::sort(channels.collect()))
        })
        .collect();
    let window = IntegerBounds::from_dimensions(display);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layers(ImageAttributes::new(window), layers).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// The file of one part with the whole display window as data window.
pub(crate) fn exr_picture(size: (usize, usize), encoding: Encoding, planes: Vec<Plane>) -> Vec<u8> {
    exr_file(size, vec![Part { name: "color", encoding, position: (0, 0), size, planes }])
}

/// A picture with channels R, G, B whose part has further attributes.
pub(crate) fn exr_with_attributes(size: (usize, usize), change: impl FnOnce(&mut LayerAttributes)) -> Vec<u8> {
    let mut attributes = LayerAttributes::named("color");
    change(&mut attributes);
    let planes = planes(&["R", "G", "B"], SampleType::F16, size).into_iter();
    let channels = planes.map(|plane| AnyChannel::new(plane.name, samples(plane.sample_type, &plane.values)));
    let layer = Layer::new(size, attributes, SCAN_LINES, AnyChannels::sort(channels.collect()));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// A picture of 6 x 3 texels that declares the places of red, green, blue and white in the chromaticity diagram.
pub(crate) fn exr_with_chromaticities([red, green, blue, white]: [[f32; 2]; 4]) -> Vec<u8> {
    let part = rgb_part((6, 3));
    let channels = part.planes.into_iter().map(|p| AnyChannel::new(p.name, samples(p.sample_type, &p.values)));
    let layer =
        Layer::new(part.size, LayerAttributes::named(part.name), part.encoding, AnyChannels::sort(channels.collect()));
    let mut attributes = ImageAttributes::new(IntegerBounds::from_dimensions(part.size));
    let point = |[x, y]: [f32; 2]| Vec2(x, y);
    let chromaticities =
        Chromaticities { red: point(red), green: point(green), blue: point(blue), white: point(white) };
    attributes.chromaticities = Some(chromaticities);
    let mut bytes = Cursor::new(Vec::new());
    Image::new(attributes, layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// A tiled file with all mip levels; the smaller ones are black.
pub(crate) fn exr_with_mip_levels((w, h): (usize, usize)) -> Vec<u8> {
    let mip = |plane: &Plane| {
        let mut level_data = vec![samples(plane.sample_type, &plane.values)];
        let (mut w, mut h) = (w, h);
        while w.max(h) > 1 {
            (w, h) = ((w / 2).max(1), (h / 2).max(1));
            level_data.push(FlatSamples::F16(vec![f16::ZERO; w * h]));
        }
        Levels::Mip { rounding_mode: exr::math::RoundingMode::Down, level_data }
    };
    let planes = planes(&["R", "G", "B"], SampleType::F16, (w, h));
    let channels = AnyChannels::sort(planes.iter().map(|p| AnyChannel::new(p.name, mip(p))).collect());
    let encoding = Encoding { blocks: Blocks::Tiles(Vec2(8, 8)), ..SCAN_LINES };
    let mut bytes = Cursor::new(Vec::new());
    Image::from_encoded_channels((w, h), encoding, channels).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

fn samples(sample_type: SampleType, values: &[f32]) -> FlatSamples {
    match sample_type {
        SampleType::F16 => FlatSamples::F16(values.iter().map(|v| f16::from_f32(*v)).collect()),
        SampleType::F32 => FlatSamples::F32(values.to_vec()),
        SampleType::U32 => FlatSamples::U32(values.iter().map(|v| *v as u32).collect()),
    }
}

/// Overwrites a window (`dataWindow` or `displayWindow`) in the header of a file: first and last column and row.
pub(crate) fn patch_window(bytes: &mut [u8], name: &str, [x0, y0, x1, y1]: [i32; 4]) {
    let key = format!("{name}\0box2i\0");
    let at = bytes.windows(key.len()).position(|w| w == key.as_bytes()).unwrap() + key.len() + 4;
    for (k, v) in [x0, y0, x1, y1].iter().enumerate() {
        bytes[at + 4 * k..][..4].copy_from_slice(&v.to_le_bytes());
    }
}
