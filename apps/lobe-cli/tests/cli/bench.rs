//! `lobe bench`: what it prints, and what it refuses. The times themselves are no test.

use serde_json::Value;

use crate::harness::Dir;

#[test]
fn jobs_are_measured_beside_their_floors() {
    let dir = Dir::new();
    let printed: Value =
        serde_json::from_str(&dir.lobe("bench product square --seconds 0.001 --json").stdout()).unwrap();
    for rate in ["gflops", "store_first_level", "copy_second_level", "store", "read"] {
        assert!(printed["machine"][rate].as_f64().unwrap() > 0.0, "{rate}: {printed}");
    }
    let jobs = printed["jobs"].as_array().unwrap();
    let names: Vec<_> = jobs.iter().map(|job| (job["job"].as_str().unwrap(), job["order"].as_u64().unwrap())).collect();
    let expected = ["product", "square"].into_iter().flat_map(|name| [3, 4, 6].map(|order| (name, order)));
    assert_eq!(names, expected.collect::<Vec<_>>(), "the jobs that are asked for");
    for job in jobs {
        let [time, floor, ratio] = ["nanoseconds", "floor", "ratio"].map(|key| job[key].as_f64().unwrap());
        assert!(floor > 0.0 && (time / floor / ratio - 1.0).abs() < 1e-9, "{job}");
    }
}

#[test]
fn the_table_has_a_line_for_each_job_and_says_by_what_it_is_bound() {
    let dir = Dir::new();
    let text = dir.lobe("bench rotation --seconds 0.001 --quiet").stdout();
    assert!(text.starts_with("one thread, ") && text.contains("GFLOP/s"), "{text}");
    let lines: Vec<_> = text.lines().filter(|line| line.starts_with("rotation  ")).collect();
    assert_eq!(lines.len(), 3, "{text}");
    assert!(lines.iter().all(|line| line.contains("second-level cache") || line.contains("arithmetic")), "{text}");
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let dir = Dir::new();
    let line = dir.lobe("bench fly --seconds 0.001").error();
    assert!(line.contains(r#"found ["fly"]; jobs: basis, basis-streamed, product"#), "{line}");
    assert!(dir.lobe("bench --seconds 0").error().contains("--seconds"), "no time");
    assert!(dir.lobe("bench --seconds 1e300").error().contains("--seconds"), "too much time");
}
