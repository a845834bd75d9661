//! Reads and writes OctoMap's trees as OctoMap 1.9 makes them, so that maps are read and written without loss:
//! binary ones (`.bt`), and full ones (`.ot`), which are read only. Keys stay integers.

mod leaves;
mod write;

use std::path::Path;

use crate::source::Sources;
use crate::spelling::plural;
pub use leaves::Leaf;
use leaves::{Nodes, visit_leaves};
use perirobot_march::Result;
use perirobot_march::error::Issue;
pub use write::write;

/// Levels below the root: a key has 16 bits on each axis.
const DEPTH: u32 = 16;
/// OctoMap's key of the voxel that begins at the world's origin.
const KEY_ORIGIN: i32 = 1 << (DEPTH - 1);
/// A pruned leaf of a few bits may stand for millions of voxels; past this many (400 MB of keys) a map is
/// refused.
const MAX_OCCUPIED: u64 = 1 << 25;

/// Past this many leaves (1.3 GB) a map of which all that is known is wanted is refused.
const MAX_LEAVES: usize = 1 << 26;

const FIRST_LINE: &str = "# Octomap OcTree binary file";
const FIRST_LINE_OF_FULL: &str = "# Octomap OcTree file";
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

/// All that a map knows.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    /// Edge of a voxel in metres.
    pub resolution_m: f64,
    /// Occupied and free cubes of voxels, in the tree's order; no two overlap.
    pub leaves: Vec<Leaf>,
}

/// Reads the occupied voxels of a file; pruned leaves are expanded to voxels.
///
/// # Errors
/// When the file cannot be read, is not an OcTree, is damaged, or has more occupied voxels than are read.
pub fn read(path: &Path, sources: &Sources) -> Result<OctoMap> {
    let bytes = sources.bytes_of_text(path)?;
    let (map, rest) = parse(&bytes).map_err(|issue| issue.with_place(path))?;
    remark_rest(rest, path, sources);
    Ok(map)
}

/// Reads all that a file says is occupied or free.
///
/// # Errors
/// When the file cannot be read, is not an OcTree, is damaged, or says nothing.
pub fn read_tree(path: &Path, sources: &Sources) -> Result<Tree> {
    let bytes = sources.bytes_of_text(path)?;
    let (tree, rest) = parse_tree(&bytes).map_err(|issue| issue.with_place(path))?;
    remark_rest(rest, path, sources);
    Ok(tree)
}

/// Tells of bytes behind a tree.
fn remark_rest(rest: usize, path: &Path, sources: &Sources) {
    if rest > 0 {
        sources.remark(path, format!("without {} behind its tree", plural(rest, "byte")));
    }
}

/// All that is known, and how many bytes there are behind the tree.
fn parse_tree(bytes: &[u8]) -> Result<(Tree, usize), Issue> {
    let header = TreeHeader::parse(bytes)?;
    let mut count = 0;
    let rest = header.visit_leaves(bytes, &mut |_| count += 1)?;
    if count > MAX_LEAVES {
        return Err(Issue::too_large(format!("has {count} leaves"))
            .with_advice(format!("at most {MAX_LEAVES} are read, so use a coarser or smaller map")));
    }
    let mut leaves = Vec::with_capacity(count);
    header.visit_leaves(bytes, &mut |leaf| leaves.push(leaf))?;
    match leaves.is_empty() {
        true => Err(Issue::says("has no voxel that is occupied or free")),
        false => Ok((Tree { resolution_m: header.resolution_m, leaves }, rest)),
    }
}

/// The occupied voxels, and how many bytes there are behind the tree.
fn parse(bytes: &[u8]) -> Result<(OctoMap, usize), Issue> {
    let header = TreeHeader::parse(bytes)?;

    // The first pass only measures, so that nothing is allocated for a map that is too large.
    let mut voxels = 0u64;
    let rest = header.visit_leaves(bytes, &mut |leaf| {
        if leaf.occupied {
            // At most 2^48 a leaf: saturating keeps a lying tree from wrapping.
            voxels = voxels.saturating_add((leaf.edge as u64).pow(3));
        }
    })?;
    if voxels == 0 {
        return Err(Issue::says("has no occupied voxel"));
    }
    if voxels > MAX_OCCUPIED {
        return Err(Issue::too_large(format!("has {voxels} occupied voxels"))
            .with_advice(format!("at most {MAX_OCCUPIED} are read, so use a coarser or smaller map")));
    }

    let mut occupied = Vec::with_capacity(voxels as usize);
    header.visit_leaves(bytes, &mut |leaf| {
        if leaf.occupied {
            let [x, y, z] = leaf.key;
            for z in z..z + leaf.edge {
                for y in y..y + leaf.edge {
                    occupied.extend((x..x + leaf.edge).map(|x| [x, y, z]));
                }
            }
        }
    })?;
    Ok((OctoMap { resolution_m: header.resolution_m, occupied }, rest))
}

struct TreeHeader {
    nodes: Nodes,
    size: u64,
    resolution_m: f64,
    /// Bytes up to the first node.
    length: usize,
}

impl TreeHeader {
    fn parse(bytes: &[u8]) -> Result<TreeHeader, Issue> {
        let (mut nodes, mut id, mut size, mut resolution_m) = (Nodes::Binary, false, None, None);
        let mut at = 0;
        for number in 1.. {
            let Some(length) = bytes[at..].iter().position(|byte| *byte == b'\n') else {
                return Err(Issue::says("ends before the line `data`"));
            };
            // Borrowed when it is text, as all lines that count are.
            let line = String::from_utf8_lossy(&bytes[at..at + length]);
            at += length + 1;
            if number == 1 {
                nodes = match () {
                    () if line.starts_with(FIRST_LINE) => Nodes::Binary,
                    () if line.starts_with(FIRST_LINE_OF_FULL) => Nodes::Full,
                    () => {
                        return Err(Issue::unsupported(format!(
                            "begins neither with `{FIRST_LINE}` nor with `{FIRST_LINE_OF_FULL}`"
                        ))
                        .with_advice("OctoMap's .bt and .ot files are read"));
                    }
                };
                continue;
            }
            let (key, value) = line.trim().split_once(' ').unwrap_or((line.trim(), ""));
            let value = value.trim();
            match key {
                "data" => break,
                // Only full files have the colours, times or labels of other trees.
                "id" if value == "OcTree" || nodes == Nodes::Binary => id = true,
                "id" => {
                    let rule = "must be OcTree: save the map as .bt, which has only what is occupied";
                    return Err(Issue::value("id", format!("{value:.40}"), rule));
                }
                "size" => {
                    let parsed = value.parse::<u64>().ok();
                    let wrong = || Issue::value("size", format!("{value:.40}"), "must be a whole number");
                    size = Some(parsed.ok_or_else(wrong)?);
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
            nodes,
            size: size.ok_or_else(|| Issue::says("header lacks the line `size N`"))?,
            resolution_m: resolution_m.ok_or_else(|| Issue::says("header lacks the line `res R`"))?,
            length: at,
        })
    }

    /// Calls `visit` for each known leaf of the file's tree, and returns how many bytes there are behind it.
    fn visit_leaves(&self, bytes: &[u8], visit: &mut dyn FnMut(Leaf)) -> Result<usize, Issue> {
        let (nodes, rest) = visit_leaves(&bytes[self.length..], self.nodes, visit)?;
        match nodes == self.size {
            true => Ok(rest),
            false => Err(Issue::damaged(format!(
                "header says size {} and the tree has {nodes} nodes: the file is damaged",
                self.size
            ))),
        }
    }
}

/// Bit 0 of a child's number is its half on x, bit 1 on y, bit 2 on z.
fn child_key(key: [i32; 3], child: usize, edge: i32) -> [i32; 3] {
    std::array::from_fn(|axis| key[axis] + edge * (child >> axis & 1) as i32)
}

#[cfg(test)]
mod tests;
