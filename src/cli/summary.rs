//! `perirobot summary`: the tables behind the paper's figures, from the folder of a sweep.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use perirobot::Result;
use perirobot::report::{Results, Score, Selection, distribution, groups, maxima, snapshots};

/// Print the tables behind the paper's figures from a sweep
///
/// Reads counts.journal, poses.csv and manifest.json of an output folder and prints, as far as they apply: how the scores
/// of all choices of poses are distributed (per scene, region, combination and representation, beside the baselines of
/// the region); the maximum of each combination of sensors, and its part of what the largest combination reaches; the
/// best pose of each group of poses (a wall, the ceiling); the best choices over the snapshots of moving scenes, by mean
/// and by worst.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    /// Folder that `perirobot sweep --out` has written
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Only this region
    #[arg(long, value_name = "NAME")]
    region: Option<String>,
    /// Only this combination (a sensor alone has its own name)
    #[arg(long, value_name = "NAME")]
    combination: Option<String>,
    /// Only this score [default: f1 and kappa]
    #[arg(long, value_enum)]
    score: Option<Choice>,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot sweep scenes/quick.toml --out out/quick
  perirobot summary out/quick
      all tables that apply
  perirobot summary out/quick --region human --score f1
      one score in one region

How to read it:
  A score without a value (nothing of the kind is in the region) is a dash, and
  is left out of means, never 0.
  Hold every score against the baselines: a sensor stuck at `occupied` has a
  better F1 than many poses.
  The same numbers for pandas, one row a choice of poses: scores.csv in the
  folder.";

#[derive(Clone, Copy, PartialEq, ValueEnum)]
#[value(rename_all = "snake_case")]
enum Choice {
    /// 2TP / (2TP + FP + FN + UF + UO)
    F1,
    /// Cohen's kappa over occupied, free, unknown
    Kappa,
    /// Share of people's voxels that are hit, or that a presence sensor feels
    HumanSeen,
    /// Share of people's voxels that are labelled occupied, rightly or by noise; with false_alarm beside it
    HumanClaimed,
    /// Share of people of whom a part is detected, or whom a presence sensor feels
    PeopleDetected,
    /// Share of people's body parts that are detected
    PartsDetected,
    /// Share of the region that stays unknown
    Unknown,
    /// Share of the free voxels with a label that are called occupied
    FalseAlarm,
}

impl Choice {
    /// The tables that it stands for: a claimed share says nothing without its false alarms.
    fn scores(self) -> &'static [Score] {
        match self {
            Choice::F1 => &[Score::F1],
            Choice::Kappa => &[Score::Kappa],
            Choice::HumanSeen => &[Score::HumanSeen],
            Choice::HumanClaimed => &[Score::HumanClaimed, Score::FalseAlarm],
            Choice::PeopleDetected => &[Score::PeopleDetected],
            Choice::PartsDetected => &[Score::PartsDetected],
            Choice::Unknown => &[Score::Unknown],
            Choice::FalseAlarm => &[Score::FalseAlarm],
        }
    }
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let (results, warnings) = Results::read(&args.folder)?;
    for warning in warnings {
        say!("warning: {warning}");
    }
    let scores = args.score.map_or(&[Score::F1, Score::Kappa][..], Choice::scores);
    let (region, combination) = (args.region.as_deref(), args.combination.as_deref());
    let selection = Selection::named(&results, region, combination, scores)?;
    for render in [distribution::render, maxima::render, groups::render, snapshots::render] {
        super::print(&render(&results, &selection))?;
    }
    Ok(ExitCode::SUCCESS)
}
