//! Sprites with holes, one upon another: the one under the mouse lights up, and a click tells its pixel.
//!
//! ```sh
//! cargo run --example sprite_picking --features sprite
//! ```
//!
//! What to look for: through the hole of a ring, and past the corners of a disc, the mouse reaches what is behind. Rings
//! turn, and are hit where they are drawn; the frame is cut into nine slices, and its middle is open. A click on a sprite
//! prints its name and the pixel of its image, and `R` lets rectangles count instead of pixels. Without a display a
//! synthetic pointer clicks on a ring, and through its hole.

#[path = "shared/panel.rs"]
mod panel;
#[path = "shared/pointer.rs"]
mod pointer;
#[allow(dead_code, reason = "there are no models to load")]
mod shared;

use bevy::{
    asset::RenderAssetUsages,
    image::ToExtents,
    prelude::*,
    render::render_resource::{TextureDimension, TextureFormat},
    sprite::{BorderRect, SpriteImageMode, TextureSlicer},
};
use bevy_sightline::prelude::*;

/// The side of the images, in pixels.
const SIDE: u32 = 128;

fn main() -> AppExit {
    let headless = !shared::has_display();
    let mut app = App::new();
    app.add_plugins((shared::plugins("sprite picking", headless), SightlinePlugins))
        .insert_resource(ClearColor(Color::srgb(0.09, 0.1, 0.13)))
        .init_resource::<Clicked>()
        .add_systems(Startup, setup)
        .add_systems(Update, (turn, choose_test, tell));
    if !headless {
        return app.run();
    }
    app.finish();
    app.cleanup();
    app.update();
    app.update();
    // The rim of the ring in the middle, and its hole.
    for (place, name) in [
        (Vec2::new(0.5, 0.5 - 105.0 / 720.0), "ring"),
        (Vec2::splat(0.5), "disc"),
    ] {
        pointer::play(&mut app, pointer::click(place));
        let clicked = app.world().resource::<Clicked>();
        assert!(clicked.0.starts_with(name), "{name}, not {}", clicked.0);
    }
    AppExit::Success
}

/// What was clicked last.
#[derive(Resource, Default)]
struct Clicked(String);

/// The text in the corner.
#[derive(Component)]
struct Told;

/// How fast a sprite turns, in radians per second.
#[derive(Component)]
struct Turning(f32);

/// The colour of a sprite when the mouse is elsewhere.
#[derive(Component)]
struct Paint(Color);

fn setup(mut commands: Commands, mut images: ResMut<Assets<Image>>) {
    commands.spawn(Camera2d);
    commands.spawn(panel::panel(Told, ""));
    let disc = images.add(draw(|r| r < 1.0));
    let ring = images.add(draw(|r| (0.62..1.0).contains(&r)));
    let frame = images.add(draw_frame());

    let sprite = |image: &Handle<Image>, side: f32| Sprite {
        image: image.clone(),
        custom_size: Some(Vec2::splat(side)),
        ..default()
    };
    let frame = Sprite {
        custom_size: Some(Vec2::new(1100.0, 560.0)),
        image_mode: SpriteImageMode::Sliced(TextureSlicer {
            border: BorderRect::all(24.0),
            ..default()
        }),
        ..sprite(&frame, 0.0)
    };
    let mut things = vec![("frame", frame, Transform::from_xyz(0.0, 0.0, 9.0), 0.35, 0.0)];
    for (i, x) in [-330.0, 0.0, 330.0].into_iter().enumerate() {
        let place = Transform::from_xyz(x, 0.0, 1.0);
        // Ellipses, and one that is mirrored, are no different.
        let stretch = [Vec3::new(1.3, 0.9, 1.0), Vec3::ONE, Vec3::new(-0.9, 1.2, 1.0)][i];
        let hue = 0.12 + 0.3 * i as f32;
        things.push((
            "ring",
            sprite(&ring, 260.0),
            place.with_scale(stretch),
            hue,
            0.6 * (i as f32 - 1.0),
        ));
        things.push((
            "disc",
            sprite(&disc, 150.0),
            Transform::from_xyz(x + 20.0, -15.0, 0.0),
            hue + 0.12,
            0.0,
        ));
        things.push((
            "disc",
            sprite(&disc, 120.0),
            Transform::from_xyz(x + 165.0, 60.0, 2.0),
            hue + 0.2,
            0.0,
        ));
    }
    for (name, sprite, place, hue, speed) in things {
        let color = Color::hsl(360.0 * hue, 0.55, 0.5);
        commands
            .spawn((
                Name::new(name),
                Sprite { color, ..sprite },
                place,
                Paint(color),
                Turning(speed),
            ))
            .observe(light_up)
            .observe(dim)
            .observe(note);
    }
}

/// A white image that is opaque where `is_inside` says so of the distance from the middle: 1 at the sides.
fn draw(is_inside: impl Fn(f32) -> bool) -> Image {
    let middle = Vec2::splat(SIDE as f32 / 2.0);
    paint(|pixel| is_inside((pixel.as_vec2() + 0.5).distance(middle) / middle.x))
}

/// A frame of 12 pixels with its corners cut off.
fn draw_frame() -> Image {
    paint(|pixel| {
        let from_side = pixel.min(SIDE - 1 - pixel);
        from_side.min_element() < 12 && from_side.element_sum() > 8
    })
}

fn paint(is_opaque: impl Fn(UVec2) -> bool) -> Image {
    let size = UVec2::splat(SIDE);
    let pixels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| UVec2::new(x, y)));
    let data = pixels.flat_map(|pixel| [255, 255, 255, if is_opaque(pixel) { 255 } else { 0 }]);
    // The holes are read when the first sprite needs them; after that the renderer may have the pixels for itself.
    Image::new(
        size.to_extents(),
        TextureDimension::D2,
        data.collect(),
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    )
}

fn turn(time: Res<Time>, mut turning: Query<(&Turning, &mut Transform)>) {
    for (Turning(speed), mut place) in turning.iter_mut().filter(|(turning, _)| turning.0 != 0.0) {
        place.rotate_z(speed * time.delta_secs());
    }
}

fn light_up(over: On<Pointer<Over>>, mut sprites: Query<&mut Sprite>) -> Result {
    sprites.get_mut(over.entity)?.color = Color::WHITE;
    Ok(())
}

fn dim(out: On<Pointer<Out>>, mut sprites: Query<(&mut Sprite, &Paint)>) -> Result {
    let (mut sprite, paint) = sprites.get_mut(out.entity)?;
    sprite.color = paint.0;
    Ok(())
}

fn note(
    click: On<Pointer<Click>>,
    sprites: Query<(&Name, &Sprite)>,
    images: Res<Assets<Image>>,
    mut clicked: ResMut<Clicked>,
) -> Result {
    let (name, sprite) = sprites.get(click.entity)?;
    let size = images
        .get(&sprite.image)
        .ok_or("a sprite that was hit has an image")?
        .size_f32();
    let uv = click.hit.extra_as::<RayHit>().and_then(|hit| hit.uv);
    let pixel = uv.ok_or("a click by another backend")? * size;
    clicked.0 = format!("{name}, pixel {} {}", pixel.x as u32, pixel.y as u32);
    println!("{}", clicked.0);
    Ok(())
}

fn choose_test(keys: Res<ButtonInput<KeyCode>>, mut settings: ResMut<SpriteIndexSettings>) {
    if keys.just_pressed(KeyCode::KeyR) {
        settings.alpha_test = match settings.alpha_test {
            AlphaTest::Off => AlphaTest::default(),
            AlphaTest::Above(_) => AlphaTest::Off,
        };
    }
}

fn tell(clicked: Res<Clicked>, settings: Res<SpriteIndexSettings>, mut told: Single<&mut Text, With<Told>>) {
    if clicked.is_changed() || settings.is_changed() {
        let counts = match settings.alpha_test {
            AlphaTest::Off => "rectangles",
            AlphaTest::Above(_) => "pixels",
        };
        told.0 = format!("Clicked: {}\nR: {counts} count", clicked.0);
    }
}
