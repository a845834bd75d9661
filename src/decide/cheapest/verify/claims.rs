//! Compares an answer in its folder with the study: the question, the aims, the allowed sets and their costs.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::ProofInput;
use crate::cheapest::purchasing::MOST_TIES;
use crate::cheapest::question::PurchaseQuestion;
use crate::cheapest::remaining::combination;
use crate::cheapest::report::{AimReport, FILE, PurchasePoint, PurchaseReport, PurchasedSet};
use crate::cheapest::terms::{PurchaseAim, Terms};
use crate::choose::{DisturbedPairs, fingerprint, pose_name};
use crate::json_file::{Difference, first_difference};
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_study::sensor::Cost;
use perirobot_study::world::place::Places;

/// An answer to verify.
pub struct PurchaseClaims {
    pub(super) folder: PathBuf,
    pub(super) report: PurchaseReport,
    /// The terms of each of its points.
    pub(super) asked: Vec<AskedPoint>,
    /// The candidates that disturb each other.
    pub(super) disturbed: DisturbedPairs,
}

/// The terms of a point, and the candidates of its set.
pub(super) struct AskedPoint {
    /// The terms of the set.
    pub(super) terms: Terms,
    /// The number of requirements that suffice; `None` for all.
    pub(super) least: Option<usize>,
    pub(super) set: Option<Vec<usize>>,
}

impl PurchaseClaims {
    /// Reads the answer in a folder, and checks that it belongs to the study.
    ///
    /// # Errors
    /// `Error::Input` that names what is wrong.
    pub(crate) fn read(folder: &Path, input: ProofInput) -> Result<PurchaseClaims> {
        let path = folder.join(FILE.name);
        let Some(report) = PurchaseReport::read(folder)? else {
            let issue = Issue::says("is missing").with_advice("name a folder of choose");
            return Err(issue.with_place(&path).into());
        };
        PurchaseClaims::new(folder, report, input)
    }

    /// Checks that an answer in a folder belongs to the study.
    ///
    /// # Errors
    /// `Error::Input` that names what is wrong.
    pub(crate) fn new(folder: &Path, report: PurchaseReport, input: ProofInput) -> Result<PurchaseClaims> {
        let in_file = |issue: Issue| Error::from(issue.with_place(folder.join(FILE.name)));
        let ProofInput { study, purchase, worlds, items, .. } = input;
        let disturbed = DisturbedPairs::from_items(items, (study, worlds), purchase.disturb);
        let asked = examine(&report, ProofInput { disturbed: &disturbed, ..input }).map_err(in_file)?;
        Ok(PurchaseClaims { folder: folder.into(), report, asked, disturbed })
    }

    /// The number of points; progress is reported per point.
    pub fn points(&self) -> usize {
        self.asked.len()
    }
}

fn mismatch<T>(place: impl Into<String>, what: impl Into<String>) -> Result<T, Issue> {
    Err(Issue::says(what.into()).with_place(place.into()))
}

/// Compares an answer with the study, without casting.
fn examine(report: &PurchaseReport, input: ProofInput) -> Result<Vec<AskedPoint>, Issue> {
    let ProofInput { study, purchase, worlds, .. } = input;
    if report.fingerprint != fingerprint(study, worlds) {
        return mismatch("fingerprint", "the study has changed since the search: choose again");
    }
    let json = |question: &PurchaseQuestion| serde_json::to_value(question).unwrap_or(Value::Null);
    let own = PurchaseQuestion::new(study, purchase);
    if let Some(Difference { place, own, other }) =
        first_difference("asked".into(), &json(&report.asked), &json(&own))
    {
        return mismatch(place, format!("is {own}, but the study has {other}: choose again"));
    }
    let (points, ways_in) = (report.points.clone(), report.ways_in.clone());
    let right = PurchaseReport::new((study, purchase, worlds), points, ways_in, report.stopped);
    let heads = [
        ("semantics_version", report.semantics_version == right.semantics_version),
        ("candidates", report.candidates == right.candidates),
        ("voxel_size_m", report.voxel_size_m == right.voxel_size_m),
        ("noiseless", report.noiseless == right.noiseless),
    ];
    if let Some((key, _)) = heads.into_iter().find(|(_, is_right)| !is_right) {
        return mismatch(key, "differs from the study");
    }
    let terms = terms_of_points(report, input)?;
    let each = report.points.iter().zip(terms).enumerate();
    let one = |(number, (point, terms)): (usize, (&PurchasePoint, Terms))| {
        let set = examine_point(input, &format!("points[{number}]"), point, (&terms, report.stopped))?;
        let least = match point.aim {
            AimReport::Number(least) => Some(least),
            _ => None,
        };
        Ok(AskedPoint { terms, least, set })
    };
    let asked = each.map(one).collect::<Result<Vec<_>, Issue>>()?;
    let is_open = |point: &PurchasePoint| !point.proven || !point.best_of_cost;
    match report.stopped {
        false if report.points.iter().any(is_open) => {
            mismatch("stopped", "is missing, but not all is proven")
        }
        true if !report.points.iter().any(is_open) && is_whole(report, input) => {
            mismatch("stopped", "is present, but all is proven")
        }
        _ => Ok(asked),
    }
}

/// Whether all aims of the study have their point and, if no set passes all, the nearest set.
fn is_whole(report: &PurchaseReport, input: ProofInput) -> bool {
    let is_nearest = |point: &&PurchasePoint| matches!(point.aim, AimReport::Nearest(_));
    let nearest = report.points.iter().filter(is_nearest).count();
    let has_nearest = report.points[0].reasons.is_empty() || nearest > 0;
    let is_explained = |point: &PurchasePoint| !lacks_reasons(point) || !point.reasons.is_empty();
    let has_nearest = has_nearest && report.points.iter().all(is_explained);
    has_nearest && report.points.len() - nearest == input.asked.len()
}

/// Whether reasons belong to a point: it is proven that no set passes its terms.
fn lacks_reasons(point: &PurchasePoint) -> bool {
    point.set.is_none() && point.proven && !matches!(point.aim, AimReport::Number(_))
}

/// The terms of each point's set.
fn terms_of_points(report: &PurchaseReport, input: ProofInput) -> Result<Vec<Terms>, Issue> {
    let place = |number: usize| format!("points[{number}].aim");
    let (mut all, mut number) = (Vec::new(), 0);
    for (aim, terms) in input.asked {
        let expected = AimReport::new(input.study, *aim);
        match report.points.get(number) {
            Some(point) if point.aim == expected => all.push(terms.clone()),
            Some(point) => {
                return mismatch(
                    place(number),
                    format!("is {:?}, but {expected:?} is expected here", point.aim),
                );
            }
            None if report.stopped && number > 0 => return Ok(all),
            None => return mismatch("points", format!("{expected:?} is missing")),
        }
        number += 1;
        if let (PurchaseAim::All, Some(AimReport::Nearest(names))) =
            (aim, report.points.get(number).map(|point| &point.aim))
        {
            let reasons = report.points[0].reasons.iter().map(|reason| &reason.requirement);
            let known = |name: &String| terms.requirements.iter().any(|one| one.name == *name);
            let is_new = |(at, name): (usize, &String)| !names[..at].contains(name);
            let begins = reasons.clone().count() > 0 && reasons.clone().zip(names).all(|(a, b)| a == b);
            let is_right = begins
                && names.len() >= reasons.count()
                && names.iter().all(known)
                && names.iter().enumerate().all(is_new);
            if !is_right {
                return mismatch(place(number), "does not begin with the reasons that nothing passes all");
            }
            let mut terms = terms.clone();
            terms.requirements.retain(|one| !names.contains(&one.name));
            all.push(terms);
            number += 1;
        }
    }
    match report.points.len() > number {
        true => mismatch(place(number), "is not requested"),
        false => Ok(all),
    }
}

/// Whether the claims of a point are consistent, and its set, if the study allows it.
fn examine_point(
    input: ProofInput,
    place: &str,
    point: &PurchasePoint,
    (terms, is_stopped): (&Terms, bool),
) -> Result<Option<Vec<usize>>, Issue> {
    let PurchasePoint { aim, set, no_set_below, proven, best_of_cost, reasons, missed, .. } = point;
    let is_left_out = |name: &String| terms.requirements.iter().all(|one| one.name != *name);
    if let Some(at) = reasons.iter().position(|reason| is_left_out(&reason.requirement)) {
        return mismatch(format!("{place}.reasons[{at}].requirement"), "is not required here");
    }
    let is_of_number = matches!(aim, AimReport::Number(_));
    // A stopped search may lack the time for them.
    let is_right = match lacks_reasons(point) {
        true => !reasons.is_empty() || is_stopped,
        false => reasons.is_empty(),
    };
    if !is_right {
        return mismatch(
            format!("{place}.reasons"),
            "are those for which nothing passes, and belong where that is proven",
        );
    }
    if !missed.is_empty() && (set.is_none() || !is_of_number) {
        return mismatch(format!("{place}.missed"), "belongs to a set that meets a number of requirements");
    }
    let bound_holds = match (set, no_set_below) {
        (Some(set), Some(bound)) => {
            if *proven {
                *bound == set.cost
            } else {
                *bound <= set.cost
            }
        }
        (None, bound) => bound.is_none() == *proven,
        (Some(_), None) => false,
    };
    if !bound_holds {
        return mismatch(
            format!("{place}.no_set_below"),
            "is inconsistent with proven and the cost of the set",
        );
    }
    let has_then = input.purchase.then.is_some();
    let counts_ties = *aim == AimReport::All && set.is_some() && *proven && !has_then;
    if point.ties.is_some_and(|ties| !counts_ties || ties > MOST_TIES) {
        return mismatch(format!("{place}.ties"), "belongs to the proven cheapest set, and is at most 9");
    }
    if point.compared.is_some() && (set.is_none() || *best_of_cost) {
        return mismatch(
            format!("{place}.compared"),
            "belongs to a set that may not be the best of its cost",
        );
    }
    let decides = has_then && set.is_some();
    if if decides { *best_of_cost && !proven } else { best_of_cost != proven } {
        return mismatch(format!("{place}.best_of_cost"), "is inconsistent with proven");
    }
    let Some(set) = set else {
        return match point.disturbed.is_empty() {
            true => Ok(None),
            false => mismatch(format!("{place}.disturbed"), "is present, but there is no set"),
        };
    };
    if set.name != aim.title() {
        return mismatch(
            format!("{place}.set.name"),
            format!("is {:?}, but the aim has {:?}", set.name, aim.title()),
        );
    }
    let found = examine_set(input.for_aim(aim), &format!("{place}.set"), set)?;
    let disturbed = match aim {
        AimReport::Disturbed => disturbed_in(input, &found),
        _ => Vec::new(),
    };
    if point.disturbed != disturbed {
        let what = format!("is {:?}, but the study has {disturbed:?}", point.disturbed);
        return mismatch(format!("{place}.disturbed"), what);
    }
    Ok(Some(found))
}

/// Pairs of some candidates, in order, that disturb each other, except those in every set.
fn disturbed_in(input: ProofInput, set: &[usize]) -> Vec<[String; 2]> {
    let ProofInput { study, purchase, items, disturbed, .. } = input;
    let poses: Vec<[usize; 2]> = set.iter().map(|&item| items[item]).collect();
    let mut pairs = Vec::new();
    for (number, &a) in poses.iter().enumerate() {
        for &b in &poses[number + 1..] {
            let hang_there = [a, b].iter().all(|pose| purchase.always.contains(pose));
            if disturbed.has(a, b) && !hang_there {
                pairs.push([pose_name(study, a), pose_name(study, b)]);
            }
        }
    }
    pairs
}

/// The candidates of a set, if the study allows it.
fn examine_set(input: ProofInput, place: &str, set: &PurchasedSet) -> Result<Vec<usize>, Issue> {
    let ProofInput { study, purchase, worlds, items, .. } = input;
    let places = Places::new(study, &worlds[0]);
    let mut found = Vec::new();
    for (number, one) in set.sensors.iter().enumerate() {
        let is_this = |&[sensor, candidate]: &[usize; 2]| {
            let spec = &study.sensors[sensor];
            spec.name == one.sensor && spec.candidates[candidate].name == one.pose
        };
        let at = |key: &str| format!("{place}.sensors[{number}].{key}");
        let Some(item) = items.iter().position(is_this) else {
            return mismatch(at("pose"), format!("{}:{} is not a pose of the study", one.sensor, one.pose));
        };
        let [sensor, candidate] = items[item];
        let words = places.words(sensor, candidate);
        if one.place != words {
            return mismatch(at("place"), format!("is {:?}, but the study has {words:?}", one.place));
        }
        let cost = study.sensors[sensor].terms.cost.unwrap_or_default();
        if one.cost != cost {
            return mismatch(at("cost"), format!("is {}, but the study has {cost}", one.cost));
        }
        found.push(item);
    }
    let claimed: Vec<[usize; 2]> = found.iter().map(|&item| items[item]).collect();
    let allowed = input.allowed();
    if let Some(why) = allowed.not_allowed((allowed.at_most, allowed.budget), Some(set.cost), &claimed) {
        return mismatch(place, why);
    }
    let sum = set.sensors.iter().fold(Cost::ZERO, |sum, one| sum.plus(one.cost));
    if set.cost != sum {
        return mismatch(format!("{place}.cost"), format!("is {}, but its sensors cost {sum}", set.cost));
    }
    found.sort_unstable();
    let ordered = combination(study, purchase, items, String::new(), &found);
    if !ordered.members.iter().map(|member| [member.sensor, member.candidates[0]]).eq(claimed) {
        return mismatch(format!("{place}.sensors"), "are out of order");
    }
    Ok(found)
}
