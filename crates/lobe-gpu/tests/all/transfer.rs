//! Matte receivers: every order, gray and colored, in pieces, in clusters, in half precision.

use lobe_gpu::{Context, ContextOptions, GpuError, GpuTransfer, Storage};
use lobe_io::Job;
use lobe_prt::{Channels, CompressOptions, CompressedTransfer, Transfer, WeightBits};
use lobe_sh::Rgb;
use lobe_testkit::Random;

use crate::{TOLERANCE, device, flat, relative_difference, with};

const RECEIVERS: usize = 1000;

fn transfer(order: usize, channels: Channels) -> Transfer {
    let mut random = Random::new(order as u64);
    let numbers = random.signed_vec(order * order * channels.count() * RECEIVERS);
    Transfer::new(order, channels, numbers.into_iter().map(|x| x as f32).collect()).unwrap()
}

pub(crate) fn light(coefficients: usize) -> Vec<Rgb<f64>> {
    let mut random = Random::new(99);
    (0..coefficients).map(|_| Rgb::new(random.signed(), random.signed(), random.signed())).collect()
}

#[test]
fn transfer_of_every_order_gives_the_radiance_of_the_processor() {
    let Some(context) = device("transfer_of_every_order_gives_the_radiance_of_the_processor") else { return };
    for order in 1..=8 {
        for channels in [Channels::Gray, Channels::Rgb] {
            let transfer = transfer(order, channels);
            let shaded = GpuTransfer::new(&context, &transfer, Storage::F32).unwrap();
            // A light of the same order, of a lower one and of a higher one, in turn on one upload.
            for coefficients in [order * order, (order - 1).max(1).pow(2), (order + 1).pow(2)] {
                let light = light(coefficients);
                let found = shaded.exit_radiance(&light).unwrap();
                let worst = relative_difference(flat(&found), flat(&transfer.exit_radiance(&light)));
                assert!(worst < 1e-5, "order {order}, {channels:?}, {coefficients} coefficients: {worst:e}");
            }
        }
    }
}

/// The same device with bindings so small that work is split.
fn small_bindings(context: &Context, bytes: u64) -> Context {
    with(context, &ContextOptions::default().max_storage_binding(bytes))
}

#[test]
fn what_is_larger_than_a_binding_is_split_and_gives_the_same() {
    let Some(whole) = device("what_is_larger_than_a_binding_is_split_and_gives_the_same") else { return };
    let transfer = transfer(4, Channels::Rgb);
    let context = small_bindings(&whole, 40_000);
    let shaded = GpuTransfer::new(&context, &transfer, Storage::F32).unwrap();
    // 192 bytes a receiver, 208 receivers a piece.
    assert_eq!(shaded.renderer().passes().count(), 5, "passes:\n{}", shaded.renderer());
    let light = light(16);
    let found = shaded.exit_radiance(&light).unwrap();
    let worst = relative_difference(flat(&found), flat(&transfer.exit_radiance(&light)));
    assert!(worst < 1e-5, "{worst:e}");
    let error =
        GpuTransfer::new(&small_bindings(&whole, 1000), &transfer, Storage::F32).expect_err("16 receivers do not fit");
    assert!(matches!(error, GpuError::Unsupported { .. }), "{error}");
}

#[test]
fn half_precision_costs_what_is_said() {
    let Some(context) = device("half_precision_costs_what_is_said") else { return };
    for channels in [Channels::Gray, Channels::Rgb] {
        // Nine coefficients: a word is left half empty.
        for order in [3, 4] {
            let transfer = transfer(order, channels);
            let light = light(order * order);
            let shaded = GpuTransfer::new(&context, &transfer, Storage::F16).unwrap();
            let found = shaded.exit_radiance(&light).unwrap();
            let worst = relative_difference(flat(&found), flat(&transfer.exit_radiance(&light)));
            assert!(worst > 1e-6 && worst < 3e-4, "order {order}, {channels:?}: {worst:e}");
        }
    }
}

#[test]
fn clusters_give_the_radiance_of_the_processor_in_every_number_format() {
    let Some(context) = device("clusters_give_the_radiance_of_the_processor_in_every_number_format") else { return };
    for (channels, bits) in
        [(Channels::Gray, WeightBits::F32), (Channels::Rgb, WeightBits::U16), (Channels::Rgb, WeightBits::U8)]
    {
        let transfer = transfer(3, channels);
        let options = CompressOptions::default().clusters(5).components(6).weights(bits);
        let (clustered, _) = CompressedTransfer::new(&transfer, &options, Job::default()).unwrap();
        let shaded = GpuTransfer::of_clusters(&context, &clustered).unwrap();
        let light = light(9);
        let found = shaded.exit_radiance(&light).unwrap();
        let worst = relative_difference(flat(&found), flat(&clustered.exit_radiance(&light)));
        assert!(worst < 1e-5, "{channels:?}, {bits:?}: {worst:e}");
    }
    let (clustered, _) =
        CompressedTransfer::new(&transfer(3, Channels::Rgb), &CompressOptions::default(), Job::default()).unwrap();
    let shaded = GpuTransfer::of_clusters(&small_bindings(&context, 16384), &clustered).unwrap();
    let found = shaded.exit_radiance(&light(9)).unwrap();
    let worst = relative_difference(flat(&found), flat(&clustered.exit_radiance(&light(9))));
    assert!(worst < TOLERANCE, "in pieces: {worst:e}\n{}", shaded.renderer());
}

#[test]
fn more_receivers_than_one_row_of_workgroups_are_all_shaded() {
    let Some(context) = device("more_receivers_than_one_row_of_workgroups_are_all_shaded") else { return };
    // A row has 65535 groups of 64.
    let count = 65535 * 64 + 1000;
    let numbers: Vec<f32> = (0..count).map(|k| (k % 1021) as f32).collect();
    let transfer = Transfer::new(1, Channels::Gray, numbers).unwrap();
    let shaded = GpuTransfer::new(&context, &transfer, Storage::F32).unwrap();
    let found = shaded.exit_radiance(&[Rgb::new(1.0, 2.0, 0.0)]).unwrap();
    let wrong = found.iter().zip(transfer.coefficients()).position(|(f, t)| f.r != *t || f.g != 2.0 * t);
    assert!(found.len() == count && wrong.is_none(), "receiver {wrong:?} of {}", found.len());
}

#[test]
fn nothing_to_shade_is_no_error() {
    let Some(context) = device("nothing_to_shade_is_no_error") else { return };
    let none = Transfer::new(2, Channels::Gray, Vec::new()).unwrap();
    let shaded = GpuTransfer::new(&context, &none, Storage::F32).unwrap();
    assert!(shaded.exit_radiance(&light(4)).unwrap().is_empty(), "no receivers");
}
