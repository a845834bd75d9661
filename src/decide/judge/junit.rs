//! Verdicts as JUnit XML for build servers: a test case for each set of sensors, requirement and condition.

use super::judged::JudgedSet;
use super::verdict::Judgement;

/// The whole file. `describe` returns a verdict in words.
pub fn junit_xml(sets: &[JudgedSet], describe: &dyn Fn(&JudgedSet, &Judgement) -> String) -> String {
    let all = || sets.iter().flat_map(|set| &set.judgements);
    let (tests, failures) = (all().count(), all().filter(|judgement| !judgement.is_met).count());
    let counts = format!("tests=\"{tests}\" failures=\"{failures}\"");
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites {counts}>\n  <testsuite name=\"perirobot judge\" {counts}>\n"
    );
    for set in sets {
        for judgement in &set.judgements {
            let name = format!("{} ({})", judgement.requirement.name, judgement.condition.name());
            let description = escape(&describe(set, judgement));
            let [name, class] = [&name, &set.poses].map(|text| escape(text));
            text += &format!("    <testcase classname=\"{class}\" name=\"{name}\">\n");
            if let Some(words) = &judgement.requirement.safety_function {
                let property = format!("<property name=\"for\" value=\"{}\"/>", escape(words));
                text += &format!("      <properties>{property}</properties>\n");
            }
            text += &match judgement.is_met {
                true => format!("      <system-out>{description}</system-out>\n"),
                false => format!("      <failure message=\"{description}\"/>\n"),
            };
            text += "    </testcase>\n";
        }
    }
    text + "  </testsuite>\n</testsuites>\n"
}

/// Escapes text for XML, also in attributes.
fn escape(text: &str) -> String {
    let one = |c: char| match c {
        '&' => "&amp;".into(),
        '<' => "&lt;".into(),
        '>' => "&gt;".into(),
        '"' => "&quot;".into(),
        '\n' => "&#10;".into(),
        // XML allows no other control characters; names of studies have none.
        c if c.is_control() => "\u{fffd}".into(),
        c => c.to_string(),
    };
    text.chars().map(one).collect()
}
