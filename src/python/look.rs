//! One choice of poses looked at closely, as `perirobot why`, `approach` and `render` do it.

use std::path::Path;

use glam::DVec3;
use perirobot_decide::approach::{Approaching, fusion_warning};
use perirobot_decide::judge::{Alteration, alter};
use perirobot_decide::look::Look;
use perirobot_decide::view::{ChoiceSelector, View, Viewer, find, find_scene, with_set};
use perirobot_march::backend::Backend;
use perirobot_march::error::{Argument, Issue, Site};
use perirobot_march::{Error, Result};
use perirobot_page::export::each_file;
use perirobot_page::render::plan::floor_plan;
use perirobot_page::render::{Colour, Eye, Wish, draw};
use perirobot_page::report::reasons_file;
use perirobot_page::report::terminal::reasons;
use perirobot_scene::objects::build::build;
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_sweep::results::files::OutputFolder;
use pyo3::FromPyObject;

use crate::watch::Listener;

/// What is not as planned: dead sensors, the number of a draw of the mounts, a posture; one of them at most.
pub(crate) type AlterationWords = (Vec<String>, Option<u32>, Option<String>);

/// What a picture is to show, as Python's `Study.render` has it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct WishWords {
    side: String,
    eye_m: Option<[f64; 3]>,
    look_at_m: Option<[f64; 3]>,
    fov_deg: f64,
    size: [u32; 2],
    colour: Option<String>,
    only_region: Option<String>,
    cut_above: Option<f64>,
    open: f64,
    points: usize,
    approach: bool,
    floor_plan: bool,
}

/// What is different, of its words.
pub(crate) fn alteration((dead, draw, posture): AlterationWords) -> Alteration {
    match (posture, draw) {
        (Some(name), _) => Alteration::Posture(name),
        (None, Some(draw)) => Alteration::Draw(draw),
        (None, None) if dead.is_empty() => Alteration::None,
        (None, None) => Alteration::Dead(dead),
    }
}

/// The study with the set that is named, if no combination lists it.
pub(crate) fn with_named_set(study: &Study, wanted: &ChoiceSelector) -> Study {
    with_set(study.clone(), &wanted.poses, wanted.combination.as_deref())
}

/// Why voxels of all regions stay unknown: in words, and the rows of `reasons.csv`.
pub(crate) fn why(
    (study, worlds): (&Study, &[World]),
    wanted: &ChoiceSelector,
    alteration: Alteration,
    backend: &mut dyn Backend,
) -> Result<(String, Vec<u8>)> {
    let study = with_named_set(study, wanted);
    let look = Look::new(&study, worlds, wanted, alteration)?;
    let views = Viewer::new(&look.study, backend)?.view_regions(look.world(), &[look.choice])?;
    let missed = views[0].why_in_regions();
    let words = reasons::render(&views[0], &missed, 0..study.regions.len());
    Ok((words, reasons_file::csv(&views[0], &missed)?))
}

/// Answers how near bodies come unnoticed, and writes the files of `perirobot approach`; the answers in words.
pub(crate) fn approach(
    (study, worlds): (&Study, &[World]),
    wanted: &ChoiceSelector,
    alteration: &Alteration,
    out: &Path,
    listener: &Listener,
) -> Result<String> {
    let study = with_named_set(study, wanted);
    let choice = find(&study, worlds, wanted)?.1;
    fusion_warning(&study, &choice).into_iter().for_each(|warning| listener.warns_of_study(warning));
    let (own_study, own_worlds, own) = alter(&study, worlds, &choice, alteration)?;
    let altered = (&own_study, own_worlds.as_slice(), own);
    let approaching = Approaching::new((&study, worlds, choice), altered, alteration)?;
    let folder = OutputFolder::open(out)?;
    listener.begins("moments", approaching.total());
    let mut words = String::new();
    let approached = approaching.answer(listener, &mut |of_scene| {
        words += of_scene;
        Ok(())
    })?;
    if let Some(stopping) = &study.stopping {
        words += &format!("{}\n", stopping.assumptions(study.voxel_size_m).join("\n"));
    }
    for name in approached.write(&folder)? {
        let path = folder.path().join(name);
        listener.warns_of_study(format!("{}: is no floor plan of this run", path.display()));
    }
    Ok(words)
}

/// Writes what a choice of poses sees for other programs, as `perirobot export` does: names of files, and what they hold.
pub(crate) fn export(
    (study, worlds): (&Study, &[World]),
    wanted: &ChoiceSelector,
    alteration: Alteration,
    out: &Path,
    backend: &mut dyn Backend,
) -> Result<Vec<(String, String)>> {
    let study = with_named_set(study, wanted);
    let look = Look::new(&study, worlds, wanted, alteration)?;
    let world = look.world();
    let view = View::new(&look.study, world, look.choice, backend)?;
    let spec = &look.study.scenes[world.scene];
    let scene = build(spec, &study.sources, study.voxel_size_m)?.swap_remove(world.snapshot);
    let folder = OutputFolder::open(out)?;
    let mut files = Vec::new();
    each_file(&view, &scene, |file| {
        folder.write(&file.name, &file.bytes)?;
        files.push((file.name, file.holds));
        Ok(())
    })?;
    Ok(files)
}

/// Draws a scene, or what a choice of poses makes of it, if one is named: the bytes of a PNG, or of an SVG.
pub(crate) fn render(
    (study, worlds): (&Study, &[World]),
    (wanted, has_poses): (&ChoiceSelector, bool),
    alteration: Alteration,
    words: &WishWords,
    backend: &mut dyn Backend,
) -> Result<Vec<u8>> {
    let study = if has_poses { with_named_set(study, wanted) } else { study.clone() };
    let scene = find_scene(&study, wanted)?;
    let mut wish = words.wish(&study, has_poses)?;
    let worlds: Vec<World> = worlds.iter().filter(|world| world.scene == scene).cloned().collect();
    let look = has_poses.then(|| Look::new(&study, &worlds, wanted, alteration)).transpose()?;
    wish.case = look.as_ref().map_or(String::new(), |one| one.case());
    if let Some(look) = look.as_ref().filter(|_| words.approach) {
        wish.ways = look.ways()?;
    }
    if words.floor_plan {
        let (study, worlds, choice) = match &look {
            Some(one) => (&one.study, one.worlds(), Some(one.choice)),
            None => (&study, worlds.as_slice(), None),
        };
        let plan = floor_plan(study, worlds, wanted.snapshot, choice).with_ways(&wish.ways).alone();
        return Ok(plan.into_bytes());
    }
    let view =
        look.as_ref().map(|one| View::new(&one.study, one.world(), one.choice, backend)).transpose()?;
    let world = look.as_ref().map_or(&worlds[wanted.snapshot], |one| one.world());
    draw(world, view.as_ref(), &wish, backend)?.png()
}

impl WishWords {
    fn wish(&self, study: &Study, has_poses: bool) -> Result<Wish> {
        let side = || {
            let eye: Result<Eye, Issue> = self.side.parse();
            // At the command line it is called otherwise.
            eye.map_err(|issue| Error::from(issue.with_place(format!("eye {:?}", self.side))))
        };
        let regions: Vec<&str> = study.regions.iter().map(|(name, _)| name.as_str()).collect();
        let region = |name: &String| {
            let place = Site::Argument(Argument("only region"), name.clone());
            let found = regions.iter().position(|region| region == name);
            found.ok_or_else(|| Error::from(Issue::unknown(&regions).with_place(place)))
        };
        let colour = match (self.colour.as_deref(), has_poses) {
            (Some("label"), _) | (None, true) => Colour::Label,
            (Some("role"), _) | (None, false) => Colour::Role,
            (Some("height"), _) => Colour::Height,
            (Some("x"), _) => Colour::X,
            (Some(other), _) => {
                let wanted = "must be \"label\", \"role\", \"height\" or \"x\"";
                return Err(Issue::value("colour", format!("{other:?}"), wanted).into());
            }
        };
        let wish = Wish {
            eye: self.eye_m.map_or_else(side, |at| Ok(Eye::At(DVec3::from_array(at))))?,
            look_at_m: self.look_at_m.map(DVec3::from_array),
            fov_rad: self.fov_deg.to_radians(),
            size_px: self.size,
            colour,
            only_region: self.only_region.as_ref().map(region).transpose()?,
            cut_above_m: self.cut_above,
            open_m: self.open,
            points: self.points,
            ways: Vec::new(),
            case: String::new(),
        };
        wish.check().map(|()| wish)
    }
}
