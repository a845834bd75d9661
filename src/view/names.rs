//! Names of poses that are not written as they stand in tables: what is meant by them. Which choice of poses has a name
//! is for `find`.

use crate::sensor::Sensor;
use crate::study::{Combination, Study, slug};
use crate::sweep::table::BETWEEN_MEMBERS;

/// Names that are so near to what was written that they may be meant.
const NEAR: f64 = 0.7;

/// The name of the choice that is meant where only its spelling is another: `South wall/2/0` for `south-wall/2/0`.
pub(super) fn spelled(study: &Study, combination: &Combination, poses: &str) -> Option<String> {
    each(study, combination, poses, |sensor, candidates, own| {
        let own = plain(own);
        let mut alike = candidates.iter().filter(|&&c| plain(&sensor.candidates[c].name) == own);
        // Two that differ in spelling only are both not meant.
        alike.next().copied().filter(|_| alike.next().is_none())
    })
}

/// The name of the choice that is nearest to what was written, if each of its poses is near.
pub(super) fn nearest(study: &Study, combination: &Combination, poses: &str) -> Option<String> {
    each(study, combination, poses, |sensor, candidates, own| {
        let own = plain(own);
        let near =
            |c: &usize| strsim::normalized_damerau_levenshtein(&plain(&sensor.candidates[*c].name), &own);
        // Of equals the first.
        let best = candidates.iter().rev().copied().max_by(|a, b| near(a).total_cmp(&near(b)))?;
        (near(&best) >= NEAR).then_some(best)
    })
}

/// The name of a choice, from what is found for each sensor among its candidates; a sensor's own name may be left out.
fn each(
    study: &Study,
    combination: &Combination,
    poses: &str,
    find: impl Fn(&Sensor, &[usize], &str) -> Option<usize>,
) -> Option<String> {
    let parts: Vec<&str> = poses.split(BETWEEN_MEMBERS).collect();
    if parts.len() != combination.members.len() {
        return None;
    }
    let name = |(part, member): (&str, &crate::study::Member)| {
        let sensor = &study.sensors[member.sensor];
        let own = part.strip_prefix(&format!("{}:", sensor.name)).unwrap_or(part);
        let found = find(sensor, &member.candidates, own)?;
        Some(format!("{}:{}", sensor.name, sensor.candidates[found].name))
    };
    let names: Option<Vec<String>> = parts.into_iter().zip(&combination.members).map(name).collect();
    Some(names?.join(BETWEEN_MEMBERS))
}

/// A name with each of its parts as names of groups are spelled.
fn plain(name: &str) -> String {
    name.split('/').map(slug).collect::<Vec<_>>().join("/")
}
