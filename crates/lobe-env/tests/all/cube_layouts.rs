//! Cube layouts: orientation of the faces in pictures and files, with colored faces that bear letters.

use lobe_env::{
    CubeHandedness, CubeLayout, CubeMap, CubeMipChain, CubeWriteOptions, EnvError, FaceAssumption, FaceOrder,
    MapReadOption, MapReadOptions, MappedMap, Mapping, PictureWriteOptions, Resample, TexelFormat, read_map,
    read_map_bytes, resample, write_cube,
};
use lobe_image::{Picture, encode_picture};
use lobe_io::Job;
use lobe_sh::{Dir, Rgb};

/// The colors of the faces +X, -X, +Y, -Y, +Z, -Z.
const COLORS: [[f32; 3]; 6] =
    [[1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]];

/// The letter F: it differs from all its rotations and mirror images, and from P, G, R, L and J.
const LETTERS: [[&str; 5]; 6] = [
    ["XXX", "X..", "XX.", "X..", "X.."], // F
    ["XXX", "X.X", "XXX", "X..", "X.."], // P
    ["X..", "X..", "X..", "X..", "XXX"], // L
    ["XX.", "X.X", "XX.", "X.X", "X.X"], // R
    ["XXX", "X..", "X.X", "X.X", "XXX"], // G
    ["..X", "..X", "..X", "X.X", "XXX"], // J
];
const SIZE: usize = 7;

fn color(face: usize) -> Rgb<f32> {
    Rgb::from(COLORS[face])
}

/// Face `face` as it is printed in this file: a white letter on its color, off the middle.
fn lettered(face: usize) -> Vec<Rgb<f32>> {
    (0..SIZE * SIZE)
        .map(|i| {
            let (x, y) = (i % SIZE, i / SIZE);
            let row = LETTERS[face].get(y.wrapping_sub(1)).map_or("", |row| row);
            if row.as_bytes().get(x.wrapping_sub(1)) == Some(&b'X') { Rgb::new(1.0, 1.0, 1.0) } else { color(face) }
        })
        .collect()
}

fn lettered_cube() -> CubeMap {
    CubeMap::from_faces(SIZE, &[0, 1, 2, 3, 4, 5].map(lettered)).expect("faces of one size")
}

#[test]
fn no_turn_or_mirror_image_of_a_letter_is_itself() {
    for face in 0..6 {
        let original = lettered(face);
        for turn in 1..8 {
            let at = |x: usize, y: usize| {
                let (x, y) = if turn & 1 == 0 { (x, y) } else { (y, x) };
                let (x, y) =
                    (if turn & 2 == 0 { x } else { SIZE - 1 - x }, if turn & 4 == 0 { y } else { SIZE - 1 - y });
                original[y * SIZE + x]
            };
            let same = (0..SIZE * SIZE).all(|i| at(i % SIZE, i / SIZE) == original[i]);
            assert!(!same, "face {face} is its own image under symmetry {turn}");
        }
    }
}

#[test]
fn a_face_of_each_color_lies_in_its_direction() {
    let cube = lettered_cube();
    // The cube's y-up axes in Lobe's.
    let centers = [Dir::X, -Dir::X, Dir::Z, -Dir::Z, -Dir::Y, Dir::Y];
    for (face, s) in centers.into_iter().enumerate() {
        // A little beside the center, where there is no letter.
        let beside = s.to_array().map(|c| c + 0.9 * if c == 0.0 { 1.0 } else { 0.0 });
        let found = cube.radiance(Dir::new(beside).unwrap());
        let distance = (0..3).map(|k| (found.to_array()[k] - COLORS[face][k]).abs()).fold(0.0, f32::max);
        assert!(distance < 0.5, "face {face}: {found:?}");
    }
}

/// The view from the center along `forward`, as a photograph with a field of view of a right angle.
fn photograph(cube: &CubeMap, forward: [f64; 3], right: [f64; 3], up: [f64; 3]) -> Vec<Rgb<f32>> {
    let cross =
        [right[1] * up[2] - right[2] * up[1], right[2] * up[0] - right[0] * up[2], right[0] * up[1] - right[1] * up[0]];
    assert_eq!(cross.map(|c| c + 0.0), forward.map(|c| -c + 0.0), "a camera's right x up is backwards");
    (0..SIZE * SIZE)
        .map(|i| {
            let at = |i: usize| (2 * i + 1) as f64 / SIZE as f64 - 1.0;
            let (a, b) = (at(i % SIZE), -at(i / SIZE));
            cube.radiance(Dir::new([0, 1, 2].map(|k| forward[k] + a * right[k] + b * up[k])).expect("not the origin"))
        })
        .collect()
}

#[test]
fn left_handed_faces_are_photographs_and_right_handed_ones_their_mirror_images() {
    let cube = CubeMap::from_handed_faces(SIZE, &[0, 1, 2, 3, 4, 5].map(lettered), CubeHandedness::Left).unwrap();
    // (X, Y, Z)_left = (-x, z, -y): the camera of each face, in Lobe's axes: forward, right, up.
    let cameras = [
        ([-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
        ([1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]),
        ([0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        ([0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]),
        ([0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
    ];
    for (face, (forward, right, up)) in cameras.into_iter().enumerate() {
        let seen = photograph(&cube, forward, right, up);
        for (i, (a, b)) in seen.iter().zip(lettered(face)).enumerate() {
            let error = (0..3).map(|k| (a.to_array()[k] - b.to_array()[k]).abs()).fold(0.0, f32::max);
            assert!(error < 1e-5, "face {face}, pixel {i}: the camera sees {a:?}, the face has {b:?}");
        }
    }
    let right = cube.faces(CubeHandedness::Right);
    for row in 0..SIZE {
        let letters = lettered(0);
        let mirrored: Vec<_> = letters[row * SIZE..][..SIZE].iter().rev().copied().collect();
        assert_eq!(right[1][row * SIZE..][..SIZE], mirrored, "row {row} of -X is that of the left-handed +X, reversed");
    }
}

#[test]
fn every_layout_comes_back_as_it_went_out() {
    let cube = lettered_cube();
    for handedness in [CubeHandedness::Right, CubeHandedness::Left] {
        for layout in CubeLayout::ALL {
            let picture = cube.to_picture(layout, handedness);
            assert_eq!(CubeLayout::of_picture(picture.width(), picture.height()).unwrap(), layout, "{layout:?}");
            let back = CubeMap::from_picture(&picture, handedness).unwrap();
            assert!(back == cube, "{layout:?} {handedness:?} changed the cube");
        }
        let back = CubeMap::from_handed_faces(SIZE, &cube.faces(handedness), handedness).unwrap();
        assert!(back == cube, "six pictures, {handedness:?}, changed the cube");
    }
}

#[test]
fn textures_of_either_hand_come_back_with_all_levels() {
    let folder = tempfile::tempdir().unwrap();
    let chain = CubeMipChain::averaged(lettered_cube());
    let options = CubeWriteOptions::default().texels(TexelFormat::Rgba32F);
    for name in ["letters.ktx2", "letters.dds"] {
        let path = folder.path().join(name);
        write_cube(&path, &chain.clone().of_handedness(CubeHandedness::Left), &options).unwrap();
        let written = read_map(&path, &MapReadOptions::default()).unwrap().0.into_chain().unwrap();
        // The file holds what six files for left-handed directions hold: each face by itself.
        for (level, original) in written.levels().iter().zip(chain.levels()) {
            let faces = original.faces(CubeHandedness::Left);
            for (face, expected) in faces.iter().enumerate() {
                assert!(level.face(face) == *expected, "{name}: face {face} of {}", level.size());
            }
        }
        // The letter of -X is on +X, and its first row is read from the right.
        let letters = lettered(1);
        let row: Vec<_> = letters[SIZE..2 * SIZE].iter().rev().copied().collect();
        assert_eq!(written.base().face(0)[SIZE..2 * SIZE], row, "{name}: the letter's first row");
        assert!(written.of_handedness(CubeHandedness::Left) == chain, "{name}: and back");
        let left = options.clone().handedness(CubeHandedness::Left);
        write_cube(&path, &chain, &left).unwrap();
        let (found, report) = read_map(&path, &MapReadOptions::default()).unwrap();
        let is_kept = name.ends_with("ktx2");
        assert_eq!(found.into_chain().unwrap() == chain, is_kept, "{name}: {:?}", report.picture.notes);
        let told = read_map(&path, &MapReadOptions::default().handedness(CubeHandedness::Left)).unwrap().0;
        assert!(told.into_chain().unwrap() == chain, "{name}: told all the same");
    }
}

#[test]
fn textures_of_another_tool_are_read_the_right_way_round() {
    let folder = std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    for name in ["letters-rgba16f.ktx2", "letters-rgb9e5.ktx2"] {
        let (map, report) = read_map(folder.join(name), &MapReadOptions::default()).unwrap();
        let (chain, report) = (map.into_chain().unwrap(), report.picture);
        assert!(*chain.base() == lettered_cube(), "{name}: other letters");
        assert_eq!((report.width, report.levels), (SIZE, 3), "{name}: size and levels");
        for level in &chain.levels()[1..] {
            for face in 0..6 {
                assert!(level.face(face).iter().all(|t| *t == color(face)), "{name}: face {face} of {}", level.size());
            }
        }
    }
}

#[test]
fn crosses_can_be_folded() {
    // Texels on both sides of every fold of a cross are neighbors on the sphere.
    let cube = CubeMap::from_fn(SIZE, |s| Rgb::new(s.x() as f32, s.y() as f32, s.z() as f32));
    for (layout, folds) in [
        (
            CubeLayout::HorizontalCross,
            vec![([0, 1], [1, 1]), ([1, 1], [2, 1]), ([2, 1], [3, 1]), ([1, 0], [1, 1]), ([1, 1], [1, 2])],
        ),
        (
            CubeLayout::VerticalCross,
            vec![([0, 1], [1, 1]), ([1, 1], [2, 1]), ([1, 0], [1, 1]), ([1, 1], [1, 2]), ([1, 2], [1, 3])],
        ),
    ] {
        let picture = cube.to_picture(layout, CubeHandedness::Right);
        let at = |x: usize, y: usize| Rgb::from(picture.pixel(x, y));
        for ([ax, ay], [bx, by]) in folds {
            for k in 0..SIZE {
                let ((px, py), (qx, qy)) = if ay == by {
                    ((bx * SIZE - 1, ay * SIZE + k), (bx * SIZE, by * SIZE + k))
                } else {
                    ((ax * SIZE + k, by * SIZE - 1), (bx * SIZE + k, by * SIZE))
                };
                let (p, q) = (at(px, py).to_array().map(f64::from), at(qx, qy).to_array().map(f64::from));
                let angle = Dir::new(p).unwrap().angle_to(Dir::new(q).unwrap());
                assert!(angle < 2.0 / SIZE as f64, "{layout:?}: ({px}, {py}) and ({qx}, {qy}) are {angle} rad apart");
            }
        }
    }
}

#[test]
fn letters_survive_every_mapping() {
    let cube = MappedMap::from(lettered_cube());
    for mapping in Mapping::ALL {
        let width = if mapping == Mapping::Cube { 60 } else { 300 };
        let there = resample(&cube, &Resample::to(mapping, width, mapping.height_for(width)), Job::default()).unwrap();
        let back = resample(&there, &Resample::to(Mapping::Cube, SIZE, 6 * SIZE), Job::default()).unwrap();
        let wrong = back
            .texels()
            .iter()
            .zip(cube.texels())
            .filter(|(a, b)| (0..3).any(|k| (a.to_array()[k] - b.to_array()[k]).abs() > 0.45));
        let wrong = wrong.count();
        assert_eq!(wrong, 0, "{mapping}: texels of another color after the way there and back");
    }
}

#[test]
fn pictures_of_no_cube_are_refused_in_one_line() {
    let picture = Picture::filled(8, 8, color(0));
    let error = CubeMap::from_picture(&picture, CubeHandedness::Right).unwrap_err().to_string();
    let expected = "a picture of a cube is 4:3 (horizontal cross), 3:4 (vertical cross), 6:1 (row) or 1:6 (column), but this is 8 x 8";
    assert_eq!(error, expected, "8 x 8");
}

#[test]
fn a_sun_beyond_half_floats_keeps_its_light_by_default() {
    let folder = tempfile::tempdir().unwrap();
    // A cube of 1 with a sun in one texel of a face: nearly all of the light is above 65504, or none of it.
    for (sun, default) in [(1e7_f32, TexelFormat::Rgba32F), (6e4, TexelFormat::Rgba16F)] {
        let mut texels = vec![Rgb::new(1.0_f32, 1.0, 1.0); 6 * 16];
        texels[3] = Rgb::new(sun, sun, sun);
        let chain = CubeMipChain::single(CubeMap::new(4, texels).unwrap());
        let all = chain.base().mean().r;
        for name in ["a.ktx2", "a.dds"] {
            let path = folder.path().join(name);
            let options = CubeWriteOptions::default();
            assert_eq!(options.texels_for(&path, &chain), default, "{name}, sun {sun}");
            let report = write_cube(&path, &chain, &options).unwrap();
            let (back, _) = read_map(&path, &MapReadOptions::default()).unwrap();
            let kept = back.base().mean().r / all;
            assert!((kept - 1.0).abs() < 1e-3 && report.lost == 0.0, "{name}, sun {sun}: {kept} kept, {report:?}");
            for format in [TexelFormat::Rgba16F, TexelFormat::Rgb9e5, TexelFormat::R11G11B10F, TexelFormat::Bc6h] {
                let report = write_cube(&path, &chain, &options.clone().texels(format)).unwrap();
                let (back, _) = read_map(&path, &MapReadOptions::default()).unwrap();
                let lost = 1.0 - back.base().mean().r / all;
                // Blocks change the texels beside the sun too.
                assert!((report.lost - lost).abs() < 0.02, "{name} {format}, sun {sun}: {lost}, {report:?}");
            }
        }
    }
}

#[test]
fn rows_and_sheets_of_photographs_in_any_order_are_one_panorama() {
    let light = |s: Dir| Rgb::new(2.0 + s.x() as f32, 2.0 + s.y() as f32, 2.0 + s.z() as f32);
    // Faces of a cube of graphics interfaces, which are photographs if they are left-handed, with the front towards -y.
    let size = 6;
    let turned = |s: Dir| light(Dir::new([-s.y(), s.x(), s.z()]).unwrap());
    let sides = CubeMap::from_fn(size, turned).faces(CubeHandedness::Left);
    let [right, left, up, down, front, back] = [0, 1, 2, 3, 4, 5];
    for (order, faces) in [
        ("right,left,up,down,front,back", [right, left, up, down, front, back]),
        ("front,right,back,left,up,down", [front, right, back, left, up, down]),
    ] {
        let named = MapReadOptions::default().faces(order.parse::<FaceOrder>().unwrap());
        for (columns, rows) in [(6, 1), (1, 6), (3, 2), (2, 3)] {
            let picture = Picture::from_fn(columns * size, rows * size, |x, y| {
                let face = &sides[faces[y / size * columns + x / size]];
                face[y % size * size + x % size].to_array()
            });
            let (bytes, _) =
                encode_picture("a.pfm".as_ref(), picture.width(), picture.pixels(), &PictureWriteOptions::default())
                    .unwrap();
            let (found, report) = read_map_bytes(&bytes, "a.pfm", &named).unwrap_or_else(|e| panic!("{order}: {e}"));
            let cube = found.into_base().into_cube_map().unwrap();
            for (face, x, y) in (0..6).flat_map(|f| (0..size).flat_map(move |x| (0..size).map(move |y| (f, x, y)))) {
                let (found, expected) = (cube.texel(face, x, y).to_array(), light(cube.dir(face, x, y)).to_array());
                let error = (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f32::max);
                assert!(error < 1e-6, "{order}, {columns} x {rows}, face {face}: {found:?} for {expected:?}");
            }
            assert_eq!(report.assumed, None, "{order}: told");
            // Without an order a row is assumed to have that of graphics interfaces, and a sheet is a photograph.
            match read_map_bytes(&bytes, "a.pfm", &MapReadOptions::default()) {
                Ok((_, report)) => assert_eq!(report.assumed, Some(FaceAssumption::RightHanded), "{columns} x {rows}"),
                Err(error) => {
                    assert!(matches!(error, EnvError::UnknownMapping { .. }), "{error}");
                    assert!([3, 2].contains(&columns), "{columns} x {rows}: {error}");
                }
            }
        }
    }
    let bytes = encode_picture("a.pfm".as_ref(), 8, &[[1.0; 3]; 32], &PictureWriteOptions::default()).unwrap().0;
    let named = MapReadOptions::default().mapping(Mapping::LatLong).faces("FRBLUD".parse::<FaceOrder>().unwrap());
    let error = read_map_bytes(&bytes, "a.pfm", &named).unwrap_err();
    assert!(matches!(error, EnvError::Contradiction { option: MapReadOption::Faces, .. }), "{error}");
}
