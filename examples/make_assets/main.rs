//! Writes the models of the example city into `assets/`: buildings, street objects, trees, cars and people as glTF
//! binary files, all made of a few dozen lines of geometry each.
//!
//! ```sh
//! cargo run --example make_assets
//! ```
//!
//! The files are in the repository already, and each run writes the same bytes again; run this after a change to a
//! model.
//!
//! What to look for: the printed table. Every file holds its model at three levels of detail, `<name>`, `<name>_lod1`
//! and `<name>_lod2`, each a mesh, a node and a scene of its own; the proxies fill the same bounds as the model with
//! fewer triangles. Colours are vertex colours, so one white material serves everything.
//!
//! `fox.glb` has a skeleton and two animations, `jelly.glb` morph targets and one; they come at one level.
//!
//! `shape.rs` has the building blocks, `glb.rs` the file format, and the other modules the models. All stand on y = 0,
//! in metres, and face +z.

mod civic;
mod color;
mod fox;
mod fox_motion;
mod glb;
mod houses;
mod jelly;
mod math;
mod morph;
mod nature;
mod outline;
mod rig;
mod shape;
mod statue;
mod street;
mod towers;
mod vehicles;

use std::path::Path;

use math::vec3;
use shape::Shape;

/// How closely a model is to be looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    Full,
    Middle,
    Far,
}

impl Level {
    const ALL: [(Self, &str); 3] = [(Self::Full, ""), (Self::Middle, "_lod1"), (Self::Far, "_lod2")];

    /// The one of three values that belongs to this level.
    fn pick<T>(self, full: T, middle: T, far: T) -> T {
        match self {
            Self::Full => full,
            Self::Middle => middle,
            Self::Far => far,
        }
    }
}

type Model = fn(Level) -> Shape;

const MODELS: [(&str, Model); 26] = [
    ("tower_round", towers::round),
    ("tower_twisted", towers::twisted),
    ("tower_stepped", towers::stepped),
    ("tower_glass", towers::glass),
    ("office_block", towers::office_block),
    ("apartment_block", houses::apartment_block),
    ("row_house", houses::row_house),
    ("corner_shop", houses::corner_shop),
    ("warehouse", houses::warehouse),
    ("church", civic::church),
    ("water_tower", civic::water_tower),
    ("arch_gate", civic::arch_gate),
    ("bridge_arch", civic::bridge_arch),
    ("pavilion_dome", civic::pavilion_dome),
    ("fountain", civic::fountain),
    ("statue", statue::statue),
    ("tree_oak", nature::tree_oak),
    ("tree_pine", nature::tree_pine),
    ("person", nature::person),
    ("lamp_street", street::lamp_street),
    ("bench", street::bench),
    ("hydrant", street::hydrant),
    ("traffic_light", street::traffic_light),
    ("bus_stop", street::bus_stop),
    ("car_sedan", vehicles::car_sedan),
    ("car_van", vehicles::car_van),
];

fn main() -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    std::fs::create_dir_all(&folder)?;
    println!(
        "{:22}{:>9}{:>10}{:>8}{:>8}",
        "file", "bytes", "triangles", "lod1", "lod2"
    );
    for (name, model) in MODELS {
        let shapes = levels(name, model);
        let bytes = glb::encode(&shapes);
        let file = format!("{name}.glb");
        std::fs::write(folder.join(&file), &bytes)?;
        let [full, middle, far] = shapes.each_ref().map(|(_, shape)| shape.triangles.len());
        println!("{file:22}{:>9}{full:>10}{middle:>8}{far:>8}", bytes.len());
    }
    let rig = fox::rig();
    let bytes = glb::encode_rig("fox", &rig);
    std::fs::write(folder.join("fox.glb"), &bytes)?;
    let triangles: usize = rig.skin.iter().map(|part| part.shape.triangles.len()).sum();
    println!("{:22}{:>9}{triangles:>10}", "fox.glb", bytes.len());
    let morph = jelly::morph();
    let bytes = glb::encode_morph("jelly", &morph);
    std::fs::write(folder.join("jelly.glb"), &bytes)?;
    let triangles = morph.base.triangles.len();
    println!("{:22}{:>9}{triangles:>10}", "jelly.glb", bytes.len());
    Ok(())
}

/// A model's three levels, named: the full one centred on the ground, the proxies fitted to its bounds.
fn levels(name: &str, model: Model) -> [(String, Shape); 3] {
    let full = model(Level::Full).bounds();
    let half = (full.max - full.min).scaled(vec3(0.5, 1.0, 0.5));
    let target = shape::Bounds {
        min: vec3(-half.x, 0.0, -half.z),
        max: half,
    };
    Level::ALL.map(|(level, suffix)| (format!("{name}{suffix}"), model(level).fitted(target)))
}
