//! Proxies made for you: levels of detail of a mesh, and one proxy for a whole block.
//!
//! # In an app
//!
//! [`AutoProxy`] on an entity with a mesh has simpler meshes made of it, and [`ClusterProxy`] on the root of a block
//! one of all that is below; both in the background, and both fill a [`ProxyLod`](super::ProxyLod). [`ProxyProgress`]
//! tells how many are done of how many, [`ProxyReady`] and [`ProxyFailed`] of each entity how it went.
//!
//! ```no_run
//! # use bevy::prelude::*;
//! # use bevy_sightline::prelude::*;
//! # let mut app = App::new();
//! // Every mesh gets levels of detail.
//! app.register_required_components::<Mesh3d, AutoProxy>();
//!
//! fn loading_bar(progress: Res<ProxyProgress>) {
//!     println!("{} of {}", progress.done, progress.total);
//! }
//! app.add_systems(Update, loading_bar.run_if(resource_changed::<ProxyProgress>));
//! ```
//!
//! # Error
//!
//! The threshold of a level is how far it is from the original: a [`Deviation`], which is measured after the mesh was
//! made, and is an upper bound, of both how far the level is from the original and the original from the level. So
//! where a level is chosen, no point of it is farther than the promised pixels from where the original would have one,
//! in the middle of the screen; a perspective stretches everything at the edges of a wide screen, and this with it.
//!
//! # Without an app
//!
//! [`Simplifier`] makes one mesh of one mesh, [`MeshChain`] several, [`merge_meshes`] one of several. They know of
//! `Mesh` and nothing else of Bevy.

mod auto_proxy;
mod chain;
mod clusters;
mod deviation;
mod error;
mod features;
mod gather;
mod job;
mod materials;
mod merge;
mod progress;
mod proxies;
mod simplifier;
mod source;

pub use auto_proxy::{AutoProxy, ClusterProxy};
pub use chain::MeshChain;
pub use deviation::{Deviation, DeviationSettings};
pub use error::{SimplifyError, SimplifyTarget};
pub use materials::ClusterMaterials;
pub use merge::merge_meshes;
pub use progress::{ProxyFailed, ProxyProgress, ProxyReady, ProxyStats};
pub use simplifier::{Simplified, Simplifier};

use bevy::{
    app::{App, Plugin, PostUpdate},
    asset::{AssetEvent, Assets},
    ecs::{
        component::Component,
        message::Messages,
        schedule::{IntoScheduleConfigs, SystemSet, common_conditions::resource_exists},
    },
    mesh::Mesh,
};

use super::{LodSystems, ProxyLodPlugin};
use clusters::ClusterProxies;
use proxies::AutoProxies;

/// When proxies are made; all in `PostUpdate`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, SystemSet)]
pub enum AutoProxySystems {
    /// What is asked for is begun, and what is made handed out: before [`LodSystems::Follow`].
    Make,
}

/// Makes proxies for [`AutoProxy`] and [`ClusterProxy`]. Adds [`ProxyLodPlugin`] by itself.
///
/// Costs nothing where there are none of these. Does nothing without `Assets<Mesh>`.
#[derive(Clone, Debug, Default)]
pub struct AutoProxyPlugin {
    materials: ClusterMaterials,
}

impl AutoProxyPlugin {
    /// Makes a proxy of its own of the parts of a block that have the same value of a component, and gives it that
    /// component: a material.
    ///
    /// Of several, those go together that have the same value of each. Without any, a block becomes one mesh without a
    /// material. Where the plugin has been added already, as one of the
    /// [`SightlinePlugins`](crate::SightlinePlugins), ask the resource [`ClusterMaterials`] instead.
    ///
    /// ```no_run
    /// # use bevy::prelude::*;
    /// # use bevy_sightline::prelude::*;
    /// App::new().add_plugins((
    ///     DefaultPlugins,
    ///     SightlinePlugins.set(AutoProxyPlugin::default().with_material::<MeshMaterial3d<StandardMaterial>>()),
    /// ));
    /// ```
    pub fn with_material<C: Component + Clone + PartialEq>(mut self) -> Self {
        self.materials.add::<C>();
        self
    }
}

impl Plugin for AutoProxyPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(ProxyLodPlugin)
            .insert_resource(self.materials.clone())
            .init_resource::<AutoProxies>()
            .init_resource::<ClusterProxies>()
            .init_resource::<ProxyProgress>()
            .init_resource::<ProxyStats>()
            .register_type::<AutoProxy>()
            .register_type::<ClusterProxy>()
            .register_type::<ProxyProgress>()
            .register_type::<ProxyStats>()
            .register_type::<ProxyReady>()
            .configure_sets(
                PostUpdate,
                AutoProxySystems::Make
                    .before(LodSystems::Follow)
                    .run_if(resource_exists::<Assets<Mesh>>)
                    .run_if(resource_exists::<Messages<AssetEvent<Mesh>>>),
            )
            .add_systems(
                PostUpdate,
                (
                    proxies::follow_users,
                    proxies::make_levels,
                    clusters::follow_clusters,
                    clusters::make_clusters.run_if(clusters::clusters_are_pending),
                    progress::count_progress,
                )
                    .chain()
                    .in_set(AutoProxySystems::Make),
            );
    }
}
