//! A ball in bevy, seen from each direction, lit by what the exported program does.
//!
//! `bevy_balls plain|sun FOLDER OUT.json SURFACES`: FOLDER has the exports in `plain/bevy` and `sun/bevy`, whose
//! programs are compiled into this one.

use std::fs;
use std::time::Duration;

use bevy::app::{AppExit, ScheduleRunnerPlugin};
use bevy::asset::UnapprovedPathMode;
use bevy::camera::{Exposure, Hdr, RenderTarget, ScalingMode};
use bevy::core_pipeline::Skybox;
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::prelude::*;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::window::ExitCondition;
use serde::Deserialize;

mod plain;
mod sun;

/// The width of the picture that is read.
const WIDTH: u32 = 9;

/// The bytes of one of its texels.
const TEXEL: usize = 16;

/// What `Exposure` makes of a luminance of 1 at an exposure value of 0.
const EXPOSURE: f32 = 1.0 / 1.2;

/// Frames that a picture may be behind what was set.
const LATE: u32 = 8;

/// What the ball emits until it is seen: pipelines are compiled while frames go by.
const GLOW: f32 = 1000.0;

/// The frames in which it must be seen.
const MOST_FRAMES: u32 = 20_000;

/// Roughness of the matte ball, by which bevy's diffuse reflection of lights is nearest to Lambert's.
const MATTE: f32 = 0.64;

#[derive(Deserialize)]
struct Surface {
    name: String,
    roughness: Option<f32>,
}

/// What is asked, and what was seen.
#[derive(Resource)]
struct Work {
    what: String,
    out: String,
    surfaces: Vec<Surface>,
    directions: Vec<[f32; 3]>,
    sky_directions: Vec<[f32; 3]>,
    step: usize,
    wait: u32,
    is_seen: bool,
    frames: u32,
    pixel: [f32; 3],
    seen: Vec<[f32; 3]>,
}

#[derive(Deserialize)]
struct Asked {
    surfaces: Vec<Surface>,
    directions: Vec<[f32; 3]>,
    sky: Vec<[f32; 3]>,
}

#[derive(Component)]
struct Ball;

fn main() {
    let [what, folder, out, asked] = std::env::args().skip(1).collect::<Vec<_>>().try_into().expect("four arguments");
    let asked: Asked = serde_json::from_str(&asked).expect("what is asked");
    let work = Work {
        what,
        out,
        surfaces: asked.surfaces,
        directions: asked.directions,
        sky_directions: asked.sky,
        step: 0,
        wait: 0,
        is_seen: false,
        frames: 0,
        pixel: [0.0; 3],
        seen: Vec::new(),
    };
    let window = WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
    let files = AssetPlugin { file_path: folder, unapproved_path_mode: UnapprovedPathMode::Allow, ..default() };
    App::new()
        .add_plugins(DefaultPlugins.set(window).set(files))
        .add_plugins(ScheduleRunnerPlugin::run_loop(Duration::from_millis(1)))
        .insert_resource(ClearColor(Color::BLACK))
        .insert_resource(GlobalAmbientLight { brightness: 0.0, ..default() })
        .insert_resource(work)
        .add_systems(Startup, set_up)
        .add_systems(Update, step)
        .run();
}

fn set_up(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
    assets: Res<AssetServer>,
    work: Res<Work>,
) {
    let ball = Mesh3d(meshes.add(Sphere::new(1.0).mesh().uv(256, 128)));
    let material = MeshMaterial3d(materials.add(StandardMaterial { base_color: Color::WHITE, ..default() }));
    commands.spawn((ball, material, Ball));
    let mut target = Image::new_target_texture(WIDTH, WIDTH, TextureFormat::Rgba32Float, None);
    target.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let target = images.add(target);
    let camera = commands
        .spawn((
            Camera3d::default(),
            RenderTarget::Image(target.clone().into()),
            Hdr,
            Tonemapping::None,
            DebandDither::Disabled,
            Msaa::Off,
            Exposure { ev100: 0.0 },
        ))
        .id();
    let folder = format!("{}/bevy", work.what);
    match work.what.as_str() {
        "plain" => plain::add_sky(&mut commands, &assets, &folder, camera),
        _ => sun::add_sky(&mut commands, &assets, &folder, camera),
    }
    commands.spawn(Readback::texture(target)).observe(|read: On<ReadbackComplete>, mut work: ResMut<Work>| {
        work.pixel = middle_of(&read.event().data);
    });
}

/// The mean of the nine pixels in the middle of a picture whose rows may be padded. Pixels of bevy are not a number
/// where some directions of lights and normals meet; these are left out.
fn middle_of(picture: &[u8]) -> [f32; 3] {
    let (row, middle) = (picture.len() / WIDTH as usize, (WIDTH / 2) as usize);
    let pixel = |x: usize, y: usize| -> [f32; 3] {
        let bytes = &picture[y * row + x * TEXEL..][..12];
        std::array::from_fn(|c| f32::from_le_bytes(bytes[4 * c..4 * c + 4].try_into().expect("four bytes")))
    };
    let around = middle - 1..=middle + 1;
    let all = around.clone().flat_map(|y| around.clone().map(move |x| (x, y))).map(|(x, y)| pixel(x, y));
    let finite: Vec<[f32; 3]> = all.filter(|color| color.iter().all(|c| c.is_finite())).collect();
    std::array::from_fn(|c| finite.iter().map(|color| color[c]).sum::<f32>() / finite.len() as f32)
}

/// Reads the picture of the last step, and sets the next.
#[allow(clippy::too_many_arguments)]
fn step(
    mut work: ResMut<Work>,
    mut exit: MessageWriter<AppExit>,
    assets: Res<AssetServer>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut balls: Query<(&mut Visibility, &MeshMaterial3d<StandardMaterial>), With<Ball>>,
    mut cameras: Query<(&mut Transform, &mut Projection, &EnvironmentMapLight, &Skybox), With<Camera3d>>,
) {
    let (mut place, mut projection, light, sky) = cameras.single_mut().expect("one camera");
    let sky = sky.image.as_ref().expect("a sky");
    let files = [light.diffuse_map.id(), light.specular_map.id(), sky.id()];
    if files.iter().any(|file| !assets.is_loaded_with_dependencies(*file)) {
        return;
    }
    if work.step == 0 {
        let material = balls.single_mut().expect("one ball").1;
        let mut material = materials.get_mut(&material.0).expect("its material");
        work.frames += 1;
        assert!(work.frames < MOST_FRAMES, "no ball is seen");
        work.is_seen |= work.pixel[0] > GLOW / 2.0;
        material.emissive = if work.is_seen { LinearRgba::BLACK } else { LinearRgba::rgb(GLOW, GLOW, GLOW) };
        material.emissive_exposure_weight = 0.0;
        if !work.is_seen {
            look_at_ball(Vec3::X, &mut place, &mut projection);
            return;
        }
    }
    if work.wait > 0 {
        work.wait -= 1;
        return;
    }
    if work.step > 0 {
        let pixel = work.pixel.map(|c| c / EXPOSURE);
        work.seen.push(pixel);
    }
    let (of_balls, per_ball) = (work.surfaces.len() * work.directions.len(), work.directions.len());
    if work.step == of_balls + work.sky_directions.len() {
        write(&work);
        exit.write(AppExit::Success);
        return;
    }
    let (mut visibility, material) = balls.single_mut().expect("one ball");
    if work.step < of_balls {
        let surface = &work.surfaces[work.step / per_ball];
        let mut material = materials.get_mut(&material.0).expect("its material");
        material.metallic = if surface.roughness.is_some() { 1.0 } else { 0.0 };
        material.perceptual_roughness = surface.roughness.unwrap_or(MATTE);
        material.reflectance = if surface.roughness.is_some() { 0.5 } else { 0.0 };
        look_at_ball(Vec3::from(work.directions[work.step % per_ball]), &mut place, &mut projection);
    } else {
        *visibility = Visibility::Hidden;
        let d = Vec3::from(work.sky_directions[work.step - of_balls]);
        *place = Transform::default().looking_to(d, up(d));
        *projection = Projection::from(PerspectiveProjection { fov: 0.02, ..default() });
    }
    work.step += 1;
    work.wait = LATE;
}

fn up(d: Vec3) -> Vec3 {
    if d.y.abs() > 0.9 { Vec3::Z } else { Vec3::Y }
}

/// The middle of the picture is the point of the ball whose normal is `d`.
fn look_at_ball(d: Vec3, place: &mut Transform, projection: &mut Projection) {
    *place = Transform::from_translation(3.0 * d).looking_at(Vec3::ZERO, up(d));
    *projection = Projection::from(OrthographicProjection {
        scaling_mode: ScalingMode::FixedVertical { viewport_height: 0.02 },
        near: 0.1,
        far: 10.0,
        ..OrthographicProjection::default_3d()
    });
}

fn write(work: &Work) {
    let per_ball = work.directions.len();
    let mut values = serde_json::Map::new();
    for (surface, seen) in work.surfaces.iter().zip(work.seen.chunks(per_ball)) {
        values.insert(surface.name.clone(), serde_json::json!(seen));
    }
    values.insert("sky".to_owned(), serde_json::json!(work.seen[work.surfaces.len() * per_ball..]));
    let found = serde_json::json!({"version": VERSION, "values": values});
    fs::write(&work.out, found.to_string()).expect("a place for what was seen");
}

/// The version of bevy in Cargo.toml.
const VERSION: &str = "0.19.1";
