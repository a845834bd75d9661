//! `[stopping]` of a study, checked: how far people must be from the robot at each of its speeds.
//!
//! # Theory
//! Somebody walks towards the robot from the moment at which a sensor could notice them, until the robot stands.
//! `iso13855` is the distance of a machine that stays where it is, as public pages tell of ISO 13855: S = K·T + C in
//! the edition of 2010, S = K·T + D_DS + Z in that of 2024, with the speed of people K and the time T until the
//! machine stands. `speed_and_separation` adds that the robot itself comes nearer, as public pages tell of
//! ISO/TS 15066 (Marvel and Norcross, 2017): S = human + robot + stopping + C + Z_d + Z_r.
//!
//! People walk with K = 1.6 m/s; where the distance is at most 0.5 m an arm is faster than that, K = 2 m/s: the distance is that with 2
//! m/s up to 0.5 m, else that with 1.6 m/s, but at least 0.5 m. C depends on the sensor and on the direction of approach
//! (`stopping/intrusion.rs`); the largest of all sensors in sets of a study holds.
//!
//! # Practice
//! What depends on devices and on the robot has no default. The defaults are what public pages tell of the
//! standards, not the standards: whoever uses them has to check them, and every report says so.

mod intrusion;

use serde::Deserialize;

use self::intrusion::{Intrusion, NORMAL_M, PARALLEL_M};
use crate::diagnostics::Place;
use crate::keys::{AxisValues, numbers};
use crate::sensor::Sensor;
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_march::metrics::Ratio;
use perirobot_march::voxel::{gap_error_m, rounded_up};

/// The walking speed of people.
const HUMAN_SPEED_M_S: f64 = 1.6;
/// The speed of arms, and up to which distance it holds.
const ARM_SPEED_M_S: f64 = 2.0;
const ARMS_UP_TO_M: f64 = 0.5;

/// Most speeds: a region may be made for each.
const MOST_SPEEDS: usize = 1000;

/// An example for whoever has none of it.
pub(super) const EXAMPLE: &str = "[stopping] formula = \"speed_and_separation\", robot_speeds_m_s = [0.25, 0.5], \
     sensor_reaction_s = 0.1, control_reaction_s = 0.05, robot_deceleration_m_s2 = 2.0, person_uncertainty_m = 0.1, \
     robot_uncertainty_m = 0.01";

/// How far people must be from the robot at each of its speeds.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct StoppingFile {
    /// Which formula says how far.
    formula: FormulaName,
    /// The edition of ISO 13855 whose formula it is, 2010 or 2024; for "iso13855".
    edition: Option<i64>,
    /// Speeds of the robot in metres a second, each above the one before.
    robot_speeds_m_s: AxisValues,
    /// How long the sensors take to tell, in seconds.
    sensor_reaction_s: f64,
    /// How long the controller takes from there to the command that stops the robot, in seconds.
    control_reaction_s: f64,
    /// How long the robot takes from there until it stands, in seconds: a number, or one for each speed. It is taken
    /// to keep its speed until then.
    robot_stopping_s: Option<AxisValues>,
    /// How the robot brakes, in metres a second squared, instead of robot_stopping_s.
    robot_deceleration_m_s2: Option<f64>,
    /// K: how fast people come, in metres a second, at any distance. Default 1.6, and 2 where the distance is then at most
    /// 0.5 m; to be checked.
    human_speed_m_s: Option<f64>,
    /// C: how far somebody reaches in before anything notices it, in metres; for "speed_and_separation" and the
    /// edition of 2010. Default the largest of all sensors in sets, to be checked: 1.2 - 0.4 H, at least 0.85, for pads and for
    /// level scanners H metres above the floor, else 0.85.
    intrusion_m: Option<f64>,
    /// D_DS: the distance that belongs to the protective device, in metres; for the edition of 2024.
    device_distance_m: Option<f64>,
    /// Z: what is added besides, in metres; for the edition of 2024.
    supplement_m: Option<f64>,
    /// Z_d: how far a person may be from where the sensors measure them, in metres; for "speed_and_separation".
    person_uncertainty_m: Option<f64>,
    /// Z_r: how far the robot may be from where its controller takes it to be, in metres; for "speed_and_separation".
    robot_uncertainty_m: Option<f64>,
}

/// A formula as in a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
enum FormulaName {
    Iso13855,
    SpeedAndSeparation,
}

/// Which formula says how far people must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formula {
    /// S = K·T + C.
    Iso13855In2010,
    /// S = K·T + D_DS + Z.
    Iso13855In2024,
    /// S = human + robot + stopping + C + Z_d + Z_r.
    SpeedAndSeparation,
}

/// How far people must be from the robot at each of its speeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Stopping {
    /// Which formula says so.
    pub formula: Formula,
    /// Each speed, the slowest first; at least one.
    pub speeds: Vec<AtSpeed>,
    terms: FormulaTerms,
    /// Defaults that nobody wrote, and values below them: what they are, and where they come from.
    defaults: Vec<String>,
    /// What is written and less than the formula asks for.
    pub(super) warnings: Vec<String>,
}

/// What a speed asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtSpeed {
    /// The speed of the robot.
    pub speed_m_s: f64,
    /// How far people must be.
    pub needed_m: f64,
}

impl AtSpeed {
    /// How far people must be, in whole nanometres, rounded up as [`perirobot_march::voxel::squared_voxels`] does.
    pub fn needed_distance(&self) -> Ratio {
        let numerator = (self.needed_m * 1e9 - 1e-3).ceil().max(0.0) as i128;
        Ratio { numerator, denominator: 1_000_000_000 }
    }
}

/// What the formulas are made of, in metres and seconds.
#[derive(Clone, Debug, PartialEq)]
struct FormulaTerms {
    /// `None` for the default, which depends on the distance.
    human_speed_m_s: Option<f64>,
    reaction_s: f64,
    brakes: Brakes,
    /// What is added whatever the speed is, with its key.
    added: Vec<(&'static str, f64)>,
}

/// How the robot comes to stand.
#[derive(Clone, Debug, PartialEq)]
enum Brakes {
    /// After a time for each speed, at full speed until then.
    After(Vec<f64>),
    /// Evenly.
    At(f64),
}

impl Formula {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Formula::Iso13855In2010 => "S = K·(T_r + T_s) + C, as public pages describe ISO 13855:2010",
            Formula::Iso13855In2024 => {
                "S = K·(T_r + T_s) + D_DS + Z, as public pages describe ISO 13855:2024"
            }
            Formula::SpeedAndSeparation => {
                "S = K·(T_r + T_s) + v·T_r + B + C + Z_d + Z_r, as public pages describe ISO/TS 15066:2016"
            }
        }
    }

    /// The keys that it has besides those of all.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Formula::Iso13855In2010 => &["intrusion_m"],
            Formula::Iso13855In2024 => &["device_distance_m", "supplement_m"],
            Formula::SpeedAndSeparation => &["intrusion_m", "person_uncertainty_m", "robot_uncertainty_m"],
        }
    }

    /// As a study names it.
    fn name(self) -> &'static str {
        match self {
            Formula::Iso13855In2010 => "formula = \"iso13855\" of 2010",
            Formula::Iso13855In2024 => "formula = \"iso13855\" of 2024",
            Formula::SpeedAndSeparation => "formula = \"speed_and_separation\"",
        }
    }
}

impl Stopping {
    /// The same with its speeds up to one of them, by its number.
    #[must_use]
    pub fn up_to(&self, speed: usize) -> Stopping {
        Stopping { speeds: self.speeds[..=speed].to_vec(), ..self.clone() }
    }

    /// The highest speed that is listed.
    pub fn fastest(&self) -> &AtSpeed {
        // There is at least one.
        &self.speeds[self.speeds.len() - 1]
    }

    /// What was assumed, sentence by sentence, for whoever reads a report.
    pub fn assumptions(&self, voxel_size_m: f64) -> Vec<String> {
        let FormulaTerms { human_speed_m_s, reaction_s, brakes, added } = &self.terms;
        let mut said = vec![format!(
            "People must be as far from the robot as {}. Check the formula and its values against your edition of \
             the standard.",
            self.formula.words()
        )];
        let each =
            self.speeds.iter().map(|at| format!("{} m at {} m/s", rounded_up(at.needed_m, 3), at.speed_m_s));
        said.push(format!("That is {}.", each.collect::<Vec<_>>().join(", ")));
        let brakes = match brakes {
            Brakes::After(times) => {
                let times: Vec<String> = times.iter().map(f64::to_string).collect();
                format!("T_s is {} s, and it keeps its speed until then", times.join(", "))
            }
            Brakes::At(deceleration) => format!("it brakes evenly with {deceleration} m/s²"),
        };
        let moves = match self.formula {
            Formula::SpeedAndSeparation => "v is its speed, and it moves by B until it stands",
            _ => "its own motion until it stands is not in the formula",
        };
        said.push(format!(
            "K is the speed of a person; the robot is commanded to stop T_r = {reaction_s:.3} s after a sensor could \
             detect one, and stands T_s later: {brakes}; {moves}."
        ));
        let added: Vec<String> =
            added.iter().map(|(key, metres)| format!("{} = {metres} m ({key})", symbol(key))).collect();
        let comes = match human_speed_m_s {
            Some(speed) => format!("{speed} m/s"),
            None => format!("{HUMAN_SPEED_M_S} m/s, up to {ARMS_UP_TO_M} m with {ARM_SPEED_M_S} m/s"),
        };
        said.push(format!("K is {comes}; added are {}.", added.join(", ")));
        said.extend(self.to_be_checked());
        said.push(format!(
            "Distances are between centres of voxels, and sizes are rounded: the gap between surfaces may be up to \
             {:.2} m less, also at a speed that is allowed.",
            gap_error_m(voxel_size_m)
        ));
        said
    }

    /// Defaults that nobody wrote, and values that are less than public pages tell, each a sentence.
    pub fn to_be_checked(&self) -> impl Iterator<Item = String> {
        self.defaults.iter().map(|default| format!("To be checked: {default}."))
    }
}

/// The floor above which heights of scanners are measured.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StandingFloor {
    pub(super) z_m: f64,
    /// Whether people walk on floors of other heights as well.
    pub(super) is_auto: bool,
}

/// Checks the table, for the sensors of a study and its floor.
pub(super) fn check(
    at: &Place,
    file: StoppingFile,
    sensors: &[Sensor],
    floor: StandingFloor,
) -> Result<Stopping> {
    let at = &at.key("stopping");
    let formula = formula(at, &file)?;
    refuse_others(at, &file, formula)?;
    let mut defaults = Vec::new();
    let time = |key: &str, value: f64| at.number(key, value, 0.0..=60.0, "a time in seconds from 0 to 60");
    let reaction_s = time("sensor_reaction_s", file.sensor_reaction_s)?
        + time("control_reaction_s", file.control_reaction_s)?;
    let speeds = numbers(at, "robot_speeds_m_s", &file.robot_speeds_m_s)?;
    if speeds.len() > MOST_SPEEDS {
        let issue = Issue::too_large(format!("robot_speeds_m_s has {} speeds", speeds.len()));
        return Err(
            at.wrap(issue.with_advice(format!("at most {MOST_SPEEDS} are possible: take a larger step")))
        );
    }
    for &speed in &speeds {
        at.number("robot_speeds_m_s", speed, f64::MIN_POSITIVE..=20.0, "speeds in m/s above 0 and up to 20")?;
    }
    if !speeds.is_sorted_by(|slower, faster| slower < faster) {
        return Err(at.wrong("robot_speeds_m_s", format!("{speeds:?}"), "each must be above the one before"));
    }
    let brakes = brakes(at, &file, speeds.len())?;
    let speed_rule = "a speed in m/s above 0 and up to 10";
    let human_speed_m_s = file
        .human_speed_m_s
        .map(|speed| at.number("human_speed_m_s", speed, f64::MIN_POSITIVE..=10.0, speed_rule));
    let human_speed_m_s = human_speed_m_s.transpose()?;
    if human_speed_m_s.is_none() {
        defaults.push(format!(
            "human_speed_m_s = {HUMAN_SPEED_M_S} is a default, what public pages tell of ISO 13855 as the speed of somebody who \
             walks; where the distance is at most {ARMS_UP_TO_M} m it is {ARM_SPEED_M_S}, that of an arm"
        ));
    }
    let intrusions: Vec<Intrusion> =
        sensors.iter().filter_map(|sensor| Intrusion::new(sensor, floor.z_m)).collect();
    let farther = |a: &&Intrusion, b: &&Intrusion| a.metres().total_cmp(&b.metres());
    let farthest = intrusions.iter().max_by(farther);
    let parallel = intrusions.iter().find(|one| one.is_parallel());
    let (mut added, mut warnings) = (Vec::new(), Vec::new());
    for &key in formula.keys() {
        // What public pages tell of a key, of which edition, and for which sensor.
        let told = match key {
            "intrusion_m" => Some((farthest.map_or(NORMAL_M, Intrusion::metres), 2010, farthest)),
            "device_distance_m" => {
                Some((parallel.map_or(NORMAL_M, |_| PARALLEL_M), 2024, parallel.or(farthest)))
            }
            _ => None,
        };
        let source = |edition: u32, sensor: Option<&Intrusion>| {
            let case =
                sensor.map_or("a device that an arm passes unnoticed".to_string(), Intrusion::to_string);
            format!("public pages tell of ISO 13855:{edition} for {case}")
        };
        let metres = match (file.extra(key), told) {
            (Some(metres), Some((least_m, edition, sensor))) if metres < least_m => {
                let (least, source) = (rounded_up(least_m, 2), source(edition, sensor));
                let less = format!("{key} = {metres} is less than the {least} m that {source}");
                if sensor.is_some_and(Intrusion::is_parallel) {
                    warnings.push(format!("stopping: {less}: distances may be too small"));
                }
                defaults.push(less);
                metres
            }
            (Some(metres), _) => metres,
            (None, Some((least_m, edition, sensor))) if key == "intrusion_m" => {
                let (least, source) = (rounded_up(least_m, 2), source(edition, sensor));
                let mut others = describe_sensors(&intrusions, least_m);
                if floor.is_auto && least_m < PARALLEL_M && parallel.is_some() {
                    others += "; heights are measured from z 0 only, also with floor = \"auto\": for people on a platform \
                               the plane is lower and C is larger, so write intrusion_m for them";
                }
                defaults.push(format!("{key} = {least} is a default, what {source}{others}"));
                least_m
            }
            (None, _) => {
                let cure = format!("{} needs it, also where it is 0, as in {key} = 0.1", formula.name());
                return Err(at.wrap(Issue::missing(key)).with_advice(cure));
            }
        };
        added.push((key, at.number(key, metres, 0.0..=100.0, "a length in metres from 0 to 100")?));
    }
    let terms = FormulaTerms { human_speed_m_s, reaction_s, brakes, added };
    let at_speed = |(number, speed_m_s)| AtSpeed {
        speed_m_s,
        needed_m: whole_nm(terms.needed_m(formula, number, speed_m_s)),
    };
    let by_default = FormulaTerms { human_speed_m_s: None, ..terms.clone() };
    let is_less = |(number, speed_m_s): &(usize, f64)| {
        terms.needed_m(formula, *number, *speed_m_s) < by_default.needed_m(formula, *number, *speed_m_s)
    };
    if let (Some(human), Some(slowest)) = (human_speed_m_s, speeds.iter().copied().enumerate().find(is_less))
    {
        let [written, told] =
            [&terms, &by_default].map(|terms| terms.needed_m(formula, slowest.0, slowest.1));
        defaults.push(format!(
            "human_speed_m_s = {human} makes {} m at {} m/s, where public pages tell {} m: {HUMAN_SPEED_M_S} m/s of somebody who \
             walks, {ARM_SPEED_M_S} m/s of an arm up to {ARMS_UP_TO_M} m",
            rounded_up(written, 3),
            slowest.1,
            rounded_up(told, 3)
        ));
    }
    let speeds = speeds.into_iter().enumerate().map(at_speed).collect();
    Ok(Stopping { formula, speeds, terms, defaults, warnings })
}

/// What the standards call a key's length.
fn symbol(key: &str) -> &'static str {
    match key {
        "device_distance_m" => "D_DS",
        "supplement_m" => "Z",
        "person_uncertainty_m" => "Z_d",
        "robot_uncertainty_m" => "Z_r",
        _ => "C",
    }
}

/// Metres rounded up to whole nanometres, without the noise of additions: 1.288, not 1.2880000000000003.
fn whole_nm(metres: f64) -> f64 {
    (metres * 1e9 - 1e-3).ceil() / 1e9
}

/// Which sensors ask for less than the farthest intrusion, in words.
fn describe_sensors(intrusions: &[Intrusion], least_m: f64) -> String {
    let less = intrusions.iter().filter(|one| one.metres() < least_m);
    let less: Vec<String> = less.map(|one| format!("{} for {one}", rounded_up(one.metres(), 2))).collect();
    match less.is_empty() {
        true => String::new(),
        false => format!("; it would be {}, and the largest holds for all", less.join(", ")),
    }
}

impl FormulaTerms {
    /// How far people must be at a speed, which has this number.
    fn needed_m(&self, formula: Formula, number: usize, speed_m_s: f64) -> f64 {
        let (stopping_s, stopping_m) = match &self.brakes {
            Brakes::After(times) => {
                let time = times[if times.len() == 1 { 0 } else { number }];
                (time, speed_m_s * time)
            }
            Brakes::At(deceleration) => {
                (speed_m_s / deceleration, speed_m_s * speed_m_s / (2.0 * deceleration))
            }
        };
        let robot_m = match formula {
            Formula::SpeedAndSeparation => speed_m_s * self.reaction_s + stopping_m,
            _ => 0.0,
        };
        let time_s = self.reaction_s + stopping_s;
        let with = |human_m_s: f64| {
            human_m_s * time_s + robot_m + self.added.iter().map(|(_, metres)| metres).sum::<f64>()
        };
        match self.human_speed_m_s {
            Some(speed) => with(speed),
            None if with(ARM_SPEED_M_S) <= ARMS_UP_TO_M => with(ARM_SPEED_M_S),
            None => with(HUMAN_SPEED_M_S).max(ARMS_UP_TO_M),
        }
    }
}

impl StoppingFile {
    /// The value of a key that only some formulas have.
    fn extra(&self, key: &str) -> Option<f64> {
        let known = [
            ("intrusion_m", self.intrusion_m),
            ("device_distance_m", self.device_distance_m),
            ("supplement_m", self.supplement_m),
            ("person_uncertainty_m", self.person_uncertainty_m),
            ("robot_uncertainty_m", self.robot_uncertainty_m),
        ];
        known.into_iter().find(|(name, _)| *name == key).and_then(|(_, value)| value)
    }
}

fn formula(at: &Place, file: &StoppingFile) -> Result<Formula> {
    match (file.formula, file.edition) {
        (FormulaName::Iso13855, Some(2010)) => Ok(Formula::Iso13855In2010),
        (FormulaName::Iso13855, Some(2024)) => Ok(Formula::Iso13855In2024),
        (FormulaName::Iso13855, Some(other)) => Err(at.wrong("edition", other, "must be 2010 or 2024")),
        (FormulaName::Iso13855, None) => Err(at
            .wrap(Issue::missing("edition"))
            .with_advice("say which edition of ISO 13855 is meant: edition = 2010, or 2024")),
        (FormulaName::SpeedAndSeparation, None) => Ok(Formula::SpeedAndSeparation),
        (FormulaName::SpeedAndSeparation, Some(edition)) => {
            Err(at.wrong("edition", edition, "belongs to formula = \"iso13855\": leave it out"))
        }
    }
}

/// Refuses keys that the formula does not have, which would change nothing.
fn refuse_others(at: &Place, file: &StoppingFile, formula: Formula) -> Result<()> {
    let all = [Formula::Iso13855In2010, Formula::Iso13855In2024, Formula::SpeedAndSeparation];
    for key in all.iter().flat_map(|other| other.keys()).filter(|key| !formula.keys().contains(key)) {
        if let Some(value) = file.extra(key) {
            let rule = format!("{} has no such term: it has {}", formula.name(), formula.keys().join(", "));
            return Err(at.wrong(key, value, &rule));
        }
    }
    Ok(())
}

fn brakes(at: &Place, file: &StoppingFile, speeds: usize) -> Result<Brakes> {
    let one = "give how long the robot takes to stand, or how it brakes";
    match (&file.robot_stopping_s, file.robot_deceleration_m_s2) {
        (Some(_), Some(_)) => Err(at
            .says("both robot_stopping_s and robot_deceleration_m_s2")
            .with_advice(format!("{one}, not both"))),
        (None, None) => Err(at.says("neither robot_stopping_s nor robot_deceleration_m_s2").with_advice(one)),
        (None, Some(deceleration)) => {
            let rule = "a deceleration in m/s² above 0 and up to 1000";
            at.number("robot_deceleration_m_s2", deceleration, 1e-3..=1e3, rule).map(Brakes::At)
        }
        (Some(times), None) => {
            let times = numbers(at, "robot_stopping_s", times)?;
            for &time in &times {
                at.number("robot_stopping_s", time, 0.0..=60.0, "times in seconds from 0 to 60")?;
            }
            if !times.is_sorted() {
                return Err(at.wrong(
                    "robot_stopping_s",
                    format!("{times:?}"),
                    "none may be below the one before",
                ));
            }
            if times.len() != 1 && times.len() != speeds {
                let rule = format!("must be one number, or one for each of the {speeds} speeds");
                return Err(at.wrong("robot_stopping_s", format!("{times:?}"), &rule));
            }
            Ok(Brakes::After(times))
        }
    }
}

#[cfg(test)]
mod tests;
