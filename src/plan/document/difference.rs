//! What was changed in a text, line by line, as a person reads it before saving.

use serde::Serialize;

/// Unchanged lines that are shown around a change.
const AROUND: usize = 3;
/// Most pairs of lines that are compared; of more, the old lines are followed by the new ones.
const MOST_PAIRS: usize = 16_000_000;

/// What became of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LineKind {
    /// It stays.
    Same,
    /// It goes.
    Old,
    /// It comes.
    New,
    /// Lines that stay and are not shown.
    Gap,
    /// Which file the next lines are of.
    File,
}

/// A line of a difference.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DiffLine {
    /// What became of it.
    pub kind: LineKind,
    /// Its number in the old text, counted from 1.
    pub old: Option<usize>,
    /// Its number in the new text, counted from 1.
    pub new: Option<usize>,
    /// The line, without its end; of a gap, nothing.
    pub text: String,
}

impl DiffLine {
    /// The name of the file that the next lines are of.
    pub(super) fn title(name: &str) -> DiffLine {
        DiffLine { kind: LineKind::File, old: None, new: None, text: name.into() }
    }
}

/// The difference of two texts. Nothing if they are equal.
pub(super) fn difference(old: &str, new: &str) -> Vec<DiffLine> {
    let [old, new]: [Vec<&str>; 2] = [old, new].map(|text| text.split_inclusive('\n').collect());
    let same = |pair: &(&&str, &&str)| pair.0 == pair.1;
    let head = old.iter().zip(&new).take_while(same).count();
    let tail = old[head..].iter().rev().zip(new[head..].iter().rev()).take_while(same).count();
    let (old_end, new_end) = (old.len() - tail, new.len() - tail);
    let mut all: Vec<DiffLine> = (0..head).map(|i| same_line(i, i, old[i])).collect();
    all.extend(middle(&old[head..old_end], &new[head..new_end], head));
    all.extend((0..tail).map(|i| same_line(old_end + i, new_end + i, old[old_end + i])));
    shorten(all)
}

fn same_line(old: usize, new: usize, text: &str) -> DiffLine {
    DiffLine { kind: LineKind::Same, old: Some(old + 1), new: Some(new + 1), text: shown(text) }
}

/// A line without its end.
fn shown(line: &str) -> String {
    line.trim_end_matches(['\r', '\n']).into()
}

/// The lines of two texts by a longest common part.
fn middle(old: &[&str], new: &[&str], before: usize) -> Vec<DiffLine> {
    let width = new.len() + 1;
    let is_small = old.len().saturating_mul(new.len()) <= MOST_PAIRS;
    // How many lines are common from each pair of places on.
    let mut common = vec![0u32; if is_small { (old.len() + 1) * width } else { 0 }];
    if is_small {
        for i in (0..old.len()).rev() {
            for j in (0..new.len()).rev() {
                common[i * width + j] = match old[i] == new[j] {
                    true => common[(i + 1) * width + j + 1] + 1,
                    false => common[(i + 1) * width + j].max(common[i * width + j + 1]),
                };
            }
        }
    }
    let (mut i, mut j, mut all) = (0, 0, Vec::new());
    while i < old.len() || j < new.len() {
        let is_same = is_small && i < old.len() && j < new.len() && old[i] == new[j];
        let old_goes = i < old.len()
            && (j == new.len() || !is_small || common[(i + 1) * width + j] >= common[i * width + j + 1]);
        if is_same {
            all.push(same_line(before + i, before + j, old[i]));
            (i, j) = (i + 1, j + 1);
        } else if old_goes {
            let line =
                DiffLine { kind: LineKind::Old, old: Some(before + i + 1), new: None, text: shown(old[i]) };
            all.push(line);
            i += 1;
        } else {
            let line =
                DiffLine { kind: LineKind::New, old: None, new: Some(before + j + 1), text: shown(new[j]) };
            all.push(line);
            j += 1;
        }
    }
    all
}

/// Puts gaps where nothing near is changed.
fn shorten(all: Vec<DiffLine>) -> Vec<DiffLine> {
    let changed: Vec<usize> = (0..all.len()).filter(|&i| all[i].kind != LineKind::Same).collect();
    let is_near = |i: usize| {
        let next = changed.partition_point(|&place| place + AROUND < i);
        changed.get(next).is_some_and(|&place| place <= i + AROUND)
    };
    let mut short: Vec<DiffLine> = Vec::new();
    for (i, line) in all.into_iter().enumerate() {
        if is_near(i) {
            short.push(line);
        } else if !changed.is_empty() && short.last().is_none_or(|last| last.kind != LineKind::Gap) {
            short.push(DiffLine { kind: LineKind::Gap, old: None, new: None, text: String::new() });
        }
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(old: &str, new: &str) -> String {
        let sign = |kind| match kind {
            LineKind::Same => ' ',
            LineKind::Old => '-',
            LineKind::New => '+',
            LineKind::Gap => '~',
            LineKind::File => '#',
        };
        let lines = difference(old, new);
        lines.iter().map(|line| format!("{}{}\n", sign(line.kind), line.text)).collect()
    }

    #[test]
    fn changed_lines_are_shown_with_those_around_them() {
        let old = "1\n2\n3\n4\n5\n6\n7\n8\n9\n";
        assert_eq!(drawn(old, old), "");
        assert_eq!(drawn(old, &old.replace("5\n", "five\n")), "~\n 2\n 3\n 4\n-5\n+five\n 6\n 7\n 8\n~\n");
        assert_eq!(drawn(old, &old.replace("9\n", "9\n10\n")), "~\n 7\n 8\n 9\n+10\n");
        assert_eq!(drawn(old, &old.replace("1\n", "")), "-1\n 2\n 3\n 4\n~\n");
        assert_eq!(drawn("a\nb\nc\n", "b\nx\nc\n"), "-a\n b\n+x\n c\n");
        assert_eq!(drawn("", "a"), "+a\n");
        // A line end that is added is a change, too.
        assert_eq!(drawn("a", "a\n"), "-a\n+a\n");
    }

    #[test]
    fn the_new_text_can_be_read_from_it() {
        let words = ["", "a", "b", "c"];
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 16
        };
        for _ in 0..200 {
            let [old, new] = [(); 2].map(|()| {
                (0..next() % 9).map(|_| format!("{}\n", words[next() as usize % 4])).collect::<String>()
            });
            for (text, other) in [(&old, LineKind::New), (&new, LineKind::Old)] {
                let lines: Vec<&str> = text.lines().collect();
                let all = difference(&old, &new);
                for line in all.iter().filter(|line| ![other, LineKind::Gap].contains(&line.kind)) {
                    let number = if other == LineKind::New { line.old } else { line.new };
                    assert_eq!(line.text, lines[number.unwrap() - 1], "{old:?} {new:?}");
                }
                let count = |kind| all.iter().filter(|line| line.kind == kind).count();
                let (was, is) = (old.lines().count(), new.lines().count());
                assert_eq!(was + count(LineKind::New), is + count(LineKind::Old), "{old:?} {new:?}");
            }
        }
    }
}
