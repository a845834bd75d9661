//! The page of the figures: each with its contents, the command that made its numbers, and the paper's counterpart.

use super::{Figure, FigureKind, FiguredSweep, LeftOut};
use crate::report::wording::{count, extent};
use perirobot_scene::shell;

/// The name of the page.
pub const PAGE: &str = "README.md";

/// The page during its construction.
#[derive(Debug, Default)]
pub struct FigurePage {
    text: String,
}

impl FigurePage {
    /// Adds the figures of a sweep, in the folder of its name, and the omitted ones.
    pub fn add(&mut self, sweep: &FiguredSweep, figures: &[Figure], left_out: &[LeftOut]) {
        let about = &sweep.manifest.provenance.about;
        let numbers = [extent(&sweep.results), count(sweep.results.regions.len(), "region")].join(", ");
        self.text += &format!(
            "\n## {}\n\nStudy {}; {numbers}; voxels of {} m. The numbers were made by\n\n    {}\n",
            plain(&sweep.name),
            plain(&about.study.file),
            sweep.study.voxel_size_m,
            shell::command(&about.command).replace('\n', " "),
        );
        for kind in FigureKind::ALL {
            let of_kind: Vec<&Figure> = figures.iter().filter(|figure| figure.kind == kind).collect();
            let without: Vec<&str> =
                left_out.iter().filter(|one| one.kind == kind).map(|one| one.why.as_str()).collect();
            if of_kind.is_empty() && without.is_empty() {
                continue;
            }
            self.text += &format!("\n### {}\n\n{}\n", heading(kind), about_kind(kind));
            for figure in of_kind {
                let (caption, file) = (plain(&figure.caption), format!("{}/{}", sweep.name, figure.file));
                let address = encode(&file);
                self.text +=
                    &format!("\n{}: {caption}\n\n![{}](<{address}>)\n", plain(&file), plain(&figure.file));
            }
            without.iter().for_each(|why| self.text += &format!("\nLeft out: {}.\n", plain(why)));
        }
    }

    /// The page as a file.
    pub fn finish(self) -> String {
        format!(
            "# Figures\n\nDrawn by `perirobot figures`, version {}, from finished sweeps. The numbers are those of `perirobot summary` of \
             the same folders: a score has no unit, and a score without a value is left out of means. The paper is Rozlivek, Svarny and \
             Hoffmann, IROS 2023 (arXiv 2303.02367); a figure named after one of its experiments shows the same kind of numbers, of \
             this study, not the paper's own.\n{}",
            env!("CARGO_PKG_VERSION"),
            self.text
        )
    }
}

fn heading(kind: FigureKind) -> &'static str {
    match kind {
        FigureKind::Distributions => "Distributions",
        FigureKind::Placements => "Places",
        FigureKind::Maxima => "Maxima of combinations",
        FigureKind::Snapshots => "Snapshots",
        FigureKind::Pictures => "Pictures",
    }
}

/// The purpose of a kind of figures, and the paper's claims about it.
fn about_kind(kind: FigureKind) -> &'static str {
    match kind {
        FigureKind::Distributions => {
            "As in the paper's Experiment 1: whether every keypoint addition beats raw points, which has the best medians and maxima, \
             and whether the zone camera is outperformed by all."
        }
        FigureKind::Placements => {
            "As in the paper's Experiments 1 and 3: where good places are (around the walls, behind people, on the ceiling), \
             and whether F1 and κ choose different ones."
        }
        FigureKind::Maxima => {
            "As in the paper's Experiment 2: how much the triplet beats pairs and single sensors, and which pair is second."
        }
        FigureKind::Snapshots => "As in the paper's Experiment 3: one sensor while people move.",
        FigureKind::Pictures => {
            "The scenes, and the labels of the best choices of poses in the first drawn scene, as `perirobot render` \
             draws them."
        }
    }
}

/// Escapes words for Markdown.
fn plain(words: &str) -> String {
    let mut text = String::with_capacity(words.len());
    for letter in words.chars() {
        match letter {
            '\n' | '\r' | '\t' => text.push(' '),
            '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '>' | '#' | '|' | '!' | '&' | '~' => {
                text.extend(['\\', letter])
            }
            other => text.push(other),
        }
    }
    text
}

/// The path of a file as an address, with percent-encoding.
fn encode(path: &str) -> String {
    let mut text = String::with_capacity(path.len());
    for byte in path.bytes() {
        match byte {
            b'%' | b'?' | b'#' | b'<' | b'>' | b'\\' | b'`' | b'&' | 0..=32 | 127.. => {
                text += &format!("%{byte:02X}")
            }
            other => text.push(char::from(other)),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_of_plain_letters() {
        assert_eq!(encode("exp1/map-robot.svg"), "exp1/map-robot.svg");
        assert_eq!(encode("a b`<c>#1%/ä.svg"), "a%20b%60%3Cc%3E%231%25/%C3%A4.svg");
    }

    #[test]
    fn names_of_strangers_are_words() {
        assert_eq!(plain("a*b [x](y)\n<script>&amp;"), r"a\*b \[x\](y) \<script\>\&amp;");
    }
}
