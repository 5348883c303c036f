//! `arch`: checks that the code has the structure that ARCHITECTURE.md draws.
//!
//! Four things are checked: the arrows between crates (`crates`), the arrows between the rooms of a crate (`rooms`), that
//! the first lines of a room name the rooms it uses (`heads`), and that no files of a crate use each other in a circle
//! (`circles`). The last three rest on the arrows between files,
//! which are read from the source: `modules` builds the tree of modules that rustc would, `resolve` finds the file that
//! defines what a path names, `uses` walks through the code and collects the paths.
//!
//! A path is all that counts. Calling a method names no file, nor does a link in a comment.
//!
//! Read in this order: `blocks`, `crates`, `modules`, `resolve`, `uses`, `circles`, `rooms`, `heads`, `draw`. Uses no
//! other room.

mod attributes;
mod blocks;
mod circles;
mod crates;
mod draw;
mod heads;
mod modules;
mod resolve;
mod rooms;
#[cfg(test)]
mod tests;
mod uses;

use blocks::{Block, DOCUMENT};
use modules::Sources;
use rooms::Plan;
use uses::Code;

use crate::outcome::{self, Outcome};
use crate::workspace::{self, Package};

/// A crate: its source, its arrows and its rooms.
struct House {
    name: String,
    code: Code,
    plan: Plan,
    head_faults: Vec<String>,
}

/// `arch` checks all; `arch --circles` only lists the circles between files; `arch --draw` prints the blocks of rooms.
/// The name of a crate behind either looks at that crate alone.
pub(crate) fn run(arguments: &[String]) -> Outcome {
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        [] => check(),
        ["--circles"] => list_circles(None),
        ["--circles", name] => list_circles(Some(name)),
        ["--draw"] => draw(None),
        ["--draw", name] => draw(Some(name)),
        _ => Err(vec![format!("expected nothing, --circles [CRATE] or --draw [CRATE], found {arguments:?}")]),
    }
}

/// Compares the document with the Cargo.toml files and with the source.
pub(crate) fn check() -> Outcome {
    let text = workspace::read(&workspace::root().join(DOCUMENT)).map_err(|fault| vec![fault])?;
    let blocks = blocks::parse(&text).map_err(|fault| vec![fault])?;
    let packages = workspace::packages().map_err(|fault| vec![fault])?;
    let houses = houses(&packages, None)?;
    let mut faults = crates::faults(&blocks, &packages);
    faults.extend(unknown_blocks(&blocks, &houses));
    for house in &houses {
        faults.extend(house_faults(house, &blocks));
    }
    outcome::of(faults)
}

fn house_faults(house: &House, blocks: &[Block]) -> Vec<String> {
    let mut faults: Vec<String> = house.code.faults.iter().map(|fault| format!("{}: {fault}", house.name)).collect();
    faults.extend(circle_faults(house));
    faults.extend(house.head_faults.iter().map(|fault| format!("{}: {fault}", house.name)));
    match blocks::only(blocks, &rooms::language(&house.name)) {
        Ok(block) => faults.extend(rooms::faults(&house.name, &house.plan, block)),
        Err(fault) => faults.push(fault),
    }
    faults
}

fn unknown_blocks(blocks: &[Block], houses: &[House]) -> Vec<String> {
    let known: Vec<String> = houses.iter().map(|house| rooms::language(&house.name)).collect();
    let unknown = blocks.iter().filter(|block| block.language != "arrows" && !known.contains(&block.language));
    unknown.map(|block| format!("{DOCUMENT}: the block `{}` names no crate of the workspace", block.language)).collect()
}

fn circle_faults(house: &House) -> Vec<String> {
    let found = circles::circles(&house.code.arrows);
    found.iter().map(|circle| format!("{}: {}", house.name, circles::describe(circle, &house.code.arrows))).collect()
}

fn list_circles(name: Option<&str>) -> Outcome {
    let packages = workspace::packages().map_err(|fault| vec![fault])?;
    let houses = houses(&packages, name)?;
    let mut faults = Vec::new();
    for house in &houses {
        let found = circle_faults(house);
        let (files, arrows) = (house.code.files, house.code.arrows.len());
        println!("{}: {files} files, {arrows} arrows between them, circles: {}", house.name, found.len());
        faults.extend(found);
    }
    outcome::of(faults)
}

fn draw(name: Option<&str>) -> Outcome {
    let packages = workspace::packages().map_err(|fault| vec![fault])?;
    let mut faults = Vec::new();
    for house in houses(&packages, name)?.iter().filter(|house| !house.plan.rooms.is_empty()) {
        match draw::block(&house.name, &house.plan) {
            Ok(block) => println!("{block}"),
            Err(found) => faults.extend(found),
        }
    }
    outcome::of(faults)
}

/// Reads the source of every package, or of the one of this name.
fn houses(packages: &[Package], name: Option<&str>) -> Result<Vec<House>, Vec<String>> {
    let chosen: Vec<&Package> =
        packages.iter().filter(|package| name.is_none_or(|name| package.name == name)).collect();
    if chosen.is_empty() {
        return Err(vec![format!("no crate of the workspace is called {}", name.unwrap_or_default())]);
    }
    let paths = workspace::files("rs").map_err(|fault| vec![fault])?;
    chosen.into_iter().map(|package| house(package, &paths).map_err(|fault| vec![fault])).collect()
}

fn house(package: &Package, paths: &[std::path::PathBuf]) -> Result<House, String> {
    let folder = package.folder.join("src");
    let mut sources = Sources::new();
    for path in paths {
        if let Ok(inside) = path.strip_prefix(&folder) {
            sources.insert(inside.to_string_lossy().replace('\\', "/"), workspace::read(path)?);
        }
    }
    let code = uses::code(&sources).map_err(|fault| format!("{}: {fault}", package.name))?;
    let plan = rooms::plan(&code, &sources);
    let head_faults = heads::faults(&plan, &sources);
    Ok(House { name: package.name.clone(), code, plan, head_faults })
}
