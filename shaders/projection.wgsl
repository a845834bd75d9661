// Where boxes of voxels are in a camera's image: what `see_tiles` and the kernels that carve voxel by voxel
// share. Floats say only where to look; what is seen there is decided in integers.
//
// # Theory
// The ideal rays that cross a box go through the pixels that it projects to. Rays of integers deviate from
// them, by less than `deviation`, so the box is grown by that first. Depth and width are bounded one by one,
// which makes the rectangle larger than need be, never smaller.

// Depth in voxels from which on a box is projected.
const NEAREST = 0.01;

// A camera at a placement.
struct Projection {
    origin: vec3<f32>,
    // The sensor's axes in the grid.
    right: vec3<f32>,
    down: vec3<f32>,
    forward: vec3<f32>,
}

// A box as a camera sees it: only rays of pixels from `first` to `last`, both included, visit any of it.
struct PixelRect {
    first: vec2<i32>,
    last: vec2<i32>,
    // The one of them next to its middle.
    centre: vec2<i32>,
    // Whether any pixel is left.
    seen: bool,
    // Whether some of it is so near that pixels say little.
    near: bool,
    // Whether it is so far inside the image, and pixels so close at its depth, that some ray surely visits
    // each voxel.
    dense: bool,
    // If it is one voxel: up to how many pixels beside `centre`, on each axis, all rays surely visit it; -1 if
    // that of `centre` need not.
    beside: i32,
}

fn projection_of(place: GridFrame) -> Projection {
    let x = vec3<f32>(vec3_of(place.axis_q15[0])) / 32768.0;
    let y = vec3<f32>(vec3_of(place.axis_q15[1])) / 32768.0;
    let z = vec3<f32>(vec3_of(place.axis_q15[2])) / 32768.0;
    return Projection(
        vec3<f32>(vec3_of(place.origin_q16)) / 65536.0,
        vec3<f32>(x.x, y.x, z.x),
        vec3<f32>(x.y, y.y, z.y),
        vec3<f32>(x.z, y.z, z.z),
    );
}

// How far a ray of integers may be from its ideal line at a distance, in voxels (src/march/march/deviation.rs).
fn deviation(distance: f32) -> f32 {
    return DEVIATION_PER_VOXEL * distance + DEVIATION_FIXED;
}

// The smallest and largest of p / z over a box, in pixels of one axis of the image.
fn span(p: f32, wide: f32, z_low: f32, z_high: f32, focal: f32, middle: f32) -> vec2<f32> {
    let low = p - wide;
    let high = p + wide;
    return middle + focal * vec2<f32>(
        low / select(z_high, z_low, low < 0.0),
        high / select(z_low, z_high, high < 0.0),
    );
}

// A cube of `edge` voxels from `corner` on, in the grid.
fn pixel_rect(projection: Projection, corner: vec3<i32>, edge: i32) -> PixelRect {
    let half = f32(edge) * 0.5;
    let centre = vec3<f32>(corner) + half - projection.origin;
    let p = vec3<f32>(dot(projection.right, centre), dot(projection.down, centre), dot(projection.forward, centre));
    let one = vec3<f32>(1.0);
    let wide = half * vec3<f32>(dot(abs(projection.right), one), dot(abs(projection.down), one), dot(abs(projection.forward), one))
        + deviation(dot(abs(p), one) + 3.0 * half);
    let z_low = p.z - wide.z;
    let z_high = p.z + wide.z;
    // If a voxel is near, so is a larger cube that holds it, however floats are rounded.
    let near = z_low < table.near + 0.01 * f32(edge - 1);
    let size = vec2<f32>(vec2<u32>(table.image_x, table.image_y));
    let z = max(z_low, NEAREST);
    let u = span(p.x, wide.x, z, max(z_high, z), table.focal_x, size.x * 0.5);
    let v = span(p.y, wide.y, z, max(z_high, z), table.focal_y, size.y * 0.5);
    // Rays pass through the centres of pixels. Some of a pixel for the floats' own rounding; all of the image
    // where the box reaches to the sensor, since it is in all directions from there.
    let slope = size * 0.5 / vec2<f32>(table.focal_x, table.focal_y);
    let touches = z_low < NEAREST && all(abs(p.xy) <= wide.xy + NEAREST * slope);
    let more = 0.52 + size * select(1e-6, 2.0, touches);
    let low = vec2<f32>(u.x, v.x) - more;
    let high = vec2<f32>(u.y, v.y) - 1.0 + more;
    let seen = z_high > 0.0 && all(high >= vec2<f32>()) && all(low <= size - 1.0) && all(ceil(low) <= floor(high));
    let first = clamp(ceil(low), vec2<f32>(), size - 1.0);
    let last = clamp(floor(high), vec2<f32>(), size - 1.0);
    let inside = all(low >= vec2<f32>()) && all(high <= size - 1.0);
    // Half the diagonal of a pixel, at most, at the farthest depth.
    let pixel = z_high / min(table.focal_x, table.focal_y);
    let deviates = deviation(dot(abs(p), one) + 3.0 * half);
    let gap = 0.71 * pixel + deviates;
    // Each pixel beside is a diagonal more.
    let beside = integer(floor(clamp((0.5 - deviates) / (1.42 * pixel) - 0.51, 0.0, 255.0)));
    let middle = size * 0.5 + vec2<f32>(table.focal_x, table.focal_y) * p.xy / max(p.z, NEAREST);
    let visited = !near && gap <= 0.5 && all(middle >= vec2<f32>()) && all(middle < size);
    return PixelRect(
        integer2(first),
        integer2(last),
        integer2(clamp(floor(middle), first, last)),
        seen,
        near,
        !near && inside && gap <= 0.5,
        select(-1, beside, visited),
    );
}

// Whether a pixel's ray visits the voxel so many voxels from the sensor's voxel, were nothing in its way.
fn sees(place: GridFrame, dir: vec2<u32>, offset: vec3<i32>) -> bool {
    let begin = launch(place, dir);
    let towards = all((offset == vec3<i32>()) | (sign(offset) == begin.step));
    return towards && visits(begin.next_q16, begin.period_q16, vec3<u32>(abs(offset)));
}

// Voxel boundaries from the sensor's voxel to the nearest and to the farthest voxel of a cube.
fn away(own: vec3<i32>, corner: vec3<i32>, edge: i32) -> vec2<u32> {
    let low = corner - own;
    let high = low + edge - 1;
    let nearest = max(max(low, -high), vec3<i32>());
    let farthest = max(high, -low);
    return vec2<u32>(u32(nearest.x + nearest.y + nearest.z), u32(farthest.x + farthest.y + farthest.z));
}

// The lowest voxel of a box, counted from the window's corner.
fn box_corner(word: u32) -> vec3<u32> {
    return ((vec3<u32>(word) >> vec3<u32>(0u, BOX_BITS / 3u, 2u * BOX_BITS / 3u)) & vec3<u32>((1u << (BOX_BITS / 3u)) - 1u)) * BOX_EDGE;
}
