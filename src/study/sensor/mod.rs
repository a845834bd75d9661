//! What a sensor is: where it may stand, the rays it casts and the voxels it claims. Everything leaves this
//! room quantised, so that backends get integers only. [`kinds`] has a file for each kind.

pub mod calibration;
pub mod camera;
pub mod contour;
mod cost;
pub mod field_of_view;
pub mod keypoints;
pub mod kinds;
pub mod lens;
pub mod look;
pub mod noise;
pub mod prism;
pub mod range;
pub mod spacing;
pub mod spread;
pub mod turned;
pub mod watch;

use std::fmt::Debug;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use self::contour::Scanner;
use self::prism::Prism;
use self::range::Range;
use self::spacing::RaySpacing;
use crate::input::catalogue::ListPrice;
pub use calibration::Calibration;
pub use camera::Camera;
pub use cost::{Cost, CostTerms};
pub use field_of_view::FieldOfView;
use perirobot_march::backend::{GridFrame, GridPose, Planes, Rays};
use perirobot_march::error::Issue;
use perirobot_march::march;
use perirobot_march::voxel::{BitGrid, Grid, Window};
pub use perirobot_scene::objects::MountLink;
use perirobot_scene::pose::Pose;
use perirobot_scene::truth::{ObjectVoxels, Truth};
pub use spread::PoseSpread;

/// Most rays a sensor may cast at one pose: their directions, 12 bytes each, must fit one buffer of 128 MiB.
pub const MAX_RAYS: usize = (128 << 20) / 12;

/// A sensor of a study.
#[derive(Clone, Debug)]
pub struct Sensor {
    /// Unique in the study.
    pub name: String,
    /// What it is.
    pub kind: Arc<dyn Kind>,
    /// The robot's link that carries it, if not the world.
    pub on: Option<MountLink>,
    /// Candidates in study order.
    pub candidates: Vec<Candidate>,
    /// The candidate words of what is drawn for its candidates, if they are not their numbers.
    pub draw_words: Vec<u32>,
    /// The groups of candidates between which others are possible.
    pub spreads: Vec<PoseSpread>,
    /// The objects on which groups of its candidates are, where the study says so.
    pub surfaces: Vec<GroupSurface>,
    /// What the study says of its noise.
    pub noise: SaidOfNoise,
    /// That it casts fewer rays than the device of the catalogue that it is, if so: `casts …`.
    pub thinned: Option<String>,
    /// What one of them costs, and how many a set may have.
    pub terms: CostTerms,
    /// The list price of its model, if that is its cost.
    pub list_price: Option<ListPrice>,
    /// To which resolutions its protective field can be set, in millimetres, if its model says so.
    pub resolutions_mm: Vec<f64>,
    /// The kind of light that it emits, if the study or its device says so.
    pub emits: Option<String>,
    /// What was assumed about it that the user may not expect.
    pub warnings: Vec<String>,
}

/// What a study says of a sensor's noise, by its keys or those of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaidOfNoise {
    /// Nothing is said: the sensor is ideal.
    Nothing,
    /// The size of its noise.
    Model,
    /// Its noise is unknown; the sensor is cast as if it were ideal.
    Unknown,
}

/// The object that the candidates of a group are mounted on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GroupSurface {
    /// The name of the group.
    pub group: String,
    /// The name of the object, or of a part of it.
    pub object: String,
}

/// One way a sensor may be set up.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Unique among the sensor's candidates, and stable: `right-wall/12/3`.
    pub name: String,
    /// The set it belongs to: `right-wall`.
    pub group: String,
    /// What distinguishes it from the other candidates.
    pub setting: Setting,
}

/// What distinguishes the candidates of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// Where it is, in the world or on its link.
    Pose(Pose),
    /// How far a proximity cover senses, in metres.
    Inflation(f64),
    /// Nothing: there is one way only.
    Fixed,
}

impl Sensor {
    /// The candidate word of what is drawn for a candidate: noise, loss, and how far its mount is off.
    pub(crate) fn draw_word(&self, candidate: usize) -> usize {
        self.draw_words.get(candidate).map_or(candidate, |&word| word as usize)
    }

    /// The settings of its candidates, with poses in the world; the carrier is the link that carries it, if one does.
    pub(crate) fn settings(&self, carrier: Option<&Pose>) -> Vec<Setting> {
        self.candidates.iter().map(|candidate| candidate.setting.carried_by(carrier)).collect()
    }
}

impl Setting {
    /// The same in the world, on a link that carries the sensor, if one does.
    pub(crate) fn carried_by(self, carrier: Option<&Pose>) -> Setting {
        match (self, carrier) {
            (Setting::Pose(pose), Some(link)) => Setting::Pose(pose.carried_by(link)),
            (Setting::Fixed, Some(link)) => Setting::Pose(*link),
            _ => self,
        }
    }

    /// The pose; the origin of a setting that has none.
    pub fn pose(&self) -> Pose {
        match self {
            Setting::Pose(pose) => *pose,
            _ => Pose::ORIGIN,
        }
    }
}

/// How a pose that faces somewhere turns the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stance {
    /// Its optical axis faces there, and tilts.
    Facing,
    /// It spins about its own vertical axis, azimuth 0 towards there, and does not tilt.
    Upright,
    /// It lies or stands level; where it faces may be left out.
    Level,
}

/// How a person approaches what a sensor watches, for the distance that ISO 13855 adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Approached {
    /// At a right angle, as far as is known.
    AtRightAngle,
    /// Along the floor.
    OnFloor,
    /// Along the plane of its rays, if they have one.
    AlongRays,
}

/// What a sensor's table of rays depends on besides the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayScale {
    /// Edge of a voxel in metres.
    pub voxel_size_m: f64,
    /// Whether a ray that leaves the grid returns from just outside.
    pub backdrop: bool,
    /// The share of light that objects of each shade reflect, the darkest first; infinite for a shade that no object has.
    pub reflectances: [f64; march::SHADES],
}

impl RayScale {
    /// Where no object is too dark for any sensor.
    pub fn new(voxel_size_m: f64, backdrop: bool) -> RayScale {
        RayScale { voxel_size_m, backdrop, reflectances: [f64::INFINITY; march::SHADES] }
    }
}

/// What a sensor of some kind does. Representations are numbered as [`Kind::representations`] lists them.
pub trait Kind: Debug + Send + Sync {
    /// What it is called in a study.
    fn name(&self) -> &'static str;

    /// The representations that are scored, in order.
    fn representations(&self) -> Vec<&'static str>;

    /// The same sensor with one of its representations alone; `None` where it has no other.
    fn only(&self, _representation: usize) -> Option<Arc<dyn Kind>> {
        None
    }

    /// The rays that a backend casts from every pose; `None` for a sensor that needs none.
    fn rays(&self, _: &RayScale) -> Option<Rays> {
        None
    }

    /// Whether it stays on until it is reset, so that people who tripped it on their way count as detected.
    fn latches(&self) -> bool {
        false
    }

    /// The rays by which a switch that is not cast on backends senses its field; `None` for any other sensor.
    fn fan(&self, _voxel_size_m: f64) -> Option<Rays> {
        None
    }

    /// Where its rays look. With it, voxels between rays can be distinguished from voxels outside the view.
    fn field_of_view(&self) -> FieldOfView {
        FieldOfView::Spacing
    }

    /// The gaps between its rays; `None` if it has none, or in no grid.
    fn spacing(&self) -> Option<RaySpacing> {
        None
    }

    /// The distances that it measures; `None` for a sensor without rays.
    fn range(&self) -> Option<&Range> {
        None
    }

    /// The frame of its rays in the world.
    fn frame(&self, pose: &Pose) -> DMat3 {
        pose.optical()
    }

    /// How a facing pose turns it.
    fn stance(&self) -> Stance {
        Stance::Facing
    }

    /// The candidates of a sensor that is not given poses; empty if it needs them.
    fn settings(&self) -> Vec<(String, Setting)> {
        Vec::new()
    }

    /// Whether poses may be given.
    fn takes_poses(&self) -> bool {
        true
    }

    /// Whether readings differ from repeat to repeat.
    fn is_noisy(&self) -> bool {
        self.range().is_some_and(Range::is_noisy)
    }

    /// How far its mount may be off, if it may.
    fn calibration(&self) -> Option<Calibration> {
        self.range()?.calibration
    }

    /// How a person approaches what it watches; `None` if it notices nobody.
    fn approached(&self) -> Option<Approached> {
        Some(Approached::AtRightAngle)
    }

    /// Whether it speaks after all others, wherever a combination lists it.
    fn speaks_last(&self) -> bool {
        false
    }

    /// The volumes that it watches where they do not begin at a lens, for drawings.
    fn prisms(&self) -> Vec<&Prism> {
        Vec::new()
    }

    /// The ground below the field that it usually guards with its rays, as corners in world metres; empty for none.
    fn guarded_m(&self, _: &Pose) -> Vec<DVec3> {
        Vec::new()
    }

    /// The same of the field that it guards at a station's moment.
    fn guarded_now_m(&self, at: &Station) -> Vec<DVec3> {
        self.guarded_m(&at.pose())
    }

    /// How far its own housing reaches, in metres: blockers nearer than that let its rays pass.
    fn housing_m(&self) -> f64 {
        self.range().map_or(0.0, |range| range.near_ignore_m)
    }

    /// What `occupied` and `free` add to a voxel's log-odds, in thousandths.
    fn log_odds(&self, representation: usize) -> [i32; 2];

    /// Refuses a candidate at which it cannot work in a scene, and says what would work.
    fn check(&self, _: &Station) -> Result<(), Issue> {
        Ok(())
    }

    /// Whether the host may add to what is cast in a representation; a claim without a cast always does.
    fn adds(&self, _representation: usize) -> bool {
        true
    }

    /// Whether it is a presence sensor: the people's voxels that it feels are its hits.
    fn feels_presence(&self, _representation: usize) -> bool {
        false
    }

    /// Which voxels it may hit or feel, if not those that its rays can reach.
    fn feels(&self, _: &Station) -> Extent {
        Extent::Rays
    }

    /// Which voxels it watches ([`watch`]) in a representation, if neither all that its rays can hit nor all
    /// that it feels.
    fn watches(&self, _representation: usize, _: &Station) -> Option<BitGrid> {
        None
    }

    /// Whether it is switched off at a moment, so that it neither says nor watches anything.
    fn is_muted(&self, _: &Station) -> bool {
        false
    }

    /// The voxels in which people count as detected because they came in through what it watches; none of most.
    fn latched(&self, _: &Station) -> BitGrid {
        BitGrid::nowhere()
    }

    /// What stops its rays.
    fn blockers<'t>(&self, truth: &'t Truth) -> &'t BitGrid {
        &truth.blockers
    }

    /// Whether an object stops them.
    fn is_stopped_by(&self, object: &ObjectVoxels) -> bool {
        object.stops_rays
    }

    /// The voxels of the environment that alone trip it, so that it never changes; none where it works.
    fn stuck_by(&self, _: &Station) -> BitGrid {
        BitGrid::nowhere()
    }

    /// What to do about them.
    fn stuck_advice(&self) -> &'static str {
        "keep the box or the field off floor and walls, or give a pad tare = true"
    }

    /// The same as a scanner, if it may guard a field with a level ring.
    fn as_scanner(&self) -> Option<&dyn Scanner> {
        None
    }

    /// What it says, in each representation.
    fn claims(&self, at: &Station) -> Vec<Claim>;

    /// The voxels that it may label.
    fn reach(&self, _: &Station) -> Extent {
        Extent::Rays
    }

    /// Further voxels that it may label, wherever it stands: around people, or in a zone of the world.
    fn wherever_it_stands(&self, _: &Truth) -> Option<BitGrid> {
        None
    }
}

/// The voxels that a sensor may label at a candidate; planes cover a part of the grid that holds all of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Whatever rays from its pose can reach.
    Rays,
    /// These voxels.
    Only(BitGrid),
    /// These voxels besides what rays can reach.
    RaysAnd(BitGrid),
}

/// Log-odds of a sensor that measures, in thousandths: OctoMap's defaults for a hit and a miss.
pub const MEASURES: [i32; 2] = [847, -405];
/// Log-odds of a switch: certain when it is on, no surer than a miss when it is off.
pub const SWITCHES: [i32; 2] = [3511, -405];

/// What a sensor says at a candidate, before it is placed in slots.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Claim {
    /// Whether the evidence that the backend casts belongs to it.
    pub cast: bool,
    /// What the host adds, over the part of the station's window that holds it; `None` for nothing.
    pub planes: Option<Planes>,
}

/// A candidate in a scene.
#[derive(Clone, Copy, Debug)]
pub struct Station<'a> {
    /// Index of the scene, and which moment of it.
    pub moment: [usize; 2],
    /// The scene.
    pub truth: &'a Truth,
    /// The voxels that matter.
    pub window: Window,
    /// The candidate's setting; a pose is in the world, whatever carries it.
    pub setting: Setting,
    /// The sensor's own table of rays, if it has one.
    pub rays: Option<&'a Rays>,
    /// Where the sensor truly is, if its mount is off; in the world.
    pub truly: Option<Pose>,
    /// The hash of the words before the ray, for what is noisy.
    pub draws: u32,
}

impl Station<'_> {
    /// Fails where no voxel of the scene is the robot's.
    pub(crate) fn check_robot(&self) -> Result<(), Issue> {
        match self.truth.robot.is_empty() {
            true => Err(Issue::says("needs a robot: no voxel of the scene is the robot's")
                .with_advice("give its object role = \"robot\"")),
            false => Ok(()),
        }
    }

    /// Where the sensor is; the world's origin if it has no pose.
    pub fn pose(&self) -> Pose {
        self.setting.pose()
    }

    /// Where a sensor of some kind is, as integers.
    pub fn placement(&self, kind: &dyn Kind) -> GridPose {
        let truly = self.truly.map(|pose| standpoint(kind, &pose, &self.truth.grid));
        GridPose { truly, ..placement(kind, &self.pose(), &self.truth.grid, self.draws) }
    }

    /// The same candidate, looked at over the whole grid.
    pub(crate) fn everywhere(&self) -> Self {
        Station { window: self.truth.grid.window(), ..*self }
    }
}

/// Refuses a pad or a gate that is not level.
fn level(at: &Station) -> Result<(), Issue> {
    match at.pose().link().z_axis.z > 1.0 - 1e-9 {
        true => Ok(()),
        false => Err(Issue::says("is tilted")
            .with_advice("a pad or a gate lies or stands level, and turns about the vertical only")),
    }
}

/// What a switch says of a volume: occupied when it is on, else free if the study lets it certify that.
/// `felt` are the voxels of people that it feels when it is on.
fn switch_planes(at: &Station, volume: BitGrid, on: bool, otherwise_free: bool, felt: BitGrid) -> Claim {
    let empty = BitGrid::nowhere();
    let planes = match (on, otherwise_free) {
        (true, _) => {
            let hits = felt.to_window(felt.window().intersection(&at.window));
            Some(Planes { occupied: volume, free: empty, hits })
        }
        (false, true) => Some(Planes { occupied: empty.clone(), free: volume, hits: empty }),
        (false, false) => None,
    };
    Claim { cast: false, planes }
}

/// A pose as integers. The position must lie in the grid.
pub(crate) fn standpoint(kind: &dyn Kind, pose: &Pose, grid: &Grid) -> GridFrame {
    let rotation = kind.frame(pose);
    let row = |r: usize| std::array::from_fn(|a| quantise_q15(rotation.col(a)[r]));
    GridFrame {
        origin_q16: grid.position_q16(pose.position_m).map(|x| x as i32),
        axis_q15: std::array::from_fn(row),
    }
}

/// The placement of a sensor that is where it is believed to be.
pub fn placement(kind: &dyn Kind, pose: &Pose, grid: &Grid, draws: u32) -> GridPose {
    let GridFrame { origin_q16, axis_q15 } = standpoint(kind, pose, grid);
    GridPose { origin_q16, axis_q15, truly: None, draws }
}

/// The hash of the words before the ray: all indices count in study order.
pub(crate) fn draws(seed: u64, [scene, snapshot, sensor, pose, repeat]: [usize; 5]) -> u32 {
    let seed = [seed as u32, (seed >> 32) as u32];
    march::fold(seed.into_iter().chain([scene, snapshot, sensor, pose, repeat].map(|index| index as u32)))
}

/// A component of a unit vector in Q15, ties away from zero: −32768 to 32768.
pub fn quantise_q15(value: f64) -> i32 {
    (value * 32_768.0).round() as i32
}

#[cfg(test)]
mod tests;
