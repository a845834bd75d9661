//! Reads messages as ROS 1 serialises them: little-endian fields one after the other, texts and lists behind their
//! lengths.

use super::messages::{
    Header, PointCloud2, PointField, Quaternion, TfMessage, Time, Transform, TransformStamped, Vector3,
};

/// A message, or a part of one, that ROS 1 writes.
pub(super) trait FromRos1: Sized {
    /// Takes it from the bytes; none if they end too early.
    fn from_ros1(rest: &mut &[u8]) -> Option<Self>;
}

fn bytes<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (bytes, after) = rest.split_first_chunk::<N>()?;
    *rest = after;
    Some(*bytes)
}

/// Takes a length, and that many bytes.
pub(super) fn byte_sequence<'d>(rest: &mut &'d [u8]) -> Option<&'d [u8]> {
    let length = u32::from_ros1(rest)? as usize;
    let (list, after) = rest.split_at_checked(length)?;
    *rest = after;
    Some(list)
}

/// A list behind its length.
fn sequence<T: FromRos1>(rest: &mut &[u8]) -> Option<Vec<T>> {
    (0..u32::from_ros1(rest)?).map(|_| T::from_ros1(rest)).collect()
}

impl FromRos1 for u32 {
    fn from_ros1(rest: &mut &[u8]) -> Option<u32> {
        bytes(rest).map(u32::from_le_bytes)
    }
}

impl FromRos1 for u8 {
    fn from_ros1(rest: &mut &[u8]) -> Option<u8> {
        bytes(rest).map(|[byte]| byte)
    }
}

impl FromRos1 for f64 {
    fn from_ros1(rest: &mut &[u8]) -> Option<f64> {
        bytes(rest).map(f64::from_le_bytes)
    }
}

impl FromRos1 for String {
    fn from_ros1(rest: &mut &[u8]) -> Option<String> {
        byte_sequence(rest).map(|text| String::from_utf8_lossy(text).into_owned())
    }
}

impl FromRos1 for Header {
    fn from_ros1(rest: &mut &[u8]) -> Option<Header> {
        let _sequence = u32::from_ros1(rest)?;
        let stamp = Time { sec: u32::from_ros1(rest)? as i32, nanosec: u32::from_ros1(rest)? };
        Some(Header { stamp, frame_id: String::from_ros1(rest)? })
    }
}

impl FromRos1 for PointField {
    fn from_ros1(rest: &mut &[u8]) -> Option<PointField> {
        Some(PointField {
            name: String::from_ros1(rest)?,
            offset: u32::from_ros1(rest)?,
            datatype: u8::from_ros1(rest)?,
            count: u32::from_ros1(rest)?,
        })
    }
}

impl FromRos1 for PointCloud2 {
    fn from_ros1(rest: &mut &[u8]) -> Option<PointCloud2> {
        Some(PointCloud2 {
            header: Header::from_ros1(rest)?,
            height: u32::from_ros1(rest)?,
            width: u32::from_ros1(rest)?,
            fields: sequence(rest)?,
            is_bigendian: u8::from_ros1(rest)? != 0,
            point_step: u32::from_ros1(rest)?,
            row_step: u32::from_ros1(rest)?,
            data: byte_sequence(rest)?.to_vec(),
            is_dense: u8::from_ros1(rest)? != 0,
        })
    }
}

impl FromRos1 for Vector3 {
    fn from_ros1(rest: &mut &[u8]) -> Option<Vector3> {
        Some(Vector3 { x: f64::from_ros1(rest)?, y: f64::from_ros1(rest)?, z: f64::from_ros1(rest)? })
    }
}

impl FromRos1 for Quaternion {
    fn from_ros1(rest: &mut &[u8]) -> Option<Quaternion> {
        let Vector3 { x, y, z } = Vector3::from_ros1(rest)?;
        Some(Quaternion { x, y, z, w: f64::from_ros1(rest)? })
    }
}

impl FromRos1 for TransformStamped {
    fn from_ros1(rest: &mut &[u8]) -> Option<TransformStamped> {
        Some(TransformStamped {
            header: Header::from_ros1(rest)?,
            child_frame_id: String::from_ros1(rest)?,
            transform: Transform {
                translation: Vector3::from_ros1(rest)?,
                rotation: Quaternion::from_ros1(rest)?,
            },
        })
    }
}

impl FromRos1 for TfMessage {
    fn from_ros1(rest: &mut &[u8]) -> Option<TfMessage> {
        Some(TfMessage { transforms: sequence(rest)? })
    }
}
