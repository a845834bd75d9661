//! A sensor's returns as a point cloud: PLY for CloudCompare, MeshLab, Open3D and Blender, PCD for PCL and ROS. Both
//! contain, for each point, x, y, z in metres (float32), the index of its ray, and the verdict on its voxel's label (0
//! … 5: tp, fp, fn, tn, uo, uf). The points of a PLY are in the world; those of a PCD in the sensor's frame (x forward,
//! y left, z up), and its VIEWPOINT is the sensor's pose in the world.

use glam::DVec3;

use super::title;
use perirobot_decide::view::{ReturnPoint, SensorView, View};
use perirobot_scene::pose::Pose;

/// A binary PLY file.
pub(crate) fn ply(view: &View, member: &SensorView, returns: &[ReturnPoint]) -> Vec<u8> {
    let [poses, scene, representation, _] = title(view).map(|text| one_line(&text));
    let sensor = one_line(&view.study.sensors[member.sensor].name);
    let header = format!(
        "ply\nformat binary_little_endian 1.0\n\
         comment returns of {sensor} in {scene}, poses {poses}, representation {representation}\n\
         comment metres in the world; verdict: 0 tp, 1 fp, 2 fn, 3 tn, 4 uo, 5 uf\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property uint ray\nproperty uchar verdict\nend_header\n",
        returns.len()
    );
    with_points(header, view, returns, |at_m| at_m)
}

/// A binary PCD file.
pub(crate) fn pcd(view: &View, member: &SensorView, returns: &[ReturnPoint]) -> Vec<u8> {
    let count = returns.len();
    let Pose { position_m: at, rotation } = view.world.settings[member.sensor][member.candidate].pose();
    let [qx, qy, qz, qw] = rotation.to_array();
    // PCL's programs move the points by the viewpoint, and take it as the sensor's pose.
    let header = format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z ray verdict\nSIZE 4 4 4 4 1\n\
         TYPE F F F U U\nCOUNT 1 1 1 1 1\nWIDTH {count}\nHEIGHT 1\n\
         VIEWPOINT {} {} {} {qw} {qx} {qy} {qz}\nPOINTS {count}\nDATA binary\n",
        at.x, at.y, at.z
    );
    with_points(header, view, returns, |at_m| rotation.conjugate() * (at_m - at))
}

/// A header, then 17 bytes per point: each moved from the world into the file's frame.
fn with_points(
    header: String,
    view: &View,
    returns: &[ReturnPoint],
    in_frame: impl Fn(DVec3) -> DVec3,
) -> Vec<u8> {
    let mut bytes = header.into_bytes();
    bytes.reserve(17 * returns.len());
    for found in returns {
        in_frame(found.at_m).to_array().iter().for_each(|&x| bytes.extend((x as f32).to_le_bytes()));
        bytes.extend((found.ray as u32).to_le_bytes());
        bytes.push(view.verdict(found.voxel) as u8);
    }
    bytes
}

/// A user's text as one line of a header; PLY readers need ASCII.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '?' }).collect()
}
