//! `lobe env sky`, `vector-irradiance`, `area-light`, `ambient` and `dfg`: the light around a point.

use std::f64::consts::PI;

use lobe::env::EnvMap;
use lobe::image::{PictureReadOptions, read_picture};
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::FileCoefficients;
use serde_json::Value;

use crate::harness::Dir;

fn json(dir: &Dir, args: &str) -> Value {
    serde_json::from_str(&dir.lobe(args).stdout()).unwrap()
}

fn assert_near(found: &Value, expected: f64, tolerance: f64, what: &str) {
    let found = found.as_f64().unwrap_or_else(|| panic!("{what}: {found} is no number"));
    assert!((found - expected).abs() <= tolerance, "{what}: {found} against {expected}");
}

#[test]
fn the_vector_of_a_lamp_points_to_it_and_is_the_difference_of_the_two_sides() {
    let dir = Dir::new();
    dir.map("lamp.exr", 64, 32, |x, y| if (x, y) == (48, 10) { [0.0, 5000.0, 0.0] } else { [0.0; 3] });
    let found = json(&dir, "env vector-irradiance lamp.exr --normal 0,-1,0 --normal 0,0,-2 --json");
    // Column 48 of 64 begins at -y and goes on to -x.
    let theta = 10.5 / 32.0 * PI;
    assert_near(&found["dir"][1][2], theta.cos(), 1e-3, "height of the lamp");
    assert!(found["dir"][1][1].as_f64().unwrap() < -0.8, "right of the center is -y: {found}");
    assert!(found["dir"][0].is_null() && found["magnitude"][0] == 0.0, "no red light: {found}");
    assert_eq!(found["luminance_dir"], found["dir"][1], "only green light");
    for net in found["net"].as_array().unwrap() {
        let difference = net["front"][1].as_f64().unwrap() - net["back"][1].as_f64().unwrap();
        assert_near(&net["net"][1], difference, 1e-6 * difference.abs(), "E(n) - E(-n)");
    }
    dir.map("even.exr", 64, 32, |_, _| [0.7; 3]);
    let even = json(&dir, "env vector-irradiance even.exr --json");
    assert!(even["dir"][0].is_null() && even["luminance_dir"].is_null(), "even light flows nowhere: {even}");
    assert_eq!(even["magnitude"][2].as_f64(), Some(0.0), "not even by rounding: {even}");
    let text = dir.lobe("env vector-irradiance lamp.exr --normal 0,-1,0").stdout();
    assert!(text.starts_with("red        0.0 towards nowhere\ngreen"), "{text}");
    assert_eq!(text.lines().count(), 5, "{text}");
}

#[test]
fn a_disc_overhead_has_its_closed_form_and_is_too_bright_as_a_point() {
    let dir = Dir::new();
    let args = "env area-light disc --center 0,0,10 --shines 0,0,-1 --radius 1 --json";
    let found = json(&dir, args);
    assert_near(&found["irradiance"], PI / 101.0, 1e-15, "irradiance");
    assert_near(&found["vector"][2], PI / 101.0, 1e-15, "vector");
    assert_near(&found["point_error"], 0.01, 1e-12, "as a point");
    assert_near(&found["directional_error"], 0.0, 1e-12, "as a beam");
    let behind = json(&dir, &args.replace("--json", "--at 0,0,20 --json"));
    assert!(behind["irradiance"] == 0.0 && behind["point_error"].is_null(), "the back is dark: {behind}");
}

#[test]
fn rectangles_are_polygons_and_spheres_are_points() {
    let dir = Dir::new();
    let rectangle = json(&dir, "env area-light rectangle --center 0,0,1 --u 1,0,0 --v 0,-1,0 --json");
    let polygon =
        json(&dir, "env area-light polygon --vertex -1,1,1 --vertex 1,1,1 --vertex 1,-1,1 --vertex -1,-1,1 --json");
    // The unit half square at distance 1: 4 atan(1/√2)/√2 of Lambert's formula.
    let expected = 4.0 * (0.5_f64.sqrt()).atan() * 0.5_f64.sqrt();
    assert_near(&rectangle["irradiance"], expected, 1e-14, "rectangle");
    assert_near(&polygon["irradiance"], expected, 1e-14, "polygon");
    let sphere = json(&dir, "env area-light sphere --center 0,0,2 --radius 1 --json");
    assert_near(&sphere["irradiance"], PI / 4.0, 1e-15, "sphere");
    assert_near(&sphere["point_error"], 0.0, 1e-14, "a sphere seen whole is a point");
    for (light, part) in [
        ("sphere --center 0,0,0.5 --radius 1", "--at: the place lies in the ball"),
        ("sphere --center 0,0,5 --radius 1 --reference 0,0,4.5", "--reference: the place lies in the ball"),
        ("disc --center 0,0,0 --shines 0,0,1 --radius 1", "--at: the place lies on the light"),
    ] {
        let line = dir.lobe(&format!("env area-light {light}")).error();
        assert!(line.starts_with(part), "{light}: {line}");
    }
    let line = dir.lobe("env area-light polygon --vertex 0,0,1 --vertex 1,0,1").error();
    assert_eq!(line, "--vertex: a polygon needs three vertices at least, found 2", "two vertices");
    let line = dir.lobe("env area-light sphere --center 0,0,2 --radius -1").error();
    assert!(line.contains("expected a number above 0"), "{line}");
}

#[test]
fn ambient_light_is_radiance_irradiance_and_reflectance() {
    let dir = Dir::new();
    let found = json(&dir, "env ambient --radiance 1,2,4 --brdf ggx:1,1 --view 0 --view 90 --json");
    assert_near(&found["irradiance"][2], 4.0 * PI, 1e-14, "irradiance");
    assert_near(&found["views"][0]["reflectance"], 1.0 - 2.0_f64.ln(), 1e-12, "one scattering of the roughest");
    assert_near(&found["views"][0]["radiance"][1], 2.0 * (1.0 - 2.0_f64.ln()), 1e-12, "radiance");
    let text = dir.lobe("env ambient --brdf lambert:0.5 --view 30").stdout();
    assert!(text.ends_with("seen at 30.0°: reflectance 0.5, radiance 0.5 0.5 0.5\n"), "{text}");
    for (args, part) in [
        ("--brdf gloss:1", "expected lambert:RHO"),
        ("--brdf ggx:0.5,0.5 --view 91", "expected an angle from 0 to 90 degrees"),
        ("--brdf ggx:0.5,0.5 --radiance 1,-1,1", "no channel of a color is negative"),
    ] {
        let line = dir.lobe(&format!("env ambient {args}")).error();
        assert!(line.contains(part), "{args}: {line}");
    }
}

#[test]
fn a_sky_is_a_picture_or_an_expansion_of_the_same_light() {
    let dir = Dir::new();
    let sky = "env sky --sun 1,0,0.5 --turbidity 4 --ground 0.2,0.2,0.2";
    dir.lobe(&format!("{sky} -o sky.exr --size 128")).stdout();
    dir.lobe(&format!("{sky} -o sky.sh.json --order 4")).stdout();
    dir.lobe("project sky.exr --order 4 -o picture.sh.json").stdout();
    let rgb = |name: &str| match dir.read_sh(name).coefficients {
        FileCoefficients::Rgb(f) => f,
        FileCoefficients::Scalar(_) => panic!("{name} is gray"),
    };
    let (formula, picture) = (rgb("sky.sh.json"), rgb("picture.sh.json"));
    assert_eq!(dir.read_sh("sky.sh.json").quantity, Quantity::Radiance, "quantity");
    for i in 0..16 {
        let error = (formula[i] - picture[i]).to_array().into_iter().map(f64::abs).fold(0.0, f64::max);
        assert!(error < 2e-3 * formula[0].g, "coefficient {i}: {:?} against {:?}", formula[i], picture[i]);
    }
    dir.lobe("env sky --sun 1,0,0.5 --turbidity 4 -o exact.sh.json --order 4").stdout();
    dir.lobe("env sky --sun 1,0,0.5 --turbidity 4 -o fit.sh.json --order 4 --fit").stdout();
    let (exact, fit) = (rgb("exact.sh.json"), rgb("fit.sh.json"));
    assert!((exact[0].g / fit[0].g - 1.0).abs() < 2e-3, "{:?} against {:?}", exact[0], fit[0]);
}

#[test]
fn an_overcast_sky_is_three_times_as_bright_at_the_zenith_as_at_the_horizon() {
    let dir = Dir::new();
    dir.lobe("env sky --model cie --type 16 --sun 0,0,1 --zenith 3,6,9 -o sky.exr --size 64").stdout();
    let sky = EnvMap::load(dir.path("sky.exr")).unwrap();
    let ratio = sky.texel(0, 0).g / sky.texel(0, 31).g;
    assert!((ratio - 3.0).abs() < 0.2 && (sky.texel(0, 0).r - 3.0).abs() < 0.01, "{ratio}");
    assert_eq!(sky.texel(5, 32).g, 0.0, "below the horizon");
}

#[test]
fn options_of_another_sky_and_suns_below_the_horizon_are_refused() {
    let dir = Dir::new();
    for (args, part) in [
        ("--sun 0,0,-1 -o s.exr", "--sun: "),
        ("--sun 0,0,1 --turbidity 1 -o s.exr", "--turbidity: a turbidity in [2, 10] expected"),
        ("--sun 0,0,1 --model cie -o s.exr", "--type: --model cie needs one of its types, 1 to 16"),
        ("--sun 0,0,1 --model cie --type 17 -o s.exr", "expected a type of sky from 1 to 16"),
        ("--sun 0,0,1 --model cie --type 3 --turbidity 3 -o s.exr", "--turbidity: --model cie has none"),
        ("--sun 0,0,1 --type 3 -o s.exr", "--type: only --model cie has types"),
        ("--sun 0,0,1 --order 3 -o s.exr", "--order: a picture has none"),
        ("--sun 0,0,1 --size 3 -o s.sh.json", "--size: an expansion has none"),
        ("--sun 0,0,1 --ground 2,0,0 -o s.exr", "no surface reflects more light than it gets"),
        ("--sun 0,0,1 -o s.txt", "expected a name that ends in .sh.json, .exr, .hdr, .pfm or .png"),
    ] {
        let line = dir.lobe(&format!("env sky {args}")).error();
        assert!(line.contains(part), "{args}: {line}");
    }
    assert_eq!(dir.names(), [""; 0], "files");
}

#[test]
fn the_table_of_reflectance_is_smooth_at_the_top_and_grazing_at_the_left() {
    let dir = Dir::new();
    dir.lobe("env dfg -o dfg.exr --size 16").stdout();
    let (table, _) = read_picture(dir.path("dfg.exr"), &PictureReadOptions::default()).unwrap();
    assert_eq!((table.width(), table.height()), (16, 16), "size");
    let (grazing, facing) = (table.pixel(0, 0), table.pixel(15, 0));
    assert!(grazing[1] > 0.7 && facing[1] < 0.01 && facing[0] > 0.98, "{grazing:?}, {facing:?}");
    assert!(table.pixel(15, 15)[0] < 0.5, "the roughest loses light between its facets");
    let line = dir.lobe("env dfg -o dfg.exr --size 0").error();
    assert!(line.contains("expected a number of texels from 1 to 1024"), "{line}");
}
