//! `perirobot voxelize`: writes a scene as an OctoMap, and lists its objects.

use std::path::PathBuf;
use std::process::ExitCode;

use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::objects::{build::build, octomap};
use perirobot_scene::truth::{Truth, voxelize as voxels};
use perirobot_study::input::load_scene;
use perirobot_sweep::results::files::write_whole;

use super::packages::PackageArgs;

/// Turn a scene into voxels and write them as an OctoMap
///
/// Prints for each object its triangles, voxels, size and whether it is watertight. The file opens in
/// octovis.
#[derive(clap::Args)]
pub(super) struct Args {
    /// The scene file (TOML)
    scene: PathBuf,
    /// The .bt file to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Edge of a voxel in metres
    #[arg(long, value_name = "METRES", default_value_t = 0.05)]
    voxel_size: f64,
    /// The snapshot of a moving scene, counted from 0
    #[arg(long, value_name = "N", default_value_t = 0)]
    snapshot: usize,
    #[command(flatten)]
    packages: PackageArgs,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    super::stop::end_tidily()?;
    if !(1e-4..=10.0).contains(&args.voxel_size) {
        return Err(Issue::says(format!(
            "--voxel-size {}: must be from 0.0001 to 10 metres",
            args.voxel_size
        ))
        .into());
    }
    if args.out.extension().is_none_or(|extension| extension != "bt") {
        return Err(Issue::says(format!("--out {}: must end in .bt", args.out.display())).into());
    }
    super::backend::start_threads(None)?;
    let sources = args.packages.sources(&args.scene);
    let mut spec = load_scene(&args.scene, &sources)?;
    args.packages.apply(std::slice::from_mut(&mut spec));
    let in_scene = |e: Error| e.with_place(&spec.path);
    if args.snapshot >= spec.snapshots {
        let (wanted, count) = (args.snapshot, spec.snapshots);
        return Err(Issue::says(format!(
            "--snapshot {wanted}: {} has {count}, counted from 0",
            spec.path.display()
        ))
        .into());
    }
    let snapshots = build(&spec, &sources, args.voxel_size)?;
    let extent = voxels::scene_extent(&snapshots, args.voxel_size).map_err(in_scene)?;
    let grid = voxels::grid_over_all(&extent, args.voxel_size, &snapshots).map_err(in_scene)?;
    let keys = (0..3).flat_map(|r| [grid.origin[r], grid.origin[r] + grid.size[r] as i32 - 1]);
    if keys.into_iter().any(|key| !octomap::KEYS.contains(&key)) {
        let farthest = octomap::KEYS.end as f64 * args.voxel_size;
        let what = format!(
            "reaches more than {farthest:.0} m from the origin, the limit of an OctoMap: move it closer"
        );
        return Err(in_scene(Issue::says(what).into()));
    }
    let wanted = &snapshots[args.snapshot..=args.snapshot];
    let truth = perirobot_scene::truth::voxelize_all(wanted, grid).map_err(in_scene)?.remove(0);
    for object in &truth.objects {
        let [low, high] = object.bounds_m;
        let is_mesh = object.watertight.is_some();
        let own_m = (high - low).max_element();
        let speck = voxels::speck_question(own_m, args.voxel_size).filter(|_| is_mesh);
        for warning in object.warnings.iter().chain(&speck) {
            say!("warning: {}: object {:?} {warning}", spec.path.display(), object.name);
        }
    }
    let state = |key: [i32; 3]| {
        let cell = std::array::from_fn(|r| key[r] - grid.origin[r]);
        if truth.ignored.get(cell) { None } else { Some(truth.occupied.get(cell)) }
    };
    let bytes = octomap::write(args.voxel_size, grid.origin, grid.size, &state);
    write_whole(&args.out, &bytes)?;
    super::print(&table(&truth))?;
    super::print(&format!("\n{} bytes in {}\n", bytes.len(), args.out.display()))?;
    Ok(ExitCode::SUCCESS)
}

fn table(truth: &Truth) -> String {
    let mut text = format!(
        "{:<24} {:<12} {:>9} {:>9} {:<10} {}\n",
        "object", "role", "triangles", "voxels", "watertight", "from … to (m)"
    );
    for object in &truth.objects {
        let watertight = match object.watertight {
            Some(true) => "yes",
            Some(false) => "no",
            None => "-",
        };
        let [low, high] = object.bounds_m;
        text += &format!(
            "{:<24} {:<12} {:>9} {:>9} {:<10} {low:.2} … {high:.2}\n",
            object.name,
            format!("{:?}", object.role).to_lowercase(),
            object.triangles,
            object.voxels.count(),
            watertight
        );
    }
    let [x, y, z] = truth.grid.size;
    let (size, occupied, ignored) = (truth.grid.voxel_size_m, truth.occupied.count(), truth.ignored.count());
    text + &format!("grid {x} × {y} × {z} voxels of {size} m: {occupied} occupied, {ignored} ignored\n")
}
