//! Writes two pictures and the mean of two halves of a reference beside each other, as a display shows them in its
//! exposure: the figures of docs/guide/src/baking.md, which `cargo xtask bakes --pictures` asks for.
//!
//! `cargo run -p lobe-image --example beside_each_other -- BEFORE.exr AFTER.exr HALF.exr HALF.exr OUT.ppm`

use std::error::Error;
use std::path::Path;

use lobe_image::{Picture, PictureReadOptions, Sheet, Tone, read_picture};

/// Columns of each picture.
const WIDTH: usize = 400;

fn main() -> Result<(), Box<dyn Error>> {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let [before, after, a, b, out] = &names[..] else {
        return Err("usage: beside_each_other BEFORE AFTER HALF HALF OUT.ppm".into());
    };
    let read =
        |name: &String| read_picture(Path::new(name), &PictureReadOptions::default()).map(|(picture, _)| picture);
    let ([before, after], [a, b]) = ([read(before)?, read(after)?], [read(a)?, read(b)?]);
    let mean = |(a, b): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]));
    let paths = a.pixels().iter().zip(b.pixels()).map(mean).collect();
    let paths = Picture::new(a.width(), a.height(), paths)?;
    let tone = Tone::PHOTOGRAPH.fixed_for(&paths);
    let small = [before, after, paths].map(|p| p.resized(WIDTH, p.height() * WIDTH / p.width()));
    let sheet = Sheet { columns: 3, margin: 2, background: [1e3; 3] }.compose(&small);
    let head = format!("P6\n{} {}\n255\n", sheet.width(), sheet.height());
    std::fs::write(out, [head.into_bytes(), tone.to_bytes(&sheet)].concat())?;
    Ok(())
}
