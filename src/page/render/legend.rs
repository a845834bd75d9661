//! The strip below a picture: its title, and the meaning of its colours.

use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::iso_8859_1::FONT_7X13 as FONT;
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::{Circle, PrimitiveStyle, Rectangle};
use embedded_graphics::text::{Baseline, Text};

use super::canvas::Canvas;
use super::colour::{Entry, SENSOR, ramp};
use perirobot_decide::view::View;
use perirobot_study::input::Member;
use perirobot_study::world::World;
use perirobot_sweep::results::columns::{pose_names, representation_names};

const EDGE_PX: u32 = 8;
const LINE_PX: u32 = 18;
const PATCH_PX: u32 = 13;
const RAMP_PX: u32 = 120;
const GAP_PX: u32 = 16;
/// The size of letters.
pub(super) const FONT_WIDTH_PX: u32 = FONT.character_size.width;
pub(super) const FONT_HEIGHT_PX: u32 = FONT.character_size.height;
/// The colour of words.
pub(super) const INK: [u8; 3] = [30; 3];

/// A legend with its layout.
pub(super) struct Legend {
    title: String,
    /// Each entry with its place: pixels from the left, and its line.
    entries: Vec<(Entry, [u32; 2])>,
    lines: u32,
}

/// The title of a picture, in one line.
pub(super) fn title(world: &World, view: Option<&View>) -> String {
    let Some(View { study, choice, .. }) = view else {
        return world.name.clone();
    };
    let combination = &study.combinations[choice.combination];
    let representation = representation_names(study, combination).swap_remove(choice.representation);
    format!(
        "{}   {}   {representation}   voxels of {} m",
        world.title(study),
        pose_names(study, combination, choice.choice),
        study.voxel_size_m
    )
}

/// The sensors of a view that say the same at this moment whoever is there, and what.
pub(super) fn stuck_sensors(view: &View) -> Vec<String> {
    let View { study, world, choice, .. } = view;
    let combination = &study.combinations[choice.combination];
    let members = combination.members.iter().zip(combination.choice(choice.choice));
    let note = |(member, candidate): (&Member, usize)| {
        let sensor = &study.sensors[member.sensor];
        let says = world.stuck_at(study, [member.sensor, candidate])?;
        Some(format!("{}:{} is {says}", sensor.name, sensor.candidates[candidate].name))
    };
    members.filter_map(note).collect()
}

fn width_px(text: &str) -> u32 {
    text.chars().count() as u32 * FONT.character_size.width
}

impl Entry {
    fn width_px(&self) -> u32 {
        match self {
            Entry::Patch(_, text) | Entry::Dot(_, text) | Entry::Sensor(text) => {
                PATCH_PX + 5 + width_px(text)
            }
            Entry::Ramp(low, high) => width_px(low) + RAMP_PX + 10 + width_px(high),
            Entry::Note(text) => width_px(text),
        }
    }
}

impl Legend {
    /// Lays entries out from left to right in the lines that a picture of this width needs.
    pub(super) fn new(title: String, entries: Vec<Entry>, width: u32) -> Legend {
        let (mut x, mut line) = (EDGE_PX, 1);
        let mut placed = Vec::new();
        for entry in entries {
            let needs = entry.width_px();
            if x > EDGE_PX && x + needs + EDGE_PX > width {
                (x, line) = (EDGE_PX, line + 1);
            }
            placed.push((entry, [x, line]));
            x += needs + GAP_PX;
        }
        let most = (width.saturating_sub(2 * EDGE_PX) / FONT.character_size.width) as usize;
        let title = match title.chars().count() > most {
            true => title.chars().take(most.saturating_sub(3)).chain("...".chars()).collect(),
            false => title,
        };
        Legend { title, entries: placed, lines: line + 1 }
    }

    pub(super) fn height_px(&self) -> u32 {
        self.lines * LINE_PX + EDGE_PX
    }

    /// Draws it below the first `top` rows.
    pub(super) fn draw(&self, canvas: &mut Canvas, top: u32) {
        let place = |x: u32, line: u32| Point::new(x as i32, (top + EDGE_PX / 2 + line * LINE_PX) as i32);
        write(canvas, &self.title, place(EDGE_PX, 0));
        for (entry, [x, line]) in &self.entries {
            let at = place(*x, *line);
            let square = Rectangle::new(at, Size::new_equal(PATCH_PX));
            let beside = at + Point::new(PATCH_PX as i32 + 5, 0);
            let text = match entry {
                Entry::Patch(colour, text) => {
                    fill(canvas, &square, *colour);
                    text
                }
                Entry::Dot(colour, text) => {
                    disc(canvas, Circle::with_center(square.center(), 4), *colour);
                    text
                }
                Entry::Sensor(text) => {
                    disc(canvas, Circle::with_center(square.center(), 9), SENSOR);
                    text
                }
                Entry::Note(text) => {
                    write(canvas, text, at);
                    continue;
                }
                Entry::Ramp(low, high) => {
                    let begin = at + Point::new(width_px(low) as i32 + 5, 0);
                    for i in 0..RAMP_PX {
                        let bar = Rectangle::new(begin + Point::new(i as i32, 0), Size::new(1, PATCH_PX));
                        fill(canvas, &bar, ramp(i * 1024 / (RAMP_PX - 1)));
                    }
                    write(canvas, high, begin + Point::new(RAMP_PX as i32 + 5, 0));
                    write(canvas, low, at);
                    continue;
                }
            };
            write(canvas, text, beside);
        }
    }
}

fn write(canvas: &mut Canvas, text: &str, at: Point) {
    write_in(canvas, text, at, INK);
}

/// Writes words with a halo, so that they stand out.
pub(super) fn write_haloed(canvas: &mut Canvas, text: &str, at: Point) {
    for beside in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, 1), (-1, 1), (1, -1)] {
        write_in(canvas, text, at + Point::from(beside), [255; 3]);
    }
    write(canvas, text, at);
}

fn write_in(canvas: &mut Canvas, text: &str, at: Point, [r, g, b]: [u8; 3]) {
    let style = MonoTextStyle::new(&FONT, Rgb888::new(r, g, b));
    let Ok(_) = Text::with_baseline(text, at, style, Baseline::Top).draw(canvas);
}

pub(super) fn fill(canvas: &mut Canvas, area: &Rectangle, [r, g, b]: [u8; 3]) {
    let Ok(()) = canvas.fill_solid(area, Rgb888::new(r, g, b));
}

fn disc(canvas: &mut Canvas, circle: Circle, [r, g, b]: [u8; 3]) {
    let style = PrimitiveStyle::with_fill(Rgb888::new(r, g, b));
    let Ok(()) = circle.into_styled(style).draw(canvas);
}
