//! Writes every kind of picture that this crate draws into a folder.
//!
//! `cargo run --release -p lobe-render --example figures -- FOLDER`

use std::error::Error;
use std::f64::consts::PI;
use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use lobe_figures::{
    Ball, Balloon, CubeCross, Profile, ProfilePlot, basis_balloons, basis_crosses, lat_long_picture,
    lat_long_picture_of,
};
use lobe_image::{Picture, Sheet, Tone, color_bar, compare, diverging, error_map, sequential};
use lobe_render::View;
use lobe_sh::{Coefficient, Dir, Expansion, Rgb, ShVec, Zonal, project};

const WHITE: Rgb<f32> = Rgb::new(1.0, 1.0, 1.0);
const GRAY: Rgb<f32> = Rgb::new(0.05, 0.05, 0.05);

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("usage: figures FOLDER")?);
    fs::create_dir_all(&folder)?;
    let mut start = Instant::now();
    let mut write = |name: &str, picture: &Picture, tone: &Tone| -> Result<(), Box<dyn Error>> {
        picture.write_png(folder.join(name), tone)?;
        println!("{name:28} {} x {}, {:.2} s", picture.width(), picture.height(), start.elapsed().as_secs_f64());
        start = Instant::now();
        Ok(())
    };

    write("balloons.png", &basis_balloons(4, 150), &Tone::PLAIN)?;
    write("crosses.png", &basis_crosses(4, 48), &Tone::PLAIN)?;

    let lights = axis_lights();
    let scalar = |s: Dir| lights.eval(s).g - lights.eval(s).b;
    write("balloon.png", &Balloon::new(400).picture(scalar), &Tone::PLAIN)?;
    write("cross.png", &CubeCross::new(150).picture(scalar), &Tone::PLAIN)?;

    let balls: Vec<_> = [View::ALONG_X, View::from_eye(Dir::X), View::three_quarter(), View::from_eye(Dir::Z)]
        .map(|view| Ball::new(220).seen(view).lit_by_sh(GRAY, &lights))
        .into();
    let sheet = Sheet { columns: 4, margin: 10, background: GRAY.into() };
    write("balls.png", &sheet.compose(&balls), &Tone::PLAIN)?;

    // The horizon is no polynomial; this degree leaves an error that no picture shows.
    let expansion = project(6, 400, sky);
    let orders: Vec<_> = (1..=6).map(|order| lat_long_picture_of(300, 150, &expansion.resized(order))).collect();
    let exact = lat_long_picture(300, 150, sky);
    let tone = Tone::PHOTOGRAPH.fixed_for(&exact);
    write("sky.png", &exact, &tone)?;
    write("reconstructions.png", &Sheet { columns: 3, ..sheet }.compose(&orders), &tone)?;

    let (image, reference) = (orders[5].clone(), exact);
    let report = compare(image.pixels(), reference.pixels());
    println!("{report:?}");
    write("error.png", &error_map(&image, &reference, report.max_abs)?, &Tone::PLAIN)?;
    write("color_bar.png", &color_bar(300, 40, report.max_abs, GRAY, WHITE), &Tone::PLAIN)?;
    let maps = Picture::from_fn(512, 64, |x, y| {
        let t = (x as f64 + 0.5) / 512.0;
        if y < 32 { sequential(t) } else { diverging(2.0 * t - 1.0) }
    });
    write("colormaps.png", &maps, &Tone::PLAIN)?;

    fs::write(folder.join("clamped_cosine.svg"), clamped_cosine_plot())?;
    Ok(())
}

/// An irradiance with a red light from +x, a green one from +y and a blue one from +z.
fn axis_lights() -> ShVec<Rgb<f64>> {
    let cosine = Zonal::clamped_cosine(9);
    let mut sum = cosine.towards(Dir::X, Rgb::new(PI, 0.0, 0.0));
    sum += &cosine.towards(Dir::Y, Rgb::new(0.0, PI, 0.0));
    sum += &cosine.towards(Dir::Z, Rgb::new(0.0, 0.0, PI));
    sum
}

/// A made-up sky: blue above, brown below, a warm sun towards +x, a little to the right and up.
fn sky(s: Dir) -> Rgb<f64> {
    let base = if s.z() > 0.0 { Rgb::new(0.2, 0.4, 0.9).scale(1.0 - 0.5 * s.z()) } else { Rgb::new(0.2, 0.13, 0.08) };
    let sun = Dir::from_angles(1.2, -0.5);
    base + Rgb::new(9.0, 6.0, 3.0).scale((60.0 * (s.dot(sun) - 1.0)).exp())
}

fn clamped_cosine_plot() -> String {
    let (three, five) = (Zonal::clamped_cosine(3), Zonal::clamped_cosine(5));
    ProfilePlot { width: 520.0, height: 320.0 }.svg(&[
        Profile { label: "max(cos θ, 0)", color: [34, 34, 34], dashed: true, f: &|theta| theta.cos().max(0.0) },
        Profile { label: "order 3", color: [200, 16, 46], dashed: false, f: &|theta| three.eval(theta.cos()) },
        Profile { label: "order 5", color: [31, 79, 209], dashed: false, f: &|theta| five.eval(theta.cos()) },
    ])
}
