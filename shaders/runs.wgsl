// Which rays an invocation of `cast` takes: columns of tiles that follow each other, or where rays do not
// go by tiles some that lie apart. The kernel says with `is_wanted` which tiles it takes.
//
// # Practice
// A tile that is passed over costs a software adapter as much as a row of its rays if each invocation takes one tile. So
// an invocation goes through several (`part.tiles`), and one that is passed over costs a look.

// Tiles that this invocation has taken or passed over.
var<private> tiles_done: u32;

// What `cast_tiles` knows of the tile taken last, as `is_wanted` found it.
var<private> of_tile: u32 = SENT;

// Rays of an invocation: so many of a table's, from `first` on.
struct Run {
    first: u32,
    stride: u32,
    count: u32,
    // Where the end of the first is in its placement, if rays go by tiles.
    place: u32,
}

// Rays that lie apart: neighbours take neighbouring rays.
fn run_of(group: u32, local: u32) -> Run {
    let first = min(part.first + group * WORKGROUP * TILE + local / TILE * TILE * TILE + local % TILE, part.end);
    return Run(first, TILE, min((part.end - first + TILE - 1u) / TILE, TILE), 0u);
}

// An invocation's column of a tile: nothing outside the image.
fn column_of(tile: u32, local: u32) -> Run {
    let across = tiles_of_image().x;
    let column = vec2<u32>(local % TILE, 0u);
    let pixel = vec2<u32>(tile % across, tile / across) * TILE + column;
    let rows = min(max(table.image_y, pixel.y) - pixel.y, TILE);
    let place = tile * (TILE * TILE) + place_in_tile(column);
    return Run(pixel.y * table.image_x + pixel.x, table.image_x, select(0u, rows, pixel.x < table.image_x), place);
}

// The word of `ends` of a ray of a run.
fn word_of_turn(row: u32, run: Run, turn: u32) -> u32 {
    let in_tile = run.place + place_in_tile(vec2<u32>(0u, turn));
    return row * table.ends_stride + select(run.first + turn * run.stride, in_tile, part.tiles != 0u);
}

// The next rays of an invocation, or none. There are more as long as `tiles_done` is below `part.tiles`.
fn next_run(row: u32, group: u32, local: u32) -> Run {
    let first_tile = part.first / (TILE * TILE) + (group * (WORKGROUP / TILE) + local / TILE) * part.tiles;
    var run = run_of(group, local);
    loop {
        if part.tiles != 0u {
            let tile = first_tile + tiles_done;
            run = column_of(tile, local);
            if run.count > 0u {
                run.count = select(0u, run.count, is_wanted(row, tile));
            }
        }
        tiles_done += 1u;
        if run.count > 0u || tiles_done >= part.tiles {
            break;
        }
    }
    loop_ended(opaque(run.count) > 0u || opaque(tiles_done) >= part.tiles);
    return run;
}
