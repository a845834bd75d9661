//! What else of a study uses a pose or a sensor, and what goes with the last that does.

use perirobot_march::Result;

use super::apply::{Editor, names};
use super::group;
use super::path::Path;
use super::plan::{self, PlacedName};

impl Editor<'_> {
    /// Removes what only a sensor needed that left its pose: the pose, its group, and the sensor that had no other.
    pub(super) fn clean(&mut self, plan: &[PlacedName], left: &PlacedName) -> Result<()> {
        let Some(listed) = group::find(self.source, &left.sensor, &left.pose) else { return Ok(()) };
        if self.is_used(plan, usize::MAX, left) {
            return Ok(());
        }
        if listed.is_last_of_group(self.source) && self.is_group_named(left) {
            return Ok(());
        }
        if !listed.is_last_of_sensor(self.source) {
            return group::remove(self.source, &listed);
        }
        // A sensor without poses is none: it goes, unless something else of the study names it.
        match names(self.source).len() > 1 && !self.is_named(&left.sensor) {
            true => {
                let sensors = Path::new("sensor");
                let index = self.source.position(&sensors, "name", &left.sensor);
                index.map_or(Ok(()), |index| self.source.remove(&sensors, index))
            }
            false => Ok(()),
        }
    }

    /// The sensors that have the poses of a sensor, itself among them.
    fn family(&self, sensor: &str) -> Vec<String> {
        let mut family = vec![sensor.to_string()];
        for name in names(self.source) {
            let like = group::sensor(self.source, &name).ok();
            let like = like.and_then(|at| self.source.str(&at.key("same_poses_as")).map(String::from));
            if like.is_some_and(|like| family.contains(&like)) {
                family.push(name);
            }
        }
        family
    }

    /// Other combinations than the plan's.
    fn others(&self) -> Vec<Path> {
        let (all, planned) = (Path::new("combination"), plan::combination(self.source));
        (0..self.source.count(&all)).filter(|i| Some(*i) != planned).map(|i| all.entry(i)).collect()
    }

    /// The patterns of poses that other combinations have for some sensors.
    fn patterns(&self, sensors: &[String]) -> Vec<String> {
        let of = |at: Path| {
            let each = sensors.iter().map(move |sensor| at.key("poses").key(sensor));
            each.flat_map(|path| self.source.strings(&path).unwrap_or_default()).collect::<Vec<_>>()
        };
        self.others().into_iter().flat_map(of).collect()
    }

    /// Whether a pose is used by more than one of the plan.
    pub(super) fn is_used(&self, plan: &[PlacedName], besides: usize, pose: &PlacedName) -> bool {
        let family = self.family(&pose.sensor);
        let others = plan.iter().enumerate().filter(|(i, _)| *i != besides);
        let placed =
            others.map(|(_, placed)| placed).any(|p| family.contains(&p.sensor) && p.pose == pose.pose);
        let always = self.source.strings(&Path::new("choose").key("always")).unwrap_or_default();
        let is_always = family.iter().any(|sensor| always.contains(&format!("{sensor}:{}", pose.pose)));
        placed || is_always || self.patterns(&family).contains(&pose.pose)
    }

    /// Whether other combinations name the group of a pose, which must then not be empty.
    fn is_group_named(&self, pose: &PlacedName) -> bool {
        let group = pose.pose.split('/').next().unwrap_or_default();
        let patterns = self.patterns(&self.family(&pose.sensor));
        patterns.iter().any(|pattern| pattern.split('/').next() == Some(group))
    }

    /// Whether something else of the study than the plan names a sensor.
    fn is_named(&self, sensor: &str) -> bool {
        let is_it = |name: &String| name == sensor;
        let combined =
            |at: &Path| self.source.strings(&at.key("sensors")).unwrap_or_default().iter().any(is_it);
        let always = self.source.strings(&Path::new("choose").key("always")).unwrap_or_default();
        let is_always = always.iter().any(|name| name.split(':').next() == Some(sensor));
        let said = Path::new("choose").key("representation").key(sensor);
        let is_said = self.source.get(&said).is_some();
        self.others().iter().any(combined) || is_always || is_said || self.family(sensor).len() > 1
    }
}
