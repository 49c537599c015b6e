//! Arrows between the layers point downward only.

use std::{fs, path::Path};

/// Each layer with what it must not name.
const FORBIDDEN: [(&str, &[&str]); 11] = [
    (
        "geometry",
        &[
            "bevy::ecs",
            "Entity",
            "Component",
            "Query<",
            "Res<",
            "crate::spatial",
            "crate::mesh",
            "crate::index",
            "crate::raster",
            "crate::occlusion",
            "crate::lod",
            "crate::culling",
            "crate::picking",
            "crate::selection",
            "crate::sprite",
            "crate::debug",
        ],
    ),
    (
        "spatial",
        &[
            "bevy::ecs",
            "Entity",
            "Component",
            "Query<",
            "Res<",
            "crate::mesh",
            "crate::index",
            "crate::raster",
            "crate::occlusion",
            "crate::lod",
            "crate::culling",
            "crate::picking",
            "crate::selection",
            "crate::sprite",
            "crate::debug",
        ],
    ),
    (
        "mesh",
        &[
            "bevy::ecs",
            "bevy::asset",
            "Entity",
            "Component",
            "Query<",
            "Res<",
            "crate::index",
            "crate::raster",
            "crate::occlusion",
            "crate::lod",
            "crate::culling",
            "crate::picking",
            "crate::selection",
            "crate::sprite",
            "crate::debug",
        ],
    ),
    (
        "index",
        &[
            "crate::raster",
            "crate::occlusion",
            "crate::lod",
            "crate::culling",
            "crate::picking",
            "crate::selection",
            "crate::sprite",
            "crate::debug",
        ],
    ),
    (
        "raster",
        &[
            "bevy::ecs",
            "Entity",
            "Component",
            "Query<",
            "Res<",
            "crate::mesh",
            "crate::index",
            "crate::occlusion",
            "crate::lod",
            "crate::culling",
            "crate::picking",
            "crate::selection",
            "crate::sprite",
            "crate::debug",
        ],
    ),
    (
        "occlusion",
        &[
            "crate::lod",
            "crate::culling",
            "crate::picking",
            "crate::selection",
            "crate::sprite",
            "crate::debug",
        ],
    ),
    (
        "lod",
        &[
            "crate::raster",
            "crate::occlusion",
            "crate::culling",
            "crate::picking",
            "crate::selection",
            "crate::sprite",
            "crate::debug",
        ],
    ),
    (
        "culling",
        &["crate::picking", "crate::selection", "crate::sprite", "crate::debug"],
    ),
    (
        "picking",
        &["crate::culling", "crate::selection", "crate::sprite", "crate::debug"],
    ),
    (
        "selection",
        &["crate::culling", "crate::picking", "crate::sprite", "crate::debug"],
    ),
    ("sprite", &["crate::debug"]),
];

#[test]
fn lower_layers_do_not_name_upper_ones() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut offences = Vec::new();
    for (layer, forbidden) in FORBIDDEN {
        let files = source_files(&src.join(layer));
        assert!(!files.is_empty(), "no files in the layer {layer}");
        for file in files {
            let text = fs::read_to_string(&file).expect("a readable source file");
            let lines = text
                .lines()
                .enumerate()
                .filter(|(_, line)| !line.trim_start().starts_with("//"));
            for (number, line) in lines {
                offences.extend(
                    forbidden
                        .iter()
                        .filter(|name| line.contains(**name))
                        .map(|name| format!("{}:{}: names {name}", file.display(), number + 1)),
                );
            }
        }
    }
    assert!(offences.is_empty(), "{}", offences.join("\n"));
}

/// All files below a folder.
pub fn source_files(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = fs::read_dir(folder).expect("a layer is a folder");
    entries
        .map(|entry| entry.expect("a readable folder").path())
        .flat_map(|path| if path.is_dir() { source_files(&path) } else { vec![path] })
        .collect()
}
