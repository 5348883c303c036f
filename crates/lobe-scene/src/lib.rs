//! Triangle scenes: read from files or built in by formula, with watertight ray tracing.
//!
//! Positions and directions are arrays `[x, y, z]`, right-handed with +z up. The crate has no lights and no expansions.
//!
//! # Examples
//!
//! Trace rays in a built-in scene:
//!
//! ```
//! use lobe_scene::{Bvh, Ray, built_in};
//!
//! let scene = built_in::ball_over_ground(32);
//! let bvh = Bvh::new(&scene);
//! assert!(bvh.is_occluded(&Ray::new([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])), "the ball hangs over the origin");
//!
//! let Some(hit) = bvh.closest(&Ray::new([3.0, 0.0, 5.0], [0.0, 0.0, -1.0])) else { panic!("the ground is there") };
//! assert_eq!(scene.surface(&hit).geometric_normal, [0.0, 0.0, 1.0]);
//! ```
//!
//! Read a file, and make its triangles small enough for light at vertices:
//!
//! ```no_run
//! use lobe_scene::{SceneReadOptions, read_scene};
//!
//! let (scene, report) = read_scene("room.glb", &SceneReadOptions::default())?;
//! println!("{} triangles, {} without area dropped", report.triangles, report.dropped_triangles);
//! let fine = scene.split_edges(0.1)?;
//! # Ok::<(), lobe_scene::SceneError>(())
//! ```
//!
//! Files that are compressed by meshoptimizer, or have Basis Universal textures, are read with the feature
//! `compressed`, a default; without it they are refused.
//!
//! Pose a scene that moves:
//!
//! ```no_run
//! use lobe_scene::{AnimatedScene, SceneReadOptions};
//!
//! let (scene, _) = AnimatedScene::read("character.glb", &SceneReadOptions::default())?;
//! let walk = scene.animation("Walk")?;
//! let posed = scene.pose(walk, scene.animations()[walk].looped(12.5))?;
//! let bvh = posed.bvh();
//! # Ok::<(), lobe_scene::SceneError>(())
//! ```
//!
//! # Index
//!
//! | purpose | item |
//! |---|---|
//! | scenes | [`Scene`]; its parts [`Mesh`], [`Material`], [`Texture`], [`NormalMap`] |
//! | files | [`read_scene`], [`read_scene_bytes`], [`SceneReadOptions`] with [`ScenePose`], [`SceneReadReport`] |
//! | glTF beyond scenes: whole files, custom attributes, scenes as glTF | [`GltfReader`], [`GltfDocument`] |
//! | scenes in motion: animations, skins, morph targets | [`AnimatedScene`], [`Animation`], [`PosedScene`] |
//! | what moves in them, and where it is | [`Entity`], [`EntityKind`], [`Place`], [`Similarity`] |
//! | built-in scenes | [`built_in`] |
//! | y-up files | [`Up`], [`z_up_from_y_up`], [`y_up_from_z_up`] |
//! | subdivision | [`Scene::split_edges`], [`Scene::halve_edges`], [`HalvedEdges`] |
//! | texture coordinates of a lightmap | [`Scene::unwrapped`], [`UnwrapOptions`], [`UnwrapReport`] |
//! | rays | [`Bvh`], [`Ray`], [`Hit`], [`Simd`]; among surfaces with holes [`SurfaceRays`] |
//! | surface at a hit | [`Scene::surface`], [`Surface`], [`Scene::stops`] |

pub mod built_in;
mod bvh;
mod error;
mod files;
mod motion;
mod reading;
mod scene;
mod unwrap;

pub use bvh::bvh::Bvh;
pub use bvh::lanes::Simd;
pub use bvh::surface_rays::SurfaceRays;
pub use error::{SceneError, SceneReadOption};
pub use files::folder::referenced_file;

pub use files::gltf::document::GltfDocument;
pub use files::read_options::{DefaultMaterial, MissingNormals, ScenePose, SceneReadOptions, SceneReadReport};
pub use files::scene_format::{SceneFormat, is_gltf};
pub use motion::animated_scene::AnimatedScene;
pub use motion::animation::Animation;
pub use motion::entity::{Entity, EntityKind};
pub use motion::place::{Place, Similarity};
pub use motion::posed_scene::PosedScene;
pub use reading::entity_source::ReadEntity;
pub use reading::gltf_reader::GltfReader;
pub use reading::read_scene::{read_scene, read_scene_bytes};
pub use reading::scene_source::{BUILT_IN, ReadScene, SceneSource};
pub use scene::finish::Finish;
pub use scene::material::{Alpha, Material, NormalMap, OcclusionMap, TextureUse};
pub use scene::mesh::{Mesh, MeshParts, MeshSource};
pub use scene::ray::{Hit, Ray};
pub use scene::scene::{Bounds, Scene, Surface};
pub use scene::split_edges::HalvedEdges;
pub use scene::texture::{Texture, Wrap};
pub use scene::up::{Up, y_up_from_z_up, z_up_from_y_up};
pub use unwrap::options::UnwrapOptions;
pub use unwrap::unwrap::UnwrapReport;
