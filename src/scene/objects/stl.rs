//! Reads STL files, binary and ASCII, in the file's own numbers: STL has no unit, so the caller scales. Equal
//! corners become one vertex; normals and colours are ignored.

use std::io::Cursor;
use std::path::Path;

use glam::DVec3;

use super::Mesh;
use super::mesh::Welder;
use crate::source::{Sources, lines, strip_mark};
use crate::spelling::{number, plural};
use perirobot_march::Result;
use perirobot_march::error::Issue;

/// Bytes before the first triangle of a binary file: 80 of free text, 4 of triangle count.
const HEADER: usize = 84;
/// Bytes of a triangle in a binary file.
const TRIANGLE: usize = 50;
/// No line of an ASCII file needs more; the parser below splits a line into owned words, so a line as long as
/// the file would cost many times its size.
const LONGEST_LINE: usize = 1024;

/// Reads an STL file: raw coordinates, nothing scaled.
///
/// # Errors
/// When the file cannot be read, is shorter than its triangle count needs, a number is not finite, or there is no
/// triangle with an area.
pub fn load(path: &Path, sources: &Sources) -> Result<Mesh> {
    let (mesh, behind) = parse(sources.bytes(path)?).map_err(|issue| issue.with_place(path))?;
    if behind > 0 {
        let bytes = plural(behind, "byte");
        sources.remark(path, format!("without {bytes} behind its triangles: is it several files in one?"));
    }
    Ok(mesh)
}

/// The surface, and how many bytes there are behind the triangles that a binary file declares.
fn parse(bytes: Vec<u8>) -> Result<(Mesh, usize), Issue> {
    let is_whole = |bytes: &[u8]| declared_length(bytes).is_some_and(|length| length <= bytes.len() as u64);
    let bytes = if is_whole(&bytes) { bytes } else { strip_mark(bytes)? };
    // The triangle count of a binary file has a zero among its bytes, a text has none.
    let is_text = starts_with_word(&bytes, b"solid") && !bytes.contains(&0);
    let is_exact = declared_length(&bytes) == Some(bytes.len() as u64);
    let (prepared, behind) = match declared_length(&bytes) {
        _ if is_text && !is_exact => (joined_solids(&String::from_utf8_lossy(&bytes))?, 0),
        Some(length) if is_whole(&bytes) => {
            let behind = bytes.len() - length as usize;
            (blank_header(bytes, length as usize), behind)
        }
        _ => return Err(wrong_length(&bytes)),
    };
    let mut reader = Cursor::new(prepared);
    let triangles =
        stl_io::create_stl_reader(&mut reader).map_err(|_| Issue::damaged("is not an STL file"))?;
    let mut welder = Welder::default();
    for (number, triangle) in triangles.enumerate() {
        let corners = triangle
            .map_err(|_| {
                Issue::damaged(format!("triangle {number} is not as it must be"))
                    .with_advice("facet normal, outer loop, three vertex, endloop, endfacet, each in a line")
            })?
            .vertices
            .map(|v| DVec3::from_array(v.0.map(f64::from)));
        if let Some(corner) = corners.iter().find(|c| !c.is_finite()) {
            return Err(Issue::says(format!("triangle {number} has the corner {corner}"))
                .with_advice("must be finite"));
        }
        welder.triangle(corners);
    }
    let mesh = welder.finish();
    if mesh.triangles.is_empty() {
        return Err(Issue::says("has no triangle with an area").with_advice("export a surface"));
    }
    Ok((mesh, behind))
}

/// The length that a binary file's triangle count asks for.
fn declared_length(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    let count = u32::from_le_bytes(count.try_into().ok()?);
    Some(HEADER as u64 + u64::from(count) * TRIANGLE as u64)
}

fn wrong_length(bytes: &[u8]) -> Issue {
    match declared_length(bytes) {
        Some(length) => Issue::damaged(format!(
            "declares {} triangles, {length} bytes in all, and has {} bytes: it is truncated or no STL",
            (length - HEADER as u64) / TRIANGLE as u64,
            bytes.len()
        )),
        None => Issue::damaged(format!("has {} bytes: too short for an STL", bytes.len())),
    }
}

/// What a binary file declares. Some exporters begin its header with "solid", which the parser would take for ASCII.
fn blank_header(mut bytes: Vec<u8>, length: usize) -> Vec<u8> {
    bytes.truncate(length);
    bytes[..HEADER - 4].fill(b' ');
    bytes
}

fn starts_with_word(line: &[u8], word: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    line.len() >= word.len()
        && line[..word.len()].eq_ignore_ascii_case(word)
        && line.get(word.len()).is_none_or(u8::is_ascii_whitespace)
}

/// An ASCII file as one nameless lower-case solid: the parser stops at the first `endsolid`, and would drop
/// the other solids of a file without a word.
fn joined_solids(text: &str) -> Result<Vec<u8>, Issue> {
    let mut joined = b"solid \n".to_vec();
    let (mut opened, mut closed, mut wrong) = (0usize, 0usize, None);
    for (index, line) in lines(text).enumerate() {
        if starts_with_word(line.as_bytes(), b"solid") {
            opened += 1;
        } else if starts_with_word(line.as_bytes(), b"endsolid") {
            closed += 1;
        } else if line.len() > LONGEST_LINE {
            return Err(Issue::too_large(format!("line {} is {} bytes long", index + 1, line.len()))
                .with_advice(format!("at most {LONGEST_LINE} are read")));
        } else {
            match facet_line(line) {
                Ok(line) => {
                    joined.extend(line.into_bytes());
                    joined.push(b'\n');
                }
                Err(issue) => wrong = wrong.or(Some(issue.with_place(format!("line {}", index + 1)))),
            }
        }
    }
    if opened != closed {
        return Err(Issue::damaged(format!(
            "begins {opened} solids and ends {closed}: it is truncated, or a damaged binary file"
        )));
    }
    // Of a file that is cut off the last line is mostly wrong, too.
    if let Some(wrong) = wrong {
        return Err(wrong);
    }
    joined.extend(b"endsolid\n");
    Ok(joined)
}

/// A line of a facet as the parser takes it. Normals are not used, and some programs write numbers there that are not finite.
fn facet_line(line: &str) -> Result<String, Issue> {
    let line = line.trim().to_ascii_lowercase();
    let mut words = line.split_whitespace();
    match words.next() {
        Some("facet") => Ok("facet normal 0 0 0".into()),
        Some("vertex") => {
            let numbers: Vec<&str> = words.collect();
            if numbers.len() != 3 {
                return Err(Issue::damaged(format!("a vertex has {} numbers", numbers.len()))
                    .with_advice("must be three"));
            }
            match numbers.iter().find(|word| !number(word).is_some_and(f64::is_finite)) {
                Some(word) => Err(Issue::damaged(format!("a vertex has {word:.40?}"))
                    .with_advice("must be a finite number with a decimal point, as in 1.5 or 1.5e-3")),
                None => Ok(line),
            }
        }
        None | Some("outer" | "endloop" | "endfacet") => Ok(line),
        Some(word) => Err(Issue::damaged(format!("begins with {word:.40?}"))
            .with_advice("must be one of solid, facet, outer loop, vertex, endloop, endfacet, endsolid")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::mesh::tests::{assert_closed, volume};

    fn parse(bytes: Vec<u8>) -> Result<Mesh, Issue> {
        super::parse(bytes).map(|(mesh, _)| mesh)
    }

    const TETRAHEDRON: [[[f32; 3]; 3]; 4] = [
        [[0., 0., 0.], [0., 1., 0.], [1., 0., 0.]],
        [[0., 0., 0.], [1., 0., 0.], [0., 0., 1.]],
        [[0., 0., 0.], [0., 0., 1.], [0., 1., 0.]],
        [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]],
    ];

    fn binary(header: &[u8], triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, 0);
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for triangle in triangles {
            bytes.extend([0; 12]);
            bytes.extend(triangle.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    fn ascii(name: &str, triangles: &[[[f32; 3]; 3]]) -> String {
        let mut text = format!("solid {name}\n");
        for t in triangles {
            text += "  facet normal 0 0 0\n    outer loop\n";
            for [x, y, z] in t {
                text += &format!("      vertex {x} {y} {z:e}\n");
            }
            text += "    endloop\n  endfacet\n";
        }
        text + "endsolid\n"
    }

    #[test]
    fn binary_and_ascii_give_the_same_closed_body() {
        let mesh = parse(binary(b"made by hand", &TETRAHEDRON)).unwrap();
        assert_closed(&mesh);
        assert_eq!(mesh.vertices.len(), 4);
        assert!((volume(&mesh) - 1.0 / 6.0).abs() < 1e-12);
        assert_eq!(parse(binary(b"solid part", &TETRAHEDRON)).unwrap(), mesh);
        assert_eq!(parse(ascii("a part", &TETRAHEDRON).into_bytes()).unwrap(), mesh);
        let shouted = ascii("", &TETRAHEDRON).to_uppercase().replace('\n', "\r\n");
        assert_eq!(parse(shouted.into_bytes()).unwrap(), mesh);
        let two_solids = ascii("a", &TETRAHEDRON[..2]) + "\n" + &ascii("b", &TETRAHEDRON[2..]);
        assert_eq!(parse(two_solids.into_bytes()).unwrap(), mesh);
    }

    #[test]
    fn a_binary_file_that_could_be_text_is_still_binary() {
        // Zeros and twos have only ASCII bytes, and none ends a line.
        let triangle = [[0., 0., 0.], [2., 0., 0.], [0., 2., 0.]];
        let mesh = parse(binary(b"solid part", &[triangle])).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
    }

    #[track_caller]
    fn assert_refused(bytes: Vec<u8>, expected: &str) {
        let what = parse(bytes).expect_err(expected);
        assert!(what.to_string().contains(expected), "{what:?} lacks {expected:?}");
    }

    #[test]
    fn what_is_wrong_is_named() {
        let good = binary(b"", &TETRAHEDRON);
        assert_refused(Vec::new(), "too short");
        assert_refused(good[..good.len() - 1].to_vec(), "declares 4 triangles");
        let mut lying = good.clone();
        lying[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_refused(lying, "declares 4294967295 triangles");
        assert_refused(binary(b"", &[]), "no triangle with an area");
        assert_refused(binary(b"", &[[[1.0; 3]; 3]]), "no triangle with an area");
        let mut broken = TETRAHEDRON;
        broken[2][1][0] = f32::NAN;
        assert_refused(binary(b"", &broken), "triangle 2 has the corner");
        assert_refused(
            ascii("", &broken).into_bytes(),
            "line 19: a vertex has \"nan\": must be a finite number",
        );
        assert_refused(ascii("", &TETRAHEDRON).replace("0e0", "0,5").into(), "line 4: a vertex has \"0,5\"");
        assert_refused(
            ascii("", &TETRAHEDRON).replace("vertex 0 0", "vertex 0").into(),
            "a vertex has 2 numbers",
        );
        let text = ascii("", &TETRAHEDRON);
        assert_refused(text[..text.len() - 12].into(), "begins 1 solids and ends 0");
        assert_refused(text.replace("endloop", "").into(), "triangle 0 is not as it must be");
        assert_refused(
            text.replace("endloop", "color 1 0 0").into(),
            "line 7: begins with \"color\": must be one of",
        );
        assert_refused(text.replace("outer", &"x ".repeat(1000)).into(), "line 3 is");
        assert_refused(text.encode_utf16().flat_map(u16::to_le_bytes).collect(), "is UTF-16 text");
        assert_refused(b"solid of nothing\nendsolid".to_vec(), "no triangle");
    }

    #[test]
    fn what_is_behind_or_is_not_used_refuses_no_file() {
        let whole = parse(binary(b"", &TETRAHEDRON)).unwrap();
        for (header, behind) in [(&b""[..], 1), (b"solid", 4), (b"solid part", 300)] {
            let (mesh, left) =
                super::parse([binary(header, &TETRAHEDRON), vec![7; behind]].concat()).unwrap();
            assert_eq!((mesh, left), (whole.clone(), behind));
        }
        let text = ascii("", &TETRAHEDRON);
        for text in [
            text.replace("normal 0 0 0", "normal -nan(ind) 1.#QNAN nan"),
            text.replace("\n", "\r\n"),
            text.replace('\n', "\r"),
            format!("\u{feff}{text}"),
        ] {
            assert_eq!(parse(text.into_bytes()).unwrap(), whole);
        }
    }

    #[test]
    fn every_cut_of_a_good_file_is_refused() {
        for good in [binary(b"solid", &TETRAHEDRON), ascii("x", &TETRAHEDRON).into_bytes()] {
            let end = good.trim_ascii_end().len();
            for length in 0..end {
                assert!(parse(good[..length].to_vec()).is_err(), "cut at {length}");
            }
        }
    }

    #[test]
    fn a_folder_is_no_file() {
        let folder = Path::new("truth");
        let error = load(folder, &Sources::from_main(folder)).unwrap_err().to_string();
        assert_eq!(error, "truth: is not a regular file");
    }
}
