//! The paper of a figure: its title and what a reader must know, and below them what is drawn, from above downwards.

use crate::render::svg::{Svg, tenth};

/// How wide each figure is, in units of the drawing: two columns of print.
pub(super) const WIDTH: f64 = 900.0;

/// Room at the sides.
pub(super) const EDGE: f64 = 14.0;

/// About how wide a letter of 12 units is; fonts differ, so rather more.
const LETTER: f64 = 6.7;

/// Small letters, as a part of these.
pub(super) const SMALL: f64 = 0.92;

/// The height of a line.
const LINE: f64 = 16.0;

/// The width between the sides.
const ACROSS: f64 = WIDTH - 2.0 * EDGE;

/// Colours of Okabe and Ito, which people with any kind of colour vision can distinguish, the ones first that print well.
const COLOURS: [&str; 7] = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#999999"];

/// The colour of the thing of a number.
pub(super) fn colour(number: usize) -> &'static str {
    COLOURS[number % COLOURS.len()]
}

/// About how wide words are.
pub(super) fn width_of(words: &str) -> f64 {
    words.chars().count() as f64 * LETTER
}

/// Words as they fit into a width, cut where they are longer.
pub(super) fn cut(words: &str, width: f64) -> String {
    match width_of(words) <= width {
        true => words.into(),
        false => {
            let kept = ((width / LETTER) as usize).saturating_sub(1).max(1);
            words.chars().take(kept).chain(['…']).collect()
        }
    }
}

/// A figure that is being drawn.
pub(super) struct Sheet {
    title: String,
    svg: Svg,
    /// Where the next thing begins.
    pub(super) y: f64,
}

impl Sheet {
    /// With a title and what a reader must know.
    pub(super) fn new(title: &str, notes: &str) -> Sheet {
        let mut sheet = Sheet { title: title.into(), svg: Svg::default(), y: EDGE + 12.0 };
        for line in lines(title, ACROSS / 1.3) {
            sheet.words("title", [EDGE, sheet.y], &line);
            sheet.y += LINE + 2.0;
        }
        sheet.note(notes);
        sheet
    }

    /// Adds a paragraph in small letters.
    pub(super) fn note(&mut self, words: &str) {
        for line in lines(words, ACROSS / SMALL) {
            self.words("soft", [EDGE, self.y], &line);
            self.y += LINE - 1.0;
        }
        self.y += 4.0;
    }

    /// Adds words; the class says where they are anchored.
    pub(super) fn words(&mut self, class: &str, [x, y]: [f64; 2], words: &str) {
        self.svg.words(&[("class", &class), ("x", &tenth(x)), ("y", &tenth(y))], words);
    }

    /// Adds words that are turned to be read from below upwards.
    pub(super) fn add_turned(&mut self, class: &str, [x, y]: [f64; 2], words: &str) {
        let [x, y] = [tenth(x), tenth(y)];
        let turn = format!("rotate(-90 {x} {y})");
        self.svg.words(&[("class", &class), ("x", &x), ("y", &y), ("transform", &turn)], words);
    }

    /// Adds a line or an outline.
    pub(super) fn path(&mut self, class: &str, path: &str) {
        self.svg.element("path", &[("class", &class), ("d", &path)]);
    }

    /// Adds a line of a colour, broken by a pattern of dashes.
    pub(super) fn curve(&mut self, colour: &str, dashes: &str, path: &str, title: &str) {
        let line: [(&str, &dyn std::fmt::Display); 4] =
            [("class", &"curve"), ("d", &path), ("stroke", &colour), ("stroke-dasharray", &dashes)];
        self.svg.add_titled("path", &line, title);
    }

    /// Adds a rectangle (left, upper edge, width, height), filled as its class says.
    pub(super) fn rectangle(&mut self, class: &str, [x, y, width, height]: [f64; 4]) {
        let path =
            format!("M{} {}h{}v{}h{}Z", tenth(x), tenth(y), tenth(width), tenth(height), tenth(-width));
        self.path(class, &path);
    }

    /// Adds a rectangle of a colour that tells something under the mouse.
    pub(super) fn add_filled(
        &mut self,
        class: &str,
        fill: &str,
        [x, y, width, height]: [f64; 4],
        title: &str,
    ) {
        let all = [x, y, width, height].map(tenth);
        let [x, y, width, height] = all.each_ref();
        let one: [(&str, &dyn std::fmt::Display); 6] =
            [("class", &class), ("x", x), ("y", y), ("width", width), ("height", height), ("fill", &fill)];
        self.svg.add_titled("rect", &one, title);
    }

    /// Adds a ring that is seen on any colour.
    pub(super) fn ring(&mut self, [x, y]: [f64; 2], radius: f64) {
        let [x, y, radius] = [x, y, radius].map(tenth);
        for class in ["halo", "thing"] {
            self.svg.element("circle", &[("class", &class), ("cx", &x), ("cy", &y), ("r", &radius)]);
        }
    }

    /// The file.
    pub(super) fn finish(self) -> String {
        let height = tenth(self.y + EDGE);
        let mut svg = Svg::default();
        svg.add(&format!("<style>\n{}</style>\n", include_str!("figure.css")));
        svg.element("rect", &[("class", &"sheet"), ("width", &"100%"), ("height", &"100%")]);
        svg.add(&self.svg.into_text());
        svg.finish("figure", &self.title, [0.0, 0.0, WIDTH, height])
    }
}

/// Words in lines of a width.
pub(super) fn lines(words: &str, width: f64) -> Vec<String> {
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
        let all = lines(&long, ACROSS);
        assert!(all.len() > 3 && all.iter().all(|line| width_of(line) <= ACROSS), "{all:?}");
        assert_eq!(all.join(" "), long.trim_end());
    }
}
