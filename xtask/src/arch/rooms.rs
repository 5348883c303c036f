//! Rooms: the folders directly under `src`, and the one way through them that ARCHITECTURE.md draws.
//!
//! The block `rooms CRATE` has a line for each room, users above what they use:
//!
//! ````text
//! ```rooms lobe-sh
//! rotation  ->  expansion, sphere
//! expansion ->  sphere
//! sphere    ->  nothing
//! ```
//! ````
//!
//! Files at the root of `src` are the ground floor, which every room may use and needs no arrow for. A file there that
//! uses a room, itself or through another such file, has left the ground floor: it stands among the rooms with a line
//! of its own, and who uses it has an arrow to it. The root itself, `lib.rs` or `main.rs`, may use everything, and no
//! room may use it.

use std::collections::{BTreeMap, BTreeSet};

use super::blocks::{Block, DOCUMENT};
use super::circles;
use super::modules::{Sources, is_root};
use super::uses::Code;

/// The most files in one folder.
const MOST_FILES: usize = 24;

/// The evidence of an arrow: `grid.rs -> basis.rs: eval_basis`, a line for each pair of files.
pub(super) type Evidence = Vec<String>;

/// The rooms of a crate and the arrows between them.
pub(super) struct Plan {
    pub(super) rooms: BTreeSet<String>,
    /// The rooms and the files that stand among them.
    pub(super) places: BTreeSet<String>,
    pub(super) arrows: BTreeMap<(String, String), Evidence>,
    /// Faults that do not depend on the document.
    pub(super) faults: Vec<String>,
}

/// The place of a file: a root, the ground floor, or a room.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    Root,
    Ground(String),
    Room(String),
}

/// The language of the crate's block.
pub(super) fn language(name: &str) -> String {
    format!("rooms {name}")
}

/// The plan of a crate as its code has it.
pub(super) fn plan(code: &Code, sources: &Sources) -> Plan {
    let rooms: BTreeSet<String> = code
        .modules
        .iter()
        .filter(|file| !is_root(file))
        .filter_map(|file| Some(file.split_once('/')?.0.into()))
        .collect();
    let mut plan = Plan { places: rooms.clone(), rooms, arrows: BTreeMap::new(), faults: Vec::new() };
    if plan.rooms.is_empty() {
        return plan;
    }
    let mut between: BTreeMap<(Place, Place), Evidence> = BTreeMap::new();
    for ((user, used), names) in &code.arrows {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let ends = (plan.place(user), plan.place(used));
        if ends.0 != ends.1 {
            between.entry(ends).or_default().push(format!("{user} -> {used}: {}", names.join(", ")));
        }
    }
    plan.lift(&between);
    for ((user, used), evidence) in between {
        match (user, used) {
            (Place::Root, _) => {}
            (_, Place::Root) => {
                let fault = "nothing may use the root of the crate where there are rooms";
                plan.faults.push(format!("{fault}: {}", evidence.join("; ")));
            }
            (Place::Room(user) | Place::Ground(user), Place::Room(used) | Place::Ground(used)) => {
                if plan.places.contains(&user) && plan.places.contains(&used) {
                    plan.arrows.insert((user, used), evidence);
                }
            }
        }
    }
    plan.faults.extend(plan.rooms.iter().flat_map(|room| room_faults(room, sources)));
    plan
}

impl Plan {
    fn place(&self, file: &str) -> Place {
        if is_root(file) {
            return Place::Root;
        }
        let first = file.split_once('/').map_or(file.trim_end_matches(".rs"), |(folder, _)| folder);
        if self.rooms.contains(first) { Place::Room(first.into()) } else { Place::Ground(first.into()) }
    }

    /// Puts the files at the root that lead to a room among the rooms.
    fn lift(&mut self, between: &BTreeMap<(Place, Place), Evidence>) {
        loop {
            let before = self.places.len();
            for (user, used) in between.keys() {
                if let (Place::Ground(user), Place::Room(used) | Place::Ground(used)) = (user, used)
                    && self.places.contains(used)
                {
                    self.places.insert(user.clone());
                }
            }
            if self.places.len() == before {
                return;
            }
        }
    }
}

fn room_faults(room: &str, sources: &Sources) -> Vec<String> {
    let mut faults = Vec::new();
    let door = format!("{room}/mod.rs");
    match sources.get(&door) {
        None => faults.push(format!("the room {room} has no mod.rs")),
        Some(text) if !opens_with_words(text) => {
            faults.push(format!("{door} does not open with a few lines (//!) on what lives there"));
        }
        Some(_) => {}
    }
    let inside = |file: &&String| file.rsplit_once('/').is_some_and(|(folder, _)| folder == room);
    let files = sources.keys().filter(inside).count();
    if files > MOST_FILES {
        faults.push(format!("the room {room} holds {files} files, limit {MOST_FILES}"));
    }
    faults
}

/// Whether the file opens with module documentation, after plain comments at most.
fn opens_with_words(text: &str) -> bool {
    let plain_comment = |line: &&str| line.is_empty() || (line.starts_with("//") && !line.starts_with("//!"));
    let first = text.lines().map(str::trim).find(|line| !plain_comment(line));
    first.and_then(|line| line.strip_prefix("//!")).is_some_and(|words| !words.trim().is_empty())
}

/// Compares the plan with the crate's block, in both directions.
pub(super) fn faults(name: &str, plan: &Plan, block: Option<&Block>) -> Vec<String> {
    let mut faults = plan.faults.clone();
    faults.extend(circle_faults(plan));
    match block {
        Some(block) => {
            faults.extend(drawn_faults(plan, block));
            faults.extend(built_faults(plan, block));
        }
        None if plan.rooms.is_empty() => {}
        None => faults.push(format!(
            "{DOCUMENT} has no code block of language `{}`, which `cargo xtask arch --draw {name}` prints",
            language(name)
        )),
    }
    faults.iter().map(|fault| format!("{name}: {fault}")).collect()
}

/// One fault for each circle of rooms, with all that ties it.
pub(super) fn circle_faults(plan: &Plan) -> Vec<String> {
    let describe = |circle: &BTreeSet<String>| {
        let places: Vec<&str> = circle.iter().map(String::as_str).collect();
        let mut text = format!("rooms use each other in a circle: {}", places.join(", "));
        for ((user, used), evidence) in &plan.arrows {
            if circle.contains(user) && circle.contains(used) {
                text += &format!("\n    {user} -> {used}\n        {}", evidence.join("\n        "));
            }
        }
        text
    };
    circles::circles(&plan.arrows).iter().map(describe).collect()
}

/// Faults of the document: lines that the code does not have, and arrows that do not point down.
fn drawn_faults(plan: &Plan, block: &Block) -> Vec<String> {
    let mut faults = Vec::new();
    for (position, line) in block.lines.iter().enumerate() {
        let user = &line.name;
        if block.lines[..position].iter().any(|above| &above.name == user) {
            faults.push(format!("{DOCUMENT} has two lines for {user}"));
        }
        if !plan.places.contains(user) {
            faults.push(format!("{DOCUMENT} has a line for {user}, which is neither a room nor a file that uses one"));
            continue;
        }
        for used in &line.uses {
            if !plan.arrows.contains_key(&(user.clone(), used.clone())) {
                faults.push(format!("{user} -> {used} stands in {DOCUMENT}, but no file of {user} uses {used}"));
            }
            if !block.lines[position + 1..].iter().any(|below| &below.name == used) {
                faults.push(format!("{user} -> {used} does not point down: {used} needs a line below {user}'s"));
            }
        }
    }
    faults
}

/// Faults of the code: places and arrows that the document does not draw.
fn built_faults(plan: &Plan, block: &Block) -> Vec<String> {
    let line = |place: &str| block.lines.iter().find(|line| line.name == place);
    let mut faults = Vec::new();
    for place in plan.places.iter().filter(|place| line(place).is_none()) {
        let what = if plan.rooms.contains(place) { "a room" } else { "a file that uses rooms" };
        faults.push(format!("{place} is {what}, but {DOCUMENT} has no line for it"));
    }
    for ((user, used), evidence) in &plan.arrows {
        if line(user).is_some_and(|line| !line.uses.contains(used)) {
            let evidence = evidence.join("\n    ");
            faults.push(format!("{user} -> {used} is missing in {DOCUMENT}:\n    {evidence}"));
        }
    }
    faults
}
