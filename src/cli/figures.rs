//! `perirobot figures`: figures for print from finished sweeps.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use perirobot_decide::choose::as_swept;
use perirobot_march::metrics::Score;
use perirobot_march::{Error, Result};
use perirobot_page::report::figures::{FigureKind, FigurePage, FigurePlan, FiguredSweep, PAGE, WantedPart};
use perirobot_sweep::results::Results;
use perirobot_sweep::results::files::OutputFolder;
use perirobot_sweep::results::manifest::Manifest;

use super::backend::BackendArgs;
use super::packages::PackageArgs;
use super::progress::ProgressArgs;
use super::score::ScoreArg;
use super::swept::{StudyPlace, study_of};

/// Draw the paper's kinds of figures from sweeps, for print
///
/// For each folder of results, writes SVG files (no scripts, text as text, colours for colour-blind readers):
/// distributions of the scores over all poses; maps of walls, ceiling and floor with the best score of each place; the
/// maxima of each combination of sensors; scores of the best placements over the snapshots of moving scenes. Also
/// pictures (.png) of each scene and of the best placements. README.md lists the figures with their contents and the
/// command that made their numbers. Empty figures are left out, and README.md explains why.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    /// Folders written by `perirobot sweep` or `perirobot choose`; their studies must be unchanged and in the same
    /// place
    #[arg(value_name = "DIR", required = true)]
    folders: Vec<PathBuf>,
    /// Folder for the figures, with one below it for each DIR; created if needed. Files of the same names are replaced
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Only figures of this kind; repeat it for more
    #[arg(long, value_enum, value_name = "KIND")]
    only: Vec<KindArg>,
    /// Only this region
    #[arg(long, value_name = "NAME")]
    region: Option<String>,
    /// Only this combination (for a sensor alone, its name)
    #[arg(long, value_name = "NAME")]
    combination: Option<String>,
    /// Only this representation, as in results.csv; maxima always cover all
    #[arg(long, value_name = "NAME")]
    representation: Option<String>,
    /// Only this scene [default: the mean of all, and each of up to 12]
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Only this score [default: f1 and kappa, side by side]
    #[arg(long, value_enum)]
    score: Option<ScoreArg>,
    #[command(flatten)]
    packages: PackageArgs,
    #[command(flatten)]
    backend: BackendArgs,
    #[command(flatten)]
    progress: ProgressArgs,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot sweep scenes/quick.toml --out out/quick
  perirobot figures out/quick --out out/figures
      out/figures/README.md shows all
  perirobot figures out/quick --out out/maps --only placements --region robot
      one map for each sensor, F1 and kappa side by side";

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum KindArg {
    /// Box plots of the scores over all poses
    Distributions,
    /// Maps of places, coloured by score
    Placements,
    /// The best score of each combination
    Maxima,
    /// Scores of the best placements over the snapshots of moving scenes
    Snapshots,
    /// Pictures of scenes and of the best placements
    Pictures,
}

impl KindArg {
    fn kind(self) -> FigureKind {
        match self {
            KindArg::Distributions => FigureKind::Distributions,
            KindArg::Placements => FigureKind::Placements,
            KindArg::Maxima => FigureKind::Maxima,
            KindArg::Snapshots => FigureKind::Snapshots,
            KindArg::Pictures => FigureKind::Pictures,
        }
    }
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    super::stop::end_tidily()?;
    args.backend.start_threads()?;
    let kinds: Vec<FigureKind> = match args.only.is_empty() {
        true => FigureKind::ALL.into(),
        false => args.only.iter().map(|only| only.kind()).collect(),
    };
    let wanted = WantedPart {
        kinds,
        region: args.region.as_deref(),
        combination: args.combination.as_deref(),
        representation: args.representation.as_deref(),
        scene: args.scene.as_deref(),
        scores: args.score.map_or(&[Score::F1, Score::Kappa][..], ScoreArg::scores),
    };
    // Everything is read and checked before any file is written.
    let mut sweeps: Vec<FiguredSweep> = Vec::new();
    for folder in &args.folders {
        let name = name_of(folder)?;
        // Some file systems ignore case.
        if let Some(known) = sweeps.iter().find(|known| known.name.to_lowercase() == name.to_lowercase()) {
            let what = format!(
                "another folder is also called {}, so their figures would have the same names",
                known.name
            );
            return Err(Error::input(folder, what).with_advice("rename one, or draw them one by one"));
        }
        sweeps.push(args.read(folder, name)?);
    }
    let each = sweeps.iter().zip(&args.folders);
    let plans = each.map(|(sweep, folder)| FigurePlan::new(sweep, &wanted).map_err(|e| e.with_place(folder)));
    let plans: Vec<FigurePlan> = plans.collect::<Result<_>>()?;
    let mut backend = args.backend.open()?;
    let mut page = FigurePage::default();
    let out = OutputFolder::open(&args.out)?;
    let all: usize = plans.iter().map(FigurePlan::count).sum();
    let mut progress = args.progress.start("figures", 0, all as u64);
    for (sweep, plan) in sweeps.iter().zip(&plans) {
        let below = OutputFolder::open(&args.out.join(&sweep.name))?;
        let mut figures = Vec::new();
        for number in 0..plan.count() {
            let figure = plan.draw(number, &mut *backend)?;
            below.write(&figure.file, &figure.bytes)?;
            figures.push(figure);
            progress.inc(1);
        }
        page.add(sweep, &figures, &plan.left_out);
    }
    progress.finish();
    out.write(PAGE, page.finish().as_bytes())?;
    super::print(&format!("{all} figures in {}, listed in {PAGE}\n", out.path().display()))?;
    Ok(ExitCode::SUCCESS)
}

fn name_of(folder: &Path) -> Result<String> {
    let whole = folder.canonicalize().unwrap_or_else(|_| folder.into());
    let name = whole.file_name().map(|name| name.to_string_lossy().into_owned());
    name.ok_or_else(|| Error::input(folder, "has no name: name the folder of a sweep"))
}

impl Args {
    fn read(&self, folder: &Path, name: String) -> Result<FiguredSweep> {
        let (results, warnings) = Results::read(folder)?;
        for warning in warnings {
            say!("warning: {warning}");
        }
        let manifest = Manifest::read(folder)?;
        let (study, worlds) = study_of(folder, StudyPlace { named: None, cure: "" }, &self.packages)?;
        let (study, worlds) = as_swept(folder, study, worlds)?;
        Ok(FiguredSweep { name, results, manifest, study, worlds })
    }
}
