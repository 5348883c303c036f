//! The layout of a file of records, and its header.

use twox_hash::XxHash3_64;

use crate::fingerprint::Fingerprint;
use crate::shard::Shard;

/// The first bytes of every checkpoint.
const MAGIC: [u8; 4] = *b"LOBE";

/// The layout of the header and of the frame of a record.
const VERSION: u32 = 3;

/// Bytes of the header.
pub(crate) const HEADER: usize = 80;

/// Bytes of a checksum.
pub(crate) const SUM: usize = 8;

/// The most bytes of what stands before the header of a shard.
const MAX_PREFACE: u64 = 4096;

/// The kind of work that a checkpoint is of.
#[derive(Clone, Copy, Debug)]
pub struct RecordFormat {
    /// Four letters that tell its files from others.
    pub kind: [u8; 4],
    /// Changes with what a record holds.
    pub version: u32,
    /// What results are called in messages, without an article: `bake`.
    pub work: &'static str,
    /// The arguments that the fingerprint depends on, in messages: `the scene or the options`.
    pub arguments: &'static str,
}

/// How many records there are and how long they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordLayout {
    /// Records in all, at least 1.
    pub count: usize,
    /// Bytes of a record.
    pub bytes: usize,
    /// Bytes of the last record, at most [`RecordLayout::bytes`].
    pub last: usize,
}

impl RecordLayout {
    /// Where the bytes of a record begin in the file of all of them.
    #[must_use]
    pub fn offset(&self, record: usize) -> u64 {
        (HEADER + record * self.framed()) as u64
    }

    pub(crate) fn len(&self, record: usize) -> usize {
        if record + 1 == self.count { self.last } else { self.bytes }
    }

    /// Bytes of a record and its checksum.
    fn framed(&self) -> usize {
        self.bytes + SUM
    }

    /// Bytes of the header and the records of a shard.
    pub(crate) fn bytes_of(&self, shard: Shard) -> u64 {
        let range = shard.range(self.count);
        let short = if range.end == self.count && !range.is_empty() { self.bytes - self.last } else { 0 };
        // What a file says may be any number.
        let records = (range.len() as u64).saturating_mul((self.bytes as u64).saturating_add(SUM as u64));
        records.saturating_add(HEADER as u64).saturating_sub(short as u64)
    }
}

/// What stands before the records of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Header {
    pub(crate) kind: [u8; 4],
    /// Of this layout, and of the kind.
    pub(crate) versions: [u32; 2],
    pub(crate) layout: RecordLayout,
    pub(crate) fingerprint: [u64; 2],
    pub(crate) shard: Shard,
}

impl Header {
    pub(crate) fn new(format: &RecordFormat, layout: RecordLayout, fingerprint: &Fingerprint, shard: Shard) -> Self {
        let versions = [VERSION, format.version];
        Self { kind: format.kind, versions, layout, fingerprint: fingerprint.bits(), shard }
    }

    /// The header at the beginning of some bytes, of this version of the layout. `None` if there is none or it is damaged.
    pub(crate) fn parse(bytes: &[u8]) -> Option<Self> {
        let (bytes, sum) = bytes.get(..HEADER)?.split_last_chunk()?;
        let word = |k: usize| u32::from_le_bytes(bytes[4 * k..][..4].as_array().copied().unwrap_or_default());
        let long = |k: usize| u64::from(word(4 + 2 * k)) | u64::from(word(5 + 2 * k)) << 32;
        let size = |k: usize| usize::try_from(long(k)).ok();
        let header = Self {
            kind: *bytes[4..].first_chunk()?,
            versions: [word(2), word(3)],
            layout: RecordLayout { count: size(0)?, bytes: size(1)?, last: size(2)? },
            fingerprint: [long(3), long(4)],
            shard: Shard::new(u32::try_from(long(5)).ok()?, u32::try_from(long(6)).ok()?)?,
        };
        let is_one = bytes[..4] == MAGIC && header.versions[0] == VERSION && header.layout.last <= header.layout.bytes;
        (is_one && u64::from_le_bytes(*sum) == header.checksum(u64::MAX, bytes)).then_some(header)
    }

    /// Its bytes.
    pub(crate) fn to_bytes(self) -> Vec<u8> {
        let Self { layout, fingerprint: [high, low], shard, .. } = self;
        let mut bytes = [MAGIC, self.kind].concat();
        self.versions.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        let sizes = [layout.count as u64, layout.bytes as u64, layout.last as u64];
        let numbers = [high, low, shard.number().into(), shard.count().into()];
        sizes.iter().chain(&numbers).for_each(|number| bytes.extend(number.to_le_bytes()));
        bytes.extend(self.checksum(u64::MAX, &bytes).to_le_bytes());
        debug_assert_eq!(bytes.len(), HEADER, "bytes of the header");
        bytes
    }

    /// The checksum of a record, or with the number 2⁶⁴ - 1 of the header.
    pub(crate) fn checksum(&self, number: u64, bytes: &[u8]) -> u64 {
        XxHash3_64::oneshot_with_seed(self.fingerprint[0] ^ number, bytes)
    }

    /// What stands before the header of a shard, which makes the file one of safetensors with the single tensor `records`, all of
    /// the rest.
    pub(crate) fn preface(&self, work: &str) -> Vec<u8> {
        let (shard, bytes) = (self.shard, self.layout.bytes_of(self.shard));
        let mut text = format!(
            r#"{{"__metadata__":{{"format":"lobe-shard","version":"1","work":"{work}","shard":"{shard}"}},"records":{{"dtype":"U8","shape":[{bytes}],"data_offsets":[0,{bytes}]}}}}"#
        );
        // The tensor begins at a multiple of eight bytes.
        text.extend(std::iter::repeat_n(' ', (8 - text.len() % 8) % 8));
        [&(text.len() as u64).to_le_bytes(), text.as_bytes()].concat()
    }

    /// Whether these bytes are the preface of this header, for work of any name.
    pub(crate) fn is_preface(&self, bytes: &[u8]) -> bool {
        let text = str::from_utf8(bytes.get(8..).unwrap_or_default()).unwrap_or_default();
        let work = text.split_once(r#""work":""#).and_then(|(_, rest)| rest.split_once('"'));
        work.is_some_and(|(work, _)| self.preface(work) == bytes)
    }
}

/// Where the header is in a file that begins with these bytes.
pub(crate) fn header_at(bytes: &[u8]) -> Option<u64> {
    if bytes.starts_with(&MAGIC) {
        return Some(0);
    }
    let length = u64::from_le_bytes(*bytes.first_chunk()?);
    (length <= MAX_PREFACE).then(|| 8 + length)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAYOUT: RecordLayout = RecordLayout { count: 10, bytes: 12, last: 4 };

    fn header(shard: Shard) -> Header {
        let format = RecordFormat { kind: *b"TEST", version: 5, work: "test", arguments: "the options" };
        Header::new(&format, LAYOUT, &Fingerprint::of_kind(1), shard)
    }

    #[test]
    fn a_header_is_read_as_it_was_written_and_no_damage_is_believed() {
        let shard = Shard::new(2, 3).unwrap();
        let bytes = header(shard).to_bytes();
        assert_eq!(Header::parse(&bytes), Some(header(shard)), "read again");
        for at in 0..bytes.len() {
            let mut bad = bytes.clone();
            bad[at] ^= 1;
            assert_eq!(Header::parse(&bad), None, "with a change at {at}");
            assert_eq!(Header::parse(&bytes[..at]), None, "of {at} bytes");
        }
    }

    // Found by the fuzz target read_checkpoint: the end of the longest preface was no number.
    #[test]
    fn a_preface_of_any_length_ends_before_the_header_or_is_none() {
        for length in [0, 7, MAX_PREFACE, MAX_PREFACE + 1, u64::MAX - 8, u64::MAX - 3, u64::MAX] {
            let expected = (length <= MAX_PREFACE).then_some(length.wrapping_add(8));
            assert_eq!(header_at(&length.to_le_bytes()), expected, "{length}");
        }
    }

    #[test]
    fn the_shards_have_the_bytes_of_all_records() {
        let records = |shard| LAYOUT.bytes_of(shard) - HEADER as u64;
        for count in [1, 2, 3, 7, 10, 11, 25] {
            let sum: u64 = (1..=count).map(|number| records(Shard::new(number, count).unwrap())).sum();
            assert_eq!(sum, 9 * (12 + 8) + 4 + 8, "{count} shards");
        }
    }

    #[test]
    fn a_shard_begins_as_safetensors_do() {
        for shard in ["1/1", "1/2", "10/1000"].map(|text| text.parse::<Shard>().unwrap()) {
            let preface = header(shard).preface("bake");
            assert_eq!(preface.len() % 8, 0, "{shard}");
            assert_eq!(header_at(&preface), Some(preface.len() as u64), "{shard}: behind its length");
            let text = str::from_utf8(&preface[8..]).unwrap();
            assert!(text.contains(&format!(r#""work":"bake","shard":"{shard}""#)), "{text}");
            assert!(header(shard).is_preface(&preface), "{text}");
            for at in 0..preface.len() {
                let mut bad = preface.clone();
                bad[at] ^= 1;
                // The name of the work is of no account.
                let is_name = text.find("bake").is_some_and(|name| (8 + name..8 + name + 4).contains(&at));
                assert_eq!(header(shard).is_preface(&bad), is_name, "with a change at {at}");
            }
        }
    }
}
