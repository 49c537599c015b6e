//! The figures of this frame.

use std::time::Duration;

use bevy::{prelude::*, time::common_conditions::on_timer};
use bevy_sightline::{index::MeshBvhs, mesh::TriangleMesh, prelude::*};

use crate::{controls::Settings, panel::panel, sight::Sight, stopwatch::Stopwatch, walk::Walker};

const HELP: &str = "\
O: occlusion  M: mode  R: resolution  V: small pictures
Space: walk   W A S D E Q, right mouse button: go yourself";

/// In the place of a time that was not measured yet.
const UNKNOWN: &str = "... ms (press O)";

#[derive(Component)]
struct Figures;

pub fn plugin(app: &mut App) {
    app.add_systems(Startup, |mut commands: Commands| {
        commands.spawn(panel(Figures, "loading"));
    })
    .add_systems(Update, tell.run_if(on_timer(Duration::from_millis(200))));
}

/// How many triangles some entities have, in millions.
pub fn millions(entities: &[Entity], meshes: &Query<&Mesh3d>, bvhs: &MeshBvhs) -> f64 {
    let triangles = |mesh: &Mesh3d| bvhs.triangles(mesh.id()).map_or(0, TriangleMesh::len);
    let all: usize = meshes.iter_many(entities).map(triangles).sum();
    all as f64 / 1e6
}

fn tell(
    sight: Res<Sight>,
    watch: Res<Stopwatch>,
    settings: Res<Settings>,
    index: Res<SpatialIndex>,
    bvhs: Res<MeshBvhs>,
    meshes: Query<&Mesh3d>,
    buffer: Query<&OcclusionBuffer, With<Walker>>,
    mut text: Single<&mut Text, With<Figures>>,
) {
    let Settings(SoftwareOcclusion { mode, resolution, .. }) = *settings;
    let buffer = buffer.single().ok();
    let mark = |chosen| if chosen { ">" } else { " " };
    let (seen, hidden) = (sight.seen.len(), sight.hidden.len());
    let stats = buffer.map(|buffer| *buffer.stats()).unwrap_or_default();
    let [seen_millions, hidden_millions] =
        [&sight.seen, &sight.hidden].map(|entities| millions(entities, &meshes, &bvhs));
    text.0 = format!(
        "{} things, {} in the frustum:\n  \
         drawn  {seen:>6}, {seen_millions:.1} million triangles\n  \
         hidden {hidden:>6}, {hidden_millions:.1} million triangles\n\
         {} with occlusion, found in {}\n\
         {} without,        found in {}\n\
         {mode:?}, {} x {}: {} occluders, {} triangles, {} tests\n\n{HELP}",
        index.len(),
        seen + hidden,
        mark(buffer.is_some()),
        watch.with_occlusion.tell(2, UNKNOWN),
        mark(buffer.is_none()),
        watch.without.tell(2, UNKNOWN),
        resolution.x,
        resolution.y,
        stats.occluders,
        stats.triangles,
        stats.tested,
    );
}
