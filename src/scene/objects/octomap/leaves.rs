//! Walks through the nodes of an OctoMap's tree, in the order in which they stand in a file.

use super::{DEPTH, INNER, KEY_ORIGIN, OCCUPIED, UNKNOWN, child_key};
use perirobot_march::error::Issue;

/// A known cube of voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    /// Its smallest world key.
    pub key: [i32; 3],
    /// Its edge in voxels.
    pub edge: i32,
    /// Whether it is occupied; free else.
    pub occupied: bool,
}

/// How nodes are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Nodes {
    /// `.bt`: two bits for each child of an inner node.
    Binary,
    /// `.ot`: the log-odds of a node as a float, and a bit for each child that it has. A leaf is occupied from
    /// log-odds 0 on (a probability of one half), as OctoMap's own default has it.
    Full,
}

/// Calls `visit` for each known leaf and returns the number of nodes, root and leaves included, and how many bytes are
/// left behind them.
pub(super) fn visit_leaves(
    data: &[u8],
    nodes: Nodes,
    visit: &mut dyn FnMut(Leaf),
) -> Result<(u64, usize), Issue> {
    if data.is_empty() {
        return Ok((0, 0));
    }
    let mut rest = data;
    let root = [-KEY_ORIGIN; 3];
    let nodes = match nodes {
        Nodes::Binary => 1 + visit_children(&mut rest, root, DEPTH, visit)?,
        Nodes::Full => visit_node(&mut rest, root, DEPTH, visit)?,
    };
    Ok((nodes, rest.len()))
}

/// Takes the next bytes of a tree.
fn take<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], Issue> {
    let (bytes, after) = rest
        .split_first_chunk::<N>()
        .ok_or_else(|| Issue::damaged("ends inside the tree: the file is truncated"))?;
    *rest = after;
    Ok(*bytes)
}

fn too_deep() -> Issue {
    Issue::damaged(format!("has a node below level {DEPTH}: the file is damaged"))
}

/// Visits the children of the inner node at `key` whose edge is 2^level voxels; recurses at most 16 deep.
fn visit_children(
    rest: &mut &[u8],
    key: [i32; 3],
    level: u32,
    visit: &mut dyn FnMut(Leaf),
) -> Result<u64, Issue> {
    let children = u16::from_le_bytes(take(rest)?);
    let edge = 1 << (level - 1);
    let mut nodes = 0;
    for child in 0..8 {
        let key = child_key(key, child, edge);
        match children >> (2 * child) & 0b11 {
            UNKNOWN => continue,
            INNER if level == 1 => return Err(too_deep()),
            INNER => nodes += visit_children(rest, key, level - 1, visit)?,
            state => visit(Leaf { key, edge, occupied: state == OCCUPIED }),
        }
        nodes += 1;
    }
    Ok(nodes)
}

/// Visits the node at `key` whose edge is 2^level voxels, and all below; recurses at most 16 deep.
fn visit_node(
    rest: &mut &[u8],
    key: [i32; 3],
    level: u32,
    visit: &mut dyn FnMut(Leaf),
) -> Result<u64, Issue> {
    let log_odds = f32::from_le_bytes(take(rest)?);
    let [children] = take(rest)?;
    if log_odds.is_nan() {
        return Err(Issue::damaged("has a node whose log-odds are no number: the file is damaged"));
    }
    if children == 0 {
        visit(Leaf { key, edge: 1 << level, occupied: log_odds >= 0.0 });
        return Ok(1);
    }
    if level == 0 {
        return Err(too_deep());
    }
    let mut nodes = 1;
    for child in (0..8).filter(|child| children >> child & 1 == 1) {
        nodes += visit_node(rest, child_key(key, child, 1 << (level - 1)), level - 1, visit)?;
    }
    Ok(nodes)
}
