//! A plan judged: all moments, all requirements, and how near a body comes unnoticed.

use perirobot_decide::approach::{Company, NearestApproach};
use perirobot_decide::judge::{CasePart, JudgedSet, Passage, judge_set, nearest_approaches};
use perirobot_decide::view::Choice;
use perirobot_march::metrics::{Confusion, Ratio, Score};
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_page::report::terminal::judge::line;
use perirobot_study::input::{Condition, Limit, Planned, Study};
use perirobot_study::sensor::Cost;
use perirobot_study::world::World;
use perirobot_sweep::results::Subject;
use perirobot_sweep::scoring::run_on;

use super::Live;
use super::disturbed::{DisturbingPair, disturbing};
use super::mid_air::placement_problem;
use super::score::{PlacedProblem, without_doubles};

/// What a plan is worth.
#[derive(Clone, Debug)]
pub struct JudgeAnswer {
    /// The counts of each moment, repeat by repeat.
    pub moments: Vec<MomentCounts>,
    /// Each requirement under each of its conditions, as `judge` has them.
    pub verdicts: Vec<VerdictLine>,
    /// Who comes nearest unnoticed; `None` if nobody does, or if that cannot be asked.
    pub nearest: Option<Nearest>,
    /// The worst moment, by its number, with why it is: the worst of the first requirement of counts that fails, else the
    /// one in which the largest share of the first region is unknown.
    pub worst: Option<(usize, String)>,
    /// What the sensors cost together; `None` if one has no cost.
    pub cost: Option<Cost>,
    /// What is wrong with sensors where they are, at any moment.
    pub problems: Vec<PlacedProblem>,
    /// Which of them may disturb each other, at any moment.
    pub disturbed: Vec<DisturbingPair>,
}

/// The counts of a moment.
#[derive(Clone, Debug, PartialEq)]
pub struct MomentCounts {
    /// The moment, as [`Live::worlds`] numbers them.
    pub moment: usize,
    /// The repeat.
    pub repeat: usize,
    /// Of each region.
    pub counts: Vec<Confusion>,
}

/// A verdict on a requirement under a condition.
#[derive(Clone, Debug, PartialEq)]
pub struct VerdictLine {
    /// The requirement, by its name.
    pub name: String,
    /// The safety function that it stands for.
    pub safety_function: Option<String>,
    /// The condition.
    pub condition: Condition,
    /// Whether it is met.
    pub passes: bool,
    /// The score in the worst case; `None` if a case has no value.
    pub value: Option<f64>,
    /// What it must reach, or must not exceed.
    pub limit: f64,
    /// Whether it must reach that.
    pub is_at_least: bool,
    /// The line that `judge` prints.
    pub words: String,
}

/// Who comes nearest unnoticed.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// How near, in metres, between the centres of voxels.
    pub metres: f64,
    /// In which scene, by its number; all its snapshots at once.
    pub scene: usize,
    /// Which body.
    pub body: String,
    /// Where it comes in.
    pub entry: String,
    /// Whether people of the scene are cover.
    pub has_cover: bool,
}

/// A plan without the sensors that are dead or cannot be counted.
struct LivingPlan {
    study: Study,
    worlds: Vec<World>,
    cost: Option<Cost>,
    problems: Vec<PlacedProblem>,
    disturbed: Vec<DisturbingPair>,
}

impl Live {
    /// The counts of a plan at all moments and in all repeats, perhaps with one of its sensors dead.
    ///
    /// # Errors
    /// A plan that the study does not have; when the backend fails; `Error::Stopped`.
    pub fn moments(
        &mut self,
        plan: &[Planned],
        dead: Option<usize>,
        progress: &dyn Progress,
    ) -> Result<Vec<MomentCounts>> {
        let LivingPlan { study, worlds, .. } = self.living_plan(plan, dead)?;
        let at = |moment: usize, repeat: usize| MomentCounts { moment, repeat, counts: Vec::new() };
        let repeats = 0..study.repeats as usize;
        let mut all: Vec<MomentCounts> =
            repeats.flat_map(|repeat| (0..worlds.len()).map(move |moment| at(moment, repeat))).collect();
        if study.combinations[0].members.is_empty() {
            for of in &mut all {
                of.counts = worlds[of.moment].baselines.iter().map(|region| region.nothing_seen).collect();
            }
            return Ok(all);
        }
        self.held = None;
        for row in run_on(&study, &worlds, &mut self.backends, progress)? {
            let here = |world: &World| (world.scene, world.snapshot) == (row.scene, row.snapshot);
            let moment = worlds.iter().position(here).expect("rows are of worlds that were given");
            all[row.repeat * worlds.len() + moment].counts.push(row.counts);
        }
        Ok(all)
    }

    fn living_plan(&self, plan: &[Planned], dead: Option<usize>) -> Result<LivingPlan> {
        let (kept, mut problems) = without_doubles(self.study()?, plan);
        let planned: Vec<Planned> = kept.iter().map(|&index| plan[index]).collect();
        let (mut study, worlds, candidates) = self.plan(&planned)?;
        let mut cost = Some(Cost::ZERO);
        let mut living = Vec::new();
        for ((&index, planned), candidate) in kept.iter().zip(&planned).zip(candidates) {
            let member = [planned.sensor, candidate];
            let own = study.sensors[planned.sensor].terms.cost;
            cost = cost.zip(own).map(|(sum, own)| sum.plus(own));
            let found = worlds.iter().filter_map(|world| placement_problem(world, &study, member));
            let worst = found.reduce(|a, b| if b.is_impossible && !a.is_impossible { b } else { a });
            let is_left_out = worst.as_ref().is_some_and(|problem| problem.is_impossible);
            problems.extend(worst.map(|problem| PlacedProblem { index, words: problem.words, is_left_out }));
            if is_left_out || dead == Some(index) {
                study.combinations[0].members.retain(|own| [own.sensor, own.candidates[0]] != member);
            } else {
                living.push((index, member));
            }
        }
        problems.sort_by_key(|problem| problem.index);
        let disturbed = disturbing(&study, &worlds, &living);
        Ok(LivingPlan { study, worlds, cost, problems, disturbed })
    }

    /// Judges a plan in the study's voxels, perhaps with one of its sensors dead.
    ///
    /// # Errors
    /// A plan that the study does not have; what `judge` refuses; when the backend fails; `Error::Stopped`.
    pub fn judge(
        &mut self,
        plan: &[Planned],
        dead: Option<usize>,
        progress: &dyn Progress,
    ) -> Result<JudgeAnswer> {
        let LivingPlan { study, worlds, cost, problems, disturbed } = self.living_plan(plan, dead)?;
        let choice = Choice { combination: 0, choice: 0, representation: 0, repeat: 0 };
        self.held = None;
        let set = judge_set(&study, &worlds, &choice, &mut self.backends, progress)?;
        let subject = Subject::from_study(&study, &worlds);
        let moments = moments(&set, &worlds);
        let nearest = nearest(&set, &study, &worlds, &choice, progress)?;
        let worst = worst(&set, &moments, &study);
        let verdicts = lines(&set, &subject);
        Ok(JudgeAnswer { verdicts, moments, nearest, worst, cost, problems, disturbed })
    }
}

fn moments(set: &JudgedSet, worlds: &[World]) -> Vec<MomentCounts> {
    let planned = &set.conditions.cases(Condition::AsPlanned)[0];
    let each = set.conditions.moments.iter().enumerate();
    let moment = |(number, at): (usize, &perirobot_decide::judge::Moment)| {
        let here = |world: &World| (world.scene, world.snapshot) == (at.scene, at.snapshot);
        let moment = worlds.iter().position(here).expect("moments are of worlds");
        let counts = planned.counts.iter().map(|of_region| of_region[number]).collect();
        MomentCounts { moment, repeat: at.repeat, counts }
    };
    each.map(moment).collect()
}

fn lines(set: &JudgedSet, subject: &Subject) -> Vec<VerdictLine> {
    let verdict = |judgement: &perirobot_decide::judge::Judgement| {
        let (limit, is_at_least) = match judgement.requirement.limit {
            Limit::AtLeast(limit) => (limit.value(), true),
            Limit::AtMost(limit) => (limit.value(), false),
        };
        VerdictLine {
            name: judgement.requirement.name.clone(),
            safety_function: judgement.requirement.safety_function.clone(),
            condition: judgement.condition,
            passes: judgement.is_met,
            value: judgement.value.as_ref().map(|value| value.number()),
            limit,
            is_at_least,
            words: line(subject, set, judgement),
        }
    };
    set.judgements.iter().map(verdict).collect()
}

/// Who comes nearest: as it was judged, else asked now; nobody where that cannot be asked.
fn nearest(
    set: &JudgedSet,
    study: &Study,
    worlds: &[World],
    choice: &Choice,
    progress: &dyn Progress,
) -> Result<Option<Nearest>> {
    let judged = &set.conditions.cases(Condition::AsPlanned)[0].near;
    let all: Vec<(Passage, NearestApproach)> = match judged.is_empty() {
        false => set.conditions.passages.iter().cloned().zip(judged.iter().copied()).collect(),
        true => match nearest_approaches(study, worlds, choice, progress) {
            Err(error @ Error::Stopped(_)) => return Err(error),
            asked => asked.unwrap_or_default(),
        },
    };
    let found = all.into_iter().filter_map(|(passage, near)| Some((near.squared?, passage)));
    let nearest = found.min_by_key(|(squared, _)| *squared);
    Ok(nearest.map(|(squared, passage)| Nearest {
        metres: f64::from(squared).sqrt() * study.voxel_size_m,
        scene: passage.scene,
        has_cover: passage.company == Company::Cover,
        body: passage.body,
        entry: passage.entry,
    }))
}

fn worst(set: &JudgedSet, moments: &[MomentCounts], study: &Study) -> Option<(usize, String)> {
    let failed = set.judgements.iter().filter(|judgement| !judgement.is_met);
    let mut of_counts = failed.filter_map(|judgement| match judgement.worst.part? {
        CasePart::Moment(moment) => {
            Some((moments[moment].moment, format!("fails “{}”", judgement.requirement.name)))
        }
        CasePart::Passage(_) => None,
    });
    let by_requirement = of_counts.next();
    by_requirement.or_else(|| {
        let unknown = |of: &MomentCounts| Ratio::from_score(Score::Unknown, of.counts.first()?);
        let each = moments.iter().filter_map(|of| Some((unknown(of)?, of.moment)));
        let worst = each.reduce(|a, b| if b.0.value() > a.0.value() { b } else { a })?;
        let (region, moment) = (&study.regions.first()?.0, worst.1);
        Some((moment, format!("least is known of region {region}")))
    })
}
