//! Counts sets of sensors when something is not as planned: with sensors left out, with mounts that are off, and with
//! other people.
//!
//! What each sensor says is cast once for all cases with the same mounts and people, and fused anew for each. Unions of
//! the sensors before and behind a dead one would save fusing, which is not where the time goes: six cameras at six moments
//! with all their 21 sets without one or two took no longer than the six alone; and log-odds are no unions.

use super::alteration::Alteration;
use super::cases::{Case, Conditions};
use super::draws::Draws;
use super::postures::Stood;
use crate::view::Choice;
use perirobot_march::backend::Fusion;
use perirobot_march::backend::factory::BackendFactory;
use perirobot_march::error::{Argument, Issue, Site};
use perirobot_march::metrics::Confusion;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Combination, Condition, Member, MountingError, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::Subject;
use perirobot_sweep::scoring::run_on;

/// A choice of sensors that is to be counted in other cases than the plan.
pub struct WhatIf<'a> {
    pub(super) study: &'a Study,
    pub(super) worlds: &'a [World],
    fusion: Fusion,
    /// Sensor, candidate and representation of each member.
    pub(super) members: Vec<[usize; 3]>,
}

/// For each region the counts of each moment.
type CountsOf = Vec<Vec<Confusion>>;

/// The sensors in a case.
pub(super) struct CaseVariant {
    pub(super) condition: Condition,
    alteration: Alteration,
    members: Vec<[usize; 3]>,
    /// Mounts that could not be drawn.
    kept: Vec<String>,
    /// What is wrong with where somebody stands.
    warnings: Vec<String>,
}

impl CaseVariant {
    fn case(self, counts: Vec<Vec<Confusion>>) -> Case {
        let CaseVariant { alteration, kept, warnings, .. } = self;
        Case { alteration, kept, warnings, counts, ..Case::default() }
    }
}

impl<'a> WhatIf<'a> {
    /// A choice of a study.
    pub fn new(study: &'a Study, worlds: &'a [World], choice: &Choice) -> WhatIf<'a> {
        let combination = &study.combinations[choice.combination];
        let ways = combination.representations(&study.sensors).swap_remove(choice.representation);
        let members = combination.members.iter().zip(combination.choice(choice.choice)).zip(ways);
        let members = members.map(|((member, candidate), way)| [member.sensor, candidate, way]);
        WhatIf { study, worlds, fusion: combination.fusion, members: members.collect() }
    }

    /// How many cases there are to count, with the plan, in each snapshot and repeat for itself; none where nothing is
    /// asked besides the plan.
    pub fn total(&self, asked: &[Condition]) -> u64 {
        let all = [&[Condition::AsPlanned], asked].concat();
        let silent = self.left_out(&all).iter().filter(|variant| variant.members.is_empty()).count() as u64;
        let moments = self.worlds.len() as u64 * u64::from(self.study.repeats);
        if asked.is_empty() { 0 } else { (self.cases_under(&all) - silent) * moments }
    }

    fn error(&self, asked: &[Condition]) -> Option<&MountingError> {
        self.study.mounting_error.as_ref().filter(|_| asked.contains(&Condition::MountingError))
    }

    /// Counts the plan of a set that was not swept.
    ///
    /// # Errors
    /// When the backend fails; `Error::Stopped`.
    pub(super) fn count_plan(
        &self,
        subject: &Subject,
        backends: &mut dyn BackendFactory,
        progress: &dyn Progress,
    ) -> Result<Conditions> {
        let counted = self.count_variants(self.study, self.worlds, self.left_out(&[]), backends, progress)?;
        let counts = counted.into_iter().map(|(_, counts)| counts).next().unwrap_or_default();
        Ok(Conditions::from_plan(self.study, subject, counts))
    }

    /// Counts all cases of some conditions and adds them to what was counted as planned. The mounts that were drawn
    /// are the answer, if any were.
    ///
    /// # Errors
    /// When the backend fails, or counts the plan differently; when no mount can be anywhere but where it is planned;
    /// when a person cannot be read; `Error::Stopped`.
    pub fn count(
        &self,
        asked: &[Condition],
        planned: &mut Conditions,
        backends: &mut dyn BackendFactory,
        progress: &dyn Progress,
    ) -> Result<Option<Draws>> {
        let variants = self.left_out(asked);
        planned.take(self.count_variants(self.study, self.worlds, variants, backends, progress)?)?;
        let mut drawn = None;
        if let Some(error) = self.error(asked) {
            let draws = self.draws(error)?;
            let of_draw = |draw| CaseVariant {
                condition: Condition::MountingError,
                alteration: Alteration::Draw(draw),
                members: self.draw(&draws, draw),
                kept: self.planned_members(&draws, draw),
                warnings: Vec::new(),
            };
            let variants = (0..error.draws).map(of_draw).collect();
            planned.take(self.count_variants(
                &draws.study,
                &draws.worlds,
                variants,
                backends,
                progress,
            )?)?;
            drawn = Some(draws);
        }
        if asked.contains(&Condition::Postures) {
            for posture in &self.study.postures {
                // One at a time, since each has voxels of its own.
                let Stood { study, worlds, warnings } = Stood::new(self.study, self.worlds, posture)?;
                let variant = CaseVariant {
                    condition: Condition::Postures,
                    alteration: Alteration::Posture(posture.name.clone()),
                    members: self.members.clone(),
                    kept: Vec::new(),
                    warnings,
                };
                planned.take(self.count_variants(&study, &worlds, vec![variant], backends, progress)?)?;
            }
        }
        Ok(drawn)
    }

    pub(super) fn draws(&self, error: &MountingError) -> Result<Draws> {
        Draws::new(self.study, self.worlds, error, self.members.iter().map(|&[s, c, _]| [s, c]))
    }

    /// The members in one draw of their mounts.
    pub(super) fn draw(&self, draws: &Draws, draw: u32) -> Vec<[usize; 3]> {
        self.members.iter().map(|&[s, c, way]| [s, draws.candidate([s, c], draw), way]).collect()
    }

    /// The members that are as planned in a draw, by their names.
    fn planned_members(&self, draws: &Draws, draw: u32) -> Vec<String> {
        let kept = self.members.iter().filter(|&&[s, c, _]| draws.keeps([s, c], draw));
        kept.map(|&member| self.name(member)).collect()
    }

    /// The set whole, and without sensors that are dead.
    pub(super) fn left_out(&self, asked: &[Condition]) -> Vec<CaseVariant> {
        let mut dead = vec![(Condition::AsPlanned, Vec::new())];
        for (condition, count) in [(Condition::OneSensorDead, 1), (Condition::TwoSensorsDead, 2)] {
            if asked.contains(&condition) {
                dead.extend(
                    dead_members(self.members.len(), count).into_iter().map(|dead| (condition, dead)),
                );
            }
        }
        let variant = |(condition, dead): (Condition, Vec<usize>)| {
            let members = self.remaining_members(&dead);
            let names = || dead.iter().map(|&number| self.name(self.members[number])).collect();
            let alteration = if dead.is_empty() { Alteration::None } else { Alteration::Dead(names()) };
            CaseVariant { condition, alteration, members, kept: Vec::new(), warnings: Vec::new() }
        };
        dead.into_iter().map(variant).collect()
    }

    /// The numbers of the members with these names.
    ///
    /// # Errors
    /// When there is none of a name.
    pub(super) fn dead(&self, sensors: &[String]) -> Result<Vec<usize>> {
        let known = self.names();
        let number = |sensor: &String| {
            known.iter().position(|name| name == sensor).ok_or_else(|| {
                let place = Site::Argument(Argument("dead"), sensor.clone());
                Error::from(Issue::unknown(&known).with_place(place))
            })
        };
        sensors.iter().map(number).collect()
    }

    /// The members but for those with these numbers.
    pub(super) fn remaining_members(&self, dead: &[usize]) -> Vec<[usize; 3]> {
        let left = self.members.iter().enumerate().filter(|(number, _)| !dead.contains(number));
        left.map(|(_, member)| *member).collect()
    }

    /// The names of all members.
    pub(super) fn names(&self) -> Vec<String> {
        self.members.iter().map(|&member| self.name(member)).collect()
    }

    fn name(&self, [sensor, candidate, _]: [usize; 3]) -> String {
        let sensor = &self.study.sensors[sensor];
        format!("{}:{}", sensor.name, sensor.candidates[candidate].name)
    }

    /// Members as a combination with one choice of poses, and the number of their representation there.
    pub(super) fn as_combination(
        &self,
        study: &Study,
        members: &[[usize; 3]],
        name: String,
    ) -> (Combination, usize) {
        let combination = WhatIf::combination(members, name, self.fusion);
        let wanted = members.iter().map(|member| member[2]);
        let ways = combination.representations(&study.sensors);
        let way = ways.iter().position(|way| way.iter().copied().eq(wanted.clone())).unwrap_or_default();
        (combination, way)
    }

    /// How many cases these conditions have.
    pub(super) fn cases_under(&self, asked: &[Condition]) -> u64 {
        let draws = self.error(asked).map_or(0, |error| u64::from(error.draws));
        let postures = if asked.contains(&Condition::Postures) { self.study.postures.len() } else { 0 };
        let left_out = self.left_out(asked);
        let left_out = left_out.iter().filter(|variant| asked.contains(&variant.condition)).count();
        (left_out + postures) as u64 + draws
    }

    /// Members as a combination with one choice of poses.
    pub(super) fn combination(members: &[[usize; 3]], name: String, fusion: Fusion) -> Combination {
        let member = |&[sensor, candidate, _]: &[usize; 3]| Member { sensor, candidates: vec![candidate] };
        Combination { name, fusion, members: members.iter().map(member).collect() }
    }

    /// Variants with what each counts.
    fn count_variants(
        &self,
        study: &Study,
        worlds: &[World],
        variants: Vec<CaseVariant>,
        backends: &mut dyn BackendFactory,
        progress: &dyn Progress,
    ) -> Result<Vec<(CaseVariant, CountsOf)>> {
        // Nobody speaks in a set without sensors.
        let nothing = |region: usize| -> Vec<Confusion> {
            let each: Vec<Confusion> =
                worlds.iter().map(|world| world.baselines[region].nothing_seen).collect();
            each.repeat(study.repeats as usize)
        };
        let mut counts: Vec<CountsOf> = Vec::new();
        let mut speaking = Vec::new();
        for (number, variant) in variants.iter().enumerate() {
            let is_silent = variant.members.is_empty();
            if !is_silent {
                speaking.push((number, variant));
            }
            let of_region = |region| if is_silent { nothing(region) } else { Vec::new() };
            counts.push((0..study.regions.len()).map(of_region).collect());
        }
        if speaking.is_empty() {
            return Ok(variants.into_iter().zip(counts).collect());
        }
        let combination = |&(number, variant): &(usize, &CaseVariant)| {
            WhatIf::combination(&variant.members, number.to_string(), self.fusion)
        };
        let combinations = speaking.iter().map(combination).collect();
        let study = one_way(study, &speaking, combinations);
        let ways: Vec<Vec<Vec<usize>>> =
            study.combinations.iter().map(|one| one.representations(&study.sensors)).collect();
        let mut rows = run_on(&study, worlds, backends, progress)?;
        rows.sort_by_key(|row| row.repeat);
        for row in rows {
            let (number, variant) = speaking[row.combination];
            let wanted = variant.members.iter().map(|&[sensor, _, way]| {
                // A sensor that is left with one representation has it under the number 0.
                let is_alone = study.sensors[sensor].kind.representations().len() == 1;
                if is_alone { 0 } else { way }
            });
            if wanted.eq(ways[row.combination][row.representation].iter().copied()) {
                counts[number][row.region].push(row.counts);
            }
        }
        Ok(variants.into_iter().zip(counts).collect())
    }
}

impl Conditions {
    /// Adds the cases of variants.
    ///
    /// # Errors
    /// When the plan is counted differently than before.
    fn take(&mut self, counted: Vec<(CaseVariant, CountsOf)>) -> Result<()> {
        for (variant, counts) in counted {
            match variant.condition {
                Condition::AsPlanned => same(&self.cases(Condition::AsPlanned)[0].counts, &counts)?,
                condition => self.add(condition, variant.case(counts)),
            }
        }
        Ok(())
    }

    fn add(&mut self, condition: Condition, case: Case) {
        match self.cases.iter_mut().find(|(known, _)| *known == condition) {
            Some((_, cases)) => cases.push(case),
            None => self.cases.push((condition, vec![case])),
        }
    }
}

/// Which members of a set of so many are dead in each case of a condition under which 0, 1 or 2 are. Of one sensor alone
/// no two can be dead: the worst is that it is.
pub(crate) fn dead_members(members: usize, dead: usize) -> Vec<Vec<usize>> {
    let all = 0..members;
    match dead {
        0 => vec![Vec::new()],
        2 if members > 1 => all.clone().flat_map(|a| (a + 1..all.end).map(move |b| vec![a, b])).collect(),
        _ => all.map(|one| vec![one]).collect(),
    }
}

/// The study with these combinations, its sensors each in one representation where the variants ask for no other.
fn one_way(study: &Study, variants: &[(usize, &CaseVariant)], combinations: Vec<Combination>) -> Study {
    let mut ways: Vec<Option<usize>> = vec![None; study.sensors.len()];
    for &[sensor, _, way] in variants.iter().flat_map(|(_, variant)| &variant.members) {
        if ways[sensor].replace(way).is_some_and(|before| before != way) {
            return Study { combinations, ..study.clone() };
        }
    }
    let ways: Vec<usize> = ways.into_iter().map(Option::unwrap_or_default).collect();
    study.with_combinations(&ways, combinations)
}

/// Fails unless a set counts the same as in the sweep.
fn same(swept: &[Vec<Confusion>], counted: &[Vec<Confusion>]) -> Result<()> {
    match swept == counted {
        true => Ok(()),
        false => {
            let what = "the set as planned is counted differently than in the sweep: report this";
            Err(Error::Disagreement(Issue::says(what)))
        }
    }
}
