//! Properties that the fuzz targets ask of readers.

/// Lets decoders of pictures panic, as readers catch that: what nobody catches still ends the program.
pub fn let_decoders_panic() {
    std::panic::set_hook(Box::new(|_| {}));
}

/// The message of a reader that refuses a file begins with the file's name, `fuzz`, and is one line.
///
/// # Panics
/// If it is not.
pub fn refused_in_one_line<T>(result: Result<T, impl std::fmt::Display>) {
    if let Err(error) = result {
        let line = error.to_string();
        assert!(line.starts_with("fuzz: ") && !line.contains('\n'), "{line:?}");
    }
}
