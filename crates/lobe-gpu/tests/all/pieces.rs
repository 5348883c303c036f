//! Work that is cut where bindings and textures of a device are too small: the same bytes as in one piece.

use lobe_env::project_env;
use lobe_gpu::{
    Context, ContextOptions, Environment, FieldResponse, GlossyMesh, GpuError, GpuMovingPart, GpuSphereShadows,
    MovingObstacles, MovingPlaces, SceneView, StillGrid, Storage, SurfaceShading,
};
use lobe_io::Job;
use lobe_prt::{
    BakeOptions, Channels, CompressOptions, CompressedTransfer, GlossyLobe, Lightmap, Receivers, Transfer, bake,
    bake_matrices,
};
use lobe_scene::{Bvh, Material, Mesh, MeshParts, Scene, Texture, TextureUse, Wrap, built_in};
use lobe_sh::{Rgb, Rotation, ShVec};
use lobe_shadow::{
    LogTable, LogTableOptions, PlacedField, Placement, ShadowFieldOptions, ShadowOptions, ShadowReceivers, SkyLight,
    SphereShadows,
};
use lobe_testkit::Random;

use crate::moving::{noise_field, placements, sky as small_sky, spheres};
use crate::scene_view::{cameras, options, painted, sky};
use crate::{device, pass_names, with};

/// The same device where a binding holds this many bytes.
fn narrow(context: &Context, bytes: u64) -> Context {
    with(context, &ContextOptions::default().max_storage_binding(bytes))
}

/// Positions in a cube, unit normals, colors.
fn points(count: usize, random: &mut Random) -> [Vec<[f32; 3]>; 3] {
    let mut three = || [0, 1, 2].map(|_| 2.0 * random.signed() as f32);
    let (positions, colors) = ((0..count).map(|_| three()).collect(), (0..count).map(|_| three()).collect());
    [positions, (0..count).map(|_| random.direction().map(|c| c as f32)).collect(), colors]
}

fn bits(colors: &[Rgb<f32>]) -> Vec<[u32; 3]> {
    colors.iter().map(|c| c.to_array().map(f32::to_bits)).collect()
}

#[test]
fn receivers_of_sphere_shadows_in_pieces_see_the_same() {
    let Some(context) = device("receivers_of_sphere_shadows_in_pieces_see_the_same") else { return };
    let mut random = Random::new(3);
    let order = 3;
    let table = LogTable::new(&LogTableOptions::default().order(order)).unwrap();
    let light = SkyLight::new(&small_sky(4), order).unwrap();
    let spheres = spheres(9, &mut random);
    let shadows = SphereShadows::new(&table, &spheres, &ShadowOptions::default().cut(0.0)).unwrap();
    // What the table and the grid need, and 48 rows of 9 colors of the light. Of receivers it holds a multiple of 64, whose parts of 36
    // bytes of visibility begin where they may: each has 48 bytes of its own.
    let table_bytes = 4 * (table.rows().len() + 8 * order) as u64;
    let least = table_bytes.max(48 * 9 * 16);
    let fitting = (least / 48 / 64 * 64) as usize;
    // One receiver; some that the last piece has fewer of than the others.
    for (count, pieces) in [(1, 1), (2 * fitting + 44, 3)] {
        let [positions, normals, _] = points(count, &mut random);
        let receivers = ShadowReceivers::new(&positions, &normals).unwrap();
        let seen = |context: &Context, most: u64| {
            let context = narrow(context, most);
            let mut shaded = GpuSphereShadows::new(&context, &table, &receivers, 9).unwrap();
            shaded.set_spheres(&shadows).unwrap();
            (bits(&shaded.irradiance(&light).unwrap()), pass_names(shaded.renderer()).len())
        };
        let (irradiance, one) = seen(&context, u64::MAX);
        let (cut_irradiance, several) = seen(&context, least);
        assert_eq!((one, several), (2, 2 * pieces), "passes, bindings of {least} bytes");
        assert_eq!(irradiance, cut_irradiance, "irradiance of {count} receivers");
        let expected = shadows.irradiance(&receivers, &light).unwrap();
        let worst = crate::relative_difference(
            crate::flat(&irradiance.iter().map(|c| Rgb::from(c.map(f32::from_bits))).collect::<Vec<_>>()),
            crate::flat(&expected),
        );
        assert!(worst < crate::TOLERANCE, "{count} receivers: {worst:e}");
    }
}

#[test]
fn a_moving_part_in_pieces_is_lit_the_same() {
    let Some(context) = device("a_moving_part_in_pieces_is_lit_the_same") else { return };
    let mut random = Random::new(31);
    let (order, count, n) = (2, 300, 4);
    let [positions, normals, albedos] = points(count, &mut random);
    let receivers = ShadowReceivers::new(&positions, &normals).unwrap().with_albedos(&albedos).unwrap();
    let rows = random.signed_vec(n * count).into_iter().map(|x| x as f32).collect();
    let transfer = Transfer::new(order, Channels::Gray, rows).unwrap();
    let numbers: Vec<f32> = random.signed_vec(9 * 27).into_iter().map(|x| x as f32).collect();
    // Of more bands than are used.
    let grid = StillGrid { order: 3, min: [-2.0; 3], step: [2.0; 3], counts: [3; 3], rows: &numbers };
    let table = LogTable::new(&LogTableOptions::default().order(order)).unwrap();
    let spheres = spheres(5, &mut random);
    let shadows = SphereShadows::new(&table, &spheres, &ShadowOptions::default()).unwrap();
    let field = noise_field(order, &mut random);
    let placed: Vec<PlacedField<'_>> =
        placements(2, &mut random).into_iter().map(|placement| PlacedField { field: &field, placement }).collect();
    let frame = placements(2, &mut random)[1];
    let light = ShVec::from_vec(crate::transfer::light(n)).unwrap();
    for response in [FieldResponse::Cosine, FieldResponse::Transfer(&transfer)] {
        let of = |most: u64| {
            let options = ShadowFieldOptions::default();
            let (fields, grids) = (placed.as_slice(), &[grid][..]);
            let obstacles = MovingObstacles { fields, options: &options, grids, table: &table, most_spheres: 5 };
            let narrow = narrow(&context, most);
            let mut part = GpuMovingPart::new(&narrow, order, &receivers, response, &obstacles).unwrap();
            let places = MovingPlaces { frame, fields, spheres: Some(&shadows), receivers: Some(receivers) };
            part.shade(&places, &light).unwrap();
            (bits(&part.radiance().unwrap()), pass_names(part.renderer()).len())
        };
        let ((whole, passes), (cut, more)) = (of(1 << 20), of(1 << 12));
        assert!(more > passes, "several pieces: {more} passes for {passes}");
        assert_eq!(cut, whole, "{response:?}");
    }
}

#[test]
fn fields_and_receivers_in_pieces_leave_the_same_light() {
    let Some(context) = device("fields_and_receivers_in_pieces_leave_the_same_light") else { return };
    let mut random = Random::new(29);
    let (order, count) = (3, 200);
    let n = order * order;
    let [positions, normals, albedos] = points(count, &mut random);
    let receivers = ShadowReceivers::new(&positions, &normals).unwrap().with_albedos(&albedos).unwrap();
    let table = LogTable::new(&LogTableOptions::default().order(order)).unwrap();
    let rows = random.signed_vec(3 * n * count).into_iter().map(|x| x as f32).collect();
    let transfer = Transfer::new(order, Channels::Rgb, rows).unwrap();
    // Of more bands than are used, and twice the same.
    let fields = [noise_field(order, &mut random), noise_field(order + 1, &mut random)];
    let options = ShadowFieldOptions::default().negligible(0.3);
    let light = ShVec::from_vec(crate::transfer::light(n)).unwrap();
    // 126 points of 12 and of 20 numbers: fields of 6048 and 10080 bytes, which are cut between points of the second. 64 receivers, as many
    // as parts of buffers need, find 15360 bytes in five entities and 6144 in two, and have transfer of 6912: entities, bytes of a binding,
    // parts of the fields that are looked up one by one, pieces of the receivers by cosine and by transfer.
    let cases = [(5, 16_000, 2, [4, 4]), (5, 15_360, 2, [4, 4]), (5, 16_400, 0, [1, 2]), (2, 6912, 3, [4, 4])];
    let responses = [FieldResponse::Cosine, FieldResponse::Transfer(&transfer)];
    for ((entities, most, parts, pieces), way) in cases.into_iter().flat_map(|case| [0, 1].map(|way| (case, way))) {
        let placed: Vec<PlacedField<'_>> = (placements(entities, &mut random).into_iter().enumerate())
            .map(|(k, placement)| PlacedField { field: &fields[k % 2], placement })
            .collect();
        let of = |most: u64| {
            let context = narrow(&context, most);
            let obstacles =
                MovingObstacles { fields: &placed, options: &options, grids: &[], table: &table, most_spheres: 0 };
            let mut part = GpuMovingPart::new(&context, order, &receivers, responses[way], &obstacles).unwrap();
            let frame = Placement::new([0.0; 3], Rotation::IDENTITY, 1.0);
            let places = MovingPlaces { frame, fields: &placed, spheres: None, receivers: None };
            part.shade(&places, &light).unwrap();
            let names = pass_names(part.renderer()).into_iter().filter(|name| !name.starts_with("sky light"));
            (bits(&part.radiance().unwrap()), names.collect::<Vec<String>>())
        };
        let (whole, names) = of(u64::MAX);
        assert_eq!(names, ["shadow fields 0"], "in one piece");
        let (cut, names) = of(most);
        let looked_up = names.iter().filter(|name| name.starts_with("look up")).count();
        let expected = [parts * pieces[way], (parts + 1) * pieces[way]];
        assert_eq!([looked_up, names.len()], expected, "bindings of {most} bytes, way {way}: {names:?}");
        assert_eq!(whole, cut, "bindings of {most} bytes: {names:?}");
    }
}

/// Draws a scene on a device with small bindings, and on one with large ones; returns the passes that draw surfaces on the first.
fn same_picture(what: &str, context: &Context, small: &Context, scene: &Scene, shading: &SurfaceShading<'_>) -> usize {
    let sky = sky();
    let light: ShVec<Rgb<f64>> = project_env(&sky, 4);
    let environment = Environment::from(&*sky);
    let drawn = |context: &Context| {
        let view = SceneView::new(context, scene, shading, Some(&environment), &options()).unwrap();
        view.set_camera(&cameras(scene).0).unwrap();
        view.set_light(&light).unwrap();
        if let SurfaceShading::Radiance(values) = shading {
            view.set_radiance(values).unwrap();
        }
        view.set_vertices(scene).unwrap();
        view.render().unwrap();
        let names = pass_names(view.renderer()).iter().filter(|name| name.starts_with("surfaces")).count();
        (view.picture().unwrap(), names, view.renderer().to_string())
    };
    let ((whole, one, _), (cut, several, table)) = (drawn(context), drawn(small));
    assert_eq!(one, 1, "{what} in one piece");
    let pairs = whole.pixels().iter().zip(cut.pixels());
    let differing = pairs.filter(|(a, b)| a.map(f32::to_bits) != b.map(f32::to_bits)).count();
    assert_eq!(differing, 0, "{what}: pixels differ in {several} pieces\n{table}");
    several
}

#[test]
fn surfaces_in_pieces_are_the_same_picture() {
    let Some(context) = device("surfaces_in_pieces_are_the_same_picture") else { return };
    let small = narrow(&context, 48 * 96);
    let scene = built_in::ball_over_ground(16);
    let pieces = same_picture("irradiance", &context, &small, &scene, &SurfaceShading::Irradiance(3));
    assert!(pieces > 3, "{pieces} pieces");
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let bvh = Bvh::new(&scene);
    let bake_options = BakeOptions::default().order(3).samples(16);
    let (transfer, _) = bake(&scene, &bvh, &receivers, &bake_options, Job::default()).unwrap();
    let demodulated = SurfaceShading::Demodulated(&transfer, Storage::F16);
    assert!(same_picture("demodulated", &context, &small, &scene, &demodulated) > 3, "pieces");
    // Vertices without holes are fetched, and drawn at once.
    let fetched = SurfaceShading::Vertices(&transfer, &[], Storage::F32);
    assert_eq!(same_picture("vertices", &context, &small, &scene, &fetched), 1, "pieces");
    // 16 vertices, as many as parts of buffers need, do not fit.
    let refused = SceneView::new(&narrow(&context, 1000), &scene, &fetched, None, &options());
    assert!(matches!(refused, Err(GpuError::Unsupported { .. })), "{:?}", refused.err());
}

#[test]
fn surfaces_that_shine_in_pieces_are_the_same_picture() {
    let Some(context) = device("surfaces_that_shine_in_pieces_are_the_same_picture") else { return };
    let small = narrow(&context, 16 * 9 * 128);
    let scene = built_in::ball_over_ground(16);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let bvh = Bvh::new(&scene);
    let bake_options = BakeOptions::default().order(3).samples(16);
    let (matrices, _) = bake_matrices(&scene, &bvh, &receivers, &bake_options, Job::default()).unwrap();
    let glossy = SurfaceShading::Glossy(&matrices, GlossyLobe::Ggx(0.3), Storage::F32);
    let pieces = same_picture("glossy", &context, &small, &scene, &glossy);
    assert!(pieces > 2, "{pieces} pieces");
    let (transfer, _) = bake(&scene, &bvh, &receivers, &bake_options, Job::default()).unwrap();
    let ground = scene.meshes()[0].positions().len();
    let of_ball = receivers.subset(&(ground..scene.vertex_count()).collect::<Vec<_>>()).unwrap();
    let (matrices, _) = bake_matrices(&scene, &bvh, &of_ball, &bake_options, Job::default()).unwrap();
    let ball = [GlossyMesh { mesh: 1, matrices: &matrices, lobe: GlossyLobe::Phong(4.0) }];
    same_picture("mixed", &context, &small, &scene, &SurfaceShading::Vertices(&transfer, &ball, Storage::F32));
}

/// Quads above each other, each with a texture of its own, the first with holes.
fn textured() -> Scene {
    let quad = |k: usize| {
        let z = 0.4 * k as f32;
        Mesh::new(MeshParts {
            name: format!("quad {k}"),
            positions: vec![[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z + 0.3]],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            uvs: [vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], Vec::new()],
            material: Some(k),
            ..MeshParts::default()
        })
        .unwrap()
    };
    let texels = |k: u32| {
        let texel = |i: u32| [(i * 37 + 90 * k) as u8, (i * 91) as u8, (50 * k) as u8, (i * 53 % 256) as u8];
        (0..256_u32).map(texel).collect()
    };
    let material = |k: usize| {
        let used = TextureUse { texture: k, uv_set: 0, uv_map: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };
        let alpha = if k == 0 { lobe_scene::Alpha::Mask(0.4) } else { lobe_scene::Alpha::Opaque };
        Material { base_color_texture: Some(used), alpha, ..Material::WHITE }
    };
    let textures = (0..3).map(|k| Texture::new(16, 16, texels(k), [Wrap::Repeat; 2])).collect();
    Scene::new((0..3).map(quad).collect(), (0..3).map(material).collect(), textures).unwrap()
}

#[test]
fn textures_and_holes_in_pieces_are_the_same_picture() {
    let Some(context) = device("textures_and_holes_in_pieces_are_the_same_picture") else { return };
    // One texture of 256 texels in a binding of 1024 bytes.
    let small = narrow(&context, 1024);
    for (name, scene, least) in [("textured", textured(), 3), ("painted", painted(), 1)] {
        let mut random = Random::new(4);
        let values: Vec<Rgb<f32>> = (0..scene.vertex_count())
            .map(|_| Rgb::new(random.unit() as f32, random.unit() as f32, random.unit() as f32))
            .collect();
        for shading in [SurfaceShading::Irradiance(3), SurfaceShading::Radiance(&values)] {
            let pieces = same_picture(name, &context, &small, &scene, &shading);
            assert!(pieces >= least, "{pieces} pieces of {name}");
        }
    }
    let line = SceneView::new(&narrow(&context, 960), &textured(), &SurfaceShading::Irradiance(3), None, &options())
        .expect_err("a texture is larger")
        .to_string();
    assert!(line.contains("at most 240 texels") && line.contains("found 256"), "{line}");
}

#[test]
fn a_lightmap_in_pieces_is_the_same_picture() {
    let Some(context) = device("a_lightmap_in_pieces_is_the_same_picture") else { return };
    let (scene, order, width) = (waves(), 2, 64);
    let lightmap = Lightmap::new(&scene, width).unwrap();
    let texels = width * width;
    let coefficients = Random::new(6).signed_vec(order * order * texels).into_iter().map(|c| c as f32).collect();
    let transfer = Transfer::new(order, Channels::Gray, coefficients).unwrap();
    let shading = SurfaceShading::Lightmap(&transfer, &lightmap, Storage::F32);
    // 20 rows of 64 texels of 16 bytes.
    let pieces = same_picture("lightmap", &context, &narrow(&context, 20 * 64 * 16), &scene, &shading);
    assert!(pieces > 3, "{pieces} pieces");
    let view = SceneView::new(&narrow(&context, 6 * 64 * 16), &scene, &shading, None, &options());
    let line = view.expect_err("triangles over more rows").to_string();
    assert!(line.contains("at most 6 rows of the lightmap"), "{line}");
}

/// A square of waves that is all of its lightmap.
fn waves() -> Scene {
    const CELLS: u32 = 8;
    let places: Vec<[f32; 2]> =
        (0..=CELLS).flat_map(|y| (0..=CELLS).map(move |x| [x, y].map(|k| k as f32 / CELLS as f32))).collect();
    let cell = |k: u32| {
        let first = k / CELLS * (CELLS + 1) + k % CELLS;
        [[first, first + 1, first + CELLS + 2], [first, first + CELLS + 2, first + CELLS + 1]]
    };
    let mesh = Mesh::new(MeshParts {
        name: "waves".into(),
        positions: places.iter().map(|[u, v]| [2.0 * u - 1.0, 2.0 * v - 1.0, 0.1 * (9.0 * u).sin()]).collect(),
        triangles: (0..CELLS * CELLS).flat_map(cell).collect(),
        uvs: [places, Vec::new()],
        ..MeshParts::default()
    });
    Scene::new(vec![mesh.unwrap()], Vec::new(), Vec::new()).unwrap()
}

#[test]
fn clusters_in_pieces_are_the_same_light() {
    let Some(context) = device("clusters_in_pieces_are_the_same_light") else { return };
    let scene = built_in::ball_over_ground(16);
    let transfer = crate::transfer::transfer(&scene, 3, Channels::Gray);
    let options = CompressOptions::default().clusters(4).components(4);
    let (clustered, _) = CompressedTransfer::new(&transfer, &options, Job::default()).unwrap();
    let (shading, small) = (SurfaceShading::Clusters(&clustered), narrow(&context, 16 * 128));
    same_picture("clusters", &context, &small, &scene, &shading);
    let view = SceneView::new(&small, &scene, &shading, None, &crate::scene_view::options()).unwrap();
    let pieces = pass_names(view.renderer()).iter().filter(|name| name.starts_with("weights")).count();
    assert!(pieces > 1, "{pieces} pieces");
}

#[test]
fn transfer_in_several_textures_is_the_same_picture() {
    let Some(context) = device("transfer_in_several_textures_is_the_same_picture") else { return };
    let scene = built_in::ball_over_ground(48);
    let order = 4;
    let numbers = Random::new(7).signed_vec(16 * scene.vertex_count()).into_iter().map(|c| c as f32).collect();
    let transfer = Transfer::new(order, Channels::Gray, numbers).unwrap();
    let bare = ContextOptions::default().without_storage(true);
    // 12 vertices in a row of 192 texels, as many as the picture has samples along a side.
    let (whole, small) = (with(&context, &bare), with(&context, &bare.clone().max_texture_side(192_u32)));
    assert!(scene.vertex_count() > 12 * 192, "{} vertices", scene.vertex_count());
    let shading = SurfaceShading::Vertices(&transfer, &[], Storage::F32);
    let pieces = same_picture("textures", &whole, &small, &scene, &shading);
    assert!(pieces > 1, "{pieces} textures");
}
