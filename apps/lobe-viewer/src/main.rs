//! The viewer; everything is in the library beside it.

use std::process::ExitCode;

fn main() -> ExitCode {
    lobe_viewer::main()
}
