//! `perirobot field`: the largest field of a scanner that the environment does not trip.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_study::input::Study;
use perirobot_study::world::{Contour, ContourRay, ContourRule};
use perirobot_sweep::results::files::{OutputFolder, write_whole};

use super::stop::end_tidily;
use super::study::StudyArgs;

/// Draw the largest scanner field that walls do not trip
///
/// Casts the level ring of a safety scanner at one pose against the environment alone, without people and robots, at
/// every moment of every scene, and writes the contour that is always clear as corners x_m,y_m in the scanner's frame.
/// To use it in the study, name the file as `polygon` in the sensor's field. Rays at which the environment would trip
/// the field are shortened.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    /// The scanner [default: the study's only sensor of kind "lidar"]
    #[arg(long, value_name = "NAME")]
    sensor: Option<String>,
    /// Its pose, group/candidate, as `perirobot check` lists it [default: its only one]
    #[arg(long, value_name = "POSE")]
    pose: Option<String>,
    /// Draw the field of this case of its field_cases, at the moments at which it counts [default: the field that counts
    /// when no case applies]
    #[arg(long, value_name = "NAME")]
    case: Option<String>,
    /// Distance between the end of the field and the environment, in metres
    #[arg(long, value_name = "METRES", default_value_t = 0.1, conflicts_with = "reference")]
    margin: f64,
    /// Largest reach of the field, in metres [default: the scanner's range]
    #[arg(long, value_name = "METRES")]
    at_most: Option<f64>,
    /// Write the reference contour instead: the hits of the rays on the environment, without margin
    #[arg(long)]
    reference: bool,
    /// The .csv file to write; its folder is created if needed, an older file is replaced [default: beside the study,
    /// its name and -field.csv or -reference.csv]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    study: StudyArgs,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot field scenes/sensors.toml --sensor scanner --pose floor/bench \\
    --at-most 3 --out out/field.csv
      the largest field of a scanner on the floor
  perirobot field scenes/sensors.toml --sensor scanner --pose floor/bench \\
    --reference --out out/reference.csv
      the contour of the walls, to detect that the scanner was moved

In the study:
  field = { polygon = \"field.csv\", height_m = 1.8 }";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    end_tidily()?;
    let rule = args.rule()?;
    let out = args.out.clone().unwrap_or_else(|| args.usual_out());
    if out.extension().is_none_or(|extension| extension != "csv") {
        return Err(Issue::says(format!("--out {}: must end in .csv", out.display())).into());
    }
    let (study, worlds) = args.study.load()?;
    let sensor = args.find_sensor(&study)?;
    let candidate = args.find_pose(&study, sensor)?;
    let contour = Contour::new(&study, &worlds, [sensor, candidate], &rule)?;
    // If nothing can be written, a folder created here is removed again.
    let inside = out.parent().filter(|folder| !folder.as_os_str().is_empty());
    let _folder = inside.map(OutputFolder::open).transpose()?;
    write_whole(&out, contour.to_csv().as_bytes())?;
    let title =
        format!("{}:{}", study.sensors[sensor].name, study.sensors[sensor].candidates[candidate].name);
    super::print(&describe(&contour, &rule, &title, worlds.len()))?;
    super::print(&format!("{} corners in {}\n", contour.corners_mm.len(), out.display()))?;
    if !rule.is_reference {
        let named = out.strip_prefix(args.study.folder()).unwrap_or(&out).display().to_string();
        let height_m = contour.height_m;
        let words = match &rule.case {
            None => format!("in the study: field = {{ polygon = {named:?}, height_m = {height_m} }}\n"),
            Some(case) => format!("in the study, in field_cases {case:?}: polygon = {named:?}\n"),
        };
        super::print(&words)?;
    }
    let words = ["perirobot", "check"].map(String::from);
    super::print_next(&[words.as_slice(), &args.study.words()].concat())?;
    Ok(ExitCode::SUCCESS)
}

/// The contour in words.
fn describe(contour: &Contour, rule: &ContourRule, title: &str, moments: usize) -> String {
    let what = if rule.is_reference { "reference contour" } else { "field" };
    let case = rule.case.as_ref().map_or(String::new(), |case| format!(", case {case:?},"));
    let over = match contour.moments {
        _ if moments == 1 => String::new(),
        all if all == moments => format!(" over {moments} moments"),
        some => format!(" over {some} of {moments} moments"),
    };
    let mut text = format!("{what} of {title}{case}{over}: {:.2} m²\n", contour.area_m2());
    let ray = |ray: &ContourRay| {
        let ended = ray.limit.as_ref().map_or("by range".into(), |name| format!("by {name:?}"));
        format!("{:.3} m at {:.1}°, limited {ended}\n", ray.reach_m, ray.azimuth_deg + 0.0)
    };
    text += &format!("  shortest ray {}", ray(&contour.shortest));
    text += &format!("  longest ray  {}", ray(&contour.longest));
    if !rule.is_reference {
        let what = "rays shortened because the environment tripped the field";
        text += &format!("  {what}: {}\n", contour.shortened);
    }
    if contour.every > 1 {
        text += &format!("  one corner for each {} rays\n", contour.every);
    }
    text
}

impl Args {
    fn rule(&self) -> Result<ContourRule> {
        if !(0.0..=100.0).contains(&self.margin) {
            return Err(Issue::says(format!("--margin {}: must be from 0 to 100 metres", self.margin)).into());
        }
        if let Some(wrong) = self.at_most.filter(|most| !(0.05..=1000.0).contains(most)) {
            return Err(Issue::says(format!("--at-most {wrong}: must be from 0.05 to 1000 metres")).into());
        }
        let case = self.case.clone();
        Ok(ContourRule { margin_m: self.margin, at_most_m: self.at_most, is_reference: self.reference, case })
    }

    fn usual_out(&self) -> PathBuf {
        let ending = if self.reference { "reference.csv" } else { "field.csv" };
        let plain = |c: char| if c.is_alphanumeric() { c } else { '-' };
        let case: String =
            self.case.iter().flat_map(|case| "-".chars().chain(case.chars().map(plain))).collect();
        let name = self.study.usual_out(&format!("{case}-{ending}"));
        self.study.folder().join(name.file_name().map(Path::new).unwrap_or(&name))
    }

    fn find_sensor(&self, study: &Study) -> Result<usize> {
        let scanners: Vec<usize> =
            (0..study.sensors.len()).filter(|&s| study.sensors[s].kind.as_scanner().is_some()).collect();
        let known: Vec<&str> = scanners.iter().map(|&sensor| study.sensors[sensor].name.as_str()).collect();
        let found = match (&self.sensor, &scanners[..]) {
            (Some(name), _) => study.sensors.iter().position(|sensor| sensor.name == *name),
            (None, [only]) => Some(*only),
            (None, []) => {
                return Err(Issue::says("the study has no scanner: add a sensor of kind \"lidar\"").into());
            }
            (None, _) => {
                let what = format!(
                    "the study has several scanners: choose one by --sensor; expected one of {known:?}"
                );
                return Err(Issue::says(what).into());
            }
        };
        found.ok_or_else(|| unknown_name("--sensor", self.sensor.as_deref(), &known))
    }

    fn find_pose(&self, study: &Study, sensor: usize) -> Result<usize> {
        let candidates = &study.sensors[sensor].candidates;
        let known: Vec<&str> = candidates.iter().map(|candidate| candidate.name.as_str()).collect();
        let found = match (&self.pose, candidates.len()) {
            (Some(name), _) => known.iter().position(|known| known == name),
            (None, 1) => Some(0),
            (None, count) => {
                let name = &study.sensors[sensor].name;
                let few = &known[..count.min(FEW)];
                let what = format!(
                    "sensor {name:?} has {count} poses: choose one by --pose, for example one of {few:?}"
                );
                return Err(Issue::says(what).into());
            }
        };
        found.ok_or_else(|| unknown_name("--pose", self.pose.as_deref(), &known))
    }
}

/// The most names in a message.
const FEW: usize = 10;

fn unknown_name(flag: &str, wrong: Option<&str>, known: &[&str]) -> perirobot_march::Error {
    let (wrong, few) = (wrong.unwrap_or_default(), &known[..known.len().min(FEW)]);
    let more = if known.len() > FEW { format!(" and {} more", known.len() - FEW) } else { String::new() };
    Issue::says(format!("{flag} {wrong:?}: unknown name; expected one of {few:?}{more}")).into()
}
