//! The decoders of what others compressed inside of a `.glb`, called as lobe-scene calls them: a stream of meshopt, a mesh of Draco, or a
//! picture (WebP, JPEG, KTX2 with Basis Universal).
//!
//! The first byte tells the kind; behind it stand, of meshopt, the mode, the filter, the bytes of an element and the number of elements.
//! It asserts nothing: it is run under the address sanitizer, which ends it where a decoder reads or writes outside of its memory. Panics are
//! caught, as the readers do.
#![no_main]

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};
use libfuzzer_sys::fuzz_target;
use lobe_fuzz::let_decoders_panic;
use meshoptimizer_rs::codec::{Filter, Mode, decode_buffer_view};
use meshoptimizer_rs::{Limits, Workspace};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Texels, triangles or points; small enough that no input takes long, large enough that every path is reached.
const LIMIT: u64 = 1 << 16;

fuzz_target!(init: let_decoders_panic(), |bytes: &[u8]| {
    let decode = || match *bytes {
        [0, mode, filter, stride, count, ref payload @ ..] => meshopt([mode, filter], stride, count, payload),
        [1, ref payload @ ..] => draco(payload),
        [2, ref payload @ ..] => match payload {
            [b'R', ..] => webp(payload),
            [0xab, ..] => ktx2(payload),
            _ => jpeg(payload),
        },
        _ => None,
    };
    let _ = catch_unwind(AssertUnwindSafe(decode));
});

fn meshopt([mode, filter]: [u8; 2], stride: u8, count: u8, payload: &[u8]) -> Option<()> {
    let mode = Mode::parse(["ATTRIBUTES", "TRIANGLES", "INDICES"][usize::from(mode) % 3]).ok()?;
    let filters = ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"];
    let filter = Filter::parse(filters[usize::from(filter) % filters.len()]).ok()?;
    let mut workspace = Workspace::new(Limits { max_bytes: usize::MAX, ..Limits::default() });
    decode_buffer_view(mode, filter, count.into(), stride.into(), payload, &mut workspace).ok().map(|_| ())
}

fn draco(payload: &[u8]) -> Option<()> {
    let limits =
        DecodeLimits::permissive().with_max_faces(LIMIT).with_max_points(LIMIT).with_max_decoded_bytes(LIMIT * 256);
    MeshDecoder::new().decode(&mut DecoderBuffer::new(payload).with_limits(limits), &mut Mesh::new()).ok().map(|_| ())
}

fn webp(payload: &[u8]) -> Option<()> {
    let mut decoder = image_webp::WebPDecoder::new(Cursor::new(payload)).ok()?;
    let (width, height) = decoder.dimensions();
    let mut texels = vec![0; decoder.output_buffer_size().filter(|_| is_small(width, height))?];
    decoder.read_image(&mut texels).ok()
}

fn jpeg(payload: &[u8]) -> Option<()> {
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(payload), DecoderOptions::default());
    decoder.decode_headers().ok()?;
    let (width, height) = decoder.dimensions()?;
    is_small(width as u32, height as u32).then(|| decoder.decode().ok())?.map(|_| ())
}

/// The reader of lobe-scene compares what the header claims before it calls the library.
fn ktx2(payload: &[u8]) -> Option<()> {
    let word = |at: usize| Some(u32::from_le_bytes(*payload.get(at..)?.first_chunk()?));
    let long = |at: usize| Some(u64::from_le_bytes(*payload.get(at..)?.first_chunk()?));
    let is_inside = long(80)?.checked_add(long(88)?).is_some_and(|end| end <= payload.len() as u64);
    if !is_inside || !is_small(word(20)?, word(24)?) || word(32)? > 1 || word(36)? > 1 || long(96)? > LIMIT * 16 {
        return None;
    }
    Transcoder::new(payload).ok()?.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).ok().map(|_| ())
}

fn is_small(width: u32, height: u32) -> bool {
    u64::from(width) * u64::from(height) <= LIMIT
}
