// Tiles of a camera's pixels.

// Tiles of an image, across and down.
fn tiles_of_image() -> vec2<u32> {
    return (vec2<u32>(table.image_x, table.image_y) + TILE - 1u) / TILE;
}
