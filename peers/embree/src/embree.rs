//! As much of Embree 3's C interface as occlusion rays need (its headers rtcore_device.h, _scene.h, _geometry.h, _ray.h).

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::ptr::{null, null_mut};

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

/// `RTCIntersectContext` of a library built without instancing levels above one and without minimal widths.
#[repr(C)]
struct RtcIntersectContext {
    flags: c_uint,
    filter: *const c_void,
    inst_id: [c_uint; 1],
}

const RTC_GEOMETRY_TYPE_TRIANGLE: c_int = 0;
const RTC_BUFFER_TYPE_INDEX: c_int = 0;
const RTC_BUFFER_TYPE_VERTEX: c_int = 1;
const RTC_FORMAT_UINT3: c_int = 0x5003;
const RTC_FORMAT_FLOAT3: c_int = 0x9003;
const RTC_SCENE_FLAG_ROBUST: c_int = 1 << 2;
const RTC_INVALID_GEOMETRY_ID: c_uint = c_uint::MAX;
const RTC_INTERSECT_CONTEXT_FLAG_COHERENT: c_uint = 1;

unsafe extern "C" {
    fn rtcNewDevice(config: *const c_char) -> *mut c_void;
    fn rtcReleaseDevice(device: *mut c_void);
    fn rtcNewScene(device: *mut c_void) -> *mut c_void;
    fn rtcSetSceneFlags(scene: *mut c_void, flags: c_int);
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
    fn rtcOccluded1(scene: *mut c_void, context: *mut RtcIntersectContext, ray: *mut RtcRay);
}

/// Embree's tree over triangles, one thread, its default (medium) build quality.
pub(crate) struct Embree {
    device: *mut c_void,
    scene: *mut c_void,
}

impl Embree {
    /// `is_robust`: watertight, as Lobe's rays always are.
    pub(crate) fn new(corners: &[[[f32; 3]; 3]], is_robust: bool) -> Self {
        // SAFETY: the calls follow the order of Embree's manual; both buffers are Embree's own, of the sizes asked for,
        // with the padding it adds for FLOAT3, and are filled before the geometry is committed.
        unsafe {
            let device = rtcNewDevice(c"threads=1".as_ptr());
            assert!(!device.is_null(), "Embree made no device");
            let scene = rtcNewScene(device);
            if is_robust {
                rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
            }
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
            rtcAttachGeometry(scene, geometry);
            rtcReleaseGeometry(geometry);
            rtcCommitScene(scene);
            Self { device, scene }
        }
    }

    /// How many of the rays from one point are occluded, by `rtcOccluded1` with the hint that they are coherent.
    pub(crate) fn occluded(&self, origin: [f32; 3], directions: &[[f32; 3]]) -> usize {
        let mut context = RtcIntersectContext {
            flags: RTC_INTERSECT_CONTEXT_FLAG_COHERENT,
            filter: null(),
            inst_id: [RTC_INVALID_GEOMETRY_ID],
        };
        let mut occluded = 0;
        for &dir in directions {
            let mut ray =
                RtcRay { org: origin, tnear: 0.0, dir, time: 0.0, tfar: f32::INFINITY, mask: !0, id: 0, flags: 0 };
            // SAFETY: scene, context and ray live as long as the call, and the ray is aligned as its type says.
            unsafe { rtcOccluded1(self.scene, &raw mut context, &raw mut ray) };
            occluded += usize::from(ray.tfar < 0.0);
        }
        occluded
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
