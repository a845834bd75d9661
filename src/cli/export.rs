//! `perirobot export`: one choice of poses as files for other programs.

use std::path::PathBuf;
use std::process::ExitCode;

use perirobot_decide::view::View;
use perirobot_march::Result;
use perirobot_page::export::{each_file, folder_name};
use perirobot_scene::objects::build::build;
use perirobot_sweep::results::files::OutputFolder;

use super::backend::BackendArgs;
use super::choice::ChoiceArgs;
use super::swept::SweptArgs;

/// Write one choice of poses voxel by voxel, for other programs
///
/// Recomputes one row of a sweep's results, voxel by voxel, and writes the labels, the truth and each sensor's evidence
/// as OctoMaps (.bt), the returns of each sensor's rays as point clouds (.ply in the world, .pcd in the sensor's frame,
/// with its pose as VIEWPOINT), everything as arrays (view.npz) and the cell with the placed sensors as glTF (cell.glb,
/// y up, metres). For ROS 2: a bag for Foxglove and `ros2 bag play` (view.mcap), the sensors' frames as static
/// transforms (transforms.sh) and as a part of a URDF (sensors.urdf), and a camera_info for each camera.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    #[command(flatten)]
    swept: SweptArgs,
    #[command(flatten)]
    choice: ChoiceArgs,
    /// Folder for the files; created if needed. Files of the same names are replaced [default: one in DIR/export, named
    /// after the selection]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    #[command(flatten)]
    backend: BackendArgs,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot sweep scenes/quick.toml --out out/quick
  perirobot export out/quick --pose camera:right-wall/4/1
  octovis out/quick/export/camera-right-wall-4-1.scene1.points/labels.bt

In Python:
  view = numpy.load(\"view.npz\"); view[\"labels\"][i, j, k]
      1 occupied, 0 free, -1 unknown; i along x, j y, k z";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    super::stop::end_tidily()?;
    args.backend.start_threads()?;
    let (study, worlds) = args.swept.load()?;
    let study = args.choice.with_set(study);
    let looked = args.choice.look(&study, &worlds)?;
    let world = looked.world();
    let mut backend = args.backend.open()?;
    let view = View::new(&looked.study, world, looked.choice, &mut *backend)?;
    let scene =
        build(&study.scenes[world.scene], &study.sources, study.voxel_size_m)?.swap_remove(world.snapshot);
    let folder =
        args.out.clone().unwrap_or_else(|| args.swept.folder().join("export").join(folder_name(&view)));
    // If nothing can be written, a folder created here is removed again.
    let folder = OutputFolder::open(&folder)?;
    each_file(&view, &scene, |file| {
        folder.write(&file.name, &file.bytes)?;
        super::print(&format!("{:<24} {:>10} bytes  {}\n", file.name, file.bytes.len(), file.holds))
    })?;
    super::print(&format!("in {}\n", folder.path().display()))?;
    Ok(ExitCode::SUCCESS)
}
