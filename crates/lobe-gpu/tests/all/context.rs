//! Devices, and what goes wrong on them.

use lobe_gpu::wgpu;
use lobe_gpu::{AdapterChoice, Context, ContextOptions, GpuError, GpuTransfer, Interface, Storage};
use lobe_prt::{Channels, Transfer};

use crate::device;

#[test]
fn numbers_come_back_as_they_went() {
    let Some(context) = device("numbers_come_back_as_they_went") else { return };
    for count in [0, 1, 3, 64, 1000] {
        let numbers: Vec<u8> = (0..count).map(|i| (7 * i % 251) as u8).collect();
        let usage = wgpu::BufferUsages::COPY_SRC;
        let buffer = context.upload("numbers", &numbers, usage).unwrap();
        let read: Vec<u8> = context.read(&buffer, numbers.len()).unwrap();
        assert_eq!(read, numbers, "{count} bytes");
    }
}

#[test]
fn a_device_that_is_lost_is_an_error_and_no_panic() {
    if device("a_device_that_is_lost_is_an_error_and_no_panic").is_none() {
        return;
    }
    let options = ContextOptions::default().adapter(AdapterChoice::Software);
    let context = Context::new(&options).or_else(|_| Context::new(&ContextOptions::default())).unwrap();
    let transfer = Transfer::new(1, Channels::Gray, vec![1.0]).unwrap();
    let shaded = GpuTransfer::new(&context, &transfer, Storage::F32).unwrap();
    assert!(!context.is_lost(), "it is there");
    context.device().destroy();
    // What it still does comes to its end before the loss is reported.
    assert!(context.wait().is_err() || context.is_lost(), "it was destroyed");
    let light = [lobe_sh::Rgb::new(1.0, 1.0, 1.0)];
    let error = shaded.exit_radiance(&light).expect_err("the device is gone");
    assert!(matches!(error, GpuError::Device { .. }), "{error}");
    assert_eq!(error.to_string().lines().count(), 1, "one line: {error}");
}

#[test]
fn an_interface_that_the_machine_has_not_is_an_error_that_says_so() {
    let foreign = if cfg!(target_os = "macos") { Interface::Dx12 } else { Interface::Metal };
    let error = Context::new(&ContextOptions::default().interface(foreign)).expect_err("no such interface");
    assert!(matches!(error, GpuError::NoAdapter(_)), "{error}");
}

#[test]
fn the_order_of_passes_is_a_table() {
    let Some(context) = device("the_order_of_passes_is_a_table") else { return };
    let transfer = Transfer::new(2, Channels::Gray, vec![0.5; 8]).unwrap();
    let shaded = GpuTransfer::new(&context, &transfer, Storage::F32).unwrap();
    let expected = "\
pass       | reads                                | writes
transfer 0 | transfer shape 0, light, transfer 0 | radiance
";
    let squeezed = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(squeezed(&shaded.renderer().to_string()), squeezed(expected), "the table");
    let names: Vec<&str> = shaded.renderer().passes().map(lobe_gpu::Pass::name).collect();
    assert_eq!(names, ["transfer 0"], "the passes as data");
    let times = shaded.renderer().run_timed().unwrap();
    assert_eq!(times.len(), 1, "one time for each pass: {times:?}");
    assert!(times[0].milliseconds.is_none_or(|ms| (0.0..1e6).contains(&ms)), "{times:?}");
}
