//! The rules of KTX File Format 2.0 and of Khronos Data Format 1.3 for a cube map, from their texts alone: none of the
//! code that writes or reads such files is used.

/// The properties of a format by those texts.
pub(crate) struct Rules {
    pub(crate) vk_format: u32,
    pub(crate) type_size: u32,
    /// Columns and rows of a block, and its bytes.
    pub(crate) block: (u32, u32),
    /// `KHR_DF_MODEL_RGBSDA` is 1, `KHR_DF_MODEL_BC6H` 133.
    pub(crate) model: u8,
    /// First bit, bits, channel with qualifiers, lower and upper value.
    pub(crate) samples: Vec<(u16, u8, u8, u32, u32)>,
}

/// Qualifiers of a channel.
const FLOAT: u8 = 0x80;
const SIGNED: u8 = 0x40;
const EXPONENT: u8 = 0x20;

/// -1 and 1 as `f32`.
const MINUS_ONE: u32 = 0xbf80_0000;
const ONE: u32 = 0x3f80_0000;

/// `KHR_DF_CHANNEL_RGBSDA_ALPHA`; red, green and blue are 0, 1 and 2.
const ALPHA: u8 = 15;

/// Four channels of floating-point numbers of `bits`.
fn rgba(vk_format: u32, bits: u8) -> Rules {
    let channels = [0, 1, 2, ALPHA].into_iter().enumerate();
    let sample = |(i, c): (usize, u8)| (i as u16 * u16::from(bits), bits, c | FLOAT | SIGNED, MINUS_ONE, ONE);
    let bytes = u32::from(bits) / 8;
    Rules { vk_format, type_size: bytes, block: (1, 4 * bytes), model: 1, samples: channels.map(sample).collect() }
}

/// The rules of a format by its name in Lobe.
pub(crate) fn rules(format: &str) -> Rules {
    match format {
        "RGBA16F" => rgba(97, 16),
        "RGBA32F" => rgba(109, 32),
        // Each color has nine bits of mantissa and shares an exponent of five: bias 15, 31 at most. 8448 is the
        // mantissa, of 511 at most, that stands for 1 with the exponent 15 in the example of the text.
        "RGB9E5" => Rules {
            vk_format: 123,
            type_size: 4,
            block: (1, 4),
            model: 1,
            samples: (0..3_u8)
                .flat_map(|c| [(9 * u16::from(c), 9, c, 0, 8448), (27, 5, c | EXPONENT, 15, 31)])
                .collect(),
        },
        "R11G11B10F" => Rules {
            vk_format: 122,
            type_size: 4,
            block: (1, 4),
            model: 1,
            samples: vec![(0, 11, FLOAT, 0, ONE), (11, 11, 1 | FLOAT, 0, ONE), (22, 10, 2 | FLOAT, 0, ONE)],
        },
        "BC6H" => {
            Rules { vk_format: 143, type_size: 1, block: (4, 16), model: 133, samples: vec![(0, 128, FLOAT, 0, ONE)] }
        }
        other => panic!("no rules for {other}"),
    }
}

/// The bytes of a part of a file, read at offsets.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn u8(&self, at: usize) -> u8 {
        self.0[at]
    }

    fn u16(&self, at: usize) -> u16 {
        u16::from_le_bytes([self.0[at], self.0[at + 1]])
    }

    fn u32(&self, at: usize) -> u32 {
        u32::from(self.u16(at)) | u32::from(self.u16(at + 2)) << 16
    }

    fn u64(&self, at: usize) -> usize {
        assert_eq!(self.u32(at + 4), 0, "the number at {at} is beyond 4 GiB");
        self.u32(at) as usize
    }
}

/// The bytes of a level in the file, and when inflated.
pub(crate) struct Level<'a> {
    pub(crate) stored: &'a [u8],
    pub(crate) length: usize,
}

/// Checks every field of a cube map of `levels` levels, and gives its levels, the largest first.
///
/// # Panics
/// If a rule is broken.
pub(crate) fn verify<'a>(file: &'a [u8], format: &Rules, size: u32, levels: u32, zstd: bool) -> Vec<Level<'a>> {
    let bytes = Bytes(file);
    assert_eq!(file[..12], [0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, b'\r', b'\n', 0x1a, b'\n'], "identifier");
    let scheme = if zstd { 2 } else { 0 };
    let expected = [format.vk_format, format.type_size, size, size, 0, 0, 6, levels, scheme];
    let found: Vec<u32> = (0..9).map(|i| bytes.u32(12 + 4 * i)).collect();
    assert_eq!(found, expected, "vkFormat, typeSize, width, height, depth, layers, faces, levels, scheme");
    assert!(levels >= 1 && levels <= size.ilog2() + 1, "{levels} levels of {size}");

    // The parts follow each other: index of levels, data format, keys, no global data, levels.
    let [dfd, dfd_length, kvd, kvd_length] = [48, 52, 56, 60].map(|at| bytes.u32(at) as usize);
    assert_eq!(dfd, 80 + 24 * levels as usize, "the data format follows the index");
    assert_eq!(kvd, dfd + dfd_length, "the keys follow the data format");
    assert!(dfd % 4 == 0 && kvd % 4 == 0, "both begin at multiples of four: {dfd}, {kvd}");
    assert_eq!((bytes.u64(64), bytes.u64(72)), (0, 0), "no global data");
    verify_descriptor(&Bytes(&file[dfd..kvd]), format);
    verify_keys(&file[kvd..kvd + kvd_length]);
    verify_levels(&bytes, format, (size, levels), zstd, kvd + kvd_length)
}

/// The basic data format descriptor, alone in its part.
fn verify_descriptor(dfd: &Bytes<'_>, format: &Rules) {
    let samples = format.samples.len();
    assert_eq!(dfd.u32(0) as usize, dfd.0.len(), "dfdTotalSize");
    assert_eq!(dfd.0.len(), 4 + 24 + 16 * samples, "one block");
    assert_eq!(dfd.u32(4), 0, "vendorId and descriptorType are those of Khronos' basic block");
    assert_eq!((dfd.u16(8), usize::from(dfd.u16(10))), (2, 24 + 16 * samples), "versionNumber, descriptorBlockSize");
    // BT.709 is 1, linear is 1, straight alpha is 0.
    assert_eq!([12, 13, 14, 15].map(|at| dfd.u8(at)), [format.model, 1, 1, 0], "model, primaries, transfer, flags");
    let side = format.block.0 as u8 - 1;
    assert_eq!([16, 17, 18, 19].map(|at| dfd.u8(at)), [side, side, 0, 0], "texelBlockDimension, each less 1");
    // The first edition required 0 here for supercompressed data. That was dropped, since it loses the size of a block,
    // and the validator of Khronos warns of 0 since its version 4.4.
    let planes: Vec<u8> = (20..28).map(|at| dfd.u8(at)).collect();
    assert_eq!(planes, [format.block.1 as u8, 0, 0, 0, 0, 0, 0, 0], "bytesPlane");
    for (i, (offset, bits, channel, lower, upper)) in format.samples.iter().enumerate() {
        let at = 28 + 16 * i;
        let found = (dfd.u16(at), dfd.u8(at + 2) + 1, dfd.u8(at + 3), dfd.u32(at + 8), dfd.u32(at + 12));
        assert_eq!(found, (*offset, *bits, *channel, *lower, *upper), "sample {i}: bit, bits, channel, lower, upper");
        assert_eq!(dfd.u32(at + 4), 0, "sample {i} lies at the first texel");
    }
}

/// Keys in order, each entry with its length before it and zeros up to a multiple of four behind it.
fn verify_keys(mut entries: &[u8]) {
    let mut keys = Vec::new();
    while !entries.is_empty() {
        let length = Bytes(entries).u32(0) as usize;
        let entry = &entries[4..4 + length];
        let end = entry.iter().position(|b| *b == 0).unwrap_or_else(|| panic!("a key without end: {entry:?}"));
        let key = std::str::from_utf8(&entry[..end]).unwrap();
        let value = std::str::from_utf8(&entry[end + 1..]).unwrap();
        // Both values here are texts, which end in a zero.
        assert!(value.len() > 1 && value.find('\0') == Some(value.len() - 1), "{key}: {value:?}");
        assert!(key != "KTXorientation" || value == "rd\0", "{key}: {value:?}");
        keys.push(key);
        let padded = (4 + length).next_multiple_of(4);
        assert!(entries[4 + length..padded].iter().all(|b| *b == 0), "zeros behind {key}");
        entries = &entries[padded..];
    }
    assert_eq!(keys, ["KTXorientation", "KTXwriter"], "keys, in the order of their letters");
}

/// Checks the index against the sizes of the levels; the smallest level lies first, without gaps except for alignment.
fn verify_levels<'a>(
    bytes: &Bytes<'a>,
    format: &Rules,
    (size, levels): (u32, u32),
    zstd: bool,
    mut end: usize,
) -> Vec<Level<'a>> {
    let mut found = Vec::new();
    // lcm(block, 4); all blocks are multiples of four. Supercompressed levels are not aligned.
    let alignment = if zstd { 1 } else { format.block.1 as usize };
    for k in (0..levels).rev() {
        let at = 80 + 24 * k as usize;
        let (offset, stored, length) = (bytes.u64(at), bytes.u64(at + 8), bytes.u64(at + 16));
        let begin = end.next_multiple_of(alignment);
        assert_eq!(offset, begin, "level {k} begins where the one before ends, aligned to {alignment}");
        assert!(bytes.0[end..begin].iter().all(|b| *b == 0), "zeros before level {k}");
        let across = (size >> k).max(1).div_ceil(format.block.0);
        assert_eq!(length, (6 * across * across * format.block.1) as usize, "bytes of level {k}");
        assert!(zstd || stored == length, "level {k} is stored as it is: {stored} of {length}");
        end = offset + stored;
        found.push(Level { stored: &bytes.0[offset..end], length });
    }
    assert_eq!(end, bytes.0.len(), "nothing behind the levels");
    found.reverse();
    found
}
