//! The app that the plugins of every side are added to: no window, no GPU.

use bevy::{
    camera::CameraPlugin, image::ImagePlugin, input::InputPlugin, mesh::MeshPlugin, prelude::*, window::WindowPlugin,
};

/// An app with assets, meshes, cameras and input, that is yet to be finished.
pub(crate) fn app() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        TransformPlugin,
        AssetPlugin::default(),
        ImagePlugin::default(),
        MeshPlugin,
        WindowPlugin::default(),
        CameraPlugin,
        InputPlugin,
    ));
    app
}
