//! Schemas of the values that are read by code of their own.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::unit::UNITS;
use super::{AxisValues, NameOrNumber, OneOrTwo, Unit};

impl JsonSchema for NameOrNumber {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "NameOrNumber".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [{ "type": "string" }, { "type": "integer", "minimum": 0 }] })
    }
}

impl JsonSchema for AxisValues {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Axis".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let number = json_schema!({ "type": "number" });
        json_schema!({ "anyOf": [
            number,
            { "type": "array", "items": number, "minItems": 1 },
            {
                "type": "object",
                "properties": { "start": number, "stop": number, "step": number },
                "required": ["start", "stop", "step"],
                "additionalProperties": false,
            },
        ]})
    }
}

impl JsonSchema for OneOrTwo {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "OneOrTwo".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [{ "type": "number" }, <[f64; 2]>::json_schema(generator)] })
    }
}

impl JsonSchema for Unit {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Unit".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let names = UNITS.map(|(name, _)| name);
        json_schema!({ "anyOf": [{ "enum": names }, { "type": "number", "minimum": 1e-6, "maximum": 1e6 }] })
    }
}
