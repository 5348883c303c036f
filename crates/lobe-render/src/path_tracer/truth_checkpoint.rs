//! Checkpoints of traced pictures: the finished pixels on disk, so that tracing can be stopped, killed and continued.

use std::path::Path;

use lobe_io::{Fingerprint, IoError, RecordFile, RecordFormat, RecordLayout, Shard};
use lobe_sh::Rgb;

use crate::error::RenderError;

/// Checkpoints of traced pictures among those of Lobe.
const FORMAT: RecordFormat = RecordFormat {
    kind: *b"PICT",
    version: 1,
    work: "picture",
    arguments: "the scene, the light, the view or the options",
};

/// Bytes of a pixel: 14 numbers (f32, little-endian).
pub(crate) const PIXEL: usize = 4 * 14;

/// The channels of a traced pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TracedPixel {
    pub(crate) mean: Rgb<f32>,
    pub(crate) variance: Rgb<f32>,
    pub(crate) albedo: Rgb<f32>,
    pub(crate) normal: Rgb<f32>,
    pub(crate) depth: f32,
    pub(crate) coverage: f32,
}

impl TracedPixel {
    fn to_numbers(self) -> [f32; 14] {
        let Self { mean: m, variance: v, albedo: a, normal: n, depth, coverage } = self;
        [m.r, m.g, m.b, v.r, v.g, v.b, a.r, a.g, a.b, n.r, n.g, n.b, depth, coverage]
    }

    fn from_numbers(x: [f32; 14]) -> Self {
        let [mean, variance, albedo, normal] = [0, 3, 6, 9].map(|k| Rgb::new(x[k], x[k + 1], x[k + 2]));
        Self { mean, variance, albedo, normal, depth: x[12], coverage: x[13] }
    }
}

/// The pixels of a picture, or of a shard of it, that are done, a record for each: its numbers in the order of
/// [`TracedPixel::to_numbers`].
pub(crate) struct TruthCheckpoint {
    file: RecordFile,
    /// The first pixel of the shard.
    first: usize,
}

impl TruthCheckpoint {
    /// Opens the checkpoint of a picture, or makes one; also returns the pixels in it.
    pub(crate) fn open(
        path: &Path,
        fingerprint: &Fingerprint,
        pixels: usize,
        shard: Option<Shard>,
    ) -> Result<(Self, Vec<TracedPixel>), RenderError> {
        let layout = RecordLayout { count: pixels, bytes: PIXEL, last: PIXEL };
        let mut found = Vec::new();
        let take_up = |record: &[u8]| {
            let numbers = record.as_chunks::<4>().0;
            found.push(TracedPixel::from_numbers(std::array::from_fn(|k| f32::from_le_bytes(numbers[k]))));
        };
        let file = RecordFile::open(path, &FORMAT, layout, fingerprint, shard, take_up)?;
        Ok((Self { file, first: shard.unwrap_or(Shard::WHOLE).range(pixels).start }, found))
    }

    /// Keeps the pixels that are not in the file yet. If there will be no other time, waits until they are on the disk.
    pub(crate) fn keep(&mut self, done: &[TracedPixel], is_last: bool) -> Result<(), RenderError> {
        let Self { file, first } = self;
        let mut push = || -> Result<(), IoError> {
            for pixel in &done[file.done() - *first..] {
                // Room for the checksum, too.
                let mut record = Vec::with_capacity(PIXEL + 8);
                record.extend(pixel.to_numbers().into_iter().flat_map(f32::to_le_bytes));
                file.push(record)?;
            }
            if is_last { file.sync() } else { Ok(()) }
        };
        Ok(push()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(range: std::ops::Range<usize>) -> Vec<TracedPixel> {
        range.map(|i| TracedPixel::from_numbers(std::array::from_fn(|k| (14 * i + k) as f32))).collect()
    }

    fn numbers(pixels: &[TracedPixel]) -> Vec<[f32; 14]> {
        pixels.iter().copied().map(TracedPixel::to_numbers).collect()
    }

    #[test]
    fn a_picture_goes_on_from_the_pixels_that_were_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p");
        let key = Fingerprint::of_kind(99);
        let all = pixels(0..10);
        for (from, to) in [(0, 3), (3, 3), (3, 7), (7, 10)] {
            let (mut checkpoint, found) = TruthCheckpoint::open(&path, &key, 10, None).unwrap();
            assert_eq!(numbers(&found), numbers(&all[..from]), "pixels that were kept");
            checkpoint.keep(&all[..to], to == 10).unwrap();
        }
        let (_, found) = TruthCheckpoint::open(&path, &key, 10, None).unwrap();
        assert_eq!(numbers(&found), numbers(&all), "all pixels");
    }

    #[test]
    fn checkpoints_of_other_pictures_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p");
        TruthCheckpoint::open(&path, &Fingerprint::of_kind(99), 10, None).unwrap();
        let other = TruthCheckpoint::open(&path, &Fingerprint::of_kind(98), 10, None);
        let refusal = other.map(drop).unwrap_err().to_string();
        assert!(refusal.contains("is of another picture: the scene, the light, the view or the options"), "{refusal}");
    }
}
