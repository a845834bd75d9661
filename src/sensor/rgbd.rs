//! An RGB-D camera: one ray a pixel, and volumes around the keypoints that it detects in its image.

use super::keypoints::{self, BONES, Detected, Eye};
use super::range::Range;
use super::{Camera, Claim, Kind, MEASURES, Scale, Station, placement};
use crate::backend::{Planes, Rays};
use crate::voxel::grid::{ONE_Q16, length_q16};
use crate::voxel::{BitGrid, Truth, solid};

/// Optics, distances and what is scored.
#[derive(Clone, Debug, PartialEq)]
pub struct Rgbd {
    /// Its optics.
    pub camera: Camera,
    /// What it measures.
    pub range: Range,
    /// Representations in the order they are scored, each once.
    pub shapes: Vec<Shape>,
    /// Largest difference between the distance of a return and of the joint it is taken for, in metres.
    pub keypoint_tolerance_m: f64,
}

/// What a camera makes of the keypoints that it detects, besides the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Nothing: the points alone (paper: PC).
    Points,
    /// A ball around each joint (PC+Sph).
    Spheres {
        /// Its radius in metres.
        radius_m: f64,
    },
    /// A cylinder along each bone (PC+Cyl).
    Cylinders {
        /// Its radius in metres.
        radius_m: f64,
    },
    /// A box around all joints of a person (PC+Box).
    Box,
}

impl Shape {
    /// Its name in studies and tables.
    pub fn name(&self) -> &'static str {
        match self {
            Shape::Points => "points",
            Shape::Spheres { .. } => "spheres",
            Shape::Cylinders { .. } => "cylinders",
            Shape::Box => "box",
        }
    }

    /// Adds the volume around what is detected of one person.
    fn fill(&self, plane: &mut BitGrid, joints: &Detected, voxel_size_m: f64) {
        match self {
            Shape::Points => {}
            Shape::Spheres { radius_m } => {
                let radius = length_q16(*radius_m, voxel_size_m);
                joints.iter().flatten().for_each(|&joint| solid::ball(plane, joint, radius));
            }
            Shape::Cylinders { radius_m } => {
                let radius = length_q16(*radius_m, voxel_size_m);
                for [a, b] in BONES {
                    if let (Some(a), Some(b)) = (joints[a], joints[b]) {
                        solid::cylinder(plane, a, b, radius);
                    }
                }
            }
            Shape::Box => solid::cuboid(plane, joints.iter().flatten().copied()),
        }
    }
}

impl Kind for Rgbd {
    fn name(&self) -> &'static str {
        "rgbd"
    }

    fn representations(&self) -> Vec<&'static str> {
        self.shapes.iter().map(Shape::name).collect()
    }

    fn rays(&self, scale: &Scale) -> Option<Rays> {
        Some(Rays { image: Some(self.camera.image()), ..self.range.rays(self.camera.dirs_q15(), scale) })
    }

    fn is_noisy(&self) -> bool {
        self.range.noise_std_m > 0.0
    }

    fn housing_m(&self) -> f64 {
        self.range.near_ignore_m
    }

    fn log_odds(&self, _: usize) -> [i32; 2] {
        MEASURES
    }

    fn check(&self, at: &Station) -> Result<(), String> {
        match self.shapes.iter().find(|shape| **shape != Shape::Points) {
            Some(shape) => keypoints::check(at).map_err(|e| format!("representation {:?} {e}", shape.name())),
            None => Ok(()),
        }
    }

    fn adds(&self, representation: usize) -> bool {
        self.shapes[representation] != Shape::Points
    }

    fn around_people(&self, truth: &Truth) -> Option<BitGrid> {
        // Joints are detected on a person, so no volume leaves the person's box grown by the largest radius.
        let radius_m = |shape: &Shape| match *shape {
            Shape::Points => None,
            Shape::Spheres { radius_m } | Shape::Cylinders { radius_m } => Some(radius_m),
            Shape::Box => Some(0.0),
        };
        let radius_m = self.shapes.iter().filter_map(radius_m).reduce(f64::max)?;
        let radius_q16 = length_q16(radius_m, truth.grid.voxel_size_m);
        let mut volumes = BitGrid::new(truth.grid.window());
        for human in keypoints::humans(truth).filter(|human| !human.cells.is_empty()) {
            let bounds = human.cells.bounds();
            let low = bounds.min.map(|x| i64::from(x) * ONE_Q16 - radius_q16);
            let high = bounds.end().map(|x| i64::from(x) * ONE_Q16 + radius_q16);
            solid::half_open_box(&mut volumes, low, high);
        }
        Some(volumes)
    }

    fn claim(&self, representation: usize, at: &Station) -> Claim {
        let shape = self.shapes[representation];
        let (Some(rays), false) = (at.rays, shape == Shape::Points) else {
            return Claim { cast: true, planes: None };
        };
        let placement = &placement(self, &at.pose(), &at.truth.grid, at.draws);
        let tolerance_m = self.keypoint_tolerance_m;
        let eye = Eye { camera: &self.camera, rays, placement, tolerance_m };
        let mut planes = at.blank();
        for joints in keypoints::detect(&eye, at) {
            shape.fill(&mut planes.occupied, &joints, at.truth.grid.voxel_size_m);
        }
        let planes: Option<Planes> = (!planes.occupied.is_empty()).then_some(planes);
        Claim { cast: true, planes }
    }
}
