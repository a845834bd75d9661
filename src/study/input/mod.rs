//! What the user wrote: a study file and the scene files it names, checked once at the edge and turned into
//! metres and radians. Defaults are in `file.rs`, `region_file.rs`, `scene_file.rs` and, of sensors, in `sensor::kinds`;
//! meshes are read by `scene`.

mod approach;
mod asking;
mod candidates;
pub mod catalogue;
mod check;
mod choices;
mod choose;
mod combination;
mod disturb;
mod elsewhere;
mod file;
mod plan;
mod poses;
mod postures;
mod reflectance;
mod region;
mod region_file;
mod require;
mod scene_file;
pub mod schema;
pub mod sensor;
mod stopping;
mod urdf;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

pub use crate::diagnostics::IN_MEMORY;
use crate::sensor::kinds::recorded::Recorded;
use crate::sensor::{Candidate, CostTerms, Kind, RayScale, SaidOfNoise, Sensor};
use crate::world::KeptRays;
pub use approach::{Approach, BodyShape, BodySpec, EntryPlace, EntrySpec, Hazard};
use catalogue::{DeviceModel, describe_list_prices};
pub use choices::Choices;
pub use choose::{Choose, Purchase, PurchaseFront, SetRequirement, ThenScore, Wanted};
pub use combination::{Combination, Member};
pub use combination::{MAX_NAMES_BYTES, MAX_ROWS, bytes_of_names};
pub use disturb::Disturb;
use perirobot_march::backend::Fusion;
use perirobot_march::{Error, Result};
use perirobot_scene::objects::spec::SceneSpec;
use perirobot_scene::source::Sources;
pub use plan::{PLANNED, Planned, PlannedAt};
pub use postures::Posture;
pub use reflectance::PERSON_REFLECTANCE;
pub use region::RegionSpec;
pub use require::{
    ApproachScore, Condition, ControllerScore, Counted, Limit, Measure, MountingError, Nearness, Requirement,
};
pub use scene_file::load_scene;
pub use stopping::{AtSpeed, Formula, Stopping};

/// A checked study: what to sweep over what.
#[derive(Clone, Debug)]
pub struct Study {
    /// The file it came from.
    pub path: PathBuf,
    /// Its text, for the manifest.
    pub text: String,
    /// Seed of everything drawn at random.
    pub seed: u64,
    /// Edge of a voxel in metres.
    pub voxel_size_m: f64,
    /// Lowest and highest corner of the grid, if the user set them.
    pub bounds_m: Option<[DVec3; 2]>,
    /// Whether a ray that leaves the grid returns from just outside.
    pub backdrop: bool,
    /// Scenes in study order.
    pub scenes: Vec<SceneSpec>,
    /// Regions in study order, with their names.
    pub regions: Vec<(String, RegionSpec)>,
    /// Sensors in study order.
    pub sensors: Vec<Sensor>,
    /// How the evidence of sensors becomes one label, unless their combination has its own rule.
    pub fusion: Fusion,
    /// The combinations in study order; each sensor alone if the study has none.
    pub combinations: Vec<Combination>,
    /// Which set of sensors is looked for, if the study says so, or has all that the cheapest set that passes needs.
    pub choose: Option<Wanted>,
    /// What a choice of sensors must reach.
    pub requirements: Vec<Requirement>,
    /// How far mounts may be off, if the study says so.
    pub mounting_error: Option<MountingError>,
    /// Each person at each spot that the study lists, person by person; none where it lists none.
    pub postures: Vec<Posture>,
    /// The unit of all costs, if the study says so.
    pub currency: Option<String>,
    /// How near bodies can come unnoticed is asked of these.
    pub approach: Approach,
    /// Whether the study says so itself, in a table `[approach]`.
    pub has_approach: bool,
    /// How far people must be from the robot at which of its speeds, if the study says so.
    pub stopping: Option<Stopping>,
    /// The devices of its own catalogue.
    pub models: Vec<DeviceModel>,
    /// The shares of light that its objects of each shade reflect, the darkest first; empty where no sensor asks.
    pub reflectances: Vec<f64>,
    /// Whether noise was switched off, whatever the study says.
    pub noiseless: bool,
    /// Numbers in its file that look as if they had a wrong unit.
    pub warnings: Vec<String>,
    /// How often everything is scored, each time with other noise; once where nothing is noisy.
    pub repeats: u32,
    /// How many voxels of a body part must be hit for it to be detected.
    pub min_hits: u32,
    /// The sources through which its files were read, and its meshes will be.
    pub sources: Sources,
    /// The tables of rays of its sensors.
    pub kept_rays: KeptRays,
}

/// What a command line may override.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Edge of a voxel in metres.
    pub voxel_size_m: Option<f64>,
    /// No sensor has noise.
    pub noiseless: bool,
}

impl Study {
    /// Reads and checks a study and its scene files (not their meshes), which must lie in its folder or
    /// below.
    pub fn load(path: &Path, overrides: &Overrides) -> Result<Study> {
        Study::read(path, overrides, Sources::from_main(path))
    }

    /// Reads and checks a study and its scene files (not their meshes), from where its sources may lie.
    pub fn read(path: &Path, overrides: &Overrides, sources: Sources) -> Result<Study> {
        Study::examine(path, overrides, sources).map_err(Error::first)
    }

    /// The same, but tells all errors that can be judged independently.
    pub fn examine(path: &Path, overrides: &Overrides, sources: Sources) -> Result<Study, Vec<Error>> {
        check::study(path, overrides, sources.clone()).map_err(|problems| sources.classify(problems))
    }

    /// What its tables of rays depend on besides the sensors.
    pub fn ray_scale(&self) -> RayScale {
        let share = |shade: usize| self.reflectances.get(shade).copied().unwrap_or(f64::INFINITY);
        RayScale {
            voxel_size_m: self.voxel_size_m,
            backdrop: self.backdrop,
            reflectances: std::array::from_fn(share),
        }
    }

    /// Which costs are list prices of the catalogue, in a sentence; `None` if none is.
    pub fn describe_list_prices(&self) -> Option<String> {
        let prices = self.sensors.iter().map(|sensor| (sensor.name.as_str(), sensor.list_price.as_ref()));
        describe_list_prices(prices)
    }

    /// The shade of people whose reflectance is not given.
    pub fn person_shade(&self) -> u8 {
        reflectance::number(&self.reflectances, PERSON_REFLECTANCE)
    }

    /// The same sensors, each in one representation alone, in other combinations.
    pub fn with_combinations(&self, representations: &[usize], combinations: Vec<Combination>) -> Study {
        let mut study = Study { combinations, ..self.clone() };
        for (sensor, &representation) in study.sensors.iter_mut().zip(representations) {
            sensor.kind = sensor.kind.only(representation).unwrap_or_else(|| sensor.kind.clone());
        }
        study
    }

    /// The same with one sensor alone, whose evidence was recorded; its requirements and questions are left out.
    pub fn with_recording(&self, recorded: Recorded) -> Study {
        let taken = |name: &str| self.sensors.iter().any(|sensor| sensor.name == name);
        let name = std::iter::successors(Some(String::from("recorded")), |name| Some(format!("{name}-map")))
            .find(|name| !taken(name))
            .expect("a study has fewer sensors than there are names");
        let candidate = |(own, setting)| Candidate { name: own, group: recorded.name().into(), setting };
        let candidates = recorded.settings().into_iter().map(candidate).collect();
        let combination = Combination {
            name: name.clone(),
            fusion: Fusion::default(),
            members: vec![Member { sensor: 0, candidates: vec![0] }],
        };
        let sensor = Sensor {
            kind: Arc::new(recorded),
            on: None,
            candidates,
            draw_words: Vec::new(),
            spreads: Vec::new(),
            surfaces: Vec::new(),
            noise: SaidOfNoise::Nothing,
            thinned: None,
            terms: CostTerms::default(),
            list_price: None,
            resolutions_mm: Vec::new(),
            emits: None,
            warnings: Vec::new(),
            name,
        };
        Study {
            combinations: vec![combination],
            sensors: vec![sensor],
            choose: None,
            requirements: Vec::new(),
            repeats: 1,
            ..self.clone()
        }
    }
}

/// A name as in tables: lower-case letters and digits, everything else replaced by single hyphens.
pub fn slug(name: &str) -> String {
    let plain: String =
        name.chars().map(|c| if c.is_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect();
    plain.split('-').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slugs_are_lower_case_with_single_hyphens() {
        for (name, expected) in [
            ("right wall", "right-wall"),
            ("  Right--Wall (2) ", "right-wall-2"),
            ("a/b:c,d", "a-b-c-d"),
            ("Straße 7", "straße-7"),
            ("...", ""),
            ("", ""),
        ] {
            assert_eq!(slug(name), expected, "{name:?}");
        }
    }
}
