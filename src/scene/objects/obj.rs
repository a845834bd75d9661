//! Reads the surfaces of Wavefront OBJ files, in the file's own numbers: OBJ has no unit and no up axis, so
//! the caller supplies both. Lines, points, curves, normals and materials are passed over.

use std::path::Path;

use glam::DVec3;

use super::mesh::Welder;
use super::{Mesh, polygon};
use crate::source::{Sources, lines};
use crate::spelling::number as number_of;
use perirobot_march::Result;
use perirobot_march::error::Issue;

/// Reads an OBJ file: raw coordinates, nothing scaled; faces of more than three corners are cut into
/// triangles.
///
/// # Errors
/// When the file cannot be read, a corner is not three finite numbers, a face names a corner that is not
/// there, or there is no triangle with an area. OBJ has no end mark: a file cut between two faces cannot be
/// told from a whole one.
pub fn load(path: &Path, sources: &Sources) -> Result<Mesh> {
    let bytes = sources.bytes_of_text(path)?;
    // Names may be in any encoding; numbers are ASCII in all of them.
    parse(&String::from_utf8_lossy(&bytes)).map_err(|issue| issue.with_place(path).into())
}

fn parse(text: &str) -> Result<Mesh, Issue> {
    let mut vertices = Vec::new();
    let mut welder = Welder::default();
    let mut lines = lines(text).enumerate();
    while let Some((number, line)) = lines.next() {
        let mut statement = strip_comment(line).to_owned();
        // A backslash carries a corner or a face on to the next line. A name may end in one: `mtllib C:\\cell\\`.
        while statement.ends_with('\\') && statement.trim_start().starts_with(['v', 'f']) {
            statement.pop();
            let Some((_, more)) = lines.next() else { break };
            statement += strip_comment(more);
        }
        let mut words = statement.split_whitespace();
        let read = match words.next() {
            Some("v") => corner(words).map(|corner| vertices.push(corner)),
            Some("f") => face(words, &vertices, &mut welder),
            _ => Ok(()),
        };
        read.map_err(|what| what.with_place(format!("line {}", number + 1)))?;
    }
    let mesh = welder.finish();
    if mesh.triangles.is_empty() {
        return Err(Issue::says("has no face with an area").with_advice("export a surface"));
    }
    Ok(mesh)
}

/// A line up to its comment, which ends with the line whatever its last character is.
fn strip_comment(line: &str) -> &str {
    line.split('#').next().unwrap_or_default().trim_end()
}

/// The three numbers of a `v` line; a weight or a colour may follow.
fn corner<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<DVec3, Issue> {
    let mut number = || -> Result<f64, Issue> {
        let word = words.next().ok_or_else(|| Issue::says("a corner has fewer than three numbers"))?;
        let value = number_of(word).ok_or_else(|| {
            Issue::says(format!("{word:.40?} is not a number"))
                .with_advice("write it with a decimal point, as in 1.5")
        })?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(Issue::says(format!("{word:.40}")).with_advice("must be finite"))
        }
    };
    Ok(DVec3::new(number()?, number()?, number()?))
}

fn face<'a>(
    words: impl Iterator<Item = &'a str>,
    vertices: &[DVec3],
    welder: &mut Welder,
) -> Result<(), Issue> {
    let corner = |word: &str| -> Result<DVec3, Issue> {
        let count = vertices.len();
        // `place/texture/normal`; places count from 1, or back from the last corner so far.
        let place: i64 = word
            .split('/')
            .next()
            .and_then(|place| place.parse().ok())
            .ok_or_else(|| Issue::says(format!("{word:.40?} is no corner of a face")))?;
        let index = if place < 0 { place.saturating_add(count as i64) } else { place.saturating_sub(1) };
        let corner = usize::try_from(index).ok().and_then(|index| vertices.get(index)).copied();
        corner.ok_or_else(|| {
            Issue::says(format!("corner {place} of a face")).with_advice(format!("there are {count} so far"))
        })
    };
    let corners: Vec<DVec3> = words.map(corner).collect::<Result<_, _>>()?;
    for triangle in polygon::triangles(&corners)? {
        welder.triangle(triangle.map(|i| corners[i]));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::mesh::tests::{assert_closed, volume};

    const CUBE: &str = "# a cube\nmtllib cube.mtl\no Cube\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\n\
        v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvn 0 0 1\nvt 0 0\nusemtl red\ns off\nf 1 4 3 2\nf 5/1 6/1 7/1 8/1\n\
        f 1//1 2//1 6//1 5//1\nf 2/1/1 3/1/1 7/1/1 6/1/1\nf -6 -5 \\\n  -1 -2\nf 4 1 5 8\nl 1 2\n";

    #[test]
    fn every_way_of_naming_a_corner_gives_the_same_cube() {
        let mesh = parse(CUBE).unwrap();
        assert_closed(&mesh);
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (8, 12));
        assert!((volume(&mesh) - 1.0).abs() < 1e-12);
        assert_eq!(parse(&CUBE.replace('\n', "\r\n")).unwrap(), mesh);
    }

    /// Corners are counted by what is written, so a line too many or too few would move all that follows.
    #[test]
    fn neither_comments_nor_names_are_carried_on() {
        let cube = parse(CUBE).unwrap();
        for (from, to) in [
            ("# a cube", "# saved to C:\\cell\\"),
            ("# a cube", "#\\\n#"),
            ("mtllib cube.mtl", "mtllib C:\\cell\\"),
            ("o Cube", "o Cube\\"),
            ("usemtl red", "g \\\\server\\parts\\"),
            ("v 0 1 0", "v 0 1 0 # was D:\\"),
            ("v 0 1 0", "v 0 \\\n1 \\\n  0 # in three lines \\"),
            ("s off", "f 1 2\nf 3\nf"),
        ] {
            assert_eq!(parse(&CUBE.replacen(from, to, 1)).unwrap(), cube, "{to:?}");
        }
        assert_eq!(parse(&CUBE.replace('\n', "\r")).unwrap(), cube, "lines of an old Macintosh");
    }

    #[test]
    fn a_face_with_a_dent_leaves_it_empty() {
        let mesh = parse("v 0 0 0\nv 2 1 0\nv 0 2 0\nv 0.5 1 0\nf 1 2 3 4\n").unwrap();
        let area: f64 = (mesh.triangles.iter())
            .map(|t| t.map(|i| mesh.vertices[i as usize]))
            .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
            .sum();
        assert!((area - 1.5).abs() < 1e-12, "{area}");
    }

    #[test]
    fn what_is_wrong_is_named_by_its_line() {
        for (text, expected) in [
            ("", "no face with an area"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no face with an area"),
            ("v 0 0\n", "line 1: a corner has fewer than three numbers"),
            ("v 0 0 x\n", "line 1: \"x\" is not a number: write it with a decimal point"),
            ("v 0 0 -nan(ind)\n", "line 1: -nan(ind): must be finite"),
            ("v 0 0 nan\n", "line 1: nan: must be finite"),
            ("v 0 0 1e999\n", "line 1: 1e999: must be finite"),
            ("v 0 0 0\nv 1 0 0\nf 1 2 3\n", "line 3: corner 3 of a face: there are 2 so far"),
            ("v 0 0 0\nv 1 0 0\nf 1 2 0\n", "line 3: corner 0 of a face"),
            ("v 0 0 0\nv 1 0 0\nf 1 2 -3\n", "line 3: corner -3 of a face"),
            ("f -9223372036854775808 9223372036854775807 1\n", "line 1: corner -92233"),
            ("v 0 0 0\nv 1 0 0\nf 1 2\n", "no face with an area"),
            ("v 0 0 0\nf 1 a 2\n", "line 2: \"a\" is no corner"),
            ("v 0 0 0\nf 1 1 1\n", "no face with an area"),
        ] {
            let what = parse(text).expect_err(text);
            assert!(what.to_string().contains(expected), "{what:?} lacks {expected:?}");
        }
    }

    #[test]
    fn no_cut_of_a_file_panics() {
        for length in 0..CUBE.len() {
            let _ = parse(&CUBE[..length]);
        }
    }
}
