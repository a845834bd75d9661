//! The cheapest set that passes: searched, written, judged and printed, or verified.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use perirobot_cover::CandidateEvidence;
use perirobot_decide::cheapest::{PurchaseOutcome, PurchaseReport, PurchaseVerified, Purchasing};
use perirobot_decide::judge::{Judging, Verdicts};
use perirobot_decide::view::Choice;
use perirobot_march::Result;
use perirobot_march::progress::Progress;
use perirobot_page::report::terminal;
use perirobot_study::input::{Purchase, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::Results;
use perirobot_sweep::scoring::check::ONE_IN;

use super::super::onlooker::{Onlooker, Shown};
use super::super::outcome::look_at;
use super::super::stop::{StopAt, stop_code};
use super::super::sweep::command;
use super::{Args, cast};

/// The exit code if no set passes, equal to that of `judge` for a missed requirement.
const NONE_PASSES: u8 = 4;

/// The consequence of reading evidence from a file.
const FILED: &str = "the search takes longer";

/// Finds the cheapest set that passes, writes it and prints it.
pub(super) fn search(
    args: &Args,
    (out, packages): (&Path, &[String]),
    (study, purchase, worlds): (&Study, &Purchase, &[World]),
    stop: &StopAt,
    begin: Instant,
) -> Result<ExitCode> {
    let purchasing = Purchasing::new(study, purchase, worlds, args.evidence_bytes())?;
    let folder = PurchaseOutcome::folder(out, study)?;
    let casting = purchasing.begin_casting(Some(folder.path()), args.restart)?;
    let mut backends = args.backend.backends()?;
    let prepare_s = begin.elapsed().as_secs_f64();
    let evidence = cast(args, casting, &mut backends, stop, FILED)?;
    let (report, is_stopped) = find(args, &purchasing, &evidence, stop)?;
    drop(evidence);
    let outcome = PurchaseOutcome::new((study, purchase, worlds), report);
    let onlooker = job_onlooker(args, "sets", outcome.total());
    let results = outcome.write(folder, &mut backends, (ONE_IN, prepare_s), &command(), &onlooker)?;
    onlooker.finish();
    let verdicts = results.map(|results| judge(args, out, worlds, (&outcome, &results))).transpose()?;
    let report = &outcome.report;
    let recommended = verdicts.as_ref().and_then(|verdicts| verdicts.sets.first());
    super::super::print(&terminal::cheapest::render(report, recommended))?;
    super::super::print(&format!("\nresults in {}\n", out.display()))?;
    super::super::print_next(&look_at(out, packages))?;
    Ok(match (is_stopped, &report.main().set) {
        (true, _) => {
            say!("{}: not all sets were searched", stop.reason().unwrap_or_default());
            stop_code()
        }
        (false, Some(_)) => ExitCode::SUCCESS,
        (false, None) => ExitCode::from(NONE_PASSES),
    })
}

/// Looks from every candidate and searches; returns also whether the search was stopped.
fn find(
    args: &Args,
    purchasing: &Purchasing,
    evidence: &[CandidateEvidence],
    stop: &StopAt,
) -> Result<(PurchaseReport, bool)> {
    let looks = match purchasing.looks() {
        0 => Shown::Nothing,
        looks => Shown::Job(args.progress.start("looks", 0, looks)),
    };
    let onlooker = Onlooker::new(looks, Some(stop), false);
    let ways = purchasing.look(&onlooker)?;
    onlooker.finish();
    let onlooker = Onlooker::new(Shown::Search(args.progress.search()), Some(stop), false);
    let report = purchasing.search(evidence, &ways, &|| args.backend.backends(), &onlooker)?;
    let is_stopped = onlooker.stops() && report.stopped;
    onlooker.finish();
    Ok((report, is_stopped))
}

/// Judges all sets of an answer, and writes the verdicts into its folder.
fn judge(
    args: &Args,
    out: &Path,
    worlds: &[World],
    (outcome, results): (&PurchaseOutcome, &Results),
) -> Result<Verdicts> {
    let sets = &outcome.sets;
    let choices: Vec<Choice> = (0..sets.combinations.len())
        .map(|combination| Choice { combination, choice: 0, representation: 0, repeat: 0 })
        .collect();
    let judging = Judging::new(sets, worlds, results, &choices)?;
    judging.warnings.iter().for_each(|warning| say!("warning: {warning}"));
    let onlooker = job_onlooker(args, "cases", judging.total());
    let judged = judging.judge(&|| args.backend.backends(), &onlooker)?;
    onlooker.finish();
    outcome.agrees(&judged.sets)?;
    judging.write(out, &judged)
}

/// Shows the progress of a job that is finished even if the search was stopped.
fn job_onlooker(args: &Args, unit: &'static str, total: u64) -> Onlooker<'static> {
    let shown = if total == 0 { Shown::Nothing } else { Shown::Job(args.progress.start(unit, 0, total)) };
    Onlooker::new(shown, None, false)
}

/// Checks the answer in a folder.
pub(super) fn verify(
    args: &Args,
    folder: &Path,
    (study, purchase, worlds): (&Study, &Purchase, &[World]),
    stop: &StopAt,
) -> Result<ExitCode> {
    let purchasing = Purchasing::new(study, purchase, worlds, args.evidence_bytes())?;
    let claims = purchasing.read_claims(folder)?;
    let casting = purchasing.begin_casting(None, false)?;
    let evidence = cast(args, casting, &mut args.backend.backends()?, stop, FILED)?;
    let shown = Shown::Job(args.progress.start("points", 0, claims.points() as u64));
    let onlooker = Onlooker::new(shown, Some(stop), false);
    let PurchaseVerified { sets, ways, proven, open, stopped } =
        purchasing.verify(&claims, &evidence, &|| args.backend.backends(), &onlooker)?;
    onlooker.finish();
    let mut rest = String::new();
    if open > 0 {
        rest += &format!("; {open} claims were not checked: too many sets for the plain search");
    }
    if stopped {
        rest += "; the search was stopped, so answers may be missing";
    }
    let holds = if open > 0 { "all others hold" } else { "all claims hold" };
    super::super::print(&format!(
        "{sets} sets judged again, {ways} ways in followed again, {proven} claims searched again, all tables \
         compared{rest}: {holds}\n"
    ))?;
    Ok(ExitCode::SUCCESS)
}
