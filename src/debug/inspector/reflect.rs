//! Values of any reflected type, edited in place.

use std::{ops::RangeInclusive, time::Duration};

use bevy::{
    color::{Color, ColorToPacked, Srgba},
    ecs::entity::Entity,
    math::{UVec2, Vec2, Vec3},
    reflect::{
        PartialReflect, ReflectMut, ReflectRef, TypeInfo, TypeRegistry,
        enums::{DynamicEnum, DynamicVariant, Enum, VariantInfo, VariantType},
        std_traits::ReflectDefault,
        structs::DynamicStruct,
        tuple::DynamicTuple,
    },
};
use bevy_egui::egui::{Align, ComboBox, DragValue, Label, Layout, Ui, emath::Numeric, vec2};

/// How wide the names of fields are, in points.
const NAME_WIDTH: f32 = 130.0;

/// What is needed beside the value.
#[derive(Clone, Copy)]
pub(super) struct Editor<'a> {
    pub registry: &'a TypeRegistry,
    /// What an optional entity can be set to.
    pub selected: Option<Entity>,
}

impl Editor<'_> {
    /// Shows a value and has it edited; whether it was changed. What cannot be edited is shown as text.
    pub fn edit(self, ui: &mut Ui, value: &mut dyn PartialReflect) -> bool {
        if let Some(has_changed) = self.edit_leaf(ui, value) {
            return has_changed;
        }
        let mut has_changed = false;
        match value.reflect_mut() {
            ReflectMut::Struct(fields) => {
                for index in 0..fields.field_len() {
                    let name = fields.name_at(index).unwrap_or_default().to_owned();
                    if let Some(field) = fields.field_at_mut(index) {
                        has_changed |= self.edit_field(ui, &name, field);
                    }
                }
            }
            ReflectMut::TupleStruct(fields) if fields.field_len() == 1 => {
                has_changed = fields.field_mut(0).is_some_and(|field| self.edit(ui, field));
            }
            ReflectMut::TupleStruct(fields) => {
                for index in 0..fields.field_len() {
                    if let Some(field) = fields.field_mut(index) {
                        has_changed |= self.edit_field(ui, &index.to_string(), field);
                    }
                }
            }
            ReflectMut::List(items) => {
                for index in 0..items.len() {
                    if let Some(item) = items.get_mut(index) {
                        has_changed |= self.edit_field(ui, &index.to_string(), item);
                    }
                }
            }
            ReflectMut::Enum(value) => {
                has_changed |= self.choose_variant(ui, value);
                if value.is_variant(VariantType::Tuple) && value.field_len() == 1 {
                    if let Some(field) = value.field_at_mut(0) {
                        has_changed |= ui.push_id("content", |ui| self.edit(ui, field)).inner;
                    }
                    return has_changed;
                }
                for index in 0..value.field_len() {
                    let name = value.name_at(index).map_or_else(|| index.to_string(), str::to_owned);
                    if let Some(field) = value.field_at_mut(index) {
                        has_changed |= self.edit_field(ui, &name, field);
                    }
                }
            }
            _ => {
                ui.weak(format!("{value:?}"));
            }
        }
        has_changed
    }

    /// A field with its name: in one line if it fits, else below a header.
    fn edit_field(self, ui: &mut Ui, name: &str, value: &mut dyn PartialReflect) -> bool {
        let name = name.replace('_', " ");
        if is_in_one_line(value) {
            let line = ui.horizontal(|ui| {
                name_column(ui, &name);
                ui.push_id(&name, |ui| self.edit(ui, value)).inner
            });
            line.inner
        } else {
            ui.collapsing(name, |ui| self.edit(ui, value)).body_returned == Some(true)
        }
    }

    /// Edits what has no parts; `None` if it is something else.
    fn edit_leaf(self, ui: &mut Ui, value: &mut dyn PartialReflect) -> Option<bool> {
        if let Some(value) = value.try_downcast_mut::<bool>() {
            return Some(ui.checkbox(value, "").changed());
        }
        macro_rules! number {
            ($($number:ty),*) => {
                $(if let Some(value) = value.try_downcast_mut::<$number>() {
                    let speed = (*value as f64).abs().max(1.0) * 0.01;
                    return Some(ui.add(DragValue::new(value).speed(speed)).changed());
                })*
            };
        }
        number!(f32, f64, u8, u16, u32, u64, usize, i8, i16, i32, i64, isize);
        if let Some(value) = value.try_downcast_mut::<String>() {
            return Some(ui.text_edit_singleline(value).changed());
        }
        if let Some(value) = value.try_downcast_mut::<Duration>() {
            let mut seconds = value.as_secs_f64();
            let drag = DragValue::new(&mut seconds).range(0.0..=1e6).speed(0.01).suffix(" s");
            let has_changed = ui.add(drag).changed();
            if has_changed {
                *value = Duration::from_secs_f64(seconds);
            }
            return Some(has_changed);
        }
        if let Some(value) = value.try_downcast_mut::<Color>() {
            let mut color = Srgba::from(*value).to_u8_array();
            let has_changed = ui.color_edit_button_srgba_unmultiplied(&mut color).changed();
            if has_changed {
                *value = Srgba::from_u8_array(color).into();
            }
            return Some(has_changed);
        }
        if let Some(value) = value.try_downcast_mut::<Vec2>() {
            return Some(drag_all(ui, value.as_mut()));
        }
        if let Some(value) = value.try_downcast_mut::<Vec3>() {
            return Some(drag_all(ui, value.as_mut()));
        }
        if let Some(value) = value.try_downcast_mut::<UVec2>() {
            return Some(drag_all(ui, value.as_mut()));
        }
        if let Some(value) = value.try_downcast_mut::<RangeInclusive<usize>>() {
            return Some(edit_range(ui, value));
        }
        if let Some(value) = value.try_downcast_mut::<Option<Entity>>() {
            return Some(self.choose_entity(ui, value));
        }
        if let Some(value) = value.try_downcast_ref::<Entity>() {
            ui.monospace(value.to_string());
            return Some(false);
        }
        None
    }

    fn choose_entity(self, ui: &mut Ui, value: &mut Option<Entity>) -> bool {
        let before = *value;
        let text = |entity: Option<Entity>| entity.map_or("none".to_owned(), |entity| entity.to_string());
        ComboBox::from_id_salt("entity")
            .selected_text(text(before))
            .show_ui(ui, |ui| {
                ui.selectable_value(value, None, "none");
                if let Some(selected) = self.selected {
                    ui.selectable_value(value, Some(selected), format!("{selected}, which is selected"));
                }
            });
        *value != before
    }

    /// Has another variant chosen, with the defaults of what it holds; only those are offered that have defaults.
    fn choose_variant(self, ui: &mut Ui, value: &mut dyn Enum) -> bool {
        let Some(TypeInfo::Enum(info)) = value.get_represented_type_info() else {
            ui.weak(value.variant_name());
            return false;
        };
        let mut chosen = None;
        ComboBox::from_id_salt("variant")
            .selected_text(value.variant_name())
            .show_ui(ui, |ui| {
                for variant in info.iter() {
                    let is_current = variant.name() == value.variant_name();
                    let Some(content) = self.default_of(variant) else {
                        continue;
                    };
                    if ui.selectable_label(is_current, variant.name()).clicked() && !is_current {
                        chosen = Some(DynamicEnum::new(variant.name(), content));
                    }
                }
            });
        chosen.is_some_and(|chosen| value.try_apply(&chosen).is_ok())
    }

    fn default_of(self, variant: &VariantInfo) -> Option<DynamicVariant> {
        let default = |id| {
            Some(
                self.registry
                    .get_type_data::<ReflectDefault>(id)?
                    .default()
                    .into_partial_reflect(),
            )
        };
        Some(match variant {
            VariantInfo::Unit(_) => DynamicVariant::Unit,
            VariantInfo::Tuple(fields) => {
                let mut content = DynamicTuple::default();
                for field in fields.iter() {
                    content.insert_boxed(default(field.type_id())?);
                }
                DynamicVariant::Tuple(content)
            }
            VariantInfo::Struct(fields) => {
                let mut content = DynamicStruct::default();
                for field in fields.iter() {
                    content.insert_boxed(field.name(), default(field.type_id())?);
                }
                DynamicVariant::Struct(content)
            }
        })
    }
}

/// A name with the width that all names have, so that values are below one another.
fn name_column(ui: &mut Ui, name: &str) {
    let size = vec2(NAME_WIDTH, ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
        ui.set_min_width(NAME_WIDTH);
        ui.add(Label::new(name).truncate());
    });
}

/// Whether a value has no parts below it.
fn is_in_one_line(value: &dyn PartialReflect) -> bool {
    match value.reflect_ref() {
        ReflectRef::Opaque(_) => true,
        ReflectRef::TupleStruct(value) => value.field_len() == 1 && value.iter_fields().all(is_in_one_line),
        ReflectRef::Enum(value) => {
            value.field_len() == 0 || value.iter_fields().all(|field| is_in_one_line(field.value()))
        }
        ReflectRef::Struct(_) => {
            value.represents::<Vec2>() || value.represents::<Vec3>() || value.represents::<UVec2>()
        }
        _ => false,
    }
}

fn drag_all<T: Numeric>(ui: &mut Ui, values: &mut [T]) -> bool {
    values.iter_mut().fold(false, |has_changed, value| {
        let speed = value.to_f64().abs().max(1.0) * 0.01;
        ui.add(DragValue::new(value).speed(speed)).changed() | has_changed
    })
}

/// The end may be without limit, which is shown as one beyond the greatest that can be chosen.
fn edit_range(ui: &mut Ui, range: &mut RangeInclusive<usize>) -> bool {
    const MOST: usize = 64;
    let (mut start, mut end) = (*range.start(), (*range.end()).min(MOST));
    let mut has_changed = ui.add(DragValue::new(&mut start).range(0..=MOST).speed(0.1)).changed();
    ui.label("to");
    let text = |end: f64, _| {
        if end as usize >= MOST {
            "all".to_owned()
        } else {
            end.to_string()
        }
    };
    let drag = DragValue::new(&mut end)
        .range(0..=MOST)
        .speed(0.1)
        .custom_formatter(text);
    has_changed |= ui.add(drag).changed();
    if has_changed {
        *range = start..=if end >= MOST { usize::MAX } else { end };
    }
    has_changed
}
