//! `.bt` files there and back, and each way one can be damaged.

use std::collections::{HashMap, HashSet};

use rand::{RngExt, SeedableRng};

use super::*;

fn parse(bytes: &[u8]) -> Result<OctoMap, Issue> {
    super::parse(bytes).map(|(map, _)| map)
}

fn parse_tree(bytes: &[u8]) -> Result<Tree, Issue> {
    super::parse_tree(bytes).map(|(tree, _)| tree)
}

fn with_header(size: u64, data: &[u8]) -> Vec<u8> {
    let header = format!("{FIRST_LINE}\n# by hand\nid OcTree\nsize {size}\nres 0.05\ndata\n");
    [header.as_bytes(), data].concat()
}

#[test]
fn one_voxel_is_a_path_of_sixteen_nodes() {
    let bytes = write(0.05, [-3, 0, 5], [4, 4, 4], &|key| (key == [-1, 0, 7]).then_some(true));
    let text = String::from_utf8_lossy(&bytes);
    assert!(
        text.starts_with(&format!("{FIRST_LINE}\n{SECOND_LINE}\n#\nid OcTree\nsize 17\nres 0.05\ndata\n"))
    );
    assert!(bytes.ends_with(&[0, 0x08]), "x odd, y even, z odd: child 5 is wrong");
    let map = parse(&bytes).unwrap();
    assert_eq!((map.resolution_m, map.occupied), (0.05, vec![[-1, 0, 7]]));
}

#[test]
fn random_maps_come_back() {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    for density in [1, 30, 64] {
        let (min, size) = ([-9, 3, -20], [21, 9, 26]);
        let mut states = HashMap::new();
        for x in 0..21 {
            for y in 0..9 {
                for z in 0..26 {
                    // Blocks of 4 alike, so that pruning has something to do.
                    let block = [x / 4, y / 4, z / 4, 1];
                    let state = match random.random_range(0..64) {
                        n if n < density => Some(n % 2 == 0),
                        _ => states.get(&block).copied().unwrap_or(Some(true)),
                    };
                    states.insert(block, state);
                    states.insert([x + min[0], y + min[1], z + min[2], 0], state);
                }
            }
        }
        let state = |k: [i32; 3]| states[&[k[0], k[1], k[2], 0]];
        let bytes = write(0.1, min, size, &state);
        let read: HashSet<_> = parse(&bytes).unwrap().occupied.into_iter().collect();
        let written: HashSet<_> = (states.iter())
            .filter(|(key, state)| key[3] == 0 && **state == Some(true))
            .map(|(key, _)| [key[0], key[1], key[2]])
            .collect();
        assert_eq!(read, written, "density {density}");
    }
}

#[test]
fn pruned_leaves_expand_to_each_voxel_once() {
    let bytes = write(0.05, [-8; 3], [16; 3], &|_| Some(true));
    // The root, and eight paths of twelve inner nodes that end in a leaf of 8 x 8 x 8 voxels.
    let header = bytes.windows(5).position(|w| w == b"data\n").unwrap() + 5;
    assert_eq!(bytes.len() - header, 2 * (1 + 8 * 12));
    let map = parse(&bytes).unwrap();
    let distinct: HashSet<_> = map.occupied.iter().collect();
    assert_eq!((map.occupied.len(), distinct.len()), (4096, 4096));
    assert!(map.occupied.iter().flatten().all(|k| (-8..8).contains(k)));
}

#[test]
fn an_empty_map_has_no_nodes_and_is_refused() {
    let bytes = write(0.05, [0; 3], [9; 3], &|_| None);
    assert!(bytes.ends_with(b"size 0\nres 0.05\ndata\n"));
    assert_refused(&bytes, "no occupied voxel");
    assert_refused(&write(0.05, [0; 3], [9; 3], &|_| Some(false)), "no occupied voxel");
}

#[track_caller]
fn assert_refused(bytes: &[u8], expected: &str) {
    let what = parse(bytes).expect_err(expected);
    assert!(what.to_string().contains(expected), "{what:?} lacks {expected:?}");
}

#[test]
fn what_is_wrong_is_named() {
    let good = write(0.05, [0; 3], [3; 3], &|_| Some(true));
    parse(&good).unwrap();
    let replaced = |from: &str, to: &str| {
        let at = (good.windows(from.len()).position(|w| w == from.as_bytes())).unwrap();
        [&good[..at], to.as_bytes(), &good[at + from.len()..]].concat()
    };
    assert_refused(b"", "ends before the line `data`");
    assert_refused(
        &replaced("Octomap OcTree binary file", "Octomap QuadTree file"),
        ".bt and .ot files are read",
    );
    assert_refused(&replaced("id OcTree", "#"), "lacks the line `id OcTree`");
    assert_refused(&replaced("size ", "#"), "lacks the line `size N`");
    assert_refused(&replaced("size ", "size -"), "must be a whole number");
    assert_refused(&replaced("res 0.05", "#"), "lacks the line `res R`");
    for res in ["0", "-1", "nan", "inf", "wide"] {
        assert_refused(&replaced("res 0.05", &format!("res {res}")), "must be a positive length");
    }
    assert_refused(&replaced("data\n", ""), "ends before the line `data`");
    assert_refused(&replaced("size ", "size 1"), "the tree has");
    assert_refused(&good[..good.len() - 1], "truncated");
    assert_refused(&with_header(18, &[0b11, 0].repeat(17)), "below level 16");
    assert_refused(&with_header(9, &[0xff; 20]), "truncated");
}

#[test]
fn a_map_that_is_too_full_is_refused_before_it_is_expanded() {
    // One leaf at level 15: 32768 voxels on each axis.
    assert_refused(
        &with_header(2, &[0b10, 0]),
        "has 35184372088832 occupied voxels: at most 33554432 are read",
    );
    // A map may be larger than a grid, which may lie around a part of it.
    let far = write(0.05, [0; 3], [4001, 1, 1], &|k| Some(k[0] % 4000 == 0));
    assert_eq!(parse(&far).unwrap().occupied, [[0, 0, 0], [4000, 0, 0]]);
    // Six levels of first children, then all eight: a full cube of 512, few bytes and 134 million voxels.
    let data = [[0b11, 0].repeat(6), vec![0b10, 0]].concat();
    assert_refused(&with_header(8, &data), "at most 33554432 are read");
}

#[test]
fn damaged_files_never_panic() {
    let good = write(0.05, [-5; 3], [11; 3], &|k| Some(k[0] * k[1] > k[2]));
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(11);
    for _ in 0..20_000 {
        let mut bytes = good.clone();
        for _ in 0..random.random_range(1..4) {
            let at = random.random_range(0..bytes.len());
            bytes[at] = random.random();
        }
        bytes.truncate(random.random_range(0..=bytes.len()));
        let _ = parse(&bytes);
    }
    for length in 0..good.len() {
        assert!(parse(&good[..length]).is_err(), "cut at {length}");
    }
}

/// A full tree: log-odds and a word of children for each node, here one path of sixteen first children.
fn full(leaf: &[u8]) -> Vec<u8> {
    let inner = [&0.5f32.to_le_bytes()[..], &[1]].concat().repeat(16);
    let header = format!("{FIRST_LINE_OF_FULL}\nid OcTree\nsize {}\nres 0.05\ndata\n", 16 + leaf.len() / 5);
    [header.as_bytes(), &inner, leaf].concat()
}

#[test]
fn a_full_tree_is_occupied_from_a_probability_of_one_half_on() {
    let lowest = [-KEY_ORIGIN; 3];
    for (log_odds, occupied) in [(0.0f32, true), (0.85, true), (-0.4, false)] {
        let leaf = [&log_odds.to_le_bytes()[..], &[0]].concat();
        let tree = parse_tree(&full(&leaf)).unwrap();
        assert_eq!(tree.leaves, [Leaf { key: lowest, edge: 1, occupied }], "{log_odds}");
    }
    let leaf = |log_odds: f32, children: u8| [&log_odds.to_le_bytes()[..], &[children]].concat();
    assert_refused(&full(&leaf(f32::NAN, 0)), "log-odds are no number");
    assert_refused(&full(&leaf(1.0, 1)), "below level 16");
    assert_refused(&full(&leaf(1.0, 0)[..4]), "truncated");
    assert_refused(&full(&[leaf(1.0, 0), leaf(1.0, 0)].concat()), "header says size 18 and the tree has 17");
}

#[test]
fn what_a_binary_tree_leaves_out_refuses_no_file() {
    let good = write(0.05, [0; 3], [4, 4, 4], &|key| (key == [1, 2, 3]).then_some(true));
    let named = |bytes: &[u8], from: &str, to: &str| {
        let at = (bytes.windows(from.len()).position(|w| w == from.as_bytes())).unwrap();
        [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
    };
    let map = parse(&good).unwrap();
    for id in ["ColorOcTree", "OcTreeStamped", "SemanticsOcTree"] {
        assert_eq!(parse(&named(&good, "id OcTree", &format!("id {id}"))).unwrap(), map);
    }
    assert_eq!(super::parse(&[&good[..], &[1, 2, 3]].concat()).unwrap(), (map, 3));
    let leaf = [&1f32.to_le_bytes()[..], &[0]].concat();
    let error = parse(&named(&full(&leaf), "id OcTree", "id ColorOcTree")).unwrap_err().to_string();
    assert!(error.contains("id = ColorOcTree: must be OcTree: save the map as .bt"), "{error}");
}

#[test]
fn all_that_a_tree_knows_comes_back() {
    let state =
        |k: [i32; 3]| [Some(true), Some(false), None][((k[0] / 4) + k[1] + 2 * k[2]).rem_euclid(3) as usize];
    let tree = parse_tree(&write(0.1, [0; 3], [13, 9, 5], &state)).unwrap();
    let mut known = HashMap::new();
    for Leaf { key: [x, y, z], edge, occupied } in tree.leaves {
        for voxel in (0..edge.pow(3)).map(|n| [x + n % edge, y + n / edge % edge, z + n / edge / edge]) {
            assert_eq!(known.insert(voxel, occupied), None, "{voxel:?} twice");
        }
    }
    for voxel in (0..13 * 9 * 5).map(|n| [n % 13, n / 13 % 9, n / 13 / 9]) {
        assert_eq!(known.remove(&voxel), state(voxel), "{voxel:?}");
    }
    assert!(known.is_empty());
}
