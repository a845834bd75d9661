//! A point cloud, carved from where its sensor was.
//!
//! # Theory
//! A point is a return. Its voxel is occupied, and the voxels before it on the ray from the sensor are free. Sensor
//! and point are rounded to 1/65536 voxel of the grid; the ray's direction is that from one to the other, a unit
//! vector in Q16, and from there on it marches as all rays do (`march`): until it comes to the point's voxel, or to
//! the point's distance. Of a ray whose sensor is outside the grid only the part inside is followed, from where it
//! enters. A point outside the grid marks nothing, and its ray frees what it passed inside.
//!
//! Nothing is carved where no point is: a cloud does not tell which rays came to nothing.

use std::collections::BTreeSet;

use glam::DVec3;

use super::Anchor;
use perirobot_march::backend::Planes;
use perirobot_march::error::Issue;
use perirobot_march::march;
use perirobot_march::voxel::Grid;

/// Most points of a file: 2.4 GB.
const MOST_POINTS: usize = 100_000_000;

/// Refuses more points than are read.
pub(super) fn check_count(points: usize) -> Result<(), Issue> {
    match points > MOST_POINTS {
        true => Err(Issue::too_large(format!("has {points} points"))
            .with_advice(format!("at most {MOST_POINTS} are read"))),
        false => Ok(()),
    }
}

/// Points that a sensor measured from one place, in metres of the recording's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud {
    /// Where the sensor was.
    pub(super) sensor_m: DVec3,
    /// All finite.
    pub(super) points_m: Vec<DVec3>,
    /// Entries of the file without a point: NaN or infinite, as drivers write for pixels without a return.
    pub(super) without_point: usize,
}

impl Cloud {
    /// The finite ones of some points.
    ///
    /// # Errors
    /// When there is none.
    pub(super) fn new(sensor_m: DVec3, mut points_m: Vec<DVec3>) -> Result<Cloud, Issue> {
        let entries = points_m.len();
        points_m.retain(|point| point.is_finite());
        match points_m.is_empty() {
            true => Err(Issue::says(format!("has no point (of {entries} entries)"))),
            false => Ok(Cloud { sensor_m, without_point: entries - points_m.len(), points_m }),
        }
    }

    /// The same, measured from where a user says the sensor was, if one does.
    pub(super) fn seen_from(self, sensor_m: Option<DVec3>) -> Cloud {
        Cloud { sensor_m: sensor_m.unwrap_or(self.sensor_m), ..self }
    }

    pub(super) fn bounds_m(&self) -> [DVec3; 2] {
        let all = || self.points_m.iter().copied();
        let [low, high] = [all().reduce(DVec3::min), all().reduce(DVec3::max)];
        [low.unwrap_or(self.sensor_m), high.unwrap_or(self.sensor_m)]
    }

    /// Adds what it says to planes over a grid; no hits.
    pub(super) fn carve_in(&self, anchor: &Anchor, grid: &Grid, planes: &mut Planes) {
        let sensor = anchor.world(self.sensor_m);
        for point in self.points_m.iter().map(|point| anchor.world(*point)) {
            if let Some(begin_q16) = enters(sensor, point, grid) {
                carve(begin_q16, point, grid, planes);
            }
        }
    }
}

/// What some clouds are, for people.
pub(super) fn describe(clouds: &[Cloud]) -> String {
    let sum = |count: fn(&Cloud) -> usize| clouds.iter().map(count).sum::<usize>();
    let places = clouds.iter().map(|cloud| cloud.sensor_m.to_array().map(|x| format!("{x:.3}")).join(", "));
    let places: BTreeSet<String> = places.collect();
    let places = match (places.len(), places.first()) {
        (1, Some(place)) => format!("{place} m"),
        (several, _) => format!("{several} places"),
    };
    let of_clouds = if clouds.len() > 1 { format!(" of {} clouds", clouds.len()) } else { String::new() };
    let without = match sum(|cloud| cloud.without_point) {
        0 => String::new(),
        count => format!(" ({count} entries without a point are passed over)"),
    };
    format!("{} points{of_clouds}{without} measured from {places}", sum(|cloud| cloud.points_m.len()))
}

/// Where a ray from a sensor to a point, in world metres, is first in the grid; `None` if it is nowhere.
pub fn enters(sensor: DVec3, point: DVec3, grid: &Grid) -> Option<[i64; 3]> {
    let begin = grid.position_q16(sensor);
    if is_inside(begin, grid) {
        return Some(begin);
    }
    let [low, high] = [grid.corner_m([0; 3]), grid.corner_m(grid.window().end())];
    let way = point - sensor;
    let (mut from, mut to) = (0f64, 1f64);
    for r in 0..3 {
        if way[r] == 0.0 {
            if !(low[r]..high[r]).contains(&sensor[r]) {
                return None;
            }
            continue;
        }
        let [a, b] = [(low[r] - sensor[r]) / way[r], (high[r] - sensor[r]) / way[r]];
        (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
    }
    // The entry lies on a face of the grid: it is moved into the outermost voxels where rounding put it outside.
    let last = grid.size.map(|n| (i64::from(n) << 16) - 1);
    let entry = grid.position_q16(sensor + way * from);
    (from <= to).then(|| std::array::from_fn(|r| entry[r].clamp(0, last[r])))
}

fn is_inside(position_q16: [i64; 3], grid: &Grid) -> bool {
    grid.window().contains(Grid::voxel_of(position_q16))
}

/// Marks the voxel of a point in world metres, and those that its ray passes before, from a position inside the grid.
fn carve(begin_q16: [i64; 3], point: DVec3, grid: &Grid, planes: &mut Planes) {
    let window = grid.window();
    let point_q16 = grid.position_q16(point);
    let begin = Grid::voxel_of(begin_q16);
    // Of a point outside only the direction is wanted; it may be too far away for whole numbers.
    let (way, end, farthest_q16) = match is_inside(point_q16, grid) {
        true => {
            let way = DVec3::from_array(std::array::from_fn(|r| (point_q16[r] - begin_q16[r]) as f64));
            (way, Some(Grid::voxel_of(point_q16)), way.length())
        }
        false => {
            let from = DVec3::from_array(begin_q16.map(|part| part as f64 / 65536.0)) * grid.voxel_size_m;
            (point - grid.corner_m([0; 3]) - from, None, f64::INFINITY)
        }
    };
    if Some(begin) != end {
        let direction_q16 = (way / way.length()).to_array().map(|v| (v * 65536.0).round() as i32);
        planes.free.set(begin);
        let marched = march::crossings(march::start(begin_q16.map(|x| x as i32), direction_q16));
        let before = marched.take_while(|to| {
            f64::from(to.t_q16) <= farthest_q16 && Some(to.voxel) != end && window.contains(to.voxel)
        });
        before.for_each(|to| planes.free.set(to.voxel));
    }
    end.into_iter().for_each(|voxel| planes.occupied.set(voxel));
}
