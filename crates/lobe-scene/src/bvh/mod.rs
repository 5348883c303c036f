//! TODO room bvh.

pub(crate) mod bvh;
pub(crate) mod collapse;
pub(crate) mod edge_planes;
pub(crate) mod lanes;
#[cfg(target_arch = "x86_64")]
pub(crate) mod lanes_avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) mod lanes_avx512;
pub(crate) mod octant_slabs;
pub(crate) mod ray_frame;
pub(crate) mod ray_stream;
pub(crate) mod simd;
pub(crate) mod traverse;
pub(crate) mod watertight;
pub(crate) mod wide_node;
