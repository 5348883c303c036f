//! Occluders that move: shadow fields, sphere sets, and what many of them leave of the sky.
//!
//! A baked transfer holds the shadows of a scene that stands still. Here every entity carries what it does to light
//! around it, and a receiver combines those of all entities when it is asked, wherever they have moved.
//!
//! # Index
//!
//! | purpose | item |
//! |---|---|
//! | the place of an entity | [`Placement`] |
//! | inside a mesh, and how much of it in a ball | [`Solid`] |
//! | spheres that stand for a mesh | [`SphereSet`], [`fit_spheres`], [`refine_spheres`], [`SphereFitOptions`] |
//! | spheres that move with joints | [`SphereSet::bind`], [`SphereSet::posed`], [`Skin`] |
//! | levels of detail of spheres | [`SphereHierarchy`] |
//! | files of spheres | [`write_spheres`], [`read_spheres`], [`write_sphere_hierarchy`], [`read_sphere_hierarchy`] |

mod error;
mod placement;
mod spheres;

pub use error::ShadowError;
pub use placement::Placement;
pub use spheres::fit_spheres::{SphereFitMethod, SphereFitOptions, SphereFitReport, fit_spheres, refine_spheres};
pub use spheres::pose::{SkinnedMesh, WorldSphere};
pub use spheres::skin::Skin;
pub use spheres::solid::Solid;
pub use spheres::sphere_file::{
    read_sphere_hierarchy, read_sphere_hierarchy_bytes, read_spheres, read_spheres_bytes, write_sphere_hierarchy,
    write_spheres,
};
pub use spheres::sphere_hierarchy::{SphereHierarchy, SphereNode};
pub use spheres::sphere_json::{SphereJson, SphereSetJson};
pub use spheres::sphere_set::SphereSet;
