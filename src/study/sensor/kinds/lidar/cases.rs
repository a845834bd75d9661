//! The fields between which a scanner switches, by the moment or by how fast something moves.

use std::collections::BTreeSet;
use std::path::PathBuf;

use serde::Deserialize;

use super::field::{Outline, ProtectiveField, outline};
use super::zone::{ZoneFile, speed_warning};
use crate::diagnostics::Place;
use crate::keys::exactly_if_given;
use crate::sensor::Station;
use crate::sensor::kinds::Context;
use crate::sensor::kinds::shared::{Silence, length};
use crate::sensor::prism::Prism;
use perirobot_march::Result;
use perirobot_scene::objects::Role;
use perirobot_scene::objects::spec::SceneSpec;
use perirobot_scene::objects::speed::{is_known, to_mm_s};

/// The highest speed of a condition, in metres a second.
const FASTEST_M_S: f64 = 100.0;

/// A field to which a scanner switches while all conditions hold that are written.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct FieldCaseFile {
    /// Its name, as in the scanner's configuration.
    name: String,
    /// Condition: the moment is one of these snapshots of a scene, counted from 0.
    at: Option<Vec<usize>>,
    /// Condition: the scene is one of these names.
    scenes: Option<Vec<String>>,
    /// Condition: an object moves at [from, to] metres a second, both included.
    #[serde(default, deserialize_with = "exactly_if_given")]
    speed_m_s: Option<[f64; 2]>,
    /// The object whose speed counts. Default the robot of `on`, which carries the scanner.
    of: Option<String>,
    /// Corners of its field, as in `field`.
    polygon_m: Option<Vec<[f64; 2]>>,
    /// Instead of polygon_m: a table of corners, as in `field`.
    polygon: Option<PathBuf>,
    /// Instead of polygon_m: a zone of a PSENscan by Pilz, as in `field`.
    psenscan: Option<ZoneFile>,
    /// Height of the volume above it, in metres. Default that of `field`.
    height_m: Option<f64>,
    /// What it says about its volume without returns. Default as `field`.
    otherwise: Option<Silence>,
}

/// The fields of a scanner.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FieldSet {
    /// The one that counts if no case applies.
    pub(crate) usual: ProtectiveField,
    /// Others: the first that applies counts.
    pub(crate) cases: Vec<FieldCase>,
}

/// A field with the conditions under which it applies.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FieldCase {
    /// Its name.
    pub(crate) name: String,
    /// When it applies.
    pub(crate) when: CaseRule,
    /// The field.
    pub(crate) field: ProtectiveField,
}

/// Conditions that must all hold; what is `None` is none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct CaseRule {
    /// The snapshots.
    pub(crate) at: Option<Vec<usize>>,
    /// The numbers of the scenes.
    pub(crate) scenes: Option<Vec<usize>>,
    /// An object, and its lowest and highest speed in millimetres a second.
    pub(crate) speed_mm_s: Option<(String, [u32; 2])>,
}

impl From<ProtectiveField> for FieldSet {
    fn from(usual: ProtectiveField) -> FieldSet {
        FieldSet { usual, cases: Vec::new() }
    }
}

impl FieldSet {
    /// The names of its cases.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.cases.iter().map(|case| case.name.as_str())
    }

    /// The cases that apply at a station's moment, the one that counts first.
    pub(super) fn applying(&self, at: &Station) -> impl Iterator<Item = usize> {
        (0..self.cases.len()).filter(|&case| self.cases[case].when.holds(at))
    }

    /// The field of a case, or the usual one.
    pub(super) fn case(&self, case: Option<usize>) -> &ProtectiveField {
        case.map_or(&self.usual, |case| &self.cases[case].field)
    }

    /// The field that counts at a station's moment.
    pub(super) fn field(&self, at: &Station) -> &ProtectiveField {
        self.case(self.applying(at).next())
    }
}

impl CaseRule {
    fn holds(&self, at: &Station) -> bool {
        let [scene, snapshot] = at.moment;
        let has_speed = |(object, [from, to]): &(String, [u32; 2])| {
            at.truth.speed_mm_s(object).is_some_and(|speed| (*from..=*to).contains(&speed))
        };
        self.at.as_ref().is_none_or(|all| all.contains(&snapshot))
            && self.scenes.as_ref().is_none_or(|all| all.contains(&scene))
            && self.speed_mm_s.as_ref().is_none_or(has_speed)
    }
}

/// Checks the cases of a scanner, and adds them to its usual field.
pub(super) fn check(
    at: &Place,
    usual: Option<ProtectiveField>,
    files: Vec<FieldCaseFile>,
    context: &Context,
    warnings: &mut Vec<String>,
) -> Result<Option<FieldSet>> {
    let Some(usual) = usual else {
        return match files.is_empty() {
            true => Ok(None),
            false => Err(at.says("field_cases without field").with_advice(
                "write field = { polygon_m = [[x, y], ...], height_m }, which counts when no case applies",
            )),
        };
    };
    at.unique("field case", files.iter().map(|file| file.name.as_str()))?;
    let cases =
        files.into_iter().map(|file| file.check(at, &usual, context, warnings)).collect::<Result<_>>()?;
    Ok(Some(FieldSet { cases, usual }))
}

impl FieldCaseFile {
    fn check(
        self,
        at: &Place,
        usual: &ProtectiveField,
        context: &Context,
        warnings: &mut Vec<String>,
    ) -> Result<FieldCase> {
        let at = &at.key(&format!("field_cases {:?}", self.name));
        let when = self.rule(at, context)?;
        let height_m = self.height_m.map(|height_m| length(at, "height_m", height_m)).transpose()?;
        let z_m = [0.0, height_m.unwrap_or(usual.volume.z_m[1])];
        let Outline { polygon_m, speeds_cm_s } =
            outline(at, self.polygon_m, self.polygon, self.psenscan, context.sources)?;
        let warning = self.speed_m_s.zip(speeds_cm_s).and_then(|(ours, theirs)| speed_warning(ours, theirs));
        warnings.extend(warning.map(|warning| format!("field_cases {:?}: {warning}", self.name)));
        let otherwise_free =
            self.otherwise.map_or(usual.otherwise_free, |silence| silence != Silence::Unknown);
        let field = ProtectiveField { volume: Prism { polygon_m, z_m }, otherwise_free };
        Ok(FieldCase { name: self.name, when, field })
    }

    fn rule(&self, at: &Place, context: &Context) -> Result<CaseRule> {
        if self.at.is_none() && self.scenes.is_none() && self.speed_m_s.is_none() {
            return Err(at
                .says("has no condition")
                .with_advice("write at = [snapshots], scenes = [names] or speed_m_s = [from, to]"));
        }
        let scenes = self.scenes.as_deref().map(|names| scenes(at, names, context)).transpose()?;
        if let Some(snapshots) = &self.at {
            check_snapshots(at, snapshots, scenes.as_deref(), context)?;
        }
        let speed_mm_s = match (self.speed_m_s, &self.of) {
            (Some(range), of) => Some(speed(at, range, of.as_deref(), scenes.as_deref(), context)?),
            (None, Some(of)) => {
                let rule = "belongs to speed_m_s = [from, to], which is missing: write it, or remove of";
                return Err(at.wrong("of", format!("{of:?}"), rule));
            }
            (None, None) => None,
        };
        Ok(CaseRule { at: self.at.clone(), scenes, speed_mm_s })
    }
}

/// The numbers of scenes by their names; that of a scene with places of a robot stands for all of them.
fn scenes<'c>(at: &Place, names: &[String], context: &'c Context) -> Result<Vec<usize>> {
    at.some("scenes", names, "scenes = [\"delivery\"]")?;
    let of = |scene: &SceneSpec, name: &str| {
        scene.name == name || scene.variant.as_ref().is_some_and(|variant| variant.scene == name)
    };
    let mut numbers = Vec::new();
    for name in names {
        let before = numbers.len();
        numbers.extend((0..context.scenes.len()).filter(|&number| of(&context.scenes[number], name)));
        if numbers.len() == before && context.has_all_scenes {
            let name_of =
                |scene: &'c SceneSpec| scene.variant.as_ref().map_or(&scene.name, |variant| &variant.scene);
            let known: BTreeSet<&str> = context.scenes.iter().map(|scene| name_of(scene).as_str()).collect();
            return Err(at.unknown_name("scenes", name, "names of scenes", &Vec::from_iter(known)));
        }
    }
    Ok(numbers)
}

/// The scenes in which a case may apply.
fn possible_scenes<'c>(
    scenes: Option<&'c [usize]>,
    context: &'c Context,
) -> impl Iterator<Item = &'c SceneSpec> + Clone {
    let is_possible = move |number: &usize| scenes.is_none_or(|scenes| scenes.contains(number));
    (0..context.scenes.len()).filter(is_possible).map(|number| &context.scenes[number])
}

fn check_snapshots(
    at: &Place,
    snapshots: &[usize],
    scenes: Option<&[usize]>,
    context: &Context,
) -> Result<()> {
    at.some("at", snapshots, "at = [0]")?;
    // Of scenes that could not be read nothing is known.
    if !context.has_all_scenes {
        return Ok(());
    }
    let most = possible_scenes(scenes, context).map(|scene| scene.snapshots).max().unwrap_or(0);
    match snapshots.iter().find(|&&snapshot| snapshot >= most) {
        Some(snapshot) => {
            let rule = format!("must be snapshots of a scene, from 0 to {}", most.saturating_sub(1));
            Err(at.wrong("at", format!("[{snapshot}]"), &rule))
        }
        None => Ok(()),
    }
}

/// The object and the range of a condition on a speed.
fn speed(
    at: &Place,
    range: [f64; 2],
    of: Option<&str>,
    scenes: Option<&[usize]>,
    context: &Context,
) -> Result<(String, [u32; 2])> {
    let [from, to] = range;
    if !((0.0..=FASTEST_M_S).contains(&from) && (from..=FASTEST_M_S).contains(&to)) {
        let rule = format!("must be [from, to] in m/s, from 0 to {FASTEST_M_S}, the slower first");
        return Err(at.wrong("speed_m_s", format!("[{from}, {to}]"), &rule));
    }
    let Some(name) = of.or(context.carrier) else {
        return Err(at.says("speed_m_s without an object").with_advice(
            "write of = \"name\" with the object whose speed counts; without it that is the robot of `on`",
        ));
    };
    if context.has_all_scenes {
        let key = if of.is_some() { "of" } else { "speed_m_s" };
        check_object(at, key, name, possible_scenes(scenes, context))?;
    }
    Ok((name.into(), range.map(to_mm_s)))
}

/// Refuses people, objects that no scene has, and those of which no speed is known.
fn check_object<'c>(
    at: &Place,
    key: &str,
    name: &str,
    scenes: impl Iterator<Item = &'c SceneSpec> + Clone,
) -> Result<()> {
    let wrong = |rule: &str| Err(at.wrong(key, format!("{name:?}"), rule));
    let found: Vec<_> = scenes
        .clone()
        .flat_map(|scene| scene.objects.iter().map(move |object| (scene, object)))
        .filter(|(_, object)| object.has_part(name))
        .collect();
    if found.is_empty() {
        let mut known: Vec<&str> =
            scenes.flat_map(|scene| &scene.objects).map(|object| object.name.as_str()).collect();
        known.sort_unstable();
        known.dedup();
        return Err(at.unknown_name(key, name, "an object of a scene", &known));
    }
    for (scene, object) in found {
        if object.role == Role::Human {
            return wrong(
                "must not be a person: a scanner does not switch its fields by how fast people walk",
            );
        }
        if !is_known(object, &scene.objects) {
            let rule = format!(
                "has no known speed in scene {:?}: write speed_m_s in that object (0 if it stands still), a list \
                 snapshots.speed_m_s, or times of its motion",
                scene.name
            );
            return wrong(&rule);
        }
    }
    Ok(())
}
