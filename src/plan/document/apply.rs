//! Each edit, as changes of the text; those of the plan are here.

use toml_edit::{Item, Value};

use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_study::sensor::Stance;

use super::edit::{Device, Edit};
use super::group;
use super::known::Known;
use super::number::{number, quote, to_number};
use super::path::Path;
use super::plan::{self, PLANNED, PlacedName};
use super::pose::Pose6;
use super::source::Source;
use super::span::whole_end;
use super::values::check_amount;

/// Changes a study. Returns which of the placed sensors was changed, if it is still there.
pub(super) fn apply(source: &mut Source, edit: &Edit, known: &Known) -> Result<Option<usize>> {
    let mut editor = Editor { plan: plan::read(source, known), alone: names(source), source, known };
    match edit {
        Edit::Place { sensor, pose } => editor.place(sensor, pose),
        Edit::Add { device, at, cost } => editor.add(device, at, *cost),
        Edit::Move { index, at } => editor.go(*index, at),
        Edit::Snap { index, pose } => editor.snap(*index, pose),
        Edit::Copy { index, at } => {
            let sensor = editor.placed(*index)?.sensor;
            editor.add(&Device::Sensor(sensor), at, None)
        }
        Edit::Remove { index } => editor.remove(*index),
        Edit::SetSensor { index, device, cost } => editor.set_sensor(*index, device, *cost),
        Edit::SetPlan { placed } => editor.set_plan(placed),
        Edit::SetCost { sensor, cost } => editor.set_cost(sensor, *cost).map(|()| None),
        Edit::MixNoise => editor.mix_noise().map(|()| None),
        Edit::SetBudget { budget } => editor.set_budget(*budget).map(|()| None),
        Edit::SetSensorShape { sensor, shape } => editor.set_sensor_shape(sensor, shape).map(|()| None),
        Edit::SetBox { table, name, shape } => editor.set_box(*table, name, shape).map(|()| None),
        // These are not changes of the study's text.
        Edit::MoveObject { .. } | Edit::SetText { .. } => Ok(None),
    }
}

/// The names of the study's sensors.
pub(super) fn names(source: &Source) -> Vec<String> {
    let sensors = Path::new("sensor");
    let name = |index: usize| source.str(&sensors.entry(index).key("name")).map(String::from);
    (0..source.count(&sensors)).filter_map(name).collect()
}

/// A study that is edited.
pub(super) struct Editor<'a> {
    pub(super) source: &'a mut Source,
    known: &'a Known,
    /// The placed sensors, if they can be read: costs can be changed even if not.
    plan: Result<Vec<PlacedName>>,
    /// The sensors before the edit.
    alone: Vec<String>,
}

impl Editor<'_> {
    fn plan(&mut self) -> Result<Vec<PlacedName>> {
        std::mem::replace(&mut self.plan, Ok(Vec::new())).inspect(|plan| self.plan = Ok(plan.clone()))
    }

    fn placed(&mut self, index: usize) -> Result<PlacedName> {
        let plan = self.plan()?;
        plan.get(index).cloned().ok_or_else(|| {
            let rule = format!("must be a number below {}, the number of placed sensors", plan.len());
            Issue::value("index", index, rule).into()
        })
    }

    /// Writes a plan, and finds one of its sensors in it.
    fn write(&mut self, plan: &[PlacedName], changed: Option<&PlacedName>) -> Result<Option<usize>> {
        plan::write(self.source, plan, &self.alone)?;
        let plan = plan::read(self.source, self.known)?;
        Ok(changed.and_then(|changed| plan.iter().position(|placed| placed == changed)))
    }

    fn stance(&self, sensor: &str) -> Result<Stance> {
        if let Some(known) = self.known.sensors.iter().find(|known| known.name == sensor) {
            return match known.is_posed {
                true => Ok(known.stance),
                false => Err(Error::input(
                    format!("sensor {sensor:?}"),
                    "has no poses: it is where its own keys say",
                )
                .with_advice("edit those, as its box, in the file")),
            };
        }
        let model = self.source.str(&group::sensor(self.source, sensor)?.key("model"));
        let model = model.and_then(|model| self.known.models.iter().find(|known| known.name == model));
        let unknown = || Error::input(format!("sensor {sensor:?}"), "is not known until the study loads");
        model.map(|model| model.stance).ok_or_else(unknown)
    }

    /// Fails unless a sensor has a pose.
    fn check_pose(&self, sensor: &str, pose: &str) -> Result<()> {
        group::sensor(self.source, sensor)?;
        let known = self.known.sensors.iter().find(|known| known.name == sensor);
        let mut poses = known.iter().flat_map(|known| &known.poses).map(|(name, _)| name);
        if poses.any(|name| name == pose) || group::find(self.source, sensor, pose).is_some() {
            return Ok(());
        }
        let like = known.and_then(|known| known.poses.first()).map_or("wall/1/0", |(name, _)| name);
        Err(Issue::value("pose", format!("{pose:?}"), format!("must be a pose of {sensor:?}, as {like:?}"))
            .into())
    }

    fn refuse_twice(plan: &[PlacedName], placed: &PlacedName) -> Result<()> {
        let PlacedName { sensor, pose } = placed;
        match plan.contains(placed) {
            true => Err(Error::input(format!("sensor {sensor:?}"), format!("one is at {pose:?} already"))
                .with_advice("take another pose")),
            false => Ok(()),
        }
    }

    fn place(&mut self, sensor: &str, pose: &str) -> Result<Option<usize>> {
        self.check_pose(sensor, pose)?;
        let (mut plan, placed) = (self.plan()?, PlacedName::new(sensor, pose));
        Self::refuse_twice(&plan, &placed)?;
        plan.push(placed.clone());
        self.write(&plan, Some(&placed))
    }

    fn add(&mut self, device: &Device, at: &Pose6, cost: Option<f64>) -> Result<Option<usize>> {
        let mut plan = self.plan()?;
        let placed = self.new_pose(device, at, cost)?;
        plan.push(placed.clone());
        self.write(&plan, Some(&placed))
    }

    /// A sensor at a new pose.
    fn new_pose(&mut self, device: &Device, at: &Pose6, cost: Option<f64>) -> Result<PlacedName> {
        at.check()?;
        match device {
            Device::Model(model) => self.new_sensor(model, at, cost),
            Device::Sensor(sensor) => {
                group::sensor(self.source, sensor)?;
                let stance = self.stance(sensor)?;
                let pose = self.list_pose(sensor, stance, at)?;
                Ok(PlacedName::new(sensor, &pose))
            }
        }
    }

    /// Lists a new pose of a sensor. One that had the poses of another gets them as its own, but for those that were dragged
    /// there for the other.
    fn list_pose(&mut self, sensor: &str, stance: Stance, at: &Pose6) -> Result<String> {
        let shared = self.source.get(&group::sensor(self.source, sensor)?.key("same_poses_as")).is_some();
        let pose = group::add(self.source, self.known, sensor, stance, at)?;
        if shared {
            let plan = self.plan()?;
            for name in group::planned_poses(self.source, sensor)? {
                let copy = PlacedName::new(sensor, &name);
                let listed = group::find(self.source, sensor, &name);
                if let Some(listed) =
                    listed.filter(|_| name != pose && !self.is_used(&plan, usize::MAX, &copy))
                {
                    group::remove(self.source, &listed)?;
                }
            }
        }
        Ok(pose)
    }

    /// What one of a new sensor costs. A study in which all others have a cost would not load without.
    fn new_cost(&self, model: &str, known: Option<f64>) -> Result<Option<String>> {
        let sensors = Path::new("sensor");
        let all: Vec<Path> = (0..self.source.count(&sensors)).map(|index| sensors.entry(index)).collect();
        let cost = |at: &Path| self.source.get(&at.key("cost")).and_then(Item::as_value);
        let like = all.iter().filter(|at| self.source.str(&at.key("model")) == Some(model)).find_map(cost);
        if let (None, Some("list")) = (known, like.and_then(Value::as_str)) {
            return Ok(Some(quote("list")));
        }
        let found = known.or(like.and_then(to_number));
        match found.is_none() && !all.is_empty() && all.iter().all(|at| cost(at).is_some()) {
            true => Err(Error::input(
                format!("model {model:?}"),
                "has no cost, and every sensor of the study has one",
            )
            .with_advice("say what one costs; 0 if it is there already")),
            false => found.map(|cost| check_amount("cost", cost).map(|()| number(cost))).transpose(),
        }
    }

    /// A new sensor of the study, at one pose.
    fn new_sensor(&mut self, model: &str, at: &Pose6, cost: Option<f64>) -> Result<PlacedName> {
        let Some(known) = self.known.models.iter().find(|known| known.name == model) else {
            return Err(
                Issue::value("model", format!("{model:?}"), "must be a device of the catalogue").into()
            );
        };
        let cost = self.new_cost(model, cost.or(known.cost))?;
        let later = (2..).map(|number| format!("{model}-{number}"));
        let mut all = std::iter::once(model.to_string()).chain(later);
        let name = all.find(|name| !self.alone.contains(name)).unwrap_or_default();
        let own = [("name".to_string(), quote(&name)), ("model".to_string(), quote(model))];
        let cost = cost.map(|cost| ("cost".to_string(), cost));
        let keys = own.iter().chain(&cost).chain(&known.keys).map(|(key, value)| format!("{key} = {value}"));
        let keys: Vec<String> = keys.collect();
        let entry = group::inline_entry("0", at, known.stance);
        let sensors = Path::new("sensor");
        match self.source.get(&sensors) {
            Some(Item::Value(_)) => {
                let poses = format!("poses = [{{ name = {}, list = [{entry}] }}]", quote(PLANNED));
                self.source.push(&sensors, &format!("{{ {}, {poses} }}", keys.join(", ")))?;
            }
            found => {
                let end = found.and_then(whole_end).unwrap_or(self.source.text().trim_end().len());
                let poses = group::planned_keys(PLANNED, &entry).join("\n");
                let block = format!("\n[[sensor]]\n{}\n[[sensor.poses]]\n{poses}", keys.join("\n"));
                self.source.append_block(end, &block)?;
            }
        }
        Ok(PlacedName { sensor: name, pose: format!("{PLANNED}/0") })
    }

    fn go(&mut self, index: usize, at: &Pose6) -> Result<Option<usize>> {
        at.check()?;
        let (mut plan, placed) = (self.plan()?, self.placed(index)?);
        let stance = self.stance(&placed.sensor)?;
        let listed = group::find(self.source, &placed.sensor, &placed.pose);
        if let Some(listed) = listed.filter(|_| !self.is_used(&plan, index, &placed)) {
            group::set(self.source, &listed, at, stance)?;
            return self.write(&plan, Some(&placed));
        }
        plan[index].pose = self.list_pose(&placed.sensor, stance, at)?;
        self.write(&plan, None)?;
        self.clean(&plan, &placed)?;
        let moved = plan[index].clone();
        self.write(&plan, Some(&moved))
    }

    fn snap(&mut self, index: usize, pose: &str) -> Result<Option<usize>> {
        let (mut plan, placed) = (self.plan()?, self.placed(index)?);
        if placed.pose == pose {
            return Ok(Some(index));
        }
        self.check_pose(&placed.sensor, pose)?;
        let snapped = PlacedName::new(&placed.sensor, pose);
        Self::refuse_twice(&plan, &snapped)?;
        plan[index] = snapped.clone();
        self.write(&plan, None)?;
        self.clean(&plan, &placed)?;
        self.write(&plan, Some(&snapped))
    }

    fn remove(&mut self, index: usize) -> Result<Option<usize>> {
        let (mut plan, placed) = (self.plan()?, self.placed(index)?);
        plan.remove(index);
        self.write(&plan, None)?;
        self.clean(&plan, &placed)?;
        Ok(None)
    }

    fn set_sensor(&mut self, index: usize, device: &Device, cost: Option<f64>) -> Result<Option<usize>> {
        let (mut plan, placed) = (self.plan()?, self.placed(index)?);
        if *device == Device::Sensor(placed.sensor.clone()) {
            return Ok(Some(index));
        }
        let poses = self.known.sensors.iter().filter(|known| known.name == placed.sensor);
        let pose = poses.flat_map(|known| &known.poses).find(|(name, _)| *name == placed.pose);
        let pose = pose.and_then(|(_, pose)| *pose).ok_or_else(|| {
            let what = format!("where {:?} is is not known until the study loads", placed.pose);
            Error::input(format!("sensor {:?}", placed.sensor), what)
        })?;
        // A pose that the other has there, too, is taken.
        let same = match device {
            Device::Model(_) => None,
            Device::Sensor(name) => {
                let others = self.known.sensors.iter().filter(|known| known.name == *name);
                let mut poses = others.flat_map(|known| &known.poses).filter(|(_, at)| *at == Some(pose));
                let name_of = |(pose, _): &(String, _)| PlacedName::new(name, pose);
                poses.find(|one| !plan.contains(&name_of(one))).map(name_of)
            }
        };
        let new = match same {
            Some(same) => same,
            None => self.new_pose(device, &Pose6::new(&pose), cost)?,
        };
        plan[index] = new.clone();
        self.write(&plan, None)?;
        self.clean(&plan, &placed)?;
        self.write(&plan, Some(&new))
    }

    fn set_plan(&mut self, placed: &[PlacedName]) -> Result<Option<usize>> {
        let before = self.plan()?;
        for (number, one) in placed.iter().enumerate() {
            self.check_pose(&one.sensor, &one.pose)?;
            Self::refuse_twice(&placed[..number], one)?;
        }
        self.write(placed, None)?;
        before.iter().filter(|one| !placed.contains(one)).try_for_each(|one| self.clean(placed, one))?;
        self.write(placed, None)
    }
}
