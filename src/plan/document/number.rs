//! Values as they are written.

use toml_edit::Value;

/// A number, whole or not.
pub(super) fn to_number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// A number as people write it: 1.25, -20.
pub(super) fn number(value: f64) -> String {
    // A zero has no sign here.
    format!("{}", value + 0.0)
}

/// A text in quotes.
pub(super) fn quote(text: &str) -> String {
    Value::from(text).to_string()
}

/// A key, in quotes if it needs them.
pub(super) fn quote_key(key: &str) -> String {
    toml_edit::Key::new(key).to_string().trim().to_string()
}

/// A list in brackets.
pub(super) fn list(values: impl Iterator<Item = String>) -> String {
    format!("[{}]", values.collect::<Vec<_>>().join(", "))
}
