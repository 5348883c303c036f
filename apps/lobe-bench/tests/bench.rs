//! Output of the program, and its refusals. The times themselves are no test.

#![allow(clippy::unwrap_used, reason = "a helper of a test that cannot do its work has found a failure")]

use std::path::Path;
use std::process::{Command, Output};

use lobe::scene::Bvh;
use serde_json::Value;

/// Runs the program with these arguments.
fn run(args: &str, folder: &Path) -> (Option<i32>, [String; 2]) {
    let mut program = Command::new(env!("CARGO_BIN_EXE_lobe-bench"));
    let output = program.args(args.split_whitespace()).current_dir(folder).output().unwrap();
    let Output { status, stdout, stderr } = output;
    (status.code(), [stdout, stderr].map(|bytes| String::from_utf8(bytes).unwrap()))
}

/// What it prints with these arguments; nothing is wrong.
fn printed_in(folder: &Path, args: &str) -> String {
    let (code, [stdout, stderr]) = run(args, folder);
    assert_eq!((code, stderr.as_str()), (Some(0), ""), "{args}");
    stdout
}

fn printed(args: &str) -> String {
    printed_in(".".as_ref(), args)
}

/// Its message where something is wrong.
fn refusal_in(folder: &Path, args: &str) -> String {
    let (code, [stdout, stderr]) = run(args, folder);
    assert_eq!((code, stdout.as_str()), (Some(2), ""), "{args}: {stderr}");
    stderr
}

fn refusal(args: &str) -> String {
    refusal_in(".".as_ref(), args)
}

#[test]
fn jobs_are_measured_beside_their_floors() {
    let printed: Value = serde_json::from_str(&printed("product square --seconds 0.001 --json")).unwrap();
    let caches = ["store_first_level", "copy_first_level", "store_second_level", "copy_second_level"];
    for rate in
        ["gigahertz", "gflops", "each_cycle", "first_level", "store", "store_past_caches", "read"].iter().chain(&caches)
    {
        assert!(printed["machine"][rate].as_f64().unwrap() > 0.0, "{rate}: {printed}");
    }
    let jobs = printed["jobs"].as_array().unwrap();
    let names: Vec<_> = jobs.iter().map(|job| (job["job"].as_str().unwrap(), job["order"].as_u64().unwrap())).collect();
    let expected = ["product", "square", "zonal-product", "product-one"]
        .into_iter()
        .flat_map(|name| [3, 4, 6].map(|order| (name, order)));
    assert_eq!(names, expected.collect::<Vec<_>>(), "the jobs that are asked for");
    for job in jobs {
        let [time, floor, ratio] = ["nanoseconds", "floor", "ratio"].map(|key| job[key].as_f64().unwrap());
        assert!(floor > 0.0 && (time / floor / ratio - 1.0).abs() < 1e-9, "{job}");
    }
}

#[test]
fn the_table_has_a_line_for_each_job_and_says_by_what_it_is_bound() {
    let text = printed("rotation --seconds 0.001 --quiet");
    assert!(text.starts_with("one thread, ") && text.contains("GFLOP/s"), "{text}");
    let lines: Vec<_> = text.lines().filter(|line| line.starts_with("rotation  ")).collect();
    assert_eq!(lines.len(), 3, "{text}");
    let bounds = ["first-level cache", "second-level cache", "arithmetic"];
    assert!(lines.iter().all(|line| bounds.iter().any(|bound| line.contains(bound))), "{text}");
}

#[test]
#[ignore = "long: of the nightly group"]
fn rays_that_are_written_find_what_the_file_says() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    printed_in(folder, "occlusion --seconds 0.001 --rays rays.safetensors");
    let bytes = std::fs::read(folder.join("rays.safetensors")).unwrap();
    let (header, numbers) =
        bytes[8..].split_at(usize::try_from(u64::from_le_bytes(bytes[..8].try_into().unwrap())).unwrap());
    let header: Value = serde_json::from_slice(header).unwrap();
    let tensor = |name: &str| {
        let at = |k: usize| usize::try_from(header[name]["data_offsets"][k].as_u64().unwrap()).unwrap();
        &numbers[at(0)..at(1)]
    };
    let vectors = |name: &str| -> Vec<[f32; 3]> {
        let floats = tensor(name).as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect::<Vec<_>>();
        floats.as_chunks::<3>().0.to_vec()
    };
    let (corners, points, directions) = (vectors("corners"), vectors("points"), vectors("directions"));
    let bvh = Bvh::from_corners(corners.as_chunks::<3>().0);
    let mut hidden = vec![false; directions.len()];
    let mut all = Vec::new();
    for point in points {
        bvh.occluded_from_into(point, &directions, &mut hidden);
        all.extend(hidden.iter().map(|&h| u8::from(h)));
    }
    let part = all.iter().map(|&h| f64::from(h)).sum::<f64>() / all.len() as f64;
    assert!(
        (0.2..0.8).contains(&part),
        "{part} of the rays are hidden: the ground hides the lower half, the knot some more"
    );
    assert!(all == tensor("hidden"), "{part} of the rays are hidden, the file says otherwise");
    let line = refusal_in(folder, "basis --seconds 0.001 --rays rays.safetensors");
    assert!(line.contains("--rays: expected occlusion among the jobs"), "{line}");
    let line = refusal_in(folder, "basis occlusion --order 3 --seconds 0.001 --rays rays.safetensors");
    assert!(line.contains("--rays: expected occlusion among the jobs"), "rays have no order: {line}");
}

#[test]
fn an_order_picks_among_the_jobs_and_a_count_does_each_of_them_once() {
    let lines = |args: &str| printed(&format!("--counted {args}"));
    assert_eq!(lines("basis product --order 4"), "basis 4\nproduct 4\n", "whole names, so no other basis or product");
    assert_eq!(lines("irradiance dering"), "irradiance 3\ndering 3\n");
    assert_eq!(lines("multiply-adds"), "multiply-adds\n", "the probe of arithmetic");
    let line = refusal("product --order 5 --seconds 0.001");
    assert!(line.contains(r#"expected a word in the name of a job of order 5, found ["product"]"#), "{line}");
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let line = refusal("fly --seconds 0.001");
    assert!(line.contains(r#"found ["fly"]; jobs: basis, basis-streamed, eval, product"#), "{line}");
    assert!(refusal("--seconds 0").contains("--seconds"), "no time");
    assert!(refusal("--seconds 1e300").contains("--seconds"), "too much time");
}
