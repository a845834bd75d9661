//! Reads point clouds from an MCAP file of ROS: each `sensor_msgs/PointCloud2` of a topic, measured from the origin
//! of its frame, which `/tf_static` places.

use std::collections::HashMap;

use glam::DVec3;

use super::cloud::{Cloud, check_count};
use super::number::Number;
use crate::pose::Pose;
use crate::ros::messages::{PointCloud2, PointField};
use crate::ros::read_clouds;
use crate::source::MemoryLimit;
use perirobot_march::error::Issue;

/// Parses a file; the frame of the recording is the outermost one around those of the clouds. With the clouds come
/// remarks about that frame.
pub(super) fn parse(
    bytes: &[u8],
    topic: Option<&str>,
    message: Option<usize>,
) -> Result<(Vec<Cloud>, Vec<String>), Issue> {
    // Each with its place in the order of time.
    let mut clouds: Vec<(usize, Cloud)> = Vec::new();
    let mut outermost: Option<String> = None;
    let mut remarks: Vec<String> = Vec::new();
    let mut placed: HashMap<String, (String, Pose)> = HashMap::new();
    let mut limit = MemoryLimit::new(bytes.len() as u64);
    let (mut points, mut empty) = (0, 0);
    let topic = read_clouds(bytes, topic, message, |frames, in_time, cloud| {
        if !placed.contains_key(&cloud.header.frame_id) {
            let around = frames.outermost(&cloud.header.frame_id)?;
            let said = frames.remarks(&cloud.header.frame_id, &around.0);
            said.into_iter().for_each(|one| {
                if !remarks.contains(&one) {
                    remarks.push(one)
                }
            });
            placed.insert(cloud.header.frame_id.clone(), around);
        }
        let (frame, pose) = &placed[&cloud.header.frame_id];
        let first = outermost.get_or_insert_with(|| frame.clone());
        if first != frame {
            let what = format!(
                "its clouds are in the frames {first:?} and {frame:?}, which /tf_static does not join"
            );
            return Err(
                Issue::says(what).with_advice("name one message, or one topic whose sensor does not move")
            );
        }
        let found = points_m(&cloud, pose, &mut points, &mut limit)?;
        match found.iter().any(|point| point.is_finite()) {
            true => clouds.push((in_time, Cloud::new(pose.position_m, found)?)),
            false => empty += 1,
        }
        Ok(())
    })?;
    if clouds.is_empty() {
        return Err(Issue::says(format!("{topic} has no point ({empty} messages)")));
    }
    clouds.sort_by_key(|(in_time, _)| *in_time);
    Ok((clouds.into_iter().map(|(_, cloud)| cloud).collect(), remarks))
}

/// The points of a message, from its frame into that which holds it at a pose. `before` counts those of earlier ones.
fn points_m(
    cloud: &PointCloud2,
    pose: &Pose,
    before: &mut usize,
    limit: &mut MemoryLimit,
) -> Result<Vec<DVec3>, Issue> {
    let wrong = |what: String| Issue::damaged(format!("a message of {:?}: {what}", cloud.header.frame_id));
    let [width, height, step, row] =
        [cloud.width, cloud.height, cloud.point_step, cloud.row_step].map(|n| n as usize);
    let axis = |name: &str| {
        let field = cloud.fields.iter().find(|field| field.name == name);
        let field = field.ok_or_else(|| wrong(format!("its points have no {name}")))?;
        let number =
            number(field).ok_or_else(|| wrong(format!("{name} has the datatype {}", field.datatype)))?;
        let offset = field.offset as usize;
        match offset + number.bytes() <= step {
            true => Ok((number, offset)),
            false => Err(wrong(format!("{name} lies outside the {step} bytes of a point"))),
        }
    };
    let axes = [axis("x")?, axis("y")?, axis("z")?];
    // Of an unorganised cloud some drivers write no row_step.
    let row = if height <= 1 { width * step } else { row };
    if height > 0 && (row < width * step || cloud.data.len() / height < row) {
        return Err(wrong(format!(
            "its {} bytes do not hold {width} x {height} points of {step}",
            cloud.data.len()
        )));
    }
    *before += width * height;
    check_count(*before).map_err(|issue| issue.cure("name one message of it"))?;
    limit.spend_on::<DVec3>(width * height)?;
    let mut points = Vec::with_capacity(width * height);
    for line in cloud.data.chunks_exact(row.max(1)).take(height) {
        for point in line.chunks_exact(step).take(width) {
            let read = axes.map(|(number, offset)| number.read(&point[offset..], cloud.is_bigendian));
            points.push(pose.position_m + pose.rotation * DVec3::from_array(read));
        }
    }
    Ok(points)
}

fn number(field: &PointField) -> Option<Number> {
    let (kind, bytes) = match field.datatype {
        1 => ('i', 1),
        2 => ('u', 1),
        3 => ('i', 2),
        4 => ('u', 2),
        5 => ('i', 4),
        6 => ('u', 4),
        7 => ('f', 4),
        8 => ('f', 8),
        _ => return None,
    };
    Number::new(kind, bytes)
}

#[cfg(test)]
mod tests;
