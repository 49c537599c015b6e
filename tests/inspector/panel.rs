//! A panel without a window: what is written on it, and how it is clicked.

use bevy::{camera::CameraProjection, prelude::*};
use bevy_sightline::{
    debug::inspector::{
        egui::{Context, Event, Modifiers, PointerButton, Pos2, RawInput, Rect, Shape, pos2, vec2},
        inspector_ui,
    },
    prelude::*,
};

use crate::common::headless_app_with;

/// An app with a panel.
pub struct Panel {
    pub app: App,
    context: Context,
    texts: Vec<(String, Pos2)>,
}

impl Panel {
    /// A headless app with the inspector open at a tab, and an empty panel.
    pub fn new(tab: InspectorTab) -> Self {
        let mut app = headless_app_with(|app| {
            app.add_plugins(SightlineInspectorPlugin);
        });
        let mut inspector = app.world_mut().resource_mut::<SightlineInspector>();
        inspector.open = true;
        inspector.tab = tab;
        let context = Context::default();
        // What is opened is open at once.
        context.all_styles_mut(|style| style.animation_time = 0.0);
        Self {
            app,
            context,
            texts: Vec::new(),
        }
    }

    pub fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// A camera that looks from `eye` along -z.
    pub fn spawn_camera(&mut self, name: &'static str, eye: Vec3) -> Entity {
        let projection = PerspectiveProjection::default();
        let eye = Transform::from_translation(eye);
        let frustum = projection.compute_frustum(&eye.into());
        let camera = (
            Camera3d::default(),
            Projection::from(projection),
            eye,
            frustum,
            Name::new(name),
        );
        self.world().spawn(camera).id()
    }

    pub fn inspector(&mut self) -> SightlineInspector {
        *self.world().resource::<SightlineInspector>()
    }

    /// A frame of the app, and then of the panel.
    pub fn update(&mut self) {
        self.app.update();
        self.show(Vec::new());
    }

    /// A frame of the panel alone.
    pub fn look(&mut self) {
        self.show(Vec::new());
    }

    fn show(&mut self, events: Vec<Event>) {
        let input = RawInput {
            // High enough for everything to be on it.
            screen_rect: Some(Rect::from_min_max(pos2(0.0, 0.0), pos2(700.0, 4000.0))),
            events,
            ..RawInput::default()
        };
        let world = self.app.world_mut();
        let mut output = self.context.run_ui(input, |ui| inspector_ui(ui, world));
        // Nothing is drawn with them.
        output.textures_delta.clear();
        self.texts.clear();
        for clipped in output.shapes {
            collect(&clipped.shape, &mut self.texts);
        }
    }

    /// Whether this is written somewhere, as a part of some text.
    pub fn says(&self, text: &str) -> bool {
        self.texts.iter().any(|(written, _)| written.contains(text))
    }

    /// What is written to the right of this text, in its line.
    pub fn beside(&self, text: &str) -> Option<&str> {
        let (_, at) = self.texts.iter().find(|(written, _)| written == text)?;
        let in_line = self
            .texts
            .iter()
            .filter(|(_, other)| (other.y - at.y).abs() < 8.0 && other.x > at.x);
        let next = in_line.min_by(|(_, a), (_, b)| a.x.total_cmp(&b.x));
        next.map(|(written, _)| written.trim())
    }

    /// The same of a text that is a part of what is written.
    pub fn beside_containing(&self, text: &str) -> Option<&str> {
        let whole = self.texts.iter().find(|(written, _)| written.contains(text))?;
        self.beside(&whole.0)
    }

    /// Clicks on a text, a little to the right of its beginning.
    pub fn click(&mut self, text: &str) {
        self.click_beside(text, 6.0);
    }

    /// Clicks so far to the right of the beginning of a text.
    pub fn click_beside(&mut self, text: &str, points: f32) {
        let exactly = self.texts.iter().find(|(written, _)| written == text);
        let found = exactly.or_else(|| self.texts.iter().find(|(written, _)| written.contains(text)));
        let (_, at) = found.unwrap_or_else(|| panic!("nothing says {text:?}: {:?}", self.texts));
        self.click_at(*at + vec2(points, 6.0));
    }

    fn click_at(&mut self, position: Pos2) {
        let button = |pressed| Event::PointerButton {
            pos: position,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        self.show(vec![Event::PointerMoved(position)]);
        self.show(vec![button(true)]);
        self.show(vec![button(false)]);
        // What was clicked is shown by the next frame.
        self.show(Vec::new());
    }
}

fn collect(shape: &Shape, texts: &mut Vec<(String, Pos2)>) {
    match shape {
        Shape::Text(text) => texts.push((text.galley.text().to_owned(), text.pos)),
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect(shape, texts)),
        _ => {}
    }
}
