//! One mesh, simplified to a target.

use std::sync::OnceLock;

use bevy::mesh::{Indices, Mesh, PrimitiveTopology};
use meshopt::{SimplifyOptions, VertexDataAdapter};

use super::{
    Deviation, DeviationSettings, SimplifyError, SimplifyTarget,
    source::{Source, attributes, has_morph_targets},
};
use crate::{
    mesh::{MeshBuildSettings, MeshBvh, TriangleMesh},
    spatial::{BuildProgress, BuildStrategy},
};

/// Makes simpler meshes of one mesh, and measures them against it.
///
/// Vertices are taken away, never moved: those that are left have all of their attributes as they were, whatever they
/// are. Which go is decided by the quadrics of Garland and Heckbert, *Simplifying Surfaces with Color and Texture using
/// Quadric Error Metrics*, 1998, as the crate `meshopt` has them: of positions, normals, vertex colours, joint weights
/// and morph targets, so that a straight arm keeps the vertices that it is bent at. Vertices at which texture
/// coordinates are torn stay on the seam, unless a ratio cannot be reached with them; nor are whole parts given up but
/// for an error that allows it, or a ratio that cannot be reached otherwise.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sightline::lod::simplify::{Simplifier, SimplifyTarget};
/// let sphere = Mesh::from(Sphere::new(1.0));
/// let simplifier = Simplifier::new(&sphere).expect("a mesh with a surface");
/// let rough = simplifier.simplify(SimplifyTarget::Error(0.02), false).expect("a target");
/// assert!(rough.triangles < simplifier.triangles());
/// // No point of either is farther from the other than two hundredths of the diameter.
/// assert!(rough.deviation.at_most <= 0.04);
/// ```
#[derive(Debug)]
pub struct Simplifier {
    mesh: Mesh,
    source: Source,
    listed: TriangleMesh,
    /// Over the triangles; once something is measured.
    bvh: OnceLock<MeshBvh>,
}

/// A simpler mesh.
#[derive(Clone, Debug)]
pub struct Simplified {
    /// A triangle list with indices, with the vertex attributes of the original.
    pub mesh: Mesh,
    /// How many triangles it has.
    pub triangles: usize,
    /// How far it is from the original, in units of the mesh; of skinned and morphed meshes, at rest.
    pub deviation: Deviation,
}

/// How a level is made.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Attempt {
    target_count: usize,
    /// As a fraction of the extent.
    error: f32,
    options: SimplifyOptions,
    keeps_seams: bool,
}

/// How many times more triangles than the target a level may have before more is given up for it.
const TOLERANCE: f32 = 1.25;
/// No error is larger than this many extents.
const ANY_ERROR: f32 = 1e6;
/// How often a level is made to meet an error.
const ATTEMPTS: usize = 8;

impl Simplifier {
    /// Reads a mesh, without triangles that have indices out of range, or positions that are NaN or infinite.
    ///
    /// # Errors
    ///
    /// If it has no surface, or vertex attributes of different lengths, or overflows.
    pub fn new(mesh: &Mesh) -> Result<Self, SimplifyError> {
        let listed = TriangleMesh::from_mesh(mesh)?;
        let source = Source::new(mesh, &listed)?;
        Ok(Self {
            mesh: mesh.clone(),
            source,
            listed,
            bvh: OnceLock::new(),
        })
    }

    /// How many triangles the mesh has, without those that are unusable.
    pub fn triangles(&self) -> usize {
        self.listed.len()
    }

    /// The longest side of the box of the mesh, in its units.
    pub fn extent(&self) -> f32 {
        self.source.extent
    }

    /// The triangles of the mesh, to be measured against.
    pub fn bvh(&self) -> &MeshBvh {
        self.bvh.get_or_init(|| build(&self.listed))
    }

    /// Makes a simpler mesh. With `lock_borders`, vertices at open edges stay: neighbours that share them still fit.
    ///
    /// It may be less simple than the target wants it, for what can be taken away is limited. A mesh with morph targets
    /// keeps all its vertices and their order, for the displacements are looked up by it; only triangles are taken
    /// away.
    ///
    /// # Errors
    ///
    /// If the target is NaN or negative.
    pub fn simplify(&self, target: SimplifyTarget, lock_borders: bool) -> Result<Simplified, SimplifyError> {
        let made = self.simplify_with(target, lock_borders, None)?;
        Ok(made.expect("nothing calls it off"))
    }

    /// The same; nothing if `progress` was told to cancel.
    pub(super) fn simplify_with(
        &self,
        target: SimplifyTarget,
        lock_borders: bool,
        progress: Option<&BuildProgress>,
    ) -> Result<Option<Simplified>, SimplifyError> {
        let mut options = SimplifyOptions::Permissive;
        options.set(SimplifyOptions::LockBorder, lock_borders);
        let made = match target.checked()? {
            SimplifyTarget::Ratio(ratio) => {
                let triangles = (f64::from(ratio.min(1.0)) * self.triangles() as f64) as usize;
                self.by_count(triangles, options, progress)
            }
            SimplifyTarget::Error(error) => self.by_error(error, options, progress),
        };
        Ok(made)
    }

    /// So many triangles, or a few less.
    fn by_count(
        &self,
        triangles: usize,
        options: SimplifyOptions,
        progress: Option<&BuildProgress>,
    ) -> Option<Simplified> {
        let target_count = 3 * triangles;
        let enough = target_count as f32 * TOLERANCE;
        let attempt = Attempt {
            target_count,
            error: ANY_ERROR,
            options,
            keeps_seams: true,
        };
        let mut indices = self.reduce(&attempt);
        // Without seams of texture coordinates if need be, and then without whole parts, but not without most of them.
        if indices.len() as f32 > enough {
            let torn = Attempt {
                keeps_seams: false,
                ..attempt
            };
            indices = self.reduce(&torn);
            if indices.len() as f32 > enough {
                let pruned = self.reduce(&Attempt {
                    options: with_pruning(options),
                    ..torn
                });
                if pruned.len() >= target_count / 2 && !pruned.is_empty() {
                    indices = pruned;
                }
            }
        }
        self.finish(indices, self.source.extent * NEGLIGIBLE, progress)
    }

    /// As few triangles as the measured error allows: quadrics tell only about how large it will be.
    fn by_error(&self, error: f32, options: SimplifyOptions, progress: Option<&BuildProgress>) -> Option<Simplified> {
        let most = error.max(NEGLIGIBLE) * self.source.extent;
        let mut best = self.unchanged();
        let (mut fits, mut fails) = (0.0, f32::INFINITY);
        let mut tried = error.clamp(NEGLIGIBLE, ANY_ERROR);
        for _ in 0..ATTEMPTS {
            let indices = self.reduce(&Attempt {
                target_count: 0,
                error: tried,
                options: with_pruning(options),
                keeps_seams: true,
            });
            let made = self.finish(indices, self.source.extent * NEGLIGIBLE, progress)?;
            let measured = made.deviation.at_most;
            if measured <= most {
                fits = tried;
                if made.triangles < best.triangles {
                    best = made;
                }
                if measured > most * 0.8 {
                    break;
                }
            } else {
                fails = tried;
            }
            // The error grows about as what is asked for does.
            let guess = tried * if measured > 0.0 { 0.9 * most / measured } else { 4.0 };
            tried = if guess > fits && guess < fails {
                guess
            } else if fails.is_finite() {
                (fits + fails) / 2.0
            } else {
                fits * 2.0
            };
            if !(tried > 0.0 && tried < ANY_ERROR) || fails.is_finite() && fails - fits <= 0.1 * fails {
                break;
            }
        }
        Some(best)
    }

    /// The triangles that are left, in vertices of the source.
    fn reduce(&self, attempt: &Attempt) -> Vec<u32> {
        let source = &self.source;
        let bytes = meshopt::typed_to_bytes(&source.positions);
        let Ok(positions) = VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0) else {
            return source.indices.clone();
        };
        let free = vec![meshopt::SimplifyVertex::None; source.positions.len()];
        meshopt::simplify_with_attributes_and_locks(
            &source.indices,
            &positions,
            &source.features.values,
            &source.features.weights,
            source.features.weights.len() * size_of::<f32>(),
            if attempt.keeps_seams { &source.seams } else { &free },
            attempt.target_count.min(source.indices.len()),
            attempt.error,
            attempt.options,
            None,
        )
    }

    fn unchanged(&self) -> Simplified {
        Simplified {
            mesh: self.mesh.clone(),
            triangles: self.triangles(),
            deviation: Deviation::default(),
        }
    }

    /// The mesh of what is left, measured.
    fn finish(&self, mut indices: Vec<u32>, negligible: f32, progress: Option<&BuildProgress>) -> Option<Simplified> {
        // Of what is smaller than a point nothing may be left: a triangle stands in for it.
        if indices.is_empty() {
            indices = self.largest().to_vec();
        }
        meshopt::optimize_vertex_cache_in_place(&mut indices, self.source.positions.len());
        for index in &mut indices {
            *index = self.source.numbers[*index as usize];
        }
        let mesh = with_triangles(&self.mesh, indices);
        let listed = TriangleMesh::from_mesh(&mesh).ok()?;
        let settings = DeviationSettings {
            negligible,
            ..DeviationSettings::default()
        };
        let deviation = Deviation::measure(self.bvh(), &build(&listed), &settings, progress)?;
        Some(Simplified {
            mesh,
            triangles: listed.len(),
            deviation,
        })
    }

    /// The triangle with the largest area.
    fn largest(&self) -> [u32; 3] {
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] =
                triangle.map(|vertex| bevy::math::Vec3::from(self.source.positions[vertex as usize]).as_dvec3());
            (b - a).cross(c - a).length_squared()
        };
        let triangles = self.source.indices.as_chunks::<3>().0;
        let largest = triangles.iter().max_by(|a, b| area(a).total_cmp(&area(b)));
        *largest.expect("there are no meshes without triangles")
    }
}

/// Whole parts may be given up too, unless their borders are locked.
fn with_pruning(options: SimplifyOptions) -> SimplifyOptions {
    if options.contains(SimplifyOptions::LockBorder) {
        options
    } else {
        options | SimplifyOptions::Prune
    }
}

/// The error that need not be told from a smaller one, as a fraction of the extent: it is a pixel where the mesh is ten
/// thousand pixels large.
pub(super) const NEGLIGIBLE: f32 = 1e-4;

/// Over what is measured once or a few times.
fn build(triangles: &TriangleMesh) -> MeshBvh {
    let settings = MeshBuildSettings {
        strategy: BuildStrategy::Ploc,
        ..MeshBuildSettings::default()
    };
    MeshBvh::build_alone(triangles, &settings, None).expect("nothing calls it off")
}

/// A mesh of some of the triangles of another, by its vertices; of those the ones that are used, in the order in which
/// they are.
pub(super) fn with_triangles(mesh: &Mesh, mut indices: Vec<u32>) -> Mesh {
    let mut made = Mesh::new(PrimitiveTopology::TriangleList, mesh.asset_usage);
    made.enable_raytracing = mesh.enable_raytracing;
    made.set_skinned_mesh_bounds(mesh.skinned_mesh_bounds().cloned());
    for (attribute, values) in attributes(mesh) {
        made.insert_attribute(*attribute, values.clone());
    }
    if has_morph_targets(mesh) {
        if let Ok(targets) = mesh.try_morph_targets() {
            made.set_morph_targets(targets.clone());
        }
        if let Ok(Some(names)) = mesh.try_morph_target_names() {
            made.set_morph_target_names(names.to_vec());
        }
    } else {
        let mut kept = Vec::new();
        let mut of_vertex = vec![u32::MAX; mesh.count_vertices()];
        for index in &mut indices {
            let known = &mut of_vertex[*index as usize];
            if *known == u32::MAX {
                *known = kept.len() as u32;
                kept.push(*index);
            }
            *index = *known;
        }
        // One vertex for each index: of the list of those that are kept, themselves.
        made.insert_indices(Indices::U32(kept));
        made.duplicate_vertices();
    }
    made.insert_indices(indices_of(indices, made.count_vertices()));
    made
}

/// Indices as small as they can be.
fn indices_of(indices: Vec<u32>, vertices: usize) -> Indices {
    if vertices <= usize::from(u16::MAX) {
        Indices::U16(indices.into_iter().map(|index| index as u16).collect())
    } else {
        Indices::U32(indices)
    }
}
