//! Which objects make a scene too large for a grid, in words. The cause is mostly a slip of one position or
//! unit.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{HUGE_M, LARGE_M, bounds_m, distinct_objects, unit_question};
use crate::objects::Scene;

/// What makes a scene longer than its objects are, in words: those that stand far from most others, or one
/// that is in another unit. `None` where it is neither.
pub(super) fn odd_ones_out(snapshots: &[Scene]) -> Option<String> {
    // The places of an object in all snapshots count together.
    let mut spans: BTreeMap<&str, [DVec3; 2]> = BTreeMap::new();
    let objects = distinct_objects(snapshots);
    let places = objects.iter().map(|object| (object.name.as_str(), bounds_m(object)));
    // A map without voxels is nowhere.
    for (name, own) in places.filter(|(_, [low, high])| low.cmple(*high).all()) {
        spans.entry(name).and_modify(|all| *all = hull(*all, own)).or_insert(own);
    }
    let [low, high] = spans.values().copied().reduce(hull)?;
    let all = high - low;
    let axis = (0..3).max_by(|&a, &b| all[a].total_cmp(&all[b]))?;
    let mut along: Vec<_> = spans.iter().map(|(name, [l, h])| (*name, [l[axis], h[axis]])).collect();
    along.sort_by(|(_, a), (_, b)| a[0].total_cmp(&b[0]));
    far_away(&along, ["x", "y", "z"][axis], all[axis]).or_else(|| {
        guess_unit(&spans, |name| objects.iter().any(|object| object.name == name && object.takes_unit))
    })
}

/// Objects, sorted along an axis: which of them lie beyond a gap that is more than half of all.
fn far_away(along: &[(&str, [f64; 2])], axis: &str, all_m: f64) -> Option<String> {
    let reach = |some: &[(&str, [f64; 2])]| {
        some.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], (_, s)| [l.min(s[0]), h.max(s[1])])
    };
    let gap = |at: &usize| reach(&along[*at..])[0] - reach(&along[..*at])[1];
    let at = (1..along.len()).find(|at| 2.0 * gap(at) > all_m)?;
    let (before, after) = along.split_at(at);
    let farthest = |some| reach(some).map(f64::abs).into_iter().fold(0.0, f64::max);
    let is_after = match before.len().cmp(&after.len()) {
        std::cmp::Ordering::Equal => farthest(after) > farthest(before),
        order => order.is_gt(),
    };
    let (few, rest) = if is_after { (after, before) } else { (before, after) };
    let objects = if few.len() == 1 { "object" } else { "objects" };
    let reaches = if few.len() == 1 { "reaches" } else { "reach" };
    let names: Vec<String> = few.iter().take(3).map(|(name, _)| format!("{name:?}")).collect();
    let more = if few.len() > 3 { format!(" and {} more", few.len() - 3) } else { String::new() };
    let ([from, to], [low, high]) = (reach(few), reach(rest));
    Some(format!(
        "{objects} {}{more} {reaches} from {axis} = {from:.2} to {to:.2} m, far from all others ({low:.2} to {high:.2} m): is its \
         position_m right?",
        names.join(", ")
    ))
}

/// The largest object, if it is no cell, or beside all others much too large.
fn guess_unit(spans: &BTreeMap<&str, [DVec3; 2]>, takes_unit: impl Fn(&str) -> bool) -> Option<String> {
    let mut sizes: Vec<(&str, DVec3)> =
        spans.iter().map(|(name, [low, high])| (*name, *high - *low)).collect();
    sizes.sort_by(|(_, a), (_, b)| b.max_element().total_cmp(&a.max_element()));
    let (name, size) = *sizes.first()?;
    let own_m = size.max_element();
    let is_odd = sizes.get(1).is_some_and(|(_, next)| own_m >= 5.0 * next.max_element());
    (own_m > HUGE_M || own_m > LARGE_M && is_odd).then(|| {
        format!(
            "object {name:?} is {:.2} × {:.2} × {:.2} m: {}",
            size.x,
            size.y,
            size.z,
            unit_question(own_m, takes_unit(name))
        )
    })
}

fn hull([low, high]: [DVec3; 2], [l, h]: [DVec3; 2]) -> [DVec3; 2] {
    [low.min(l), high.max(h)]
}
