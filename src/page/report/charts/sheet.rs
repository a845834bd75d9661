//! The paper of a drawing, filled from top to bottom.

use std::fmt::Display;

use crate::render::svg::{Svg, tenth};

/// Approximate width of a letter of 12 units; a little more, since fonts differ.
const LETTER: f64 = 6.7;

/// Size of small letters relative to these.
pub(crate) const SMALL: f64 = 0.92;

/// Approximate width of words.
pub(crate) fn width_of(words: &str) -> f64 {
    words.chars().count() as f64 * LETTER
}

/// Words cut to a width.
pub(crate) fn cut(words: &str, width: f64) -> String {
    match width_of(words) <= width {
        true => words.into(),
        false => {
            let kept = ((width / LETTER) as usize).saturating_sub(1).max(1);
            words.chars().take(kept).chain(['…']).collect()
        }
    }
}

/// An unfinished drawing.
pub(crate) struct Sheet {
    label: String,
    svg: Svg,
    /// The place of the next element.
    pub(crate) y: f64,
}

impl Sheet {
    /// An empty drawing, with its description in words.
    pub(crate) fn new(label: &str) -> Sheet {
        Sheet { label: label.into(), svg: Svg::default(), y: 0.0 }
    }

    /// Adds words; the class sets their anchor.
    pub(crate) fn words(&mut self, class: &str, [x, y]: [f64; 2], words: &str) {
        self.svg.words(&[("class", &class), ("x", &tenth(x)), ("y", &tenth(y))], words);
    }

    /// Adds words that read from bottom to top.
    pub(crate) fn add_turned(&mut self, class: &str, [x, y]: [f64; 2], words: &str) {
        let [x, y] = [tenth(x), tenth(y)];
        let turn = format!("rotate(-90 {x} {y})");
        self.svg.words(&[("class", &class), ("x", &x), ("y", &y), ("transform", &turn)], words);
    }

    /// Adds a line or an outline.
    pub(crate) fn path(&mut self, class: &str, path: &str) {
        self.svg.element("path", &[("class", &class), ("d", &path)]);
    }

    /// Adds a line of a colour, with dashes and a tooltip.
    pub(crate) fn curve(&mut self, colour: &str, dashes: &str, path: &str, title: &str) {
        let line: [(&str, &dyn Display); 4] =
            [("class", &"curve"), ("d", &path), ("stroke", &colour), ("stroke-dasharray", &dashes)];
        self.svg.add_titled("path", &line, title);
    }

    /// Adds a line of a colour, with dashes, without a tooltip.
    pub(crate) fn line(&mut self, class: &str, (colour, dashes): (&str, &str), path: &str) {
        let line: [(&str, &dyn Display); 4] =
            [("class", &class), ("d", &path), ("stroke", &colour), ("stroke-dasharray", &dashes)];
        self.svg.element("path", &line);
    }

    /// Adds a point of a colour, with a tooltip.
    pub(crate) fn point(&mut self, class: &str, [x, y]: [f64; 2], colour: &str, title: &str) {
        let [x, y] = [tenth(x), tenth(y)];
        let point: [(&str, &dyn Display); 6] =
            [("class", &class), ("cx", &x), ("cy", &y), ("r", &5), ("stroke", &colour), ("fill", &colour)];
        self.svg.add_titled("circle", &point, title);
    }

    /// Adds a line or an outline with a tooltip; its class sets the style.
    pub(crate) fn mark(&mut self, class: &str, path: &str, title: &str) {
        self.svg.add_titled("path", &[("class", &class), ("d", &path)], title);
    }

    /// Adds a rectangle (left, upper edge, width, height), filled by its class.
    pub(crate) fn rectangle(&mut self, class: &str, [x, y, width, height]: [f64; 4]) {
        let path =
            format!("M{} {}h{}v{}h{}Z", tenth(x), tenth(y), tenth(width), tenth(height), tenth(-width));
        self.path(class, &path);
    }

    /// Adds a rectangle of a colour, with a tooltip.
    pub(crate) fn add_filled(
        &mut self,
        class: &str,
        fill: &str,
        [x, y, width, height]: [f64; 4],
        title: &str,
    ) {
        let all = [x, y, width, height].map(tenth);
        let [x, y, width, height] = all.each_ref();
        let one: [(&str, &dyn Display); 6] =
            [("class", &class), ("x", x), ("y", y), ("width", width), ("height", height), ("fill", &fill)];
        match title {
            "" => self.svg.element("rect", &one),
            title => self.svg.add_titled("rect", &one, title),
        }
    }

    /// Adds a ring that is visible on any colour.
    pub(crate) fn ring(&mut self, [x, y]: [f64; 2], radius: f64) {
        let [x, y, radius] = [x, y, radius].map(tenth);
        for class in ["halo", "thing"] {
            self.svg.element("circle", &[("class", &class), ("cx", &x), ("cy", &y), ("r", &radius)]);
        }
    }

    /// Adds elements unchanged.
    pub(crate) fn add(&mut self, elements: &str) {
        self.svg.add(elements);
    }

    /// The finished drawing, with a width and the filled height.
    pub(crate) fn finish(self, class: &str, width: f64) -> String {
        let height = tenth(self.y);
        self.svg.finish(class, &self.label, [0.0, 0.0, width, height])
    }
}

/// Words in lines of a width.
pub(crate) fn lines(words: &str, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width_of(&format!("{line} {word}")) <= width => {
                *line += &format!(" {word}");
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stay_on_the_paper() {
        assert_eq!(cut("camera", 100.0), "camera");
        assert_eq!(cut("camera", 27.0), "cam…");
        let long = "word ".repeat(100);
        let all = lines(&long, 872.0);
        assert!(all.len() > 3 && all.iter().all(|line| width_of(line) <= 872.0), "{all:?}");
        assert_eq!(all.join(" "), long.trim_end());
    }
}
