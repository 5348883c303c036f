//! The names of the six files of a cube, and the cubes among the names of a folder.

use std::collections::BTreeSet;

use crate::map::face_order::FaceNames;
use crate::mapping::cube::FACES;

/// The names of the faces +X, -X, +Y, -Y, +Z, -Z in the names of files, in any of [`cases`]. The first ones are
/// written, all are read.
pub(crate) const AXES: [[&str; FACES]; 6] = [
    ["px", "nx", "py", "ny", "pz", "nz"],
    ["px", "mx", "py", "my", "pz", "mz"],
    ["posx", "negx", "posy", "negy", "posz", "negz"],
    ["PosX", "NegX", "PosY", "NegY", "PosZ", "NegZ"],
    ["xpos", "xneg", "ypos", "yneg", "zpos", "zneg"],
    ["+x", "-x", "+y", "-y", "+z", "-z"],
];

/// The same of photographs of right, left, up, down, front and back.
pub(crate) const SIDES: [[&str; FACES]; 4] = [
    ["right", "left", "top", "bottom", "front", "back"],
    ["right", "left", "up", "down", "front", "back"],
    ["rt", "lf", "up", "dn", "ft", "bk"],
    ["r", "l", "u", "d", "f", "b"],
];

/// Digits of the numbers of files.
const DIGITS: [usize; 4] = [1, 2, 3, 4];

/// Six names, and what they name the faces by; none of numbers.
pub(crate) type Names = ([String; FACES], Option<FaceNames>);

/// All names that are read, those that are written first.
pub(crate) fn all_names() -> impl Iterator<Item = Names> {
    let named = |names: &'static [[&'static str; FACES]], kind| {
        names.iter().flat_map(cases).map(move |names| (names, Some(kind)))
    };
    let numbers = [0, 1].into_iter().flat_map(|first| DIGITS.map(|digits| (numbers_from(first, digits), None)));
    named(&AXES, FaceNames::Axes).chain(named(&SIDES, FaceNames::Sides)).chain(numbers)
}

/// Names in small letters, with a large one first, and in large ones.
fn cases(names: &[&str; FACES]) -> [[String; FACES]; 3] {
    let with_first_large = |name: &str| {
        let (first, rest) = name.split_at(1);
        first.to_ascii_uppercase() + rest
    };
    [names.map(str::to_owned), names.map(with_first_large), names.map(str::to_ascii_uppercase)]
}

fn numbers_from(first: usize, digits: usize) -> [String; FACES] {
    std::array::from_fn(|k| format!("{:0digits$}", first + k))
}

/// What the names of the files of a cube have before and after the name of the face.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Around {
    pub(crate) before: String,
    pub(crate) after: String,
}

/// The cubes of which all six names are there, in the order of the names.
///
/// A number is a whole one, with no digit beside it, and the numbers of a cube are six: a film has more. Each place of
/// a name is asked for only until a face is missing (test `a_long_film_is_looked_through_in_few_questions`).
pub(crate) fn cubes_among(
    names: &BTreeSet<String>,
    mut is_there: impl FnMut(&str) -> bool,
) -> impl Iterator<Item = Around> {
    let kinds: Vec<Names> = all_names().collect();
    names.iter().flat_map(move |name| {
        let mut cubes = Vec::new();
        for (faces, kind) in &kinds {
            for (at, first) in name.match_indices(&faces[0]) {
                let (before, after) = (&name[..at], &name[at + first.len()..]);
                let mut has = |face: &str| is_there(&format!("{before}{face}{after}"));
                let is_cube = match kind {
                    Some(_) => faces[1..].iter().all(|face| has(face)),
                    None => is_whole(before, after) && faces[1..].iter().all(|face| has(face)) && are_six(faces, has),
                };
                if is_cube {
                    cubes.push(Around { before: before.to_owned(), after: after.to_owned() });
                }
            }
        }
        cubes
    })
}

/// Whether a number between these is all of it.
fn is_whole(before: &str, after: &str) -> bool {
    !before.ends_with(|c: char| c.is_ascii_digit()) && !after.starts_with(|c: char| c.is_ascii_digit())
}

/// Whether the number before the first and that behind the last are missing.
fn are_six(faces: &[String; FACES], mut has: impl FnMut(&str) -> bool) -> bool {
    let digits = faces[0].len();
    let first = usize::from(faces[0].ends_with('1'));
    let mut others = (0..first).chain([first + FACES]);
    !others.any(|k| has(&format!("{k:0digits$}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The questions for each name: it may have a place of each kind of name.
    const QUESTIONS: usize = 4;

    #[test]
    fn a_long_film_is_looked_through_in_few_questions() {
        let mut asked = 0;
        let names: BTreeSet<String> = (0..10_000).map(|k| format!("frame_{k:04}.exr")).collect();
        let cubes = cubes_among(&names, |name| {
            asked += 1;
            names.contains(name)
        });
        assert_eq!(cubes.count(), 0, "cubes in a film");
        assert!(asked <= QUESTIONS * names.len(), "{asked} questions for {} names", names.len());
    }

    #[test]
    fn six_numbers_are_a_cube_and_seven_are_not() {
        let cubes = |first: usize, count: usize| {
            let names: BTreeSet<String> = (first..first + count).map(|k| format!("a{k:02}_b.png")).collect();
            cubes_among(&names, |name| names.contains(name))
                .map(|Around { before, after }| before + "%" + &after)
                .collect::<Vec<_>>()
        };
        for (first, count, is_cube) in [(0, 6, true), (1, 6, true), (0, 7, false), (0, 5, false), (2, 6, false)] {
            let expected: &[&str] = if is_cube { &["a%_b.png"] } else { &[] };
            assert_eq!(cubes(first, count), expected, "{count} from {first}");
        }
    }
}
