use super::*;
use crate::ros::messages::{Header, TfMessage, Transform, TransformStamped};
use crate::ros::{BagWriter, STAMP};

fn header(frame: &str) -> Header {
    Header { stamp: STAMP, frame_id: frame.into() }
}

/// A quarter turn about z, and a place.
fn frame(holder: &str, name: &str, [x, y, z]: [f64; 3]) -> TransformStamped {
    let rotation = glam::DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
    let transform = Transform { translation: DVec3::new(x, y, z).into(), rotation: rotation.into() };
    TransformStamped { header: header(holder), child_frame_id: name.into(), transform }
}

/// Points as big-endian doubles in reverse order, with a byte before them and padding behind each row of two.
fn odd(frame: &str, points: [[f64; 3]; 4]) -> PointCloud2 {
    let mut data = Vec::new();
    for row in points.chunks(2) {
        for point in row {
            data.push(7);
            point.iter().rev().for_each(|x| data.extend(x.to_be_bytes()));
        }
        data.extend([9; 5]);
    }
    let field = |(name, offset): (&str, u32)| PointField { name: name.into(), offset, datatype: 8, count: 1 };
    PointCloud2 {
        header: header(frame),
        height: 2,
        width: 2,
        fields: [("z", 1), ("y", 9), ("x", 17)].map(field).to_vec(),
        is_bigendian: true,
        point_step: 25,
        row_step: 55,
        data,
        is_dense: false,
    }
}

const POINTS: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [f64::NAN; 3], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];

fn bag(write: impl FnOnce(&mut BagWriter)) -> Vec<u8> {
    let mut bag = BagWriter::new();
    write(&mut bag);
    bag.finish()
}

fn told(read: Result<Vec<Cloud>, Issue>) -> String {
    crate::Error::from(read.unwrap_err().at("scan.mcap")).to_string()
}

#[test]
fn points_are_measured_from_their_frame_in_the_outermost_one() {
    let bytes = bag(|bag| {
        // The frame of the sensor is told before that which holds it, and once with the slash of old drivers.
        let transforms =
            vec![frame("/base", "lidar", [0.0, 0.0, 1.0]), frame("map", "base", [10.0, 0.0, 0.0])];
        bag.write("/tf_static", &TfMessage { transforms });
        bag.write("/points", &odd("lidar", POINTS));
    });
    let clouds = parse(&bytes, None, None).unwrap();
    // Two quarter turns: x and y change their signs. The lidar is 1 m above base, base 10 m along x.
    let near =
        |a: DVec3, b: [f64; 3]| assert!((a - DVec3::from_array(b)).length() < 1e-12, "{a} is not {b:?}");
    assert_eq!((clouds.len(), clouds[0].without_point, clouds[0].points_m.len()), (1, 1, 3));
    near(clouds[0].sensor_m, [10.0, 0.0, 1.0]);
    let expected = [[9.0, 0.0, 1.0], [10.0, -2.0, 1.0], [10.0, 0.0, 4.0]];
    clouds[0].points_m.iter().zip(expected).for_each(|(&point, expected)| near(point, expected));
}

#[test]
fn one_topic_and_one_message_can_be_asked_for() {
    let moved = POINTS.map(|[x, y, z]| [x + 1.0, y, z]);
    let bytes = bag(|bag| {
        bag.write("/front", &odd("front", POINTS));
        bag.write("/back", &odd("back", POINTS));
        bag.write("/back", &odd("back", moved));
    });
    assert_eq!(parse(&bytes, Some("/front"), None).unwrap().len(), 1);
    let both = parse(&bytes, Some("/back"), None).unwrap();
    assert_eq!(both.len(), 2);
    assert_eq!(parse(&bytes, Some("/back"), Some(1)).unwrap(), both[1..]);
    assert_ne!(both[0].points_m, both[1].points_m);
    let several = told(parse(&bytes, None, None));
    assert!(several.contains("on several topics") && several.contains("/front"), "{several}");
    let unknown = told(parse(&bytes, Some("/side"), None));
    assert!(unknown.contains("topic \"/side\"") || unknown.contains("topic = \"/side\""), "{unknown}");
    let beyond = told(parse(&bytes, Some("/back"), Some(2)));
    assert!(beyond.contains("from 0 to 1"), "{beyond}");
}

#[test]
fn what_is_no_bag_of_clouds_is_refused_in_words() {
    let whole = bag(|bag| bag.write("/points", &odd("lidar", POINTS)));
    let changed = |change: fn(&mut PointCloud2)| {
        let mut cloud = odd("lidar", POINTS);
        change(&mut cloud);
        bag(|bag| bag.write("/points", &cloud))
    };
    let ring = bag(|bag| {
        let transforms = vec![frame("a", "b", [0.0; 3]), frame("b", "a", [0.0; 3])];
        bag.write("/tf_static", &TfMessage { transforms });
        bag.write("/points", &odd("a", POINTS));
    });
    let apart = bag(|bag| {
        bag.write("/points", &odd("left", POINTS));
        bag.write("/points", &odd("right", POINTS));
    });
    let cases = [
        (b"no bag".to_vec(), "no whole MCAP file"),
        (whole[..whole.len() / 2].to_vec(), "no whole MCAP file"),
        (bag(|bag| bag.write("/tf_static", &TfMessage { transforms: vec![] })), "no messages of sensor_msgs"),
        (ring, "in a ring"),
        (apart, "which /tf_static does not join"),
        (changed(|cloud| cloud.fields.truncate(2)), "no x"),
        (changed(|cloud| cloud.fields[0].datatype = 9), "datatype 9"),
        (changed(|cloud| cloud.point_step = 0), "outside the 0 bytes"),
        (changed(|cloud| cloud.point_step = 24), "x lies outside the 24 bytes"),
        (changed(|cloud| cloud.height = u32::MAX), "do not hold"),
        (changed(|cloud| (cloud.width, cloud.height) = (u32::MAX, 1)), "do not hold"),
        (changed(|cloud| cloud.row_step = 49), "do not hold"),
        (changed(|cloud| cloud.data.fill(255)), "has no point"),
    ];
    for (bytes, expected) in cases {
        let said = told(parse(&bytes, None, None));
        assert!(said.contains(expected) && said.starts_with("scan.mcap: "), "no {expected:?} in {said}");
    }
}

#[test]
fn lengths_that_no_file_has_are_refused_without_making_room_for_them() {
    let record = |opcode: u8, length: u64, body: &[u8]| [&[opcode][..], &length.to_le_bytes(), body].concat();
    let whole = |opcode: u8, body: &[u8]| record(opcode, body.len() as u64, body);
    let magic = b"\x89MCAP0\r\n";
    let header = whole(1, &[4, 0, 0, 0, b'r', b'o', b's', b'2', 0, 0, 0, 0]);
    for length in [1 << 40, 1 << 62, (1 << 63) + 5, u64::MAX] {
        let message = record(5, length, &[7; 20]);
        // The same in a chunk without compression, and in one of zstd: a frame with one raw block.
        let raw = u32::from(message.len() as u8) << 3 | 1;
        let zstd =
            [&[0x28, 0xb5, 0x2f, 0xfd, 0x20, message.len() as u8][..], &raw.to_le_bytes()[..3], &message]
                .concat();
        let chunk = |name: &[u8], records: &[u8], size: u64| {
            let size = [&[0; 16][..], &size.to_le_bytes(), &[0; 4], &(name.len() as u32).to_le_bytes(), name]
                .concat();
            whole(6, &[&size, &(records.len() as u64).to_le_bytes()[..], records].concat())
        };
        let own = message.len() as u64;
        for (damaged, expected) in [
            (message.clone(), "no whole MCAP file"),
            (record(6, length, &[0; 60]), "no whole MCAP file"),
            (chunk(b"", &message, own), "no whole MCAP file"),
            (chunk(b"zstd", &zstd, own), "no whole MCAP file"),
            (chunk(b"zstd", &zstd, u64::MAX), "has a chunk of 18446744073709551615 bytes"),
        ] {
            let bytes = [&magic[..], &header, &damaged, magic].concat();
            let said = told(parse(&bytes, None, None));
            assert!(said.contains(expected), "{length}: {said}");
        }
    }
}
