//! Exports for engines: what the files hold, by the formulas with which engines read them.

use std::f64::consts::{FRAC_1_PI, PI};
use std::path::PathBuf;

use lobe_env::{
    Engine, EngineFacts, ExportOptions, ExportedFile, MapReadOptions, MappedMap, Mapping, RoughnessLevels, SunChoice,
    SunRecord, export_light, exported_files, import_coefficients, project_map, read_map_bytes,
};
use lobe_image::ktx_sh;
use lobe_io::Job;
use lobe_sh::encoding::EngineForm;
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, ShL2, Zonal};
use lobe_testkit::directions;

/// Light that differs in every direction, without any below 0.
fn sky() -> MappedMap {
    let radiance = |s: Dir| {
        let [x, y, z] = s.to_array();
        let colors = [1.5 + x + 0.3 * y * z, 1.4 + y + 0.3 * x * z, 1.3 + z + 0.2 * (x * x - y * y)];
        Rgb::from(colors.map(|c| c as f32))
    };
    MappedMap::from_fn(Mapping::LatLong, 256, 128, radiance)
}

fn options() -> ExportOptions {
    ExportOptions::default().size(32)
}

fn exported(map: &MappedMap, engine: Engine, options: &ExportOptions) -> Vec<ExportedFile> {
    exported_files(map, engine, "sky", options, Job::default()).unwrap()
}

fn bytes<'a>(files: &'a [ExportedFile], name: &str) -> &'a [u8] {
    &files.iter().find(|file| file.name == name).unwrap_or_else(|| panic!("no file {name}")).bytes
}

fn read(files: &[ExportedFile], name: &str) -> MappedMap {
    read_map_bytes(bytes(files, name), name, &MapReadOptions::default()).unwrap().0.into_base()
}

fn difference(a: Rgb<f32>, b: Rgb<f32>) -> f32 {
    (a - b).to_array().into_iter().fold(0.0, |worst, e| worst.max(e.abs()))
}

/// Where an engine looks a direction of its own frame up in a lat-long picture, by the formula of its source.
fn looked_up(engine: Engine, [x, y, z]: [f64; 3]) -> (f64, f64) {
    let around = |a: f64, b: f64| a.atan2(b) / (2.0 * PI);
    match engine {
        Engine::Three => (0.5 + around(z, x), y.acos() / PI),
        Engine::Godot | Engine::Mitsuba => (around(x, -z), y.acos() / PI),
        Engine::Blender => (0.5 - around(y, x), z.acos() / PI),
        // Of pictures that are imported as cubes.
        Engine::Unity => (0.75 - around(z, x), y.acos() / PI),
        Engine::Unreal => (0.5 + around(x, -y), z.acos() / PI),
        other => panic!("no formula of {other}"),
    }
}

#[test]
fn panoramas_show_every_direction_where_the_engine_looks_it_up() {
    let sky = sky();
    for (engine, name) in [
        (Engine::Three, "sky.hdr"),
        (Engine::Godot, "light.hdr"),
        (Engine::Mitsuba, "sky.exr"),
        (Engine::Blender, "sky.exr"),
        (Engine::Unity, "sky.hdr"),
        (Engine::Unreal, "light.hdr"),
    ] {
        let picture = read(&exported(&sky, engine, &options()), name);
        for s in directions().into_iter().map(Dir::from_unit) {
            let (u, v) = looked_up(engine, engine.facts().frame.dir(s).to_array());
            let (x, y) = (u.rem_euclid(1.0) * picture.width() as f64, v * picture.height() as f64);
            let found = picture.texel((x as usize).min(picture.width() - 1), (y as usize).min(picture.height() - 1));
            let error = difference(found, sky.radiance(s));
            // Half a texel of 1/40 and the eight bits of .hdr.
            assert!(error < 0.04, "{engine}, {s:?}: {found:?}, expected {:?}", sky.radiance(s));
        }
    }
}

#[test]
fn coefficients_light_a_white_surface_as_the_map_does() {
    let sky = sky();
    let irradiance = project_map(&sky, 3).convolved(&Zonal::clamped_cosine(3));
    let expect = |light: &ShL2<Rgb<f64>>, most: f64, what: &str| {
        let found = light.convolved(&Zonal::clamped_cosine(3));
        for n in directions().into_iter().map(Dir::from_unit) {
            let error =
                (found.eval(n) - irradiance.eval(n)).to_array().into_iter().fold(0.0, |w: f64, e| w.max(e.abs()));
            assert!(error < most, "{what}, {n:?}: {:?}, expected {:?}", found.eval(n), irradiance.eval(n));
        }
    };
    for (engine, name) in [
        (Engine::Three, "light-probe.json"),
        (Engine::Babylon, "coefficients.json"),
        (Engine::PlayCanvas, "coefficients.json"),
        (Engine::Filament, "sh.txt"),
        (Engine::Godot, "coefficients.json"),
        (Engine::Unity, "coefficients.json"),
        (Engine::Unreal, "coefficients.json"),
    ] {
        let (files, form) = (exported(&sky, engine, &options()), engine.facts().form.unwrap());
        expect(&import_coefficients(bytes(&files, name), form, name).unwrap(), 1e-12, engine.name());
    }
    let files = exported(&sky, Engine::Filament, &options());
    let ktx = bytes(&files, "light.ktx");
    expect(&import_coefficients(ktx, EngineForm::Filament, "light.ktx").unwrap(), 1e-12, "the key sh");
    assert!(ktx_sh(bytes(&files, "sky.ktx"), "sky.ktx").unwrap().is_none(), "a sky has no such key");
    let files = exported(&sky, Engine::Babylon, &options());
    let light = import_coefficients(bytes(&files, "light.env"), EngineForm::Babylon, "light.env").unwrap();
    expect(&light, 1e-12, "the polynomial of .env");
}

#[test]
fn diffuse_cubes_hold_irradiance_over_pi() {
    let sky = sky();
    let irradiance = project_map(&sky, 3).convolved(&Zonal::clamped_cosine(3));
    for engine in [Engine::Bevy, Engine::Khronos] {
        // The file says for which handedness its faces are.
        let cube = read(&exported(&sky, engine, &options()), "diffuse.ktx2");
        for n in directions().into_iter().map(Dir::from_unit) {
            let expected = Rgb::narrow(irradiance.eval(n).scale(FRAC_1_PI));
            let found = cube.radiance(n);
            assert!(difference(found, expected) < 2e-3, "{engine}, {n:?}: {found:?}, expected {expected:?}");
        }
    }
}

#[test]
fn chains_have_the_levels_of_the_engine() {
    let sky = sky();
    for (engine, name, levels) in [
        (Engine::Three, "specular.ktx2", 3),
        (Engine::Filament, "light.ktx", 2),
        (Engine::Bevy, "specular.ktx2", 2),
        (Engine::Khronos, "specular.ktx2", 2),
    ] {
        let files = exported(&sky, engine, &options());
        let report = read_map_bytes(bytes(&files, name), name, &MapReadOptions::default()).unwrap().1;
        assert_eq!(report.picture.levels, levels, "{engine}");
    }
    let env = exported(&sky, Engine::Babylon, &options());
    let text = String::from_utf8_lossy(bytes(&env, "light.env")).into_owned();
    assert_eq!(text.matches("\"length\"").count(), 6 * 6, "Babylon.js reads levels down to one texel");
    // Level 4 of six holds α = 2^5/2^5, more than the roughest.
    assert_eq!(RoughnessLevels::Babylon.roughness_of_level(4, 6), 1.0);
}

#[test]
fn suns_for_which_an_engine_has_no_light_stay_in_its_pictures() {
    let mut bright = sky();
    let width = bright.width();
    for (sun, radiance) in [([0.6, 0.5, 0.62], 4000.0), ([-0.5, 0.6, 0.62], 2000.0)] {
        let (x, y) = bright.texel_at(Dir::new(sun).unwrap());
        bright.texels_mut()[y * width + x] = Rgb::splat(radiance);
    }
    for engine in Engine::ALL {
        let EngineFacts { traces_paths, most_suns, .. } = engine.facts();
        let expected = if traces_paths { 0 } else { most_suns.unwrap_or(2).min(2) };
        let files = exported(&bright, engine, &options());
        let text = String::from_utf8_lossy(bytes(&files, "README.md")).into_owned();
        let apart = text.split_once("Suns apart: ").map_or(0, |(_, rest)| rest[..1].parse().unwrap());
        assert_eq!(apart, expected, "{engine}: {text}");
        // What lights the scene has the others.
        let light = files.iter().find(|file| ["specular.ktx2", "light.ktx"].contains(&&*file.name));
        if let Some(light) = light {
            let most = read(&files, &light.name).texels().iter().map(|t| t.g).max_by(f32::total_cmp).unwrap();
            assert_eq!(most > 20.0, expected < 2, "{engine}: {most}");
        }
    }
}

#[test]
fn suns_are_lights_of_engines_and_stay_in_the_picture_of_programs_that_trace_paths() {
    let mut bright = sky();
    let sun = Dir::new([0.6, 0.5, 0.62]).unwrap();
    let (x, y) = bright.texel_at(sun);
    let width = bright.width();
    bright.texels_mut()[y * width + x] = Rgb::splat(4000.0);
    let text =
        |engine, name: &str| String::from_utf8(bytes(&exported(&bright, engine, &options()), name).to_vec()).unwrap();
    let [x, y, z] = sun.to_array();
    // Frames: y up, y up with x turned around, z up with y turned around.
    for (engine, name, expected) in [
        (Engine::Three, "sky.mjs", [x, z, -y]),
        (Engine::Babylon, "sky.mjs", [-x, z, -y]),
        (Engine::Godot, "sky.gd", [x, z, -y]),
        (Engine::Unreal, "sky.py", [x, -y, z]),
    ] {
        let program = text(engine, name);
        let (_, found) = program.split_once("\"direction\":[").unwrap_or_else(|| panic!("{engine}: no sun"));
        let numbers = found.split(']').next().unwrap().split(',').map(|x| x.parse::<f64>().unwrap());
        let error = numbers.zip(expected).map(|(a, b)| (a - b).abs()).max_by(f64::total_cmp).unwrap();
        assert!(error < 0.02, "{engine}: {found}");
    }
    for engine in [Engine::Blender, Engine::Mitsuba] {
        assert!(text(engine, "sky.py").contains("SUNS = []"), "{engine} has a sun twice");
    }
    let brightest = |engine, name| {
        let map = read(&exported(&bright, engine, &options()), name);
        map.texels().iter().map(|t| t.g).fold(0.0, f32::max)
    };
    assert!(brightest(Engine::Three, "sky.hdr") > 3000.0, "the sky has its sun");
    assert!(brightest(Engine::Godot, "light.hdr") < 5.0, "what lights the scene beside the sun has none");
    assert!(brightest(Engine::Three, "specular.ktx2") < 5.0, "nor has the mirror");
}

#[test]
fn suns_of_a_file_are_lights_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("suns.json");
    std::fs::write(&path, serde_json::to_vec(&SunRecord::new([0.0, 0.0, 1.0], [3.0, 2.0, 1.0], 0.5)).unwrap()).unwrap();
    let options = options().suns(SunChoice::File(path));
    for (engine, name) in [(Engine::Three, "sky.mjs"), (Engine::Blender, "sky.py"), (Engine::Mitsuba, "sky.py")] {
        let files = exported(&sky(), engine, &options);
        let program = String::from_utf8(bytes(&files, name).to_vec()).unwrap();
        assert!(program.contains("\"irradiance\":[3.0,2.0,1.0]"), "{engine}: {program}");
    }
}

#[test]
fn every_engine_has_its_folder_and_programs_have_no_place_left_for_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let report = export_light(folder.path(), &sky(), &Engine::ALL, "sky", &options(), Job::default()).unwrap();
    let mut count = 0;
    for engine in Engine::ALL {
        for name in engine.files() {
            let path: PathBuf = folder.path().join(engine.name()).join(name);
            let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            count += 1;
            if let Ok(text) = String::from_utf8(bytes) {
                let is_left =
                    ["coefficients", "suns", "version"].iter().any(|place| text.contains(&format!("{{{{{place}")));
                assert!(!is_left, "{}: {text}", path.display());
                assert!(text.lines().all(|line| line.chars().count() <= 1000), "{}: a long line", path.display());
            }
        }
    }
    assert_eq!(report.files.len(), count, "files that were written");
}

#[test]
fn sizes_that_engines_do_not_read_are_refused() {
    for size in [0, 8, 100] {
        let error = exported_files(&sky(), Engine::Three, "sky", &options().size(size), Job::default()).unwrap_err();
        assert!(error.to_string().ends_with(&format!("not {size}")), "{error}");
    }
}
