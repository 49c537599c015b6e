//! Embree, in robust mode: its triangles are then tested by Plücker coordinates, and no ray slips between them.
//!
//! The memory is what it says that it has allocated; the buffers of the mesh, which it needs no more for a hit, are not
//! counted.
#![expect(unsafe_code, reason = "Embree is a C library")]

use std::{
    ffi::c_void,
    ptr,
    sync::atomic::{AtomicIsize, Ordering},
};

use bevy::math::Vec3;
use bevy_sightline::geometry::ray::Ray;

use super::{Hit, MeshRays, Named, models::Model, refit::Refit};
use crate::embree::*;

pub(crate) const REFITTED: &str = "Embree 3.13 robust, refit";

/// How a tree is made: its name, the quality of the build and the flags of the scene.
type Kind = (&'static str, u32, u32);

const MEDIUM: Kind = ("Embree 3.13 robust", MEDIUM_QUALITY, ROBUST_SCENE);
const HIGH: Kind = ("Embree 3.13 robust, splits", HIGH_QUALITY, ROBUST_SCENE);
const COMPACT: Kind = (
    "Embree 3.13 robust, compact",
    MEDIUM_QUALITY,
    ROBUST_SCENE | COMPACT_SCENE,
);
const LOW: Kind = ("Embree 3.13 robust, Morton", LOW_QUALITY, ROBUST_SCENE);

/// A scene of one mesh.
pub(crate) struct Embree {
    device: Device,
    scene: Scene,
    geometry: Geometry,
    /// Embree holds on to them; one more vertex, for it reads sixteen bytes of each.
    vertices: Vec<Vec3>,
    _triangles: Vec<[u32; 3]>,
}

impl Embree {
    /// Those whose rays are raced.
    pub fn best(model: &Model) -> impl Iterator<Item = Named> + '_ {
        [MEDIUM, HIGH, COMPACT].into_iter().map(|kind| {
            let before = HELD.load(Ordering::Relaxed);
            let embree = Self::build(model, kind.1, MEDIUM_QUALITY, kind.2);
            Named {
                name: kind.0,
                rays: Box::new(embree),
                bytes: (HELD.load(Ordering::Relaxed) - before) as usize,
            }
        })
    }

    /// Those whose builds are raced.
    pub fn builds(model: &Model, fast: bool) -> Vec<(&'static str, Box<dyn Fn() -> Box<dyn MeshRays> + '_>)> {
        let kinds = if fast { &[LOW][..] } else { &[MEDIUM, HIGH] };
        let build = |&(name, quality, flags): &Kind| {
            let build = move || -> Box<dyn MeshRays> { Box::new(Self::build(model, quality, MEDIUM_QUALITY, flags)) };
            (name, Box::new(build) as Box<dyn Fn() -> Box<dyn MeshRays>>)
        };
        kinds.iter().map(build).collect()
    }

    /// One whose vertices move.
    pub fn refittable(model: &Model) -> Self {
        Self::build(model, LOW_QUALITY, REFIT_QUALITY, ROBUST_SCENE | DYNAMIC_SCENE)
    }

    fn build(model: &Model, quality: u32, geometry_quality: u32, flags: u32) -> Self {
        let mut vertices = model.positions.clone();
        vertices.push(Vec3::ZERO);
        let triangles = model.triangles.clone();
        // SAFETY: all handles are live until they are released, and the buffers outlive the scene, and do not move.
        unsafe {
            let device = rtcNewDevice(ONE_THREAD.as_ptr());
            assert!(!device.is_null(), "Embree starts");
            rtcSetDeviceMemoryMonitorFunction(device, monitor, ptr::null_mut());
            let geometry = rtcNewGeometry(device, TRIANGLES);
            let positions = model.positions.len();
            let (stride, data) = (size_of::<Vec3>(), vertices.as_ptr().cast());
            rtcSetSharedGeometryBuffer(geometry, VERTEX_BUFFER, 0, FLOAT3, data, 0, stride, positions);
            let (stride, data) = (size_of::<[u32; 3]>(), triangles.as_ptr().cast());
            rtcSetSharedGeometryBuffer(geometry, INDEX_BUFFER, 0, UINT3, data, 0, stride, triangles.len());
            rtcSetGeometryBuildQuality(geometry, geometry_quality);
            rtcCommitGeometry(geometry);
            let scene = rtcNewScene(device);
            rtcSetSceneFlags(scene, flags);
            rtcSetSceneBuildQuality(scene, quality);
            rtcAttachGeometry(scene, geometry);
            rtcCommitScene(scene);
            assert_eq!(rtcGetDeviceError(device), 0, "Embree builds");
            Self {
                device,
                scene,
                geometry,
                vertices,
                _triangles: triangles,
            }
        }
    }
}

/// What Embree has allocated.
static HELD: AtomicIsize = AtomicIsize::new(0);

unsafe extern "C" fn monitor(_: *mut c_void, bytes: isize, _: bool) -> bool {
    HELD.fetch_add(bytes, Ordering::Relaxed);
    true
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: none was released before.
        unsafe {
            rtcReleaseGeometry(self.geometry);
            rtcReleaseScene(self.scene);
            rtcReleaseDevice(self.device);
        }
    }
}

impl MeshRays for Embree {
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut context = Context::PLAIN;
        let mut hit = RayHit {
            ray: RtcRay::new(ray),
            hit: crate::embree::Hit::NONE,
        };
        // SAFETY: the scene is live.
        unsafe { rtcIntersect1(self.scene, (&raw mut context).cast(), &raw mut hit) };
        (hit.hit.geometry != NONE).then_some((hit.ray.t_far, hit.hit.primitive))
    }

    fn any(&self, ray: &Ray) -> bool {
        let mut context = Context::PLAIN;
        let mut ray = RtcRay::new(ray);
        // SAFETY: the scene is live.
        unsafe { rtcOccluded1(self.scene, (&raw mut context).cast(), &raw mut ray) };
        ray.t_far == f32::NEG_INFINITY
    }
}

impl Refit for Embree {
    fn refit(&mut self, positions: &[Vec3]) {
        self.vertices[..positions.len()].copy_from_slice(positions);
        // SAFETY: the handles are live.
        unsafe {
            rtcUpdateGeometryBuffer(self.geometry, VERTEX_BUFFER, 0);
            rtcCommitGeometry(self.geometry);
            rtcCommitScene(self.scene);
        }
    }
}
