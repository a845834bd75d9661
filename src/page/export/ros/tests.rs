use std::path::Path;
use std::process::Command;

use super::*;
use perirobot_decide::view::{ChoiceSelector, find};
use perirobot_march::backend::cpu::Cpu;
use perirobot_scene::source::Sources;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

/// The files of a choice of poses of a shipped study, and the view.
fn export(study: &str, poses: &str, test: impl FnOnce(&View, &[PlacedSensor], Vec<ExportedFile>)) {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(study);
    let study = Study::load(&path, &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    let wanted = ChoiceSelector { poses: poses.into(), ..ChoiceSelector::default() };
    let (world, choice) = find(&study, &worlds, &wanted).unwrap();
    let view = View::new(&study, world, choice, &mut Cpu::new(Some(1)).unwrap()).unwrap();
    let (octree, _) = super::super::octomap::labels(&view).unwrap();
    test(&view, &placed_sensors(&view), files(&view, &octree).unwrap());
}

fn text(files: &[ExportedFile], name: &str) -> String {
    let file = files.iter().find(|file| file.name == name);
    String::from_utf8(file.unwrap_or_else(|| panic!("no {name}")).bytes.clone()).unwrap()
}

/// Whether two rotations are equal except for unwritten digits.
fn is_as(a: DQuat, b: DQuat) -> bool {
    a.dot(b).abs() > 1.0 - 1e-11
}

const CAMERA: &str = "camera:wall/1/1";

#[test]
fn transforms_put_frames_where_the_sensors_are() {
    export("scenes/tiny.toml", CAMERA, |_, placed, files| {
        // A stub prints the arguments that the script passes to ROS.
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("said");
        let script = text(&files, "transforms.sh");
        let stand_in = format!("ros2() {{ echo \"$*\" >> '{}'; }}\n{script}", output.display());
        assert!(Command::new("sh").args(["-c", &stand_in]).status().unwrap().success());
        let output = std::fs::read_to_string(output).unwrap();
        let mut lines: Vec<Vec<&str>> = output.lines().map(|line| line.split(' ').collect()).collect();
        lines.sort_by_key(|words| words.len());
        assert_eq!(lines.len(), 2, "{output}");
        let after = |words: &[&str], flag: &str| {
            let at = words.iter().position(|word| *word == flag).unwrap();
            words[at + 1].to_string()
        };
        let own = lines.iter().find(|words| after(words, "--child-frame-id") == "camera").unwrap();
        assert_eq!(own[..4], ["run", "tf2_ros", "static_transform_publisher", "--x"]);
        assert_eq!(after(own, "--frame-id"), "world");
        let number = |flag| after(own, flag).parse::<f64>().unwrap();
        let at = DVec3::new(number("--x"), number("--y"), number("--z"));
        let turned = DQuat::from_xyzw(number("--qx"), number("--qy"), number("--qz"), number("--qw"));
        let pose = placed[0].own.pose;
        assert!((at - pose.position_m).length() < 1e-11 && is_as(turned, pose.rotation));
        // REP-103: forward is z of the optical frame, and x of the camera's.
        let optical = lines.iter().find(|words| after(words, "--child-frame-id") != "camera").unwrap();
        assert_eq!(after(optical, "--child-frame-id"), "camera_optical_frame");
        let q = ["--qx", "--qy", "--qz", "--qw"].map(|flag| after(optical, flag).parse::<f64>().unwrap());
        let turned = DQuat::from_xyzw(q[0], q[1], q[2], q[3]);
        assert!(
            (turned * DVec3::Z - DVec3::X).length() < 1e-9 && (turned * DVec3::X + DVec3::Y).length() < 1e-9
        );
    });
}

#[test]
fn the_urdf_puts_links_where_the_sensors_are() {
    export("scenes/tiny.toml", CAMERA, |_, placed, files| {
        let urdf = text(&files, "sensors.urdf")
            .replace("<robot name=\"sensors\">", "<robot name=\"s\"><link name=\"world\"/>");
        let robot = urdf_rs::read_from_string(&urdf).unwrap();
        assert_eq!(robot.joints.len(), 2);
        let found = robot.joints.iter().fold(Pose::ORIGIN, |holder, joint| {
            // Fixed axes: roll, then pitch, then yaw.
            let [roll, pitch, yaw] = joint.origin.rpy.0;
            let rotation =
                DQuat::from_rotation_z(yaw) * DQuat::from_rotation_y(pitch) * DQuat::from_rotation_x(roll);
            Pose { position_m: DVec3::from_array(joint.origin.xyz.0), rotation }.carried_by(&holder)
        });
        let (frame, expected) = placed[0].points_frame();
        assert_eq!(robot.joints[1].child.link, frame);
        assert!((found.position_m - expected.position_m).length() < 1e-11);
        assert!(is_as(found.rotation, expected.rotation), "{found:?} {expected:?}");
        // The optical frame is that of the rays.
        let axes = expected.link();
        let placement = placed[0].member.placement.axis_q15;
        for (r, row) in placement.iter().enumerate() {
            let axis = [axes.x_axis[r], axes.y_axis[r], axes.z_axis[r]];
            let close =
                row.iter().zip(axis).all(|(&q15, axis)| (f64::from(q15) / 32768.0 - axis).abs() < 1e-4);
            assert!(close, "{row:?} {axis:?}");
        }
    });
}

#[test]
fn the_camera_info_gives_the_same_rays_again() {
    export("scenes/tiny.toml", CAMERA, |view, _, files| {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("left.yaml"), text(&files, "camera_info-camera.yaml")).unwrap();
        let study = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/tiny.toml");
        let written = std::fs::read_to_string(&study).unwrap();
        let keys =
            |line: &&str| !line.starts_with("fov_deg = [87, 58]") && !line.starts_with("resolution_px");
        let kept: Vec<&str> = written.lines().filter(keys).collect();
        assert_eq!(kept.len() + 2, written.lines().count(), "the camera's two keys");
        let kept =
            kept.join("\n").replacen("kind = \"rgbd\"", "kind = \"rgbd\"\ncamera_info = \"left.yaml\"", 1);
        let changed = folder.path().join("tiny.toml");
        std::fs::write(&changed, kept).unwrap();
        std::fs::create_dir(folder.path().join("tiny")).unwrap();
        std::fs::copy(study.with_file_name("tiny/cell.toml"), folder.path().join("tiny/cell.toml")).unwrap();
        let again = Study::load(&changed, &Overrides::default()).unwrap();
        assert_eq!(again.sensors[0].warnings, Vec::<String>::new());
        let rays = |study: &Study| ray_table(study, 0).unwrap().dirs_q15.to_vec();
        assert_eq!(rays(&again), rays(view.study));
    });
}

#[test]
fn a_sensor_on_a_link_hangs_on_that_link() {
    export("scenes/sensors.toml", "wrist:hand/along", |view, placed, files| {
        let robot = text(&files, "sensors.urdf")
            .replace("<robot name=\"sensors\">", "<robot name=\"s\"><link name=\"wrist_3_link\"/>");
        let mount = &urdf_rs::read_from_string(&robot).unwrap().joints[0];
        assert_eq!((mount.parent.link.as_str(), mount.child.link.as_str()), ("wrist_3_link", "wrist"));
        // As in the study: in the link's frame, along its z.
        assert_eq!(mount.origin.xyz.0, [0.0, -0.1, 0.1]);
        let [roll, pitch, yaw] = mount.origin.rpy.0;
        let turned =
            DQuat::from_rotation_z(yaw) * DQuat::from_rotation_y(pitch) * DQuat::from_rotation_x(roll);
        assert!((turned * DVec3::X - DVec3::Z).length() < 1e-9);
        assert!(text(&files, "transforms.sh").contains("--frame-id wrist_3_link --child-frame-id wrist &"));
        // In the bag it is at the robot's pose of that moment.
        assert_eq!(placed[0].own.holder, "world");
        assert_eq!(Setting::Pose(placed[0].own.pose), view.world.settings[placed[0].member.sensor][0]);
    });
}

#[test]
fn a_cloud_of_a_bag_lies_in_the_voxels_of_the_returns() {
    for poses in [CAMERA, "lidar:posts/upright"] {
        export("scenes/tiny.toml", poses, |view, placed, files| {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("view.mcap");
            std::fs::write(&path, &files.last().unwrap().bytes).unwrap();
            let sources = Sources::from_main(&path);
            let read =
                perirobot_scene::recording::Recording::read(&path, Default::default(), &sources).unwrap();
            let grid = &view.world.grid;
            let points = read.planes(&perirobot_scene::recording::Anchor::new(DVec3::ZERO, 0.0), grid);
            let cast = placed[0].member.cast.as_ref().unwrap();
            let expected: Vec<_> = cast.planes.occupied.voxels().collect();
            assert!(expected.len() > 30);
            assert_eq!(points.planes.occupied.voxels().collect::<Vec<_>>(), expected, "{poses}");
            assert!(!points.planes.free.is_empty());
        });
    }
}

#[test]
fn frames_have_names_that_ros_takes_each_once() {
    let mut taken = BTreeSet::from(["world".to_string(), "wrist_3_link".to_string()]);
    let names =
        ["cam-1", "cam_1", "world", "2d lidar", "tür links", "x", "x_optical_frame", "wrist_3_link", "…"];
    let found = names.map(|name| frame_name(name, &mut taken));
    let expected = [
        "cam_1",
        "cam_1_2",
        "world_2",
        "sensor_2d_lidar",
        "t_r_links",
        "x",
        "x_optical_frame_2",
        "wrist_3_link_2",
        "sensor",
    ];
    assert_eq!(found, expected);
}
