//! Reads the points of a PLY file: ASCII, or binary in either order of bytes.

use glam::DVec3;

use super::cloud::Cloud;
use super::header::lines;
use super::number::Number;
use super::points::{Field, Order, PointLayout};
use perirobot_march::error::Issue;

/// Parses a file. It does not say where the sensor was: at the origin.
pub(super) fn parse(bytes: &[u8]) -> Result<Cloud, Issue> {
    let mut header = PlyHeader::default();
    let length = lines(bytes, "end_header", |number, words| header.line(number, words))?;
    let order = header.order.ok_or_else(|| Issue::damaged("header lacks the line `format`"))?;
    let count = header.count.ok_or_else(|| Issue::damaged("header lacks the line `element vertex`"))?;
    Cloud::new(DVec3::ZERO, header.layout.points(&bytes[length..], count, order)?)
}

#[derive(Default)]
struct PlyHeader {
    order: Option<Order>,
    count: Option<usize>,
    layout: PointLayout,
    /// Whether the element whose properties are listed is the points.
    in_points: bool,
}

impl PlyHeader {
    /// Takes a line; whether others follow.
    fn line(&mut self, number: usize, words: &[&str]) -> Result<bool, Issue> {
        match words {
            ["ply"] if number == 0 => {}
            _ if number == 0 => return Err(Issue::unsupported("does not begin with the line `ply`")),
            ["format", "ascii", _] => self.order = Some(Order::Text),
            ["format", "binary_little_endian", _] => {
                self.order = Some(Order::Records { is_big_endian: false });
            }
            ["format", "binary_big_endian", _] => self.order = Some(Order::Records { is_big_endian: true }),
            ["format", ..] => {
                return Err(Issue::unsupported(format!("has the format {:?}", words[1..].join(" "))));
            }
            ["element", "vertex", count] => {
                let parsed = count.parse::<usize>().ok();
                let wrong =
                    || Issue::value("element vertex", format!("{count:.40}"), "must be a whole number");
                self.count = Some(parsed.ok_or_else(wrong)?);
                self.in_points = true;
            }
            // Data of elements behind the points are never reached.
            ["element", name, _] if self.count.is_none() => {
                return Err(Issue::unsupported(format!("has the element {name:?} before its vertices")));
            }
            ["element", ..] => self.in_points = false,
            ["property", "list", ..] if self.in_points => {
                return Err(Issue::unsupported("has a list of numbers in each vertex"));
            }
            ["property", kind, name] if self.in_points => {
                let number = number_of(kind).ok_or_else(|| {
                    Issue::unsupported(format!("has the property {name:?} of the unknown type {kind:?}"))
                })?;
                self.layout.0.push(Field { name: name.to_string(), number, count: 1 });
            }
            ["end_header"] => return Ok(false),
            _ => {}
        }
        Ok(true)
    }
}

/// PLY's names of types, old and new.
fn number_of(kind: &str) -> Option<Number> {
    Some(match kind {
        "char" | "int8" => Number::I8,
        "uchar" | "uint8" => Number::U8,
        "short" | "int16" => Number::I16,
        "ushort" | "uint16" => Number::U16,
        "int" | "int32" => Number::I32,
        "uint" | "uint32" => Number::U32,
        "float" | "float32" => Number::F32,
        "double" | "float64" => Number::F64,
        _ => return None,
    })
}
