// Tiles of a camera's pixels, and which rays an invocation takes: columns of tiles that follow each other, or where rays
// do not go by tiles some that lie apart.
//
// # Practice
// Tiles that are done already cost a software adapter as much as one row of their rays, if an invocation takes a tile:
// so it takes some of them (`part.tiles`), and what it skips costs a look.

// Tiles of an image, across and down.
fn tiles_of_image() -> vec2<u32> {
    return (vec2<u32>(table.image_x, table.image_y) + TILE - 1u) / TILE;
}

// Rays of an invocation: so many of a table's, from `first` on.
struct Run {
    first: u32,
    stride: u32,
    count: u32,
}

// The rays that an invocation takes: neighbours take neighbouring rays.
fn run_of(group: u32, local: u32) -> Run {
    let first = min(part.first + group * WORKGROUP * TILE + local / TILE * TILE * TILE + local % TILE, part.end);
    return Run(first, TILE, min((part.end - first + TILE - 1u) / TILE, TILE));
}

// One after the other of the tiles of which an invocation takes a column.
fn tile_of(group: u32, local: u32, number: u32) -> u32 {
    return part.first / (TILE * TILE) + (group * (WORKGROUP / TILE) + local / TILE) * part.tiles + number;
}

// Its column of a tile: nothing outside the image.
fn column_of(tile: u32, local: u32) -> Run {
    let across = tiles_of_image().x;
    let pixel = vec2<u32>(tile % across, tile / across) * TILE + vec2<u32>(local % TILE, 0u);
    let rows = min(max(table.image_y, pixel.y) - pixel.y, TILE);
    return Run(pixel.y * table.image_x + pixel.x, table.image_x, select(0u, rows, pixel.x < table.image_x));
}
