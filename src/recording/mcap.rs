//! Reads point clouds from an MCAP file of ROS 2: each `sensor_msgs/PointCloud2` of a topic, measured from the origin
//! of its frame, which `/tf_static` places.

use glam::DVec3;

use super::cloud::Cloud;
use super::number::Number;
use crate::error::Issue;
use crate::pose::Pose;
use crate::ros::messages::{PointCloud2, PointField};
use crate::ros::read_clouds;

/// Most points of all clouds together: 2.4 GB.
const MOST_POINTS: usize = 100_000_000;

/// Parses a file; the frame of the recording is the outermost one around those of the clouds.
pub(super) fn parse(bytes: &[u8], topic: Option<&str>, message: Option<usize>) -> Result<Vec<Cloud>, Issue> {
    let mut clouds: Vec<Cloud> = Vec::new();
    let mut outermost: Option<String> = None;
    let (mut points, mut empty) = (0, 0);
    let topic = read_clouds(bytes, topic, message, |frames, cloud| {
        let (frame, pose) = frames.outermost(&cloud.header.frame_id)?;
        let first = outermost.get_or_insert_with(|| frame.to_owned());
        if first != frame {
            let what = format!(
                "its clouds are in the frames {first:?} and {frame:?}, which /tf_static does not join"
            );
            return Err(Issue::says(what).wanted("name one message, or one topic whose sensor does not move"));
        }
        let found = points_m(&cloud, &pose)?;
        points += found.len();
        if points > MOST_POINTS {
            return Err(Issue::too_large(format!("holds more than {MOST_POINTS} points"))
                .wanted("name one message of it"));
        }
        match found.iter().any(|point| point.is_finite()) {
            true => clouds.push(Cloud::new(pose.position_m, found)?),
            false => empty += 1,
        }
        Ok(())
    })?;
    match clouds.is_empty() {
        true => Err(Issue::says(format!("{topic} has no point ({empty} messages)"))),
        false => Ok(clouds),
    }
}

/// The points of a message, from its frame into that which holds it at a pose.
fn points_m(cloud: &PointCloud2, pose: &Pose) -> Result<Vec<DVec3>, Issue> {
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
