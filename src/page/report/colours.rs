//! The colours of figures and of the page, in one place. Drawings use them directly, the page's style and scripts as
//! CSS variables.

use crate::render::ramp;

/// The page's scheme: name, light and dark colour. Figures use the light ones.
const SCHEME: [(&str, &str, &str); 11] = [
    ("ink", "#1c2430", "#e8edf2"),
    ("soft", "#55606f", "#a9b5c2"),
    ("line", "#d5dbe2", "#3a4653"),
    ("paper", "#ffffff", "#12171d"),
    ("tint", "#f3f6f9", "#1b222b"),
    ("accent", "#005a8f", "#74bdf0"),
    ("warn", "#8a3c00", "#ffb076"),
    ("good", "#1b6b3a", "#6fd08f"),
    ("bad", "#a3271d", "#ff9186"),
    ("chosen", "#fff3d6", "#4a3a14"),
    ("focus", "#b35c00", "#ffb454"),
];

/// Colours of series, sizes of sets and scores: those of Okabe and Ito and two more, which people with any kind of
/// colour vision can distinguish; those that print well come first.
const SERIES: [&str; 8] =
    ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#8a8a00", "#8a63d2"];

/// A part of a whole in the first of these colours.
pub(crate) const PART: &str = "#8cc0e6";

/// Colours that do not depend on the scheme.
const THINGS: [(&str, &str); 28] = [
    // The selection.
    ("picked", "#d55e00"),
    ("robot", "#0072b2"),
    ("person", "#e69f00"),
    ("badge", "#006b4f"),
    ("mount", "#007a5a"),
    ("frame", "#7c8894"),
    ("no-value", "#9aa5b1"),
    ("no-sensor", "#8a8a8a"),
    // Layers of the 3D view: blind space has the colour of the hatch in floor plans.
    ("TP", "#9db4c8"),
    ("FN", "#7b2d8b"),
    ("FP", "#d81b60"),
    ("TN", "#56b4e9"),
    ("UO", "#8c1d0f"),
    ("UF", "#d9745f"),
    ("environment", "#b8c0c8"),
    ("sensors", "#009e73"),
    ("approaches", "#c0399f"),
    // Axes of a sensor.
    ("axis-x", "#d55e00"),
    ("axis-y", "#009e73"),
    ("axis-z", "#0072b2"),
    // Reasons for unknown voxels, by the names of reasons.csv: Paul Tol's muted colours, distinct from those of the
    // layers.
    ("out_of_view", "#888888"),
    ("out_of_range", "#000000"),
    ("muted", "#dd88aa"),
    ("silent", "#999933"),
    ("between_rays", "#88ccee"),
    ("no_return", "#44aa99"),
    ("misread", "#332288"),
    ("cancelled", "#117733"),
];

/// Objects that hide voxels, in the order of the page.
const OBJECTS: [&str; 6] = ["#cc6677", "#aa4499", "#ddcc77", "#882255", "#661100", "#6699cc"];

/// Stops of the ramp from the smallest to the largest value.
const STOPS: u32 = 5;

/// The colour of a series, size or score, by its index.
pub(crate) fn series(number: usize) -> &'static str {
    SERIES[number % SERIES.len()]
}

/// The colour at a place of the ramp between the lowest (0) and the highest (1024).
pub(crate) fn ramp_colour(place: u32) -> String {
    let [r, g, b] = ramp(place);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// All colours as CSS variables.
pub(crate) fn variables() -> String {
    let variable = |(name, colour): (&str, &str)| format!("--{name}: {colour}; ");
    let day = SCHEME.map(|(name, day, _)| variable((name, day))).concat();
    let night = SCHEME.map(|(name, _, night)| variable((name, night))).concat();
    let numbered = |name: &str, colours: &[&str]| -> String {
        (0..).zip(colours).map(|(n, colour)| variable((&format!("{name}-{n}"), colour))).collect()
    };
    let stops: Vec<String> = (0..STOPS).map(|n| ramp_colour(n * 1024 / (STOPS - 1))).collect();
    let stops: Vec<&str> = stops.iter().map(String::as_str).collect();
    let numbers = [("series", &SERIES[..]), ("object", &OBJECTS), ("ramp", &stops)];
    let numbers = numbers.map(|(name, colours)| numbered(name, colours)).concat();
    let things = THINGS.map(variable).concat();
    let print = variable(("print", SCHEME[0].1));
    format!(
        ":root {{ color-scheme: light dark; {day}{print}{things}{numbers}}}\n\
         @media screen and (prefers-color-scheme: dark) {{ :root {{ {night}}} }}\n"
    )
}

/// A style sheet with light colours instead of variables, which many SVG viewers do not support.
pub(crate) fn resolve(style: &str) -> String {
    SCHEME.iter().fold(style.into(), |style, (name, day, _)| style.replace(&format!("var(--{name})"), day))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_no_variables() {
        let style = include_str!("charts/chart.css");
        assert!(style.contains("var(--"), "{style}");
        assert!(!resolve(style).contains("var("), "{}", resolve(style));
    }

    #[test]
    fn the_page_uses_no_colour_that_is_not_defined() {
        let variables = variables();
        let style =
            [include_str!("page/style.css"), include_str!("charts/chart.css"), crate::viewer::STYLE].concat();
        for name in style.split("var(").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            assert!(variables.contains(&format!("{name}: ")), "{name}");
        }
    }
}
