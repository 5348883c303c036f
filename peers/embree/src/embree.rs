//! As much of Embree 4's C interface as occlusion rays, closest hits and builds need (its headers rtcore_device.h, _scene.h,
//! _geometry.h, _ray.h).

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::ptr::{null, null_mut};
use std::time::Instant;

/// `RTCRay`.
#[repr(C, align(16))]
struct RtcRay {
    org: [f32; 3],
    tnear: f32,
    dir: [f32; 3],
    time: f32,
    tfar: f32,
    mask: c_uint,
    id: c_uint,
    flags: c_uint,
}

impl RtcRay {
    fn new(org: [f32; 3], dir: [f32; 3]) -> Self {
        Self { org, tnear: 0.0, dir, time: 0.0, tfar: f32::INFINITY, mask: !0, id: 0, flags: 0 }
    }
}

/// `RTCHit` of a library without instancing levels above one, with arrays of instances (4.4) or without.
#[repr(C, align(16))]
struct RtcHit {
    normal: [f32; 3],
    u: f32,
    v: f32,
    primitive: c_uint,
    geometry: c_uint,
    instance: c_uint,
    instance_primitive: c_uint,
}

/// `RTCRayHit`.
#[repr(C)]
struct RtcRayHit {
    ray: RtcRay,
    hit: RtcHit,
}

/// `RTCOccludedArguments` and `RTCIntersectArguments`, which are laid out alike, with room for the minimal width that some
/// libraries are built with.
#[repr(C)]
struct RtcArguments {
    flags: c_uint,
    features: c_uint,
    context: *const c_void,
    filter: *const c_void,
    of_user_geometry: *const c_void,
    min_width_distance_factor: f32,
}

impl RtcArguments {
    fn new(flags: c_uint) -> Self {
        let (context, filter, of_user_geometry) = (null(), null(), null());
        Self {
            flags,
            features: RTC_FEATURE_FLAG_TRIANGLE,
            context,
            filter,
            of_user_geometry,
            min_width_distance_factor: 0.0,
        }
    }
}

const RTC_GEOMETRY_TYPE_TRIANGLE: c_int = 0;
const RTC_BUFFER_TYPE_INDEX: c_int = 0;
const RTC_BUFFER_TYPE_VERTEX: c_int = 1;
const RTC_FORMAT_UINT3: c_int = 0x5003;
const RTC_FORMAT_FLOAT3: c_int = 0x9003;
const RTC_SCENE_FLAG_ROBUST: c_int = 1 << 2;
const RTC_BUILD_QUALITY_MEDIUM: c_int = 1;
const RTC_INVALID_GEOMETRY_ID: c_uint = c_uint::MAX;
const RTC_RAY_QUERY_FLAG_INCOHERENT: c_uint = 0;
const RTC_RAY_QUERY_FLAG_COHERENT: c_uint = 1 << 16;
const RTC_FEATURE_FLAG_TRIANGLE: c_uint = 1 << 1;

unsafe extern "C" {
    fn rtcNewDevice(config: *const c_char) -> *mut c_void;
    fn rtcReleaseDevice(device: *mut c_void);
    fn rtcNewScene(device: *mut c_void) -> *mut c_void;
    fn rtcSetSceneFlags(scene: *mut c_void, flags: c_int);
    fn rtcSetSceneBuildQuality(scene: *mut c_void, quality: c_int);
    fn rtcNewGeometry(device: *mut c_void, kind: c_int) -> *mut c_void;
    fn rtcSetNewGeometryBuffer(
        geometry: *mut c_void,
        kind: c_int,
        slot: c_uint,
        format: c_int,
        stride: usize,
        count: usize,
    ) -> *mut c_void;
    fn rtcCommitGeometry(geometry: *mut c_void);
    fn rtcAttachGeometry(scene: *mut c_void, geometry: *mut c_void) -> c_uint;
    fn rtcReleaseGeometry(geometry: *mut c_void);
    fn rtcCommitScene(scene: *mut c_void);
    fn rtcReleaseScene(scene: *mut c_void);
    fn rtcOccluded1(scene: *mut c_void, ray: *mut RtcRay, arguments: *mut RtcArguments);
    fn rtcIntersect1(scene: *mut c_void, hit: *mut RtcRayHit, arguments: *mut RtcArguments);
}

/// Embree's tree over triangles, built by one thread at medium quality, its default.
pub(crate) struct Embree {
    device: *mut c_void,
    scene: *mut c_void,
    /// The seconds that the build took, the triangles already in Embree's buffers.
    pub(crate) build_seconds: f64,
}

impl Embree {
    /// `is_robust`: watertight, as Lobe's rays always are.
    pub(crate) fn new(corners: &[[[f32; 3]; 3]], is_robust: bool) -> Self {
        // SAFETY: the calls follow the order of Embree's manual.
        unsafe {
            let device = rtcNewDevice(c"threads=1".as_ptr());
            assert!(!device.is_null(), "Embree made no device");
            let scene = rtcNewScene(device);
            rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
            if is_robust {
                rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
            }
            let geometry = new_triangles(device, corners);
            rtcAttachGeometry(scene, geometry);
            rtcReleaseGeometry(geometry);
            let begun = Instant::now();
            rtcCommitScene(scene);
            Self { device, scene, build_seconds: begun.elapsed().as_secs_f64() }
        }
    }

    /// How many of the rays from one point are occluded, by `rtcOccluded1` with the hint that they are coherent.
    pub(crate) fn occluded(&self, origin: [f32; 3], directions: &[[f32; 3]]) -> f64 {
        let mut arguments = RtcArguments::new(RTC_RAY_QUERY_FLAG_COHERENT);
        let mut occluded = 0;
        for &dir in directions {
            let mut ray = RtcRay::new(origin, dir);
            // SAFETY: scene, arguments and ray live as long as the call, and the ray is aligned as its type says.
            unsafe { rtcOccluded1(self.scene, &raw mut ray, &raw mut arguments) };
            occluded += usize::from(ray.tfar < 0.0);
        }
        occluded as f64
    }

    /// The sum of the distances of the closest hits of these rays, by `rtcIntersect1`.
    pub(crate) fn closest(&self, origin: [f32; 3], directions: &[[f32; 3]]) -> f64 {
        let mut arguments = RtcArguments::new(RTC_RAY_QUERY_FLAG_INCOHERENT);
        let mut sum = 0.0;
        for &dir in directions {
            let none = RTC_INVALID_GEOMETRY_ID;
            let hit = RtcHit {
                normal: [0.0; 3],
                u: 0.0,
                v: 0.0,
                primitive: none,
                geometry: none,
                instance: none,
                instance_primitive: none,
            };
            let mut hit = RtcRayHit { ray: RtcRay::new(origin, dir), hit };
            // SAFETY: scene, arguments, ray and hit live as long as the call, and both are aligned as their types say.
            unsafe { rtcIntersect1(self.scene, &raw mut hit, &raw mut arguments) };
            if hit.hit.geometry != none {
                sum += f64::from(hit.ray.tfar);
            }
        }
        sum
    }
}

/// A geometry of these triangles, committed.
///
/// # Safety
/// The device is one that Embree has made and not released.
unsafe fn new_triangles(device: *mut c_void, corners: &[[[f32; 3]; 3]]) -> *mut c_void {
    // SAFETY: both buffers are Embree's own, of the sizes asked for, with the padding it adds for FLOAT3, and are filled before the
    // geometry is committed.
    unsafe {
        let geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        let count = corners.len();
        let buffer = |kind, format, items| rtcSetNewGeometryBuffer(geometry, kind, 0, format, 12, items);
        let vertices = buffer(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 3 * count).cast::<[f32; 3]>();
        let indices = buffer(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, count).cast::<[u32; 3]>();
        assert!(!vertices.is_null() && !indices.is_null(), "Embree made no buffers");
        for (i, triangle) in corners.iter().enumerate() {
            for (k, corner) in triangle.iter().enumerate() {
                vertices.add(3 * i + k).write(*corner);
            }
            let first = 3 * i as u32;
            indices.add(i).write([first, first + 1, first + 2]);
        }
        rtcCommitGeometry(geometry);
        geometry
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: both were made in `new` and are released once.
        unsafe {
            rtcReleaseScene(self.scene);
            rtcReleaseDevice(self.device);
        }
        (self.scene, self.device) = (null_mut(), null_mut());
    }
}
