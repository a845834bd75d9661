//! In which unit a file of geometry is, and which of its axes points up.

use serde::Deserialize;
use serde::de::{self, Deserializer, Visitor};

/// The unit of a file: `"mm"`, or metres in one of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit(pub(crate) f64);

pub(super) const UNITS: [(&str, f64); 4] = [("m", 1.0), ("cm", 0.01), ("mm", 1e-3), ("in", 0.0254)];

impl<'de> Deserialize<'de> for Unit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct UnitVisitor;
        impl Visitor<'_> for UnitVisitor {
            type Value = Unit;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("\"m\", \"cm\", \"mm\", \"in\", or metres in one of it, from 0.000001 to 1000000")
            }
            fn visit_str<E: de::Error>(self, word: &str) -> Result<Unit, E> {
                let known = UNITS.iter().find(|(name, _)| *name == word);
                known
                    .map(|(_, metres)| Unit(*metres))
                    .ok_or_else(|| E::unknown_variant(word, &["m", "cm", "mm", "in"]))
            }
            fn visit_f64<E: de::Error>(self, metres: f64) -> Result<Unit, E> {
                match (1e-6..=1e6).contains(&metres) {
                    true => Ok(Unit(metres)),
                    false => Err(E::invalid_value(de::Unexpected::Float(metres), &self)),
                }
            }
            fn visit_i64<E: de::Error>(self, metres: i64) -> Result<Unit, E> {
                self.visit_f64(metres as f64)
            }
        }
        deserializer.deserialize_any(UnitVisitor)
    }
}

/// Which axis of a file points up.
#[derive(Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub(crate) enum UpFile {
    Y,
    Z,
}
