//! Orders in which files hold the faces of a cube, by the names of axes or of sides.
//!
//! ```text
//!   px nx py ny pz nz                     the faces of graphics interfaces, see CubeHandedness
//! right left up down front back         photographs from the center: front is the middle of the panorama, Lobe's +x,
//! right is -y;                                         the lower edge of up and the upper edge of down are at the
//! front
//! ```
//!
//! Tools for panoramas make photographs, in many orders: front, right, back, left, up, down; right, left, up, down,
//! front, back.

use std::fmt;
use std::str::FromStr;

use lobe_sh::Rgb;

use crate::error::EnvError;
use crate::map::cube_handedness::CubeHandedness;
use crate::map::cube_map::CubeMap;
use crate::mapping::cube::FACES;

/// Names of axes, by face.
const AXES: [&[&str]; FACES] = [
    &["px", "+x", "posx", "xpos"],
    &["nx", "mx", "-x", "negx", "xneg"],
    &["py", "+y", "posy", "ypos"],
    &["ny", "my", "-y", "negy", "yneg"],
    &["pz", "+z", "posz", "zpos"],
    &["nz", "mz", "-z", "negz", "zneg"],
];

/// Names of sides, by the face that is called so.
const SIDES: [&[&str]; FACES] = [
    &["right", "rt", "r"],
    &["left", "lf", "l"],
    &["up", "top", "u", "t"],
    &["down", "bottom", "dn", "d"],
    &["front", "ft", "f"],
    &["back", "bk", "b"],
];

/// How faces are named, and so what they show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum FaceNames {
    /// By the axes of a graphics interface; [`CubeHandedness`] says for which directions.
    Axes,
    /// By sides: photographs from the center, front in the middle of the panorama.
    Sides,
}

/// The order in which a file, a picture or six files hold the faces of a cube.
///
/// ```
/// use lobe_env::{FaceNames, FaceOrder};
///
/// let order: FaceOrder = "front,right,back,left,up,down".parse()?;
/// assert_eq!((order.names(), order.to_string().as_str()), (FaceNames::Sides, "front,right,back,left,up,down"));
/// assert_eq!("FRBLUD".parse::<FaceOrder>()?, order);
/// # Ok::<(), lobe_env::EnvError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "String", into = "String"))]
pub struct FaceOrder {
    names: FaceNames,
    /// Of each face in the file, its number in the tables.
    faces: [usize; FACES],
}

impl FaceOrder {
    /// `px,nx,py,ny,pz,nz`, or `right,left,up,down,front,back`.
    #[must_use]
    pub fn usual(names: FaceNames) -> Self {
        Self { names, faces: [0, 1, 2, 3, 4, 5] }
    }

    /// How the faces are named.
    #[must_use]
    pub fn names(&self) -> FaceNames {
        self.names
    }

    /// The cube of faces in this order. The handedness is that of faces which are named by axes; photographs have none.
    pub(crate) fn cube(
        &self,
        size: usize,
        stored: [Vec<Rgb<f32>>; FACES],
        handedness: CubeHandedness,
    ) -> Result<CubeMap, EnvError> {
        let mut faces: [Vec<Rgb<f32>>; FACES] = Default::default();
        for (face, texels) in self.faces.into_iter().zip(stored) {
            faces[face] = texels;
        }
        match self.names {
            FaceNames::Axes => CubeMap::from_handed_faces(size, &faces, handedness),
            FaceNames::Sides => CubeMap::from_handed_faces(size, &of_photographs(size, faces), CubeHandedness::Left),
        }
    }
}

/// The faces of a left-handed cube, +X to -Z, from photographs of right, left, up, down, front and back.
///
/// Their +X is Lobe's -x, and their +Z its -y ([`CubeHandedness::Left`]), so the front, +x, is the face -X, and the
/// others follow around. The upper and the lower face of the cube have the face +Z, which shows what is on the right,
/// at their lower and upper edge: both photographs are turned by a quarter.
fn of_photographs(size: usize, faces: [Vec<Rgb<f32>>; FACES]) -> [Vec<Rgb<f32>>; FACES] {
    let [right, left, up, down, front, back] = faces;
    if [&up, &down].iter().any(|face| face.len() != size * size) {
        // The length is refused by what takes the faces.
        return [back, front, up, down, right, left];
    }
    let turned = |face: &[Rgb<f32>], place: &dyn Fn(usize, usize) -> [usize; 2]| {
        let at = |i: usize| {
            let [x, y] = place(i % size, i / size);
            face[y * size + x]
        };
        (0..size * size).map(at).collect()
    };
    let clockwise = turned(&up, &|x, y| [y, size - 1 - x]);
    let counterclockwise = turned(&down, &|x, y| [size - 1 - y, x]);
    [back, front, clockwise, counterclockwise, right, left]
}

impl FromStr for FaceOrder {
    type Err = EnvError;

    fn from_str(text: &str) -> Result<Self, EnvError> {
        let letters = |text: &str| text.chars().map(String::from).collect::<Vec<_>>();
        let text = text.to_ascii_lowercase();
        let words = match text.contains(',') {
            false if text.chars().count() == FACES => letters(&text),
            _ => text.split(',').map(|word| word.trim().to_owned()).collect(),
        };
        let wrong = |what: String| {
            EnvError::Options(format!(
                "expected the six faces in their order, such as front,right,back,left,up,down or px,nx,py,ny,pz,nz; {what}"
            ))
        };
        if words.len() != FACES {
            return Err(wrong(format!("found {} name(s)", words.len())));
        }
        let find = |table: &[&[&str]; FACES], word: &str| table.iter().position(|names| names.contains(&word));
        let is_axes = find(&AXES, &words[0]).is_some();
        let (names, table) = if is_axes { (FaceNames::Axes, &AXES) } else { (FaceNames::Sides, &SIDES) };
        let mut faces = [0; FACES];
        for (k, word) in words.iter().enumerate() {
            faces[k] = find(table, word).ok_or_else(|| wrong(format!("found {word:?}")))?;
            if faces[..k].contains(&faces[k]) {
                return Err(wrong(format!("found {} twice", table[faces[k]][0])));
            }
        }
        Ok(Self { names, faces })
    }
}

impl fmt::Display for FaceOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let table = match self.names {
            FaceNames::Axes => &AXES,
            FaceNames::Sides => &SIDES,
        };
        f.write_str(&self.faces.map(|face| table[face][0]).join(","))
    }
}

impl TryFrom<String> for FaceOrder {
    type Error = EnvError;

    fn try_from(text: String) -> Result<Self, EnvError> {
        text.parse()
    }
}

impl From<FaceOrder> for String {
    fn from(order: FaceOrder) -> Self {
        order.to_string()
    }
}

#[cfg(test)]
mod tests {
    use lobe_sh::Dir;

    use super::*;

    /// Light that differs in every direction.
    fn light(s: Dir) -> Rgb<f32> {
        Rgb::new(2.0 + s.x() as f32, 2.0 + s.y() as f32, 2.0 + s.z() as f32)
    }

    /// What a camera of 90 degrees sees that looks along `forward`, with `up` upwards.
    fn photograph(size: usize, forward: [f64; 3], right: [f64; 3], up: [f64; 3]) -> Vec<Rgb<f32>> {
        let at = |i: usize| 2.0 * (i as f64 + 0.5) / size as f64 - 1.0;
        let texel = |i: usize| {
            let (a, b) = (at(i % size), at(i / size));
            light(Dir::new([0, 1, 2].map(|k| forward[k] + a * right[k] - b * up[k])).unwrap())
        };
        (0..size * size).map(texel).collect()
    }

    #[test]
    fn photographs_of_the_six_sides_are_the_cube_with_the_front_in_the_middle_of_the_panorama() {
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let minus = |v: [f64; 3]| v.map(|c| 0.0 - c);
        let size = 5;
        let sides = [
            ("right", photograph(size, minus(y), minus(x), z)),
            ("left", photograph(size, y, x, z)),
            ("up", photograph(size, z, minus(y), minus(x))),
            ("down", photograph(size, minus(z), minus(y), x)),
            ("front", photograph(size, x, minus(y), z)),
            ("back", photograph(size, minus(x), y, z)),
        ];
        for order in ["right,left,up,down,front,back", "FRBLUD", "bk,lf,ft,rt,dn,top"] {
            let order: FaceOrder = order.parse().unwrap();
            let stored = order.faces.map(|face| sides[face].1.clone());
            let cube = order.cube(size, stored, CubeHandedness::Right).unwrap();
            for (face, x, y) in (0..6).flat_map(|f| (0..size).flat_map(move |x| (0..size).map(move |y| (f, x, y)))) {
                let (found, expected) = (cube.texel(face, x, y).to_array(), light(cube.dir(face, x, y)).to_array());
                let error = (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f32::max);
                assert!(error < 1e-6, "{order}: face {face}, {x}, {y}: {found:?} for {expected:?}");
            }
        }
    }

    #[test]
    fn an_order_is_six_names_of_one_kind() {
        let usual = |names| FaceOrder::usual(names).to_string();
        assert_eq!(usual(FaceNames::Axes), "px,nx,py,ny,pz,nz", "axes");
        assert_eq!("+X,-X,+Y,-Y,+Z,-Z".parse::<FaceOrder>().unwrap().to_string(), usual(FaceNames::Axes), "signs");
        assert_eq!("rludfb".parse::<FaceOrder>().unwrap().to_string(), usual(FaceNames::Sides), "letters");
        for bad in ["", "front", "front,right,back,left,up,up", "px,nx,py,ny,pz,back", "frblux", "a,b,c,d,e,f"] {
            let error = bad.parse::<FaceOrder>().unwrap_err().to_string();
            assert!(error.contains("six faces") && !error.contains('\n'), "{bad}: {error}");
        }
    }
}
