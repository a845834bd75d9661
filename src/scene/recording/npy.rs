//! Reads one numpy array: its header of text, and its numbers in either order of axes.

use super::labels::voxels_of;
use super::number::Number;
use perirobot_march::error::Issue;

/// The longest header; that of an array of plain numbers has a hundred bytes.
const LONGEST_HEADER: usize = 1 << 16;

/// An array of numbers.
#[derive(Clone, Debug)]
pub(super) struct Array {
    pub(super) shape: Vec<usize>,
    /// Whether the first index varies fastest.
    is_fortran: bool,
    number: Number,
    is_big_endian: bool,
    bytes: Vec<u8>,
    /// Where its numbers begin in the bytes.
    begin: usize,
}

impl Array {
    /// Parses the bytes of an `.npy` file.
    pub(super) fn parse(bytes: Vec<u8>) -> Result<Array, Issue> {
        let damaged = || Issue::damaged("is no numpy array, or a truncated one");
        let version = bytes.strip_prefix(b"\x93NUMPY").and_then(|rest| rest.first()).ok_or_else(damaged)?;
        let word = |at: usize| bytes.get(at).map(|&byte| usize::from(byte)).ok_or_else(damaged);
        let (length, from) = match version {
            1 => (word(8)? | word(9)? << 8, 10),
            2 | 3 => (word(8)? | word(9)? << 8 | word(10)? << 16 | word(11)? << 24, 12),
            other => return Err(Issue::unsupported(format!("is a numpy array of version {other}"))),
        };
        if length > LONGEST_HEADER {
            return Err(Issue::too_large(format!(
                "has a header of {length} bytes, more than {LONGEST_HEADER}"
            )));
        }
        let begin = from + length;
        let header = String::from_utf8_lossy(bytes.get(from..begin).ok_or_else(damaged)?).into_owned();
        let after = |key: &str| {
            let quoted = [format!("'{key}':"), format!("\"{key}\":")];
            let found = quoted.iter().find_map(|key| header.split_once(key.as_str()));
            found.map(|(_, rest)| rest.trim_start()).ok_or_else(damaged)
        };
        let descr: String =
            after("descr")?.chars().skip(1).take_while(|c| !matches!(c, '\'' | '"')).collect();
        let (number, is_big_endian) = number_of(&descr).ok_or_else(|| {
            Issue::unsupported(format!("has numbers of the type {descr:?}: whole or floating ones are read"))
        })?;
        let shape: String = after("shape")?.chars().skip(1).take_while(|c| *c != ')').collect();
        let shape = shape.split(',').map(str::trim).filter(|n| !n.is_empty()).map(str::parse);
        let shape: Vec<usize> = shape.collect::<Result<_, _>>().map_err(|_| damaged())?;
        let count = shape.iter().try_fold(1usize, |all, n| all.checked_mul(*n)).ok_or_else(damaged)?;
        let wanted = count.checked_mul(number.bytes()).ok_or_else(damaged)?;
        if bytes.len() - begin < wanted {
            return Err(damaged());
        }
        let is_fortran = after("fortran_order")?.starts_with("True");
        Ok(Array { shape, is_fortran, number, is_big_endian, bytes, begin })
    }

    /// Its shape, if it has three axes.
    pub(super) fn three(&self) -> Result<[usize; 3], Issue> {
        self.shape
            .as_slice()
            .try_into()
            .map_err(|_| Issue::says(format!("has the shape {:?}, must be (x, y, z)", self.shape)))
    }

    /// The first numbers, at most four, in the order in which they are stored: enough to tell that there are more than three.
    pub(super) fn numbers(&self) -> Vec<f64> {
        (0..self.shape.iter().product()).take(4).map(|n| self.get(n)).collect()
    }

    /// Whether its numbers are bytes without a sign, which have no −1.
    pub(super) fn is_of_bytes(&self) -> bool {
        self.number == Number::U8
    }

    /// Calls `see` with the place and the number of each entry of an array of three axes.
    pub(super) fn each(&self, see: &mut dyn FnMut([i32; 3], f64)) {
        let Ok([nx, ny, nz]) = self.three() else { return };
        for [x, y, z] in voxels_of([nx, ny, nz]) {
            let n = if self.is_fortran { x + nx * (y + ny * z) } else { z + nz * (y + ny * x) };
            see([x, y, z].map(|n| n as i32), self.get(n));
        }
    }

    fn get(&self, n: usize) -> f64 {
        self.number.read(&self.bytes[self.begin + n * self.number.bytes()..], self.is_big_endian)
    }
}

/// A type as numpy writes it: `|i1`, `<f8`, `|b1`.
fn number_of(descr: &str) -> Option<(Number, bool)> {
    let mut letters = descr.chars();
    let order = letters.next()?;
    let kind = letters.next()?;
    let bytes: usize = letters.as_str().parse().ok()?;
    let number = match (kind, bytes) {
        ('b', 1) => Number::U8,
        _ => Number::new(kind, bytes)?,
    };
    Some((number, order == '>'))
}
