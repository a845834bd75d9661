//! Numbers of any type in binary files.

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Number {
    /// A signed or unsigned whole number (`i`, `u`) or a floating one (`f`) of so many bytes, if there is such
    /// a type.
    pub(super) fn new(kind: char, bytes: usize) -> Option<Number> {
        Some(match (kind, bytes) {
            ('i', 1) => Number::I8,
            ('i', 2) => Number::I16,
            ('i', 4) => Number::I32,
            ('i', 8) => Number::I64,
            ('u', 1) => Number::U8,
            ('u', 2) => Number::U16,
            ('u', 4) => Number::U32,
            ('u', 8) => Number::U64,
            ('f', 4) => Number::F32,
            ('f', 8) => Number::F64,
            _ => return None,
        })
    }

    /// Its length in bytes.
    pub(super) fn bytes(self) -> usize {
        match self {
            Number::I8 | Number::U8 => 1,
            Number::I16 | Number::U16 => 2,
            Number::I32 | Number::U32 | Number::F32 => 4,
            Number::I64 | Number::U64 | Number::F64 => 8,
        }
    }

    /// The number that begins a slice, which must be long enough.
    pub(super) fn read(self, bytes: &[u8], is_big_endian: bool) -> f64 {
        let mut word = [0; 8];
        let own = &mut word[..self.bytes()];
        own.copy_from_slice(&bytes[..self.bytes()]);
        if is_big_endian {
            own.reverse();
        }
        let [a, b, c, d, ..] = word;
        match self {
            Number::I8 => f64::from(a as i8),
            Number::U8 => f64::from(a),
            Number::I16 => f64::from(i16::from_le_bytes([a, b])),
            Number::U16 => f64::from(u16::from_le_bytes([a, b])),
            Number::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Number::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Number::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Number::I64 => i64::from_le_bytes(word) as f64,
            Number::U64 => u64::from_le_bytes(word) as f64,
            Number::F64 => f64::from_le_bytes(word),
        }
    }
}
