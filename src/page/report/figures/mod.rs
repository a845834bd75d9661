//! Figures for print from finished sweeps, of any study: the kinds in the paper's experiments. Each is an SVG file
//! without scripts, or a picture by `render`; a page lists them with their contents.
//!
//! # Practice
//! The numbers are those of `summary`, from the same functions. A figure's bytes depend only on the sweep.

mod curves;
mod distributions;
mod map;
mod maxima;
mod names;
mod paper;
mod part;
mod pictures;
mod placements;
mod readme;

use crate::export::file_name;
pub use part::WantedPart;
use part::{SceneRange, SweepPart};
use perirobot_march::Result;
use perirobot_march::backend::Backend;
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::manifest::Manifest;
use pictures::Pictured;
use placements::PlacedSeries;
pub use readme::{FigurePage, PAGE};

/// A finished sweep, its study and its scenes.
pub struct FiguredSweep {
    /// Its name, which is also the folder of its figures.
    pub name: String,
    /// Its results.
    pub results: Results,
    /// Its manifest.
    pub manifest: Manifest,
    /// The study of the sweep.
    pub study: Study,
    /// Its scenes at all moments.
    pub worlds: Vec<World>,
}

/// A kind of figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FigureKind {
    /// Distributions of scores over the choices of poses.
    Distributions,
    /// Scores of places.
    Placements,
    /// The best score of each combination.
    Maxima,
    /// Scores of the best choices over the moments of a scene.
    Snapshots,
    /// Scenes, and the labels of the best choices.
    Pictures,
}

impl FigureKind {
    /// All kinds, in the order of the page.
    pub const ALL: [FigureKind; 5] = [
        FigureKind::Distributions,
        FigureKind::Placements,
        FigureKind::Maxima,
        FigureKind::Snapshots,
        FigureKind::Pictures,
    ];

    /// Its name in the names of files.
    fn name(self) -> &'static str {
        match self {
            FigureKind::Distributions => "distributions",
            FigureKind::Placements => "placements",
            FigureKind::Maxima => "maxima",
            FigureKind::Snapshots => "snapshots",
            FigureKind::Pictures => "picture",
        }
    }
}

/// A figure, ready to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its kind.
    pub kind: FigureKind,
    /// The name of its file.
    pub file: String,
    /// Its contents, in a sentence or two.
    pub caption: String,
    /// The file.
    pub bytes: Vec<u8>,
}

/// Figures that are not drawn, with the reason.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Their kind.
    pub kind: FigureKind,
    /// The reason.
    pub why: String,
}

/// The figures of a sweep that will be drawn.
pub struct FigurePlan<'a> {
    sweep: &'a FiguredSweep,
    part: SweepPart,
    jobs: Vec<(String, FigureJob)>,
    /// The omitted figures.
    pub left_out: Vec<LeftOut>,
}

/// The contents of one figure.
enum FigureJob {
    Distributions { region: usize },
    Placements { region: usize, placed: PlacedSeries },
    Maxima { region: usize },
    Snapshots { region: usize, scene: usize },
    Picture(Pictured),
}

impl FigureJob {
    fn kind(&self) -> FigureKind {
        match self {
            FigureJob::Distributions { .. } => FigureKind::Distributions,
            FigureJob::Placements { .. } => FigureKind::Placements,
            FigureJob::Maxima { .. } => FigureKind::Maxima,
            FigureJob::Snapshots { .. } => FigureKind::Snapshots,
            FigureJob::Picture(_) => FigureKind::Pictures,
        }
    }
}

/// The reason against figures of single scenes.
const TOO_MANY: &str = "there are more than 12 scenes: name one of them to draw it";

impl<'a> FigurePlan<'a> {
    /// The figures of a sweep.
    ///
    /// # Errors
    /// If the sweep lacks a requested part; lists the existing ones.
    pub fn new(sweep: &'a FiguredSweep, wanted: &WantedPart) -> Result<FigurePlan<'a>> {
        let part = SweepPart::new(&sweep.results, wanted)?;
        let mut plan = FigurePlan { sweep, part, jobs: Vec::new(), left_out: Vec::new() };
        for kind in FigureKind::ALL.into_iter().filter(|kind| wanted.kinds.contains(kind)) {
            match kind {
                FigureKind::Distributions => plan.each_region(|region| FigureJob::Distributions { region }),
                FigureKind::Placements => plan.placements(),
                FigureKind::Maxima if sweep.results.combinations.len() < 2 => {
                    plan.leave_out(kind, "the study has one combination of sensors only");
                }
                FigureKind::Maxima => plan.each_region(|region| FigureJob::Maxima { region }),
                FigureKind::Snapshots => plan.snapshots(),
                FigureKind::Pictures => plan.pictures()?,
            }
        }
        Ok(plan)
    }

    /// The number of figures.
    pub fn count(&self) -> usize {
        self.jobs.len()
    }

    /// Draws a figure by its index.
    pub fn draw(&self, number: usize, backend: &mut dyn Backend) -> Result<Figure> {
        let (file, job) = &self.jobs[number];
        let (sweep, part) = (self.sweep, &self.part);
        let (caption, bytes) = match job {
            FigureJob::Distributions { region } => distributions::draw(&sweep.results, part, *region)?,
            FigureJob::Placements { region, placed } => placements::draw(sweep, part, *region, placed)?,
            FigureJob::Maxima { region } => maxima::draw(&sweep.results, part, *region)?,
            FigureJob::Snapshots { region, scene } => curves::draw(&sweep.results, part, *region, *scene)?,
            FigureJob::Picture(pictured) => pictures::draw(sweep, pictured, backend)?,
        };
        Ok(Figure { kind: job.kind(), file: file.clone(), caption, bytes })
    }

    fn add(&mut self, words: &[&str], job: FigureJob) {
        let ending = if job.kind() == FigureKind::Pictures { "png" } else { "svg" };
        let all: Vec<String> = words.iter().map(|word| file_name(word)).collect();
        let name = format!("{}-{}", job.kind().name(), all.join("-"));
        let again = (2..).map(|n| format!("{name}-{n}.{ending}"));
        // Some file systems ignore case.
        let is_free =
            |file: &String| !self.jobs.iter().any(|(known, _)| known.to_lowercase() == file.to_lowercase());
        let file = std::iter::once(format!("{name}.{ending}")).chain(again).find(is_free);
        self.jobs.extend(file.map(|file| (file, job)));
    }

    fn leave_out(&mut self, kind: FigureKind, why: impl Into<String>) {
        self.left_out.push(LeftOut { kind, why: why.into() });
    }

    fn each_region(&mut self, job: impl Fn(usize) -> FigureJob) {
        for region in self.part.regions.clone() {
            self.add(&[&self.sweep.results.regions[region]], job(region));
        }
    }

    fn placements(&mut self) {
        let (results, mut without) = (&self.sweep.results, Vec::new());
        for series in self.part.series.clone() {
            let combination = &results.combinations[series.combination];
            let Some(placed) = PlacedSeries::new(&self.sweep.study, &self.sweep.worlds[0], series) else {
                if !without.contains(&combination.name) {
                    without.push(combination.name.clone());
                }
                continue;
            };
            let representation = &combination.representations[series.representation];
            for region in self.part.regions.clone() {
                let words = [&results.regions[region], &combination.name, representation];
                self.add(
                    &words.map(String::as_str),
                    FigureJob::Placements { region, placed: placed.clone() },
                );
            }
        }
        if !without.is_empty() {
            let names = without.join(", ");
            let why = format!("a map needs one sensor with several places in the world, unlike: {names}");
            self.leave_out(FigureKind::Placements, why);
        }
    }

    fn snapshots(&mut self) {
        let results = &self.sweep.results;
        let scenes: Vec<usize> = self.part.extents.iter().filter_map(|extent| extent.scene).collect();
        let too_many = scenes.is_empty();
        let moves = |scene: &usize| results.scenes[*scene].moments.len() > 1;
        let moving: Vec<usize> = scenes.into_iter().filter(moves).collect();
        if moving.is_empty() {
            let why = if too_many { TOO_MANY } else { "no scene moves" };
            self.leave_out(FigureKind::Snapshots, why);
        }
        for region in self.part.regions.clone() {
            for &scene in &moving {
                let words = [&results.regions[region], &results.scenes[scene].name];
                self.add(&words.map(String::as_str), FigureJob::Snapshots { region, scene });
            }
        }
    }

    fn pictures(&mut self) -> Result<()> {
        let scenes: Vec<usize> = self.part.extents.iter().filter_map(|extent| extent.scene).collect();
        if scenes.is_empty() {
            self.leave_out(FigureKind::Pictures, format!("of the scenes, {TOO_MANY}"));
        }
        for scene in scenes {
            self.add(
                &["scene", &self.sweep.results.scenes[scene].name],
                FigureJob::Picture(Pictured::Scene(scene)),
            );
        }
        for (words, pictured) in pictures::best(&self.sweep.results, &self.part)? {
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            self.add(&words, FigureJob::Picture(pictured));
        }
        Ok(())
    }
}
