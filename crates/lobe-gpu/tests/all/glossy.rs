//! Glossy receivers.

use lobe_gpu::{GpuMatrices, Storage};
use lobe_prt::{Channels, TransferMatrices};
use lobe_sh::{Dir, Zonal};
use lobe_testkit::Random;

use crate::transfer::light;
use crate::{TOLERANCE, device, flat, relative_difference};

const POINTS: usize = 120;

#[test]
fn glossy_points_send_towards_the_eye_what_the_processor_says() {
    let Some(context) = device("glossy_points_send_towards_the_eye_what_the_processor_says") else { return };
    let mut random = Random::new(1);
    let positions: Vec<[f32; 3]> = (0..POINTS).map(|_| [0, 1, 2].map(|_| random.signed() as f32)).collect();
    let normals: Vec<[f32; 3]> =
        lobe_testkit::fibonacci_sphere(POINTS).into_iter().map(|n| n.map(|c| c as f32)).collect();
    let eye = [2.0_f32, -1.5, 3.0];
    for (order, channels) in [(1, Channels::Gray), (3, Channels::Rgb), (4, Channels::Gray), (8, Channels::Gray)] {
        let numbers = random.signed_vec(order * order * order * order * channels.count() * POINTS);
        let numbers = numbers.into_iter().map(|x| x as f32).collect();
        let matrices = TransferMatrices::new(order, channels, numbers).unwrap();
        let (light, lobe) = (light(order * order), Zonal::ggx(order, 0.4));
        let expected: Vec<f64> = (0..POINTS)
            .flat_map(|k| {
                let n = Dir::new(normals[k].map(f64::from)).unwrap();
                let v = Dir::new([0, 1, 2].map(|c| f64::from(eye[c]) - f64::from(positions[k][c]))).unwrap();
                matrices.exit_radiance(k, &light, &lobe, n, v).to_array()
            })
            .collect();
        for (storage, tolerance) in [(Storage::F32, TOLERANCE), (Storage::F16, 1e-3)] {
            let shaded = GpuMatrices::new(&context, &matrices, &positions, &normals, storage).unwrap();
            let found = shaded.exit_radiance(&light, &lobe, eye).unwrap();
            let worst = relative_difference(flat(&found), expected.iter().copied());
            assert!(worst < tolerance, "order {order}, {channels:?}, {storage:?}: {worst:e}");
        }
    }
}
