//! The same shading on the GPU, without a window.
//!
//! Each WGSL module has a counterpart on the processor, whose name it has, and gives its numbers: relative differences are below
//! 1e-4, tested on the same data. All work of a device is passes of a [`Renderer`], in an order that can be printed.
//!
//! # Example: a baked scene under a new light
//!
//! ```no_run
//! use lobe_gpu::{Context, ContextOptions, Environment, GpuCamera, SceneView, SceneViewOptions, Storage, SurfaceShading};
//! use lobe_image::Tone;
//! use lobe_io::Job;
//! use lobe_prt::{BakeOptions, Receivers, bake};
//! use lobe_scene::{Bvh, built_in};
//! use lobe_sh::Dir;
//!
//! let scene = built_in::ball_over_ground(32);
//! let receivers = Receivers::at_vertices(&scene)?;
//! let (transfer, _) = bake(&scene, &Bvh::new(&scene), &receivers, &BakeOptions::default(), Job::default())?;
//! let sky = lobe_env::bundled::sunset().map();
//!
//! let context = Context::new(&ContextOptions::default())?;
//! let shading = SurfaceShading::Vertices(&transfer, &[], Storage::F32);
//! let view = SceneView::new(&context, &scene, &shading, Some(&Environment::from(&*sky)), &SceneViewOptions::default())?;
//! if let Some(camera) = GpuCamera::framing(scene.world_bounds(), Dir::from_angles(1.2, 0.5), 0.3) {
//!     view.set_camera(&camera)?;
//! }
//! view.set_light(&lobe_env::project_env(&sky, 4))?;
//! view.render()?;
//! view.picture()?.write_png("ball.png", &Tone::PHOTOGRAPH)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Index
//!
//! | purpose | item | WGSL modules |
//! |---|---|---|
//! | a device | [`Context`], [`ContextOptions`] | |
//! | passes and what they take | [`Renderer`], [`PassTime`] | |
//! | environment maps in every mapping | [`Environment`] | `environment` |
//! | split-sum reflection | [`SplitSum`] | `specular`, `lobe_table` |
//! | spheres that hide the sky | [`GpuSphereShadows`] | `accumulate`, `sky_light` |
//! | a part of a moving scene under spheres, fields and what stands still | [`GpuMovingPart`], [`FieldResponse`], [`StillGrid`] | `shadow_fields`, `product`, `still_visibility` and those above |
//! | metals and plastics of glTF | [`GltfShading`] | `gltf`, `gltf_suns`, `finish`, `openness` |
//! | suns that cast shadows by themselves | [`SunsApart`], [`SceneView::with_suns`] | `sun_shadow`, `sun_light`, `sunlit_*` |
//! | pictures of scenes | [`SceneView`], [`SurfaceShading`], [`GlossyMesh`], [`Storage`], [`GpuCamera`] | `transfer`, `clustered`, `glossy`, `basis`, `camera`, `surface`, `shade_*`, `draw_*`, `backdrop`, `resolve`, `tone`, `display` |
//! | without a window: frames to files, times of passes | [`write_turntable`], [`render_turntable`], [`TurningLight`], [`BenchReport`] | |
//!
//! # Precision
//!
//! Shaders compute in `f32`. Where WGSL allows larger errors than the last digits, in `atan2` and `sin`, the modules have
//! functions of their own; textures of light are read texel by texel and weighted here, because filters of devices have eight
//! bits for a weight.
//!
//! # Sizes
//!
//! A binding of a storage buffer holds what the device says, 128 MiB where it promises no more than WebGPU. What grows with
//! receivers, vertices, triangles, texels of a lightmap or fields is cut into pieces that fit, each a pass of its own, with the
//! same results to the last digit (tests of `pieces`). These remain whole, and are refused in one line where they do not fit:
//!
//! * what every item looks up anywhere: spheres (64 bytes each), the products of the light with clusters;
//! * one texture of a surface, and a triangle over more rows of a lightmap than a binding holds, because a triangle is drawn at once;
//! * environments and pictures, which are textures: up to the side that the device has, 8192 texels in WebGPU;
//! * buffers of all receivers that are read back or fetched as one, radiance, visibility: up to the largest buffer.
//!
//! # What can go wrong
//!
//! Devices are lost, run out of memory, or refuse work: each is a [`GpuError`], and nothing panics. A machine without an
//! adapter is [`GpuError::NoAdapter`]; the same pictures are then made by `lobe-render`.

mod context;
mod error;
mod headless;
mod lookup;
mod moving;
mod renderer;
mod scene_view;
mod storage;
mod transfer;

pub use context::context::Context;
pub use context::options::{AdapterChoice, ContextOptions};
pub use error::GpuError;
pub use headless::bench::BenchReport;
pub use headless::turning_light::TurningLight;
pub use headless::turntable::{TurntableOptions, render_turntable, write_turntable};
pub use lookup::environment::Environment;
pub use lookup::specular::SplitSum;
pub use moving::field_passes::FieldResponse;
pub use moving::gpu_moving_part::{GpuMovingPart, MovingObstacles, MovingPlaces};
pub use moving::gpu_sphere_shadows::GpuSphereShadows;
pub use moving::still_grid::StillGrid;
pub use renderer::renderer::{PassTime, Renderer};
pub use scene_view::camera::GpuCamera;
pub use scene_view::gltf_shading::GltfShading;
pub use scene_view::options::{SceneViewOptions, ViewOutput};
pub use scene_view::scene_view::SceneView;
pub use scene_view::suns_apart::SunsApart;
pub use scene_view::surface_shading::{GlossyMesh, SurfaceShading};
pub use storage::Storage;
