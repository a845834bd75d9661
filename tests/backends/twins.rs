//! Each function of `shaders/march.wgsl` alone, on a device, against its Rust twin: edge values, and
//! thousands of random ones.

use crate::common::{self, Random};
use perirobot_march::backend::gpu::types::dir_words;
use perirobot_march::backend::gpu::{GpuDevice, WORKGROUP, evaluate, open, shader_prelude};
use perirobot_march::march::{self, BLIND, End, LEFT, March, NEVER, NOTHING, RETURN, leap};

/// A pure function of words: what WGSL and Rust make of `input`.
struct Twin {
    name: &'static str,
    inputs: usize,
    outputs: usize,
    /// WGSL statements that read `in(0)`, `in(1)` … and call `out(0, …)`, `out(1, …)` …
    wgsl: &'static str,
    rust: fn(&[u32]) -> Vec<u32>,
}

/// Compares the twins on all cases, each `inputs` words.
#[track_caller]
fn check(device: &GpuDevice, twin: &Twin, cases: &[u32]) {
    let (inputs, outputs) = (twin.inputs, twin.outputs);
    let number = cases.len() / inputs;
    assert_eq!(number * inputs, cases.len(), "{}: whole cases", twin.name);
    let kernel = format!(
        "
        @group(0) @binding(0) var<storage, read> input: array<u32>;
        @group(0) @binding(1) var<storage, read_write> output: array<u32>;
        var<private> number: u32;
        fn in(i: u32) -> u32 {{ return input[number * {inputs}u + i]; }}
        fn sin(i: u32) -> i32 {{ return bitcast<i32>(in(i)); }}
        fn out(i: u32, word: u32) {{ output[number * {outputs}u + i] = word; }}
        fn sout(i: u32, word: i32) {{ out(i, bitcast<u32>(word)); }}
        fn in3(i: u32) -> vec3<i32> {{ return vec3<i32>(sin(i), sin(i + 1u), sin(i + 2u)); }}
        fn out_march(m: March) {{
            sout(0u, m.voxel.x); sout(1u, m.voxel.y); sout(2u, m.voxel.z);
            sout(3u, m.step.x); sout(4u, m.step.y); sout(5u, m.step.z);
            out(6u, m.next_q16.x); out(7u, m.next_q16.y); out(8u, m.next_q16.z);
            out(9u, m.period_q16.x); out(10u, m.period_q16.y); out(11u, m.period_q16.z);
        }}
        @compute @workgroup_size(WORKGROUP)
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
            if id.x < {number}u {{ number = id.x; {} }}
        }}",
        twin.wgsl
    );
    let groups = (number as u32).div_ceil(WORKGROUP);
    let source = shader_prelude() + &kernel;
    let found = evaluate(device, source, cases, number * outputs, groups).unwrap_or_else(|e| panic!("{e}"));
    for (case, found) in cases.chunks_exact(inputs).zip(found.chunks_exact(outputs)) {
        let expected = (twin.rust)(case);
        assert_eq!(
            found,
            expected,
            "{}({case:?}, signed {:?}): the device's words, then Rust's\nrerun: cargo test --test backends twins",
            twin.name,
            case.iter().map(|&w| w as i32).collect::<Vec<_>>()
        );
    }
}

fn march_words(march: March) -> Vec<u32> {
    let signed = [march.voxel, march.step].concat();
    let unsigned = [march.next_q16, march.period_q16].concat();
    signed.into_iter().map(|w| w as u32).chain(unsigned).collect()
}

fn signed(words: &[u32]) -> [i32; 3] {
    std::array::from_fn(|i| words[i] as i32)
}

fn march_of(words: &[u32]) -> March {
    March {
        voxel: signed(words),
        step: signed(&words[3..]),
        next_q16: std::array::from_fn(|r| words[6 + r]),
        period_q16: std::array::from_fn(|r| words[9 + r]),
    }
}

const TWINS: [Twin; 27] = [
    Twin {
        name: "packed",
        inputs: 2,
        outputs: 1,
        wgsl: "out(0u, packed(End(in(0u), in(1u))));",
        rust: |w| vec![End { kind: w[0], crossings: w[1] }.packed()],
    },
    Twin {
        name: "unpacked",
        inputs: 1,
        outputs: 2,
        wgsl: "let end = unpacked(in(0u)); out(0u, end.kind); out(1u, end.crossings);",
        rust: |w| vec![End::unpacked(w[0]).kind, End::unpacked(w[0]).crossings],
    },
    Twin {
        name: "period_q16",
        inputs: 1,
        outputs: 1,
        wgsl: "out(0u, period_q16(in(0u)));",
        rust: |w| vec![march::period_q16(w[0])],
    },
    Twin {
        name: "first_q16",
        inputs: 2,
        outputs: 1,
        wgsl: "out(0u, first_q16(in(0u), in(1u)));",
        rust: |w| vec![march::first_q16(w[0], w[1])],
    },
    Twin {
        name: "axial_q16",
        inputs: 2,
        outputs: 1,
        wgsl: "out(0u, axial_q16(sin(0u), in(1u) != 0u));",
        rust: |w| vec![march::axial_q16(w[0] as i32, w[1] != 0)],
    },
    Twin {
        name: "ray_range_q16",
        inputs: 2,
        outputs: 1,
        wgsl: "out(0u, ray_range_q16(in(0u), period_q16(in(1u))));",
        rust: |w| vec![march::ray_range_q16(w[0], march::period_q16(w[1]))],
    },
    Twin {
        name: "std_along_q16",
        inputs: 2,
        outputs: 1,
        wgsl: "out(0u, std_along_q16(in(0u), period_q16(in(1u))));",
        rust: |w| vec![march::std_along_q16(w[0], march::period_q16(w[1]))],
    },
    Twin {
        name: "direction_q16",
        inputs: 6,
        outputs: 1,
        wgsl: "sout(0u, direction_q16(in3(0u), in3(3u)));",
        rust: |w| vec![march::direction_q16(signed(w), signed(&w[3..])) as u32],
    },
    Twin {
        name: "start_axis",
        inputs: 2,
        outputs: 2,
        wgsl: "let axis = start_axis(sin(0u), sin(1u)); out(0u, axis.x); out(1u, axis.y);",
        rust: |w| march::start_axis(w[0] as i32, w[1] as i32).to_vec(),
    },
    Twin {
        name: "start",
        inputs: 6,
        outputs: 12,
        wgsl: "out_march(start(in3(0u), in3(3u)));",
        rust: |w| march_words(march::start(signed(w), signed(&w[3..]))),
    },
    Twin {
        name: "next_axis",
        inputs: 3,
        outputs: 1,
        wgsl: "out(0u, next_axis(vec3<u32>(in(0u), in(1u), in(2u))));",
        rust: |w| vec![march::next_axis([w[0], w[1], w[2]]) as u32],
    },
    Twin {
        name: "cross",
        inputs: 13,
        outputs: 12,
        wgsl: "var m = March(in3(0u), in3(3u), vec3<u32>(in(6u), in(7u), in(8u)),
                             vec3<u32>(in(9u), in(10u), in(11u)), vec3<f32>());
               cross(&m, in(12u));
               out_march(m);",
        rust: |w| {
            let mut m = march_of(w);
            march::cross(&mut m, w[12] as usize);
            march_words(m)
        },
    },
    Twin {
        name: "freed",
        inputs: 3,
        outputs: 1,
        wgsl: "out(0u, freed(End(in(0u), in(1u)), in(2u) != 0u));",
        rust: |w| vec![march::freed(End { kind: w[0], crossings: w[1] }, w[2] != 0)],
    },
    Twin {
        name: "periods_in",
        inputs: 3,
        outputs: 1,
        wgsl: "out(0u, periods_in(in(0u), in(1u), rate3(vec3<i32>(sin(2u))).x));",
        rust: |w| vec![leap::periods_in(w[0], w[1], w[2])],
    },
    Twin {
        name: "made_at",
        inputs: 5,
        outputs: 1,
        wgsl: "let rate = rate3(vec3<i32>(sin(1u))).x;
               out(0u, made_at(in(0u), period_q16(in(1u)), rate, sin(2u), in(3u), sin(4u)));",
        rust: |w| vec![march::made_at(w[0], march::period_q16(w[1]), w[2] as i32, w[3], w[4] as i32)],
    },
    Twin {
        name: "crossing_q16",
        inputs: 3,
        outputs: 1,
        wgsl: "out(0u, crossing_q16(in(0u), in(1u), in(2u)));",
        rust: |w| vec![march::crossing_q16(w[0], w[1], w[2])],
    },
    Twin {
        name: "crossings_at",
        inputs: 10,
        outputs: 1,
        wgsl: "let m = start(in3(0u), in3(3u));
               out(0u, crossings_at(m, vec3<u32>(in(6u), in(7u), in(8u)), in(9u)));",
        rust: |w| {
            let begin = march::start(signed(w), signed(&w[3..]));
            vec![march::crossings_at(&begin, std::array::from_fn(|r| w[6 + r]), w[9])]
        },
    },
    Twin {
        name: "made_until",
        inputs: 11,
        outputs: 4,
        wgsl: "let m = start(in3(0u), in3(3u));
               let stand = made_until(m, vec3<u32>(in(6u), in(7u), in(8u)), in(9u), sin(10u));
               out(0u, stand.made.x); out(1u, stand.made.y); out(2u, stand.made.z); out(3u, u32(stand.stopped));",
        rust: |w| {
            let (begin, room) =
                (march::start(signed(w), signed(&w[3..])), std::array::from_fn(|r| w[6 + r]));
            let place = (w[9], w[10] as i32);
            let made = march::made_until(&begin, room, place.0, place.1);
            [made.to_vec(), vec![stopped(begin, room, place) as u32]].concat()
        },
    },
    Twin {
        name: "visits",
        inputs: 9,
        outputs: 1,
        wgsl: "let m = start(in3(0u), in3(3u));
               out(0u, u32(visits(m.next_q16, m.period_q16, vec3<u32>(in(6u), in(7u), in(8u)))));",
        rust: |w| {
            let begin = march::start(signed(w), signed(&w[3..]));
            let ahead = |r: usize| if begin.step[r] < 0 { -(w[6 + r] as i32) } else { w[6 + r] as i32 };
            let voxel = std::array::from_fn(|r| begin.voxel[r] + ahead(r));
            vec![leap::visits(&begin, voxel) as u32]
        },
    },
    Twin {
        name: "room",
        inputs: 9,
        outputs: 3,
        wgsl: "let m = start(in3(0u), in3(3u));
               let left = room(m, vec3<u32>(in(6u), in(7u), in(8u)));
               out(0u, left.x); out(1u, left.y); out(2u, left.z);",
        rust: |w| {
            let begin = march::start(signed(w), signed(&w[3..]));
            march::room(&begin, std::array::from_fn(|r| w[6 + r])).to_vec()
        },
    },
    Twin {
        name: "pcg",
        inputs: 1,
        outputs: 1,
        wgsl: "out(0u, pcg(in(0u)));",
        rust: |w| vec![march::pcg(w[0])],
    },
    Twin {
        name: "draw",
        inputs: 2,
        outputs: 1,
        wgsl: "out(0u, draw(in(0u), in(1u)));",
        rust: |w| vec![march::draw(w[0], w[1])],
    },
    Twin {
        name: "entry",
        inputs: 1,
        outputs: 1,
        wgsl: "out(0u, entry(in(0u)));",
        rust: |w| vec![march::entry(w[0])],
    },
    Twin {
        name: "is_lost",
        inputs: 2,
        outputs: 1,
        wgsl: "out(0u, u32(is_lost(in(0u), in(1u))));",
        rust: |w| vec![march::is_lost(w[0], w[1]) as u32],
    },
    Twin {
        name: "step_q16",
        inputs: 2,
        outputs: 1,
        wgsl: "out(0u, bitcast<u32>(step_q16(sin(0u), in(1u))));",
        rust: |w| vec![march::step_q16(w[0] as i32, w[1]) as u32],
    },
    Twin {
        name: "noisy_q16",
        inputs: 2,
        outputs: 1,
        wgsl: "out(0u, noisy_q16(in(0u), sin(1u)));",
        rust: |w| vec![march::noisy_q16(w[0], w[1] as i32)],
    },
    Twin {
        name: "launch",
        inputs: 17,
        outputs: 12,
        wgsl: "let axes = array<array<i32, 3>, 3>(
                   array<i32, 3>(sin(3u), sin(4u), sin(5u)), array<i32, 3>(sin(6u), sin(7u), sin(8u)),
                   array<i32, 3>(sin(9u), sin(10u), sin(11u)));
               let place = GridFrame(array<i32, 3>(sin(0u), sin(1u), sin(2u)), axes);
               out_march(launch(place, vec2<u32>(in(12u), in(13u))));",
        rust: |w| {
            let axis_q15 = [3, 6, 9].map(|row| signed(&w[row..]));
            march_words(march::launch(signed(w), axis_q15, signed(&w[14..])))
        },
    },
];

/// Steps until a ray has come to (t, axis), or to the last cell inside its room: whether it was the room that
/// stopped it, which only the shaders ask.
fn stopped(mut ray: March, mut room: [u32; 3], place: (u32, i32)) -> bool {
    loop {
        let axis = march::next_axis(ray.next_q16);
        if (ray.next_q16[axis], axis as i32) > place {
            return false;
        }
        if room[axis] == 0 {
            return true;
        }
        march::cross(&mut ray, axis);
        room[axis] -= 1;
    }
}

/// The cases of each function, within what the rules allow as its arguments.
fn cases(name: &str, random: &mut Random) -> Vec<u32> {
    let kinds = [NOTHING, RETURN, BLIND, LEFT];
    let mut out = Vec::new();
    match name {
        "packed" | "freed" => {
            for kind in kinds {
                for crossings in [0, 1, 2, 3, 3069, 65_534] {
                    for more in 0..if name == "freed" { 2 } else { 1 } {
                        out.extend([kind, crossings]);
                        out.extend((name == "freed").then_some(more));
                    }
                }
            }
        }
        "unpacked" => {
            out.extend([0, 1, 65_535, 65_536, 65_537, 3 << 16 | 3069]);
            out.extend((0..4000).map(|_| random.below(4) << 16 | random.below(65_536)));
        }
        // Every value that a direction can have.
        "period_q16" => out.extend(0..=65_600),
        "first_q16" => {
            for period in [0, 1, 65_533, 65_535, 65_536, 65_537, 131_072, NEVER - 1, NEVER] {
                for f in [0, 1, 2, 3, 255, 32_767, 32_768, 65_535, 65_536] {
                    out.extend([f, period]);
                }
            }
            for _ in 0..4000 {
                out.extend([random.below(65_537), random.below(NEVER)]);
            }
        }
        // Every part of a unit vector.
        "axial_q16" => {
            for z_q15 in -32_768..=32_768 {
                out.extend([z_q15 as u32, 0, z_q15 as u32, 1]);
            }
        }
        "ray_range_q16" | "std_along_q16" => {
            let axial = |random: &mut Random| 2 * (2048 + random.below(30_721));
            for depth_q16 in [0, 1, 0xffff, 0x1_0000, 0x1_0001, (64 << 16) - 1, 64 << 16, 2047 << 16] {
                for axial in [4096, 4098, 37_838, 65_534, 65_536] {
                    out.extend([depth_q16, axial]);
                }
            }
            for _ in 0..4000 {
                let most = random.of(&[1 << 16, 100 << 16, (2047 << 16) + 1]);
                out.extend([random.below(most), axial(random)]);
            }
        }
        "direction_q16" => {
            for edge in [-32_768, -18_919, -1, 0, 1, 2, 3, 18_919, 32_768] {
                out.extend([edge, 0, 0, 32_768, 0, 0].map(|v| v as u32));
                out.extend([18_919, 18_919, 18_919, edge, 0, 0].map(|v| v as u32));
                // Sums around the rounding's half.
                out.extend([8191 + edge, 0, 0, 1, 0, 0].map(|v| v as u32));
                out.extend([-8193 + edge, 0, 0, 1, 0, 0].map(|v| v as u32));
            }
            out.extend([18_919; 6]);
            for _ in 0..4000 {
                out.extend(unit(random));
                out.extend(unit(random));
            }
        }
        "start_axis" => {
            for origin in [0, 1, 0x7fff, 0x8000, 0xffff, 0x1_0000, 0x1_0001, (1023 << 16) - 1, -1] {
                for dir in -65_539..=65_539 {
                    out.extend([origin, dir].map(|v| v as u32));
                }
            }
        }
        "start" => {
            let lattice = [-65_539, -65_536, -3, -2, -1, 0, 1, 2, 3, 37_837, 65_535, 65_536, 65_539];
            for origin in [0, 1, 0x7fff, 0x8000, 0xffff, 0x1_0000, 0x1_0001, 1022 << 16, (1023 << 16) - 1, -1]
            {
                for dir in lattice {
                    out.extend([origin, 5 << 16, 0x8000, dir, -dir, 65_536].map(|v| v as u32));
                }
            }
            for _ in 0..4000 {
                out.extend((0..3).map(|_| random.below(1023 << 16)));
                out.extend((0..3).map(|_| random.between(-65_539, 65_539) as u32));
            }
        }
        "next_axis" => {
            let edges = [0, 1, 2, 65_536, NEVER - 1, NEVER, 0xffff_fffe];
            for x in edges {
                for y in edges {
                    for z in edges {
                        out.extend([x, y, z]);
                    }
                }
            }
            for _ in 0..4000 {
                // Few values, so that ties are frequent.
                out.extend((0..3).map(|_| random.below(4) << 20));
                out.extend((0..3).map(|_| random.below(NEVER)));
            }
        }
        "cross" => {
            for _ in 0..4000 {
                out.extend((0..3).map(|_| random.between(-1, 1023) as u32));
                out.extend((0..3).map(|_| random.between(-1, 1) as u32));
                out.extend((0..3).map(|_| random.below(2047 << 16)));
                out.extend((0..3).map(|_| if random.one_in(5) { NEVER } else { random.below(NEVER) }));
                out.push(random.below(3));
            }
        }
        "launch" => {
            for _ in 0..4000 {
                out.extend((0..3).map(|_| random.below(1023 << 16)));
                (0..3).for_each(|_| out.extend(unit(random)));
                // The direction as the device gets it, then as Rust does.
                let dir = unit(random);
                out.extend(dir_words(signed(&dir)));
                out.extend(dir);
            }
        }
        _ => read_cases(name, random, &mut out),
    }
    out
}

/// The cases of the functions that say where a noisy return is read.
fn read_cases(name: &str, random: &mut Random, out: &mut Vec<u32>) {
    match name {
        "periods_in" => {
            // Multiples of periods from all of a direction's, and what lies beside them.
            let mut beside = |d: u32| {
                let period = march::period_q16(d);
                let most = ((1 << 28) - 2) / period;
                for n in [0, 1, 2, random.below(most + 1), most.saturating_sub(1), most].map(|n| n.min(most))
                {
                    let x = n * period;
                    [x.saturating_sub(1), x, x + 1].iter().for_each(|&x| out.extend([x, period, d]));
                }
            };
            (3..=65_539)
                .step_by(7)
                .chain([1, 2, 3, 4, 5, 65_535, 65_536, 65_537, 65_539])
                .for_each(&mut beside);
            for d in [1, 2, 3, 31, 32, 32_768, 65_536, 65_539] {
                for x in [0, 1, 65_532, 65_533, 65_536, 2047 << 16, 2347 << 16, (1 << 28) - 1] {
                    out.extend([x, march::period_q16(d), d]);
                }
            }
            (0..20_000).for_each(|_| {
                let d = 3 + random.below(65_537);
                out.extend([random.below(1 << 28), march::period_q16(d), d])
            });
        }
        "made_at" => {
            for first in [0, 1, 10, 65_533, 65_536, 2047 << 16, NEVER - 1, NEVER] {
                for d in [65_539, 65_536, 65_535, 32_768, 33, 32, 3, 2, 1] {
                    for t in [0, 1, 9, 10, 11, 65_545, 65_546, 1772 << 16, 2047 << 16, 2347 << 16] {
                        for (own, axis) in [(0, -1), (0, 0), (0, 2), (1, 0), (1, 1), (2, 1)] {
                            out.extend([first, d, own, t, axis as u32]);
                        }
                    }
                }
            }
            for _ in 0..10_000 {
                let d = 1 + random.below(65_539);
                let period = march::period_q16(d);
                let first = march::first_q16(random.below(65_537), period);
                let n = random.below(1 + (2000 << 16) / period);
                // At a crossing, beside one, or anywhere.
                let any = random.below(2347 << 16);
                let at = first.min(300 << 16) + n * period.min(2000 << 16);
                let t = random.of(&[at, at + 1, at.saturating_sub(1), any]).min(2347 << 16);
                out.extend([first, d, random.below(3), t, random.between(-1, 2) as u32]);
            }
        }
        "crossing_q16" => {
            for first in [0, 1, 10, 65_533, 65_536, 2047 << 16, NEVER - 1, NEVER] {
                for period in [65_533, 65_536, 65_537, 131_072, 2047 << 16, 2048 << 16, NEVER - 1, NEVER] {
                    [0, 1, 2, 3, 31, 32, 511, 1022, 1023]
                        .iter()
                        .for_each(|&n| out.extend([first, period, n]));
                }
            }
            for _ in 0..4000 {
                let period = march::period_q16(1 + random.below(65_539));
                let first = march::first_q16(random.below(65_537), period);
                out.extend([first, period, random.below(1024)]);
            }
        }
        "visits" => {
            for i in 0..20_000 {
                let (origin, dir, _) = ray_in_a_grid(random, i);
                // A voxel that the ray comes to, or one beside it.
                let mut march = march::start(origin, dir);
                let mut ahead = [0u32; 3];
                for _ in 0..random.below(40) {
                    let axis = march::next_axis(march.next_q16);
                    if march.next_q16[axis] > 1500 << 16 {
                        break;
                    }
                    march::cross(&mut march, axis);
                    ahead[axis] += 1;
                }
                ahead[random.below(3) as usize] += random.of(&[0, 0, 1]);
                // What is entered past any range is never asked for.
                let begin = march::start(origin, dir);
                let enters = |r| march::crossing_q16(begin.next_q16[r], begin.period_q16[r], ahead[r] - 1);
                if (0..3).any(|r| ahead[r] > 0 && (2047 << 16..NEVER).contains(&enters(r))) {
                    continue;
                }
                out.extend(origin.map(|x| x as u32).into_iter().chain(dir.map(|x| x as u32)).chain(ahead));
            }
        }
        "room" | "crossings_at" | "made_until" => {
            for i in 0..40_000 {
                let (origin, dir, size) = ray_in_a_grid(random, i);
                out.extend(origin.map(|x| x as u32).into_iter().chain(dir.map(|x| x as u32)));
                match name {
                    "room" => out.extend(size),
                    _ => {
                        let (room, t) = read_at(random, i, origin, dir, size);
                        out.extend(room.into_iter().chain([t]));
                        out.extend((name == "made_until").then(|| random.between(-1, 2) as u32));
                    }
                }
            }
        }
        "pcg" | "entry" => {
            out.extend([0, 1, 42, 0xdead_beef, 1 << 31, u32::MAX]);
            out.extend((0..20_000).map(|_| random.bits() as u32));
        }
        "draw" => {
            (0..64).for_each(|ray| out.extend([129_708_002, ray]));
            (0..20_000).for_each(|_| out.extend([random.bits() as u32, random.below(1 << 20)]));
        }
        "is_lost" => {
            for drawn in (0..10_000).map(|_| random.bits() as u32) {
                let hash = march::pcg(drawn);
                let beside = [hash.saturating_sub(1), hash, hash.saturating_add(1), 0, u32::MAX];
                beside.iter().for_each(|&below| out.extend([drawn, below]));
            }
        }
        "step_q16" => {
            for unit in [0, 1, -1, 3, 4096, -4096, 15_025, -15_025, 18_432] {
                for std in [0, 1, 2047, 2048, 2049, 4095, 4096, 65_536, (64 << 16) - 1, 64 << 16] {
                    out.extend([unit as u32, std]);
                }
            }
            for _ in 0..20_000 {
                out.extend([random.between(-18_432, 18_432) as u32, random.below((64 << 16) + 1)]);
            }
        }
        "noisy_q16" => {
            for t in [0, 1, 65_536, 2047 << 16] {
                for step in [0, 1, -1, 65_536, -65_536, 300 << 16, -300 << 16, -2047 << 16] {
                    out.extend([t, step as u32]);
                }
            }
            for _ in 0..4000 {
                out.extend([random.below(2047 << 16), random.between(-300 << 16, 300 << 16) as u32]);
            }
        }
        _ => panic!("no cases for {name}"),
    }
}

/// A position in a grid and a direction: on boundaries, centres or anywhere; along the lattice, nearly so, or
/// anywhere.
fn ray_in_a_grid(random: &mut Random, i: usize) -> ([i32; 3], [i32; 3], [u32; 3]) {
    let size: [u32; 3] =
        std::array::from_fn(|_| if i.is_multiple_of(4) { 1023 } else { 1 + random.below(12) });
    let origin = size.map(|n| match i % 3 {
        0 => (random.below(n) << 16) as i32,
        1 => (random.below(n) << 16) as i32 + 0x8000,
        _ => random.below(n << 16) as i32,
    });
    let dir = std::array::from_fn(|_| match i % 2 {
        // 1 and 2 have a period of NEVER.
        0 => random.of(&[-65_536, -37_837, -2, -1, 0, 1, 3, 37_837, 65_536]),
        _ => random.between(-65_539, 65_539),
    });
    (origin, dir, size)
}

/// The room of a ray, and a distance: 0, at a crossing, at the exit or beside it, and far behind it.
fn read_at(
    random: &mut Random,
    i: usize,
    origin: [i32; 3],
    dir: [i32; 3],
    size: [u32; 3],
) -> ([u32; 3], u32) {
    let begin = march::start(origin, dir);
    let room = march::room(&begin, size);
    let crossing = |axis: usize, n| march::crossing_q16(begin.next_q16[axis], begin.period_q16[axis], n);
    let exit = (0..3).map(|axis| crossing(axis, room[axis])).min().unwrap_or(NEVER);
    let t = match i % 7 {
        0 => 0,
        1 => exit.saturating_sub(1),
        2 => exit,
        3 => exit + 1,
        4 => crossing(random.below(3) as usize, random.below(8)),
        5 => random.below(2347 << 16),
        _ => random.below(exit.min(2047 << 16) + 1),
    };
    (room, t.min(2347 << 16))
}

/// A random unit vector in Q15; every eighth along an axis.
fn unit(random: &mut Random) -> [u32; 3] {
    if random.one_in(8) {
        let mut axis = [0; 3];
        axis[random.below(3) as usize] = if random.one_in(2) { 32_768 } else { -32_768i32 as u32 };
        return axis;
    }
    loop {
        let v: [f64; 3] = std::array::from_fn(|_| 2.0 * random.share() - 1.0);
        let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm > 0.01 && norm <= 1.0 {
            return v.map(|x| (x / norm * 32_768.0).round() as i32 as u32);
        }
    }
}

#[test]
fn every_function_equals_its_twin() {
    let Some(choice) = common::adapter() else { return };
    let device = open(&choice).unwrap_or_else(|e| panic!("{e}"));
    for twin in TWINS.iter() {
        check(&device, twin, &cases(twin.name, &mut Random(1)));
    }
}

#[test]
fn a_direction_comes_back_from_its_words() {
    let Some(choice) = common::adapter() else { return };
    let device = open(&choice).unwrap_or_else(|e| panic!("{e}"));
    let twin = Twin {
        name: "unpacked_dir",
        inputs: 5,
        outputs: 3,
        wgsl: "let d = unpacked_dir(vec2<u32>(in(0u), in(1u))); sout(0u, d.x); sout(1u, d.y); sout(2u, d.z);",
        rust: |w| w[2..].to_vec(),
    };
    let edges = [-32_768, -32_767, -16_385, -16_384, -1, 0, 1, 16_383, 16_384, 32_767, 32_768];
    let mut cases = Vec::new();
    for dir in (0..edges.len().pow(3)).map(|i| [i % 11, i / 11 % 11, i / 121].map(|k| edges[k])) {
        cases.extend(dir_words(dir));
        cases.extend(dir.map(|c| c as u32));
    }
    check(&device, &twin, &cases);
}

#[test]
fn whole_floats_become_the_integers_that_they_are() {
    let Some(choice) = common::adapter() else { return };
    let device = open(&choice).unwrap_or_else(|e| panic!("{e}"));
    const MOST: i32 = 1 << 22;
    let whole = Twin {
        name: "integer",
        inputs: 1,
        outputs: 3,
        wgsl: "let x = bitcast<f32>(in(0u));
               let two = integer2(vec2<f32>(x, x));
               let three = integer3(vec3<f32>(x));
               sout(0u, integer(x));
               sout(1u, select(0, two.x, two.x == two.y));
               sout(2u, select(0, three.x, all(three == vec3<i32>(three.y))));",
        rust: |w| vec![f32::from_bits(w[0]) as i32 as u32; 3],
    };
    let edges = [-MOST, 1 - MOST, -65_537, -1, 0, 1, 4095, 65_536, MOST - 1, MOST];
    let mut random = Random(1);
    let numbers = edges.into_iter().chain((0..20_000).map(|_| random.between(-MOST, MOST)));
    check(&device, &whole, &numbers.map(|n| (n as f32).to_bits()).collect::<Vec<_>>());
}

#[test]
fn no_function_is_left_out() {
    let source = include_str!("../../shaders/march.wgsl");
    let functions = source.lines().filter_map(|line| line.strip_prefix("fn ")?.split('(').next());
    let twins =
        concat!(include_str!("../../src/march/march.rs"), include_str!("../../src/march/march/leap.rs"));
    for function in
        functions.filter(|name| !name.ends_with('3') && !name.ends_with("3_q16") && *name != "vec3_of")
    {
        assert!(
            TWINS.iter().any(|twin| twin.name == function),
            "shaders/march.wgsl: {function} has no twin test"
        );
        assert!(twins.contains(&format!("pub fn {function}(")), "src/march has no {function}");
    }
}

#[test]
fn a_broken_kernel_is_an_error_not_a_panic() {
    let Some(choice) = common::adapter() else { return };
    let device = open(&choice).unwrap_or_else(|e| panic!("{e}"));
    for broken in ["fn main() { nonsense }", "@compute @workgroup_size(1) fn other() {}"] {
        let failed = evaluate(&device, shader_prelude() + broken, &[0], 1, 1);
        assert!(matches!(failed, Err(perirobot_march::Error::Device(_))), "{broken}: {failed:?}");
    }
    // And the device still works.
    check(&device, &TWINS[2], &[0, 1, 2, 3]);
}
