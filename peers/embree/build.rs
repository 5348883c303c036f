//! Links with Embree 3.

fn main() {
    println!("cargo::rustc-link-lib=dylib=embree3");
    println!("cargo::rerun-if-changed=build.rs");
}
