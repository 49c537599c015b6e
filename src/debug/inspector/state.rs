//! What the panel shows.

use bevy::{
    ecs::{entity::Entity, reflect::ReflectResource, resource::Resource},
    input::keyboard::KeyCode,
    reflect::{Reflect, std_traits::ReflectDefault},
};

/// The panel: whether it is open, and what it shows. May be changed at any time.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct SightlineInspector {
    /// Whether it is shown. False by default: then nothing is done for it.
    pub open: bool,
    /// Whether it is a panel of its own while it is open. True by default; false for those who show
    /// [`inspector_ui`](super::inspector_ui) in a window of theirs.
    pub panel: bool,
    /// What opens and closes it. `F1` by default; `None` if the game does so by itself.
    pub key: Option<KeyCode>,
    /// Which tab is shown.
    pub tab: InspectorTab,
    /// The entity that all tabs tell of, which is marked in the scene while the panel is open.
    pub selected: Option<Entity>,
    /// The camera whose view is told of: by default the first that culls.
    pub view: Option<Entity>,
    /// Whether a click on something in the scene selects it while the panel is open. True by default.
    pub select_by_click: bool,
}

impl Default for SightlineInspector {
    fn default() -> Self {
        Self {
            open: false,
            panel: true,
            key: Some(KeyCode::F1),
            tab: InspectorTab::default(),
            selected: None,
            view: None,
            select_by_click: true,
        }
    }
}

/// The tabs of the [`SightlineInspector`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq, Hash)]
pub enum InspectorTab {
    /// What is indexed, what is not and why, and what that costs.
    #[default]
    Index,
    /// The ray under the mouse: what it visits, and what it hits.
    Query,
    /// What cameras see, and why not the rest.
    Culling,
    /// Which levels of detail are shown.
    Lod,
    /// The structures: drawn, and compared with others over the same entities.
    Structures,
}

impl InspectorTab {
    /// All of them, in the order in which they are shown.
    pub const ALL: [Self; 5] = [Self::Index, Self::Query, Self::Culling, Self::Lod, Self::Structures];

    /// What stands on it.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Index => "Index",
            Self::Query => "Query",
            Self::Culling => "Culling",
            Self::Lod => "LOD",
            Self::Structures => "Structures",
        }
    }
}
