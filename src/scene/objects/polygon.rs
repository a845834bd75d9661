//! Cuts a flat polygon into triangles, also where it has dents, so that nothing outside it is covered.

use glam::{DVec2, DVec3};

use perirobot_march::error::Issue;

/// Most corners of one polygon: the time it takes grows with their square.
const MOST_CORNERS: usize = 1024;
/// Most tests of corners, in squares of the number of corners, before a polygon is refused; one designed to
/// take long would need hundreds.
const MOST_LOOKS: usize = 64;

/// The triangles of a polygon, as indices into its corners, turned as it is turned; none if it has fewer than three
/// corners. The corners go round it once.
///
/// # Errors
/// When it has too many corners, or winds about itself too much.
pub fn triangles(corners: &[DVec3]) -> Result<Vec<[usize; 3]>, Issue> {
    match corners.len() {
        0..=2 => return Ok(Vec::new()),
        3 => return Ok(vec![[0, 1, 2]]),
        4..=MOST_CORNERS => {}
        count => {
            return Err(Issue::too_large(format!("a face has {count} corners, more than {MOST_CORNERS}"))
                .with_advice("triangulate the mesh"));
        }
    }
    let flat = flatten(corners);
    let mut left: Vec<usize> = (0..corners.len()).collect();
    let mut triangles = Vec::with_capacity(corners.len() - 2);
    let mut looks = MOST_LOOKS * corners.len() * corners.len();
    while left.len() > 3 {
        // A polygon that crosses itself may have no ear; any corner will do then.
        let ear = (0..left.len()).find(|&place| is_ear(&flat, &left, place, &mut looks)).unwrap_or(1);
        if looks == 0 {
            let count = corners.len();
            return Err(Issue::says(format!("a face of {count} corners winds about itself too much"))
                .with_advice("triangulate the mesh"));
        }
        triangles.push(neighbours(&left, ear));
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]]);
    Ok(triangles)
}

/// The corners seen along the polygon's normal (after Newell), so that they go round counter-clockwise.
fn flatten(corners: &[DVec3]) -> Vec<DVec2> {
    let next = corners.iter().cycle().skip(1);
    let normal: DVec3 = corners.iter().zip(next).map(|(a, b)| (*a - corners[0]).cross(*b - corners[0])).sum();
    let size = normal.abs();
    let largest = (0..3).fold(2, |best, axis| if size[axis] > size[best] { axis } else { best });
    let (u, v) = ((largest + 1) % 3, (largest + 2) % 3);
    let mirror = if normal[largest] < 0.0 { -1.0 } else { 1.0 };
    corners.iter().map(|corner| DVec2::new(mirror * corner[u], corner[v])).collect()
}

/// A corner with the one before and the one after it.
fn neighbours(left: &[usize], place: usize) -> [usize; 3] {
    let count = left.len();
    [left[(place + count - 1) % count], left[place], left[(place + 1) % count]]
}

/// Whether a corner can be cut off: it points outward, and no other corner is in the triangle.
fn is_ear(flat: &[DVec2], left: &[usize], place: usize, looks: &mut usize) -> bool {
    let corner = neighbours(left, place);
    let [a, b, c] = corner.map(|i| flat[i]);
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    let inside = |p: DVec2| side(a, b, p) >= 0.0 && side(b, c, p) >= 0.0 && side(c, a, p) >= 0.0;
    side(a, b, c) > 0.0
        && left.iter().filter(|i| !corner.contains(i)).map(|&i| flat[i]).all(|p| {
            *looks = looks.saturating_sub(1);
            // A corner of the polygon may be visited twice, where a bridge leads to a hole.
            p == a || p == b || p == c || !inside(p)
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[DVec3]) -> DVec3 {
        let cut = triangles(corners).unwrap();
        assert_eq!(cut.len(), corners.len() - 2);
        let area = |t: [usize; 3]| {
            let [a, b, c] = t.map(|i| corners[i]);
            (b - a).cross(c - a) / 2.0
        };
        // Triangles that lie over each other would add up to more than the polygon.
        let lengths: f64 = cut.iter().map(|t| area(*t).length()).sum();
        let whole: DVec3 = cut.iter().map(|t| area(*t)).sum();
        assert!((lengths - whole.length()).abs() < 1e-12, "{cut:?}");
        whole
    }

    #[test]
    fn dents_stay_empty_whatever_the_plane_and_the_first_corner() {
        // An L of area 3: a square of 2 less a corner of 1.
        let shape = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
        for first in 0..6 {
            let turned: Vec<[f64; 2]> = (0..6).map(|i| shape[(first + i) % 6]).collect();
            for (u, v, normal) in [
                (DVec3::X, DVec3::Y, DVec3::Z),
                (DVec3::Y, DVec3::Z, DVec3::X),
                (DVec3::Z, DVec3::X, DVec3::Y),
            ] {
                let mut corners: Vec<DVec3> =
                    turned.iter().map(|p| u * p[0] + v * p[1] + 5.0 * normal).collect();
                assert!((area(&corners) - 3.0 * normal).length() < 1e-12, "{first} {normal}");
                corners.reverse();
                assert!((area(&corners) + 3.0 * normal).length() < 1e-12, "{first} -{normal}");
            }
        }
    }

    #[test]
    fn a_dent_is_not_cut_across() {
        // An arrowhead whose second diagonal runs outside.
        let corners = [[0., 0.], [2., 1.], [0., 2.], [0.5, 1.]].map(|[x, y]| DVec3::new(x, y, 0.0));
        assert!((area(&corners).z - 1.5).abs() < 1e-12);
    }

    #[test]
    fn spirals_and_combs_are_cut() {
        for corners in [50, 512] {
            // A strip that winds inward, seven times with 512 corners on each of its sides.
            let at = |i: usize, width: f64| {
                let radius = 10.0 - i as f64 / 100.0 + width;
                let angle = i as f64 * 0.09;
                radius * DVec3::new(libm::cos(angle), libm::sin(angle), 0.0)
            };
            let inner = (0..corners).rev().map(|i| at(i, 0.0));
            area(&(0..corners).map(|i| at(i, 0.3)).chain(inner).collect::<Vec<_>>());
            let teeth = (0..corners).map(|i| DVec3::new(i as f64, if i % 2 == 0 { 1.0 } else { 9.0 }, 0.0));
            let back = (0..corners).rev().map(|i| DVec3::new(i as f64, 0.0, 0.0));
            area(&teeth.chain(back).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_polygon_that_only_takes_long_is_given_up() {
        // Round the same triangle again and again; the last corner, on its edge, is in the way of every ear.
        let round = [DVec3::ZERO, 3.0 * DVec3::X, 3.0 * DVec3::Y].into_iter().cycle().take(1023);
        let corners: Vec<DVec3> = round.chain([DVec3::X]).collect();
        let what = triangles(&corners).unwrap_err();
        assert_eq!(
            what.to_string(),
            "a face of 1024 corners winds about itself too much: triangulate the mesh"
        );
        assert!(triangles(&corners[924..]).is_ok(), "a small one may");
    }

    #[test]
    fn odd_polygons_end() {
        assert_eq!(triangles(&[DVec3::ZERO; 2]).unwrap().len(), 0);
        assert!(triangles(&[DVec3::ZERO; 2000]).unwrap_err().to_string().contains("2000 corners"));
        assert_eq!(triangles(&[DVec3::ZERO; 9]).unwrap().len(), 7);
        let crossed = [[0., 0.], [1., 1.], [1., 0.], [0., 1.]].map(|[x, y]| DVec3::new(x, y, 0.0));
        assert_eq!(triangles(&crossed).unwrap().len(), 2);
    }
}
