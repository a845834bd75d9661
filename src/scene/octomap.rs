//! Reads and writes OctoMap's binary trees (`.bt`, as OctoMap 1.9's `writeBinary` makes them), so that maps
//! are read and written without loss. Keys stay integers.

use std::path::Path;

use crate::Result;
use crate::error::Issue;
use crate::source::Sources;

/// Levels below the root: a key has 16 bits on each axis.
const DEPTH: u32 = 16;
/// OctoMap's key of the voxel that begins at the world's origin.
const KEY_ORIGIN: i32 = 1 << (DEPTH - 1);
/// A pruned leaf of a few bits may stand for millions of voxels; past this many (400 MB of keys) a map is
/// refused.
const MAX_OCCUPIED: u64 = 1 << 25;

const FIRST_LINE: &str = "# Octomap OcTree binary file";
const SECOND_LINE: &str = "# (feel free to add / change comments, but leave the first line as it is!)";

// What two bits say of a child, low bit first in the format's description.
const UNKNOWN: u16 = 0b00;
const FREE: u16 = 0b01;
const OCCUPIED: u16 = 0b10;
const INNER: u16 = 0b11;

/// The world keys that an OctoMap can hold.
pub const KEYS: std::ops::Range<i32> = -KEY_ORIGIN..KEY_ORIGIN;

/// The occupied voxels of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct OctoMap {
    /// Edge of a voxel in metres.
    pub resolution_m: f64,
    /// World keys floor(x / resolution) of the occupied voxels, each once, in the tree's order.
    pub occupied: Vec<[i32; 3]>,
}

/// Reads a `.bt` file; pruned leaves are expanded to voxels.
///
/// # Errors
/// When the file cannot be read, is not a binary OcTree, is damaged, or has more occupied voxels than are read.
pub fn read(path: &Path, sources: &Sources) -> Result<OctoMap> {
    let bytes = sources.bytes(path)?;
    parse(&bytes).map_err(|issue| issue.at(path).into())
}

fn parse(bytes: &[u8]) -> Result<OctoMap, Issue> {
    let header = TreeHeader::parse(bytes)?;
    let data = &bytes[header.length..];

    // The first pass only measures, so that nothing is allocated for a map that is too large.
    let mut voxels = 0u64;
    let nodes = visit_leaves(data, &mut |leaf| {
        if leaf.occupied {
            // At most 2^45 a leaf: saturating keeps a lying tree from wrapping.
            voxels = voxels.saturating_add((leaf.edge as u64).pow(3));
        }
    })?;
    if nodes != header.size {
        return Err(Issue::damaged(format!(
            "header says size {} and the tree has {nodes} nodes: the file is damaged",
            header.size
        )));
    }
    if voxels == 0 {
        return Err(Issue::says("has no occupied voxel"));
    }
    if voxels > MAX_OCCUPIED {
        return Err(Issue::too_large(format!("has {voxels} occupied voxels"))
            .wanted(format!("at most {MAX_OCCUPIED} are read, so use a coarser or smaller map")));
    }

    let mut occupied = Vec::with_capacity(voxels as usize);
    visit_leaves(data, &mut |leaf| {
        if leaf.occupied {
            let [x, y, z] = leaf.key;
            for z in z..z + leaf.edge {
                for y in y..y + leaf.edge {
                    occupied.extend((x..x + leaf.edge).map(|x| [x, y, z]));
                }
            }
        }
    })?;
    Ok(OctoMap { resolution_m: header.resolution_m, occupied })
}

struct TreeHeader {
    size: u64,
    resolution_m: f64,
    /// Bytes up to the first node.
    length: usize,
}

impl TreeHeader {
    fn parse(bytes: &[u8]) -> Result<TreeHeader, Issue> {
        let (mut id, mut size, mut resolution_m) = (false, None, None);
        let mut at = 0;
        for number in 1.. {
            let Some(length) = bytes[at..].iter().position(|byte| *byte == b'\n') else {
                return Err(Issue::says("ends before the line `data`"));
            };
            // Borrowed when it is text, as all lines that count are.
            let line = String::from_utf8_lossy(&bytes[at..at + length]);
            at += length + 1;
            if number == 1 {
                if !line.starts_with(FIRST_LINE) {
                    return Err(Issue::unsupported(format!("does not begin with `{FIRST_LINE}`"))
                        .wanted("only .bt files are read (convert_octree makes one of an .ot)"));
                }
                continue;
            }
            let (key, value) = line.trim().split_once(' ').unwrap_or((line.trim(), ""));
            let value = value.trim();
            match key {
                "data" => break,
                "id" if value == "OcTree" => id = true,
                "id" => return Err(Issue::value("id", format!("{value:.40}"), "must be OcTree")),
                "size" => {
                    let parsed = value.parse::<u64>();
                    size = Some(
                        parsed.map_err(|e| Issue::value("size", format!("{value:.40}"), e.to_string()))?,
                    );
                }
                "res" => {
                    let parsed = value.parse::<f64>().ok();
                    let usable = parsed.filter(|res| res.is_finite() && *res > 0.0);
                    resolution_m = Some(usable.ok_or_else(|| {
                        Issue::value("res", format!("{value:.40}"), "must be a positive length in metres")
                    })?);
                }
                // As OctoMap does: comments, empty lines and unknown words are passed over.
                _ => {}
            }
        }
        if !id {
            return Err(Issue::says("header lacks the line `id OcTree`"));
        }
        Ok(TreeHeader {
            size: size.ok_or_else(|| Issue::says("header lacks the line `size N`"))?,
            resolution_m: resolution_m.ok_or_else(|| Issue::says("header lacks the line `res R`"))?,
            length: at,
        })
    }
}

/// A known cube of voxels: its smallest world key, its edge in voxels.
struct Leaf {
    key: [i32; 3],
    edge: i32,
    occupied: bool,
}

/// Calls `visit` for each known leaf and returns the number of nodes, root and leaves included.
fn visit_leaves(data: &[u8], visit: &mut dyn FnMut(Leaf)) -> Result<u64, Issue> {
    if data.is_empty() {
        return Ok(0);
    }
    let mut rest = data;
    let nodes = 1 + visit_children(&mut rest, [-KEY_ORIGIN; 3], DEPTH, visit)?;
    if !rest.is_empty() {
        return Err(Issue::damaged(format!("has {} bytes after the tree: the file is damaged", rest.len())));
    }
    Ok(nodes)
}

/// Visits the children of the inner node at `key` whose edge is 2^level voxels; recurses at most 16 deep.
fn visit_children(
    rest: &mut &[u8],
    key: [i32; 3],
    level: u32,
    visit: &mut dyn FnMut(Leaf),
) -> Result<u64, Issue> {
    let Some((bytes, after)) = rest.split_first_chunk::<2>() else {
        return Err(Issue::damaged("ends inside the tree: the file is truncated"));
    };
    *rest = after;
    let children = u16::from_le_bytes(*bytes);
    let edge = 1 << (level - 1);
    let mut nodes = 0;
    for child in 0..8 {
        let key = child_key(key, child, edge);
        match children >> (2 * child) & 0b11 {
            UNKNOWN => continue,
            INNER if level == 1 => {
                return Err(Issue::damaged(format!("has a node below level {DEPTH}: the file is damaged")));
            }
            INNER => nodes += visit_children(rest, key, level - 1, visit)?,
            state => visit(Leaf { key, edge, occupied: state == OCCUPIED }),
        }
        nodes += 1;
    }
    Ok(nodes)
}

/// Bit 0 of a child's number is its half on x, bit 1 on y, bit 2 on z.
fn child_key(key: [i32; 3], child: usize, edge: i32) -> [i32; 3] {
    std::array::from_fn(|axis| key[axis] + edge * (child >> axis & 1) as i32)
}

/// The bytes of a pruned `.bt` file: `state` is asked once for each key in `min .. min + size` and says
/// occupied (`Some(true)`), free (`Some(false)`) or unknown. Keys outside OctoMap's −32768 … 32767 are left
/// out.
pub fn write(
    resolution_m: f64,
    min: [i32; 3],
    size: [u32; 3],
    state: &dyn Fn([i32; 3]) -> Option<bool>,
) -> Vec<u8> {
    let mut writer = TreeWriter {
        min: min.map(i64::from),
        end: std::array::from_fn(|axis| i64::from(min[axis]) + i64::from(size[axis])),
        state,
        data: Vec::new(),
        nodes: 0,
    };
    if writer.node([-KEY_ORIGIN; 3], DEPTH) != UNKNOWN {
        writer.nodes += 1;
    }
    let mut bytes = format!(
        "{FIRST_LINE}\n{SECOND_LINE}\n#\nid OcTree\nsize {}\nres {resolution_m}\ndata\n",
        writer.nodes
    )
    .into_bytes();
    bytes.append(&mut writer.data);
    bytes
}

struct TreeWriter<'a> {
    min: [i64; 3],
    end: [i64; 3],
    state: &'a dyn Fn([i32; 3]) -> Option<bool>,
    data: Vec<u8>,
    /// Nodes below the root.
    nodes: u64,
}

impl TreeWriter<'_> {
    /// Writes the node at `key` with an edge of 2^level voxels, and returns what its parent is to write about
    /// it.
    fn node(&mut self, key: [i32; 3], level: u32) -> u16 {
        let edge = 1i64 << level;
        for axis in 0..3 {
            let low = i64::from(key[axis]);
            if low + edge <= self.min[axis] || low >= self.end[axis] {
                return UNKNOWN;
            }
        }
        if level == 0 {
            return match (self.state)(key) {
                None => UNKNOWN,
                Some(false) => FREE,
                Some(true) => OCCUPIED,
            };
        }
        let start = self.data.len();
        self.data.extend([0, 0]);
        let states: [u16; 8] =
            std::array::from_fn(|child| self.node(child_key(key, child, 1 << (level - 1)), level - 1));
        // The root stays a node: a lone root cannot say what it is.
        let alike = states.iter().all(|state| *state == states[0]) && states[0] != INNER;
        if alike && (level < DEPTH || states[0] == UNKNOWN) {
            self.data.truncate(start);
            return states[0];
        }
        let known = states.iter().filter(|state| **state != UNKNOWN).count();
        self.nodes += known as u64;
        let children = (0..8).fold(0, |word, child| word | states[child] << (2 * child));
        self.data[start..start + 2].copy_from_slice(&children.to_le_bytes());
        INNER
    }
}

#[cfg(test)]
mod tests;
