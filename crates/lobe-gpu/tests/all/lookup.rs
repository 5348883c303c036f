//! Basis, irradiance, environments and their reflection towards the whole sphere.

use lobe_env::{CubeMipChain, DfgTable, MappedMap, Mapping, RoughnessLevels};
use lobe_gpu::{Environment, SplitSum, Storage, basis_towards, irradiance_towards};
use lobe_sh::{Coefficient as _, Dir, PackedIrradiance, Rgb, Rotation, ShL2, eval_basis};
use lobe_testkit::Random;

use crate::{TOLERANCE, device, directions, flat3, relative_difference};

fn dir(s: [f32; 3]) -> Dir {
    Dir::new(s.map(f64::from)).unwrap()
}

#[test]
fn basis_is_that_of_the_processor() {
    let Some(context) = device("basis_is_that_of_the_processor") else { return };
    let dirs = directions();
    for order in 1..=8 {
        let found = basis_towards(&context, order, &dirs).unwrap();
        let expected: Vec<f64> = dirs.iter().flat_map(|s| eval_basis(dir(*s), order)).collect();
        let worst = found.iter().zip(&expected).map(|(f, e)| (f64::from(*f) - e).abs()).fold(0.0, f64::max);
        assert!(worst < 2e-6, "order {order}: {worst:e}");
    }
    assert!(basis_towards(&context, 9, &dirs).is_err(), "order 9 has no code");
    assert!(basis_towards(&context, 3, &[]).unwrap().is_empty(), "no directions");
}

#[test]
fn irradiance_is_that_of_the_processor() {
    let Some(context) = device("irradiance_is_that_of_the_processor") else { return };
    let mut random = Random::new(3);
    let mut light = ShL2::<Rgb<f64>>::zero();
    for i in 0..9 {
        light[i] = Rgb::new(random.signed(), random.signed(), random.signed());
    }
    let packed = PackedIrradiance::from_radiance_sh(&light);
    let dirs = directions();
    let found = irradiance_towards(&context, &packed, &dirs).unwrap();
    let expected = dirs.iter().flat_map(|n| packed.eval(dir(*n)).to_array());
    let worst = relative_difference(flat3(&found), expected);
    assert!(worst < 2e-6, "{worst:e}");
}

/// Every texel another color, so that a wrong neighbor shows.
fn noise(mapping: Mapping, width: usize, height: usize) -> MappedMap {
    let mut random = Random::new(11);
    let texels = (0..width * height)
        .map(|_| Rgb::new(random.unit() as f32, random.unit() as f32, 0.5 + 0.5 * random.unit() as f32))
        .collect();
    MappedMap::new(mapping, width, height, texels).unwrap()
}

#[test]
fn lookups_in_every_mapping_are_those_of_the_processor() {
    let Some(context) = device("lookups_in_every_mapping_are_those_of_the_processor") else { return };
    let mut dirs = directions();
    dirs.extend(lobe_testkit::fibonacci_sphere(3000).into_iter().map(|s| s.map(|c| c as f32)));
    for mapping in Mapping::ALL {
        for width in [1, 2, 16, 63] {
            let map = noise(mapping, width, mapping.height_for(width));
            let found = Environment::from(&map).radiance_towards(&context, &dirs, 0.0).unwrap();
            let expected: Vec<[f32; 3]> = dirs.iter().map(|s| map.radiance(dir(*s)).to_array()).collect();
            let worst = relative_difference(flat3(&found), flat3(&expected));
            assert!(worst < TOLERANCE, "{mapping}, {width}: {worst:e}");
        }
    }
}

#[test]
fn a_turned_environment_shows_towards_the_turned_direction_what_it_showed() {
    let name = "a_turned_environment_shows_towards_the_turned_direction_what_it_showed";
    let Some(context) = device(name) else { return };
    let map = noise(Mapping::LatLong, 16, 8);
    let turn = Rotation::from_euler_zyz(0.4, 1.1, -2.0);
    let dirs: Vec<[f32; 3]> = lobe_testkit::fibonacci_sphere(500).into_iter().map(|s| s.map(|c| c as f32)).collect();
    let turned: Vec<[f32; 3]> = dirs.iter().map(|s| turn.rotate_dir(dir(*s)).to_array().map(|c| c as f32)).collect();
    let found = Environment::from(&map).turned(turn).radiance_towards(&context, &turned, 0.0).unwrap();
    let expected: Vec<[f32; 3]> = dirs.iter().map(|s| map.radiance(dir(*s)).to_array()).collect();
    let worst = relative_difference(flat3(&found), flat3(&expected));
    assert!(worst < TOLERANCE, "{worst:e}");
}

#[test]
fn half_precision_texels_are_within_their_eleven_bits() {
    let Some(context) = device("half_precision_texels_are_within_their_eleven_bits") else { return };
    let (map, dirs) = (noise(Mapping::Octahedral, 16, 16), directions());
    let environment = Environment::from(&map);
    let full = environment.radiance_towards(&context, &dirs, 0.0).unwrap();
    let half = environment.stored(Storage::F16).radiance_towards(&context, &dirs, 0.0).unwrap();
    let worst = relative_difference(flat3(&half), flat3(&full));
    assert!(worst > 1e-5 && worst < 0.5_f64.powi(11), "{worst:e}");
}

#[test]
fn the_split_sum_is_that_of_the_processor_between_levels_and_beyond_them() {
    let name = "the_split_sum_is_that_of_the_processor_between_levels_and_beyond_them";
    let Some(context) = device(name) else { return };
    let levels = [16, 8, 4].map(|size| noise(Mapping::Cube, size, 6 * size).into_cube_map().unwrap());
    let chain = CubeMipChain::new(levels.to_vec()).unwrap();
    let normals: Vec<[f32; 3]> = directions();
    let mut random = Random::new(5);
    let views: Vec<[f32; 3]> = normals
        .iter()
        .map(|n| {
            let side = [random.signed(), random.signed(), random.signed()];
            let v = [0, 1, 2].map(|k| 1.2 * f64::from(n[k]) + 0.6 * side[k]);
            Dir::new(v).unwrap().to_array().map(|c| c as f32)
        })
        .collect();
    let (dfg, f0) = (DfgTable::new(16), [0.9, 0.5, 0.04]);
    for spacing in [RoughnessLevels::Linear, RoughnessLevels::Quadratic] {
        let split = SplitSum { environment: Environment::of_levels(&chain, spacing).unwrap(), dfg: dfg.clone() };
        for roughness in [0.0_f32, 0.3, 0.5, 0.85, 1.0] {
            let found = split.reflected_towards(&context, &normals, &views, roughness, f0).unwrap();
            let level = spacing.level_for_roughness(f64::from(roughness), 3);
            let expected: Vec<f64> = normals
                .iter()
                .zip(&views)
                .flat_map(|(n, v)| {
                    let (n, v) = (dir(*n), dir(*v));
                    let cosine = n.dot(v);
                    let twice = [0, 1, 2].map(|k| 2.0 * cosine * n.to_array()[k] - v.to_array()[k]);
                    let r = Dir::new(twice).unwrap();
                    let (low, t) = ((level as usize).min(1), level - (level as usize).min(1) as f64);
                    let at = |k: usize| chain.levels()[k].radiance(r).widen();
                    let light = at(low).scale(1.0 - t) + at(low + 1).scale(t);
                    (light * dfg.lookup(cosine, f64::from(roughness)).reflectance(Rgb::from(f0).widen())).to_array()
                })
                .collect();
            let worst = relative_difference(flat3(&found), expected);
            assert!(worst < TOLERANCE, "{spacing:?}, roughness {roughness}: {worst:e}");
        }
    }
}

#[test]
fn every_module_can_be_had_and_names_what_it_needs() {
    for name in lobe_gpu::wgsl_modules() {
        let text = lobe_gpu::wgsl_module(name).unwrap();
        let first = text.lines().next().unwrap();
        assert!(first.starts_with("//"), "{name} begins with {first}");
        for used in first.strip_prefix("// uses: ").into_iter().flat_map(|list| list.split(", ")) {
            assert!(lobe_gpu::wgsl_module(used).is_some(), "{name} uses {used}");
        }
    }
    assert!(lobe_gpu::wgsl_module("no such module").is_none(), "unknown names have no text");
}
