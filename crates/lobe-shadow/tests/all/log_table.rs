//! The table of the logarithms of spheres, and exponentials of many functions at once.

use std::f64::consts::PI;
use std::fs;

use lobe_sh::batch::ShBatch;
use lobe_sh::exponential::{ExpMethod, Exponential, LOG_CLAMP, ZonalLogarithm};
use lobe_sh::{Dir, Expansion as _, ShVec, Zonal};
use lobe_shadow::{
    BatchExponential, LogTable, LogTableOptions, cached_log_table, read_log_table, read_log_table_bytes,
    write_log_table,
};
use lobe_testkit::Random;

#[test]
fn the_table_is_within_its_tolerance_of_the_logarithm() {
    let mut random = Random::new(1);
    for (order, tolerance) in [(1, 0.01), (3, 0.01), (4, 0.05), (6, 0.01)] {
        let table = LogTable::new(&LogTableOptions::default().order(order).tolerance(tolerance)).unwrap();
        let exact = ZonalLogarithm::new(order, LOG_CLAMP);
        let mut worst = 0.0_f64;
        for k in 0..600 {
            // Half of them small, where the polynomials are.
            let angle = random.unit() * if k % 2 == 0 { 0.5 * PI } else { 0.3 };
            let (found, expected) = (table.at(angle), exact.of_sphere(angle));
            let pairs = found.coefficients().iter().zip(expected.coefficients());
            worst = worst.max(pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt());
        }
        println!("order {order}: {} rows, {worst:.2e} of {tolerance}", table.row_count());
        assert!(worst <= tolerance, "order {order}: {worst} of {tolerance}");
        assert!(table.at(0.0).coefficients().iter().all(|c| *c == 0.0), "nothing hides nothing: {:?}", table.at(0.0));
    }
}

#[test]
fn a_window_is_on_the_visibility_before_its_logarithm() {
    let (order, h, angle) = (4, 8.0, 0.7);
    let table = LogTable::new(&LogTableOptions::default().order(order).window(h).tolerance(0.05)).unwrap();
    let mut visible: Vec<f64> = Zonal::cone(order, angle).coefficients().iter().map(|c| -c).collect();
    visible[0] += (4.0 * PI).sqrt();
    for (l, c) in visible.iter_mut().enumerate() {
        *c *= (PI * l as f64 / (2.0 * h)).cos();
    }
    let expected = ZonalLogarithm::new(order, LOG_CLAMP).of(&Zonal::new(visible));
    for (found, expected) in table.at(angle).coefficients().iter().zip(expected.coefficients()) {
        assert!((found - expected).abs() < 0.05, "{found} against {expected}");
    }
}

#[test]
fn a_file_keeps_the_table_and_another_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.safetensors");
    let options = LogTableOptions::default().order(3).tolerance(0.1);
    let made = cached_log_table(&path, &options).unwrap();
    assert_eq!(read_log_table(&path).unwrap(), made, "read back");
    assert_eq!(cached_log_table(&path, &options).unwrap(), made, "from the cache");
    assert_eq!(cached_log_table(&path, &options.tolerance(0.2)).unwrap(), made, "a finer one will do");
    for (other, said) in [
        (options.order(4), "another order: expected order 4, found order 3"),
        (options.window(6.0), "another window: expected a window of 6, found no window"),
        (options.clamp(0.05), "another clamp: expected clamp 0.05, found clamp 0.02"),
        (options.tolerance(0.01), "another tolerance"),
    ] {
        let message = cached_log_table(&path, &other).unwrap_err().to_string();
        assert!(message.contains(said) && message.starts_with(&path.display().to_string()), "{message}");
        assert!(!message.contains('\n'), "one line: {message}");
    }
}

#[test]
fn a_table_of_another_version_is_made_anew() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.safetensors");
    let options = LogTableOptions::default().order(2).tolerance(0.1);
    let made = cached_log_table(&path, &options).unwrap();
    let mut old = fs::read(&path).unwrap();
    let version = "version\\\":1";
    let place = 8 + String::from_utf8_lossy(&old[8..400]).find(version).unwrap() + version.len() - 1;
    old[place] = b'0';
    fs::write(&path, &old).unwrap();
    assert!(read_log_table(&path).is_err(), "version 0 is not read");
    assert_eq!(cached_log_table(&path, &options).unwrap(), made, "made anew");
    assert_eq!(read_log_table(&path).unwrap(), made, "and written");
}

#[test]
fn damaged_files_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.safetensors");
    write_log_table(&path, &LogTable::new(&LogTableOptions::default().order(2).tolerance(0.1)).unwrap()).unwrap();
    let bytes = fs::read(&path).unwrap();
    for end in (0..bytes.len()).step_by(41) {
        let message = read_log_table_bytes(&bytes[..end], "cut.safetensors").unwrap_err().to_string();
        assert!(message.starts_with("cut.safetensors: ") && !message.contains('\n'), "{end}: {message}");
    }
    let text = String::from_utf8_lossy(&bytes[8..400]).into_owned();
    for (from, to, said) in [
        ("lobe-sphere-logarithms", "lobe-sphere-logarithmz", "expected lobe-sphere-logarithms"),
        ("version\\\":1", "version\\\":7", "expected version 1"),
        ("fit_end\\\":0.", "fit_end\\\":9.", "end between 0.001 and 0.75"),
        ("order\\\":2", "order\\\":9", "from 1 to 8, found 9"),
        ("order\\\":2", "order\\\":3", "expected a tensor rows of shape [any, 3], found"),
    ] {
        assert!(text.contains(from), "{from} in {text}");
        let place = 8 + text.find(from).unwrap();
        let mut changed = bytes.clone();
        changed[place..place + to.len()].copy_from_slice(to.as_bytes());
        let message = read_log_table_bytes(&changed, "x").unwrap_err().to_string();
        assert!(message.contains(said), "{to}: {message}");
    }
    let mut not_a_number = bytes.clone();
    let end = bytes.len() - 4;
    not_a_number[end..].copy_from_slice(&f32::NAN.to_le_bytes());
    let message = read_log_table_bytes(&not_a_number, "x").unwrap_err().to_string();
    assert!(message.contains("expected logarithms"), "{message}");
}

#[test]
fn options_out_of_their_range_are_refused() {
    for (options, said) in [
        (LogTableOptions::default().order(0), "from 1 to 8, found 0"),
        (LogTableOptions::default().order(9), "from 1 to 8, found 9"),
        (LogTableOptions::default().window(0.0), "above 0, found 0"),
        (LogTableOptions::default().clamp(f64::NAN), "found NaN"),
        (LogTableOptions::default().tolerance(0.0), "above 0, found 0"),
    ] {
        let message = LogTable::new(&options).unwrap_err().to_string();
        assert!(message.contains(said), "{message}");
    }
    for method in [ExpMethod::Eigen, ExpMethod::ProductSeries(4), ExpMethod::Hybrid { limit: 0.0 }] {
        let message = BatchExponential::new(4, method).unwrap_err().to_string();
        assert!(message.contains("expected grid, optimal linear"), "{message}");
    }
}

#[test]
#[ignore = "long: of the nightly group"]
fn exponentials_of_blocks_are_those_of_the_scalar_path() {
    let mut random = Random::new(2);
    for order in 1..=8 {
        let logarithm = ZonalLogarithm::new(order, LOG_CLAMP);
        let hybrid = [1.0, 1e-3, 1e-7].map(|limit| ExpMethod::Hybrid { limit });
        for method in hybrid.into_iter().chain([ExpMethod::Grid, ExpMethod::OptimalLinear]) {
            let (scalar, batch) = (Exponential::new(order, method), BatchExponential::new(order, method).unwrap());
            let functions: Vec<ShVec<f64>> = (0..20)
                .map(|k| {
                    let mut f = ShVec::zero(order);
                    for _ in 0..k {
                        let towards = Dir::try_from(random.direction()).unwrap();
                        f += &logarithm.of_sphere(0.5 * random.unit()).towards(towards, 1.0);
                    }
                    f
                })
                .collect();
            let single =
                |f: &ShVec<f64>| ShVec::from_vec(f.coefficients().iter().map(|c| *c as f32).collect()).unwrap();
            let mut found = ShBatch::from_functions(&functions.iter().map(single).collect::<Vec<ShVec<f32>>>());
            batch.of_batch_in_place(&mut found);
            for (k, (f, found)) in functions.iter().zip(found.to_functions()).enumerate() {
                let expected = scalar.of(f);
                let square: f64 = (0..order * order).map(|i| (f64::from(found[i]) - expected[i]).powi(2)).sum();
                let error = (square / expected.dot(&expected)).sqrt();
                assert!(error < 1e-5, "order {order}, {method:?}, function {k}: {error}");
            }
        }
    }
}
