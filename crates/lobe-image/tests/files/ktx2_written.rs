//! KTX2 files that Lobe writes, checked against the rules of the format.

use lobe_image::TexelFormat;

use crate::cubes::{all_levels, encoded, formats, levels};
use crate::ktx2_rules::{Rules, rules, verify};

#[test]
fn every_field_of_a_written_file_obeys_the_rules() {
    for (format, _) in formats() {
        for zstd in [false, true] {
            for size in [1, 2, 5, 8, 30] {
                for chain in [all_levels(size), levels(&[size])] {
                    let count = chain.len() as u32;
                    let bytes = encoded("a.ktx2", &chain, format, zstd);
                    let rules = rules(&format.to_string());
                    let found = verify(&bytes, &rules, size as u32, count, zstd);
                    for (k, (level, map)) in found.iter().zip(&chain).enumerate() {
                        let data = if zstd { inflated(level.stored) } else { level.stored.to_vec() };
                        assert_eq!(data.len(), level.length, "{format}, zstd {zstd}, size {size}: level {k} inflated");
                        check_texels(&data, format, &rules, map, &format!("{format}, size {size}, level {k}"));
                    }
                }
            }
        }
    }
}

fn inflated(stored: &[u8]) -> Vec<u8> {
    zstd::stream::decode_all(stored).unwrap_or_else(|e| panic!("{e}"))
}

/// The first texel of every face, decoded by hand: faces in order, rows from the top.
fn check_texels(data: &[u8], format: TexelFormat, rules: &Rules, (size, texels): &(usize, Vec<[f32; 3]>), what: &str) {
    let half = |at: usize| {
        let bits = u16::from_le_bytes([data[at], data[at + 1]]);
        (f32::from(bits & 0x3ff) / 1024.0 + 1.0) * (f32::from(bits >> 10) - 15.0).exp2()
    };
    let across = size.div_ceil(rules.block.0 as usize);
    for face in 0..6 {
        let at = face * across * across * rules.block.1 as usize;
        let float = |i: usize| f32::from_le_bytes([data[at + i], data[at + i + 1], data[at + i + 2], data[at + i + 3]]);
        let expected = texels[face * size * size];
        let (found, alpha) = match format {
            TexelFormat::Rgba16F => ([0, 2, 4].map(|i| half(at + i)), half(at + 6)),
            TexelFormat::Rgba32F => ([0, 4, 8].map(float), float(12)),
            TexelFormat::Rgb9e5 => {
                let word = u32::from_le_bytes([data[at], data[at + 1], data[at + 2], data[at + 3]]);
                let scale = ((word >> 27) as f32 - 15.0 - 9.0).exp2();
                ([0, 9, 18].map(|bit| (word >> bit & 0x1ff) as f32 * scale), 1.0)
            }
            // Blocks and packed floats are not decoded by hand.
            _ => (expected, 1.0),
        };
        let limit = 1.0 / 511.0;
        let largest = expected.into_iter().fold(0.0, f32::max);
        let error = found.iter().zip(expected).map(|(a, b)| (a - b).abs() / largest).fold(0.0, f32::max);
        assert!(error <= limit && alpha == 1.0, "{what}, face {face}: {found:?}, {alpha} against {expected:?}");
    }
}
