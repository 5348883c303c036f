//! Exit radiance of receivers under a light; see the README beside this file.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use lobe_io::Job;
use lobe_prt::{Channels, CompressOptions, CompressedTransfer, Transfer, WeightBits, ZonalFitOptions, fit_zonal};
use lobe_sh::Rgb;
use lobe_testkit::Random;

const ORDERS: [usize; 4] = [3, 4, 5, 6];

/// Enough receivers that the rows of order 3 exceed the caches.
const RECEIVERS: usize = 1 << 20;

/// Receivers to compress and to fit, repeated to [`RECEIVERS`].
const FEW: usize = 1 << 12;

/// Rows near a few planted directions, so that compression has something to find.
fn transfer(order: usize, channels: Channels, receivers: usize) -> Transfer {
    let width = order * order * channels.count();
    let mut random = Random::new(order as u64);
    let directions = random.signed_vec(8 * width);
    let few: Vec<f32> = (0..FEW)
        .flat_map(|_| {
            let weights = random.signed_vec(8);
            let row =
                |i: usize| weights.iter().enumerate().map(|(j, w)| w * directions[j * width + i]).sum::<f64>() as f32;
            (0..width).map(row).collect::<Vec<f32>>()
        })
        .collect();
    let coefficients = few.iter().copied().cycle().take(receivers * width).collect();
    Transfer::new(order, channels, coefficients).unwrap_or_else(|e| unreachable!("finite rows: {e}"))
}

fn light(order: usize) -> Vec<Rgb<f64>> {
    let mut random = Random::new(9);
    (0..order * order).map(|_| Rgb::new(random.signed(), random.signed(), random.signed())).collect()
}

/// The sum of the rows: what reading them costs at least, with 32 sums that do not wait for each other.
fn floor(c: &mut Criterion) {
    for (channels, name) in [(Channels::Gray, "shade-floor-read-gray"), (Channels::Rgb, "shade-floor-read-rgb")] {
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements(RECEIVERS as u64));
        for order in ORDERS {
            let transfer = transfer(order, channels, RECEIVERS);
            group.bench_function(BenchmarkId::from_parameter(order), |b| {
                b.iter(|| {
                    let mut sums = [0.0_f32; 32];
                    for chunk in black_box(transfer.coefficients()).as_chunks::<32>().0 {
                        for k in 0..32 {
                            sums[k] += chunk[k];
                        }
                    }
                    sums
                });
            });
        }
    }
}

fn uncompressed(c: &mut Criterion) {
    for (channels, name) in [(Channels::Gray, "shade-gray"), (Channels::Rgb, "shade-rgb")] {
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements(RECEIVERS as u64));
        for order in ORDERS {
            let (transfer, light) = (transfer(order, channels, RECEIVERS), light(order));
            let mut out = vec![Rgb::new(0.0, 0.0, 0.0); RECEIVERS];
            group.bench_function(BenchmarkId::from_parameter(order), |b| {
                b.iter(|| transfer.exit_radiance_into(black_box(&light), &mut out));
            });
        }
    }
}

fn compressed(c: &mut Criterion) {
    for (weights, name) in [(WeightBits::F32, "shade-cpca-f32"), (WeightBits::U8, "shade-cpca-u8")] {
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements(RECEIVERS as u64));
        for order in ORDERS {
            let options = CompressOptions::default().clusters(64).components(8).weights(weights).iterations(4);
            let few = transfer(order, Channels::Gray, FEW);
            let Ok((small, _)) = CompressedTransfer::new(&few, &options, Job::default()) else { continue };
            let Some(all) = repeated(&small) else { continue };
            let light = light(order);
            let mut out = vec![Rgb::new(0.0, 0.0, 0.0); RECEIVERS];
            group.bench_function(BenchmarkId::from_parameter(order), |b| {
                b.iter(|| all.exit_radiance_into(black_box(&light), &mut out));
            });
        }
    }
}

/// The same receivers over and over, to [`RECEIVERS`].
fn repeated(small: &CompressedTransfer) -> Option<CompressedTransfer> {
    use lobe_prt::{CompressedTable, TableWeights};
    let table = small.table();
    let times = RECEIVERS / table.rows();
    let weights = match table.weights() {
        TableWeights::F32(w) => TableWeights::F32(w.repeat(times)),
        TableWeights::U16(w) => TableWeights::U16(w.repeat(times)),
        TableWeights::U8(w) => TableWeights::U8(w.repeat(times)),
    };
    let clusters = table.clusters().repeat(times);
    let table = CompressedTable::new(table.width(), table.components(), clusters, weights, table.bases().to_vec());
    CompressedTransfer::from_table(small.order(), small.channels(), table.ok()?).ok()
}

fn zonal(c: &mut Criterion) {
    let mut group = c.benchmark_group("shade-zonal");
    group.throughput(Throughput::Elements(FEW as u64));
    for order in ORDERS {
        let few = transfer(order, Channels::Gray, FEW);
        let options = ZonalFitOptions::default().lobes(1).optimize(false);
        let Ok((zonal, _)) = fit_zonal(&few, &options, Job::default()) else { continue };
        let light = light(order);
        let mut out = vec![Rgb::new(0.0, 0.0, 0.0); FEW];
        group.bench_function(BenchmarkId::from_parameter(order), |b| {
            b.iter(|| zonal.exit_radiance_towards_into(zonal.axes(), black_box(&light), &mut out));
        });
    }
}

fn main() {
    let mut c = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1000))
        .configure_from_args();
    floor(&mut c);
    uncompressed(&mut c);
    compressed(&mut c);
    zonal(&mut c);
    c.final_summary();
}
