//! Where a sensor looks from a pose, whatever is in between: what decides whether sensors disturb each other.

use glam::{DMat3, DVec3};

use super::range::Along;
use super::{FieldOfView, Kind};
use perirobot_march::voxel::Grid;
use perirobot_scene::pose::Pose;

/// Rays of a field of view along which places are taken, at most.
const RAYS: usize = 48;
/// Places along each of them.
const ALONG: usize = 5;
/// Steps between the places that outline what is too near, on each axis.
const NEAR_STEPS: usize = 24;
/// Lenses nearer than this are in the same place: none is in front of the other.
const SAME_PLACE_M: f64 = 1e-9;

/// The lens of a sensor at a pose.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    /// Where it is in the world, in metres.
    pub position_m: DVec3,
    world_from_lens: DMat3,
    field: FieldOfView,
    /// The nearest and the farthest distance that are measured, in metres, and what they are measured along.
    near_m: f64,
    far_m: f64,
    along: Along,
}

/// Whether sensors of a kind have a lens: rays, in a field of view that is known.
pub fn has_lens(kind: &dyn Kind) -> bool {
    kind.range().is_some() && kind.field_of_view() != FieldOfView::Spacing
}

impl Lens {
    /// The lens of a kind of sensor at a pose in the world, if it has one.
    pub fn new(kind: &dyn Kind, pose: &Pose) -> Option<Lens> {
        let range = kind.range().filter(|_| has_lens(kind))?;
        let [near_m, far_m] = range.range_m;
        Some(Lens {
            position_m: pose.position_m,
            world_from_lens: kind.frame(pose),
            field: kind.field_of_view(),
            near_m,
            far_m,
            along: range.along,
        })
    }

    /// How far a point is off the direction of view, in radians; `None` outside the field of view. A camera looks along its
    /// axis. What spins looks everywhere in the middle of its elevations, so that only the elevation counts.
    pub fn off_view_rad(&self, point_m: DVec3) -> Option<f64> {
        let towards = self.in_lens(point_m);
        if towards.length() < SAME_PLACE_M || self.field.holds(towards) != Some(true) {
            return None;
        }
        let DVec3 { x, y, z } = towards;
        let aside = libm::sqrt(x * x + y * y);
        match self.field {
            FieldOfView::Image(_) => Some(libm::atan2(aside, z)),
            FieldOfView::Turn { elevation_rad: [low, high], .. } => {
                Some((libm::atan2(z, aside) - (low + high) / 2.0).abs())
            }
            FieldOfView::Spacing => None,
        }
    }

    /// Whether a point is in the field of view, and not farther than is measured.
    pub fn reaches(&self, point_m: DVec3) -> bool {
        let towards = self.in_lens(point_m);
        self.measured_m(towards) <= self.far_m && self.field.holds(towards) == Some(true)
    }

    /// Whether a point is in the field of view, and nearer than is measured.
    pub fn is_too_near(&self, point_m: DVec3) -> bool {
        let towards = self.in_lens(point_m);
        self.measured_m(towards) < self.near_m && self.field.holds(towards) == Some(true)
    }

    /// Places at the nearest distance that is measured, spread over the field of view, in the world and in parts: what is too
    /// near is made up of the convex hulls of the lens and each part.
    pub fn near_parts_m(&self) -> Vec<Vec<DVec3>> {
        let place = |direction: &DVec3| {
            let towards = match self.along {
                Along::Axis if direction.z > 0.0 => direction / direction.z,
                _ => *direction,
            };
            self.position_m + self.world_from_lens * (towards * self.near_m)
        };
        let rows = self.field.lattice(NEAR_STEPS);
        match self.field {
            FieldOfView::Image(_) => vec![rows.iter().flatten().map(place).collect()],
            // A whole turn is not convex, a step of it is.
            _ => (0..NEAR_STEPS)
                .map(|step| rows.iter().flat_map(|row| row[step..step + 2].iter().map(place)).collect())
                .collect(),
        }
    }

    /// How far from the lens a point may be that is too near, in metres.
    pub fn near_reach_m(&self) -> f64 {
        let ends = self.near_parts_m().into_iter().flatten();
        ends.map(|end| end.distance(self.position_m)).fold(self.near_m, f64::max)
    }

    /// The nearest distance that is measured, and what it is measured along.
    pub fn near_m(&self) -> (f64, Along) {
        (self.near_m, self.along)
    }

    /// The distance of a point in the frame of its rays, as its ranges count it.
    fn measured_m(&self, towards: DVec3) -> f64 {
        match self.along {
            Along::Ray => towards.length(),
            Along::Axis => towards.z,
        }
    }

    /// Places that stand for what it sees, in the world: evenly along rays that are spread over the field of view, up to the
    /// farthest distance or the edge of the grid.
    pub fn places_m(&self, grid: &Grid) -> Vec<DVec3> {
        let [low, high] = [[0; 3], grid.size.map(|size| size as i32)].map(|corner| grid.corner_m(corner));
        let along_ray = |direction: DVec3| {
            let towards = self.world_from_lens * direction;
            let far_m = match self.along {
                Along::Axis if direction.z > 0.0 => self.far_m / direction.z,
                _ => self.far_m,
            };
            let to_edge = |axis: usize| match towards[axis] {
                0.0 => f64::INFINITY,
                up @ 0.0.. => (high[axis] - self.position_m[axis]) / up,
                down => (low[axis] - self.position_m[axis]) / down,
            };
            let end_m = (0..3).map(to_edge).fold(far_m, f64::min).max(0.0);
            let share = |number: usize| (number as f64 + 0.5) / ALONG as f64;
            (0..ALONG).map(move |number| self.position_m + towards * (end_m * share(number)))
        };
        self.field.some(RAYS).into_iter().flat_map(along_ray).collect()
    }

    /// From the lens to a point, in the frame of its rays.
    fn in_lens(&self, point_m: DVec3) -> DVec3 {
        self.world_from_lens.transpose() * (point_m - self.position_m)
    }
}
