//! The light of a scene as suns and the rest, against the map it is made of.

use std::f64::consts::PI;

use lobe_env::{
    EnvError, EnvMap, SceneLight, Sun, SunChoice, SunRecord, bundled, irradiance_at, project_env, read_suns,
};
use lobe_sh::{Dir, Expansion as _, Rgb, Rotation, Window};
use lobe_testkit::fibonacci_sphere;

/// Bands of the rest: the irradiance of a smooth sky has none above.
const ORDER: usize = 12;

/// A blue sky over brown ground with a sun of a few texels.
fn sunny() -> EnvMap {
    let sun = Dir::from_angles(0.7, 0.4);
    EnvMap::from_fn(512, 256, |s| {
        let sky = if s.z() > 0.0 { Rgb::new(0.3, 0.5, 0.9) } else { Rgb::new(0.2, 0.15, 0.1) };
        if s.angle_to(sun) < 0.02 { Rgb::new(9000.0, 8000.0, 6000.0) } else { sky }
    })
}

fn of(map: &EnvMap, order: usize, choice: &SunChoice) -> SceneLight {
    SceneLight::of_map(map, order, choice).unwrap()
}

#[test]
fn suns_and_rest_give_the_irradiance_of_the_map_in_every_direction() {
    for (name, map) in [("sunny", sunny()), ("sunset", bundled::sunset().map())] {
        let light = of(&map, ORDER, &SunChoice::Auto);
        let normals: Vec<Dir> = fibonacci_sphere(200).into_iter().map(|s| Dir::new(s).unwrap()).collect();
        let exact = irradiance_at(&map, &normals);
        let largest = exact.iter().map(|e| e.luminance()).fold(0.0, f64::max);
        for (n, exact) in normals.iter().zip(exact) {
            let error = (light.irradiance(*n).luminance() - exact.luminance()).abs() / largest;
            assert!(error < 1e-3, "{name} towards {n:?}: {error}");
        }
    }
}

#[test]
fn the_expansion_of_all_parts_is_that_of_the_map() {
    let map = sunny();
    let light = of(&map, 6, &SunChoice::Auto);
    let (whole, expected) = (light.whole(), project_env(&map, 6));
    assert_eq!(light.suns().len(), 1, "{:?}", light.suns());
    let size = expected.coefficients().iter().map(|c| c.luminance().powi(2)).sum::<f64>().sqrt();
    for (i, (a, b)) in whole.coefficients().iter().zip(expected.coefficients()).enumerate() {
        // The disc has not the outline of the texels.
        assert!((a.luminance() - b.luminance()).abs() < 1e-4 * size, "{i}: {a:?} {b:?}");
    }
}

#[test]
fn a_map_without_suns_is_projected_to_the_same_bits() {
    let map = EnvMap::from_fn(64, 32, |s| Rgb::new(1.0, 1.0, 1.0 + s.z() as f32));
    for choice in [SunChoice::Auto, SunChoice::None, SunChoice::Count(0), SunChoice::Count(3)] {
        let light = of(&map, 4, &choice);
        assert!(light.suns().is_empty() && light.whole() == project_env(&map, 4), "{choice}");
    }
    let none = of(&sunny(), 4, &SunChoice::None);
    assert!(none.suns().is_empty() && none.rest() == &project_env(&sunny(), 4), "none");
}

#[test]
fn faint_lamps_stay_in_the_map_unless_they_are_asked_for() {
    let lamp = Dir::from_angles(1.2, 2.0);
    let map = EnvMap::from_fn(512, 256, |s| {
        if s.angle_to(lamp) < 0.01 { Rgb::new(150.0, 150.0, 150.0) } else { Rgb::new(1.0, 1.0, 1.0) }
    });
    let part = |light: &SceneLight| light.suns()[0].irradiance.g / (4.0 * PI * map.mean().g);
    assert!(of(&map, 4, &SunChoice::Auto).suns().is_empty(), "less than half a percent");
    let asked = of(&map, 4, &SunChoice::Count(1));
    assert!(part(&asked) > 1e-3 && part(&asked) < 5e-3, "{}", part(&asked));
}

#[test]
fn a_glint_that_is_brighter_than_the_sun_does_not_hide_it() {
    let (map, glint) = (sunny(), Dir::from_angles(1.1, -2.0));
    let mut with_glint = map.clone();
    let (x, y) = with_glint.texel_at(glint);
    with_glint.texels_mut()[y * 512 + x] = Rgb::new(2e4, 2e4, 2e4);
    let light = of(&with_glint, 4, &SunChoice::Auto);
    assert!(light.suns().iter().any(|sun| sun.direction.angle_to(Dir::from_angles(0.7, 0.4)) < 0.02), "{light:?}");
}

#[test]
fn a_window_is_on_the_expansion_of_suns_too() {
    let light = of(&sunny(), 4, &SunChoice::Auto);
    let window = Window::Hanning { width: 4.0 };
    let (windowed, expected) = (light.clone().windowed(&window), light.whole().windowed(&window));
    for (a, b) in windowed.whole().coefficients().iter().zip(expected.coefficients()) {
        assert!((a.g - b.g).abs() < 1e-12 * expected[0].g.abs(), "{a:?} {b:?}");
    }
    assert_eq!(windowed.suns(), light.suns(), "suns themselves");
}

#[test]
fn light_turns_with_its_suns() {
    let (light, turn) = (of(&sunny(), 5, &SunChoice::Auto), Rotation::from_axis_angle(Dir::X, 0.8));
    let turned = light.rotated(&turn);
    for s in fibonacci_sphere(50).into_iter().map(|s| Dir::new(s).unwrap()).chain([light.suns()[0].direction]) {
        let (a, b) = (light.radiance(s), turned.radiance(turn.rotate_dir(s)));
        assert!((a.g - b.g).abs() < 1e-9 * (1.0 + a.g.abs()), "{s:?}: {a:?} {b:?}");
    }
}

#[test]
fn suns_are_read_from_what_is_printed_of_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("suns.json");
    let suns = of(&sunny(), 3, &SunChoice::Auto).suns().to_vec();
    let records: Vec<SunRecord> = suns.iter().map(|sun| SunRecord::from(*sun)).collect();
    let read = |text: String| {
        std::fs::write(&path, text).unwrap();
        read_suns(&path)
    };
    for text in [serde_json::to_string(&records[0]).unwrap(), serde_json::json!({ "suns": records }).to_string()] {
        let found = read(text).unwrap();
        let Sun { direction, irradiance, angular_diameter, .. } = found[0];
        assert_eq!(irradiance, suns[0].irradiance, "one sun");
        assert!(direction.angle_to(suns[0].direction) < 1e-12, "{direction:?}");
        assert!((angular_diameter / suns[0].angular_diameter - 1.0).abs() < 1e-12, "{angular_diameter}");
    }
    let marked = read("\u{feff}{\"direction\": [0, 0, 1], \"irradiance\": [1, 1, 1]}".to_owned()).unwrap();
    assert_eq!(marked.len(), 1, "after a mark of byte order");
    let short = read(r#"{"direction": [0, 0, 2], "irradiance": [1, 2, 3]}"#.to_owned()).unwrap();
    assert!((short[0].angular_diameter.to_degrees() - 0.533).abs() < 1e-3, "as large as the sun: {short:?}");
    for (text, expected) in [
        ("", "expected {\"direction\""),
        ("{\"suns\": 3}", "invalid type: integer `3`, expected a sequence"),
        (r#"{"direction": [0, 0, 1], "irradiance": [1, 1]}"#, "invalid length 2"),
        (r#"{"direction": [0, 0, 1], "irradiance": [1, 1, 1], "width": 1}"#, "unknown field `width`"),
        (r#"{"direction": [0, 0, 1], "irradiance": [1, 1, 1], "diameter": 180}"#, "sun 0: expected a diameter above 0"),
        (r#"{"direction": [0, 0, 0], "irradiance": [1, 1, 1]}"#, "sun 0: expected a direction, found 0,0,0"),
        (r#"{"direction": [0, 0, 1], "irradiance": [1, -1, 1]}"#, "sun 0: expected an irradiance of at least 0"),
        (r#"{"direction": [0, 0, 1], "irradiance": [1, 1, 1], "diameter": 0}"#, "sun 0: expected a diameter above 0"),
    ] {
        let error = read(text.to_owned()).unwrap_err();
        assert!(matches!(error, EnvError::File(_)) && error.to_string().contains(expected), "{text}: {error}");
    }
    let missing = SceneLight::of_map(&sunny(), 3, &SunChoice::File(folder.path().join("none.json")));
    assert!(matches!(missing, Err(EnvError::File(_))), "{missing:?}");
    let of_expansion = SceneLight::of_expansion(project_env(&sunny(), 3), &SunChoice::Count(1)).unwrap_err();
    assert!(of_expansion.to_string().starts_with("an expansion holds no suns"), "{of_expansion}");
}
