//! Counts choices of sensors in altered cases: without some sensors, with shifted mounts, and with other people.
//!
//! The evidence of each sensor is cast once for all cases of all choices with the same mounts and people, and fused for
//! each. Unions of the sensors before and behind a dead one would save fusing, which takes little time: six cameras at six
//! moments with all their 21 sets without one or two took no longer than the six alone. Log-odds are not unions.

use super::alteration::Alteration;
use super::cases::{Case, Conditions};
use super::draws::Draws;
use super::postures::Stood;
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

/// For each region the counts of each moment.
type CountsOf = Vec<Vec<Confusion>>;

/// The sensors of a choice in a case.
struct CaseVariant {
    /// The number of the choice.
    choice: usize,
    condition: Condition,
    alteration: Alteration,
    members: Vec<[usize; 3]>,
    fusion: Fusion,
    /// Mounts that could not be drawn.
    kept: Vec<String>,
    /// What is wrong with where somebody stands.
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

    /// The representation of each sensor, if all its members are in the same one.
    fn ways(&self, sensors: usize) -> Option<Vec<Option<usize>>> {
        let mut ways = vec![None; sensors];
        let is_other =
            |&[sensor, _, way]: &[usize; 3]| ways[sensor].replace(way).is_some_and(|before| before != way);
        (!self.members.iter().any(is_other)).then_some(ways)
    }
}

/// Counts the plan of a choice that was not swept.
///
/// # Errors
/// When the backend fails; `Error::Stopped`.
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

/// Counts all cases of some conditions, and adds them to what was counted of each choice as planned. The mounts that were
/// drawn are the answer, if any were.
///
/// # Errors
/// When the backend fails, or counts the plan differently; when no mount of a choice can be anywhere but where it is
/// planned; when a person cannot be read; `Error::Stopped`.
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
            // One at a time, since each has voxels of its own.
            let stood = Stood::new(study, worlds, posture)?;
            let variant = |(choice, what_if)| CaseVariant {
                warnings: stood.warnings.clone(),
                ..CaseVariant::new(
                    choice,
                    what_if,
                    Condition::Postures,
                    Alteration::Posture(posture.name.clone()),
                )
            };
            let variants = each().map(variant).collect();
            take(conditions, count_variants(&stood.study, &stood.worlds, variants, backends, progress)?)?;
        }
    }
    Ok(drawn)
}

/// Variants with what each counts.
fn count_variants(
    study: &Study,
    worlds: &[World],
    variants: Vec<CaseVariant>,
    backends: &mut dyn BackendFactory,
    progress: &dyn Progress,
) -> Result<Vec<(CaseVariant, CountsOf)>> {
    // Nobody speaks in a set without sensors.
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
        // Sensors are each in one representation where no variant asks for another.
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
                // A sensor that is left with one representation has it under the number 0.
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

/// Variants, by their numbers, of which all have a sensor in the same representation.
struct SameWays {
    /// That of each sensor; none of a variant that has a sensor in several.
    ways: Option<Vec<Option<usize>>>,
    numbers: Vec<usize>,
}

/// Groups the variants in which somebody speaks.
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

/// Adds the cases of variants to what is known of their choices.
///
/// # Errors
/// When the plan is counted differently than before.
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
