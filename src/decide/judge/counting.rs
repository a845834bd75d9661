//! Counts choices of sensors in altered cases: without some sensors, with shifted mounts, and with other people.
//!
//! The evidence of each sensor is cast once for all cases of all choices with the same mounts and people, and fused for
//! each. Unions of the sensors before and behind a dead one would save fusing, which takes little time: six cameras at six
//! moments with all their 21 sets without one or two took no longer than the six alone. Log-odds are not unions.

use super::alteration::Alteration;
use super::cases::{Case, Conditions};
use super::draws::Draws;
use super::postures::PostureStudy;
use super::what_if::WhatIf;
use perirobot_march::backend::Fusion;
use perirobot_march::backend::factory::BackendFactory;
use perirobot_march::error::Issue;
use perirobot_march::metrics::Confusion;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Combination, Condition, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::Subject;
use perirobot_sweep::scoring::run_on;

/// The counts of each moment, for each region.
type CountsOf = Vec<Vec<Confusion>>;

/// The sensors of a choice in a case.
struct CaseVariant {
    /// The index of the choice.
    choice: usize,
    condition: Condition,
    alteration: Alteration,
    members: Vec<[usize; 3]>,
    fusion: Fusion,
    /// Mounts that could not be drawn.
    kept: Vec<String>,
    /// Warnings about the place of a posture.
    warnings: Vec<String>,
}

impl CaseVariant {
    fn new(choice: usize, what_if: &WhatIf, condition: Condition, alteration: Alteration) -> CaseVariant {
        CaseVariant {
            choice,
            condition,
            alteration,
            members: what_if.members.clone(),
            fusion: what_if.fusion,
            kept: Vec::new(),
            warnings: Vec::new(),
        }
    }

    fn case(self, counts: CountsOf) -> Case {
        let CaseVariant { alteration, kept, warnings, .. } = self;
        Case { alteration, kept, warnings, counts, ..Case::default() }
    }

    /// The representation of each sensor, if all its members have the same.
    fn ways(&self, sensors: usize) -> Option<Vec<Option<usize>>> {
        let mut ways = vec![None; sensors];
        let is_other =
            |&[sensor, _, way]: &[usize; 3]| ways[sensor].replace(way).is_some_and(|before| before != way);
        (!self.members.iter().any(is_other)).then_some(ways)
    }
}

/// Counts the plan of a choice without a sweep.
///
/// # Errors
/// If the backend fails; `Error::Stopped`.
pub(super) fn count_plan(
    what_if: &WhatIf,
    subject: &Subject,
    backends: &mut dyn BackendFactory,
    progress: &dyn Progress,
) -> Result<Conditions> {
    let planned = CaseVariant::new(0, what_if, Condition::AsPlanned, Alteration::None);
    let counted = count_variants(what_if.study, what_if.worlds, vec![planned], backends, progress)?;
    let counts = counted.into_iter().map(|(_, counts)| counts).next().unwrap_or_default();
    Ok(Conditions::from_plan(what_if.study, subject, counts))
}

/// Counts all cases of some conditions, and adds them to the planned counts of each choice. Returns the drawn mounts,
/// if any.
///
/// # Errors
/// If the backend fails, or counts the plan differently; if no mount of a choice can move from its planned place; if a
/// person cannot be read; `Error::Stopped`.
pub fn count_cases(
    what_ifs: &[WhatIf],
    asked: &[Condition],
    conditions: &mut [Conditions],
    backends: &mut dyn BackendFactory,
    progress: &dyn Progress,
) -> Result<Option<Draws>> {
    let Some(WhatIf { study, worlds, .. }) = what_ifs.first() else { return Ok(None) };
    let each = || what_ifs.iter().enumerate();
    let left_out = each().flat_map(|(choice, what_if)| {
        let variant = move |(condition, dead): (Condition, Vec<usize>)| {
            let names = || dead.iter().map(|&number| what_if.name(what_if.members[number])).collect();
            let alteration = if dead.is_empty() { Alteration::None } else { Alteration::Dead(names()) };
            let members = what_if.remaining_members(&dead);
            CaseVariant { members, ..CaseVariant::new(choice, what_if, condition, alteration) }
        };
        what_if.left_out(asked).into_iter().map(variant)
    });
    take(conditions, count_variants(study, worlds, left_out.collect(), backends, progress)?)?;
    let mut drawn = None;
    if let Some(error) = what_ifs[0].error(asked) {
        let used = what_ifs.iter().flat_map(|what_if| &what_if.members).map(|&[s, c, _]| [s, c]);
        let draws = Draws::new(study, worlds, error, used)?;
        what_ifs.iter().try_for_each(|what_if| draws.check_some_move(study, &what_if.members))?;
        let of_draw = |(choice, what_if), draw| CaseVariant {
            members: WhatIf::draw(what_if, &draws, draw),
            kept: what_if.planned_members(&draws, draw),
            ..CaseVariant::new(choice, what_if, Condition::MountingError, Alteration::Draw(draw))
        };
        let variants = each().flat_map(|one| (0..error.draws).map(move |draw| of_draw(one, draw)));
        let counted = count_variants(&draws.study, &draws.worlds, variants.collect(), backends, progress)?;
        take(conditions, counted)?;
        drawn = Some(draws);
    }
    if asked.contains(&Condition::Postures) {
        for posture in &study.postures {
            // One at a time, since each has its own voxels.
            let posture_study = PostureStudy::new(study, worlds, posture)?;
            let variant = |(choice, what_if)| CaseVariant {
                warnings: posture_study.warnings.clone(),
                ..CaseVariant::new(
                    choice,
                    what_if,
                    Condition::Postures,
                    Alteration::Posture(posture.name.clone()),
                )
            };
            let variants = each().map(variant).collect();
            take(
                conditions,
                count_variants(&posture_study.study, &posture_study.worlds, variants, backends, progress)?,
            )?;
        }
    }
    Ok(drawn)
}

/// The counts of variants.
fn count_variants(
    study: &Study,
    worlds: &[World],
    variants: Vec<CaseVariant>,
    backends: &mut dyn BackendFactory,
    progress: &dyn Progress,
) -> Result<Vec<(CaseVariant, CountsOf)>> {
    // A set without sensors has no labels.
    let nothing = |region: usize| -> Vec<Confusion> {
        let each: Vec<Confusion> = worlds.iter().map(|world| world.baselines[region].nothing_seen).collect();
        each.repeat(study.repeats as usize)
    };
    let silent = |variant: &CaseVariant| -> CountsOf {
        let of_region = |region| if variant.members.is_empty() { nothing(region) } else { Vec::new() };
        (0..study.regions.len()).map(of_region).collect()
    };
    let mut counts: Vec<CountsOf> = variants.iter().map(silent).collect();
    for SameWays { ways, numbers } in same_ways(study, &variants) {
        let combination = |&number: &usize| {
            let CaseVariant { members, fusion, .. } = &variants[number];
            WhatIf::combination(members, number.to_string(), *fusion)
        };
        let combinations: Vec<Combination> = numbers.iter().map(combination).collect();
        // The first representation, if no variant needs another.
        let study = match ways {
            Some(ways) => {
                let ways: Vec<usize> = ways.into_iter().map(Option::unwrap_or_default).collect();
                study.with_combinations(&ways, combinations)
            }
            None => Study { combinations, ..study.clone() },
        };
        let ways: Vec<Vec<Vec<usize>>> =
            study.combinations.iter().map(|one| one.representations(&study.sensors)).collect();
        let mut rows = run_on(&study, worlds, backends, progress)?;
        rows.sort_by_key(|row| row.repeat);
        for row in rows {
            let number = numbers[row.combination];
            let wanted = variants[number].members.iter().map(|&[sensor, _, way]| {
                // A sensor with only one representation left has it under index 0.
                let is_alone = study.sensors[sensor].kind.representations().len() == 1;
                if is_alone { 0 } else { way }
            });
            if wanted.eq(ways[row.combination][row.representation].iter().copied()) {
                counts[number][row.region].push(row.counts);
            }
        }
    }
    Ok(variants.into_iter().zip(counts).collect())
}

/// Variants, by their indices, in which every sensor has the same representation.
struct SameWays {
    /// The representation of each sensor; `None` if a variant has a sensor in several.
    ways: Option<Vec<Option<usize>>>,
    numbers: Vec<usize>,
}

/// Groups the variants with at least one sensor.
fn same_ways(study: &Study, variants: &[CaseVariant]) -> Vec<SameWays> {
    let mut groups: Vec<SameWays> = Vec::new();
    for (number, variant) in variants.iter().enumerate().filter(|(_, variant)| !variant.members.is_empty()) {
        let own = variant.ways(study.sensors.len());
        let goes_with = |group: &&mut SameWays| match (&group.ways, &own) {
            (Some(ways), Some(own)) => {
                ways.iter().zip(own).all(|(one, own)| own.is_none() || one.is_none() || one == own)
            }
            (None, None) => true,
            _ => false,
        };
        match groups.iter_mut().find(goes_with) {
            Some(SameWays { ways, numbers }) => {
                let both = ways.iter_mut().flatten().zip(own.into_iter().flatten());
                both.for_each(|(way, own)| *way = way.or(own));
                numbers.push(number);
            }
            None => groups.push(SameWays { ways: own, numbers: vec![number] }),
        }
    }
    groups
}

/// Adds the cases of variants to those of their choices.
///
/// # Errors
/// If the plan is counted differently than before.
fn take(conditions: &mut [Conditions], counted: Vec<(CaseVariant, CountsOf)>) -> Result<()> {
    for (variant, counts) in counted {
        let known = &mut conditions[variant.choice];
        match variant.condition {
            Condition::AsPlanned => same(&known.cases(Condition::AsPlanned)[0].counts, &counts)?,
            condition => known.add(condition, variant.case(counts)),
        }
    }
    Ok(())
}

impl Conditions {
    fn add(&mut self, condition: Condition, case: Case) {
        match self.cases.iter_mut().find(|(known, _)| *known == condition) {
            Some((_, cases)) => cases.push(case),
            None => self.cases.push((condition, vec![case])),
        }
    }
}

/// Fails unless a set has the counts of the sweep.
fn same(swept: &[Vec<Confusion>], counted: &[Vec<Confusion>]) -> Result<()> {
    match swept == counted {
        true => Ok(()),
        false => {
            let what = "the planned set has other counts than in the sweep: please report this";
            Err(Error::Disagreement(Issue::says(what)))
        }
    }
}
