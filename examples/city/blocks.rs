//! One mesh for each block, which stands in for all that is in it from far away.

use bevy::{
    asset::RenderAssetUsages,
    camera::primitives::MeshAabb,
    ecs::system::SystemParam,
    mesh::{Indices, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues},
    platform::collections::{HashMap, HashSet},
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::{
    interaction::Dragged,
    levels::{BLOCK, Hits, Levels, OtherLevel, range_of_block, range_without_block},
    options::Options,
    plan::{DESIGNS, District, Plan},
    scenery::{Models, Slab, Thing, is_building},
    traffic::spawn_travellers,
};

/// What stands on the ground of a block, which is its parent.
#[derive(Component)]
pub struct Lot {
    design: (District, u32),
    things: Vec<Entity>,
    proxy: Option<Entity>,
}

/// Stands in for a block.
#[derive(Component)]
pub struct Proxy;

/// Whether all blocks have their proxies.
#[derive(Resource, Default)]
pub struct ProxiesAreUp(pub bool);

pub fn plugin(app: &mut App) {
    app.init_resource::<ProxiesAreUp>()
        .add_systems(PostStartup, settle.after(spawn_travellers))
        .add_systems(
            Update,
            (raise_proxies.run_if(|done: Res<ProxiesAreUp>| !done.0), leave_block),
        );
}

/// Makes things the children of the ground of their blocks.
fn settle(
    mut commands: Commands,
    options: Res<Options>,
    slabs: Query<(Entity, &Slab, &Transform), Without<Thing>>,
    mut things: Query<(Entity, &Thing, &mut Transform)>,
) {
    let plan = Plan { blocks: options.blocks };
    let mut of_blocks: Vec<Vec<Entity>> = vec![Vec::new(); (plan.blocks * plan.blocks) as usize];
    let centers: HashMap<u32, Vec3> = slabs
        .iter()
        .map(|(_, slab, place)| (slab.0, place.translation))
        .collect();
    for (entity, thing, mut place) in &mut things {
        if let Some(block) = thing.block {
            of_blocks[block as usize].push(entity);
            place.translation -= centers[&block];
        }
    }
    let districts: Vec<District> = plan.districts().map(|(_, district)| district).collect();
    for (entity, slab, _) in &slabs {
        let things = std::mem::take(&mut of_blocks[slab.0 as usize]);
        let design = (districts[slab.0 as usize], slab.0 % DESIGNS);
        commands.entity(entity).add_children(&things).insert(Lot {
            design,
            things,
            proxy: None,
        });
    }
}

/// Makes the meshes of blocks.
#[derive(SystemParam)]
struct Builder<'w, 's> {
    meshes: ResMut<'w, Assets<Mesh>>,
    levels: Res<'w, Levels>,
    things: Query<'w, 's, (&'static Thing, &'static Transform)>,
    /// What is put together, by model.
    parts: Local<'s, HashMap<&'static str, Mesh>>,
}

impl Builder<'_, '_> {
    /// All that is large among some things, in one mesh.
    fn merge(&mut self, things: &[Entity]) -> Handle<Mesh> {
        let mut merged: Option<Mesh> = None;
        for (thing, place) in self.things.iter_many(things) {
            let is_tree = thing.model.starts_with("tree");
            if !is_tree && !is_building(thing.model) {
                continue;
            }
            let meshes = &self.meshes;
            let coarsest = self.levels.coarsest(thing.model).and_then(|mesh| meshes.get(mesh));
            let Some(coarsest) = coarsest else {
                continue;
            };
            let part = self.parts.entry(thing.model).or_insert_with(|| {
                if is_tree {
                    cone(coarsest)
                } else {
                    without_texture(coarsest)
                }
            });
            let part = part.clone().transformed_by(*place);
            match &mut merged {
                // Of the same attributes, all of them.
                Some(merged) => merged.merge(&part).expect("meshes that were made alike"),
                None => merged = Some(part),
            }
        }
        self.meshes
            .add(merged.unwrap_or_else(|| Cuboid::from_length(0.1).into()))
    }
}

/// What all parts have: positions, normals and colours.
fn without_texture(mesh: &Mesh) -> Mesh {
    let mut part = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    let kept: [MeshVertexAttribute; 3] = [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL, Mesh::ATTRIBUTE_COLOR];
    for attribute in kept {
        if let Some(values) = mesh.attribute(attribute) {
            part.insert_attribute(attribute, values.clone());
        }
    }
    let vertices = mesh.count_vertices() as u32;
    let indices = mesh
        .indices()
        .map(|indices| indices.iter().map(|index| index as u32).collect());
    part.insert_indices(Indices::U32(indices.unwrap_or_else(|| (0..vertices).collect())));
    part
}

/// A cone of the size and the colour of a tree.
fn cone(tree: &Mesh) -> Mesh {
    const SIDES: u32 = 6;
    let bounds = tree.compute_aabb().unwrap_or_default();
    let (radius, height) = (bounds.half_extents.x * 0.85, 2.0 * bounds.half_extents.y);
    let mut cone: Mesh = Cone::new(radius, 0.85 * height).mesh().resolution(SIDES).into();
    cone.transform_by(Transform::from_xyz(0.0, 0.575 * height, 0.0));
    let color = match tree.attribute(Mesh::ATTRIBUTE_COLOR) {
        Some(VertexAttributeValues::Float32x4(colors)) => {
            colors.iter().map(|&color| Vec4::from(color)).sum::<Vec4>() / colors.len().max(1) as f32
        }
        _ => Vec4::ONE,
    };
    let colors = vec![color.to_array(); cone.count_vertices()];
    without_texture(&cone.with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colors))
}

/// Gives each block its proxy, as soon as all models are there. Those of one design share a mesh.
fn raise_proxies(
    mut commands: Commands,
    mut builder: Builder,
    mut lots: Query<(Entity, &Slab, &mut Lot)>,
    models: Res<Models>,
    hits: Option<Res<Hits>>,
    mut done: ResMut<ProxiesAreUp>,
) {
    if !builder.levels.are_loaded(&builder.meshes) {
        return;
    }
    let mut made = HashMap::new();
    for (slab, &Slab(number), mut lot) in &mut lots {
        let mesh = made
            .entry(lot.design)
            .or_insert_with(|| builder.merge(&lot.things))
            .clone();
        let look = (Mesh3d(mesh.clone()), MeshMaterial3d(models.painted.clone()));
        let name = Name::new(format!("proxy of block {number}"));
        let mut proxy = commands.spawn((name, Proxy, look, Transform::default(), ChildOf(slab)));
        lot.proxy = Some(proxy.id());
        match hits.as_deref() {
            Some(&hits) => {
                let group = group(&lot, &builder.meshes, &mesh, hits);
                commands.entity(slab).insert(group);
            }
            None => {
                proxy.insert(range_of_block());
            }
        }
    }
    done.0 = true;
}

/// Shows all things of a block, and from far away its proxy.
fn group(lot: &Lot, meshes: &Assets<Mesh>, mesh: &Handle<Mesh>, Hits(hits): Hits) -> ProxyLod {
    let proxy: Vec<Entity> = lot.proxy.into_iter().collect();
    let group = ProxyLod::new(LodMetric::Distance, lot.things.clone())
        .then(BLOCK, proxy)
        .measured_to(LodReference::Center)
        .hit_as(hits);
    let bounds = meshes.get(mesh).and_then(MeshAabb::compute_aabb);
    bounds.into_iter().fold(group, ProxyLod::with_bounds)
}

/// What is dragged away is not in its block any more: the proxy is made anew without it.
fn leave_block(
    mut commands: Commands,
    mut builder: Builder,
    dragged: Query<(Entity, &Thing), Added<Dragged>>,
    mut lots: Query<(Entity, &Slab, &mut Lot)>,
    others: Query<(Entity, &OtherLevel, &ChildOf)>,
    hits: Option<Res<Hits>>,
) {
    if dragged.is_empty() {
        return;
    }
    let left: HashSet<Entity> = dragged.iter().map(|(entity, _)| entity).collect();
    let blocks: HashSet<u32> = dragged.iter().filter_map(|(_, thing)| thing.block).collect();
    for (slab, _, mut lot) in lots.iter_mut().filter(|(_, slab, _)| blocks.contains(&slab.0)) {
        let before = lot.things.len();
        lot.things.retain(|thing| !left.contains(thing));
        let (true, Some(proxy)) = (lot.things.len() < before, lot.proxy) else {
            continue;
        };
        let mesh = builder.merge(&lot.things);
        if let Some(&hits) = hits.as_deref() {
            commands.entity(slab).insert(group(&lot, &builder.meshes, &mesh, hits));
        }
        commands.entity(proxy).insert(Mesh3d(mesh));
    }
    for (entity, _, of) in others.iter().filter(|(_, level, _)| level.is_coarsest) {
        if let Ok((_, thing)) = dragged.get(of.parent()) {
            commands.entity(entity).insert(range_without_block(thing.model));
        }
    }
}
