//! The messages that are read or written, field by field as ROS 2 defines them, and their definitions for
//! whoever reads the file.

#![allow(missing_docs, reason = "fields are documented by ROS 2")]

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// A message that has a name and a definition.
pub trait Message {
    /// Package and name.
    const NAME: &'static str;
    /// Its fields in the language of `.msg` files, followed by those of all messages in it.
    const DEFINITION: &'static str;
}

/// A moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    pub sec: i32,
    pub nanosec: u32,
}

/// When and in which frame.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    pub stamp: Time,
    pub frame_id: String,
}

/// A number of each point of a cloud: `datatype` is 1 to 8 for i8, u8, i16, u16, i32, u32, f32, f64.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointField {
    pub name: String,
    pub offset: u32,
    pub datatype: u8,
    pub count: u32,
}

/// Points, row by row.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointCloud2 {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub fields: Vec<PointField>,
    pub is_bigendian: bool,
    pub point_step: u32,
    pub row_step: u32,
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
    pub is_dense: bool,
}

/// A vector, or a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// A rotation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

impl From<DVec3> for Vector3 {
    fn from(DVec3 { x, y, z }: DVec3) -> Vector3 {
        Vector3 { x, y, z }
    }
}

impl From<DQuat> for Quaternion {
    fn from(DQuat { x, y, z, w }: DQuat) -> Quaternion {
        Quaternion { x, y, z, w }
    }
}

/// Where a frame is in another. A `geometry_msgs/Pose` has the same fields under other names.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    pub translation: Vector3,
    pub rotation: Quaternion,
}

/// Where a frame is in that of the header.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    pub header: Header,
    pub child_frame_id: String,
    pub transform: Transform,
}

/// Where frames are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TfMessage {
    pub transforms: Vec<TransformStamped>,
}

/// The part of an image that a camera sends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RegionOfInterest {
    pub x_offset: u32,
    pub y_offset: u32,
    pub height: u32,
    pub width: u32,
    pub do_rectify: bool,
}

/// The pinhole of a camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraInfo {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub distortion_model: String,
    pub d: Vec<f64>,
    pub k: [f64; 9],
    pub r: [f64; 9],
    pub p: [f64; 12],
    pub binning_x: u32,
    pub binning_y: u32,
    pub roi: RegionOfInterest,
}

/// An octree; `binary` is one without probabilities, as a `.bt` file has it below its header.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Octomap {
    pub header: Header,
    pub binary: bool,
    pub id: String,
    pub resolution: f64,
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}

/// A number of each voxel of a grid: `kind` is 1 to 8 for u8, i8, u16, i16, u32, i32, f32, f64.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PackedElementField {
    pub name: String,
    pub offset: u32,
    pub kind: u8,
}

/// Voxels: slice by slice along z, row by row along y.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VoxelGrid {
    pub timestamp: Time,
    pub frame_id: String,
    pub pose: Transform,
    pub row_count: u32,
    pub column_count: u32,
    pub cell_size: Vector3,
    pub slice_stride: u32,
    pub row_stride: u32,
    pub cell_stride: u32,
    pub fields: Vec<PackedElementField>,
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}

/// The definitions of messages that others hold, each behind the line that ROS 2 separates them by.
macro_rules! with {
    ($own:literal $(, $name:literal: $fields:literal)*) => {
        concat!($own $(, "================================================================================\nMSG: ", $name, "\n", $fields)*)
    };
}

impl Message for PointCloud2 {
    const NAME: &'static str = "sensor_msgs/msg/PointCloud2";
    const DEFINITION: &'static str = with!(
        "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n\
         uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
        "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
        "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
        "sensor_msgs/PointField": "string name\nuint32 offset\nuint8 datatype\nuint32 count\n"
    );
}

impl Message for TfMessage {
    const NAME: &'static str = "tf2_msgs/msg/TFMessage";
    const DEFINITION: &'static str = with!(
        "geometry_msgs/TransformStamped[] transforms\n",
        "geometry_msgs/TransformStamped":
            "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
        "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
        "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
        "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
        "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
        "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
    );
}

impl Message for CameraInfo {
    const NAME: &'static str = "sensor_msgs/msg/CameraInfo";
    const DEFINITION: &'static str = with!(
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\n\
         float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n",
        "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
        "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
        "sensor_msgs/RegionOfInterest":
            "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"
    );
}

impl Message for Octomap {
    const NAME: &'static str = "octomap_msgs/msg/Octomap";
    const DEFINITION: &'static str = with!(
        "std_msgs/Header header\nbool binary\nstring id\nfloat64 resolution\nint8[] data\n",
        "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
        "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n"
    );
}

impl Message for VoxelGrid {
    const NAME: &'static str = "foxglove_msgs/msg/VoxelGrid";
    const DEFINITION: &'static str = with!(
        "builtin_interfaces/Time timestamp\nstring frame_id\ngeometry_msgs/Pose pose\nuint32 row_count\n\
         uint32 column_count\ngeometry_msgs/Vector3 cell_size\nuint32 slice_stride\nuint32 row_stride\n\
         uint32 cell_stride\nfoxglove_msgs/PackedElementField[] fields\nuint8[] data\n",
        "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
        "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
        "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z\n",
        "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
        "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
        "foxglove_msgs/PackedElementField": "string name\nuint32 offset\nuint8 type\n"
    );
}
