//! The page of formats, `docs/guide/src/formats.md`, judged by readers that were written from it.
//!
//! The readers use a parser of JSON and, for the lightmap, a reader of OpenEXR; nothing of Lobe's. What they find is
//! compared with what Lobe wrote.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::{Path, PathBuf};

use lobe::prt::{
    BakeMode, BakeOptions, BakedGlb, Channels, CompressOptions, CompressedTransfer, HalfTransfer, Neighborhood,
    NeighborhoodGrid, Receivers, Recipe, Transfer, TransferMatrices, WeightBits, ZonalFitOptions, bake, fit_zonal,
    write_compressed_transfer, write_half_transfer, write_lightmap, write_matrices, write_neighborhood, write_transfer,
    write_zonal_transfer,
};
use lobe::scene::{Bounds, Bvh, built_in};
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::{ShFile, write_sh_json};
use lobe::sh::{Dir, Expansion as _, Rgb, ShVec};
use lobe::{io::Job, scene::Scene};
use lobe_testkit::Random;
use serde_json::Value;

mod by_hand;
mod moving;
mod moving_by_hand;

use by_hand::{Table, exit_radiance, read_checkpoint, read_glb, read_safetensors, read_sh_json, transfer_of};

/// Relative to the largest number: sums are made in another order, of `f32`.
const ROUNDING: f64 = 1e-5;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn random_transfer(order: usize, channels: Channels, receivers: usize) -> Transfer {
    let numbers = Random::new(7).signed_vec(order * order * channels.count() * receivers);
    Transfer::new(order, channels, numbers.iter().map(|x| *x as f32).collect()).unwrap()
}

fn random_light(order: usize) -> ShVec<Rgb<f64>> {
    let numbers = Random::new(8).signed_vec(3 * order * order);
    ShVec::from_vec(numbers.as_chunks::<3>().0.iter().map(|c| Rgb::from(*c)).collect()).unwrap()
}

fn rows(light: &ShVec<Rgb<f64>>) -> Vec<[f64; 3]> {
    light.coefficients().iter().map(|c| c.to_array()).collect()
}

/// What every receiver sends back of the light, by the reader's numbers and by Lobe.
fn compare_light(what: &str, about: &Value, table: &Table, light: &ShVec<Rgb<f64>>, expected: &[Rgb<f32>]) {
    let found: Vec<[f64; 3]> =
        transfer_of(about, table).iter().map(|row| exit_radiance(about, row, &rows(light))).collect();
    assert_eq!(found.len(), expected.len(), "{what}: receivers");
    let largest = expected.iter().flat_map(|b| b.to_array()).fold(0.0_f32, |a, b| a.max(b.abs()));
    for (r, (found, expected)) in found.iter().zip(expected).enumerate() {
        for (a, b) in found.iter().zip(expected.to_array()) {
            let error = (a - f64::from(b)).abs();
            assert!(error < ROUNDING * f64::from(largest), "{what}, receiver {r}: {found:?} against {expected:?}");
        }
    }
}

#[test]
fn an_expansion_is_read_from_the_page() {
    let folder = folder();
    let path = folder.path().join("light.sh.json");
    let light = random_light(3);
    write_sh_json(&path, &ShFile::new(Quantity::Radiance, light.clone())).unwrap();
    let (order, quantity, found) = read_sh_json(&path);
    assert_eq!((order, quantity.as_str()), (3, "radiance"), "order and quantity");
    assert_eq!(found, rows(&light), "every coefficient, to the last bit");
    let [x, y, z] = [0.48, -0.60, 0.64];
    let value: f64 = found.iter().zip(by_hand::basis([x, y, z])).map(|(c, y)| c[1] * y).sum();
    let expected = light.eval(Dir::new([x, y, z]).unwrap()).g;
    assert!((value - expected).abs() < 1e-13, "{value} against {expected}");
}

#[test]
fn plain_transfer_is_read_from_the_page() {
    let folder = folder();
    for channels in [Channels::Gray, Channels::Rgb] {
        let path = folder.path().join("t.safetensors");
        let (transfer, light) = (random_transfer(3, channels, 5), random_light(3));
        write_transfer(&path, &transfer, &Recipe::default(), Job::default()).unwrap();
        let (about, table) = read_safetensors(&path);
        assert_eq!(about["format"], "lobe-transfer", "{about}");
        let expected = transfer.exit_radiance(light.coefficients());
        compare_light(&format!("{channels:?}"), &about, &table, &light, &expected);
        let (halves, _) = HalfTransfer::new(&transfer).unwrap();
        write_half_transfer(&path, &halves, &Recipe::default()).unwrap();
        let (about, table) = read_safetensors(&path);
        let expected = halves.exit_radiance(light.coefficients());
        compare_light(&format!("{channels:?} in 16 bits"), &about, &table, &light, &expected);
    }
}

#[test]
fn compressed_transfer_is_read_from_the_page() {
    let folder = folder();
    for weights in [WeightBits::F32, WeightBits::U16, WeightBits::U8] {
        let path = folder.path().join("c.safetensors");
        let light = random_light(3);
        let options = CompressOptions::default().clusters(3).components(5).weights(weights);
        let transfer = random_transfer(3, Channels::Rgb, 40);
        let (compressed, _) = CompressedTransfer::new(&transfer, &options, Job::default()).unwrap();
        write_compressed_transfer(&path, &compressed, &Recipe::default()).unwrap();
        let (about, table) = read_safetensors(&path);
        let expected = compressed.exit_radiance(light.coefficients());
        compare_light(&format!("{weights:?}"), &about, &table, &light, &expected);
    }
}

#[test]
fn zonal_lobes_are_read_from_the_page() {
    let folder = folder();
    let path = folder.path().join("z.safetensors");
    let (transfer, light) = (random_transfer(3, Channels::Rgb, 6), random_light(3));
    let (zonal, _) = fit_zonal(&transfer, &ZonalFitOptions::default().lobes(2), Job::default()).unwrap();
    write_zonal_transfer(&path, &zonal, &Recipe::default()).unwrap();
    let (about, table) = read_safetensors(&path);
    assert_eq!((about["format"].as_str(), about["lobes"].as_u64()), (Some("lobe-zonal-transfer"), Some(2)), "{about}");
    compare_light("lobes", &about, &table, &light, &zonal.exit_radiance(light.coefficients()));
}

#[test]
fn matrices_are_read_from_the_page() {
    let folder = folder();
    let (light, points) = (random_light(2), 2 * 3 * 2);
    let numbers = Random::new(9).signed_vec(points * 3 * 16).iter().map(|x| *x as f32).collect();
    let matrices = TransferMatrices::new(2, Channels::Rgb, numbers).unwrap();
    let bounds = Bounds { min: [0.0, 0.0, 0.0], max: [1.0, 2.0, 3.0] };
    let grid = NeighborhoodGrid::new(bounds, [2, 3, 2]).unwrap();
    let paths = ["m", "g"].map(|name| folder.path().join(name));
    write_matrices(&paths[0], &matrices, &Recipe::default(), Job::default()).unwrap();
    write_neighborhood(&paths[1], &grid, &matrices, &Recipe::default(), Job::default()).unwrap();
    let (about, _) = read_safetensors(&paths[1]);
    assert_eq!(about["format"], "lobe-neighbourhood-transfer", "{about}");
    assert_eq!(about["grid"], serde_json::json!([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [2, 3, 2]]), "{about}");
    // Point (1, 2, 0) of the grid: x fastest.
    let (point, place) = (1 + 2 * 2, [1.0, 2.0, 0.0]);
    let neighborhood = Neighborhood::new(grid, matrices.clone()).unwrap();
    for (path, expected) in paths
        .iter()
        .zip([matrices.incident(point, light.coefficients()), neighborhood.incident(place, light.coefficients())])
    {
        let (_, table) = read_safetensors(path);
        let (shape, numbers) = &table["matrices"];
        assert_eq!(shape, &[points, 3, 4, 4], "points, channels, rows, columns");
        for (i, expected) in expected.coefficients().iter().enumerate() {
            let found = (0..4).map(|j| numbers[((point * 3 + 2) * 4 + i) * 4 + j] * light[j].b).sum::<f64>();
            assert!((found - expected.b).abs() < 1e-6, "row {i}, blue: {found} against {}", expected.b);
        }
    }
}

/// A scene of two meshes, and where its file is.
fn scene_and_path(folder: &tempfile::TempDir) -> (Scene, PathBuf) {
    (built_in::ball_over_ground(4), folder.path().join("baked.glb"))
}

#[test]
fn baked_scenes_are_read_from_the_page() {
    let folder = folder();
    let (scene, path) = scene_and_path(&folder);
    for (order, channels) in [(2, Channels::Gray), (3, Channels::Gray), (3, Channels::Rgb)] {
        let transfer = random_transfer(order, channels, scene.vertex_count());
        let light = random_light(order);
        BakedGlb::of_scene(&scene).write(&path, &transfer, &Recipe::default(), Job::default()).unwrap();
        let (about, table) = read_glb(&path);
        let expected = transfer.exit_radiance(light.coefficients());
        compare_light(&format!("order {order}, {channels:?}"), &about, &table, &light, &expected);
    }
}

#[test]
fn compressed_baked_scenes_are_read_from_the_page() {
    let folder = folder();
    let (scene, path) = scene_and_path(&folder);
    let (transfer, light) = (random_transfer(3, Channels::Rgb, scene.vertex_count()), random_light(3));
    for (components, weights) in [(0, WeightBits::F32), (3, WeightBits::F32), (4, WeightBits::U16), (5, WeightBits::U8)]
    {
        let options = CompressOptions::default().clusters(4).components(components).weights(weights);
        let (compressed, _) = CompressedTransfer::new(&transfer, &options, Job::default()).unwrap();
        BakedGlb::of_scene(&scene).write_compressed(&path, &compressed, &Recipe::default()).unwrap();
        let (about, table) = read_glb(&path);
        let expected = compressed.exit_radiance(light.coefficients());
        compare_light(&format!("{components} components, {weights:?}"), &about, &table, &light, &expected);
    }
}

#[test]
fn a_lightmap_is_read_from_the_page() {
    let folder = folder();
    let path = folder.path().join("map.exr");
    for channels in [Channels::Gray, Channels::Rgb] {
        let transfer = random_transfer(3, channels, 4 * 4);
        write_lightmap(&path, &transfer, &Recipe::default(), Job::default()).unwrap();
        let (about, planes) = read_exr(&path);
        assert_eq!((about["format"].as_str(), about["version"].as_u64()), (Some("lobe-lightmap"), Some(1)), "{about}");
        let names: &[&str] = if channels == Channels::Gray { &["Y"] } else { &["R", "G", "B"] };
        for (c, name) in names.iter().enumerate() {
            // Coefficient 7 at the texel in column 1 of row 2.
            let (texel, wanted) = (2 * 4 + 1, format!("sh07.{name}"));
            let (_, plane) = planes.iter().find(|(name, _)| *name == wanted).unwrap();
            assert_eq!(plane[texel], transfer.vector(texel, c)[7], "{wanted}");
        }
    }
}

/// The attribute `lobe`, and the channels by name.
fn read_exr(path: &Path) -> (Value, Vec<(String, Vec<f32>)>) {
    use exr::prelude::{AttributeValue, ReadChannels as _, ReadLayers as _, Text};
    let image = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let layer = image.all_attributes().from_file(path).unwrap().layer_data;
    let Some(AttributeValue::Text(about)) = layer.attributes.other.get(&Text::from("lobe")) else {
        panic!("an attribute lobe, of text: {:?}", layer.attributes);
    };
    let about = serde_json::from_slice(about.bytes()).unwrap();
    let channels = layer.channel_data.list.iter();
    (about, channels.map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect())).collect())
}

#[test]
fn a_checkpoint_is_laid_out_as_the_page_says() {
    let folder = folder();
    let path = folder.path().join("bake.checkpoint");
    let scene = built_in::ball_over_ground(4);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let options = BakeOptions::default().mode(BakeMode::Shadowed).order(2).samples(8).channels(Some(Channels::Gray));
    let job = Job::default().kept_in(&path);
    let (transfer, report) = bake(&scene, &Bvh::new(&scene), &receivers, &options, job).unwrap();
    let (kind, records) = read_checkpoint(&path);
    assert_eq!(kind, "PART", "the kind of work");
    let (mut rays, mut rows) = (0, Vec::new());
    for record in records {
        rays += u64::from_le_bytes(*record.first_chunk().unwrap());
        // Rays, the weight of the ends, and one number of reflections: 0.
        rows.extend(record[24..].as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)));
    }
    assert_eq!(rows, transfer.coefficients(), "four numbers for each receiver");
    assert_eq!(rays, report.rays, "rays of all records");
}
