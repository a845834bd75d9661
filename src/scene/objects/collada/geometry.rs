//! The triangles of one COLLADA geometry, in its own frame and unit.

use glam::DVec3;
use roxmltree::Node;

use super::{Corners, Library, child, children};
use crate::objects::polygon;
use perirobot_march::error::Issue;

/// Calls `triangle` for every triangle of a geometry's mesh.
pub(super) fn read(
    library: &Library,
    geometry: Node,
    mut triangle: impl FnMut(Corners) -> Result<(), Issue>,
) -> Result<(), Issue> {
    // Splines are curves, which have no surface.
    if child(geometry, "spline").is_some() {
        return Ok(());
    }
    let mesh = child(geometry, "mesh").ok_or_else(|| {
        library.with_line(geometry, Issue::says("has no <mesh>").with_advice("export the surfaces as meshes"))
    })?;
    for primitive in mesh.children().filter(Node::is_element) {
        let tag = primitive.tag_name().name();
        if !["triangles", "polylist", "polygons", "tristrips", "trifans"].contains(&tag) {
            continue;
        }
        let Some(layout) = IndexLayout::new(library, primitive)? else { continue };
        for face in faces(library, primitive, tag, &layout)? {
            let corners = face.into_iter().map(|place| layout.position(place)).collect::<Result<Vec<_>, _>>();
            corners
                .and_then(|corners| {
                    polygon::triangles(&corners)?
                        .into_iter()
                        .try_for_each(|t| triangle(t.map(|i| corners[i])))
                })
                .map_err(|what| library.with_line(primitive, what))?;
        }
    }
    Ok(())
}

/// The faces of a primitive as places of positions.
fn faces(
    library: &Library,
    primitive: Node,
    tag: &str,
    layout: &IndexLayout,
) -> Result<Vec<Vec<usize>>, Issue> {
    let lists = children(primitive, "p").map(|list| layout.places(library, list));
    let lists: Vec<Vec<usize>> = lists.collect::<Result<_, _>>()?;
    let wrong = |issue: Issue| library.with_line(primitive, issue);
    Ok(match tag {
        "triangles" => {
            let places = lists.concat();
            if places.len() % 3 != 0 {
                return Err(wrong(
                    Issue::says(format!("has {} corners", places.len()))
                        .with_advice("triangles need a multiple of 3"),
                ));
            }
            places.chunks(3).map(<[usize]>::to_vec).collect()
        }
        "polylist" => {
            let sizes = child(primitive, "vcount").map(|vcount| library.whole_numbers(vcount));
            let places = lists.concat();
            let mut rest = places.as_slice();
            let mut faces = Vec::new();
            for size in sizes.transpose()?.unwrap_or_default() {
                let (face, more) = rest.split_at_checked(size).ok_or_else(|| {
                    wrong(Issue::says(format!(
                        "<vcount> asks for more than the {} corners of its <p>",
                        places.len()
                    )))
                })?;
                faces.push(face.to_vec());
                rest = more;
            }
            if !rest.is_empty() {
                return Err(wrong(Issue::says(format!(
                    "<vcount> leaves {} corners of its <p> over",
                    rest.len()
                ))));
            }
            faces
        }
        "polygons" => {
            if child(primitive, "ph").is_some() {
                return Err(wrong(
                    Issue::says("has a polygon with a hole (<ph>)").with_advice("triangulate the mesh"),
                ));
            }
            lists
        }
        "tristrips" => lists.iter().flat_map(|strip| strip_faces(strip)).collect(),
        _ => lists.iter().flat_map(|fan| fan_faces(fan)).collect(),
    })
}

/// Every second triangle of a strip runs the other way round.
fn strip_faces(strip: &[usize]) -> Vec<Vec<usize>> {
    let turned = |(i, t): (usize, &[usize])| if i % 2 == 0 { t.to_vec() } else { vec![t[1], t[0], t[2]] };
    strip.windows(3).enumerate().map(turned).collect()
}

fn fan_faces(fan: &[usize]) -> Vec<Vec<usize>> {
    fan.windows(2).skip(1).map(|pair| vec![fan[0], pair[0], pair[1]]).collect()
}

/// How a primitive's indices lead to positions.
struct IndexLayout {
    /// Indices for each corner.
    stride: usize,
    /// Which of them is the position's.
    offset: usize,
    positions: Vec<DVec3>,
}

impl IndexLayout {
    /// Nothing for a primitive without indices.
    fn new(library: &Library, primitive: Node) -> Result<Option<IndexLayout>, Issue> {
        if child(primitive, "p").is_none() {
            return Ok(None);
        }
        let mut stride = 0;
        let mut vertices = None;
        for input in children(primitive, "input") {
            let offset = library.attribute(input, "offset")?.unwrap_or(0);
            stride = stride.max(offset.saturating_add(1));
            if input.attribute("semantic") == Some("VERTEX") {
                vertices = Some((offset, library.follow(input, "source", "vertices")?));
            }
        }
        let (offset, vertices) = vertices
            .ok_or_else(|| library.with_line(primitive, Issue::says("has no <input semantic=\"VERTEX\">")))?;
        let position = children(vertices, "input").find(|i| i.attribute("semantic") == Some("POSITION"));
        let position = position.ok_or_else(|| {
            library.with_line(vertices, Issue::says("has no <input semantic=\"POSITION\">"))
        })?;
        let positions = positions(library, library.follow(position, "source", "source")?)?;
        Ok(Some(IndexLayout { stride, offset, positions }))
    }

    /// Places of positions in a list of indices.
    fn places(&self, library: &Library, list: Node) -> Result<Vec<usize>, Issue> {
        let indices = library.whole_numbers(list)?;
        if indices.len() % self.stride != 0 {
            let what = Issue::says(format!("has {} indices", indices.len()));
            return Err(
                library.with_line(list, what.with_advice(format!("must be a multiple of {}", self.stride)))
            );
        }
        Ok(indices.chunks_exact(self.stride).map(|corner| corner[self.offset]).collect())
    }

    fn position(&self, place: usize) -> Result<DVec3, Issue> {
        let position = self.positions.get(place).copied();
        position.ok_or_else(|| {
            Issue::says(format!("position {place}"))
                .with_advice(format!("there are {}", self.positions.len()))
        })
    }
}

fn positions(library: &Library, source: Node) -> Result<Vec<DVec3>, Issue> {
    let accessor = child(source, "technique_common").and_then(|common| child(common, "accessor"));
    let accessor = accessor.ok_or_else(|| library.with_line(source, Issue::says("has no <accessor>")))?;
    let array = library.follow(accessor, "source", "float_array")?;
    let numbers = library.numbers(array)?;
    // More numbers than are declared are not referred to.
    if library.attribute(array, "count")?.is_some_and(|count| count > numbers.len()) {
        let what = format!("its count is more than the {} numbers there: the file is damaged", numbers.len());
        return Err(library.with_line(array, Issue::damaged(what)));
    }
    let stride = library.attribute(accessor, "stride")?.unwrap_or(1);
    let offset = library.attribute(accessor, "offset")?.unwrap_or(0);
    let count = library.attribute(accessor, "count")?.unwrap_or(0);
    let end = count.checked_mul(stride).and_then(|length| length.checked_add(offset));
    if stride < 3 || end.is_none_or(|end| end > numbers.len()) {
        let what = format!("count = {count}, stride = {stride}, offset = {offset}");
        let rule = format!("positions need a stride of 3 or more, and there are {} numbers", numbers.len());
        return Err(library.with_line(accessor, Issue::says(what).with_advice(rule)));
    }
    Ok((0..count).map(|i| DVec3::from_slice(&numbers[offset + i * stride..])).collect())
}
