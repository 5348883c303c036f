//! The viewer; everything is in the library beside it.

use std::alloc::System;
use std::process::ExitCode;

use lobe::io::HugePages;

#[global_allocator]
static ALLOCATOR: HugePages<System> = HugePages::new(System).growing_by_remapping();

fn main() -> ExitCode {
    lobe_viewer::main()
}
