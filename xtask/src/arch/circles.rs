//! Circles of arrows (strongly connected components): items that use each other, directly or by way of others.

use std::collections::{BTreeMap, BTreeSet};

use super::uses::Arrows;

/// The sets of two or more in which each leads to each other, in order of their first names.
pub(super) fn circles<T>(arrows: &BTreeMap<(String, String), T>) -> Vec<BTreeSet<String>> {
    let mut below: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (user, used) in arrows.keys() {
        below.entry(user).or_default().push(used);
    }
    let reached: BTreeMap<&str, BTreeSet<&str>> = below.keys().map(|&user| (user, reached(user, &below))).collect();
    let mut found: Vec<BTreeSet<String>> = Vec::new();
    for (user, those) in &reached {
        let back = |other: &&str| reached.get(other).is_some_and(|reached| reached.contains(user));
        let circle: BTreeSet<String> = those.iter().copied().filter(back).map(Into::into).collect();
        if circle.len() > 1 && !found.contains(&circle) {
            found.push(circle);
        }
    }
    found
}

/// Everything that can be reached from `user`; itself only where it lies on a circle.
fn reached<'a>(user: &'a str, below: &BTreeMap<&'a str, Vec<&'a str>>) -> BTreeSet<&'a str> {
    let mut found = BTreeSet::new();
    let mut open = vec![user];
    while let Some(next) = open.pop() {
        for &used in below.get(next).into_iter().flatten() {
            if found.insert(used) {
                open.push(used);
            }
        }
    }
    found
}

/// The files of the circle, and below them each arrow among them with the names that it takes.
pub(super) fn describe(circle: &BTreeSet<String>, arrows: &Arrows) -> String {
    let files: Vec<&str> = circle.iter().map(String::as_str).collect();
    let mut text = format!("{} files use each other in a circle: {}", files.len(), files.join(", "));
    for ((user, used), names) in arrows {
        if circle.contains(user) && circle.contains(used) {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            text += &format!("\n    {user} -> {used}: {}", names.join(", "));
        }
    }
    text
}
