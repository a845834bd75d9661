//! The best sets of sensors: the question, the front, and each set sensor by sensor.

use crate::report::chosen_sets::{
    Spelling, describe_disturb, describe_score, four, front, question, reading_guide, refined_words,
    sentence, set,
};
use perirobot_decide::choose::{Chosen, describe_asked_prices};
use perirobot_march::metrics::Across;

/// Scores by their names in files.
const AS_IN_FILES: Spelling = Spelling {
    score: |score| score.title().into(),
    over: Across::name,
    least: |_, least| least.to_string(),
    value: four,
    change: |_, change| format!("{change:+.4}"),
};

/// How to add refined poses to a study.
const HOW_TO_LIST: &str = "refined.csv has the finer poses; a study lists them as [[sensor.poses]] name = \"refined\", \
                                      csv = \"refined.csv\".";

/// The question and the front.
pub fn overview(chosen: &Chosen) -> String {
    format!(
        "asked: {}\n\n{}{}{}\n{}",
        question(chosen, &AS_IN_FILES),
        front(chosen, &AS_IN_FILES).text(),
        reading_guide(chosen),
        describe_disturb(chosen, &AS_IN_FILES),
        describe_asked_prices(&chosen.asked.sensors).map_or(String::new(), |prices| prices + "\n")
    )
}

/// The best set in a sentence and sensor by sensor, the question, the front, finer poses, and sets that are nearly as good.
pub fn render(chosen: &Chosen) -> String {
    let mut text = String::new();
    if let Some(best) = chosen.report.best() {
        text += &format!(
            "{}\n\n{}\n",
            sentence(chosen, &AS_IN_FILES, best),
            set(chosen, &AS_IN_FILES, &best.best).text()
        );
    }
    text += overview(chosen).trim_end();
    text.push('\n');
    for refined in chosen.report.refined.iter().flatten() {
        text += &format!("\n{}\n", refined_words(chosen, &AS_IN_FILES, refined));
        if let Some(best) = &refined.best {
            text += &set(chosen, &AS_IN_FILES, best).text();
        }
    }
    if chosen.report.refined.iter().flatten().any(|refined| refined.best.is_some()) {
        text += &format!("\n{HOW_TO_LIST}\n");
    }
    for tie in &chosen.report.ties {
        text += &format!(
            "\nnearly as good elsewhere: {}\n{}",
            describe_score(chosen, &AS_IN_FILES, tie),
            set(chosen, &AS_IN_FILES, tie).text()
        );
    }
    text
}
