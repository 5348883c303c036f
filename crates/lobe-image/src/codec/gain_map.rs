//! Gain maps: a second, smaller picture in a JPEG that says how much brighter each texel was.
//!
//! ```text
//!   G = min + (max - min) g^(1/γ)                 g: the second picture, between its texels bilinear, in [0, 1]
//!   L = (B + base offset) 2^G - other offset      B: light of the first picture, white is 1
//! ```
//!
//! That is the light of a display bright enough for all of it ([ISO 2025], [Google 2023]: weight 1). The numbers stand in the second
//! picture: as a binary block by ISO 21496-1, as XMP of the namespace `hdrgm` (Ultra HDR), or both, which agree.

use roxmltree::{Document, Node};

use crate::codec::jpeg_end;
use crate::header::xmp;
use crate::pixel::Pixel;

/// The name of a segment with the numbers of ISO 21496-1, with the zero behind it.
const ISO: &[u8] = b"urn:iso:std:iso:ts:21496:-1\0";

/// The name of a segment with a packet of XMP, with the zero behind it.
const XMP: &[u8] = b"http://ns.adobe.com/xap/1.0/\0";

/// The namespace of the properties of Ultra HDR.
const HDRGM: &str = "http://ns.adobe.com/hdr-gain-map/1.0/";

/// What is in the XMP of a gain map of Apple, whose numbers stand in a note of the camera's maker.
const APPLE: &[u8] = b"HDRGainMap:";

/// The offsets of Ultra HDR where a file has none [Google 2023].
const OFFSET: f64 = 1.0 / 64.0;

/// The most stops that are believed: 2^32 is brighter than the sun beside a white wall.
const MOST_STOPS: f64 = 32.0;

/// The start of a JPEG: its mark and that of its first segment.
const START: [u8; 3] = [0xff, 0xd8, 0xff];

/// The flag of ISO 21496-1 for numbers of three channels.
const THREE_CHANNELS: u8 = 1 << 7;

/// The flag of gains in the colors of the first picture.
const IN_BASE_COLORS: u8 = 1 << 6;

/// The flag of fractions that have one denominator.
const ONE_DENOMINATOR: u8 = 1 << 3;

/// The numbers of a gain map, by channels.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GainMap {
    /// Stops where the second picture is black, and where it is white.
    min: [f64; 3],
    max: [f64; 3],
    gamma: [f64; 3],
    base_offset: [f64; 3],
    other_offset: [f64; 3],
    /// Whether the first picture is the bright one already.
    is_base_bright: bool,
    /// Whether the gains are in the colors of the first picture, rather than of the profile of the second.
    pub(crate) is_in_base_colors: bool,
}

/// What a file says of a gain map.
#[derive(Debug, PartialEq)]
pub(crate) enum Found<'a> {
    Nothing,
    /// The numbers, and the second picture.
    Map(GainMap, &'a [u8]),
    /// A note: there is one, and why it is not used.
    Unusable(&'static str),
}

/// Looks for the gain map of a JPEG file among the pictures behind the first.
pub(crate) fn find(bytes: &[u8]) -> Found<'_> {
    for picture in pictures_behind(bytes) {
        let (mut iso, mut xmp) = (None, None);
        for segment in segments(picture) {
            iso = iso.or(segment.strip_prefix(ISO));
            xmp = xmp.or(segment.strip_prefix(XMP));
        }
        if let Some(iso) = iso {
            return of_iso(iso)
                .map_or(Found::Unusable("its numbers by ISO 21496-1 are damaged"), |map| map.of(picture));
        }
        if let Some(found) = xmp.and_then(of_xmp) {
            return found.map_or(Found::Unusable("its numbers in XMP are damaged"), |map| map.of(picture));
        }
        if xmp.is_some_and(|packet| contains(packet, APPLE)) {
            return Found::Unusable("it is Apple's, without the numbers of ISO 21496-1");
        }
    }
    let announced = segments(bytes).any(|segment| segment.starts_with(ISO) || contains(segment, HDRGM.as_bytes()));
    if announced { Found::Unusable("the file announces it and does not have it") } else { Found::Nothing }
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|window| window == part)
}

/// The JPEG pictures that follow the first one, one after another; each slice ends with the file.
fn pictures_behind(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = jpeg_end::behind(bytes);
    std::iter::from_fn(move || {
        let behind = rest?;
        let picture = &behind[behind.windows(START.len()).position(|window| window == START)?..];
        // Nothing is looked for behind a picture without an end.
        rest = jpeg_end::behind(picture);
        Some(picture)
    })
}

/// The contents of the segments before the scan of a JPEG.
fn segments(picture: &[u8]) -> impl Iterator<Item = &[u8]> {
    const START_OF_SCAN: u8 = 0xda;
    let mut at = 2;
    std::iter::from_fn(move || {
        // A marker may be preceded by any number of bytes of ones.
        while picture.get(at..at + 2)? == [0xff, 0xff] {
            at += 1;
        }
        let [0xff, mark, high, low] = *picture.get(at..at + 4)? else { return None };
        let length = usize::from(u16::from_be_bytes([high, low]));
        let segment = picture.get(at + 4..at + 2 + length)?;
        at += 2 + length;
        (mark != START_OF_SCAN).then_some(segment)
    })
}

/// The numbers of ISO 21496-1: versions, flags, headrooms of both pictures, then of each channel the least and the greatest gain, gamma and both
/// offsets; each is a fraction, of which the denominator may be one for all.
fn of_iso(block: &[u8]) -> Option<GainMap> {
    let &[0, 0, _, _, flags, ref rest @ ..] = block else { return None };
    let mut words = rest.as_chunks::<4>().0.iter().map(|word| u32::from_be_bytes(*word));
    let common = if flags & ONE_DENOMINATOR != 0 { Some(words.next()?) } else { None };
    let mut number = |is_signed: bool| {
        let numerator = words.next()?;
        let numerator = if is_signed { f64::from(numerator.cast_signed()) } else { f64::from(numerator) };
        let denominator = common.or_else(|| words.next())?;
        (denominator != 0).then(|| numerator / f64::from(denominator))
    };
    let (base, other) = (number(false)?, number(false)?);
    let mut channel = || Some([number(true)?, number(true)?, number(false)?, number(true)?, number(true)?]);
    let first = channel()?;
    let channels = if flags & THREE_CHANNELS != 0 { [first, channel()?, channel()?] } else { [first; 3] };
    let [min, max, gamma, base_offset, other_offset] = [0, 1, 2, 3, 4].map(|k| channels.map(|numbers| numbers[k]));
    let is_in_base_colors = flags & IN_BASE_COLORS != 0;
    GainMap { min, max, gamma, base_offset, other_offset, is_base_bright: base > other, is_in_base_colors }.checked()
}

/// The numbers of Ultra HDR in a packet of XMP; none without them, and none within where they are damaged.
fn of_xmp(packet: &[u8]) -> Option<Option<GainMap>> {
    if !contains(packet, HDRGM.as_bytes()) || !contains(packet, b"GainMapMax") {
        return None;
    }
    Some(xmp::with_document(packet, of_properties).flatten())
}

fn of_properties(document: &Document<'_>) -> Option<GainMap> {
    let channels = |name: &str, default: Option<f64>| match property(document, name).as_slice() {
        [] => default.map(|number| [number; 3]),
        [one] => Some([one.parse().ok()?; 3]),
        [red, green, blue] => Some([red.parse().ok()?, green.parse().ok()?, blue.parse().ok()?]),
        _ => None,
    };
    GainMap {
        min: channels("GainMapMin", Some(0.0))?,
        max: channels("GainMapMax", None)?,
        gamma: channels("Gamma", Some(1.0))?,
        base_offset: channels("OffsetSDR", Some(OFFSET))?,
        other_offset: channels("OffsetHDR", Some(OFFSET))?,
        is_base_bright: property(document, "BaseRenditionIsHDR").iter().any(|text| text.eq_ignore_ascii_case("true")),
        is_in_base_colors: true,
    }
    .checked()
}

/// The value of a property, an attribute or an element, or its values, a list in an element.
fn property(document: &Document<'_>, name: &str) -> Vec<String> {
    let texts = |element: Node<'_, '_>| -> Vec<String> {
        let items = element.descendants().filter(|node| node.tag_name().name() == "li");
        let items: Vec<_> = items.filter_map(|item| item.text()).map(|text| text.trim().to_owned()).collect();
        if items.is_empty() { element.text().into_iter().map(|text| text.trim().to_owned()).collect() } else { items }
    };
    document
        .descendants()
        .find_map(|element| {
            let attribute = element.attribute((HDRGM, name)).map(|value| vec![value.trim().to_owned()]);
            attribute.or_else(|| element.has_tag_name((HDRGM, name)).then(|| texts(element)))
        })
        .unwrap_or_default()
}

impl GainMap {
    /// These numbers if light can be computed by them.
    fn checked(self) -> Option<Self> {
        let is_stops = |stops: &f64| stops.abs() <= MOST_STOPS;
        let is_whole = self.min.iter().chain(&self.max).all(is_stops)
            && self.gamma.iter().all(|gamma| gamma.is_finite() && *gamma > 0.0)
            && self.base_offset.iter().chain(&self.other_offset).all(|offset| offset.is_finite());
        is_whole.then_some(self)
    }

    fn of(self, picture: &[u8]) -> Found<'_> {
        if self.is_base_bright {
            return Found::Unusable("the picture itself is the bright one");
        }
        Found::Map(self, picture)
    }

    /// The most stops by which a texel is brighter.
    pub(crate) fn stops(&self) -> f64 {
        self.max.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Makes the light of a picture that of a display bright enough for all of it. `gain` is the second picture, its values in [0, 1].
    pub(crate) fn apply(&self, texels: &mut [Pixel], size: [usize; 2], gain: &[Pixel], gain_size: [usize; 2]) {
        let columns: Vec<_> = (0..size[0]).map(|x| neighbors(x, size[0], gain_size[0])).collect();
        for (y, row) in texels.chunks_exact_mut(size[0]).enumerate() {
            let (above, below, down) = neighbors(y, size[1], gain_size[1]);
            let at = |x: usize, y: usize| gain[y * gain_size[0] + x];
            for (texel, &(left, right, along)) in row.iter_mut().zip(&columns) {
                let corners = [at(left, above), at(right, above), at(left, below), at(right, below)];
                let weights = [(1.0 - along) * (1.0 - down), along * (1.0 - down), (1.0 - along) * down, along * down];
                for c in 0..3 {
                    let value: f64 = corners.iter().zip(weights).map(|(corner, w)| w * f64::from(corner[c])).sum();
                    texel[c] = self.light(f64::from(texel[c]), value, c) as f32;
                }
            }
        }
    }

    /// The light of a channel from that of the first picture and the value of the second; never below zero.
    fn light(&self, base: f64, value: f64, channel: usize) -> f64 {
        let c = channel;
        let stops = self.min[c] + (self.max[c] - self.min[c]) * value.powf(1.0 / self.gamma[c]);
        ((base + self.base_offset[c]) * stops.exp2() - self.other_offset[c]).max(0.0)
    }
}

/// The texels of `few` on both sides of the center of texel `at` of `many`, and the weight of the second.
fn neighbors(at: usize, many: usize, few: usize) -> (usize, usize, f64) {
    let place = ((at as f64 + 0.5) * few as f64 / many as f64 - 0.5).clamp(0.0, (few - 1) as f64);
    let first = place as usize;
    (first, (first + 1).min(few - 1), place - first as f64)
}
