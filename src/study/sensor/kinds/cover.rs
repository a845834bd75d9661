//! A proximity cover, the robot's skin: it measures what comes near any part of the robot.

use serde::Deserialize;
use toml::Table;

use super::shared::range::{NoiseFile, constant, refuse_former};
use super::{Checked, Context, KindFile};
#[cfg(test)]
use super::{EvidenceWords, Page};
use crate::diagnostics::Place;
use crate::sensor::noise::{self, Deviation};
use crate::sensor::{Claim, Extent, Kind, MEASURES, Setting, Station};
use perirobot_march::Result;
use perirobot_march::backend::Planes;
use perirobot_march::error::Issue;
use perirobot_march::march;
use perirobot_march::voxel::grid::{MAX_VOXELS_PER_AXIS, ONE_Q16, length_q16};
use perirobot_march::voxel::{BitGrid, solid};
use perirobot_scene::source::Sources;

/// A robot's skin that feels what is near.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct CoverFile {
    /// How far it senses; each is a candidate.
    inflation_m: Vec<f64>,
    /// How far off it feels what is near, on each axis: { std_m }. Default exact.
    noise: Option<NoiseFile>,
}

impl KindFile for CoverFile {
    const NAME: &'static str = "cover";
    #[cfg(test)]
    const PAGE: Page = Page {
        what: "proximity cover, the robot's skin",
        keys: "`inflation_m` (a list: its candidates), `noise?` (`{ std_m }`, on each axis)",
        evidence: &[EvidenceWords {
            says: "",
            occupied: "truly occupied voxels whose centre is within `inflation_m` of the centre of a voxel of the robot, \
        outside the robot",
            free: "the other voxels of that shell",
        }],
    };

    fn prepare(at: &Place, keys: &mut Table, _: &Sources) -> Result<Vec<String>> {
        refuse_former(at, keys)?;
        Ok(Vec::new())
    }

    fn check(self, at: &Place, context: &Context) -> Result<Checked> {
        at.some("inflation_m", &self.inflation_m, "inflation_m = [0.1, 0.2]")?;
        for (i, &metres) in self.inflation_m.iter().enumerate() {
            at.number("inflation_m", metres, f64::MIN_POSITIVE..=10.0, "lengths above 0 and at most 10 m")?;
            if self.inflation_m[..i].contains(&metres) {
                return Err(at.wrong("inflation_m", metres, "stands twice: name each distance once"));
            }
        }
        let farthest_m = self.inflation_m.iter().copied().fold(0.0, f64::max);
        let noise_std_m = constant(at, self.noise, farthest_m, context.noiseless)?;
        Ok(Cover { inflation_m: self.inflation_m, noise_std_m }.into())
    }
}

/// How far a cover senses, and how noisily. Its candidates are distances, not poses.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cover {
    /// The distances to try, in metres, as they were written.
    pub(crate) inflation_m: Vec<f64>,
    /// Standard deviation on each axis in metres; 0 for none.
    pub(crate) noise_std_m: f64,
}

impl Cover {
    /// The voxels around the robot that it senses, over the part of the grid that holds them.
    fn shell(&self, at: &Station) -> BitGrid {
        let Setting::Inflation(inflation_m) = at.setting else { return BitGrid::nowhere() };
        let (robot, grid) = (&at.truth.robot_volume, &at.truth.grid);
        let distance_q16 = length_q16(inflation_m, grid.voxel_size_m);
        let farthest = (distance_q16 >> 16).clamp(0, MAX_VOXELS_PER_AXIS.into()) as i32;
        let around = robot.bounds().grown(farthest).intersection(&grid.window());
        let mut shell = solid::dilate(robot, distance_q16, around);
        shell.remove(robot);
        shell
    }

    /// Each occupied voxel where noise puts its centre. One that leaves the window marks nothing.
    fn shift(&self, occupied: &BitGrid, at: &Station) -> BitGrid {
        let grid = &at.truth.grid;
        let deviation = Deviation { std_m: self.noise_std_m, ..Deviation::NONE };
        let std_q16 = deviation.at_q16(0.0, grid.voxel_size_m);
        if std_q16 == 0 {
            return occupied.to_window(occupied.window().intersection(&at.window));
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
        CoverFile::NAME
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
        let (occupied, window) = (self.shift(&near, at), free.window().intersection(&at.window));
        near.keep(&at.truth.human);
        let planes = Planes { occupied, free: free.to_window(window), hits: near.to_window(window) };
        vec![Claim { cast: false, planes: Some(planes) }]
    }

    fn feels(&self, at: &Station) -> Extent {
        Extent::Only(self.shell(at))
    }

    fn reach(&self, at: &Station) -> Extent {
        Extent::Only(self.shell(at))
    }
}
