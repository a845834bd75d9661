//! The page of the planner, and that of the cells to begin with: HTML texts with style and script inside, which fetch nothing
//! but what the planner's own server answers. The 3D view is the report's. Names from the study reach the page as text only.

use base64::{Engine, prelude::BASE64_STANDARD};
use sha2::{Digest, Sha256};

use perirobot_page::render::plan;
use perirobot_page::viewer;

/// What the script and the style take the place of.
const STYLE_PLACE: &str = "/*STYLE*/";
const SCRIPT_PLACE: &str = "/*SCRIPT*/";

/// What a browser says that cannot run the script, mostly an old one.
const FAILED: &str = r#"function failed(error) {
  const failure = document.getElementById("failure");
  failure.hidden = false;
  failure.textContent = `The planner cannot be shown: ${error.message}.`;
  throw error;
}"#;

/// The page's own scripts, in the order in which they are read: what is known, scores, poses, the two views and what is dragged
/// in them, tools, the panels around them, keys; the last one begins.
const OWN_SCRIPTS: [&str; 21] = [
    include_str!("state.js"),
    include_str!("live.js"),
    include_str!("poses.js"),
    include_str!("layers.js"),
    include_str!("wording.js"),
    include_str!("dots.js"),
    include_str!("scene.js"),
    include_str!("drag.js"),
    include_str!("objects.js"),
    include_str!("zones.js"),
    include_str!("tools.js"),
    include_str!("plan.js"),
    include_str!("plan_drag.js"),
    include_str!("inspector.js"),
    include_str!("status.js"),
    include_str!("files.js"),
    include_str!("leave.js"),
    include_str!("front.js"),
    include_str!("find.js"),
    include_str!("keys.js"),
    include_str!("start.js"),
];

/// The page as HTML, and the Content-Security-Policy to send with it.
pub fn html() -> (String, String) {
    let (style, script) = (style(), script());
    let csp = policy(&[&style], &[&script]);
    let page = include_str!("page.html").replace(STYLE_PLACE, &style).replace(SCRIPT_PLACE, &script);
    (page, csp)
}

/// The page of the cells to begin with, and a policy under which the planner's page runs as well.
pub fn gallery() -> (String, String) {
    let (style, script) = (gallery_style(), wrapped(include_str!("gallery.js")));
    let csp = policy(&[&style, &self::style()], &[&script, &self::script()]);
    let page = include_str!("gallery.html").replace("/*PATTERNS*/", plan::PATTERNS);
    (page.replace(STYLE_PLACE, &style).replace(SCRIPT_PLACE, &script), csp)
}

fn gallery_style() -> String {
    style() + include_str!("gallery.css")
}

/// Colours, the floor plan's and the viewer's style, then the page's own.
fn style() -> String {
    [&viewer::colour_variables(), plan::STYLE, viewer::STYLE, include_str!("style.css")].concat()
}

fn script() -> String {
    wrapped(&[&viewer::SCRIPTS[..], &OWN_SCRIPTS].concat().join("\n"))
}

fn wrapped(parts: &str) -> String {
    format!("{FAILED}\n(async () => {{\n\"use strict\";\n{parts}}})().catch(failed);\n")
}

/// Only these styles and scripts, and requests to the page's own server: whatever stands in a study, nothing else runs.
fn policy(styles: &[&str], scripts: &[&str]) -> String {
    let hashes = |texts: &[&str]| -> String {
        let hash =
            |text: &&str| format!("'sha256-{}'", BASE64_STANDARD.encode(Sha256::digest(text.as_bytes())));
        texts.iter().map(hash).collect::<Vec<_>>().join(" ")
    };
    let (styles, scripts) = (hashes(styles), hashes(scripts));
    format!(
        "default-src 'none'; script-src {scripts}; style-src {styles}; connect-src 'self'; img-src blob: data:; \
         frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text between two others, of which the first is the first in the page and the second the last.
    fn between<'a>(page: &'a str, begin: &str, end: &str) -> &'a str {
        let rest = page.split_once(begin).unwrap().1;
        rest.rsplit_once(end).unwrap().0
    }

    #[test]
    fn a_browser_runs_what_the_policy_names() {
        let ((page, own), (gallery, both)) = (html(), gallery());
        for (page, csp) in [(&page, &own), (&page, &both), (&gallery, &both)] {
            for (kind, text) in [
                ("style", between(page, "<style>", "</style>")),
                ("script", between(page, "<script>", "</script>")),
            ] {
                let hash = BASE64_STANDARD.encode(Sha256::digest(text.as_bytes()));
                let rule = csp.split("; ").find(|rule| rule.starts_with(&format!("{kind}-src"))).unwrap();
                assert!(rule.contains(&format!("'sha256-{hash}'")), "{kind}: {csp}");
            }
            assert_eq!(page.matches("<script").count(), 1, "nothing else is a script");
            assert!(!csp.contains("unsafe"), "{csp}");
        }
    }

    #[test]
    fn the_pages_fetch_nothing_and_write_no_html() {
        for (page, _) in [html(), gallery()] {
            for word in [
                "http:",
                "https:",
                "innerHTML",
                "outerHTML",
                "insertAdjacentHTML",
                "document.write",
                "eval(",
                "style=\"",
                "onclick=\"",
            ] {
                let found = page.replace("http://www.w3.org/2000/svg", "");
                assert!(!found.contains(word), "{word}");
            }
        }
    }

    #[test]
    fn the_style_names_colours_that_are_defined() {
        let style = gallery_style();
        for name in style.split("var(").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            assert!(style.contains(&format!("{name}: ")), "{name}");
        }
    }
}
