//! MCAP files: the point clouds of one, in order of time, and a writer.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;

use byteorder::{BigEndian, LittleEndian};
use mcap::read::{ChannelAccumulator, parse_record};
use mcap::records::{MessageHeader, Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::Frames;
use super::chunk::{LONGEST_RECORD, unpack};
use super::messages::{Message, PointCloud2, TfMessage, Time};
use super::ros1::{FromRos1, byte_sequence};
use crate::source::MemoryLimit;
use perirobot_march::error::{Argument, Issue, Words};

/// When all that is written was: not 0, which ROS takes for "no time".
pub const STAMP: Time = Time { sec: 1, nanosec: 0 };
const STAMP_NS: u64 = 1_000_000_000;

/// The last part of the topics on which a bag says which frames never move, and where others are. Both may be in the
/// namespace of a robot.
pub(super) const STATIC_FRAMES: &str = "tf_static";
const MOVING_FRAMES: &str = "tf";

/// How messages are serialised, as MCAP names it: those of ROS 2, and those of ROS 1.
const ENCODING: &str = "cdr";
const ENCODING_OF_ROS1: &str = "ros1";

/// Most kinds of other messages that are named where there is no cloud.
const MOST_OTHERS: usize = 6;

/// Hands the point clouds of a topic, or that of one message (counted from 0), to `take`, in the order of the file, each
/// with its place in the order of time. Returns the topic.
///
/// # Errors
/// When the file is damaged, unfolds to far more than its size, has no point clouds, has several topics of them and none
/// is named, or none is what was asked for; and those of `take`.
pub(crate) fn read_clouds(
    bytes: &[u8],
    topic: Option<&str>,
    message: Option<usize>,
    mut take: impl FnMut(&Frames, usize, PointCloud2) -> Result<(), Issue>,
) -> Result<String, Issue> {
    /// What is kept of a message until it is read: its time, and two places.
    const KEPT_BYTES: u64 = 48;
    let mut limit = MemoryLimit::new(bytes.len() as u64);
    let mut frames = Frames::default();
    // Of each topic of clouds the times of its messages.
    let mut topics: BTreeMap<String, Vec<u64>> = BTreeMap::new();
    let mut others: BTreeSet<String> = BTreeSet::new();
    each_message(bytes, |message| {
        let topic = &message.channel.topic;
        let kind = topic.rsplit('/').next().unwrap_or_default();
        if is_a::<TfMessage>(&message) && [STATIC_FRAMES, MOVING_FRAMES].contains(&kind) {
            let learn = if kind == STATIC_FRAMES { Frames::learn } else { Frames::learn_moving };
            let said: TfMessage = decode(&message)?;
            return said.transforms.into_iter().try_for_each(|one| learn(&mut frames, topic, one));
        }
        if is_a::<PointCloud2>(&message) {
            limit.spend(KEPT_BYTES)?;
            topics.entry(topic.clone()).or_default().push(message.header.log_time);
        } else if others.len() < MOST_OTHERS {
            let schema = message.channel.schema.as_ref().map_or("no type", |schema| schema.name.as_str());
            others.insert(format!("{schema} ({}) on {topic}", message.channel.message_encoding));
        }
        Ok(())
    })?;
    let topic = asked_for(&topics, &others, topic)?;
    let times = &topics[&topic];
    let mut order: Vec<usize> = (0..times.len()).collect();
    order.sort_by_key(|&place| times[place]);
    let wanted = match message {
        None => order,
        Some(number) => match order.get(number) {
            Some(&place) => vec![place],
            None => {
                let rule =
                    format!("must be from 0 to {}: {topic} has {} of them", times.len() - 1, times.len());
                return Err(Issue::value("message", number, rule));
            }
        },
    };
    let mut places_in_time: Vec<Option<usize>> = vec![None; times.len()];
    wanted.into_iter().enumerate().for_each(|(in_time, place)| places_in_time[place] = Some(in_time));
    let mut places = places_in_time.into_iter();
    each_message(bytes, |message| {
        if message.channel.topic == topic
            && is_a::<PointCloud2>(&message)
            && let Some(in_time) = places.next().flatten()
        {
            take(&frames, in_time, decode(&message)?)?;
        }
        Ok(())
    })?;
    Ok(topic)
}

/// The topic that is named, or the only one.
fn asked_for(
    topics: &BTreeMap<String, Vec<u64>>,
    others: &BTreeSet<String>,
    topic: Option<&str>,
) -> Result<String, Issue> {
    let known: Vec<&String> = topics.keys().collect();
    match (topic, &known[..]) {
        (_, []) => {
            let none = Issue::says(format!("has no messages of {}", PointCloud2::NAME))
                .with_advice("record the topic of the point clouds, with `ros2 bag record`");
            match others.is_empty() {
                true => Err(none),
                false => {
                    Err(none.cure(format!("it has {}", Vec::from_iter(others.iter().cloned()).join(", "))))
                }
            }
        }
        (None, [only]) => Ok((*only).clone()),
        (None, _) => Err(Issue::says(format!("has point clouds on several topics: {known:?}"))
            .cure(Words::from("name one with ") + Argument("topic"))),
        (Some(named), _) if topics.contains_key(named) => Ok(named.into()),
        (Some(named), _) => Err(Issue::value("topic", format!("{named:?}"), format!("must be of {known:?}"))),
    }
}

/// A message of a bag.
struct BagMessage<'m> {
    channel: &'m mcap::Channel<'static>,
    header: MessageHeader,
    data: &'m [u8],
}

/// Hands over each message of a file. The file and one unpacked chunk are in memory; all chunks together may not be far
/// larger than the file, and no record of a damaged file makes room for more than it can hold.
fn each_message(bytes: &[u8], mut take: impl FnMut(BagMessage) -> Result<(), Issue>) -> Result<(), Issue> {
    let options =
        LinearReaderOptions::default().with_emit_chunks(true).with_record_length_limit(LONGEST_RECORD);
    let mut reader = LinearReader::new_with_options(options);
    let mut channels = ChannelAccumulator::default();
    let mut limit = MemoryLimit::new(bytes.len() as u64);
    let (mut left, mut is_summary) = (bytes, false);
    if !mcap::MAGIC.starts_with(&bytes[..bytes.len().min(mcap::MAGIC.len())]) {
        let what = "its first bytes are not those of MCAP: convert a .bag or .db3 with `mcap convert FILE NAME.mcap`";
        return Err(not_whole(what));
    }
    while let Some(event) = reader.next_event() {
        let (opcode, data) = match event.map_err(damage)? {
            LinearReadEvent::ReadRequest(wanted) => {
                let (next, rest) = left.split_at(wanted.min(left.len()));
                reader.insert(next.len()).copy_from_slice(next);
                reader.notify_read(next.len());
                left = rest;
                continue;
            }
            LinearReadEvent::Record { opcode, data } => (opcode, data),
        };
        match record(opcode, data)? {
            // Schemas and channels come once more behind all messages.
            _ if is_summary => {}
            Some(Record::DataEnd(_)) => is_summary = true,
            Some(Record::Chunk { header, data }) => {
                limit.spend(header.uncompressed_size)?;
                let records = unpack(&header, data)?;
                let mut rest = &records[..];
                while let Some((opcode, body)) = next_record(&mut rest)? {
                    take_record(record(opcode, body)?, &mut channels, &mut take)?;
                }
            }
            record => take_record(record, &mut channels, &mut take)?,
        }
    }
    Ok(())
}

/// A record of a kind that is needed here. The parser makes room for texts before it reads them, so their lengths are
/// compared with that of the record first.
fn record(opcode: u8, body: &[u8]) -> Result<Option<Record<'_>>, Issue> {
    // How many bytes are before the first text, how many texts there are, and whether a list of texts follows.
    let (before, texts, has_list) = match opcode {
        op::SCHEMA => (2, 2, false),
        op::CHANNEL => (4, 2, true),
        op::CHUNK => (28, 1, false),
        op::MESSAGE | op::DATA_END => (0, 0, false),
        _ => return Ok(None),
    };
    let fits = || {
        let mut rest = body.get(before..)?;
        for _ in 0..texts {
            byte_sequence(&mut rest)?;
        }
        if has_list {
            let mut list = byte_sequence(&mut rest)?;
            while !list.is_empty() {
                byte_sequence(&mut list)?;
            }
        }
        Some(())
    };
    fits().ok_or_else(|| damage(mcap::McapError::UnexpectedEof))?;
    parse_record(opcode, body).map(Some).map_err(damage)
}

fn damage(e: mcap::McapError) -> Issue {
    let what = match e {
        mcap::McapError::BadMagic => {
            "its last bytes are not those of MCAP: copy it again, or run `mcap recover FILE -o NAME.mcap`"
                .into()
        }
        mcap::McapError::UnexpectedEof => {
            "it ends within a record: copy it again, or run `mcap recover FILE -o NAME.mcap`".into()
        }
        other => other.to_string(),
    };
    not_whole(&what)
}

fn not_whole(what: &str) -> Issue {
    Issue::damaged(format!("is no whole MCAP file: {what}"))
}

/// The next record of a chunk: an opcode, a length and so many bytes.
fn next_record<'d>(rest: &mut &'d [u8]) -> Result<Option<(u8, &'d [u8])>, Issue> {
    let Some((&opcode, after)) = rest.split_first() else { return Ok(None) };
    let record = after.split_first_chunk::<8>().and_then(|(length, after)| {
        let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
        after.split_at_checked(length)
    });
    let (body, after) = record.ok_or_else(|| damage(mcap::McapError::UnexpectedEof))?;
    *rest = after;
    Ok(Some((opcode, body)))
}

/// Learns a channel, or hands a message over.
fn take_record(
    record: Option<Record>,
    channels: &mut ChannelAccumulator<'static>,
    take: &mut impl FnMut(BagMessage) -> Result<(), Issue>,
) -> Result<(), Issue> {
    match record {
        Some(Record::Schema { header, data }) => {
            channels.add_schema(header, data.into_owned().into()).map_err(damage)
        }
        Some(Record::Channel(channel)) => channels.add_channel(channel).map_err(damage),
        Some(Record::Message { header, data }) => {
            let channel = channels.get(header.channel_id).ok_or_else(|| {
                Issue::damaged(format!("has a message of the channel {}, which it lacks", header.channel_id))
            })?;
            take(BagMessage { channel: &channel, header, data: &data })
        }
        _ => Ok(()),
    }
}

/// Whether a message is one of ROS of a type. Some programs write the types of ROS 2 as those of ROS 1, without `msg`.
fn is_a<M: Message>(message: &BagMessage) -> bool {
    let Some(schema) = message.channel.schema.as_ref() else { return false };
    let is_known = [ENCODING, ENCODING_OF_ROS1].contains(&message.channel.message_encoding.as_str());
    is_known && (schema.name == M::NAME || schema.name == M::NAME.replacen("/msg/", "/", 1))
}

fn decode<M: Message + DeserializeOwned + FromRos1>(message: &BagMessage) -> Result<M, Issue> {
    let wrong = |what: &str| {
        let (topic, number) = (&message.channel.topic, message.header.sequence);
        Issue::damaged(format!("message {number} of {topic} is no {}: {what}", M::NAME))
    };
    if message.channel.message_encoding == ENCODING_OF_ROS1 {
        return M::from_ros1(&mut &*message.data).ok_or_else(|| wrong("it ends too early"));
    }
    let read = match message.data.split_at_checked(4) {
        Some(([0, 0, ..], body)) => cdr_encoding::from_bytes::<M, BigEndian>(body),
        Some(([0, 1, ..], body)) => cdr_encoding::from_bytes::<M, LittleEndian>(body),
        _ => return Err(wrong("it is not serialised as plain CDR")),
    };
    read.map(|(message, _)| message).map_err(|_| wrong("it is cut off, or serialised otherwise"))
}

/// Writes an MCAP file in memory.
pub struct BagWriter {
    file: mcap::Writer<Cursor<Vec<u8>>>,
}

impl Default for BagWriter {
    /// A file without messages.
    fn default() -> BagWriter {
        let options = mcap::WriteOptions::new().profile("ros2").library("perirobot");
        // Memory takes what it is given.
        let file = options.create(Cursor::new(Vec::new())).expect("memory can be written");
        BagWriter { file }
    }
}

impl BagWriter {
    /// Adds a message, alone on its topic, which a reader gets whenever it comes.
    pub fn write<M: Message + Serialize>(&mut self, topic: &str, message: &M) {
        // Little-endian plain CDR.
        let mut body = vec![0, 1, 0, 0];
        body.extend(cdr_encoding::to_vec::<M, LittleEndian>(message).expect("all fields are plain"));
        let schema = self.file.add_schema(M::NAME, "ros2msg", M::DEFINITION.as_bytes());
        let latched = BTreeMap::from([("offered_qos_profiles".to_string(), LATCHED.to_string())]);
        let channel = schema.and_then(|schema| self.file.add_channel(schema, topic, ENCODING, &latched));
        let written = channel.and_then(|channel_id| {
            let header =
                MessageHeader { channel_id, sequence: 0, log_time: STAMP_NS, publish_time: STAMP_NS };
            self.file.write_to_known_channel(&header, &body)
        });
        written.expect("memory can be written");
    }

    /// The file's bytes.
    pub fn finish(mut self) -> Vec<u8> {
        self.file.finish().expect("memory can be written");
        self.file.into_inner().into_inner()
    }
}

/// That a topic keeps its last message for who comes later, as `ros2 bag` writes it.
const LATCHED: &str = "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9223372036\n    \
                       nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  \
                       liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n  \
                       avoid_ros_namespace_conventions: false\n";
