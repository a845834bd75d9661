//! The sensors of a view for ROS 2: their poses as static transforms and as a part of a URDF, the `camera_info` of
//! cameras, and a bag with their points, the labels as voxels, and an OctoMap.
//!
//! Each sensor has a frame of its name: x forward, y left, z up (REP-103). A camera has a second one, whose name ends
//! in `_optical_frame`: z forward, x right, y down; its points are in that.

use std::collections::BTreeSet;

use glam::{DQuat, DVec3, EulerRot};

use super::ExportedFile;
use crate::render::svg::escape;
use crate::render::{Colour, Palette};
use perirobot_decide::view::{SensorView, Verdict, View};
use perirobot_march::Result;
use perirobot_march::backend::Image;
use perirobot_scene::pose::Pose;
use perirobot_scene::ros::messages::{
    CameraInfo, Header, Octomap, PackedElementField, PointCloud2, PointField, RegionOfInterest, TfMessage,
    Transform, TransformStamped, VoxelGrid,
};
use perirobot_scene::ros::{BagWriter, STAMP};
use perirobot_scene::shell;
use perirobot_study::sensor::Setting;
use perirobot_study::world::ray_table;

/// The root frame.
const WORLD: &str = "world";
/// Bytes of a voxel in the grid of a bag: verdict, red, green, blue, alpha.
const VOXEL_BYTES: u32 = 5;
/// Bytes of a point: x, y, z, and the index of the ray.
const POINT_BYTES: u32 = 16;

/// A frame, and its pose in its parent.
#[derive(Clone)]
struct RosFrame {
    name: String,
    holder: String,
    pose: Pose,
}

/// A sensor with a pose.
struct PlacedSensor<'v> {
    member: &'v SensorView,
    /// Its own frame in the world.
    own: RosFrame,
    /// The same in the link that carries it, if any.
    mounted: RosFrame,
    /// The frame of a camera's image, in the sensor's frame.
    optical: Option<(RosFrame, Image)>,
}

impl PlacedSensor<'_> {
    /// Its frames, the first relative to its carrier.
    fn frames(&self) -> impl Iterator<Item = &RosFrame> {
        std::iter::once(&self.mounted).chain(self.optical.iter().map(|(frame, _)| frame))
    }

    /// The name of the frame of its points, and its pose in the world.
    fn points_frame(&self) -> (&str, Pose) {
        match &self.optical {
            Some((frame, _)) => (&frame.name, frame.pose.carried_by(&self.own.pose)),
            None => (&self.own.name, self.own.pose),
        }
    }
}

/// The sensors of a view that have poses.
fn placed_sensors<'v>(view: &'v View) -> Vec<PlacedSensor<'v>> {
    // Existing frames: the world's, and the links that carry sensors.
    let links = view.members.iter().filter_map(|member| view.study.sensors[member.sensor].on.as_ref());
    let mut taken: BTreeSet<String> = links.map(|on| on.link.clone()).chain([WORLD.into()]).collect();
    let placed = view.members.iter().filter_map(|member| {
        let sensor = &view.study.sensors[member.sensor];
        let Setting::Pose(pose) = view.world.settings[member.sensor][member.candidate] else { return None };
        let name = frame_name(&sensor.name, &mut taken);
        let own = RosFrame { name: name.clone(), holder: WORLD.into(), pose };
        let mounted = match &sensor.on {
            Some(on) => {
                let pose = sensor.candidates[member.candidate].setting.pose();
                RosFrame { holder: on.link.clone(), pose, ..own.clone() }
            }
            None => own.clone(),
        };
        let optical = ray_table(view.study, member.sensor).and_then(|rays| rays.image).map(|image| {
            let pose = Pose { position_m: DVec3::ZERO, rotation: DQuat::from_mat3(&Pose::ORIGIN.optical()) };
            (RosFrame { name: optical_name(&name), holder: name, pose }, image)
        });
        Some(PlacedSensor { member, own, mounted, optical })
    });
    placed.collect()
}

/// An unused name that is valid for frames, topics and links: ASCII letters, digits and underscores, starting with a
/// letter. The name of its optical frame is unused as well.
fn frame_name(name: &str, taken: &mut BTreeSet<String>) -> String {
    let plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let plain = match plain.trim_matches('_') {
        "" => "sensor".to_string(),
        word if word.starts_with(|c: char| c.is_ascii_digit()) => format!("sensor_{word}"),
        word => word.to_string(),
    };
    let again = (2..).map(|n| format!("{plain}_{n}"));
    let is_free = |name: &String| !taken.contains(name) && !taken.contains(&optical_name(name));
    let free = std::iter::once(plain.clone()).chain(again).find(is_free).unwrap_or(plain);
    taken.extend([free.clone(), optical_name(&free)]);
    free
}

fn optical_name(name: &str) -> String {
    format!("{name}_optical_frame")
}

/// All files for ROS.
pub(super) fn files(view: &View, octree: &[u8]) -> Result<Vec<ExportedFile>> {
    let placed = placed_sensors(view);
    let mut files = Vec::new();
    let mut add =
        |name: String, bytes: Vec<u8>, holds: String| files.push(ExportedFile { name, bytes, holds });
    if !placed.is_empty() {
        let frames = format!("{} frames", placed.iter().flat_map(PlacedSensor::frames).count());
        add("transforms.sh".into(), transforms(&placed).into(), frames.clone());
        add("sensors.urdf".into(), urdf(&placed).into(), frames);
    }
    for sensor in &placed {
        if let Some((_, image)) = sensor.optical {
            let name = &sensor.own.name;
            let [width, height] = image.size_px;
            let holds = format!("{width} × {height} pixels");
            add(format!("camera_info-{name}.yaml"), calibration(name, image).into(), holds);
        }
    }
    let (bytes, topics) = bag(view, &placed, octree)?;
    add("view.mcap".into(), bytes, format!("{topics} topics"));
    Ok(files)
}

/// A script that publishes the frames.
fn transforms(placed: &[PlacedSensor]) -> String {
    let mut text =
        "#!/bin/sh\n# Publishes the poses of the sensors until it is stopped.\ntrap 'kill 0' INT TERM\n"
            .to_string();
    for frame in placed.iter().flat_map(PlacedSensor::frames) {
        let [x, y, z] = frame.pose.position_m.to_array().map(short);
        let [qx, qy, qz, qw] = frame.pose.rotation.to_array().map(short);
        let [holder, name] = [&frame.holder, &frame.name].map(|name| shell::quote(name));
        text += &format!(
            "ros2 run tf2_ros static_transform_publisher --x {x} --y {y} --z {z} \
             --qx {qx} --qy {qy} --qz {qz} --qw {qw} --frame-id {holder} --child-frame-id {name} &\n"
        );
    }
    text + "wait\n"
}

/// Links and joints of the frames, for a robot's URDF.
fn urdf(placed: &[PlacedSensor]) -> String {
    let mut text = "<?xml version=\"1.0\"?>\n\
         <!-- The sensors' links, and the joints that hold them: include them by xacro in, or copy them to, the URDF that\n     \
         has the links that are named as parents here and are not sensors. -->\n<robot name=\"sensors\">\n"
        .to_string();
    for frame in placed.iter().flat_map(PlacedSensor::frames) {
        let [x, y, z] = frame.pose.position_m.to_array().map(short);
        let (yaw, pitch, roll) = frame.pose.rotation.to_euler(EulerRot::ZYX);
        let [roll, pitch, yaw] = [roll, pitch, yaw].map(short);
        let [holder, name] = [&frame.holder, &frame.name].map(|name| escape(name));
        text += &format!(
            "  <link name=\"{name}\"/>\n  <joint name=\"{name}_joint\" type=\"fixed\">\n    \
             <parent link=\"{holder}\"/>\n    <child link=\"{name}\"/>\n    \
             <origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>\n  </joint>\n"
        );
    }
    text + "</robot>\n"
}

/// A number with at most twelve decimals, without trailing zeros.
fn short(value: f64) -> String {
    let text = format!("{value:.12}");
    match text.trim_end_matches('0').trim_end_matches('.') {
        "-0" => "0".into(),
        short => short.into(),
    }
}

/// Focal lengths and principal point of an image in pixels, which ROS counts by their centres: fx, fy, cx, cy.
fn pinhole(image: Image) -> [f64; 4] {
    let [cx, cy] = image.size_px.map(|n| (f64::from(n) - 1.0) / 2.0);
    let [fx, fy] = image.focal_px;
    [fx, fy, cx, cy]
}

/// A `camera_info` in the format of `camera_calibration` and `camera_info_manager`.
fn calibration(name: &str, image: Image) -> String {
    let ([width, height], [fx, fy, cx, cy]) = (image.size_px, pinhole(image));
    format!(
        "image_width: {width}\nimage_height: {height}\ncamera_name: {name}\n\
         camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{fx:?}, 0.0, {cx:?}, 0.0, {fy:?}, {cy:?}, 0.0, 0.0, 1.0]\n\
         distortion_model: plumb_bob\n\
         distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.0, 0.0, 0.0, 0.0, 0.0]\n\
         rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\n\
         projection_matrix:\n  rows: 3\n  cols: 4\n  \
         data: [{fx:?}, 0.0, {cx:?}, 0.0, 0.0, {fy:?}, {cy:?}, 0.0, 0.0, 0.0, 1.0, 0.0]\n"
    )
}

fn header(frame: &str) -> Header {
    Header { stamp: STAMP, frame_id: frame.into() }
}

fn transform(pose: &Pose) -> Transform {
    Transform { translation: pose.position_m.into(), rotation: pose.rotation.into() }
}

/// A bag, and the number of its topics.
fn bag(view: &View, placed: &[PlacedSensor], octree: &[u8]) -> Result<(Vec<u8>, usize)> {
    let mut bag = BagWriter::default();
    let mut topics = 0;
    let stamped = |frame: &RosFrame| TransformStamped {
        header: header(&frame.holder),
        child_frame_id: frame.name.clone(),
        transform: transform(&frame.pose),
    };
    let frames = placed
        .iter()
        .flat_map(|sensor| std::iter::once(&sensor.own).chain(sensor.optical.iter().map(|(frame, _)| frame)));
    let frames = TfMessage { transforms: frames.map(stamped).collect() };
    if !frames.transforms.is_empty() {
        bag.write("/tf_static", &frames);
        topics += 1;
    }
    for sensor in placed {
        let name = &sensor.own.name;
        if let Some((frame, image)) = &sensor.optical {
            bag.write(&format!("/{name}/camera_info"), &camera_info(frame, *image));
            topics += 1;
        }
        if sensor.member.cast.is_some() {
            bag.write(&format!("/{name}/points"), &points(view, sensor));
            topics += 1;
        }
    }
    let grid = &view.world.grid;
    // After the header of the file, which ends with this line.
    let behind = octree.windows(6).position(|text| text == b"\ndata\n").map_or(0, |at| at + 6);
    let octree = Octomap {
        header: header(WORLD),
        binary: true,
        id: "OcTree".into(),
        resolution: grid.voxel_size_m,
        data: octree[behind..].to_vec(),
    };
    bag.write("/octomap_binary", &octree);
    topics += 1;
    if let Some(voxels) = voxels(view)? {
        bag.write("/voxels", &voxels);
        topics += 1;
    }
    Ok((bag.finish(), topics))
}

fn camera_info(frame: &RosFrame, image: Image) -> CameraInfo {
    let ([width, height], [fx, fy, cx, cy]) = (image.size_px, pinhole(image));
    CameraInfo {
        header: header(&frame.name),
        height,
        width,
        distortion_model: "plumb_bob".into(),
        d: vec![0.0; 5],
        k: [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p: [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        binning_x: 0,
        binning_y: 0,
        roi: RegionOfInterest::default(),
    }
}

/// The returns of a sensor in its own frame.
fn points(view: &View, sensor: &PlacedSensor) -> PointCloud2 {
    let (frame, pose) = sensor.points_frame();
    let returns = view.returns(sensor.member);
    let mut data = Vec::with_capacity(POINT_BYTES as usize * returns.len());
    for found in &returns {
        let at = pose.rotation.conjugate() * (found.at_m - pose.position_m);
        at.to_array().iter().for_each(|&x| data.extend((x as f32).to_le_bytes()));
        data.extend((found.ray as u32).to_le_bytes());
    }
    let field = |(name, datatype): (&str, u8), place: u32| PointField {
        name: name.into(),
        offset: 4 * place,
        datatype,
        count: 1,
    };
    // Float32 is 7, uint32 is 6.
    let fields = [("x", 7), ("y", 7), ("z", 7), ("ray", 6)].into_iter().zip(0u32..);
    PointCloud2 {
        header: header(frame),
        height: 1,
        width: returns.len() as u32,
        fields: fields.map(|(named, place)| field(named, place)).collect(),
        is_bigendian: false,
        point_step: POINT_BYTES,
        row_step: data.len() as u32,
        data,
        is_dense: true,
    }
}

/// The verdicts on the labels, voxel by voxel; `None` if they exceed the size of a message.
fn voxels(view: &View) -> Result<Option<VoxelGrid>> {
    let grid = &view.world.grid;
    let [nx, ny, nz] = grid.size;
    if u64::from(nx) * u64::from(ny) * u64::from(nz) * u64::from(VOXEL_BYTES) > u64::from(u32::MAX) {
        return Ok(None);
    }
    let palette = Palette::new(view.world, Some(view), Colour::Label)?;
    let mut data = Vec::with_capacity((nx * ny * nz * VOXEL_BYTES) as usize);
    let [columns, rows, slices] = [nx, ny, nz].map(|n| 0..n as i32);
    let along_x = |y, z| columns.clone().map(move |x| [x, y, z]);
    let in_slice = |z| rows.clone().flat_map(move |y| along_x(y, z));
    for voxel in slices.flat_map(in_slice) {
        let verdict = view.verdict(voxel);
        let [red, green, blue] = palette.colour(voxel);
        let alpha = match verdict {
            Verdict::Tp | Verdict::Fn | Verdict::Uo => u8::MAX,
            Verdict::Fp => 128,
            Verdict::Tn | Verdict::Uf => 0,
        };
        data.extend([verdict as u8, red, green, blue, alpha]);
    }
    let fields = ["verdict", "red", "green", "blue", "alpha"].into_iter().zip(0..);
    // Uint8 is 1.
    let fields = fields.map(|(name, offset)| PackedElementField { name: name.into(), offset, kind: 1 });
    Ok(Some(VoxelGrid {
        timestamp: STAMP,
        frame_id: WORLD.into(),
        pose: transform(&Pose { position_m: grid.corner_m([0; 3]), ..Pose::ORIGIN }),
        row_count: ny,
        column_count: nx,
        cell_size: DVec3::splat(grid.voxel_size_m).into(),
        slice_stride: nx * ny * VOXEL_BYTES,
        row_stride: nx * VOXEL_BYTES,
        cell_stride: VOXEL_BYTES,
        fields: fields.collect(),
        data,
    }))
}

#[cfg(test)]
mod tests;
