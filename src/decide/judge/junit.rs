//! Verdicts as JUnit XML, which build servers read: a test case for each set of sensors, requirement and condition.

use super::judged::JudgedSet;
use super::verdict::Judgement;

/// The whole file. `told` says in words what was found.
pub fn junit_xml(sets: &[JudgedSet], told: &dyn Fn(&JudgedSet, &Judgement) -> String) -> String {
    let all = || sets.iter().flat_map(|set| &set.judgements);
    let (tests, failures) = (all().count(), all().filter(|judgement| !judgement.is_met).count());
    let counts = format!("tests=\"{tests}\" failures=\"{failures}\"");
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites {counts}>\n  <testsuite name=\"perirobot judge\" {counts}>\n"
    );
    for set in sets {
        for judgement in &set.judgements {
            let name = format!("{} ({})", judgement.requirement.name, judgement.condition.name());
            let told = escape(&told(set, judgement));
            let [name, class] = [&name, &set.poses].map(|text| escape(text));
            text += &format!("    <testcase classname=\"{class}\" name=\"{name}\">\n");
            if let Some(words) = &judgement.requirement.safety_function {
                let property = format!("<property name=\"for\" value=\"{}\"/>", escape(words));
                text += &format!("      <properties>{property}</properties>\n");
            }
            text += &match judgement.is_met {
                true => format!("      <system-out>{told}</system-out>\n"),
                false => format!("      <failure message=\"{told}\"/>\n"),
            };
            text += "    </testcase>\n";
        }
    }
    text + "  </testsuite>\n</testsuites>\n"
}

/// Text for XML, in attributes, too.
fn escape(text: &str) -> String {
    let one = |c: char| match c {
        '&' => "&amp;".into(),
        '<' => "&lt;".into(),
        '>' => "&gt;".into(),
        '"' => "&quot;".into(),
        '\n' => "&#10;".into(),
        // XML has no other control characters; names of studies have none.
        c if c.is_control() => "\u{fffd}".into(),
        c => c.to_string(),
    };
    text.chars().map(one).collect()
}
