//! Points in files: which of the numbers of each is x, y and z, as text, in records, or in columns.

use glam::DVec3;

use super::cloud::check_count;
use super::number::Number;
use crate::spelling::number;
use perirobot_march::error::Issue;

/// The numbers of a point, in their order.
#[derive(Clone, Debug, Default)]
pub(super) struct PointLayout(pub(super) Vec<Field>);

/// One or several numbers of a name.
#[derive(Clone, Debug)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) number: Number,
    pub(super) count: usize,
}

/// How the numbers of points stand in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// A line of text for each point.
    Text,
    /// All numbers of the first point, then those of the second.
    Records { is_big_endian: bool },
    /// The first numbers of all points, then the second.
    Columns,
}

impl PointLayout {
    /// The points of a file's data, of which there are so many.
    ///
    /// # Errors
    /// When a point has no x, y or z, the data are shorter, or there are too many.
    pub(super) fn points(&self, data: &[u8], count: usize, order: Order) -> Result<Vec<DVec3>, Issue> {
        check_count(count)?;
        match order {
            Order::Text => self.parse_text(data, count),
            Order::Records { is_big_endian } => self.parse_binary(data, count, is_big_endian, false),
            Order::Columns => self.parse_binary(data, count, false, true),
        }
    }

    /// The bytes of a point.
    pub(super) fn bytes(&self) -> usize {
        self.0.iter().map(|field| field.number.bytes() * field.count).sum()
    }

    /// Index of the field of each axis.
    fn axes(&self) -> Result<[usize; 3], Issue> {
        let mut axes = [0; 3];
        for (axis, wanted) in axes.iter_mut().zip(["x", "y", "z"]) {
            *axis = (self.0.iter().position(|field| field.name == wanted))
                .ok_or_else(|| Issue::damaged(format!("its points have no {wanted}")))?;
        }
        Ok(axes)
    }

    fn parse_text(&self, data: &[u8], count: usize) -> Result<Vec<DVec3>, Issue> {
        let before = |axis: usize| self.0[..axis].iter().map(|field| field.count).sum::<usize>();
        let places = self.axes()?.map(before);
        let text = std::str::from_utf8(data).map_err(|_| Issue::damaged("its points are no text"))?;
        let lines = text.lines().filter(|line| !line.trim().is_empty()).take(count).enumerate();
        let points: Vec<DVec3> = lines
            .map(|(row, line)| {
                let mut point = DVec3::ZERO;
                for (r, place) in places.into_iter().enumerate() {
                    let word = line.split_whitespace().nth(place).unwrap_or_default();
                    point[r] = number(word).ok_or_else(|| {
                        Issue::damaged(format!(
                            "point {row}: {line:.60?} has no number at place {}",
                            place + 1
                        ))
                        .with_advice(
                            "must be numbers with a decimal point, as in 1.5, with spaces between them",
                        )
                    })?;
                }
                Ok(point)
            })
            .collect::<Result<_, Issue>>()?;
        match points.len() == count {
            true => Ok(points),
            false => Err(truncation(points.len(), count)),
        }
    }

    fn parse_binary(
        &self,
        data: &[u8],
        count: usize,
        is_big_endian: bool,
        in_columns: bool,
    ) -> Result<Vec<DVec3>, Issue> {
        let bytes = |field: &Field| field.number.bytes() * field.count;
        let length = self.bytes();
        let axes = self.axes()?;
        if data.len() / length < count {
            return Err(truncation(data.len() / length, count));
        }
        // Where the number of an axis stands for the first point, and how far it is to that of the next.
        let places = axes.map(|axis| {
            let before: usize = self.0[..axis].iter().map(bytes).sum();
            match in_columns {
                true => (before * count, bytes(&self.0[axis])),
                false => (before, length),
            }
        });
        let point = |row: usize| {
            DVec3::from_array(std::array::from_fn(|r| {
                let (first, stride) = places[r];
                self.0[axes[r]].number.read(&data[first + row * stride..], is_big_endian)
            }))
        };
        Ok((0..count).map(point).collect())
    }
}

fn truncation(found: usize, promised: usize) -> Issue {
    Issue::damaged(format!("has {found} of the {promised} points of its header: the file is truncated"))
}
