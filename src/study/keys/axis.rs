//! Numbers along one axis: one, a list, or a row of steps.

use serde::Deserialize;
use serde::de::{self, Deserializer, MapAccess, SeqAccess, Visitor};

use crate::diagnostics::{FARTHEST_M, Place};
use perirobot_march::Result;

/// Most numbers of one axis. A larger number comes from a mistyped step.
pub(crate) const MAX_NUMBERS: usize = 4_000_000;

/// `1.5`, `[1.5, 2.0]` or `{ start = -2.2, stop = 2.3, step = 0.5 }`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum AxisValues {
    List(Vec<f64>),
    Steps { start: f64, stop: f64, step: f64 },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Steps {
    start: f64,
    stop: f64,
    step: f64,
}

impl<'de> Deserialize<'de> for AxisValues {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AxisVisitor;
        impl<'de> Visitor<'de> for AxisVisitor {
            type Value = AxisValues;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number, a list of numbers, or { start, stop, step }")
            }
            fn visit_f64<E>(self, value: f64) -> Result<AxisValues, E> {
                Ok(AxisValues::List(vec![value]))
            }
            fn visit_i64<E>(self, value: i64) -> Result<AxisValues, E> {
                Ok(AxisValues::List(vec![value as f64]))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<AxisValues, A::Error> {
                let mut list = Vec::new();
                while let Some(value) = seq.next_element()? {
                    list.push(value);
                }
                Ok(AxisValues::List(list))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<AxisValues, A::Error> {
                let Steps { start, stop, step } =
                    Steps::deserialize(de::value::MapAccessDeserializer::new(map))?;
                Ok(AxisValues::Steps { start, stop, step })
            }
        }
        deserializer.deserialize_any(AxisVisitor)
    }
}

/// The numbers of a list, or of a row of steps: ⌊(stop − start)/step + 1e-9⌋ + 1 of them, stop included.
pub(crate) fn numbers(at: &Place, key: &str, axis: &AxisValues) -> Result<Vec<f64>> {
    let values = match axis {
        AxisValues::List(list) => list.clone(),
        AxisValues::Steps { start, stop, step } => {
            let (start, stop, step) = (*start, *stop, *step);
            let steps = ((stop - start) / step + 1e-9).floor();
            if !(step > 0.0 && step <= FARTHEST_M && steps >= 0.0 && steps < MAX_NUMBERS as f64) {
                let value = format!("{{ start = {start}, stop = {stop}, step = {step} }}");
                let rule = "step must be above 0 (neither tiny nor huge) and stop not below start";
                return Err(at.wrong(key, value, rule));
            }
            (0..=steps as usize).map(|i| start + i as f64 * step).collect()
        }
    };
    if values.is_empty() {
        return Err(at.wrong(key, "[]", "must be at least one number"));
    }
    if let Some(value) = values.iter().find(|v| !(-FARTHEST_M..=FARTHEST_M).contains(*v)) {
        return Err(at.wrong(key, value, &format!("must be from -{FARTHEST_M} to {FARTHEST_M}")));
    }
    Ok(values)
}
