//! Embree, as Debian packages it (`libembree-dev`, 3.13): its SAH tree over boxes as user geometry.
//!
//! A callback of ours tests a box, with the reciprocal of the direction that comes with the context of the query.
#![expect(unsafe_code, reason = "Embree is a C library")]

use std::{ffi::c_void, ptr};

use bevy::math::{Vec3A, bounding::Aabb3d};
use bevy_sightline::geometry::ray::Ray;

use super::{
    peers::Slabs,
    queries::{Found, RayQueries},
};
use crate::embree::*;

pub(crate) const NAME: &str = "Embree 3.13 SAH";

/// A scene of one geometry.
pub(crate) struct Embree {
    device: Device,
    scene: Scene,
    /// Embree holds on to them.
    _boxes: Vec<Aabb3d>,
}

impl Embree {
    pub fn build(boxes: &[Aabb3d]) -> Self {
        let boxes = boxes.to_vec();
        // SAFETY: all handles are live until they are released, the callbacks have the types that Embree wants, and the
        // boxes outlive the scene, and do not move.
        unsafe {
            let device = rtcNewDevice(ONE_THREAD.as_ptr());
            assert!(!device.is_null(), "Embree starts");
            let geometry = rtcNewGeometry(device, USER_GEOMETRY);
            rtcSetGeometryUserPrimitiveCount(geometry, boxes.len() as u32);
            rtcSetGeometryUserData(geometry, boxes.as_ptr().cast_mut().cast());
            rtcSetGeometryBoundsFunction(geometry, bounds, ptr::null_mut());
            rtcSetGeometryIntersectFunction(geometry, intersect);
            rtcSetGeometryOccludedFunction(geometry, occluded);
            rtcSetGeometryBuildQuality(geometry, HIGH_QUALITY);
            rtcCommitGeometry(geometry);
            let scene = rtcNewScene(device);
            rtcSetSceneBuildQuality(scene, HIGH_QUALITY);
            rtcAttachGeometry(scene, geometry);
            rtcReleaseGeometry(geometry);
            rtcCommitScene(scene);
            assert_eq!(rtcGetDeviceError(device), 0, "Embree builds");
            Self {
                device,
                scene,
                _boxes: boxes,
            }
        }
    }

    /// Goes through the boxes along a ray to the first, or to the last if none is taken as a hit.
    fn intersect(&self, ray: &Ray, all: Option<&mut Found>) -> RayHit {
        let mut context = BoxContext::new(ray, all);
        let mut hit = RayHit {
            ray: RtcRay::new(ray),
            hit: Hit::NONE,
        };
        // SAFETY: the scene is live, and the context begins with what Embree knows of it.
        unsafe { rtcIntersect1(self.scene, (&raw mut context).cast(), &raw mut hit) };
        hit
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: neither was released before.
        unsafe {
            rtcReleaseScene(self.scene);
            rtcReleaseDevice(self.device);
        }
    }
}

impl RayQueries for Embree {
    fn closest(&self, ray: &Ray) -> Option<f32> {
        let hit = self.intersect(ray, None);
        (hit.hit.geometry != NONE).then_some(hit.ray.t_far)
    }

    fn any(&self, ray: &Ray) -> bool {
        let mut context = BoxContext::new(ray, None);
        let mut ray = RtcRay::new(ray);
        // SAFETY: as for `intersect`.
        unsafe { rtcOccluded1(self.scene, (&raw mut context).cast(), &raw mut ray) };
        ray.t_far == f32::NEG_INFINITY
    }

    fn all(&self, ray: &Ray) -> Found {
        let mut found = Found::default();
        self.intersect(ray, Some(&mut found));
        found
    }
}

unsafe extern "C" fn bounds(arguments: *const c_void) {
    // SAFETY: called with the boxes as user data, and an index of one of them.
    unsafe {
        let arguments = &*arguments.cast::<BoundsArguments>();
        let aabb = &*arguments.boxes.add(arguments.primitive as usize);
        *arguments.bounds = Bounds {
            lower: aabb.min,
            upper: aabb.max,
        };
    }
}

unsafe extern "C" fn intersect(arguments: *const c_void) {
    // SAFETY: as for `bounds`; the ray is a single one, with its hit, and the context is ours.
    unsafe {
        let arguments = &*arguments.cast::<IntersectArguments>();
        let (hit, context) = (&mut *arguments.ray_hit, &*arguments.context);
        let aabb = &*arguments.boxes.add(arguments.primitive as usize);
        let t = context.slabs.enter(aabb.min, aabb.max);
        if t >= hit.ray.t_far {
            return;
        }
        if let Some(found) = context.all.as_mut() {
            found.add(arguments.primitive);
        } else {
            hit.ray.t_far = t;
            hit.hit.primitive = arguments.primitive;
            hit.hit.geometry = arguments.geometry;
        }
    }
}

unsafe extern "C" fn occluded(arguments: *const c_void) {
    // SAFETY: as for `intersect`; the ray comes without a hit, which is not touched.
    unsafe {
        let arguments = &*arguments.cast::<IntersectArguments>();
        let (ray, context) = (&mut *arguments.ray_hit.cast::<RtcRay>(), &*arguments.context);
        let aabb = &*arguments.boxes.add(arguments.primitive as usize);
        if context.slabs.enter(aabb.min, aabb.max) < ray.t_far {
            ray.t_far = f32::NEG_INFINITY;
        }
    }
}

/// What comes with a query, and behind it what is ours.
#[repr(C)]
struct BoxContext {
    plain: Context,
    slabs: Slabs,
    all: *mut Found,
}

impl BoxContext {
    fn new(ray: &Ray, all: Option<&mut Found>) -> Self {
        Self {
            plain: Context::PLAIN,
            slabs: Slabs::new(ray),
            all: all.map_or(ptr::null_mut(), |found| found),
        }
    }
}

/// `RTCBounds`.
#[repr(C)]
struct Bounds {
    lower: Vec3A,
    upper: Vec3A,
}

/// `RTCBoundsFunctionArguments`.
#[repr(C)]
struct BoundsArguments {
    boxes: *const Aabb3d,
    primitive: u32,
    time_step: u32,
    bounds: *mut Bounds,
}

/// `RTCIntersectFunctionNArguments`, and the one for occlusion.
#[repr(C)]
struct IntersectArguments {
    valid: *mut i32,
    boxes: *const Aabb3d,
    primitive: u32,
    context: *const BoxContext,
    ray_hit: *mut RayHit,
    number: u32,
    geometry: u32,
}
