//! Environment maps in memory: in any mapping ([`mapped_map`]), lat-long ([`env_map`]) and cube ([`cube_map`], with mip
//! levels [`cube_mip_chain`]).
//!
//! Read [`mapped_map`] first. [`cube_layout`] puts the faces of a cube into a picture and takes them out, in a
//! [`face_order`] and for a [`cube_handedness`], [`adjust`]
//! changes exposure and clamps, [`finite`] refuses sums beyond `f32`. Uses `mapping`.

pub(crate) mod adjust;
pub(crate) mod cube_average;
pub(crate) mod cube_handedness;
pub(crate) mod cube_layout;
pub(crate) mod cube_map;
pub(crate) mod cube_mip_chain;
pub(crate) mod env_map;
pub(crate) mod face_order;
pub(crate) mod finite;
pub(crate) mod mapped_map;
