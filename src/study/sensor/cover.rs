//! A proximity cover, the robot's skin: it measures what comes near any part of the robot.

use super::noise::{self, Deviation};
use super::{Claim, Extent, Kind, MEASURES, Setting, Station};
use perirobot_march::backend::Planes;
use perirobot_march::error::Issue;
use perirobot_march::march;
use perirobot_march::voxel::grid::{MAX_VOXELS_PER_AXIS, ONE_Q16, length_q16};
use perirobot_march::voxel::{BitGrid, solid};

/// How far a cover senses, and how noisily. Its candidates are distances, not poses.
#[derive(Clone, Debug, PartialEq)]
pub struct Cover {
    /// The distances to try, in metres, as they were written.
    pub inflation_m: Vec<f64>,
    /// Standard deviation on each axis in metres; 0 for none.
    pub noise_std_m: f64,
}

impl Cover {
    /// The voxels around the robot that it senses, over the part of the grid that holds them.
    fn shell(&self, at: &Station) -> BitGrid {
        let Setting::Inflation(inflation_m) = at.setting else { return BitGrid::nowhere() };
        let (robot, grid) = (&at.truth.robot_volume, &at.truth.grid);
        let distance_q16 = length_q16(inflation_m, grid.voxel_size_m);
        let farthest = (distance_q16 >> 16).clamp(0, MAX_VOXELS_PER_AXIS.into()) as i32;
        let around = robot.bounds().grown(farthest).intersection(&grid.window());
        let mut shell = solid::within(robot, distance_q16, around);
        shell.remove(robot);
        shell
    }

    /// Each occupied voxel where noise puts its centre. One that leaves the window marks nothing.
    fn shifted(&self, occupied: &BitGrid, at: &Station) -> BitGrid {
        let grid = &at.truth.grid;
        let deviation = Deviation { std_m: self.noise_std_m, ..Deviation::NONE };
        let std_q16 = deviation.at_q16(0.0, grid.voxel_size_m);
        if std_q16 == 0 {
            return occupied.over(occupied.window().intersection(&at.window));
        }
        let unit_q12 = noise::unit_q12();
        let [x, y, _] = grid.size;
        let mut shifted = BitGrid::new(at.window);
        for voxel in occupied.voxels() {
            let number = voxel[0] as u32 + x * (voxel[1] as u32 + y * voxel[2] as u32);
            shifted.set(std::array::from_fn(|axis| {
                // 3 · 1023³ has 32 bits and wraps nothing.
                let entry = march::entry(march::draw(at.draws, 3 * number + axis as u32));
                let step = march::step_q16(unit_q12[entry as usize], std_q16);
                ((i64::from(voxel[axis]) * ONE_Q16 + ONE_Q16 / 2 + i64::from(step)) >> 16) as i32
            }));
        }
        shifted
    }
}

const _: () = assert!(3 * (MAX_VOXELS_PER_AXIS as u64).pow(3) <= u32::MAX as u64);

impl Kind for Cover {
    fn name(&self) -> &'static str {
        "cover"
    }

    fn representations(&self) -> Vec<&'static str> {
        vec!["naive"]
    }

    fn settings(&self) -> Vec<(String, Setting)> {
        self.inflation_m.iter().map(|&metres| (metres.to_string(), Setting::Inflation(metres))).collect()
    }

    fn takes_poses(&self) -> bool {
        false
    }

    fn is_noisy(&self) -> bool {
        self.noise_std_m > 0.0
    }

    fn log_odds(&self, _: usize) -> [i32; 2] {
        MEASURES
    }

    fn feels_presence(&self, _: usize) -> bool {
        true
    }

    fn check(&self, at: &Station) -> Result<(), Issue> {
        at.check_robot()
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        let mut free = self.shell(at);
        let mut near = free.clone();
        near.keep(&at.truth.occupied);
        free.remove(&near);
        let (occupied, window) = (self.shifted(&near, at), free.window().intersection(&at.window));
        near.keep(&at.truth.human);
        let planes = Planes { occupied, free: free.over(window), hits: near.over(window) };
        vec![Claim { cast: false, planes: Some(planes) }]
    }

    fn feels(&self, at: &Station) -> Extent {
        Extent::Only(self.shell(at))
    }

    fn reach(&self, at: &Station) -> Extent {
        Extent::Only(self.shell(at))
    }
}
