//! Additions to a picture from straight above: names of furniture, robots and people, axes in metres, and a scale bar.
//! Lengths are true at the height of the floor; higher objects look larger.

use embedded_graphics::prelude::*;
use embedded_graphics::primitives::Rectangle;
use glam::DVec3;

use super::FINE;
use super::canvas::Canvas;
use super::eye::PictureCamera;
use super::legend::{FONT_HEIGHT_PX, FONT_WIDTH_PX, INK, fill, write_haloed};
use super::plan::labels::PlacedLabels;
use super::plan::named_things;
use super::scale::{marks, ruler, step};
use perirobot_study::world::World;
use perirobot_study::world::place::room_m;

/// Least distance between two numbers of an axis.
const APART_PX: f64 = 40.0;
/// From the edge of the picture to its numbers, and the length of a tick.
const MARK_PX: i32 = 5;

/// Draws them over the first `height` rows; nothing above `top_m` is labelled.
pub(super) fn draw(
    canvas: &mut Canvas,
    world: &World,
    camera: &PictureCamera,
    height: u32,
    top_m: Option<f64>,
) {
    let truth = world.truth();
    let [low, high] = room_m(&truth);
    let floor = world.floor.z_m;
    let width = canvas.size_px()[0];
    let place = |at: DVec3| {
        let ([x, y], _) = camera.project(at)?;
        Some([x / f64::from(FINE), y / f64::from(FINE)])
    };
    let (Some([left, bottom]), Some([right, _])) = (place(low.with_z(floor)), place(high.with_z(floor)))
    else {
        return;
    };
    let scale = (right - left) / (high.x - low.x);
    let every = step(((high - low).truncate().max_element() / 8.0).max(APART_PX / scale));
    let (line, letter) = (FONT_HEIGHT_PX as i32, f64::from(FONT_WIDTH_PX));
    let (foot, edge) = (height as i32, width as i32);
    for (metres, text) in marks(low.x, high.x, every) {
        let x = (left + (metres - low.x) * scale).round() as i32;
        fill(canvas, &Rectangle::new(Point::new(x, foot - MARK_PX), Size::new(1, MARK_PX as u32)), INK);
        let half = (text.len() as f64 * letter / 2.0) as i32;
        write_haloed(canvas, &text, Point::new(x - half, foot - MARK_PX - line));
    }
    for (metres, text) in marks(low.y, high.y, every) {
        let y = (bottom - (metres - low.y) * scale).round() as i32;
        fill(canvas, &Rectangle::new(Point::new(0, y), Size::new(MARK_PX as u32, 1)), INK);
        write_haloed(canvas, &text, Point::new(2 * MARK_PX, y - line / 2));
    }
    write_haloed(
        canvas,
        "x and y in metres, at the floor",
        Point::new(2 * MARK_PX, foot - MARK_PX - 2 * line),
    );
    let length = ruler(high.x - low.x);
    let bar = (length * scale).round() as i32;
    let at = Point::new(edge - 2 * MARK_PX - bar, foot - MARK_PX - 2 * line + line / 2);
    fill(canvas, &Rectangle::new(at, Size::new(bar as u32, 2)), INK);
    for end in [at.x, at.x + bar - 1] {
        fill(canvas, &Rectangle::new(Point::new(end, at.y - 3), Size::new(1, 8)), INK);
    }
    let text = format!("{length} m");
    let before = (text.len() as f64 * letter) as i32 + MARK_PX;
    write_haloed(canvas, &text, Point::new(at.x - before, at.y - line / 2));
    let free = f64::from(foot - MARK_PX - 2 * line);
    let mut labels = PlacedLabels::new([0.0, 0.0, f64::from(width), free]);
    for thing in named_things(world) {
        let z = top_m.map_or(thing.high_m.z, |top| thing.high_m.z.min(top));
        let (Some(a), Some(b)) = (place(thing.low_m.with_z(z)), place(thing.high_m.with_z(z))) else {
            continue;
        };
        let area = [a[0], b[1], b[0], a[1]];
        let size = f64::from(FONT_HEIGHT_PX);
        if let Some([x, y]) = labels.place(&thing.name, size, area) {
            let half = (thing.name.chars().count() as f64 * letter / 2.0) as i32;
            write_haloed(canvas, &thing.name, Point::new(x as i32 - half, y as i32 - line / 2));
        }
    }
}
