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
    let mut bag = BagWriter::default();
    write(&mut bag);
    bag.finish()
}

fn parse(bytes: &[u8], topic: Option<&str>, message: Option<usize>) -> Result<Vec<Cloud>, Issue> {
    super::parse(bytes, topic, message).map(|(clouds, _)| clouds)
}

fn describe(read: Result<Vec<Cloud>, Issue>) -> String {
    perirobot_march::Error::from(read.unwrap_err().with_place("scan.mcap")).to_string()
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
    let several = describe(parse(&bytes, None, None));
    assert!(several.contains("on several topics") && several.contains("/front"), "{several}");
    let unknown = describe(parse(&bytes, Some("/side"), None));
    assert!(unknown.contains("topic \"/side\"") || unknown.contains("topic = \"/side\""), "{unknown}");
    let beyond = describe(parse(&bytes, Some("/back"), Some(2)));
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
        (b"#ROSBAG V2.0\nand more".to_vec(), "not those of MCAP: convert a .bag or .db3"),
        (whole[..whole.len() / 2].to_vec(), "no whole MCAP file: it ends within a record: copy it again"),
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
        let said = describe(parse(&bytes, None, None));
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
            (chunk(b"zstd", &zstd, u64::MAX), "unfolds to far more than its size"),
        ] {
            let bytes = [&magic[..], &header, &damaged, magic].concat();
            let said = describe(parse(&bytes, None, None));
            assert!(said.contains(expected), "{length}: {said}");
        }
    }
}

/// A bag whose messages have a type, an encoding, a topic and a time of their own.
fn raw_bag(messages: &[(&str, &str, &str, u64, Vec<u8>)]) -> Vec<u8> {
    let mut file = ::mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    for (name, encoding, topic, log_time, body) in messages {
        let schema = file.add_schema(name, "ros2msg", b"x").unwrap();
        let channel_id = file.add_channel(schema, topic, encoding, &Default::default()).unwrap();
        let header = ::mcap::records::MessageHeader {
            channel_id,
            sequence: 0,
            log_time: *log_time,
            publish_time: *log_time,
        };
        file.write_to_known_channel(&header, body).unwrap();
    }
    file.finish().unwrap();
    file.into_inner().into_inner()
}

fn cdr<M: serde::Serialize>(message: &M) -> Vec<u8> {
    let body = cdr_encoding::to_vec::<M, byteorder::LittleEndian>(message).unwrap();
    [&[0, 1, 0, 0][..], &body].concat()
}

#[test]
fn types_without_msg_and_messages_of_ros_1_are_read() {
    let expected = parse(&bag(|bag| bag.write("/points", &odd("lidar", POINTS))), None, None).unwrap();
    let short = raw_bag(&[("sensor_msgs/PointCloud2", "cdr", "/points", 1, cdr(&odd("lidar", POINTS)))]);
    assert_eq!(parse(&short, None, None).unwrap(), expected);
    // ROS 1: a counter before the stamp, no padding, no zero behind texts.
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let header = |frame: &str| [[0; 12].to_vec(), text(frame)].concat();
    let PointCloud2 { height, width, fields, point_step, row_step, data, .. } = odd("lidar", POINTS);
    let word = |n: u32| n.to_le_bytes().to_vec();
    let fields = fields.iter().flat_map(|field| {
        [text(&field.name), word(field.offset), vec![field.datatype], word(field.count)].concat()
    });
    let cloud = [
        header("lidar"),
        [word(height), word(width), word(3)].concat(),
        fields.collect(),
        vec![1],
        [word(point_step), word(row_step), word(data.len() as u32)].concat(),
        data,
        vec![0],
    ]
    .concat();
    let numbers = |numbers: &[f64]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<_>>();
    let place =
        [word(1), header("base"), text("lidar"), numbers(&[0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 1.0])].concat();
    let old = |cloud: Vec<u8>| {
        raw_bag(&[
            ("tf2_msgs/TFMessage", "ros1", "/tf_static", 1, place.clone()),
            ("sensor_msgs/PointCloud2", "ros1", "/points", 2, cloud),
        ])
    };
    let clouds = parse(&old(cloud.clone()), None, None).unwrap();
    assert_eq!(clouds[0].sensor_m, DVec3::new(0.0, 0.0, 5.0));
    let lifted: Vec<DVec3> =
        expected[0].points_m.iter().map(|point| *point + DVec3::new(0.0, 0.0, 5.0)).collect();
    assert_eq!(clouds[0].points_m, lifted);
    for length in 0..cloud.len() {
        let said = describe(parse(&old(cloud[..length].to_vec()), None, None));
        assert!(said.contains("message 0 of /points is no sensor_msgs/msg/PointCloud2"), "{length}: {said}");
    }
    let other = raw_bag(&[("foxglove.PointCloud", "protobuf", "/scan", 1, vec![1])]);
    let said = describe(parse(&other, None, None));
    assert!(said.contains("it has foxglove.PointCloud (protobuf) on /scan"), "{said}");
}

#[test]
fn frames_that_are_told_elsewhere_are_followed_or_told() {
    let remarks = |topics: &[(&str, TfMessage)]| {
        let bytes = bag(|bag| {
            topics.iter().for_each(|(topic, told)| bag.write(topic, told));
            bag.write("/points", &odd("lidar", POINTS));
        });
        let (clouds, remarks) = super::parse(&bytes, None, None).unwrap();
        (clouds[0].sensor_m.to_array(), remarks)
    };
    let at = |z: f64| TfMessage { transforms: vec![frame("base", "lidar", [0.0, 0.0, z])] };
    assert_eq!(remarks(&[("/tf_static", at(2.0))]), ([0.0, 0.0, 2.0], vec![]));
    assert_eq!(remarks(&[("/cell/robot/tf_static", at(2.0))]), ([0.0, 0.0, 2.0], vec![]), "in a namespace");
    for topic in ["/tf", "/robot/tf"] {
        let (place, said) = remarks(&[(topic, at(1.0))]);
        assert_eq!((place, said.len()), ([0.0; 3], 1));
        let expected = format!(
            "{topic} has the frame \"lidar\" at 0.000, 0.000, 1.000 m in \"base\", and is not followed"
        );
        assert!(said[0].starts_with(&expected), "{said:?}");
    }
    let (_, said) = remarks(&[("/tf", at(1.0)), ("/tf", at(2.0))]);
    assert!(said[0].starts_with("/tf moves the frame \"lidar\" in \"base\""), "{said:?}");
    let (place, said) = remarks(&[("/a/tf_static", at(1.0)), ("/b/tf_static", at(2.0))]);
    assert_eq!(place, [0.0, 0.0, 2.0]);
    assert!(said[0].contains("several topics place the frame \"lidar\" differently"), "{said:?}");
    let elsewhere = |z: f64| TfMessage { transforms: vec![frame("base", "other", [0.0, 0.0, z])] };
    let two = [("/a/tf_static", elsewhere(1.0)), ("/b/tf_static", elsewhere(2.0))];
    assert_eq!(remarks(&two), ([0.0; 3], vec![]));
    // Of frames that no cloud is in nothing is told, and what is no pose there refuses nothing.
    let mut other = frame("map", "other", [0.0; 3]);
    other.transform.rotation.z = 9.0;
    assert_eq!(remarks(&[("/tf_static", TfMessage { transforms: vec![other.clone()] })]), ([0.0; 3], vec![]));
    other.child_frame_id = "lidar".into();
    let bytes = bag(|bag| {
        bag.write("/tf_static", &TfMessage { transforms: vec![other] });
        bag.write("/points", &odd("lidar", POINTS));
    });
    let said = describe(parse(&bytes, None, None));
    assert!(said.contains("transform of the frame \"lidar\" has no finite place"), "{said}");
}

#[test]
fn clouds_come_in_order_of_time_whatever_the_order_of_the_file() {
    let message = |time: u64| {
        let shifted = POINTS.map(|[x, y, z]| [x + time as f64, y, z]);
        ("sensor_msgs/msg/PointCloud2", "cdr", "/points", time, cdr(&odd("lidar", shifted)))
    };
    let clouds = parse(&raw_bag(&[message(3), message(1), message(2)]), None, None).unwrap();
    let first: Vec<f64> = clouds.iter().map(|cloud| cloud.points_m[0].x).collect();
    assert_eq!(first, [2.0, 3.0, 4.0]);
    let second = parse(&raw_bag(&[message(3), message(1), message(2)]), None, Some(1)).unwrap();
    assert_eq!(second, clouds[1..2]);
}

/// Files of some kilobytes that stand for gigabytes: each is refused before anything of that size is made.
#[test]
fn small_recordings_take_no_gigabytes() {
    let one_byte = |points: u32| PointCloud2 {
        header: header("lidar"),
        height: 1,
        width: points,
        fields: ["x", "y", "z"]
            .map(|name| PointField { name: name.into(), offset: 0, datatype: 1, count: 1 })
            .to_vec(),
        is_bigendian: false,
        point_step: 1,
        row_step: points,
        data: vec![0; points as usize],
        is_dense: true,
    };
    // 12 million points of a byte are 288 MB; one bag has them in one message, the other in four.
    for (points, messages) in [(12 << 20, 1), (3 << 20, 4)] {
        let packed = packed_bag(&(0..messages).map(|_| cdr(&one_byte(points))).collect::<Vec<_>>());
        assert!(packed.len() < 200_000, "{} bytes", packed.len());
        let said = describe(parse(&packed, None, None));
        assert!(said.contains("unfolds to far more than its size"), "{said}");
    }
    // A text of 4 GiB in the record of a channel, of a schema, of a chunk.
    let record = |opcode: u8, body: &[u8]| [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat();
    let long = u32::MAX.to_le_bytes();
    let magic = b"\x89MCAP0\r\n";
    for damaged in [
        record(3, &[&[1, 0][..], &long, b"x"].concat()),
        record(3, &[&[1, 0, 1, 0, 0, 0, b'x'][..], &long].concat()),
        record(4, &[&[0; 4][..], &long, b"x"].concat()),
        record(4, &[&[0; 12][..], &[9, 0, 0, 0], &long, b"xyzuv"].concat()),
        record(6, &[&[0; 28][..], &long, b"x"].concat()),
    ] {
        let said = describe(parse(&[&magic[..], &damaged, magic].concat(), None, None));
        assert!(said.contains("no whole MCAP file"), "{said}");
    }
    let frames = |count: usize, name: fn(usize) -> [String; 2]| TfMessage {
        transforms: (0..count).map(|i| frame(&name(i)[0], &name(i)[1], [0.0; 3])).collect(),
    };
    for (told_frames, expected) in [
        (frames(10_001, |i| ["map".into(), format!("f{i}")]), "has more than 10000 frames"),
        (frames(2_000, |i| [format!("f{}", i + 1), format!("f{i}")]), "more than 256 deep"),
    ] {
        let bytes = bag(|bag| {
            bag.write("/tf_static", &told_frames);
            bag.write("/points", &odd("f0", POINTS));
        });
        let said = describe(parse(&bytes, None, None));
        assert!(said.contains(expected), "{said}");
    }
}

/// A bag of messages of clouds, each in a chunk that is packed by lz4.
fn packed_bag(messages: &[Vec<u8>]) -> Vec<u8> {
    use std::io::Write;
    let record = |opcode: u8, body: &[u8]| [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat();
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let schema = [&[1, 0][..], &text("sensor_msgs/msg/PointCloud2"), &text("ros2msg"), &text("x")].concat();
    let channel = [&[1, 0, 1, 0][..], &text("/points"), &text("cdr"), &[0; 4]].concat();
    let chunk = |message: &Vec<u8>| {
        let records = record(5, &[&[1, 0][..], &[0; 20], message].concat());
        let mut packer = lz4_flex::frame::FrameEncoder::new(Vec::new());
        packer.write_all(&records).unwrap();
        let packed = packer.finish().unwrap();
        let size = (records.len() as u64).to_le_bytes();
        let head =
            [&[0; 16][..], &size, &[0; 4], &text("lz4"), &(packed.len() as u64).to_le_bytes()].concat();
        record(6, &[head, packed].concat())
    };
    let magic = b"\x89MCAP0\r\n";
    let head =
        [record(1, &[text("ros2"), text("")].concat()), record(3, &schema), record(4, &channel)].concat();
    let chunks: Vec<u8> = messages.iter().flat_map(chunk).collect();
    [&magic[..], &head, &chunks, &record(15, &[0; 4]), &record(2, &[0; 20]), magic].concat()
}
