//! Pictures of what moves, of the program without a window against those by rays of the command `lobe render`.

use lobe::env::{SceneLight, SunChoice};
use lobe::image::Picture;
use lobe::io::Job;
use lobe::motion::{MovingMethod, MovingOptions, MovingShading, light_moving_scene};
use lobe::render::{ViewOptions, ViewPoint};
use lobe::sh::Coefficient as _;
use lobe::shadow::SphereFitMethod;
use lobe_viewer::{ReadLimits, moving_bake_options, open_moving, open_sky};

use crate::command::{is_without_adapter, viewer};

/// The relative difference, of the brightest pixel, that pictures of the device keep but at the edges of shadows.
const TOLERANCE: f32 = 1e-3;

/// No more than this part of the pixels differs: those where an edge passes so near to a sample that the grid to which the
/// device snaps corners decides, and edges of the shadows of suns.
const AT_EDGES: f64 = 6e-3;

const SIZE: [usize; 2] = [120, 80];
const ORDER: usize = 3;
const SPHERES: usize = 4;

/// The part of the pixels that differ.
fn differing(found: &Picture, expected: &Picture) -> f64 {
    let brightest = expected.pixels().iter().flatten().fold(0.0_f32, |most, c| most.max(c.abs()));
    let differs = |(f, e): (&[f32; 3], &[f32; 3])| {
        (0..3).any(|c| !f[c].is_finite() || (f[c] - e[c]).abs() > TOLERANCE * brightest)
    };
    let pairs = found.pixels().iter().zip(expected.pixels());
    pairs.filter(|pair| differs(*pair)).count() as f64 / expected.pixels().len() as f64
}

#[test]
#[ignore = "long: of the nightly group"]
fn what_moves_is_in_files_as_rays_on_the_processor_show_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let wedge = "v 0.5 0 -0.3\nv -0.3 0.4 -0.3\nv -0.3 -0.4 -0.3\nv 0 0 0.5\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    std::fs::write(at.join("wedge.obj"), wedge).unwrap();
    // Smooth: a picture in which nothing but the light changes from pixel to pixel.
    let floor: Vec<String> = (0..81).map(|k| format!("v {} 0 {}\n", k % 9 - 4, 4 - k / 9)).collect();
    let face = |k: usize| {
        let first = k / 8 * 9 + k % 8 + 1;
        format!("f {} {} {} {}\n", first, first + 1, first + 10, first + 9)
    };
    let floor = floor.concat() + &(0..64).map(face).collect::<String>();
    std::fs::write(at.join("ground.obj"), floor).unwrap();
    let falls = r#"{"format": "lobe-scene", "version": 1, "still": ["ground.obj"], "entities": [
        {"name": "falling", "mesh": "wedge.obj", "keys": [{"time": 0, "translation": [0, 0, 2]}, {"time": 2, "translation": [0, 0, 1]}]},
        {"name": "other", "mesh": "wedge.obj", "keys": [{"time": 0, "translation": [1, 1, 1]}, {"time": 2, "translation": [-1, 1, 2]}]}]}"#;
    let path = at.join("falls.json");
    std::fs::write(&path, falls).unwrap();
    let limits = ReadLimits::default();
    let sky = open_sky("made:evening".as_ref(), &limits).unwrap();
    let light = SceneLight::of_map(&sky.map, ORDER, &SunChoice::Auto).unwrap();
    assert_eq!(light.suns().len(), 1, "a sun that casts shadows by itself");
    let [width, height] = SIZE;
    let view = ViewOptions::default().width(width).height(height).rays(1_usize).edge_rays(0);
    // The device takes every sphere by itself, the processor some of them together.
    let ways = [
        ("fields", "device", MovingMethod::Fields),
        ("fields", "processor", MovingMethod::Fields),
        ("exponentials", "auto", MovingMethod::Exponentials),
    ];
    for (mode, lit_on, method) in ways {
        let arguments = format!(
            "--headless falls.json --mode {mode} --order {ORDER} --spheres {SPHERES} --frames 2 --size {width}x{height} \
             --rays 1 --orbit 40,25 --software --lit-on {lit_on} -o {mode}.exr"
        );
        let output = viewer(at, &arguments);
        if is_without_adapter(&output) {
            return;
        }
        assert!(output.status.success(), "{mode}: {}", String::from_utf8_lossy(&output.stderr));
        let mut scene = open_moving(&path, &limits).unwrap();
        let options = moving_bake_options(ORDER, SphereFitMethod::Variational, SPHERES, true).direct(true);
        scene.bake(method, &options, Job::default()).unwrap();
        let shading = MovingShading::new(MovingOptions::default().order(ORDER).method(method)).unwrap();
        let [begin, end] = scene.span();
        let first = scene.at(begin).unwrap();
        let looks = ViewPoint::Orbit { azimuth: 40.0, height: 25.0 };
        let camera = looks.camera(first.scene().world_bounds(), ViewPoint::FOV).unwrap();
        for (frame, time) in [begin, 0.5 * (begin + end)].into_iter().enumerate() {
            let moment = scene.at(time).unwrap();
            let behind = |s| sky.map.radiance(s).widen();
            let lit = light_moving_scene(&moment, &shading, &light, &camera, &view, behind, Job::default()).unwrap();
            let file = at.join(format!("{mode}.{frame:04}.exr"));
            let found = lobe::image::read_picture(&file, &Default::default()).unwrap().0;
            let part = differing(&found, &lit.picture);
            assert!(part <= AT_EDGES, "{mode}, moment {frame}: {part} of the pixels differ");
        }
    }
}
