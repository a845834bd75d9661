//! MCAP files: the point clouds of one, in order of time, and a writer.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;

use byteorder::{BigEndian, LittleEndian};
use mcap::read::{ChannelAccumulator, parse_record};
use mcap::records::{MessageHeader, Record};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::Frames;
use super::chunk::unpacked;
use super::messages::{Message, PointCloud2, TfMessage, Time};
use crate::error::{Argument, Issue, Words};

/// When all that is written was: not 0, which ROS takes for "no time".
pub(crate) const STAMP: Time = Time { sec: 1, nanosec: 0 };
const STAMP_NS: u64 = 1_000_000_000;

/// Where a bag says which frames never move.
const STATIC_FRAMES: &str = "/tf_static";

/// The longest record that is read, as a file may not be longer: a damaged length must not ask for all memory.
pub(super) const LONGEST_RECORD: usize = 1 << 30;

/// How a message is serialised, as MCAP names it.
const ENCODING: &str = "cdr";

/// Hands the point clouds of a topic, or that of one message (counted from 0), to `take`, in order of time, and
/// returns the topic.
///
/// # Errors
/// When the file is damaged, has no point clouds, has several topics of them and none is named, or none is what was asked for;
/// and those of `take`.
pub(crate) fn read_clouds(
    bytes: &[u8],
    topic: Option<&str>,
    message: Option<usize>,
    mut take: impl FnMut(&Frames, PointCloud2) -> Result<(), Issue>,
) -> Result<String, Issue> {
    let mut frames = Frames::default();
    // Of each topic of clouds the times of its messages.
    let mut topics: BTreeMap<String, Vec<u64>> = BTreeMap::new();
    each_message(bytes, |message| {
        if message.channel.topic == STATIC_FRAMES && is_a::<TfMessage>(&message) {
            let said: TfMessage = decoded(&message)?;
            said.transforms.into_iter().try_for_each(|one| frames.learn(one))?;
        } else if is_a::<PointCloud2>(&message) {
            topics.entry(message.channel.topic.clone()).or_default().push(message.header.log_time);
        }
        Ok(())
    })?;
    let topic = asked_for(&topics, topic)?;
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
    // Files are in order of time but for what several threads wrote; what comes too early waits.
    let mut waiting: BTreeMap<usize, PointCloud2> = BTreeMap::new();
    let (mut place, mut next) = (0, wanted.iter().peekable());
    let asked: BTreeSet<usize> = wanted.iter().copied().collect();
    each_message(bytes, |message| {
        if message.channel.topic == topic && is_a::<PointCloud2>(&message) {
            if asked.contains(&place) {
                waiting.insert(place, decoded(&message)?);
            }
            place += 1;
            while let Some(cloud) = next.peek().and_then(|place| waiting.remove(place)) {
                next.next();
                take(&frames, cloud)?;
            }
        }
        Ok(())
    })?;
    Ok(topic)
}

/// The topic that is named, or the only one.
fn asked_for(topics: &BTreeMap<String, Vec<u64>>, topic: Option<&str>) -> Result<String, Issue> {
    let known: Vec<&String> = topics.keys().collect();
    match (topic, &known[..]) {
        (_, []) => Err(Issue::says(format!("has no messages of {}", PointCloud2::NAME))
            .wanted("record the topic of the point clouds, with `ros2 bag record`")),
        (None, [only]) => Ok((*only).clone()),
        (None, _) => Err(Issue::says(format!("has point clouds on several topics: {known:?}"))
            .cure(Words::from("name one with ") + Argument::Topic)),
        (Some(named), _) if topics.contains_key(named) => Ok(named.into()),
        (Some(named), _) => Err(Issue::value("topic", format!("{named:?}"), format!("must be of {known:?}"))),
    }
}

/// A message of a bag.
struct Recorded<'m> {
    channel: &'m mcap::Channel<'static>,
    header: MessageHeader,
    data: &'m [u8],
}

/// Hands over each message of a file. The file and one unpacked chunk are in memory, but no record of a damaged file makes
/// room for more than it can hold.
fn each_message(bytes: &[u8], mut take: impl FnMut(Recorded) -> Result<(), Issue>) -> Result<(), Issue> {
    let options =
        LinearReaderOptions::default().with_emit_chunks(true).with_record_length_limit(LONGEST_RECORD);
    let mut reader = LinearReader::new_with_options(options);
    let mut channels = ChannelAccumulator::default();
    let (mut left, mut is_summary) = (bytes, false);
    while let Some(event) = reader.next_event() {
        let (opcode, data) = match event.map_err(damaged)? {
            LinearReadEvent::ReadRequest(wanted) => {
                let (next, rest) = left.split_at(wanted.min(left.len()));
                reader.insert(next.len()).copy_from_slice(next);
                reader.notify_read(next.len());
                left = rest;
                continue;
            }
            LinearReadEvent::Record { opcode, data } => (opcode, data),
        };
        match parse_record(opcode, data).map_err(damaged)? {
            // Schemas and channels come once more behind all messages.
            _ if is_summary => {}
            Record::DataEnd(_) => is_summary = true,
            Record::Chunk { header, data } => {
                let records = unpacked(&header, data)?;
                let mut rest = &records[..];
                while let Some((opcode, body)) = next_record(&mut rest)? {
                    take_record(parse_record(opcode, body).map_err(damaged)?, &mut channels, &mut take)?;
                }
            }
            record => take_record(record, &mut channels, &mut take)?,
        }
    }
    Ok(())
}

fn damaged(e: mcap::McapError) -> Issue {
    Issue::damaged(format!("is no whole MCAP file: {e}"))
}

/// The next record of a chunk: an opcode, a length and so many bytes.
fn next_record<'d>(rest: &mut &'d [u8]) -> Result<Option<(u8, &'d [u8])>, Issue> {
    let Some((&opcode, after)) = rest.split_first() else { return Ok(None) };
    let record = after.split_first_chunk::<8>().and_then(|(length, after)| {
        let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
        after.split_at_checked(length)
    });
    let (body, after) = record.ok_or_else(|| damaged(mcap::McapError::UnexpectedEof))?;
    *rest = after;
    Ok(Some((opcode, body)))
}

/// Learns a channel, or hands a message over.
fn take_record(
    record: Record,
    channels: &mut ChannelAccumulator<'static>,
    take: &mut impl FnMut(Recorded) -> Result<(), Issue>,
) -> Result<(), Issue> {
    match record {
        Record::Schema { header, data } => {
            channels.add_schema(header, data.into_owned().into()).map_err(damaged)
        }
        Record::Channel(channel) => channels.add_channel(channel).map_err(damaged),
        Record::Message { header, data } => {
            let channel = channels.get(header.channel_id).ok_or_else(|| {
                Issue::damaged(format!("has a message of the channel {}, which it lacks", header.channel_id))
            })?;
            take(Recorded { channel: &channel, header, data: &data })
        }
        _ => Ok(()),
    }
}

/// Whether a message is one of ROS 2 of a type.
fn is_a<M: Message>(message: &Recorded) -> bool {
    let schema = message.channel.schema.as_ref();
    message.channel.message_encoding == ENCODING && schema.is_some_and(|schema| schema.name == M::NAME)
}

fn decoded<M: Message + DeserializeOwned>(message: &Recorded) -> Result<M, Issue> {
    let wrong = |what: &str| {
        let (topic, number) = (&message.channel.topic, message.header.sequence);
        Issue::damaged(format!("message {number} of {topic} is no {}: {what}", M::NAME))
    };
    let read = match message.data.split_at_checked(4) {
        Some(([0, 0, ..], body)) => cdr_encoding::from_bytes::<M, BigEndian>(body),
        Some(([0, 1, ..], body)) => cdr_encoding::from_bytes::<M, LittleEndian>(body),
        _ => return Err(wrong("it is not serialised as plain CDR")),
    };
    read.map(|(message, _)| message).map_err(|e| wrong(&e.to_string()))
}

/// Writes an MCAP file in memory.
pub(crate) struct BagWriter {
    file: mcap::Writer<Cursor<Vec<u8>>>,
}

impl BagWriter {
    pub(crate) fn new() -> BagWriter {
        let options = mcap::WriteOptions::new().profile("ros2").library("perirobot");
        // Memory takes what it is given.
        let file = options.create(Cursor::new(Vec::new())).expect("memory can be written");
        BagWriter { file }
    }

    /// Adds a message, alone on its topic, which a reader gets whenever it comes.
    pub(crate) fn write<M: Message + Serialize>(&mut self, topic: &str, message: &M) {
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
    pub(crate) fn finish(mut self) -> Vec<u8> {
        self.file.finish().expect("memory can be written");
        self.file.into_inner().into_inner()
    }
}

/// That a topic keeps its last message for who comes later, as `ros2 bag` writes it.
const LATCHED: &str = "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9223372036\n    \
                       nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  \
                       liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n  \
                       avoid_ros_namespace_conventions: false\n";
