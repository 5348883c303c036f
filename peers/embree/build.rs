//! Links with Embree 4: the file that `EMBREE` names, such as that in the wheel of embreex, or the one of the system.

use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=EMBREE");
    match std::env::var_os("EMBREE").map(PathBuf::from) {
        Some(file) => {
            let folder = file.parent().unwrap_or(Path::new("."));
            println!("cargo::rustc-link-arg={}", file.display());
            println!("cargo::rustc-link-arg=-Wl,-rpath,{}", folder.display());
        }
        None => println!("cargo::rustc-link-lib=dylib=embree4"),
    }
}
