//! `lobe sh`: evaluation, rotation, product and convolution.

use std::f64::consts::PI;

use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::FileCoefficients;
use lobe::sh::{Coefficient, Dir as Direction, Expansion as _, Rgb, ShVec, Zonal, project};
use lobe_testkit::{Random, golden_f64s};

use crate::harness::Dir;

/// Rounding of sums of a hundred terms of size 1.
const TOLERANCE: f64 = 1e-12;

fn assert_close(found: &FileCoefficients, expected: &[f64], what: &str) {
    let FileCoefficients::Scalar(found) = found else { panic!("{what}: numbers expected, found {found:?}") };
    assert_eq!(found.coefficients().len(), expected.len(), "{what}");
    for (i, (a, b)) in found.coefficients().iter().zip(expected).enumerate() {
        assert!((a - b).abs() < TOLERANCE, "{what}, i {i}: {a} against {b}");
    }
}

/// The inputs of the golden values.
fn rule(n: usize, f: impl Fn(usize) -> f64) -> ShVec<f64> {
    ShVec::from_vec((0..n * n).map(f).collect()).unwrap()
}

fn rule_a(i: usize) -> f64 {
    (((37 * i + 11) % 19) as f64 - 9.0) / 10.0
}

fn rule_b(i: usize) -> f64 {
    (((23 * i + 5) % 17) as f64 - 8.0) / 8.0
}

/// A light towards a direction.
fn impulse(dir: Direction) -> ShVec<f64> {
    ShVec::impulse(4, dir, 1.0)
}

#[test]
fn eval_prints_one_line_for_each_direction() {
    let dir = Dir::new();
    let f = rule(3, rule_a).map(|c| Rgb::new(c, 0.0, -c));
    let line = |s: Direction| f.eval(s).to_array().map(|c| format!("{c:?}")).join(" ") + "\n";
    let expected = line(Direction::Z) + &line(-Direction::X);
    dir.sh("p.sh.json", Quantity::Radiance, f.clone());
    assert_eq!(dir.lobe("sh eval p.sh.json --dir 0,0,1 --dir -3,0,0").stdout(), expected, "colors");
    dir.sh("v.sh.json", Quantity::LogVisibility, f.map(|c| c.b));
    let expected = format!("{:?}\n", f.eval(-Direction::Y).b);
    assert_eq!(dir.lobe("sh eval v.sh.json --dir=0,-1,0").stdout(), expected, "numbers");
}

#[test]
fn eval_prints_json_for_machines() {
    let dir = Dir::new();
    let f = rule(3, rule_a).map(|c| Rgb::new(c, 0.0, -c));
    let row = |s: Direction| format!("[{}]", f.eval(s).to_array().map(|c| format!("{c:?}")).join(","));
    let expected = format!("{{\"values\":[{},{}]}}\n", row(Direction::Z), row(Direction::X));
    dir.sh("p.sh.json", Quantity::Radiance, f.clone());
    assert_eq!(dir.lobe("sh eval p.sh.json --json --dir 0,0,1 --dir 1,0,0").stdout(), expected, "colors");
    let expected = format!("{{\"values\":[[{:?}]]}}\n", f.eval(Direction::Y).r);
    dir.sh("v.sh.json", Quantity::Visibility, f.map(|c| c.r));
    assert_eq!(dir.lobe("sh eval v.sh.json --json --dir 0,2,0").stdout(), expected, "numbers");
}

#[test]
fn eval_agrees_with_the_golden_basis() {
    let dir = Dir::new();
    let y = golden_f64s("/basis_dir/order10");
    let direction = golden_f64s("/basis_dir/dir").iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    let f = ShVec::from_vec(Random::new(1).signed_vec(100)).unwrap();
    let expected: f64 = f.coefficients().iter().zip(&y).map(|(f, y)| f * y).sum();
    dir.sh("f.sh.json", Quantity::Radiance, f);
    let found: f64 = dir.lobe(&format!("sh eval f.sh.json --dir {direction}")).stdout().trim().parse().unwrap();
    assert!((found - expected).abs() < TOLERANCE, "{found} against {expected}");
}

#[test]
fn info_prints_facts_about_an_expansion() {
    let dir = Dir::new();
    // 1 + 2 z in red: band 0 has 4π, band 1 2² 4π/3; green is constant, blue points to -x.
    let f = project(3, 1, |s| Rgb::new(1.0 + 2.0 * s.z(), 0.5, 1.0 - s.x()));
    dir.sh("p.sh.json", Quantity::Radiance, f);
    let text = dir.lobe("sh info p.sh.json").stdout();
    for line in [
        "order     3",
        "quantity  radiance",
        "channels  3",
        "mean      1.0 0.5 1.0",
        "max       3.0 0.5 ",
        "min       -1.0 0.5 ",
        "green     towards nowhere",
    ] {
        assert!(text.contains(line), "{line:?} is missing in\n{text}");
    }
    let info: serde_json::Value = serde_json::from_str(&dir.lobe("sh info p.sh.json --json").stdout()).unwrap();
    let number = |path: &str| info.pointer(path).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
    for (path, expected) in [
        ("/order", 3.0),
        ("/channels", 3.0),
        ("/band_energy/0/0", 4.0 * PI),
        ("/band_energy/0/1", 16.0 * PI / 3.0),
        ("/band_energy/1/0", PI),
        ("/dir/0/2", 1.0),
        ("/dir/2/0", -1.0),
        ("/max/0", 3.0),
        ("/min/0", -1.0),
    ] {
        assert!((number(path) - expected).abs() < 1e-9, "{path}: {} against {expected}", number(path));
    }
    assert!(info["dir"][1].is_null(), "a constant points nowhere: {}", info["dir"]);
    dir.sh("v.sh.json", Quantity::Visibility, ShVec::constant(1, 0.25));
    let text = dir.lobe("sh info v.sh.json").stdout();
    assert!(text.contains("channels  1") && text.ends_with("points    towards nowhere\n"), "{text}");
}

#[test]
fn rotate_agrees_with_the_golden_rotation() {
    let dir = Dir::new();
    let expected = golden_f64s("/rotation/out");
    dir.sh("p.sh.json", Quantity::Transfer, rule(expected.len().isqrt(), rule_a));
    let matrix = golden_f64s("/rotation/R").iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    dir.lobe(&format!("sh rotate p.sh.json --matrix {matrix} -o q.sh.json")).stdout();
    let q = dir.read_sh("q.sh.json");
    assert_eq!(q.quantity, Quantity::Transfer, "quantity");
    assert_close(&q.coefficients, &expected, "golden rotation");
}

#[test]
fn axis_quaternion_matrix_and_euler_angles_turn_plus_x_to_plus_y_alike() {
    let dir = Dir::new();
    dir.sh("x.sh.json", Quantity::Radiance, impulse(Direction::X));
    for turn in [
        "--axis 0,0,1 --angle 90",
        "--axis 0,0,-2 --angle -90",
        "--axis 0,0,1 --angle 3690",
        "--quat 0,0,0.7071067811865476,0.7071067811865476",
        "--matrix 0,-1,0,1,0,0,0,0,1",
        "--euler-zyz 90,0,0",
        "--euler-zyz 30,0,-3540",
        // The turn about +y leaves what the first one has taken there.
        "--euler-zyz 0,70,90",
    ] {
        dir.lobe(&format!("sh rotate x.sh.json {turn} -o y.sh.json")).stdout();
        assert_close(&dir.read_sh("y.sh.json").coefficients, impulse(Direction::Y).coefficients(), turn);
    }
}

#[test]
fn euler_angles_take_plus_z_to_their_direction_in_functions_and_in_maps() {
    let dir = Dir::new();
    let (theta, phi) = (50.0_f64.to_radians(), -120.0_f64.to_radians());
    dir.sh("z.sh.json", Quantity::Radiance, impulse(Direction::Z));
    for gamma in [0.0, 77.0, -300.0] {
        dir.lobe(&format!("sh rotate z.sh.json --euler-zyz -120,50,{gamma} -o q.sh.json")).stdout();
        let expected = impulse(Direction::from_angles(theta, phi));
        assert_close(&dir.read_sh("q.sh.json").coefficients, expected.coefficients(), &format!("γ = {gamma}"));
    }
    // R_z(90°) R_y(90°), by hand.
    dir.map("m.pfm", 32, 16, |x, y| [x as f32, y as f32, 1.0]);
    dir.lobe("env rotate m.pfm --euler-zyz 90,90,0 -o a.pfm").succeeds();
    let rotation = "--matrix 0,-1,0,0,0,1,-1,0,0";
    dir.lobe(&format!("env rotate m.pfm {rotation} -o b.pfm")).succeeds();
    for (k, (a, b)) in dir.numbers("a.pfm").iter().zip(dir.numbers("b.pfm")).enumerate() {
        assert!((a - b).abs() < 1e-3, "number {k}: {a} against {b}");
    }
}

#[test]
fn a_file_may_be_turned_in_place() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, impulse(Direction::X).map(|c| Rgb::new(c, 2.0 * c, 0.0)));
    dir.lobe("sh rotate p.sh.json --axis 0,1,0 --angle 90 -o p.sh.json").stdout();
    let FileCoefficients::Rgb(turned) = dir.read_sh("p.sh.json").coefficients else { panic!("colors stay colors") };
    for (a, b) in turned.coefficients().iter().zip(impulse(-Direction::Z).coefficients()) {
        let error = (a.r - b).abs().max((a.g - 2.0 * b).abs()).max(a.b.abs());
        assert!(error < TOLERANCE, "{a:?} against {b}");
    }
    assert_eq!(dir.names(), ["p.sh.json"], "files");
}

#[test]
fn what_is_no_rotation_is_refused() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, impulse(Direction::X));
    for (turn, start) in [
        (
            "--matrix 1,0,0,0,1,0,0,0,-1",
            "--matrix: expected a rotation, found a mirror (determinant -1.000000); exchange two",
        ),
        ("--matrix 2,0,0,0,2,0,0,0,2", "--matrix: expected a rotation matrix, found one that scales"),
        ("--matrix 0,0,0,0,0,0,0,0,0", "--matrix: "),
        ("--quat 0,0,0,0", "--quat: expected a unit quaternion, found length 0"),
        ("--quat 0,0,0,7", "--quat: expected a unit quaternion, found length 7"),
    ] {
        let line = dir.lobe(&format!("sh rotate p.sh.json {turn} -o q.sh.json")).error();
        assert!(line.starts_with(start), "{turn}: {line}");
        assert_eq!(dir.names(), ["p.sh.json"], "files after {turn}");
    }
}

#[test]
fn product_agrees_with_the_golden_products() {
    let dir = Dir::new();
    for n in 2..=6 {
        dir.sh("a.sh.json", Quantity::Radiance, rule(n, rule_a));
        dir.sh("b.sh.json", Quantity::Visibility, rule(n, rule_b));
        dir.lobe("sh product a.sh.json b.sh.json -o c.sh.json").stdout();
        assert_close(&dir.read_sh("c.sh.json").coefficients, &golden_f64s(&format!("/product/{n}/c")), &n.to_string());
    }
}

#[test]
fn a_product_has_the_order_that_was_asked_for_and_is_whole_at_the_sum() {
    let dir = Dir::new();
    let (a, b) = (rule(3, rule_a), rule(5, rule_b));
    let s = Direction::from_angles(1.1, -2.0);
    let expected = a.eval(s) * b.eval(s);
    dir.sh("a.sh.json", Quantity::Visibility, a);
    dir.sh("b.sh.json", Quantity::Visibility, b);
    for (option, order) in [("", 5), ("--order 2", 2), ("--order 7", 7), ("--order 9", 9)] {
        dir.lobe(&format!("sh product a.sh.json b.sh.json {option} -o c.sh.json")).stdout();
        let FileCoefficients::Scalar(c) = dir.read_sh("c.sh.json").coefficients else { panic!("numbers expected") };
        assert_eq!(c.order(), order, "order with {option:?}");
        // The product of degrees 2 and 4 has degree 6: order 7 holds all of it.
        let error = (c.eval(s) - expected).abs();
        assert!(order < 7 || error < TOLERANCE, "{option}: {} against {expected}", c.eval(s));
    }
}

#[test]
fn colors_may_be_masked_by_visibility() {
    let dir = Dir::new();
    dir.sh("l.sh.json", Quantity::Irradiance, ShVec::constant(3, Rgb::new(1.0, 2.0, 3.0)));
    dir.sh("v.sh.json", Quantity::Visibility, ShVec::constant(2, 0.5));
    for pair in ["l.sh.json v.sh.json", "v.sh.json l.sh.json"] {
        dir.lobe(&format!("sh product {pair} -o c.sh.json")).stdout();
        let c = dir.read_sh("c.sh.json");
        assert_eq!(c.quantity, Quantity::Irradiance, "quantity of {pair}");
        let value = c.coefficients.to_rgb().eval(Direction::X);
        let error = (value - Rgb::new(0.5, 1.0, 1.5)).to_array().map(f64::abs);
        assert!(error.iter().all(|e| *e < TOLERANCE), "{pair}: {value:?}");
    }
}

#[test]
fn quantities_that_have_no_product_are_refused() {
    let dir = Dir::new();
    for quantity in [Quantity::Radiance, Quantity::Irradiance, Quantity::Transfer, Quantity::LogVisibility] {
        dir.sh(&format!("{quantity}.sh.json"), quantity, ShVec::constant(2, 1.0));
    }
    for (a, b) in [("radiance", "transfer"), ("irradiance", "irradiance")] {
        let line = dir.lobe(&format!("sh product {a}.sh.json {b}.sh.json -o c.sh.json")).error();
        let expected = format!(
            "{a}.sh.json and {b}.sh.json: {a} times {b} is no quantity of a file; expected visibility for one of them; \
             --quantity names the result whatever it is"
        );
        assert_eq!(line, expected, "{a} and {b}");
    }
    let line = dir.lobe("sh product log-visibility.sh.json log-visibility.sh.json -o c.sh.json").error();
    assert!(line.contains("so add them instead"), "{line}");
    let line = dir.lobe("sh convolve transfer.sh.json --kernel phong:2 -o c.sh.json").error();
    assert!(line.contains("the cosine is in it already") && line.contains("--quantity"), "{line}");
}

#[test]
fn a_result_without_a_quantity_of_its_own_gets_the_one_that_is_named() {
    let dir = Dir::new();
    let pair = [("a", Quantity::Radiance, 2.0), ("b", Quantity::Radiance, 3.0), ("t", Quantity::Transfer, 2.0)];
    for (name, quantity, value) in pair {
        dir.sh(&format!("{name}.sh.json"), quantity, ShVec::constant(2, value));
    }
    for (args, quantity, value) in [
        ("product a.sh.json b.sh.json --quantity radiance", Quantity::Radiance, 6.0),
        ("product a.sh.json b.sh.json --quantity function", Quantity::Function, 6.0),
        ("convolve t.sh.json --kernel phong:2 --quantity transfer", Quantity::Transfer, 2.0),
    ] {
        dir.lobe(&format!("sh {args} -o c.sh.json")).stdout();
        let c = dir.read_sh("c.sh.json");
        assert_eq!(c.quantity, quantity, "{args}: quantity");
        let found = c.coefficients.to_rgb().eval(Direction::X).g;
        assert!((found - value).abs() < TOLERANCE, "{args}: {found}, not {value}");
    }
    let line = dir.lobe("sh product a.sh.json b.sh.json --quantity love -o c.sh.json").error();
    assert!(
        line.contains("expected one of radiance, irradiance, transfer, visibility, log-visibility, function"),
        "{line}"
    );
}

#[test]
fn a_constant_sky_convolved_with_the_cosine_gives_pi() {
    let dir = Dir::new();
    dir.sh("sky.sh.json", Quantity::Radiance, ShVec::constant(3, Rgb::splat(1.0)));
    dir.lobe("sh convolve sky.sh.json --kernel cosine -o e.sh.json").stdout();
    let e = dir.read_sh("e.sh.json");
    assert_eq!(e.quantity, Quantity::Irradiance, "quantity");
    for s in lobe_testkit::directions() {
        let value = e.coefficients.to_rgb().eval(Direction::from_unit(s)).r;
        assert!((value - PI).abs() < TOLERANCE, "towards {s:?}: {value}");
    }
}

#[test]
fn normalized_lobes_keep_radiance_and_its_mean() {
    let dir = Dir::new();
    let f = rule(5, rule_a);
    for kernel in ["phong:0", "phong:20", "ggx:0.3", "ggx:1", "ggx:0"] {
        dir.sh("p.sh.json", Quantity::Radiance, f.clone());
        dir.lobe(&format!("sh convolve p.sh.json --kernel {kernel} -o q.sh.json")).stdout();
        let q = dir.read_sh("q.sh.json");
        let FileCoefficients::Scalar(g) = q.coefficients else { panic!("numbers expected") };
        assert_eq!(q.quantity, Quantity::Radiance, "quantity after {kernel}");
        assert!((g.mean() - f.mean()).abs() < TOLERANCE, "mean after {kernel}: {} against {}", g.mean(), f.mean());
        let (before, after) = (f.band_energies()[3], g.band_energies()[3]);
        assert!(after < before || kernel == "ggx:0", "energy of band 3 after {kernel}: {after} against {before}");
    }
}

#[test]
fn a_kernel_in_a_file_is_a_function_of_the_angle_from_z() {
    let dir = Dir::new();
    let cosine = Zonal::clamped_cosine(4);
    dir.sh("p.sh.json", Quantity::Transfer, rule(4, rule_b));
    dir.sh("z.sh.json", Quantity::Visibility, cosine.towards(Direction::Z, 1.0));
    dir.lobe("sh convolve p.sh.json --kernel z.sh.json -o q.sh.json").stdout();
    let q = dir.read_sh("q.sh.json");
    assert_eq!(q.quantity, Quantity::Transfer, "a kernel from a file keeps the quantity");
    assert_close(&q.coefficients, rule(4, rule_b).convolved(&cosine).coefficients(), "cosine by file");
}

#[test]
fn a_kernel_that_is_not_symmetric_about_z_is_refused() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, rule(3, rule_a));
    dir.sh("x.sh.json", Quantity::Radiance, ShVec::from_vec(vec![1.0, 0.0, 0.5, -0.25]).unwrap());
    let line = dir.lobe("sh convolve p.sh.json --kernel x.sh.json -o q.sh.json").error();
    let expected =
        "x.sh.json: expected a kernel that is symmetric about +z, but coefficient 3 (l = 1, m = 1) is -0.25, not 0";
    assert_eq!(line, expected, "kernel towards +x");
}

#[test]
fn a_kernel_of_lower_order_is_noted() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, rule(3, rule_a));
    dir.sh("z.sh.json", Quantity::Radiance, ShVec::constant(1, 1.0));
    let (_, stderr) = dir.lobe("sh convolve p.sh.json --kernel z.sh.json -o q.sh.json").succeeds();
    assert_eq!(
        stderr, "note: --kernel: p.sh.json has order 3, the kernel order 1; the bands from 1 on become zero\n",
        "note"
    );
}

#[test]
fn quantities_that_are_no_light_are_not_convolved_with_the_cosine() {
    let dir = Dir::new();
    for (quantity, reason) in [
        (Quantity::Irradiance, "this is irradiance, the cosine is in it already; expected radiance or visibility"),
        (Quantity::Transfer, "this is transfer, the cosine is in it already; expected radiance or visibility"),
        (
            Quantity::LogVisibility,
            "log-visibility is a logarithm, its convolution has no meaning; expected radiance or visibility",
        ),
    ] {
        dir.sh("p.sh.json", quantity, ShVec::constant(2, 1.0));
        let line = dir.lobe("sh convolve p.sh.json --kernel cosine -o q.sh.json").error();
        assert_eq!(line, format!("p.sh.json: {reason}; --quantity names the result whatever it is"), "{quantity}");
        assert_eq!(dir.names(), ["p.sh.json"], "files");
    }
}

#[test]
fn every_style_is_drawn_as_png_and_as_svg() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Irradiance, project(3, 2, |s| Rgb::new(s.z(), s.x() * s.y(), 0.5)));
    for style in ["balloon", "cross", "polar"] {
        dir.lobe(&format!("sh plot p.sh.json -o {style}.png --style {style} --size 64")).stdout();
        assert!(dir.bytes(&format!("{style}.png")).starts_with(b"\x89PNG\r\n\x1a\n"), "{style}: no PNG");
        dir.lobe(&format!("sh plot p.sh.json -o {style}.svg --style {style} --size 64")).stdout();
        let svg = String::from_utf8(dir.bytes(&format!("{style}.svg"))).unwrap();
        assert!(svg.starts_with("<svg xmlns") && svg.ends_with("</svg>\n"), "{style}: {svg}");
    }
    dir.lobe("sh plot p.sh.json -o profile.png --style profile").stdout();
    assert!(dir.bytes("profile.png").starts_with(b"\x89PNG\r\n\x1a\n"), "profile: no PNG");
    dir.lobe("sh plot p.sh.json -o two.svg --style polar --plane yz --channel red --beside p.sh.json").stdout();
    let svg = String::from_utf8(dir.bytes("two.svg")).unwrap();
    assert!(svg.contains("stroke-dasharray") && svg.contains(">+y<"), "{svg}");
}

/// The ends of the lines of one color in an SVG, from left to right.
fn ends_of_lines(svg: &str, color: &str) -> Vec<[[f64; 2]; 2]> {
    let point = |text: &str| {
        let mut numbers = text.split(' ').map(|x| x.parse::<f64>().unwrap());
        [(); 2].map(|()| numbers.next().unwrap())
    };
    let lines = svg.lines().filter(|line| line.starts_with("<path") && line.contains(color));
    let ends = lines.map(|line| {
        let path = line.split('"').nth(1).unwrap().trim_start_matches('M');
        let mut points = path.split('L').map(point);
        let first = points.next().unwrap();
        [first, points.next_back().unwrap()]
    });
    ends.collect()
}

#[test]
fn a_profile_runs_from_plus_z_to_minus_z_on_its_side() {
    let dir = Dir::new();
    // 0.9 cos θ, from 0.9 at +z to -0.9 at -z, and 0.9 sin θ cos φ.
    dir.sh("z.sh.json", Quantity::Radiance, project(2, 1, |s| 0.9 * s.z()));
    dir.sh("x.sh.json", Quantity::Radiance, project(2, 1, |s| 0.9 * s.x()));
    dir.lobe("sh plot z.sh.json -o z.svg --style profile --size 480").stdout();
    let svg = String::from_utf8(dir.bytes("z.svg")).unwrap();
    let lines = ends_of_lines(&svg, "#c81e1e");
    // 480 x 300 pixels, of which 52 on the left, 14 around and 34 below are for the numbers; from 14 to 266 it is 1 to -1.
    assert_eq!(lines, [[[52.0, 26.6], [466.0, 253.4]]], "from the top left to the bottom right");
    assert!(svg.contains("180°") && !svg.contains("z.sh.json"), "degrees, and no legend of one curve: {svg}");
    for (plane, height) in [("xz", 113.4), ("yz", 0.0)] {
        dir.lobe(&format!(
            "sh plot z.sh.json -o two.svg --style profile --plane {plane} --beside x.sh.json --size 480"
        ))
        .stdout();
        let svg = String::from_utf8(dir.bytes("two.svg")).unwrap();
        assert!(svg.contains(">z.sh.json<") && svg.contains(">x.sh.json<"), "{plane}, the legend: {svg}");
        let dashed: Vec<&str> = svg.lines().filter(|line| line.contains("stroke-dasharray")).collect();
        // The middle of the axis is at 140; sin θ is highest at 90°, which is point 180 of 361.
        let middle = dashed[0].split('L').nth(180).unwrap();
        let y: f64 = middle.split(' ').nth(1).unwrap().parse().unwrap();
        assert!((140.0 - height - y).abs() < 0.02, "{plane}: {y} in {middle}");
    }
}

#[test]
fn plots_refuse_what_they_would_ignore() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, ShVec::constant(1, 1.0));
    for (args, part) in [
        ("p.sh.json -o p.jpg", "expected a figure's name that ends in .png or .svg"),
        ("p.sh.json -o p.png --plane xz", "--plane: only --style polar and profile lie in a plane"),
        ("p.sh.json -o p.png --beside p.sh.json", "--beside: only --style polar and profile draw several functions"),
        ("p.sh.json -o p.png --style profile --plane xy", "--plane xy: --style profile begins at +z"),
        ("p.sh.json -o p.png --style profile --extent 1", "--extent: --style profile has all values on its axis"),
        ("p.sh.json -o p.png --style profile --size 64", "--size: expected 256 or more with --style profile"),
        ("- -o p.png --style profile --beside -", "stdin: several inputs are -"),
        ("- -o p.png --style polar --beside -", "stdin: several inputs are -"),
        ("p.sh.json -o p.png --size 8", "expected a width in pixels from 16 to 8192"),
        ("p.sh.json -o p.png --extent 0", "expected a number above 0"),
    ] {
        let line = dir.lobe(&format!("sh plot {args}")).error();
        assert!(line.contains(part), "{args}: {line}");
    }
    assert_eq!(dir.names(), ["p.sh.json"], "files");
}
