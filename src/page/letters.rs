//! The letters of a set's sensors, equal in the planner and in all parts of a report.

/// The letter of a sensor by its index in its set, counted from 0: A to Z, then AA and so on.
pub fn letter(number: usize) -> String {
    let own = char::from(b'A' + (number % 26) as u8);
    match number / 26 {
        0 => own.to_string(),
        more => letter(more - 1) + &own.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::letter;

    #[test]
    fn letters_go_on_after_z() {
        let all = [0, 1, 25, 26, 27, 51, 52, 701, 702].map(letter);
        assert_eq!(all, ["A", "B", "Z", "AA", "AB", "AZ", "BA", "ZZ", "AAA"]);
    }
}
