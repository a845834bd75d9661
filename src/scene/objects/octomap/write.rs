//! Writes an OctoMap's binary tree (`.bt`).

use super::{DEPTH, FIRST_LINE, FREE, INNER, KEY_ORIGIN, OCCUPIED, SECOND_LINE, UNKNOWN, child_key};

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
