//! Fisheye pictures become maps: their light, their orientation, their circle, and what is refused.

use std::f64::consts::PI;

use lobe_env::{
    CubeMap, CubeMipChain, CubeWriteOptions, EnvError, EnvMap, FisheyeOptions, FisheyeProjection, MapReadOptions,
    MappedMap, Mapping, Padding, PictureWriteOptions, irradiance_at, project_map, read_map, read_map_bytes, write_cube,
    write_env,
};
use lobe_image::{ImageError, encode_picture};
use lobe_sh::{Dir, Expansion as _, Rgb};

/// The side of a square picture, in pixels.
const SIDE: usize = 80;

/// The bytes of a picture.
fn picture(width: usize, height: usize, pixel: impl Fn(usize, usize) -> [f32; 3]) -> Vec<u8> {
    let pixels: Vec<[f32; 3]> = (0..width * height).map(|i| pixel(i % width, i / width)).collect();
    encode_picture("a.exr".as_ref(), width, &pixels, &PictureWriteOptions::default()).unwrap().0
}

fn try_read(bytes: &[u8], options: &MapReadOptions) -> Result<EnvMap, EnvError> {
    read_map_bytes(bytes, "test", options)?.0.into_base().into_env_map()
}

fn read(bytes: &[u8], lens: FisheyeOptions) -> EnvMap {
    try_read(bytes, &MapReadOptions::default().fisheye(lens)).unwrap_or_else(|e| panic!("{lens:?}: {e}"))
}

fn lens(projection: FisheyeProjection, degrees: f64) -> FisheyeOptions {
    FisheyeOptions::default().projection(projection).field_of_view(degrees.to_radians())
}

/// The angle to the axis at the distance `r` from the middle, in radii, as the formulas of the papers have it.
fn theta(projection: FisheyeProjection, half: f64, r: f64) -> f64 {
    match projection {
        FisheyeProjection::Equidistant => r * half,
        FisheyeProjection::Equisolid => 2.0 * (r * (0.5 * half).sin()).asin(),
        FisheyeProjection::Stereographic => 2.0 * (r * (0.5 * half).tan()).atan(),
        FisheyeProjection::Orthographic => (r * half.sin()).asin(),
        other => panic!("{other} has no formula here"),
    }
}

/// The lenses of the tests, with their fields of view in degrees.
fn lenses() -> impl Iterator<Item = (FisheyeProjection, f64)> {
    let narrow = FisheyeProjection::ALL.into_iter().flat_map(|projection| [(projection, 120.0), (projection, 180.0)]);
    let wide = [
        (FisheyeProjection::Equidistant, 360.0),
        (FisheyeProjection::Equisolid, 360.0),
        (FisheyeProjection::Stereographic, 240.0),
    ];
    narrow.chain(wide)
}

#[test]
fn the_light_of_skies_is_that_of_their_closed_forms() {
    // The texels of the map have single precision.
    const CONSTANT: f64 = 1e-5;
    // Pixels show the cosine at their middles: the square of their width, of the radius of 40, and slivers at the rim.
    const COSINE: f64 = 1e-2;
    for (projection, degrees) in lenses() {
        let half = 0.5 * f64::to_radians(degrees);
        let bytes = picture(SIDE, SIDE, |x, y| {
            let at = |i: usize| (2 * i + 1) as f64 / SIDE as f64 - 1.0;
            let r = at(x).hypot(at(y)).min(1.0);
            [1.0, theta(projection, half, r).cos() as f32, 0.0]
        });
        let map = read(&bytes, lens(projection, degrees));
        assert_eq!((map.width(), map.height() % 2), (2 * map.height(), 0), "a horizon between rows");
        let mean = map.mean();
        let (constant, cosine) = (4.0 * PI * mean.r, 4.0 * PI * mean.g);
        let expected = [2.0 * PI * (1.0 - half.cos()), PI * half.sin().powi(2)];
        let error = (constant / expected[0] - 1.0).abs();
        assert!(error < CONSTANT, "{projection} {degrees}: {constant}, not {}", expected[0]);
        let error = (cosine - expected[1]).abs();
        assert!(error < COSINE, "{projection} {degrees}: {cosine}, not {}", expected[1]);
        // E = ∫ cos θ ds of a constant sky, below which there is nothing.
        let irradiance = irradiance_at(&map, &[Dir::Z])[0].r;
        let expected = PI * half.min(0.5 * PI).sin().powi(2);
        assert!((irradiance / expected - 1.0).abs() < 1e-3, "{projection} {degrees}: {irradiance}, not {expected}");
    }
}

/// The direction of the brightest texel of a channel.
fn brightest(map: &EnvMap, channel: usize) -> Dir {
    let light = |i: usize| map.texels()[i].to_array()[channel];
    let i = (0..map.texels().len()).max_by(|a, b| light(*a).total_cmp(&light(*b))).unwrap();
    map.dir(i % map.width(), i / map.width())
}

#[test]
fn lights_at_the_sides_of_a_picture_lie_where_the_camera_saw_them() {
    const PIXELS: usize = 60;
    // A pixel and a texel, of 3 degrees each, and what interpolation makes of them.
    const OFF: f64 = 7.0;
    let slanted = Dir::new([0.8, 0.0, 0.6]).unwrap();
    let steep = Dir::new([0.6, 0.0, 0.8]).unwrap();
    // The axis, and where the top and the right side of the picture point.
    let cases = [
        (Dir::Z, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        (-Dir::Z, [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]),
        (Dir::X, [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]),
        (-Dir::X, [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
        (Dir::Y, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
        (-Dir::Y, [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]),
        (slanted, [-0.6, 0.0, 0.8], [0.0, -1.0, 0.0]),
        (steep, [0.8, 0.0, -0.6], [0.0, 1.0, 0.0]),
    ];
    // To the right and up from the middle, in units of half of the radius, which is 45°; one for each channel.
    let lights = [[(0.0, 0.0), (0.0, 1.0), (1.0, 0.0)], [(0.0, -1.0), (-1.0, 0.0), (0.7, 0.3)]];
    for (axis, top, right) in cases {
        for lights in lights {
            let at = |c: f64| (0.5 * PIXELS as f64 * (1.0 + 0.5 * c)) as usize;
            let suns = lights.map(|(x, y)| (at(x), at(-y)));
            let bytes = picture(PIXELS, PIXELS, |x, y| suns.map(|sun| if (x, y) == sun { 100.0 } else { 0.1 }));
            let map = read(&bytes, lens(FisheyeProjection::Equidistant, 180.0).axis(axis));
            for (channel, (x, y)) in lights.into_iter().enumerate() {
                let aside = f64::hypot(x, y);
                let (sin, cos) = (0.25 * PI * aside).sin_cos();
                let sin = if aside > 0.0 { sin / aside } else { 0.0 };
                let expected = [0, 1, 2].map(|k| cos * axis.to_array()[k] + sin * (x * right[k] + y * top[k]));
                let expected = Dir::new(expected).unwrap();
                let error = brightest(&map, channel).angle_to(expected).to_degrees();
                assert!(error < OFF, "{axis:?}, light at ({x}, {y}): {error}° off {expected:?}");
            }
        }
    }
}

/// A smooth light without symmetry.
fn uneven(s: Dir) -> Rgb<f32> {
    Rgb::from([2.0 + s.x(), 2.0 + s.y() * s.z(), (1.0 - s.z()).powi(2) + s.x()].map(|c| c as f32))
}

#[test]
fn an_equidistant_fisheye_of_the_whole_sphere_is_the_angular_map() {
    const ORDER: usize = 3;
    // Of the mean. Turning the map of 50 rows interpolates, which costs band 2 less than half a percent of itself.
    const TOLERANCE: f64 = 1e-2;
    let angular = MappedMap::from_fn(Mapping::Angular, 64, 64, uneven);
    let bytes = picture(64, 64, |x, y| angular.texel(x, y).to_array());
    let map = read(&bytes, lens(FisheyeProjection::Equidistant, 360.0).axis(Dir::X));
    let (found, expected) = (project_map(&map, ORDER), project_map(&angular, ORDER));
    for (i, (found, expected_i)) in found.coefficients().iter().zip(expected.coefficients()).enumerate() {
        let error = (*found - *expected_i).to_array().into_iter().zip(expected[0].to_array());
        let error = error.map(|(e, mean)| (e / mean).abs()).fold(0.0, f64::max);
        assert!(error < TOLERANCE, "coefficient {i}: {found:?}, not {expected_i:?}");
    }
}

#[test]
fn a_circle_aside_is_the_picture_that_is_cut_out() {
    let light = |x: usize, y: usize| [1.0 + (x * 7 % 5) as f32, (y % 3) as f32, (x + y) as f32];
    let options = lens(FisheyeProjection::Equisolid, 180.0);
    let cut_out = read(&picture(40, 40, light), options);
    let inside = |x: usize, y: usize| (17..57).contains(&x) && (5..45).contains(&y);
    let whole = picture(80, 60, |x, y| if inside(x, y) { light(x - 17, y - 5) } else { [50.0; 3] });
    let found = read(&whole, options.circle([37.0, 25.0, 20.0]));
    assert_eq!((found.width(), found.height()), (cut_out.width(), cut_out.height()), "the same circle");
    for (a, b) in found.texels().iter().zip(cut_out.texels()) {
        let error = (*a - *b).to_array().into_iter().fold(0.0, |most: f32, e| most.max(e.abs()));
        assert!(error < 1e-4, "{a:?}, not {b:?}");
    }
    // Without it the largest about the middle.
    let centered = read(&whole, options.circle([40.0, 30.0, 30.0]));
    assert_eq!(read(&whole, options), centered, "the inscribed circle");
}

#[test]
fn beyond_the_circle_is_nothing_or_the_nearest_of_its_rim() {
    let bytes = picture(60, 60, |x, _| [1.0 + x as f32; 3]);
    let options = MapReadOptions::default().fisheye(lens(FisheyeProjection::Stereographic, 180.0));
    let black = try_read(&bytes, &options).unwrap();
    let horizon = black.height() / 2;
    let is_above = |map: &EnvMap, x: usize| map.texel(x, horizon - 1).g >= 1.0;
    assert!((0..black.width()).all(|x| is_above(&black, x)), "rows above the horizon are not diluted");
    let below = black.texels()[horizon * black.width()..].iter().map(|texel| texel.g);
    assert!(below.clone().all(|light| light < 1e-6), "{:?} below", below.fold(0.0, f32::max));
    let edge = try_read(&bytes, &options.clone().padding(Padding::Edge)).unwrap();
    for x in 0..edge.width() {
        let column: Vec<f32> = (horizon..edge.height()).map(|y| edge.texel(x, y).g).collect();
        let near = edge.texel(x, horizon - 1).g;
        assert!(column.iter().all(|light| (light / column[0] - 1.0).abs() < 1e-5), "column {x}: {column:?}");
        // Along a row of texels of two degrees the picture changes by two pixels.
        assert!((column[0] - near).abs() < 3.0, "column {x}: {} below {near}", column[0]);
    }
    // A pixel that stands out of the rim is no brighter below than it is.
    let sun = picture(60, 60, |x, y| if x == 59 && (y == 26 || y == 33) { [100.0; 3] } else { [1.0; 3] });
    let edge = try_read(&sun, &options.clone().padding(Padding::Edge)).unwrap();
    let below = edge.texels()[(horizon + 1) * edge.width()..].iter().map(|texel| texel.g);
    let (least, most) = below.fold((f32::MAX, 0.0_f32), |(least, most), light| (least.min(light), most.max(light)));
    assert!(least > 0.999 && most < 100.1 && most > 2.0, "from {least} to {most}");
    // A circle that leaves the picture above and below.
    let cut = picture(60, 40, |_, _| [1.0; 3]);
    let lens = lens(FisheyeProjection::Equidistant, 180.0).circle([30.0, 20.0, 30.0]);
    let whole = try_read(&cut, &MapReadOptions::default().fisheye(lens).padding(Padding::Edge)).unwrap();
    assert!(whole.texels().iter().all(|texel| (texel.g - 1.0).abs() < 1e-6), "the same all around");
    let part = read(&cut, lens);
    assert!(part.mean().g < 0.5 && part.texel(0, 0).g > 0.999, "black where the picture ends: {:?}", part.mean());
}

#[test]
fn what_is_no_fisheye_picture_is_refused() {
    let bytes = picture(20, 10, |_, _| [1.0; 3]);
    let base = MapReadOptions::default();
    let error = |options: &MapReadOptions| try_read(&bytes, options).unwrap_err();
    let of_lens = |lens: FisheyeOptions| error(&base.clone().fisheye(lens)).to_string();
    let said = of_lens(lens(FisheyeProjection::Orthographic, 200.0));
    assert!(said.starts_with("test: the field of view of orthographic fisheyes is") && said.contains("200°"), "{said}");
    for circle in
        [[0.0, 5.0, 3.0], [10.0, 12.0, 3.0], [10.0, 5.0, 0.0], [10.0, 5.0, f64::INFINITY], [f64::NAN, 5.0, 3.0]]
    {
        let said = of_lens(FisheyeOptions::default().circle(circle));
        assert!(said.starts_with("test: the circle of a fisheye picture of 20 x 10 pixels"), "{circle:?}: {said}");
    }
    let fisheye = base.clone().fisheye(FisheyeOptions::default());
    let others = [Mapping::LatLong, Mapping::Angular, Mapping::Cube].map(|mapping| fisheye.clone().mapping(mapping));
    for options in others.into_iter().chain([fisheye.clone().elevations([-0.5, 0.5])]) {
        let said = error(&options).to_string();
        assert!(said.contains("has no other mapping and no elevations"), "{said}");
    }
    let large = fisheye.clone().max_texels(200).fisheye(FisheyeOptions::default().circle([10.0, 5.0, 50.0]));
    assert!(matches!(error(&large), EnvError::Image(ImageError::Refused { .. })), "the map is larger than the picture");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ktx2");
    let cube = CubeMipChain::single(CubeMap::from_fn(4, |_| Rgb::new(1.0, 1.0, 1.0)));
    write_cube(&path, &cube, &CubeWriteOptions::default()).unwrap();
    assert!(matches!(read_map(&path, &fisheye), Err(EnvError::Contradiction { .. })), "a cube is none");
}

#[test]
fn what_a_file_says_of_itself_is_no_fisheye_picture() {
    let fisheye = MapReadOptions::default().fisheye(FisheyeOptions::default());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("kept.exr");
    let map = MappedMap::from_fn(Mapping::Octahedral, 8, 8, |_| Rgb::new(1.0, 1.0, 1.0));
    write_env(&path, &map, &PictureWriteOptions::default()).unwrap();
    for (source, found) in [(path.to_str().unwrap(), "octahedral"), ("bundled:sunset", "lat-long")] {
        assert!(read_map(source, &MapReadOptions::default()).is_ok(), "{source}: a map");
        let said = read_map(source, &fisheye).map(|_| ()).unwrap_err().to_string();
        assert_eq!(said, format!("{source} is {found}; leave MapReadOptions::fisheye at its default"), "{source}");
    }
}

#[test]
fn a_note_says_what_was_taken_for_what() {
    let bytes = picture(20, 10, |_, _| [1.0; 3]);
    let options = MapReadOptions::default().fisheye(lens(FisheyeProjection::Equisolid, 170.0));
    let (map, report) = read_map_bytes(&bytes, "test", &options).unwrap();
    let (width, height) = (map.base().width(), map.base().height());
    let note = format!("it shows 170° around 0.000,0.000,1.000 (equisolid fisheye) of a map of {width} x {height}");
    assert!(report.picture.notes.contains(&note), "{:?}", report.picture.notes);
}
