//! Tests of the checks on small made-up crates.

use super::blocks::{self, Block};
use super::modules::Sources;
use super::rooms::{self, Plan};
use super::uses::{self, Code};
use super::{circles, draw};

fn sources(files: &[(&str, &str)]) -> Sources {
    files.iter().map(|&(path, text)| (path.to_string(), text.to_string())).collect()
}

fn code(files: &[(&str, &str)]) -> Code {
    let code = uses::code(&sources(files)).unwrap();
    assert!(code.faults.is_empty(), "{:?}", code.faults);
    code
}

/// The arrows as `user -> used: names`.
fn arrows(files: &[(&str, &str)]) -> Vec<String> {
    let join = |names: &std::collections::BTreeSet<String>| names.iter().cloned().collect::<Vec<_>>().join(" ");
    code(files).arrows.iter().map(|((user, used), names)| format!("{user} -> {used}: {}", join(names))).collect()
}

fn circles_of(files: &[(&str, &str)]) -> Vec<Vec<String>> {
    circles::circles(&code(files).arrows).into_iter().map(|circle| circle.into_iter().collect()).collect()
}

#[test]
fn a_use_of_an_item_is_an_arrow_to_the_file_that_holds_it() {
    let found = arrows(&[
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "use crate::b::{N, Thing}; fn f(t: Thing) -> usize { t.x + N }"),
        ("b.rs", "pub(crate) struct Thing { pub(crate) x: usize } pub(crate) const N: usize = 1;"),
    ]);
    assert_eq!(found, ["a.rs -> b.rs: N Thing"], "one arrow");
}

#[test]
fn a_circle_by_direct_paths_is_found_with_the_names_that_tie_it() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c; mod d;"),
        ("a.rs", "use crate::b::B; pub struct A(B);"),
        ("b.rs", "use crate::c::c; pub struct B; fn f() { c() }"),
        ("c.rs", "use super::a::A; pub fn c() -> Option<A> { None }"),
        ("d.rs", "use crate::a::A; struct D(A);"),
    ];
    assert_eq!(circles_of(&files), [["a.rs", "b.rs", "c.rs"]], "d uses the circle and is not in it");
    let code = code(&files);
    let text = circles::describe(&circles::circles(&code.arrows)[0], &code.arrows);
    let expected = "3 files use each other in a circle: a.rs, b.rs, c.rs\n    a.rs -> b.rs: B\n    b.rs -> c.rs: c\n    c.rs -> a.rs: A";
    assert_eq!(text, expected, "each arrow within");
}

#[test]
fn a_circle_through_reexports_at_the_root_only_is_found() {
    let files = [
        ("lib.rs", "mod a; mod b; pub use a::A; pub(crate) use b::*;"),
        ("a.rs", "use crate::B; pub struct A(B);"),
        ("b.rs", "use crate::A; pub struct B(Option<Box<A>>);"),
    ];
    assert_eq!(circles_of(&files), [["a.rs", "b.rs"]], "the root is no part of it");
}

#[test]
fn separate_circles_are_told_apart_and_a_way_without_return_is_none() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c; mod d;"),
        ("a.rs", "use crate::b::B; use crate::c::C; pub struct A;"),
        ("b.rs", "use crate::a::A; pub struct B;"),
        ("c.rs", "use crate::d::D; pub struct C;"),
        ("d.rs", "use crate::c::C; pub struct D;"),
    ];
    assert_eq!(circles_of(&files), [["a.rs", "b.rs"], ["c.rs", "d.rs"]], "a uses c, c never a");
}

#[test]
fn paths_within_the_code_count_as_uses_do() {
    let found = arrows(&[
        ("lib.rs", "mod a; mod b { pub mod c; pub struct Here; }"),
        (
            "a.rs",
            "fn f(x: crate::b::c::T) -> usize { super::b::c::N + <u8 as crate::b::c::Tr>::M + Vec::<crate::b::c::G>::new().len() }
             fn g() { self::h(crate::b::c::E::V); } fn h<T>(_: T) {} struct I(crate::b::Here);",
        ),
        ("b/c.rs", "pub struct T; pub const N: usize = 0; pub trait Tr {} pub struct G; pub enum E { V }"),
    ]);
    assert_eq!(found, ["a.rs -> b/c.rs: E G N T Tr", "a.rs -> lib.rs: Here"], "all by inline paths");
}

#[test]
fn nested_use_trees_renames_and_modules_by_another_name_are_followed() {
    let found = arrows(&[
        ("lib.rs", "mod a; mod room; mod z;"),
        (
            "a.rs",
            "use crate::{room::{self as r, b::{self, B as Other}, c::*}, z as last};
             fn f(_: Other) { r::b::g(); b::h(); only_of_c(); last::end(); }",
        ),
        ("room/mod.rs", "//! A room.\npub mod b; pub mod c;"),
        ("room/b.rs", "pub struct B; pub fn g() {} pub fn h() {}"),
        ("room/c.rs", "pub fn only_of_c() {} pub fn never_named() {}"),
        ("z.rs", "pub fn end() {}"),
    ]);
    let expected = ["a.rs -> room/b.rs: B g h", "a.rs -> room/c.rs: only_of_c", "a.rs -> z.rs: end"];
    assert_eq!(found, expected, "nothing that is not named");
}

#[test]
fn a_use_within_a_function_counts() {
    let found =
        arrows(&[("lib.rs", "mod a; mod b;"), ("a.rs", "fn f() { use crate::b::g; g(); }"), ("b.rs", "pub fn g() {}")]);
    assert_eq!(found, ["a.rs -> b.rs: g"], "one arrow");
}

#[test]
fn chains_of_reexports_end_at_the_file_that_defines() {
    let found = arrows(&[
        ("lib.rs", "mod a; mod room; pub use room::Deep as Shallow;"),
        ("a.rs", "use crate::Shallow; struct A(Shallow);"),
        ("room/mod.rs", "//! A room.\nmod inner; pub use inner::*;"),
        ("room/inner/mod.rs", "//! Within.\nmod deep; pub use self::deep::Deep;"),
        ("room/inner/deep.rs", "pub struct Deep;"),
    ]);
    assert_eq!(found, ["a.rs -> room/inner/deep.rs: Deep"], "neither root nor mod.rs");
}

#[test]
fn handing_on_what_lies_below_is_no_use_but_handing_on_from_elsewhere_is() {
    let found = arrows(&[
        ("lib.rs", "mod room; mod other; pub use other::O;"),
        ("room/mod.rs", "//! A room.\nmod b; pub use b::B; pub use crate::other::O;"),
        ("room/b.rs", "pub struct B;"),
        ("other.rs", "pub struct O;"),
    ]);
    assert_eq!(found, ["room/mod.rs -> other.rs: O"], "b and O at the root are only handed on");
}

#[test]
fn what_a_mod_rs_defines_is_its_own_and_what_it_uses_counts() {
    let files = [
        ("lib.rs", "mod room;"),
        ("room/mod.rs", "//! A room.\nmod b; pub use b::B; pub const N: usize = 1; pub fn f(_: B) {}"),
        ("room/b.rs", "use super::N; pub struct B([u8; N]);"),
    ];
    let expected = ["room/b.rs -> room/mod.rs: N", "room/mod.rs -> room/b.rs: B"];
    assert_eq!(arrows(&files), expected, "both ways");
    assert_eq!(circles_of(&files), [["room/b.rs", "room/mod.rs"]], "a circle");
}

#[test]
fn what_only_tests_use_is_no_arrow() {
    let found = arrows(&[
        ("lib.rs", "mod a; mod b; #[cfg(test)] mod kit;"),
        (
            "a.rs",
            "#[cfg(test)] use crate::b::B; #[cfg(all(test, unix))] fn f(_: crate::b::B) {}
             struct A; impl A { #[cfg(test)] fn g(_: crate::b::B) {} #[test] fn h() { crate::b::B; } }
             fn i() { #[cfg(test)] let _ = crate::b::B; }
             #[cfg(test)] mod tests { use super::*; use crate::b::B; mod more; }",
        ),
        ("a/tests/more.rs", "use crate::b::B;"),
        ("b.rs", "pub struct B;"),
        ("kit.rs", "mod inner; use crate::b::B;"),
        ("kit/inner.rs", "use crate::b::B;"),
    ]);
    assert!(found.is_empty(), "{found:?}");
}

#[test]
fn a_function_with_the_name_of_its_module_is_found_behind_it() {
    let found = arrows(&[
        ("lib.rs", "mod project; mod index; mod a; pub use project::project; pub use index::index;"),
        ("a.rs", "use crate::{index, project}; fn f() { project(index(0)); index::more(); }"),
        ("project.rs", "pub fn project(_: usize) {}"),
        ("index.rs", "pub fn index(i: usize) -> usize { i } pub fn more() {}"),
    ]);
    assert_eq!(found, ["a.rs -> index.rs: index more", "a.rs -> project.rs: project"], "both meanings");
}

#[test]
fn files_of_one_name_in_two_rooms_are_two_files() {
    let files = [
        ("lib.rs", "mod left; mod right;"),
        ("left/mod.rs", "//! Left.\npub mod cube;"),
        ("left/cube.rs", "use crate::right::cube::Cube; pub struct Other(Cube);"),
        ("right/mod.rs", "//! Right.\npub mod cube;"),
        ("right/cube.rs", "pub struct Cube;"),
    ];
    assert_eq!(arrows(&files), ["left/cube.rs -> right/cube.rs: Cube"], "one way");
    assert!(circles_of(&files).is_empty(), "no circle");
}

#[test]
fn paths_in_macros_attributes_and_macros_by_name_count() {
    let found = arrows(&[
        ("lib.rs", "#[macro_use] mod m; mod a; mod b;"),
        (
            "a.rs",
            "use crate::b; fn f() { assert!(x.g() == crate::b::N, \"{}\", b::h(1)); twice!(); }
             #[arg(parser = crate::b::parse)] #[serde(default = \"crate::b::default\")] struct A;",
        ),
        ("b.rs", "pub const N: usize = 0; pub fn g() {} pub fn h() {} pub fn parse() {} pub fn default() {}"),
        ("m.rs", "macro_rules! twice { () => { $crate::b::g() } }"),
    ]);
    let expected = ["a.rs -> b.rs: N default h parse", "a.rs -> m.rs: twice", "m.rs -> b.rs: g"];
    assert_eq!(found, expected, "a.rs calls a method g, not b's");
}

#[test]
fn names_that_a_macro_makes_belong_to_the_file_that_calls_it() {
    let found = arrows(&[
        ("lib.rs", "mod a; mod b; pub use b::{Two, Three};"),
        ("a.rs", "use crate::Three; struct A(Three);"),
        ("b.rs", "macro_rules! make { ($($n:ident)*) => { $(pub struct $n;)* } } make!(Two Three);"),
    ]);
    assert_eq!(found, ["a.rs -> b.rs: Three"], "one arrow");
}

#[test]
fn a_variable_with_the_name_of_a_function_in_sight_is_no_use() {
    let found = arrows(&[
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "use crate::b::*; fn f(width: usize) -> usize { let area = width; area + g() }"),
        ("b.rs", "pub fn width() {} pub fn area() {} pub fn g() -> usize { 0 }"),
    ]);
    assert_eq!(found, ["a.rs -> b.rs: g"], "width and area are variables");
}

#[test]
fn other_crates_are_no_arrows_and_a_path_that_leads_nowhere_is_named() {
    let files = [
        ("lib.rs", "mod a; mod image;"),
        (
            "a.rs",
            "use std::fmt; use ::image::Rgb; use rayon::prelude::*; use crate::image::Missing; fn f(_: fmt::Error) {}",
        ),
        ("image.rs", "pub struct Rgb;"),
        ("stray.rs", ""),
    ];
    let code = uses::code(&sources(&files)).unwrap();
    assert!(code.arrows.is_empty(), "{:?}", code.arrows);
    let expected = ["no module declares stray.rs", "a.rs: crate::image::Missing leads to nothing that is known"];
    assert_eq!(code.faults, expected, "two faults");
}

/// Three rooms, one above the other, over a ground floor; `cli` uses a room.
const HOUSE: &[(&str, &str)] = &[
    ("lib.rs", "mod cli; mod error; mod sphere; mod basis; mod light; pub use sphere::Dir;"),
    ("cli.rs", "use crate::light::Lamp; fn f(_: Lamp) {}"),
    ("error.rs", "pub struct Fault;"),
    ("sphere/mod.rs", "//! Directions.\nmod dir; pub use dir::Dir;"),
    ("sphere/dir.rs", "use crate::error::Fault; pub struct Dir; fn f(_: Fault) {}"),
    ("basis/mod.rs", "//! The basis.\npub mod eval;"),
    ("basis/eval.rs", "use crate::Dir; pub fn eval(_: Dir) {}"),
    ("light/mod.rs", "// Generated.\n\n//! Lamps.\nmod lamp; pub use lamp::Lamp;"),
    ("light/lamp.rs", "use crate::{Dir, basis::eval::eval}; pub struct Lamp(Dir); fn f() { eval(Dir) }"),
];

const DRAWN: &str =
    "```rooms house\ncli     ->  light\nlight   ->  basis, sphere\nbasis   ->  sphere\nsphere  ->  nothing\n```\n";

fn plan(files: &[(&str, &str)]) -> Plan {
    rooms::plan(&code(files), &sources(files))
}

/// The house with some files replaced or added.
fn house<'a>(changes: &[(&'a str, &'a str)]) -> Vec<(&'a str, &'a str)> {
    let kept = HOUSE.iter().filter(|(path, _)| !changes.iter().any(|(changed, _)| changed == path));
    kept.copied().chain(changes.iter().copied()).collect()
}

fn faults(files: &[(&str, &str)], drawn: &str) -> Vec<String> {
    let blocks: Vec<Block> = blocks::parse(drawn).unwrap();
    rooms::faults("house", &plan(files), blocks.first())
}

#[test]
fn what_is_drawn_from_the_code_agrees_with_it() {
    assert_eq!(draw::block("house", &plan(HOUSE)).unwrap(), DRAWN, "users above what they use");
    let found = faults(HOUSE, DRAWN);
    assert!(found.is_empty(), "{found:?}");
}

#[test]
fn an_arrow_that_runs_the_wrong_way_between_rooms_fails() {
    let files = house(&[("sphere/dir.rs", "use crate::light::Lamp; pub struct Dir; fn f(_: Lamp) {}")]);
    let found = faults(&files, DRAWN);
    let circle = "house: rooms use each other in a circle: basis, light, sphere\n    basis -> sphere\n        basis/eval.rs -> sphere/dir.rs: Dir";
    assert!(found[0].starts_with(circle), "{}", found[0]);
    let missing =
        "house: sphere -> light is missing in ARCHITECTURE.md:\n    sphere/dir.rs -> light/lamp.rs: Lamp".to_string();
    assert!(found.len() == 2 && found.contains(&missing), "{found:?}");
    let found = faults(&files, &DRAWN.replace("sphere  ->  nothing", "sphere  ->  light"));
    let up = "house: sphere -> light does not point down: light needs a line below sphere's".to_string();
    assert!(found.len() == 2 && found.contains(&up), "{found:?}");
    assert!(draw::block("house", &plan(&files)).unwrap_err()[0].starts_with(circle), "nothing to draw");
}

#[test]
fn a_missing_and_a_surplus_arrow_of_the_block_are_named() {
    let drawn = DRAWN
        .replace("light   ->  basis, sphere", "light   ->  sphere")
        .replace("cli     ->  light", "cli -> light, basis");
    let expected = [
        "house: cli -> basis stands in ARCHITECTURE.md, but no file of cli uses basis",
        "house: light -> basis is missing in ARCHITECTURE.md:\n    light/lamp.rs -> basis/eval.rs: eval",
    ];
    assert_eq!(faults(HOUSE, &drawn), expected, "two faults");
}

#[test]
fn rooms_on_one_side_only_are_named() {
    let drawn = DRAWN.replace("basis   ->  sphere\n", "attic -> nothing\n").replace("basis, sphere", "sphere");
    let expected = [
        "house: ARCHITECTURE.md has a line for attic, which is neither a room nor a file that uses one",
        "house: basis is a room, but ARCHITECTURE.md has no line for it",
        "house: light -> basis is missing in ARCHITECTURE.md:\n    light/lamp.rs -> basis/eval.rs: eval",
    ];
    assert_eq!(faults(HOUSE, &drawn), expected, "one surplus, one missing");
    let found = faults(HOUSE, &DRAWN.replace("cli     ->  light\n", ""));
    assert_eq!(found, ["house: cli is a file that uses rooms, but ARCHITECTURE.md has no line for it"], "a file");
}

#[test]
fn lines_in_the_wrong_order_or_twice_are_named() {
    let drawn = DRAWN
        .replace("basis   ->  sphere\nsphere  ->  nothing", "sphere -> nothing\nbasis -> sphere\nsphere -> nothing");
    assert_eq!(faults(HOUSE, &drawn), ["house: ARCHITECTURE.md has two lines for sphere"], "twice");
    let drawn = DRAWN.replace("basis   ->  sphere\nsphere  ->  nothing", "sphere -> nothing\nbasis -> sphere");
    let expected = ["house: basis -> sphere does not point down: sphere needs a line below basis's"];
    assert_eq!(faults(HOUSE, &drawn), expected, "order");
}

#[test]
fn a_crate_with_rooms_needs_a_block_and_one_without_needs_none() {
    let found = faults(HOUSE, "");
    let expected = "house: ARCHITECTURE.md has no code block of language `rooms house`, which `cargo xtask arch --draw house` prints";
    assert_eq!(found, [expected], "one fault");
    let found = faults(&[("main.rs", "mod a;"), ("a.rs", "")], "");
    assert!(found.is_empty(), "{found:?}");
}

#[test]
fn a_file_of_the_ground_floor_that_uses_a_room_is_checked_like_one() {
    let files = house(&[
        ("error.rs", "use crate::helper::help; pub struct Fault; fn f() { help() }"),
        ("helper.rs", "pub fn help() { crate::basis::eval::more() }"),
        ("basis/eval.rs", "use crate::Dir; pub fn eval(_: Dir) {} pub fn more() {}"),
        ("lib.rs", "mod cli; mod error; mod helper; mod sphere; mod basis; mod light; pub use sphere::Dir;"),
    ]);
    let found = faults(&files, DRAWN);
    let circle = "house: rooms use each other in a circle: basis, error, helper, sphere";
    assert!(found[0].starts_with(circle), "basis uses sphere, sphere error, error helper, helper basis: {}", found[0]);
    assert!(
        found.contains(&"house: helper is a file that uses rooms, but ARCHITECTURE.md has no line for it".into()),
        "{found:?}"
    );
    let one_way =
        house(&[("error.rs", "use crate::light::Lamp; fn f(_: Lamp) {}"), ("sphere/dir.rs", "pub struct Dir;")]);
    let drawn = draw::block("house", &plan(&one_way)).unwrap();
    assert_eq!(drawn, DRAWN.replace("light   ->  basis", "error   ->  light\nlight   ->  basis"), "above what it uses");
}

#[test]
fn the_root_may_use_every_room_and_no_room_the_root() {
    let root = "mod cli; mod error; mod sphere; mod basis; mod light; pub use sphere::Dir; pub const N: usize = 1; fn f(_: light::Lamp) {}";
    let found = faults(&house(&[("lib.rs", root)]), DRAWN);
    assert!(found.is_empty(), "{found:?}");
    let lamp = "use crate::{Dir, N, basis::eval::eval}; pub struct Lamp(Dir); fn f() { eval(Dir); N; }";
    let found = faults(&house(&[("lib.rs", root), ("light/lamp.rs", lamp)]), DRAWN);
    let expected = "house: nothing may use the root of the crate where there are rooms: light/lamp.rs -> lib.rs: N";
    assert_eq!(found, [expected], "one fault");
}

#[test]
fn a_room_opens_with_words_and_holds_no_more_files_than_one_overlooks() {
    let silent = house(&[("basis/mod.rs", "pub mod eval;")]);
    let expected = ["house: basis/mod.rs does not open with a few lines (//!) on what lives there"];
    assert_eq!(faults(&silent, DRAWN), expected, "silent");
    let without: Vec<_> = house(&[("basis.rs", "//! The basis.\npub mod eval;")]);
    let without: Vec<_> = without.into_iter().filter(|(path, _)| *path != "basis/mod.rs").collect();
    assert_eq!(faults(&without, DRAWN), ["house: the room basis has no mod.rs"], "basis.rs is not its door");
    for (count, expected) in [(24, 0), (25, 1)] {
        // mod.rs and eval.rs are two of them.
        let names: Vec<String> = (2..count).map(|number| format!("f{number}")).collect();
        let door = format!("//! The basis.\npub mod eval; mod {};", names.join("; mod "));
        let paths: Vec<String> = names.iter().map(|name| format!("basis/{name}.rs")).collect();
        let mut changes: Vec<(&str, &str)> = paths.iter().map(|path| (path.as_str(), "")).collect();
        changes.push(("basis/mod.rs", &door));
        changes.push(("basis/eval.rs", "use crate::Dir; pub fn eval(_: Dir) {}"));
        let found = faults(&house(&changes), DRAWN);
        assert_eq!(found.len(), expected, "{count} files: {found:?}");
    }
}
