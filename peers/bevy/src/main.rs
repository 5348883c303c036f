//! Cube maps that `lobe` has written, as the loader of bevy reads them: each texel says where it lies.
//!
//! ```sh
//! cargo run --manifest-path peers/bevy/Cargo.toml -- target/release/lobe
//! ```
//!
//! Prints a line for each file: what the loader took it for, and the largest difference of a texel of the first level. Ends with 1 if
//! a file is not a cube with the right texels, or if a mirrored one is not found out.

use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode};

use bevy_asset::RenderAssetUsages;
use bevy_image::{CompressedImageFormats, Image, ImageSampler, ImageType};
use half::f16;
use wgpu_types::{TextureDataOrder, TextureFormat, TextureViewDimension};

/// Texels along an edge.
const N: usize = 16;

const FACES: [&str; 6] = ["px", "nx", "py", "ny", "pz", "nz"];

/// Files, and the options of `lobe env convert` that write them. The last is mirrored.
const FILES: [(&str, &str); 12] = [
    ("rgba16f.ktx2", "--texels rgba16f"),
    ("rgba16f-mips.ktx2", "--texels rgba16f --mips"),
    ("rgba16f-zstd.ktx2", "--texels rgba16f --mips --zstd"),
    ("rgba32f.ktx2", "--texels rgba32f"),
    ("rgb9e5.ktx2", "--texels rgb9e5"),
    ("bc6h.ktx2", "--texels bc6h"),
    ("rgba16f.dds", "--texels rgba16f"),
    ("rgba16f-mips.dds", "--texels rgba16f --mips"),
    ("rgba32f.dds", "--texels rgba32f"),
    ("rgb9e5.dds", "--texels rgb9e5"),
    ("bc6h.dds", "--texels bc6h"),
    ("mirrored.ktx2", "--texels rgba16f --left-handed"),
];

/// Half of the last digit of RGB9E5, whose numbers of a texel share an exponent: 2^-9 of the largest.
const TOLERANCE: f32 = 1.0 / 512.0;

fn main() -> ExitCode {
    let Some(lobe) = std::env::args_os().nth(1) else {
        eprintln!("usage: lobe-peer-bevy LOBE");
        return ExitCode::from(2);
    };
    let folder = tempfile::tempdir().expect("a folder for files");
    for (face, name) in FACES.iter().enumerate() {
        fs::write(folder.path().join(format!("{name}.pfm")), pfm(face)).expect("a face");
    }
    let mut is_good = true;
    println!("{:<20} result", "file");
    for (name, options) in FILES {
        let result = write(&lobe, folder.path(), name, options).and_then(|()| read(&folder.path().join(name)));
        let is_mirrored = name.starts_with("mirrored");
        let (line, is_right) = match result {
            Ok((format, Some(error))) => (format!("{format:?}, {error:.1e} off"), error <= TOLERANCE),
            Ok((format, None)) => (format!("{format:?}, a cube; blocks are not compared"), true),
            Err(reason) => (reason, false),
        };
        is_good &= is_right != is_mirrored;
        println!("{name:<20} {}{line}", if is_right == is_mirrored { "FAILED: " } else { "" });
    }
    ExitCode::from(u8::from(!is_good))
}

/// 2 (face + 1), 4 (column + 1/2)/N, 4 (row + 1/2)/N.
fn texel(face: usize, x: usize, y: usize) -> [f32; 3] {
    let place = |k: usize| 4.0 * (k as f32 + 0.5) / N as f32;
    [2.0 * (face as f32 + 1.0), place(x), place(y)]
}

/// A face as a .pfm picture, whose rows go upwards.
fn pfm(face: usize) -> Vec<u8> {
    let mut bytes = format!("PF\n{N} {N}\n-1.0\n").into_bytes();
    for y in (0..N).rev() {
        bytes.extend((0..N).flat_map(|x| texel(face, x, y)).flat_map(f32::to_le_bytes));
    }
    bytes
}

fn write(lobe: &OsString, folder: &Path, name: &str, options: &str) -> Result<(), String> {
    let size = N.to_string();
    let mut command = Command::new(Path::new(lobe).canonicalize().map_err(|e| format!("{}: {e}", lobe.display()))?);
    command.args(["--quiet", "env", "convert", "%.pfm", "--size", &size]).args(options.split(' ')).args(["-o", name]);
    let output = command.current_dir(folder).output().map_err(|e| format!("{}: {e}", lobe.display()))?;
    if output.status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&output.stderr).trim().to_owned()) }
}

/// The format of a cube, and the largest difference of its first level relative to 4; none of one in blocks.
fn read(path: &Path) -> Result<(TextureFormat, Option<f32>), String> {
    let bytes = fs::read(path).map_err(|e| e.to_string())?;
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    let formats = CompressedImageFormats::all();
    let (sampler, usage) = (ImageSampler::Default, RenderAssetUsages::default());
    let image = Image::from_buffer(&bytes, ImageType::Extension(ending), formats, false, sampler, usage)
        .map_err(|error| format!("refused: {error}"))?;
    let (descriptor, view) = (&image.texture_descriptor, &image.texture_view_descriptor);
    let dimension = view.as_ref().and_then(|view| view.dimension);
    let (size, levels) = (descriptor.size, descriptor.mip_level_count);
    if dimension != Some(TextureViewDimension::Cube) || size.depth_or_array_layers != 6 {
        return Err(format!("taken for {dimension:?} of {} layers", size.depth_or_array_layers));
    }
    let Some(bytes_of_texel) = descriptor.format.block_copy_size(None).filter(|_| !descriptor.format.is_compressed())
    else {
        return Ok((descriptor.format, None));
    };
    let data = image.data.as_deref().ok_or("no data")?;
    let of_level = |level: u32| (N >> level).max(1).pow(2) * bytes_of_texel as usize;
    let layer: usize = match image.data_order {
        TextureDataOrder::LayerMajor => (0..levels).map(of_level).sum(),
        TextureDataOrder::MipMajor => of_level(0),
    };
    let mut worst = 0.0_f32;
    for face in 0..6 {
        for (k, bytes) in data[face * layer..][..of_level(0)].chunks_exact(bytes_of_texel as usize).enumerate() {
            let found = color(descriptor.format, bytes)?;
            let expected = texel(face, k % N, k / N);
            worst = found.iter().zip(expected).fold(worst, |worst, (a, b)| worst.max((a - b).abs() / 4.0));
        }
    }
    Ok((descriptor.format, Some(worst)))
}

/// The color of a texel.
fn color(format: TextureFormat, bytes: &[u8]) -> Result<[f32; 3], String> {
    match format {
        TextureFormat::Rgba32Float => {
            Ok([0, 4, 8].map(|at| f32::from_le_bytes(bytes[at..at + 4].try_into().expect("four"))))
        }
        TextureFormat::Rgba16Float => Ok([0, 2, 4].map(|at| f16::from_le_bytes([bytes[at], bytes[at + 1]]).to_f32())),
        TextureFormat::Rgb9e5Ufloat => {
            let bits = u32::from_le_bytes(bytes.try_into().expect("four"));
            let scale = 2.0_f32.powi((bits >> 27) as i32 - 15 - 9);
            Ok([0, 9, 18].map(|shift| (bits >> shift & 511) as f32 * scale))
        }
        other => Err(format!("{other:?} is not decoded here")),
    }
}
