//! Makes the simple bodies that scenes are built of, about the origin, z up, vertices on the true surface.
//!
//! All trigonometry goes through `libm`, so two machines make identical vertices. A closed body shares its
//! vertices and its triangles look outward. Sizes are taken as they come: callers check that they are
//! positive.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DMat3, DQuat, DVec3};

use super::Mesh;

/// Fewest segments of a full turn: a coarse body still looks like itself.
const MIN_SEGMENTS: u32 = 8;
/// Most segments of a full turn, whatever `sag_m` asks: a metre's radius is then within 0.04 mm.
const MAX_SEGMENTS: u32 = 512;

/// A box with edges of `size` metres.
pub fn cuboid(size: DVec3) -> Mesh {
    let vertices = (0..8).map(|i| corner(size, i)).collect();
    let quads = FACES.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Mesh { vertices, triangles: quads.into_iter().flatten().collect() }
}

/// The six inner walls of a room of `size` metres, facing inward. It is closed, but its inside is the
/// cell and no body.
pub(crate) fn room(size: DVec3) -> Mesh {
    let mut mesh = Mesh::default();
    for [a, b, c, d] in FACES {
        mesh.append(&Mesh {
            vertices: [a, b, c, d].map(|i| corner(size, i)).to_vec(),
            triangles: vec![[0, 2, 1], [0, 3, 2]],
        });
    }
    mesh
}

/// A rectangle in the xy plane, facing up.
pub(crate) fn plane(size: [f64; 2]) -> Mesh {
    let size = DVec3::new(size[0], size[1], 0.0);
    Mesh { vertices: [0, 1, 3, 2].map(|i| corner(size, i)).to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]] }
}

/// A sphere; `sag_m` is the largest distance between it and the triangles.
pub(crate) fn sphere(radius: f64, sag_m: f64) -> Mesh {
    ellipsoid(DVec3::splat(radius), sag_m)
}

/// An ellipsoid with these half-axes. It is a stretched unit sphere, and the stretch lengthens no distance by
/// more than the largest half-axis, which is what keeps within `sag_m`.
pub(crate) fn ellipsoid(radii: DVec3, sag_m: f64) -> Mesh {
    let around = segments(1.0, sag_m / radii.max_element() / 2.0);
    let mut mesh = revolve(&arc(1.0, around, -FRAC_PI_2, FRAC_PI_2, 0.0), around);
    for vertex in &mut mesh.vertices {
        *vertex *= radii;
    }
    mesh
}

/// A cylinder about the z axis with flat ends, from −height/2 to height/2.
pub fn cylinder(radius: f64, height: f64, sag_m: f64) -> Mesh {
    let (low, high) = (-height / 2.0, height / 2.0);
    let profile = [[0.0, low], [radius, low], [radius, high], [0.0, high]];
    revolve(&profile, segments(radius, sag_m))
}

/// A cylinder about the z axis with round ends; `length` is the distance between the centres of its caps.
pub(crate) fn capsule(radius: f64, length: f64, sag_m: f64) -> Mesh {
    let around = segments(radius, sag_m / 2.0);
    let mut profile = arc(radius, around, -FRAC_PI_2, 0.0, -length / 2.0);
    let upper = arc(radius, around, 0.0, FRAC_PI_2, length / 2.0);
    // Without a length both caps share their equator; a second ring there would have no area.
    profile.extend(upper.iter().skip(usize::from(length == 0.0)));
    revolve(&profile, around)
}

/// A capsule whose caps are centred at `a` and `b`; a sphere when they coincide.
pub(crate) fn capsule_between(a: DVec3, b: DVec3, radius: f64, sag_m: f64) -> Mesh {
    let length = (b - a).length();
    let turn = match (b - a).try_normalize() {
        Some(z) => {
            let (x, y) = z.any_orthonormal_pair();
            DQuat::from_mat3(&DMat3::from_cols(x, y, z))
        }
        None => DQuat::IDENTITY,
    };
    capsule(radius, length, sag_m).transform(turn, (a + b) / 2.0)
}

/// Corners of each face of a box, counter-clockwise seen from outside; see [`corner`].
const FACES: [[u32; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// Bit 0 of a corner's number is its side on x, bit 1 on y, bit 2 on z.
fn corner(size: DVec3, number: u32) -> DVec3 {
    let side = |axis: u32| f64::from(number >> axis & 1) - 0.5;
    size * DVec3::new(side(0), side(1), side(2))
}

/// Segments of a full turn, a multiple of four, such that a chord is within `sag` of its circle.
fn segments(radius: f64, sag: f64) -> u32 {
    let half_angle = libm::acos((1.0 - sag / radius).clamp(-1.0, 1.0));
    let needed = libm::ceil(PI / half_angle);
    // NaN and infinity (no sag, no radius) end up at the bounds.
    (needed.clamp(f64::from(MIN_SEGMENTS), f64::from(MAX_SEGMENTS)) as u32)
        .clamp(MIN_SEGMENTS, MAX_SEGMENTS)
        .next_multiple_of(4)
}

/// Points (distance from the axis, z) of an arc between two latitudes, in steps of a full turn / `around`. A
/// triangle of the revolved arc lies within 1 − (1 − h)² ≤ 2h of the unit sphere when both steps' chords do
/// within h, hence the halved sag above.
fn arc(radius: f64, around: u32, from: f64, to: f64, z: f64) -> Vec<[f64; 2]> {
    let steps = ((to - from) / TAU * f64::from(around) + 0.5) as u32;
    let point = |step: u32| {
        let latitude = from + (to - from) * f64::from(step) / f64::from(steps);
        [radius * libm::cos(latitude), z + radius * libm::sin(latitude)]
    };
    (0..=steps).map(point).collect()
}

/// Turns a profile of (distance from the axis, z), from bottom to top, about the z axis. Its first and last
/// points are taken to lie on the axis (at a pole the cosine is 6e-17), the others do not.
fn revolve(profile: &[[f64; 2]], around: u32) -> Mesh {
    let rings = profile.len() as u32 - 2;
    let mut mesh = Mesh::default();
    for ring in 1..=rings {
        let [distance, z] = profile[ring as usize];
        for step in 0..around {
            let angle = TAU * f64::from(step) / f64::from(around);
            mesh.vertices.push(DVec3::new(distance * libm::cos(angle), distance * libm::sin(angle), z));
        }
    }
    let (bottom, top) = (rings * around, rings * around + 1);
    for end in [profile[0], profile[profile.len() - 1]] {
        mesh.vertices.push(DVec3::new(0.0, 0.0, end[1]));
    }
    for step in 0..around {
        let next = (step + 1) % around;
        mesh.triangles.push([bottom, next, step]);
        for ring in 0..rings - 1 {
            let (low, high) = (ring * around, (ring + 1) * around);
            mesh.triangles.push([low + step, low + next, high + next]);
            mesh.triangles.push([low + step, high + next, high + step]);
        }
        let last = (rings - 1) * around;
        mesh.triangles.push([top, last + step, last + next]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::mesh::tests::{assert_closed, volume};

    const SAG: f64 = 0.002;

    /// Checks that the body is closed, looks outward, spans ±`half`, and that points spread over each
    /// triangle are no more than `sag` inside the surface, of which `distance` gives a point's distance
    /// (negative inside).
    #[track_caller]
    fn check(mesh: &Mesh, half: DVec3, sag: f64, distance: impl Fn(DVec3) -> f64) {
        assert_closed(mesh);
        assert!(volume(mesh) > 0.0, "looks inward");
        let (low, high) = mesh.bounds().unwrap();
        assert!((high - half).abs().max_element() < 1e-12, "{high} is not {half}");
        assert!((low + half).abs().max_element() < 1e-12, "{low} is not -{half}");
        for vertex in &mesh.vertices {
            assert!(distance(*vertex).abs() < 1e-12, "{vertex} is off the surface");
        }
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
            assert!((b - a).cross(c - a).length() > 1e-9, "a triangle without area");
            for i in 0..=8 {
                for j in 0..=8 - i {
                    let (u, v) = (f64::from(i) / 8.0, f64::from(j) / 8.0);
                    let point = a + (b - a) * u + (c - a) * v;
                    let inside = -distance(point);
                    assert!(inside < sag + 1e-12, "{point} is {inside} inside, not {sag}");
                }
            }
        }
    }

    fn box_distance(half: DVec3) -> impl Fn(DVec3) -> f64 {
        move |p| (p.abs() - half).max_element()
    }

    #[test]
    fn closed_bodies_stay_within_their_sag() {
        let half = DVec3::new(0.5, 1.0, 1.5);
        check(&cuboid(half * 2.0), half, SAG, box_distance(half));
        for radius in [0.02, 0.1, 1.0] {
            check(&sphere(radius, SAG), DVec3::splat(radius), SAG, |p| p.length() - radius);
            let half = DVec3::new(radius, radius, 0.3);
            check(&cylinder(radius, 0.6, SAG), half, SAG, |p| {
                (p.truncate().length() - radius).max(p.z.abs() - 0.3)
            });
            for length in [0.0, 0.5] {
                let half = DVec3::new(radius, radius, radius + length / 2.0);
                check(&capsule(radius, length, SAG), half, SAG, |p| {
                    let on_axis = p.z.clamp(-length / 2.0, length / 2.0);
                    (p - DVec3::Z * on_axis).length() - radius
                });
            }
        }
        let radii = DVec3::new(0.08, 0.1, 0.12);
        // (|p/r| − 1) · the smallest half-axis is at most the true distance, so this asks more than sag
        // promises.
        check(&ellipsoid(radii, SAG), radii, SAG, |p| ((p / radii).length() - 1.0) * 0.08);
    }

    #[test]
    fn a_smaller_sag_makes_more_triangles_up_to_a_bound() {
        assert!(sphere(0.1, 0.001).triangles.len() > sphere(0.1, 0.01).triangles.len());
        for sag in [0.0, -1.0, f64::NAN, 1e-300] {
            assert!(cylinder(1.0, 1.0, sag).triangles.len() <= 4 * 512, "sag {sag}");
        }
        assert_eq!(cylinder(1.0, 1.0, f64::INFINITY).triangles.len(), 4 * 8);
    }

    #[test]
    fn capsules_reach_from_end_to_end() {
        let (a, b) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.5, 1.0, 2.0));
        let mesh = capsule_between(a, b, 0.1, SAG);
        assert_closed(&mesh);
        assert!(volume(&mesh.clone().transform(DQuat::IDENTITY, -a)) > 0.0);
        for vertex in &mesh.vertices {
            let along = (*vertex - a).dot(b - a) / (b - a).length_squared();
            let nearest = a + (b - a) * along.clamp(0.0, 1.0);
            assert!(((*vertex - nearest).length() - 0.1).abs() < 1e-12, "{vertex}");
        }
        assert_closed(&capsule_between(a, a, 0.1, SAG));
    }

    #[test]
    fn walls_and_planes_are_open() {
        let walls = room(DVec3::new(4.0, 5.0, 3.0));
        assert_eq!((walls.vertices.len(), walls.triangles.len()), (24, 12));
        assert!((volume(&walls) + 60.0).abs() < 1e-9, "walls must look inward");
        assert_eq!(walls.bounds().unwrap().1, DVec3::new(2.0, 2.5, 1.5));
        let floor = plane([2.0, 1.0]);
        let [a, b, c] = floor.triangles[0].map(|i| floor.vertices[i as usize]);
        assert_eq!((b - a).cross(c - a), DVec3::new(0.0, 0.0, 2.0));
        assert_eq!(floor.bounds().unwrap().0, DVec3::new(-1.0, -0.5, 0.0));
        assert_eq!(floor.triangles.len(), 2);
    }
}
