//! Reads STL files, binary and ASCII, in the file's own numbers: STL has no unit, so the caller scales. Equal
//! corners become one vertex; normals and colours are ignored.

use std::io::Cursor;
use std::path::Path;

use glam::DVec3;

use super::Mesh;
use super::mesh::Welder;
use crate::Result;
use crate::error::Issue;
use crate::source::Sources;

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
/// When the file cannot be read, its length is not what its triangle count needs, a number is not finite, or
/// there is no triangle with an area.
pub fn load(path: &Path, sources: &Sources) -> Result<Mesh> {
    let bytes = sources.bytes(path)?;
    parse(bytes).map_err(|issue| issue.at(path).into())
}

fn parse(bytes: Vec<u8>) -> Result<Mesh, Issue> {
    let prepared = if declared_length(&bytes) == Some(bytes.len() as u64) {
        blank_header(bytes)
    } else if starts_with_word(&bytes, b"solid") {
        joined_solids(&bytes)?
    } else {
        return Err(wrong_length(&bytes));
    };
    let mut reader = Cursor::new(prepared);
    let triangles = stl_io::create_stl_reader(&mut reader).map_err(|e| Issue::damaged(e.to_string()))?;
    let mut welder = Welder::default();
    for (number, triangle) in triangles.enumerate() {
        let corners = triangle
            .map_err(|e| Issue::damaged(e.to_string()).at(format!("triangle {number}")))?
            .vertices
            .map(|v| DVec3::from_array(v.0.map(f64::from)));
        if let Some(corner) = corners.iter().find(|c| !c.is_finite()) {
            return Err(
                Issue::says(format!("triangle {number} has the corner {corner}")).wanted("must be finite")
            );
        }
        welder.triangle(corners);
    }
    let mesh = welder.finish();
    if mesh.triangles.is_empty() {
        return Err(Issue::says("has no triangle with an area").wanted("export a surface"));
    }
    Ok(mesh)
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

/// Some exporters begin a binary header with "solid", which the parser would take for ASCII.
fn blank_header(mut bytes: Vec<u8>) -> Vec<u8> {
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
fn joined_solids(bytes: &[u8]) -> Result<Vec<u8>, Issue> {
    let mut joined = b"solid \n".to_vec();
    let (mut opened, mut closed) = (0usize, 0usize);
    for (index, line) in bytes.split(|byte| matches!(byte, b'\n' | b'\r')).enumerate() {
        if starts_with_word(line, b"solid") {
            opened += 1;
        } else if starts_with_word(line, b"endsolid") {
            closed += 1;
        } else if line.len() > LONGEST_LINE {
            return Err(Issue::too_large(format!("line {} is {} bytes long", index + 1, line.len()))
                .wanted(format!("at most {LONGEST_LINE} are read")));
        } else {
            joined.extend(line.iter().map(u8::to_ascii_lowercase));
            joined.push(b'\n');
        }
    }
    if opened != closed {
        return Err(Issue::damaged(format!(
            "begins {opened} solids and ends {closed}: it is truncated, or a damaged binary file"
        )));
    }
    joined.extend(b"endsolid\n");
    Ok(joined)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mesh::tests::{assert_closed, volume};

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
    fn refused(bytes: Vec<u8>, expected: &str) {
        let what = parse(bytes).expect_err(expected);
        assert!(what.to_string().contains(expected), "{what:?} lacks {expected:?}");
    }

    #[test]
    fn what_is_wrong_is_named() {
        let good = binary(b"", &TETRAHEDRON);
        refused(Vec::new(), "too short");
        refused(good[..good.len() - 1].to_vec(), "declares 4 triangles");
        refused([good.clone(), vec![0]].concat(), "has 285 bytes");
        let mut lying = good.clone();
        lying[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        refused(lying, "declares 4294967295 triangles");
        refused(binary(b"", &[]), "no triangle with an area");
        refused(binary(b"", &[[[1.0; 3]; 3]]), "no triangle with an area");
        let mut broken = TETRAHEDRON;
        broken[2][1][0] = f32::NAN;
        refused(binary(b"", &broken), "triangle 2 has the corner");
        refused(ascii("", &broken).into_bytes(), "triangle 2: ");
        let text = ascii("", &TETRAHEDRON);
        refused(text[..text.len() - 12].into(), "begins 1 solids and ends 0");
        refused(text.replace("endloop", "").into(), "triangle 0: expected");
        refused(text.replace("outer", &"x ".repeat(1000)).into(), "line 3 is");
        refused(b"solid of nothing\nendsolid".to_vec(), "no triangle");
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
        let folder = Path::new("src");
        let error = load(folder, &Sources::beside(folder)).unwrap_err().to_string();
        assert_eq!(error, "src: is not a regular file");
    }
}
