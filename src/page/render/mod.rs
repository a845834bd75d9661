//! Draws a cell and the labels of a choice of poses in it. Each pixel is a few rays of a camera, cast by the same
//! backend that scores.
//!
//! # Practice
//! The voxel at the end of a ray is the same on every backend, and colours are computed on the host, so the CPU and any
//! GPU draw the same bytes.

mod above;
mod canvas;
mod cast;
mod colour;
mod cut;
mod eye;
mod legend;
mod overlay;
pub mod plan;
pub(crate) mod scale;
pub mod svg;

pub use canvas::Canvas;
pub use colour::Colour;
pub(crate) use colour::Palette;
#[cfg(feature = "report")]
pub(crate) use colour::ramp;
pub use eye::{Eye, point};
use perirobot_decide::approach::Way;
use perirobot_decide::view::{Verdict, View};
use perirobot_march::backend::Backend;
use perirobot_march::error::{Argument, Issue, Site, Words};
use perirobot_march::voxel::BitGrid;
use perirobot_march::{Error, Result};
use perirobot_study::world::World;

use cast::Hit;
use cut::Cut;
use eye::PictureCamera;
use glam::DVec3;

/// Rays along each side of a pixel.
const FINE: u32 = 2;

/// Least and most pixels on a side.
pub const SIDES_PX: std::ops::RangeInclusive<u32> = 64..=4096;

/// Full horizontal angles of view, in degrees.
pub const ANGLES_DEG: std::ops::RangeInclusive<f64> = 1.0..=150.0;

/// The properties of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Wish {
    /// The viewpoint.
    pub eye: Eye,
    /// The point in the middle of the picture, in world metres; by default the middle of the cell.
    pub look_at_m: Option<DVec3>,
    /// Full horizontal angle of view in radians.
    pub fov_rad: f64,
    /// Width and height in pixels, including the legend.
    pub size_px: [u32; 2],
    /// The meaning of the colours.
    pub colour: Colour,
    /// Only the voxels of this region are drawn.
    pub only_region: Option<usize>,
    /// Nothing is drawn above this height in the world.
    pub cut_above_m: Option<f64>,
    /// Thickness of the removed sides of the cell between it and the eye.
    pub open_m: f64,
    /// About this many returns of each sensor are drawn as dots, or all.
    pub points: usize,
    /// Ways of bodies to draw, visible through everything.
    pub ways: Vec<Way>,
    /// What is not as planned, for the legend; empty if all is.
    pub case: String,
}

impl Default for Wish {
    /// The default of `render`: the whole cell from a corner, by role, without the walls in front.
    fn default() -> Wish {
        Wish {
            eye: Eye::ISO,
            look_at_m: None,
            fov_rad: 45f64.to_radians(),
            size_px: [960, 600],
            colour: Colour::Role,
            only_region: None,
            cut_above_m: None,
            open_m: 0.1,
            points: 3000,
            ways: Vec::new(),
            case: String::new(),
        }
    }
}

impl Wish {
    /// Checks the numbers of a picture.
    ///
    /// # Errors
    /// The first argument that is wrong.
    pub fn check(&self) -> Result<()> {
        let wrong = |name: &'static str, value: String, rule: String| {
            Err(Error::input(Site::Argument(Argument(name), value), rule))
        };
        let fov_deg = self.fov_rad.to_degrees();
        // Radians are rounded.
        let rounded_deg = (fov_deg * 1e9).round() / 1e9;
        if !ANGLES_DEG.contains(&rounded_deg) {
            return wrong("fov deg", rounded_deg.to_string(), "must be from 1 to 150".into());
        }
        if !(0.0..=100.0).contains(&self.open_m) {
            return wrong("open", self.open_m.to_string(), "must be from 0 to 100 metres".into());
        }
        if let Some(height) = self.cut_above_m.filter(|height| !(-1e4..=1e4).contains(height)) {
            return wrong("cut above", height.to_string(), "must be from -10000 to 10000 metres".into());
        }
        if !self.size_px.iter().all(|side| SIDES_PX.contains(side)) {
            let [width, height] = self.size_px;
            let (least, most) = (SIDES_PX.start(), SIDES_PX.end());
            let rule = format!("must be from {least} to {most} pixels, in width and in height");
            return wrong("size", format!("{width} x {height}"), rule);
        }
        Ok(())
    }
}

/// Draws a cell, or a view of it. The backend unloads its previous scene.
///
/// # Errors
/// If the picture is impossible, with a remedy, and those of the backend.
pub fn draw(world: &World, view: Option<&View>, wish: &Wish, backend: &mut dyn Backend) -> Result<Canvas> {
    let palette = colour::Palette::new(world, view, wish.colour)?;
    let whole = Cut { open_m: 0.0, ..Cut::new(wish) }.solid(world, DVec3::ZERO);
    if whole.is_empty() {
        let both =
            Words::from(Argument("only region")) + " and " + Argument("cut above") + " leave nothing to draw";
        return Err(Issue::says(both).with_advice("widen them").into());
    }
    let haze = view
        .filter(|_| wish.colour == Colour::Label)
        .map(|view| Cut::new(wish).plane(world, false_volumes(view)));
    let haze = haze.filter(|haze| !haze.is_empty());
    let mut entries = palette.entries(&whole, haze.is_some(), view.filter(|_| wish.points > 0));
    let stuck = view.map_or(Vec::new(), legend::stuck_sensors);
    let case = Some(&wish.case).filter(|case| !case.is_empty());
    entries.extend(stuck.iter().chain(case).cloned().map(colour::Entry::Note));
    entries.extend(wish.ways.iter().map(|way| colour::Entry::Patch(colour::WAY, way.words())));
    let legend = legend::Legend::new(legend::title(world, view), entries, wish.size_px[0]);
    let height = wish.size_px[1].saturating_sub(legend.height_px());
    if height < 32 {
        let least = legend.height_px() + 32;
        let rule = format!("at least {least} pixels high");
        return Err(Error::input(Argument("size"), "the legend leaves no room").with_advice(rule));
    }
    let size = [wish.size_px[0] * FINE, height * FINE];
    let camera = PictureCamera::new(wish, size, &world.grid, &whole)?;
    let solid = Cut::new(wish).solid(world, camera.eye_m);
    let mut samples = paint(world, &palette, &solid, haze.as_ref(), &camera, backend)?;
    if let Some(view) = view {
        let dots = Cut::new(wish).dots(world, camera.eye_m);
        overlay::points(&mut samples, view, wish.points, &dots, &camera);
        overlay::sensors(&mut samples, view, &camera);
    }
    overlay::ways(&mut samples, &wish.ways, &camera);
    let mut canvas = Canvas::white(wish.size_px);
    canvas.paste(&samples.colours, size, FINE);
    if wish.eye.is_above() {
        above::draw(&mut canvas, world, &camera, height, wish.cut_above_m);
    }
    legend.draw(&mut canvas, height);
    Ok(canvas)
}

/// Free space labelled occupied without a ray's return: volumes around detections, zones. Returns displaced by noise
/// are dots.
fn false_volumes(view: &View) -> BitGrid {
    let mut voxels = view.voxels(Verdict::Fp);
    let cast = view.members.iter().filter_map(|member| member.cast.as_ref());
    cast.for_each(|cast| voxels.remove(&cast.planes.occupied));
    voxels
}

/// The rays of a picture, row by row.
struct Samples {
    colours: Vec<[u8; 3]>,
    /// The distance of each hit, in 1/65536 voxels.
    depths_q16: Vec<u32>,
}

fn paint(
    world: &World,
    palette: &colour::Palette,
    solid: &BitGrid,
    haze: Option<&BitGrid>,
    camera: &PictureCamera,
    backend: &mut dyn Backend,
) -> Result<Samples> {
    let grid = &world.grid;
    let hits = cast::cast(solid, grid, camera, backend)?;
    let mut colours: Vec<[u8; 3]> = hits
        .iter()
        .map(|hit| hit.map_or(colour::SKY, |hit| colour::shade(palette.colour(hit.voxel), &hit, solid)))
        .collect();
    let far = |hit: &Option<Hit>| hit.map_or(u32::MAX, |hit| hit.distance_q16);
    if let Some(haze) = haze {
        let before = cast::cast(haze, grid, camera, backend)?;
        for ((colour, hit), before) in colours.iter_mut().zip(&hits).zip(&before) {
            if let Some(veil) = before.filter(|veil| veil.distance_q16 < far(hit)) {
                *colour = colour::veil(*colour, &veil, haze);
            }
        }
    }
    Ok(Samples { colours, depths_q16: hits.iter().map(far).collect() })
}

#[cfg(test)]
mod tests;
