//! The places of names on a floor plan: next to their objects, apart from each other and inside the drawing.

/// The width of a letter and the height of a line, as shares of the font size.
const LETTER: f64 = 0.6;
const LINE: f64 = 1.15;

/// A box of the drawing: left, top, right, bottom.
pub(crate) type Area = [f64; 4];

/// The placed names, and boxes that they must not cover.
#[derive(Debug)]
pub(crate) struct PlacedLabels {
    within: Area,
    taken: Vec<Area>,
}

impl PlacedLabels {
    /// Inside a box.
    pub(crate) fn new(within: Area) -> PlacedLabels {
        PlacedLabels { within, taken: Vec::new() }
    }

    /// Reserves a box.
    pub(crate) fn take(&mut self, area: Area) {
        self.taken.push(area);
    }

    /// The middle of a name for an area: in it, else around it; `None` if there is no room.
    pub(crate) fn place(
        &mut self,
        name: &str,
        size: f64,
        [left, top, right, bottom]: Area,
    ) -> Option<[f64; 2]> {
        let [wide, high] = size_of(name, size);
        let [x, y] = [(left + right) / 2.0, (top + bottom) / 2.0];
        let (aside, apart) = (wide / 2.0 + 4.0, high / 2.0 + 3.0);
        let around = [
            [x, y],
            [x, top - apart],
            [x, bottom + apart],
            [right + aside, y],
            [left - aside, y],
            [right + aside, top - apart],
            [left - aside, top - apart],
            [right + aside, bottom + apart],
            [left - aside, bottom + apart],
        ];
        let around = around.into_iter().chain((2..6).flat_map(|n| {
            let far = f64::from(n) * high;
            [[x, top - far], [x, bottom + far]]
        }));
        self.place_at(name, size, around)
    }

    /// The first of some places with room for the middle of a name.
    pub(crate) fn place_at(
        &mut self,
        name: &str,
        size: f64,
        places: impl IntoIterator<Item = [f64; 2]>,
    ) -> Option<[f64; 2]> {
        let [wide, high] = size_of(name, size);
        for [x, y] in places {
            let area = [x - wide / 2.0, y - high / 2.0, x + wide / 2.0, y + high / 2.0];
            let is_inside = (0..2).all(|side| area[side] >= self.within[side])
                && (2..4).all(|side| area[side] <= self.within[side]);
            let meets = |other: &Area| (0..2).all(|r| area[r] < other[r + 2] && other[r] < area[r + 2]);
            if is_inside && !self.taken.iter().any(meets) {
                self.taken.push(area);
                return Some([x, y]);
            }
        }
        None
    }
}

/// Width and height of a name.
fn size_of(name: &str, size: f64) -> [f64; 2] {
    [name.chars().count() as f64 * LETTER * size, LINE * size]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_do_not_cover_each_other() {
        let mut labels = PlacedLabels::new([0.0, 0.0, 200.0, 100.0]);
        let table = [90.0, 45.0, 110.0, 55.0];
        let places: Vec<_> = (0..40).map_while(|_| labels.place("table", 10.0, table)).collect();
        assert_eq!(places[0], [100.0, 50.0], "in its middle");
        assert!(places.len() > 5 && places.len() < 40, "{places:?}");
        for (i, a) in places.iter().enumerate() {
            for b in &places[i + 1..] {
                assert!((a[0] - b[0]).abs() >= 30.0 || (a[1] - b[1]).abs() >= 11.5, "{a:?} covers {b:?}");
            }
        }
        assert_eq!(labels.place("a name longer than the drawing is wide", 10.0, table), None);
    }
}
