//! Triangles in the world: scenes read from files or made by a formula, and watertight rays among them.
//!
//! Positions and directions are arrays `[x, y, z]`, right-handed with +z up. The crate knows no light and no expansion.
//!
//! # Examples
//!
//! A scene by formula, and whether a point lies in the shadow of its ball:
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
//! A file, with triangles small enough for light at vertices:
//!
//! ```no_run
//! use lobe_scene::{ReadOptions, read_scene};
//!
//! let (scene, report) = read_scene("room.glb", &ReadOptions::default())?;
//! println!("{} triangles, {} without area dropped", report.triangles, report.dropped_triangles);
//! let fine = scene.split_edges(0.1)?;
//! # Ok::<(), lobe_scene::SceneError>(())
//! ```
//!
//! # Where to find what
//!
//! | purpose | item |
//! |---|---|
//! | the world | [`Scene`]; its parts [`Mesh`], [`Material`], [`Texture`] |
//! | files | [`read_scene`], [`read_scene_bytes`], [`ReadOptions`], [`ReadReport`] |
//! | glTF beyond scenes: whole files, attributes of one's own, scenes as glTF | [`GltfDocument`], [`read_scene_and_attributes`], [`GltfAttributes`] |
//! | scenes by formula | [`built_in`] |
//! | y-up files | [`Up`], [`z_up_from_y_up`], [`y_up_from_z_up`] |
//! | smaller triangles | [`Scene::split_edges`] |
//! | rays | [`Bvh`], [`Ray`], [`Hit`], [`Simd`] |
//! | what a ray found | [`Scene::surface`], [`Surface`], [`Scene::is_solid`] |

mod angle_weighted;
pub mod built_in;
mod bvh;
mod cave;
mod collapse;
mod columns_hall;
mod edge_planes;
mod error;
mod gltf_accessor;
mod gltf_attributes;
mod gltf_document;
mod gltf_files;
mod gltf_materials;
mod gltf_nodes;
mod gltf_of_scene;
mod lanes;
#[cfg(target_arch = "x86_64")]
mod lanes_avx2;
#[cfg(target_arch = "x86_64")]
mod lanes_avx512;
mod material;
mod mesh;
mod near_origin;
mod octant_slabs;
mod ray;
mod ray_frame;
mod ray_stream;
mod read;
mod read_gltf;
mod read_obj;
mod read_ply;
mod scene;
mod shapes;
mod simd;
mod split_edges;
mod terrain;
mod texture;
mod traverse;
mod up;
mod watertight;
mod wide_node;

pub use bvh::Bvh;
pub use error::SceneError;
pub use gltf_attributes::{GltfAttributes, read_scene_and_attributes};
pub use gltf_document::GltfDocument;
pub use material::{Alpha, Material, TextureUse};
pub use mesh::{Mesh, MeshParts, MeshSource};
pub use ray::{Hit, Ray};
pub use read::{LOBE_EXTRAS_VERSION, ReadOptions, ReadReport, read_scene, read_scene_bytes};
pub use scene::{Bounds, Scene, Surface};
pub use simd::Simd;
pub use texture::{Texture, Wrap};
pub use up::{Up, y_up_from_z_up, z_up_from_y_up};
