//! Links the C++ runtime, which the compiled BC6H encoder needs and does not ask for itself.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let is = |key: &str, value: &str| std::env::var(key).is_ok_and(|found| found == value);
    if std::env::var_os("CARGO_FEATURE_BC6H").is_some() && is("CARGO_CFG_TARGET_FAMILY", "unix") {
        let runtime = if is("CARGO_CFG_TARGET_VENDOR", "apple") { "c++" } else { "stdc++" };
        println!("cargo:rustc-link-lib=dylib={runtime}");
    }
}
