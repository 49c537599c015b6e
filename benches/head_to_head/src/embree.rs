//! What the benchmarks use of Embree 3, as Debian packages it (`libembree-dev`, 3.13).
#![expect(unsafe_code, reason = "Embree is a C library")]

use std::ffi::{CStr, c_char, c_void};

use bevy_sightline::geometry::ray::Ray;

pub(crate) type Device = *mut c_void;
pub(crate) type Scene = *mut c_void;
pub(crate) type Geometry = *mut c_void;

pub(crate) const TRIANGLES: u32 = 0;
pub(crate) const USER_GEOMETRY: u32 = 120;

/// Tells how a scene and its geometries are built: by Morton codes, by the surface area heuristic, with spatial splits
/// too, or by fitting the boxes of what is there.
pub(crate) const LOW_QUALITY: u32 = 0;
pub(crate) const MEDIUM_QUALITY: u32 = 1;
pub(crate) const HIGH_QUALITY: u32 = 2;
pub(crate) const REFIT_QUALITY: u32 = 3;

pub(crate) const DYNAMIC_SCENE: u32 = 1;
pub(crate) const COMPACT_SCENE: u32 = 2;
pub(crate) const ROBUST_SCENE: u32 = 4;

pub(crate) const INDEX_BUFFER: u32 = 0;
pub(crate) const VERTEX_BUFFER: u32 = 1;
pub(crate) const UINT3: u32 = 0x5003;
pub(crate) const FLOAT3: u32 = 0x9003;

/// No geometry, primitive or instance.
pub(crate) const NONE: u32 = u32::MAX;

/// One thread builds, and none is started beside it.
pub(crate) const ONE_THREAD: &CStr = c"threads=1,start_threads=0,set_affinity=0";

/// `RTCIntersectContext`.
#[repr(C)]
pub(crate) struct Context {
    flags: u32,
    filter: *const c_void,
    instance: u32,
}

impl Context {
    pub const PLAIN: Self = Self {
        flags: 0,
        filter: std::ptr::null(),
        instance: NONE,
    };
}

/// `RTCRay`.
#[repr(C, align(16))]
pub(crate) struct RtcRay {
    pub origin: [f32; 3],
    pub t_near: f32,
    pub direction: [f32; 3],
    pub time: f32,
    pub t_far: f32,
    pub mask: u32,
    pub id: u32,
    pub flags: u32,
}

impl RtcRay {
    pub fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin().to_array(),
            t_near: 0.0,
            direction: ray.direction().to_array(),
            time: 0.0,
            t_far: ray.t_max(),
            mask: u32::MAX,
            id: 0,
            flags: 0,
        }
    }
}

/// `RTCHit`.
#[repr(C, align(16))]
pub(crate) struct Hit {
    pub normal: [f32; 3],
    pub barycentric: [f32; 2],
    pub primitive: u32,
    pub geometry: u32,
    pub instance: u32,
}

impl Hit {
    pub const NONE: Self = Self {
        normal: [0.0; 3],
        barycentric: [0.0; 2],
        primitive: NONE,
        geometry: NONE,
        instance: NONE,
    };
}

/// `RTCRayHit`.
#[repr(C)]
pub(crate) struct RayHit {
    pub ray: RtcRay,
    pub hit: Hit,
}

/// Called with the arguments of the kind of callback.
pub(crate) type Callback = unsafe extern "C" fn(*const c_void);

/// Called with how many bytes more or less are allocated.
pub(crate) type MemoryMonitor = unsafe extern "C" fn(data: *mut c_void, bytes: isize, after: bool) -> bool;

unsafe extern "C" {
    pub fn rtcNewDevice(config: *const c_char) -> Device;
    pub fn rtcReleaseDevice(device: Device);
    pub fn rtcGetDeviceError(device: Device) -> u32;
    pub fn rtcSetDeviceMemoryMonitorFunction(device: Device, monitor: MemoryMonitor, data: *mut c_void);
    pub fn rtcNewGeometry(device: Device, kind: u32) -> Geometry;
    pub fn rtcReleaseGeometry(geometry: Geometry);
    pub fn rtcCommitGeometry(geometry: Geometry);
    pub fn rtcSetGeometryBuildQuality(geometry: Geometry, quality: u32);
    pub fn rtcSetGeometryUserData(geometry: Geometry, data: *mut c_void);
    pub fn rtcSetGeometryUserPrimitiveCount(geometry: Geometry, count: u32);
    pub fn rtcSetGeometryBoundsFunction(geometry: Geometry, bounds: Callback, data: *mut c_void);
    pub fn rtcSetGeometryIntersectFunction(geometry: Geometry, intersect: Callback);
    pub fn rtcSetGeometryOccludedFunction(geometry: Geometry, occluded: Callback);
    pub fn rtcSetSharedGeometryBuffer(
        geometry: Geometry,
        kind: u32,
        slot: u32,
        format: u32,
        data: *const c_void,
        offset: usize,
        stride: usize,
        count: usize,
    );
    pub fn rtcUpdateGeometryBuffer(geometry: Geometry, kind: u32, slot: u32);
    pub fn rtcNewScene(device: Device) -> Scene;
    pub fn rtcReleaseScene(scene: Scene);
    pub fn rtcSetSceneFlags(scene: Scene, flags: u32);
    pub fn rtcSetSceneBuildQuality(scene: Scene, quality: u32);
    pub fn rtcAttachGeometry(scene: Scene, geometry: Geometry) -> u32;
    pub fn rtcCommitScene(scene: Scene);
    pub fn rtcIntersect1(scene: Scene, context: *mut c_void, ray_hit: *mut RayHit);
    pub fn rtcOccluded1(scene: Scene, context: *mut c_void, ray: *mut RtcRay);
}
