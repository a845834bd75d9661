//! `perirobot render`: a picture of a cell, or of the labels of a choice of poses.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use glam::DVec3;
use perirobot_decide::view::View;
use perirobot_march::error::{Argument, Issue, Site};
use perirobot_march::{Error, Result};
use perirobot_page::render::plan::floor_plan;
use perirobot_page::render::{Colour, Eye, SIDES_PX, Wish, draw, point};
use perirobot_study::world::World;
use perirobot_sweep::results::files::write_whole;

use super::backend::BackendArgs;
use super::choice::RestArgs;
use super::study::StudyArgs;
use super::swept::StudyPlace;

/// Draw a cell, or what one choice of poses makes of it
///
/// The same code casts the picture's rays and scores poses, so the CPU and any GPU draw the same bytes. With --pose the
/// colours show the label of each occupied voxel; free space labelled occupied by a volume or zone is a veil, a part of
/// the returns are dots, and the sensors are drawn at their mounts, visible through everything. From straight above
/// (--from top) the picture has the axes, names and scale bar of a floor plan. A folder of results can replace the
/// study; its placements are then drawn.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    #[command(flatten)]
    study: StudyArgs,
    /// The study file of a folder of results, if it was moved
    #[arg(id = "moved", long = "study", value_name = "FILE", help_heading = "Study")]
    moved: Option<PathBuf>,
    /// The poses, sensor:pose as `perirobot check` lists them, several joined by ";", or as in the column `poses` of
    /// results.csv [default: none, the cell alone]
    #[arg(long, value_name = "POSES")]
    pose: Option<String>,
    #[command(flatten)]
    rest: RestArgs,
    /// The .png file to write, or an .svg file for a floor plan: walls, furniture, robot, people, entries, the sensors'
    /// views and the floor that no sensor watches
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// The viewpoint: a point in world metres, or iso, top, front, back, left, right, bottom, at a distance that shows
    /// everything
    #[arg(long, value_name = "X,Y,Z|SIDE", default_value = "iso", allow_hyphen_values = true)]
    from: Eye,
    /// The centre of the picture, in world metres [default: the middle of the cell]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = point)]
    look_at: Option<DVec3>,
    /// Full horizontal angle of view in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 45.0)]
    fov_deg: f64,
    /// Width and height in pixels, including the legend below the picture
    #[arg(long, value_name = "WxH", default_value = "960x600", value_parser = size)]
    size: [u32; 2],
    /// The meaning of the colours [default: label with --pose, role without]
    #[arg(long, value_enum)]
    colour: Option<Colouring>,
    /// Draw only the inside of this region
    #[arg(long, value_name = "NAME")]
    only_region: Option<String>,
    /// Draw nothing above this height
    #[arg(long, value_name = "METRES", allow_hyphen_values = true)]
    cut_above: Option<f64>,
    /// Leave out walls and ceilings up to this thick between the viewpoint and the cell; 0 draws them
    #[arg(long, value_name = "METRES", default_value_t = 0.1)]
    open: f64,
    /// Draw about this many returns of each sensor as dots, chosen by a hash; 0 for none
    #[arg(long, value_name = "N", default_value_t = 3000)]
    points: usize,
    /// Draw the path by which each body of the study's [approach] comes closest to the robot unnoticed, over all
    /// snapshots at once, and the body at its end
    #[arg(long, requires = "pose")]
    approach: bool,
    #[command(flatten)]
    backend: BackendArgs,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot render scenes/quick.toml --out cell.png
  perirobot render scenes/quick.toml --pose camera:right-wall/4/1 \\
    --out pose.png
  perirobot render scenes/quick.toml --pose camera:right-wall/4/1 \\
    --from top --cut-above 2.2 --out above.png
  perirobot render out/quick --pose camera:right-wall/4/1 --out swept.png
  perirobot render scenes/quick.toml --pose camera:right-wall/4/1 \\
    --out plan.svg
  perirobot render scenes/approach.toml --pose wall/front --approach \\
    --out way.png
  perirobot render scenes/quick.toml --from 2.8,1.8,2.7 --look-at 0,0,0.8 \\
    --fov-deg 77 --colour height --out inside.png";

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Colouring {
    /// The sensors' labels: labelled occupied, unknown, labelled free; people and the robot in other colours
    Label,
    /// From the lowest voxel to the highest
    Height,
    /// Along x
    X,
    /// People, the robot, everything else
    Role,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    super::stop::end_tidily()?;
    let ends_in = |ending: &str| args.out.extension().is_some_and(|extension| extension == ending);
    if !ends_in("png") && !ends_in("svg") {
        let what = format!("--out {}: must end in .png, or in .svg for a floor plan", args.out.display());
        return Err(Issue::says(what).into());
    }
    args.backend.start_threads()?;
    let place = StudyPlace { named: args.moved.as_deref(), cure: ", or name the study: --study FILE" };
    let swept = args.study.load_folder(place)?;
    let (study, swept) = match swept {
        Some((study, worlds)) => (study, Some(worlds)),
        None => (args.study.read()?, None),
    };
    let study = match &args.pose {
        Some(poses) => args.rest.with_set(study, poses),
        None => study,
    };
    let (scene, snapshot) = args.rest.find_scene(&study)?;
    let regions: Vec<&str> = study.regions.iter().map(|(name, _)| name.as_str()).collect();
    let mut wish = args.wish(&regions)?;
    let mut worlds = swept.map_or_else(|| World::prepare(&study, scene), Ok)?;
    worlds.retain(|world| world.scene == scene);
    super::warn(
        worlds.iter().map(|world| (world.name.as_str(), world.warnings.as_slice())),
        super::MOST_WARNINGS,
    );
    let looked = args.pose.as_ref().map(|poses| args.rest.look(poses, &study, &worlds)).transpose()?;
    wish.case = looked.as_ref().map_or(String::new(), |one| one.case());
    if let Some(looked) = looked.as_ref().filter(|_| args.approach) {
        wish.ways = looked.ways()?;
        wish.ways.iter().try_for_each(|way| super::print(&format!("{}\n", way.words())))?;
        if wish.ways.is_empty() {
            super::print("every body of [approach] is noticed at every entry\n")?;
        }
    }
    if ends_in("svg") {
        let (study, worlds, choice) = match &looked {
            Some(one) => (&one.study, one.worlds(), Some(one.choice)),
            None => (&study, worlds.as_slice(), None),
        };
        let plan = floor_plan(study, worlds, snapshot, choice).with_ways(&wish.ways).alone();
        write_whole(&args.out, plan.as_bytes())?;
        super::print(&format!("floor plan, {} bytes in {}\n", plan.len(), args.out.display()))?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut backend = args.backend.open()?;
    let view = looked.as_ref().map(|one| View::new(&one.study, one.world(), one.choice, &mut *backend));
    let view = view.transpose()?;
    let world = looked.as_ref().map_or(&worlds[snapshot], |one| one.world());
    let picture = draw(world, view.as_ref(), &wish, &mut *backend)?;
    let bytes = picture.png()?;
    write_whole(&args.out, &bytes)?;
    let [width, height] = picture.size_px();
    super::print(&format!("{width} × {height} pixels, {} bytes in {}\n", bytes.len(), args.out.display()))?;
    Ok(ExitCode::SUCCESS)
}

impl Args {
    /// The requested picture, in a study with these regions.
    fn wish(&self, regions: &[&str]) -> Result<Wish> {
        let region = |name: &String| {
            let found = regions.iter().position(|region| region == name);
            let place = Site::Argument(Argument("only region"), name.clone());
            found.ok_or_else(|| Error::from(Issue::unknown(regions).with_place(place)))
        };
        let colour = match (self.colour, &self.pose) {
            (Some(Colouring::Label), _) | (None, Some(_)) => Colour::Label,
            (Some(Colouring::Height), _) => Colour::Height,
            (Some(Colouring::X), _) => Colour::X,
            (Some(Colouring::Role), _) | (None, None) => Colour::Role,
        };
        let wish = Wish {
            eye: self.from,
            look_at_m: self.look_at,
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

/// Reads `960x600`.
fn size(text: &str) -> Result<[u32; 2], String> {
    let parts =
        text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    let (least, most) = (SIDES_PX.start(), SIDES_PX.end());
    parts
        .filter(|size: &[u32; 2]| size.iter().all(|side| SIDES_PX.contains(side)))
        .ok_or_else(|| format!("must be width x height in pixels from {least} to {most}, as in 960x600"))
}
