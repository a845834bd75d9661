//! `perirobot merge`: merges the shards of a sweep.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use perirobot_march::{Error, Result};
use perirobot_study::input::Study;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::files::shards_below;
use perirobot_sweep::results::merge::merge;
use perirobot_sweep::scoring::reopen;

use super::outcome::{OutcomeArgs, look_at, print_verdicts};
use super::packages::PackageArgs;

/// Merge the shards of a sweep
///
/// Proves that the shards belong to one sweep and are complete and disjoint, and writes into OUT the files of a single
/// run, byte for byte (except for the run records in manifest.json). If a part is missing, prints the command that
/// computes it and writes nothing; the exit code is 2. If the study is still in its place and has requirements, the
/// verdicts are printed as in `perirobot sweep`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  perirobot sweep my.toml --out out/my --shard 0/2
      the two parts of a sweep, on two machines
  perirobot sweep my.toml --out out/my --shard 1/2
  perirobot merge out/my
      all folders out/my/shard-*-of-*
  perirobot merge whole here/shard-0-of-2 there/shard-1-of-2")]
pub(super) struct Args {
    /// Folder for the merged results
    #[arg(value_name = "OUT")]
    out: PathBuf,
    /// Folders of the shards [default: OUT/shard-*-of-*]
    #[arg(value_name = "DIR")]
    shards: Vec<PathBuf>,
    #[command(flatten)]
    outcome: OutcomeArgs,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    super::stop::end_tidily()?;
    let shards = if args.shards.is_empty() { shards_below(&args.out)? } else { args.shards.clone() };
    let results = merge(&args.out, &shards)?;
    args.outcome.write(&results, &args.out)?;
    let study = study(&args.out, &results);
    args.outcome.print_best(study.as_ref().ok(), &results)?;
    let next = match study {
        Ok(study) => print_verdicts(&study, &results, None, &args.out, &[])?,
        Err(why) => {
            say!("warning: {why}; its requirements are not judged");
            look_at(&args.out, &[])
        }
    };
    super::print(&format!("{} shards merged; results in {}\n", shards.len(), args.out.display()))?;
    super::print_next(&next)?;
    Ok(ExitCode::SUCCESS)
}

/// The study of a sweep, if its file exists and its regions are unchanged.
fn study(folder: &Path, results: &Results) -> Result<Study> {
    let (file, overrides) = reopen::origin(folder)?;
    let study = Study::read(&file, &overrides, PackageArgs::default().sources(&file))?;
    let same = study.regions.iter().map(|(name, _)| name).eq(&results.regions);
    if same { Ok(study) } else { Err(Error::input(file, "has other regions than the sweep")) }
}
