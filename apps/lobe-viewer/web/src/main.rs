//! Makes a page of the viewer: `lobe-web VIEWER.wasm FOLDER` writes its WebAssembly, its JavaScript and `index.html` into the folder.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{env, fs};

use wasm_bindgen_cli_support::Bindgen;

const PAGE: &str = include_str!("../index.html");

fn main() -> ExitCode {
    let [Some(viewer), Some(folder), None] = [1, 2, 3].map(|k| env::args_os().nth(k).map(PathBuf::from)) else {
        eprintln!("usage: lobe-web VIEWER.wasm FOLDER");
        return ExitCode::from(2);
    };
    match write(&viewer, &folder) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("lobe-web: {message}");
            ExitCode::from(2)
        }
    }
}

fn write(viewer: &Path, folder: &Path) -> Result<(), String> {
    let mut bindgen = Bindgen::new();
    bindgen.input_path(viewer).out_name("lobe-viewer").omit_default_module_path(false);
    let bindgen = bindgen.web(true).map_err(|error| error.to_string())?;
    bindgen.generate(folder).map_err(|error| format!("{}: {error:#}", viewer.display()))?;
    let page = folder.join("index.html");
    fs::write(&page, PAGE).map_err(|error| format!("{}: {error}", page.display()))
}
