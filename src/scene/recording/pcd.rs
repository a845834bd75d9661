//! Reads the points of a PCD file (Point Cloud Library, version 0.7): ASCII, binary, or compressed.

use glam::{DQuat, DVec3};

use super::cloud::{Cloud, check_count};
use super::header::lines;
use super::number::Number;
use super::points::{Field, Order, PointLayout};
use crate::pose::unit_quaternion;
use crate::source::MemoryLimit;
use perirobot_march::error::Issue;

/// Parses a file. Its viewpoint is where the sensor was, and how it was turned: points are in the sensor's own
/// frame, and the viewpoint moves them, as PCL's programs do.
pub(super) fn parse(bytes: &[u8]) -> Result<Cloud, Issue> {
    let mut header = PcdHeader { viewpoint: [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], ..PcdHeader::default() };
    let length = lines(bytes, "DATA", |_, words| header.line(words))?;
    let layout = header.layout()?;
    let of_sides = match header.sides[..] {
        [width, height] => width.checked_mul(height),
        _ => None,
    };
    let count = header.count.or(of_sides).ok_or_else(|| Issue::damaged("header lacks the line `POINTS`"))?;
    let data = &bytes[length..];
    let points = match header.data.as_str() {
        "ascii" => layout.points(data, count, Order::Text)?,
        "binary" => layout.points(data, count, Order::Records { is_big_endian: false })?,
        "binary_compressed" => {
            check_count(count)?;
            let mut limit = MemoryLimit::new(bytes.len() as u64);
            limit.spend_on::<DVec3>(count)?;
            let wanted = count.saturating_mul(layout.bytes());
            layout.points(&decompress(data, wanted, &mut limit)?, count, Order::Columns)?
        }
        other => return Err(Issue::unsupported(format!("has DATA {other:.40?}"))),
    };
    let [x, y, z, qw, qx, qy, qz] = header.viewpoint;
    let (sensor_m, turned) = (DVec3::new(x, y, z), DQuat::from_xyzw(qx, qy, qz, qw));
    // Some programs write zeros where nothing is turned.
    let is_turn = (turned.length() - 1.0).abs() < 1e-3 || turned.length() == 0.0;
    let Some(turned) = unit_quaternion(turned).filter(|_| sensor_m.is_finite() && is_turn) else {
        return Err(Issue::value(
            "VIEWPOINT",
            format!("{:?}", header.viewpoint),
            "must be x y z and a unit quaternion w x y z",
        ));
    };
    Cloud::new(sensor_m, points.into_iter().map(|point| sensor_m + turned * point).collect())
}

#[derive(Default)]
struct PcdHeader {
    names: Vec<String>,
    sizes: Vec<usize>,
    kinds: Vec<char>,
    counts: Vec<usize>,
    viewpoint: [f64; 7],
    /// Width and height of an organised cloud; points of any other.
    sides: Vec<usize>,
    count: Option<usize>,
    data: String,
}

impl PcdHeader {
    /// Takes a line; whether others follow.
    fn line(&mut self, words: &[&str]) -> Result<bool, Issue> {
        let Some((key, values)) = words.split_first() else { return Ok(true) };
        let wrong = |wanted: &str| Issue::value(*key, values.join(" "), wanted);
        let whole = || {
            let all = values.iter().map(|value| value.parse::<usize>().ok());
            all.collect::<Option<Vec<_>>>().ok_or_else(|| wrong("must be whole numbers"))
        };
        match *key {
            "FIELDS" | "COLUMNS" => self.names = values.iter().map(|name| name.to_string()).collect(),
            "SIZE" => self.sizes = whole()?,
            "TYPE" => self.kinds = values.iter().filter_map(|kind| kind.chars().next()).collect(),
            "COUNT" => self.counts = whole()?,
            "VIEWPOINT" => {
                let all: Option<Vec<f64>> = values.iter().map(|value| value.parse().ok()).collect();
                let all = all.and_then(|all| all.try_into().ok());
                self.viewpoint =
                    all.ok_or_else(|| wrong("must be seven numbers: x y z, and a quaternion w x y z"))?;
            }
            "WIDTH" | "HEIGHT" | "POINTS" => match (&whole()?[..], *key) {
                ([count], "POINTS") => self.count = Some(*count),
                ([side], _) => self.sides.push(*side),
                _ => return Err(wrong("must be one number")),
            },
            "DATA" => {
                self.data = values.join(" ");
                return Ok(false);
            }
            _ => {}
        }
        Ok(true)
    }

    /// The numbers of a point.
    fn layout(&self) -> Result<PointLayout, Issue> {
        let PcdHeader { names, sizes, kinds, counts, .. } = self;
        let ones = vec![1; names.len()];
        let counts = if counts.is_empty() { &ones } else { counts };
        if names.is_empty() || [sizes.len(), kinds.len(), counts.len()] != [names.len(); 3] {
            return Err(Issue::damaged(
                "FIELDS, SIZE, TYPE and COUNT of its header do not have as many entries",
            ));
        }
        let fields =
            names.iter().zip(sizes).zip(kinds).zip(counts).map(|(((name, &size), &kind), &count)| {
                let number = Number::new(kind.to_ascii_lowercase(), size).ok_or_else(|| {
                    Issue::unsupported(format!(
                        "has the field {name:?} of the unknown type {kind} of {size} bytes"
                    ))
                })?;
                match (1..=MOST_NUMBERS).contains(&count) {
                    true => Ok(Field { name: name.clone(), number, count }),
                    false => Err(Issue::damaged(format!("has {count} numbers {name:?} in each point"))),
                }
            });
        Ok(PointLayout(fields.collect::<Result<_, _>>()?))
    }
}

/// Most numbers of one name in a point; descriptors of features have some hundred.
const MOST_NUMBERS: usize = 1 << 16;

/// The bytes of a compressed file's data: two lengths, and what LZF made of the columns. `wanted` is how many bytes the
/// points have. If packing does not help, some programs store the bytes as they are, and both lengths are equal.
fn decompress(data: &[u8], wanted: usize, limit: &mut MemoryLimit) -> Result<Vec<u8>, Issue> {
    let damaged = || Issue::damaged("its compressed points end too early: the file is truncated or damaged");
    let length = |at: usize| {
        let word = data.get(at..at + 4).and_then(|word| word.try_into().ok()).map(u32::from_le_bytes);
        word.map(|word| word as usize).ok_or_else(damaged)
    };
    let (packed, unpacked) = (length(0)?, length(4)?);
    let input = data.get(8..8 + packed).ok_or_else(damaged)?;
    if unpacked != wanted {
        let what = format!("its compressed points are {unpacked} bytes, and its header makes them {wanted}");
        return Err(Issue::damaged(what).with_advice("the file is truncated or damaged"));
    }
    limit.spend(unpacked as u64)?;
    match unpack(input, unpacked) {
        Some(bytes) => Ok(bytes),
        None if packed == unpacked => Ok(input.to_vec()),
        None => Err(damaged()),
    }
}

/// What LZF packed, if it has this length.
fn unpack(input: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut input = input.iter().copied();
    let mut out: Vec<u8> = Vec::with_capacity(length);
    let mut next = || input.next();
    while let Some(control) = next().map(usize::from) {
        if control < 32 {
            for _ in 0..=control {
                out.push(next()?);
            }
        } else {
            let mut run = control >> 5;
            if run == 7 {
                run += usize::from(next()?);
            }
            let back = ((control & 31) << 8) + usize::from(next()?) + 1;
            // A run may reach into what it writes itself.
            let from = out.len().checked_sub(back)?;
            (from..from + run + 2).for_each(|at| out.push(out[at]));
        }
        if out.len() > length {
            return None;
        }
    }
    (out.len() == length).then_some(out)
}
