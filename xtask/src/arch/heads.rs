//! Heads: the first lines of a room, which say what it may use: `Uses basis, sphere.` or `Uses no other room.`

use std::collections::BTreeSet;

use super::modules::Sources;
use super::rooms::Plan;

/// One fault for each room whose head names other rooms than its code uses.
pub(super) fn faults(plan: &Plan, sources: &Sources) -> Vec<String> {
    let mut faults = Vec::new();
    for room in &plan.rooms {
        let door = format!("{room}/mod.rs");
        let Some(text) = sources.get(&door) else { continue };
        let built: BTreeSet<String> =
            plan.arrows.keys().filter(|(user, _)| user == room).map(|(_, used)| used.clone()).collect();
        if said(text).as_ref() != Some(&built) {
            faults.push(format!("{door}: expected the head to say `{}`", sentence(&built)));
        }
    }
    faults
}

/// The rooms that the head names; `None` if it has no such sentence.
fn said(text: &str) -> Option<BTreeSet<String>> {
    let comments = text.lines().map_while(|row| row.strip_prefix("//").or(row.is_empty().then_some("")));
    let words: Vec<&str> = comments.flat_map(|row| row.trim_start_matches('!').split_whitespace()).collect();
    let start = words.iter().rposition(|&word| word == "Uses")? + 1;
    let end = start + words[start..].iter().position(|word| word.ends_with('.'))? + 1;
    let list = words[start..end].join(" ").replace(" and ", ", ");
    let names = list.trim_end_matches('.').split(", ").map(|name| name.trim_matches(['`', '[', ']']).to_string());
    Some(if list == "no other room." { BTreeSet::new() } else { names.collect() })
}

/// The sentence that names these rooms.
fn sentence(rooms: &BTreeSet<String>) -> String {
    let names: Vec<String> = rooms.iter().map(|room| format!("`{room}`")).collect();
    match names.split_last() {
        None => "Uses no other room.".into(),
        Some((last, [])) => format!("Uses {last}."),
        Some((last, others)) => format!("Uses {} and {last}.", others.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arch::{rooms, uses};

    #[test]
    fn the_sentence_is_read_as_it_is_written() {
        for names in [&[][..], &["a"], &["a", "b_c"], &["a", "b", "c"]] {
            let rooms: BTreeSet<String> = names.iter().map(|name| (*name).to_string()).collect();
            let text = format!("//! Words. Used often.\n//!\n//! Read. {}\n\nmod x;\n", sentence(&rooms));
            assert_eq!(said(&text), Some(rooms), "{text}");
        }
        assert_eq!(said("//! Uses a\n//! and `b`. More.\n"), Some(["a", "b"].map(String::from).into()), "two rows");
        assert_eq!(said("//! Words.\nfn f() {} // Uses a.\n"), None, "no head");
    }

    #[test]
    fn a_head_that_names_other_rooms_than_the_code_uses_is_a_fault() {
        let faults_of = |head: &str| {
            let files = [
                ("lib.rs", "mod a; mod b;".to_string()),
                ("a/mod.rs", format!("//! A. {head}\nuse crate::b::B;")),
                ("b/mod.rs", "//! B. Uses no other room.\npub struct B;".into()),
            ];
            let sources: Sources = files.into_iter().map(|(path, text)| (path.to_string(), text)).collect();
            faults(&rooms::plan(&uses::code(&sources).unwrap(), &sources), &sources)
        };
        assert_eq!(faults_of("Uses `b`."), [""; 0], "as it is");
        for wrong in ["", "Uses no other room.", "Uses `b` and `c`."] {
            assert_eq!(faults_of(wrong), ["a/mod.rs: expected the head to say `Uses `b`.`"], "{wrong}");
        }
    }
}
