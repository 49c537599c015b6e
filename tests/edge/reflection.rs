//! What scene files and Bevy's remote protocol can carry: every type that the source declares, so that none is forgotten.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use bevy::{
    ecs::reflect::{ReflectComponent, ReflectEvent, ReflectResource},
    prelude::*,
    reflect::{TypeRegistration, TypeRegistry, serde::TypedReflectSerializer, std_traits::ReflectDefault},
};
use bevy_sightline::prelude::*;

/// What is not reflected, as its documentation says; and what is registered with types of the user's.
const NOT_REGISTERED: [&str; 11] = [
    "ClusterMaterials",
    "LevelVariants",
    "LodChoices",
    "MeshBvhs",
    "Occluders",
    "OcclusionBuffer",
    "PickShape",
    "PosedMeshes",
    "ProxyFailed",
    "SpatialIndex",
    "SpriteMasks",
];

/// Types that are reflected, and belong to no plugin that could register them.
const NO_PLUGIN: &str = "selection";

/// A public type, as it is declared.
struct Declared {
    file: PathBuf,
    derives: String,
}

impl Declared {
    fn is(&self, what: &str) -> bool {
        self.derives
            .split(|c: char| !c.is_alphanumeric())
            .any(|derived| derived == what)
    }
}

/// All public types that the source declares, with what they derive.
fn declared() -> BTreeMap<String, Declared> {
    let mut types = BTreeMap::new();
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for file in source_files(&src) {
        let text = fs::read_to_string(&file).expect("a readable source file");
        let mut derives = String::new();
        for line in text.lines().map(str::trim) {
            let declares = ["pub struct ", "pub enum "]
                .into_iter()
                .find_map(|kind| line.strip_prefix(kind));
            if line.starts_with("#[derive(") {
                derives = line.to_owned();
            } else if let Some(name) = declares {
                let name: String = name.chars().take_while(|c| c.is_alphanumeric()).collect();
                let (file, derives) = (file.clone(), std::mem::take(&mut derives));
                types.insert(name, Declared { file, derives });
            } else if !line.starts_with(['#', '/']) {
                derives.clear();
            }
        }
    }
    types
}

fn source_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder of sources");
    entries
        .map(|entry| entry.expect("a readable folder").path())
        .flat_map(|path| if path.is_dir() { source_files(&path) } else { vec![path] })
        .collect()
}

/// An app of whose types none has registered itself.
fn app() -> App {
    let mut app = App::new();
    app.insert_resource(AppTypeRegistry::default())
        .add_plugins((MinimalPlugins, SightlinePlugins));
    #[cfg(feature = "inspector")]
    app.add_plugins(SightlineInspectorPlugin);
    app
}

/// What the plugins have registered of their own types, by name.
fn registered(registry: &TypeRegistry) -> BTreeMap<&'static str, &TypeRegistration> {
    let info = |registration: &TypeRegistration| *registration.type_info().type_path_table();
    let ours = registry.iter().filter(|registration| {
        info(registration)
            .path()
            .starts_with(concat!(env!("CARGO_PKG_NAME"), "::"))
    });
    ours.map(|registration| (info(registration).short_path(), registration))
        .collect()
}

/// Whether a type is behind a feature that is off.
fn is_left_out(declared: &Declared) -> bool {
    let has = |folder: &str| declared.file.components().any(|part| part.as_os_str() == folder);
    has("gizmos") && !cfg!(feature = "gizmos")
        || has("inspector") && !cfg!(feature = "inspector")
        || has("simplify") && !cfg!(feature = "simplify")
        || has("sprite") && !cfg!(feature = "sprite")
}

#[test]
fn every_public_component_resource_and_event_is_registered_as_such() {
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let registered = registered(&registry);
    let mut missing = Vec::new();
    let mut found = 0;
    for (name, declared) in declared() {
        if NOT_REGISTERED.contains(&&*name) || is_left_out(&declared) {
            continue;
        }
        let (is_component, is_resource) = (declared.is("Component"), declared.is("Resource"));
        let is_event = declared.is("EntityEvent") || declared.is("Event") || declared.is("Message");
        // Stands in for Bevy's own where this is not there.
        let is_bevys = matches!(&*name, "RayCastBackfaces" | "SimplifiedMesh");
        if !(is_component || is_resource || is_event) || is_bevys {
            continue;
        }
        found += 1;
        let Some(registration) = registered.get(&*name) else {
            missing.push(format!("{name} is not registered"));
            continue;
        };
        let mut expect = |is: bool, has: bool, what: &str| {
            if is && !has {
                missing.push(format!("{name} is registered without {what}"));
            }
        };
        expect(
            is_component,
            registration.contains::<ReflectComponent>(),
            "ReflectComponent",
        );
        expect(
            is_resource,
            registration.contains::<ReflectResource>(),
            "ReflectResource",
        );
        expect(is_event, registration.contains::<ReflectEvent>(), "ReflectEvent");
        expect(!is_event, registration.contains::<ReflectDefault>(), "ReflectDefault");
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
    assert!(found > 25, "only {found} were found in the source");
}

#[test]
fn every_public_type_that_is_reflected_is_registered() {
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let registered = registered(&registry);
    let missing: Vec<String> = declared()
        .into_iter()
        .filter(|(name, declared)| {
            let has_plugin = !declared.file.components().any(|part| part.as_os_str() == NO_PLUGIN);
            let is_bevys = matches!(&**name, "RayCastBackfaces" | "SimplifiedMesh");
            declared.is("Reflect") && has_plugin && !is_bevys && !is_left_out(declared)
        })
        .map(|(name, _)| name)
        .filter(|name| !registered.contains_key(&**name) && !NOT_REGISTERED.contains(&&**name))
        .collect();
    assert!(missing.is_empty(), "not registered: {missing:?}");
}

#[test]
fn what_is_not_reflected_says_so() {
    let declared = declared();
    for name in NOT_REGISTERED {
        let text = fs::read_to_string(&declared[name].file).expect("a readable source file");
        let says_so = text.contains("/// Not reflected") || text.contains("/// For scenes and tools, register it");
        assert!(says_so, "{name}");
    }
}

#[test]
fn every_component_and_resource_is_written_and_has_types_that_are_known() {
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    for (name, registration) in registered(&registry) {
        let is_stored = registration.contains::<ReflectComponent>() || registration.contains::<ReflectResource>();
        let Some(default) = registration.data::<ReflectDefault>().filter(|_| is_stored) else {
            continue;
        };
        let value = default.default();
        let written = serde_json::to_string(&TypedReflectSerializer::new(value.as_partial_reflect(), &registry));
        assert!(written.is_ok(), "{name}: {written:?}");
    }
}

#[test]
fn variants_of_a_users_type_may_be_registered() {
    #[derive(Component, Clone, Default, Reflect)]
    #[reflect(Component, Default, Clone)]
    struct Paint(u8);

    let mut app = app();
    app.register_type::<LevelVariants<Paint>>();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let registration = registry.get(std::any::TypeId::of::<LevelVariants<Paint>>());
    assert!(registration.is_some_and(TypeRegistration::contains::<ReflectComponent>));
}
