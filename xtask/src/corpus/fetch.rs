//! Packages of public registries in a cache outside the repository, by the user's own npm, pip and cargo.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The file in a package's folder that says that all of it is there.
const COMPLETE: &str = ".complete";

/// Files of a kind that the small part takes of a package, unless it says how many.
const SMALL: usize = 4;

const PACKAGES: &str = include_str!("packages.txt");

/// A package of the list.
pub(super) struct Package {
    /// `npm`, `pip` or `cargo`.
    from: &'static str,
    pub(super) name: &'static str,
    version: &'static str,
    /// The files of each kind that continuous integration has of it.
    pub(super) small: usize,
}

/// The list.
pub(super) fn packages() -> impl Iterator<Item = Package> {
    PACKAGES.lines().filter(|line| !line.starts_with('#')).filter_map(|line| {
        let mut words = line.split_whitespace();
        let (from, name, version) = (words.next()?, words.next()?, words.next()?);
        Some(Package {
            from,
            name,
            version,
            small: words.next().map_or(0, |_| words.next().map_or(SMALL, |n| n.parse().unwrap_or(SMALL))),
        })
    })
}

/// Where packages are kept: `LOBE_CORPUS`, or a folder of the user's cache.
pub(super) fn cache() -> PathBuf {
    let variable = |name| std::env::var_os(name).map(PathBuf::from);
    variable("LOBE_CORPUS")
        .or_else(|| variable("XDG_CACHE_HOME").map(|cache| cache.join("lobe-corpus")))
        .or_else(|| variable("HOME").map(|home| home.join(".cache/lobe-corpus")))
        .unwrap_or_else(|| std::env::temp_dir().join("lobe-corpus"))
}

impl Package {
    /// The folder that holds, or will hold, its files.
    pub(super) fn folder(&self) -> PathBuf {
        cache().join(format!("{}-{}", self.name.replace(['@', '/'], "_"), self.version))
    }

    fn is_there(&self) -> bool {
        self.folder().join(COMPLETE).exists()
    }

    /// Gets it, unless it is there.
    pub(super) fn fetch(&self) -> Result<(), String> {
        if self.is_there() {
            return Ok(());
        }
        let folder = self.folder();
        // What was left half done is begun anew.
        if folder.exists() {
            fs::remove_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        }
        fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        println!("fetching {} {}", self.name, self.version);
        match self.from {
            "npm" => run("npm", &["pack", "--silent", &format!("{}@{}", self.name, self.version)], &folder)?,
            "cargo" => {
                // Cargo unpacks what it tells of, and copies are left to the cache.
                run("cargo", &["info", "--quiet", &format!("{}@{}", self.name, self.version)], &folder)?;
                run("cp", &["-r", &unpacked(self.name, self.version)?.to_string_lossy(), "."], &folder)?;
            }
            _ => {
                let wanted = format!("{}=={}", self.name, self.version);
                let only = ["-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:", &wanted];
                run("python3", &only, &folder)?;
            }
        }
        for archive in files(&folder, &["tgz", "whl"]) {
            let name = archive.to_string_lossy();
            match self.from {
                "npm" => run("tar", &["-xzf", &name], &folder)?,
                _ => run("python3", &["-m", "zipfile", "-e", &name, "."], &folder)?,
            }
            if self.from == "npm" {
                run("node", &["-e", include_str!("unwrap.cjs"), "--", "unwrap.cjs", "."], &folder)?;
            }
            fs::remove_file(&archive).map_err(|error| format!("{name}: {error}"))?;
        }
        fs::write(folder.join(COMPLETE), "").map_err(|error| format!("{}: {error}", folder.display()))
    }
}

/// Where cargo keeps the sources of a crate that it has fetched: `registry/src` of its home, in a folder for each registry.
fn unpacked(name: &str, version: &str) -> Result<PathBuf, String> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| std::env::var_os("HOME").map(|home| PathBuf::from(home).join(".cargo")));
    let sources = home.ok_or("expected the environment variable HOME, found none")?.join("registry/src");
    let registries = fs::read_dir(&sources).map_err(|error| format!("{}: {error}", sources.display()))?;
    let crates = registries.flatten().map(|registry| registry.path().join(format!("{name}-{version}")));
    let missing = || format!("{name} {version} is not in {}", sources.display());
    crates.into_iter().find(|path| path.is_dir()).ok_or_else(missing)
}

/// Runs a program in a folder, without its output.
fn run(program: &str, arguments: &[&str], folder: &Path) -> Result<(), String> {
    let output = Command::new(program)
        .args(arguments)
        .current_dir(folder)
        .output()
        .map_err(|error| format!("{program} did not start: {error}"))?;
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr).trim().to_string();
    Err(format!("{program} {} failed ({}): {said}", arguments.join(" "), output.status))
}

/// The files of a folder and of those in it with one of these extensions, in path order.
pub(super) fn files(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(&folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| extensions.iter().any(|known| e.eq_ignore_ascii_case(known))) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// The folder of a package of the list, which is fetched if it is not there.
///
/// # Errors
/// The reason why it is not there.
pub(crate) fn package_folder(name: &str) -> Result<PathBuf, String> {
    let package = packages().find(|package| package.name == name);
    let package = package.ok_or_else(|| format!("{name} is not in packages.txt"))?;
    package.fetch()?;
    Ok(package.folder())
}

/// Whether the small part of the corpus is in the cache or can be fetched.
///
/// # Errors
/// The reason why not.
pub(crate) fn has_small_part() -> Result<(), String> {
    let missing: Vec<_> = packages().filter(|package| package.small > 0 && !package.is_there()).collect();
    missing.iter().try_for_each(Package::fetch).map_err(|reason| {
        format!("models cannot be fetched here: {}", reason.lines().next().unwrap_or("no reason was given"))
    })
}
