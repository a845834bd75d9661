// The outline of a box in a camera's image: the pixels whose rays may pass through the box, and those whose rays surely do.
//
// # Theory
// As seen on two axes, rays pass the box between those two of its corners that are farthest apart from there: on one side of
// an edge through each. A ray that does so on each pair of axes enters the box. If the sensor is within the box on both
// axes, all rays do.
//
// A ray crosses an edge's corner on the other side by the product of both, which is a linear function of the pixel. For a
// corner c and a place p of the ray on these axes, it is (c × p) / depth of p. A move of c or of p by g on each axis changes it
// by g · (|c.x| + |c.y|) / depth at most, and two more for g if p may be anywhere in a box of one voxel. So
//
// * a ray that passes within g of the box is outside of no edge by more than this margin, and
// * a ray that is inside of every edge by this margin passes through the box less g on all sides.
//
// With g more than what rays of integers deviate, the first may visit a voxel, and the second surely do.

// Three edges of an outline in the image: pixels are inside where ax + by + c is not negative.
struct Edges {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    margin: vec3<f32>,
}

// The outline of a box: an edge for each pair of axes, and the one opposite to it.
struct Outline {
    edges: Edges,
    opposite: Edges,
}

// How the rays of pixels go: that of the pixel in the corner of the image, and what is added from pixel to pixel.
struct PixelRays {
    first: vec3<f32>,
    right: vec3<f32>,
    down: vec3<f32>,
}

// An upper bound on the length of any pixel's ray with a depth of 1.
fn image_reach() -> f32 {
    return 1.0 + f32(table.image_x) / table.focal_x + f32(table.image_y) / table.focal_y;
}

// The rays of pixels as seen by a camera whose axes in the grid are mirrored or left out.
fn pixel_rays(projection: Projection, side: vec3<f32>) -> PixelRays {
    let half = vec2<f32>(vec2<u32>(table.image_x, table.image_y)) * 0.5;
    let right = projection.right * side / table.focal_x;
    let down = projection.down * side / table.focal_y;
    return PixelRays(projection.forward * side + right * (0.5 - half.x) + down * (0.5 - half.y), right, down);
}

// Where rays pass one corner of a box on the same side, as seen on each axis and the next: where the corner is on both; on the
// other side for their negatives.
fn edges_of(on: vec3<f32>, on_next: vec3<f32>, rays: PixelRays, sign: f32, by_depth: f32) -> Edges {
    let size = abs(on) + abs(on_next);
    return Edges(
        sign * (on * rays.right.yzx - on_next * rays.right),
        sign * (on * rays.down.yzx - on_next * rays.down),
        sign * (on * rays.first.yzx - on_next * rays.first),
        // The first is more than floats are off by.
        4e-6 * image_reach() * size + by_depth * (size + 2.0),
    );
}

// The outline of the box between two corners, relative to the sensor. `by_depth` is the margin around the box, divided by the
// least depth of the box.
fn outline_of(projection: Projection, low: vec3<f32>, high: vec3<f32>, by_depth: f32) -> Outline {
    // As if the box were not behind the sensor on any axis.
    let behind = high < vec3<f32>();
    let near = select(low, -high, behind);
    let far = select(high, -low, behind);
    let side = select(vec3<f32>(1.0), vec3<f32>(-1.0), behind);
    let rays = pixel_rays(projection, side);
    let within = near <= vec3<f32>();
    let all_pass = within & within.yzx;
    let one = select(select(far, near, within.yzx), vec3<f32>(), all_pass);
    let one_next = select(near.yzx, vec3<f32>(), all_pass);
    let other = select(near, vec3<f32>(), all_pass);
    let other_next = select(select(far.yzx, near.yzx, within), vec3<f32>(), all_pass);
    return Outline(
        edges_of(one, one_next, rays, 1.0, by_depth),
        edges_of(other, other_next, rays, -1.0, by_depth),
    );
}

// Rows from a pixel on, as many as two tiles have: a bit each.
const ROWS = 2u * TILE;

// Pixels of columns of so many rows: those whose rays may visit a voxel, and those whose rays surely do.
struct Columns {
    outer: u32,
    inner: u32,
}

// Rows of a column inside some edges: from the first to the last of those that may be, then of those that surely are.
fn inside_edges(edges: Edges, pixel: vec2<f32>, rows: vec4<f32>) -> vec4<f32> {
    let at = edges.a * pixel.x + edges.b * pixel.y + edges.c;
    // Along the column: all of it is on one side.
    let level = edges.b == vec3<f32>();
    let per_row = 1.0 / select(edges.b, vec3<f32>(1.0), level);
    let outer = -(at + edges.margin) * per_row;
    let inner = (edges.margin - at) * per_row;
    let up = edges.b > vec3<f32>();
    let down = edges.b < vec3<f32>();
    let after = vec3<f32>(f32(ROWS));
    let outer_firsts = select(select(rows.xxx, outer, up), after, level & (at < -edges.margin));
    let inner_firsts = select(select(rows.zzz, inner, up), after, level & (at < edges.margin));
    let outer_lasts = select(rows.yyy, outer, down);
    let inner_lasts = select(rows.www, inner, down);
    return vec4<f32>(
        max(max(rows.x, outer_firsts.x), max(outer_firsts.y, outer_firsts.z)),
        min(min(rows.y, outer_lasts.x), min(outer_lasts.y, outer_lasts.z)),
        max(max(rows.z, inner_firsts.x), max(inner_firsts.y, inner_firsts.z)),
        min(min(rows.w, inner_lasts.x), min(inner_lasts.y, inner_lasts.z)),
    );
}

// Rows from a first to a last, both included.
fn rows_between(first: f32, last: f32) -> u32 {
    let begin = u32(integer(clamp(ceil(first), 0.0, f32(ROWS))));
    let end = u32(integer(clamp(floor(last), -1.0, f32(ROWS - 1u))) + 1);
    return ((1u << end) - 1u) & ~((1u << begin) - 1u);
}

// The pixels of a column from a pixel on, as far as they are in a rectangle.
fn column_inside(pixel: vec2<i32>, rect: PixelRect, outline: Outline) -> Columns {
    let begin = f32(rect.first.y - pixel.y);
    let end = f32(rect.last.y - pixel.y);
    let all = vec4<f32>(begin, end, begin, end);
    let rows = inside_edges(outline.opposite, vec2<f32>(pixel), inside_edges(outline.edges, vec2<f32>(pixel), all));
    // Some of a pixel for rounding.
    let outer = rows_between(max(rows.x - 0.01, begin), min(rows.y + 0.01, end));
    let is_in_rect = pixel.x >= rect.first.x && pixel.x <= rect.last.x;
    let wanted = select(0u, outer, is_in_rect);
    return Columns(wanted, wanted & rows_between(rows.z + 0.01, rows.w - 0.01));
}
