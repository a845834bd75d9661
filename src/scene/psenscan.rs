//! Reads zones of PSENscan safety laser scanners from the XML that the PSENscan Configurator of Pilz exports: the only
//! configuration of a maker whose form is public, by the reader in Pilz' driver for ROS (`psen_scan_v2`).
//!
//! A file has a `scannerDescr` for each scanner of a cluster, in it a `zoneSetInfo` for each zone set, in that a
//! `zoneSetDetail` for each zone: its `type`, and in `ro` how far it reaches, in millimetres, four hexadecimal digits each with
//! the lower byte first. There is a value every half degree over 275°, which begin at the scanner's left: the frame of the
//! driver, in which they turn to the left, has its z axis down. 0 is no zone there.

use std::path::Path;

use roxmltree::Node;

use crate::objects::xml::{Xml, children};
use crate::source::Sources;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};

/// The direction of the first value: 0 is ahead, 90 left.
const FIRST_DEG: f64 = 137.5;
/// The angle from a value to the next, which is to its right.
const STEP_DEG: f64 = 0.5;
/// How many values there are, without the end or with it.
const COUNTS: [usize; 2] = [550, 551];

/// Which zone of a file is meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ZoneChoice {
    /// The zone set, counted from 1.
    pub zone_set: usize,
    /// Its zone, as in the file: `roOSSD1`.
    pub zone: String,
    /// The scanner of the cluster, counted from 1; needed if there are several.
    pub scanner: Option<usize>,
}

/// A zone of a scanner.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// How far it reaches, as direction in degrees (0 is ahead, 90 left) and millimetres, from the right to the left.
    pub reaches: Vec<(f64, u32)>,
    /// The lowest and highest speed for which its zone set is, in centimetres a second, if it is chosen by speed; backwards
    /// is negative.
    pub speeds_cm_s: Option<[i64; 2]>,
}

/// A zone of a file.
///
/// # Errors
/// If it is not such a file, or has no such zone.
pub fn read_zone(path: &Path, choice: &ZoneChoice, sources: &Sources) -> Result<Zone> {
    let text = sources.xml(path)?;
    zone_of(&text, choice).map_err(|issue| Error::from(issue.with_place(path)))
}

fn zone_of(text: &str, choice: &ZoneChoice) -> Result<Zone, Issue> {
    let xml = Xml::scan(text)?;
    let document = xml.document()?;
    let root = document.root_element();
    if !root.has_tag_name("MIB") {
        let what = format!("begins with <{:.40}>, and not with <MIB>", root.tag_name().name());
        return Err(Issue::unsupported(what)
            .with_advice("export the configuration of the PSENscan Configurator as XML"));
    }
    let scanner = scanner(root, choice.scanner)?;
    let sets: Vec<Node> = children(scanner, "zoneSetDefinition")
        .flat_map(|definition| children(definition, "zoneSetInfo"))
        .collect();
    let Some(set) = choice.zone_set.checked_sub(1).and_then(|number| sets.get(number)) else {
        let what = format!("has no zone set {}", choice.zone_set);
        return Err(Issue::says(what).with_advice(format!("there are {}, counted from 1", sets.len())));
    };
    let details: Vec<(&str, Node)> =
        children(*set, "zoneSetDetail").map(|detail| (child_text(detail, "type"), detail)).collect();
    let found = details.iter().find(|(zone, _)| *zone == choice.zone);
    let Some((_, detail)) = found else {
        let known: Vec<&str> = details.iter().map(|(zone, _)| *zone).collect();
        return Err(Issue::says(format!("zone set {} has no zone {:?}", choice.zone_set, choice.zone))
            .with_advice(format!("expected one of {known:?}")));
    };
    let in_zone = |issue: Issue| issue.with_place(format!("zone set {}, {}", choice.zone_set, choice.zone));
    let values = values(child_text(*detail, "ro")).map_err(in_zone)?;
    let reach = |(number, mm): (usize, u32)| (FIRST_DEG - number as f64 * STEP_DEG, mm);
    let reaches = values.into_iter().enumerate().map(reach).rev().collect();
    Ok(Zone { reaches, speeds_cm_s: speeds_cm_s(root, choice.zone_set) })
}

/// The scanner of this number, or the only one.
fn scanner<'a, 'i>(root: Node<'a, 'i>, number: Option<usize>) -> Result<Node<'a, 'i>, Issue> {
    let scanners: Vec<Node> = children(root, "scannerDescr").collect();
    let advice = format!("there are {}, counted from 1", scanners.len());
    match (number, &scanners[..]) {
        (_, []) => Err(Issue::damaged("has no scannerDescr").with_advice("export it again")),
        (None, [only]) => Ok(*only),
        (None, _) => Err(Issue::says("has several scanners")
            .with_advice(format!("choose one by scanner = 1: {advice}, the master first"))),
        (Some(number), all) => number
            .checked_sub(1)
            .and_then(|number| all.get(number).copied())
            .ok_or_else(|| Issue::says(format!("has no scanner {number}")).with_advice(advice)),
    }
}

/// The numbers of `ro`.
fn values(text: &str) -> Result<Vec<u32>, Issue> {
    let digits = text.as_bytes();
    let value = |four: &[u8]| -> Option<u32> {
        let [a, b, c, d] = four else { return None };
        let text = [*c, *d, *a, *b];
        if !text.iter().all(u8::is_ascii_hexdigit) {
            return None;
        }
        u32::from_str_radix(std::str::from_utf8(&text).ok()?, 16).ok()
    };
    let values: Option<Vec<u32>> = digits.chunks(4).map(value).collect();
    let Some(values) = values else {
        return Err(Issue::damaged("ro is not a list of four hexadecimal digits each")
            .with_advice("export the configuration again"));
    };
    if !COUNTS.contains(&values.len()) {
        return Err(Issue::unsupported(format!("ro has {} values", values.len()))
            .with_advice("550 or 551 are known, one every half degree"));
    }
    Ok(values)
}

/// The speeds for which a zone set is, if sets are chosen by the speed that encoders measure.
fn speeds_cm_s(root: Node, zone_set: usize) -> Option<[i64; 2]> {
    let cluster = children(root, "clusterDescr").next()?;
    let sets = children(cluster, "zoneSetConfiguration").next()?;
    if child_text(sets, "encEnable") != "true" {
        return None;
    }
    let selectors = children(sets, "zoneSetSelCode").flat_map(|code| children(code, "zoneSetSelector"));
    let selector = selectors.into_iter().nth(zone_set.checked_sub(1)?)?;
    let range = children(selector, "zoneSetSpeedRange").next()?;
    let [low, high] = ["minSpeed", "maxSpeed"].map(|name| child_text(range, name).parse().ok());
    Some([low?, high?])
}

/// The text of a child; empty if there is none.
fn child_text<'a>(node: Node<'a, '_>, name: &str) -> &'a str {
    children(node, name).next().and_then(|child| child.text()).unwrap_or_default().trim()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values of a zone by their numbers.
    type ZoneValues = fn(usize) -> u16;

    /// A configuration: for each scanner its zone sets, each with the value of its `roOSSD1` by number.
    fn configuration(scanners: &[&[ZoneValues]], by_speed: bool) -> String {
        let ro = |value: &ZoneValues| {
            let bytes = (0..550).flat_map(|number| value(number).to_le_bytes());
            bytes.map(|byte| format!("{byte:02X}")).collect::<String>()
        };
        let set = |value: &ZoneValues| {
            let zones = [("roOSSD1", ro(value)), ("warn1", "0A00".repeat(551))];
            let zones = zones.map(|(zone, ro)| {
                format!("<zoneSetDetail><type>{zone}</type>\n<shapes><type>Arc</type></shapes><ro>{ro}</ro></zoneSetDetail>")
            });
            format!("<zoneSetInfo>{}</zoneSetInfo>", zones.concat())
        };
        let scanner = |sets: &&[ZoneValues]| {
            let sets: String = sets.iter().map(set).collect();
            format!("<scannerDescr><zoneSetDefinition>{sets}</zoneSetDefinition></scannerDescr>")
        };
        let selector = |[low, high]: [i32; 2]| {
            format!(
                "<zoneSetSelector><zoneSetSpeedRange><minSpeed>{low}</minSpeed><maxSpeed>{high}</maxSpeed>\
                 </zoneSetSpeedRange></zoneSetSelector>"
            )
        };
        format!(
            "<?xml version=\"1.0\" encoding=\"utf-16\"?>\n<MIB xmlns=\"http://tempuri.org/Mib.xsd\"><clusterDescr>\
             <zoneSetConfiguration><zoneSetSelCode>{}{}</zoneSetSelCode><encEnable>{by_speed}</encEnable>\
             </zoneSetConfiguration></clusterDescr>{}</MIB>",
            selector([-10, 10]),
            selector([11, 50]),
            scanners.iter().map(scanner).collect::<String>()
        )
    }

    fn choice(zone_set: usize, zone: &str, scanner: Option<usize>) -> ZoneChoice {
        ZoneChoice { zone_set, zone: zone.into(), scanner }
    }

    /// A quarter to the right of the scanner, and a single ray ahead.
    const RIGHT: ZoneValues = |number| if (275..=455).contains(&number) { 2003 } else { 0 };
    const AHEAD: ZoneValues = |number| if number == 275 { 0x1389 } else { 0 };

    #[test]
    fn values_go_from_the_left_to_the_right() {
        let text = configuration(&[&[RIGHT, AHEAD]], true);
        let right = zone_of(&text, &choice(1, "roOSSD1", None)).unwrap();
        let there: Vec<&(f64, u32)> = right.reaches.iter().filter(|(_, mm)| *mm > 0).collect();
        assert_eq!((right.reaches.len(), there.len()), (550, 181));
        assert_eq!([there[0], there[180]], [&(-90.0, 2003), &(0.0, 2003)]);
        assert_eq!([right.reaches[0].0, right.reaches[549].0], [-137.0, 137.5]);
        assert_eq!(right.speeds_cm_s, Some([-10, 10]));
        let ahead = zone_of(&text, &choice(2, "roOSSD1", Some(1))).unwrap();
        assert_eq!(ahead.reaches.iter().find(|(_, mm)| *mm > 0), Some(&(0.0, 5001)));
        assert_eq!(ahead.speeds_cm_s, Some([11, 50]));
        let warned = zone_of(&configuration(&[&[RIGHT]], false), &choice(1, "warn1", None)).unwrap();
        assert!(warned.reaches.iter().all(|(_, mm)| *mm == 10) && warned.reaches.len() == 551);
        assert_eq!(warned.speeds_cm_s, None);
        let second =
            zone_of(&configuration(&[&[RIGHT], &[AHEAD]], false), &choice(1, "roOSSD1", Some(2))).unwrap();
        assert_eq!(second.reaches, ahead.reaches);
    }

    #[test]
    fn what_is_no_zone_is_refused() {
        let good = configuration(&[&[RIGHT]], true);
        let first = choice(1, "roOSSD1", None);
        for (text, choice, expected) in [
            (good.clone(), choice(2, "roOSSD1", None), "has no zone set 2: there are 1, counted from 1"),
            (good.clone(), choice(0, "roOSSD1", None), "has no zone set 0"),
            (
                good.clone(),
                choice(1, "muting1", None),
                "zone set 1 has no zone \"muting1\": expected one of [\"roOSSD1\", \"warn1\"]",
            ),
            (good.clone(), choice(1, "roOSSD1", Some(2)), "has no scanner 2: there are 1, counted from 1"),
            (
                configuration(&[&[RIGHT], &[AHEAD]], true),
                first.clone(),
                "has several scanners: choose one by scanner = 1",
            ),
            (configuration(&[], true), first.clone(), "has no scannerDescr"),
            (
                good.replacen("<ro>", "<ro>0000", 2),
                choice(1, "warn1", None),
                "zone set 1, warn1: ro has 552 values: 550 or 551",
            ),
            (
                good.replacen("<ro>", "<ro>00", 1),
                first.clone(),
                "zone set 1, roOSSD1: ro is not a list of four",
            ),
            (good.replacen("<ro>00", "<ro>0x", 1), first.clone(), "ro is not a list of four"),
            (good.replacen("<ro>00", "<ro>+0", 1), first.clone(), "ro is not a list of four"),
            (
                good.replace("MIB", "project"),
                first.clone(),
                "begins with <project>, and not with <MIB>: export",
            ),
            ("x_m,y_m".into(), first, "is no XML"),
        ] {
            let said = zone_of(&text, &choice).unwrap_err().to_string();
            assert!(said.contains(expected), "{said}");
        }
    }
}
