//! Shows the progress of a long job on standard error, for people (a bar) or programs (JSON lines).

use std::sync::LazyLock;
use std::time::{Duration, Instant};

use clap::ValueEnum;
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use perirobot_decide::cheapest::purchase_progress_of;
use perirobot_decide::choose::progress_of;
use perirobot_march::progress::{PurchaseState, SearchState};
use perirobot_study::sensor::Cost;
use serde::Serialize;

#[derive(clap::Args)]
#[command(next_help_heading = "Progress")]
pub(super) struct ProgressArgs {
    /// How to show progress on standard error
    #[arg(long, value_enum, value_name = "HOW", default_value = "bar")]
    progress: How,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum How {
    /// A bar with rate and remaining time, if standard error is a terminal
    Bar,
    /// One JSON object per line, for programs: its event is start, progress (at most twice a second), done or stopped;
    /// a search for sets adds search, for its start and for each set found
    Json,
    /// Not at all
    None,
}

/// Time between two JSON lines.
const BETWEEN_LINES: Duration = Duration::from_millis(500);

/// Time between two frames of the spinner.
const BETWEEN_TICKS: Duration = Duration::from_millis(200);

/// The bar; other writers on standard error move it out of the way.
static BARS: LazyLock<MultiProgress> = LazyLock::new(MultiProgress::new);

/// Runs a function that writes on standard error, with the bar hidden.
pub(super) fn suspend_bar<T>(write: impl FnOnce() -> T) -> T {
    BARS.suspend(write)
}

impl ProgressArgs {
    /// Shows progress from `done` to `of`; `what` names the items in the plural. The rate ignores items done before.
    pub(super) fn start(&self, what: &'static str, done: u64, of: u64) -> JobProgress {
        let (mut bar, mut lines) = (None, None);
        match self.progress {
            How::Bar => bar = Some(new_bar(what, done, of)),
            How::Json => lines = Some(Lines::new(what, done, of)),
            How::None => (),
        }
        if let Some(lines) = &lines {
            say!("{}", lines.line("start", Duration::ZERO));
        }
        JobProgress { what, bar, lines, begin: Instant::now() }
    }

    /// Shows a search.
    pub(super) fn search(&self) -> SearchProgress {
        let spinner = (self.progress == How::Bar).then(|| {
            let style = ProgressStyle::with_template("{spinner} {msg}, {elapsed}");
            let style = style.unwrap_or_else(|_| ProgressStyle::default_spinner());
            let spinner = BARS.add(ProgressBar::new_spinner().with_style(style));
            spinner.enable_steady_tick(BETWEEN_TICKS);
            spinner
        });
        SearchProgress { spinner, lines: self.progress == How::Json, begin: Instant::now() }
    }
}

/// Spinner for a search of unknown length; cleared on drop.
pub(super) struct SearchProgress {
    spinner: Option<ProgressBar>,
    lines: bool,
    begin: Instant,
}

/// The JSON line of a search.
#[derive(Serialize)]
struct SearchLine {
    event: &'static str,
    at_most: usize,
    /// In the study's currency.
    budget: Option<f64>,
    best: Option<f64>,
    /// Upper bound of all scores.
    above: Option<f64>,
    elapsed_s: f64,
}

/// The JSON line of a search for the cheapest set; costs are in the study's currency.
#[derive(Serialize)]
struct PurchaseLine<'a> {
    event: &'static str,
    /// The question under search.
    what: &'a str,
    /// Cost of the cheapest set found.
    cost: Option<f64>,
    /// Lower bound of all costs.
    below: Option<f64>,
    tested: u64,
    /// Whether the answer is proven.
    proven: bool,
    elapsed_s: f64,
}

impl SearchProgress {
    /// Shows the current step, the best score found, and its upper bound if known.
    pub(super) fn show(&self, state: &SearchState) {
        if let Some(spinner) = &self.spinner {
            spinner.set_message(progress_of(state));
        }
        if self.lines {
            let &SearchState { at_most, budget, best, bound: above, .. } = state;
            let elapsed_s = self.elapsed_s();
            let budget = budget.map(|budget| Cost::from_thousandths(budget).amount());
            let line = SearchLine { event: "search", at_most, budget, best, above, elapsed_s };
            say!("{}", serde_json::to_string(&line).expect("numbers make a line"));
        }
    }

    /// Shows the cheapest set found, the lower bound of the cost, and the number of tested sets.
    pub(super) fn show_purchase(&self, state: &PurchaseState) {
        if let Some(spinner) = &self.spinner {
            spinner.set_message(purchase_progress_of(state));
        }
        if self.lines {
            let amount = |cost: u64| Cost::from_thousandths(cost).amount();
            let line = PurchaseLine {
                event: "search",
                what: &state.title,
                cost: state.best.as_ref().map(|best| amount(best.cost)),
                below: state.no_set_below.map(amount),
                tested: state.tested,
                proven: state.is_proven,
                elapsed_s: self.elapsed_s(),
            };
            say!("{}", serde_json::to_string(&line).expect("text and numbers make a line"));
        }
    }

    /// Seconds since the start, to a millisecond.
    fn elapsed_s(&self) -> f64 {
        (1e3 * self.begin.elapsed().as_secs_f64()).round() / 1e3
    }
}

impl Drop for SearchProgress {
    fn drop(&mut self) {
        if let Some(spinner) = &self.spinner {
            spinner.finish_and_clear();
        }
    }
}

fn new_bar(what: &str, done: u64, of: u64) -> ProgressBar {
    let template = format!("{{bar:30}} {{pos}}/{{len}} {what}  {{per_sec}}  {{eta}} left");
    let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = BARS.add(ProgressBar::new(of).with_style(style).with_position(done));
    bar.reset_eta();
    bar
}

/// A running job. The bar is removed when this is finished or dropped.
pub(super) struct JobProgress {
    /// The items, in the plural.
    pub(super) what: &'static str,
    bar: Option<ProgressBar>,
    lines: Option<Lines>,
    begin: Instant,
}

impl JobProgress {
    /// Counts `more` finished items.
    pub(super) fn inc(&mut self, more: u64) {
        if let Some(bar) = &self.bar {
            bar.inc(more);
        }
        let elapsed = self.begin.elapsed();
        if let Some(line) = self.lines.as_mut().and_then(|lines| lines.inc(more, elapsed)) {
            say!("{line}");
        }
    }

    /// To be called when the job has ended, finished or not.
    pub(super) fn finish(self) {
        drop(self);
    }
}

impl Drop for JobProgress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        if let Some(lines) = &self.lines {
            say!("{}", lines.end(self.begin.elapsed()));
        }
    }
}

/// A JSON line. Rate and remaining time are measured since the start of this run, and null before the first item.
#[derive(Serialize)]
struct ProgressLine<'a> {
    event: &'a str,
    what: &'a str,
    done: u64,
    of: u64,
    elapsed_s: f64,
    per_s: Option<f64>,
    left_s: Option<f64>,
}

/// The state behind the JSON lines.
struct Lines {
    what: &'static str,
    /// Done before this run.
    before: u64,
    done: u64,
    of: u64,
    /// Time of the last line, since the start.
    last: Duration,
}

impl Lines {
    fn new(what: &'static str, done: u64, of: u64) -> Self {
        Lines { what, before: done, done, of, last: Duration::ZERO }
    }

    /// Counts `more` finished items; returns a line if one is due.
    fn inc(&mut self, more: u64, elapsed: Duration) -> Option<String> {
        self.done += more;
        if elapsed < self.last + BETWEEN_LINES {
            return None;
        }
        self.last = elapsed;
        Some(self.line("progress", elapsed))
    }

    /// The last line: whether the job was finished.
    fn end(&self, elapsed: Duration) -> String {
        self.line(if self.done >= self.of { "done" } else { "stopped" }, elapsed)
    }

    fn line(&self, event: &str, elapsed: Duration) -> String {
        let (elapsed_s, new) = (elapsed.as_secs_f64(), self.done - self.before);
        let per_s = (new > 0 && elapsed_s > 0.0).then(|| new as f64 / elapsed_s);
        let left_s = per_s.map(|per_s| self.of.saturating_sub(self.done) as f64 / per_s);
        let rounded = |x: f64| (1e3 * x).round() / 1e3;
        let line = ProgressLine {
            event,
            what: self.what,
            done: self.done,
            of: self.of,
            elapsed_s: rounded(elapsed_s),
            per_s: per_s.map(rounded),
            left_s: left_s.map(rounded),
        };
        serde_json::to_string(&line).expect("text and numbers make a line")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn millis(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn lines_have_rate_and_time_left() {
        // 100 were done before, 50 more in 2 s: 25 per second, 850 remain.
        let mut lines = Lines::new("poses", 100, 1000);
        assert_eq!(
            lines.line("start", millis(0)),
            r#"{"event":"start","what":"poses","done":100,"of":1000,"elapsed_s":0.0,"per_s":null,"left_s":null}"#
        );
        assert_eq!(
            lines.inc(50, millis(2000)).unwrap(),
            r#"{"event":"progress","what":"poses","done":150,"of":1000,"elapsed_s":2.0,"per_s":25.0,"left_s":34.0}"#
        );
        assert!(lines.end(millis(2000)).starts_with(r#"{"event":"stopped","what":"poses","done":150,"#));
        lines.inc(850, millis(2001));
        assert_eq!(
            lines.end(millis(3000)),
            r#"{"event":"done","what":"poses","done":1000,"of":1000,"elapsed_s":3.0,"per_s":300.0,"left_s":0.0}"#
        );
    }

    #[test]
    fn lines_come_twice_a_second_at_most() {
        let mut lines = Lines::new("poses", 0, 100);
        let times = [1, 400, 499, 500, 501, 999, 1000, 1700, 2100, 2200];
        let printed: Vec<u64> = times.into_iter().filter(|&ms| lines.inc(1, millis(ms)).is_some()).collect();
        assert_eq!(printed, [500, 1000, 1700, 2200]);
        assert_eq!(lines.done, 10, "all items are counted");
    }
}
