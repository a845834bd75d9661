//! A pad and a camera about the same three voxels, fused by both rules.

use super::*;
use crate::sensor::kinds::known_robot::KnownRobot;
use crate::sensor::kinds::pad::Pad;
use crate::sensor::prism::Prism;
use crate::sensor::{MEASURES, SWITCHES};
use perirobot_march::backend::{Backend, Fusion, Reading, VoxelScene, cpu::Cpu, oracle::Oracle};
use perirobot_march::voxel::People;

const ROW: u32 = 3;

/// The labels o, f and u of voxels 0, 1 and 2 of a row.
fn labels(fusion: Fusion, said: &[(&Planes, [i32; 2])]) -> String {
    let truth = empty([ROW, 1, 2], 1.0);
    let one = |x: u32| {
        let mut voxels = BitGrid::new(truth.grid.window());
        voxels.set([x as i32, 0, 1]);
        voxels
    };
    let scene = VoxelScene {
        shades: None,
        blockers: truth.blockers.clone(),
        over_time: None,
        window: truth.grid.window(),
        truth: BitGrid::clone(&truth.occupied),
        human: truth.human.clone(),
        robot: truth.robot.clone(),
        regions: (0..ROW).map(one).collect(),
        people: People::default(),
    };
    let uploads: Vec<_> = (0..).zip(said.iter().map(|(planes, _)| (*planes).clone())).collect();
    let job = (0..).zip(said).map(|(slot, (_, [hit, miss]))| Reading {
        slot,
        volume: None,
        hit: *hit,
        miss: *miss,
        presence: false,
    });
    let job: Vec<_> = job.collect();
    let backends: [Box<dyn Backend>; 2] = [Box::new(Oracle::default()), Box::new(Cpu::new(Some(1)).unwrap())];
    let [first, second] = backends.map(|mut backend| -> String {
        backend.tables(&[]).unwrap();
        backend.load(&scene).unwrap();
        backend.upload(uploads.clone()).unwrap();
        let counts = backend.score(fusion, std::slice::from_ref(&job)).unwrap().remove(0);
        counts
            .iter()
            .map(|c| {
                if c.fp == 1 {
                    'o'
                } else if c.tn == 1 {
                    'f'
                } else {
                    'u'
                }
            })
            .collect()
    });
    assert_eq!(first, second);
    first
}

/// A camera that calls voxel 0 occupied, voxel 1 free and knows nothing of voxel 2.
fn camera() -> Planes {
    let window = empty([ROW, 1, 2], 1.0).grid.window();
    let (mut occupied, mut free) = (BitGrid::new(window), BitGrid::new(window));
    occupied.set([0, 0, 1]);
    free.set([1, 0, 1]);
    Planes { occupied, free, hits: BitGrid::new(window) }
}

/// A pad under all three, with someone on it or not.
fn pad(pressed: bool) -> Planes {
    let mut truth = empty([ROW, 1, 2], 1.0);
    if pressed {
        put(&mut truth, Role::Human, &[[2, 0, 1]], None);
    }
    let pad = Pad {
        column: Prism::from_corners(DVec3::ZERO, DVec3::new(3.0, 1.0, 2.0)),
        tare: true,
        otherwise_free: true,
    };
    assert_eq!(pad.log_odds(0), SWITCHES);
    pad.claims(&facing(&truth, [0.0; 3], [1.0, 0.0, 0.0])).swap_remove(0).planes.unwrap()
}

#[test]
fn a_pad_and_a_camera() {
    let (camera, pressed, silent) = (&camera(), &pad(true), &pad(false));
    for order in [[0, 1], [1, 0]] {
        let fused = |fusion, pad| {
            let said = [(camera, MEASURES), (pad, SWITCHES)];
            labels(fusion, &order.map(|i: usize| said[i]))
        };
        // Occupied wins: the pad's people are everywhere; a silent pad frees what the camera did not see
        // occupied.
        assert_eq!(fused(Fusion::OccupiedWins, pressed), "ooo");
        assert_eq!(fused(Fusion::OccupiedWins, silent), "off");
        // 3511 − 405 > 0; 847 − 405 > 0: a silent pad does not erase what a camera saw.
        assert_eq!(fused(Fusion::Octomap, pressed), "ooo");
        assert_eq!(fused(Fusion::Octomap, silent), "off");
    }
    // Three silent sensors do: 847 − 3 · 405 < 0.
    let said = [(camera, MEASURES), (silent, SWITCHES), (silent, SWITCHES), (silent, SWITCHES)];
    assert_eq!(labels(Fusion::Octomap, &said), "fff");
    assert_eq!(labels(Fusion::OccupiedWins, &said), "off");
}

#[test]
fn the_known_robot_speaks_last_and_is_believed() {
    let mut truth = empty([ROW, 1, 2], 1.0);
    put(&mut truth, Role::Robot, &[[1, 0, 1]], None);
    let robot = &KnownRobot.claims(&station(&truth, Setting::Fixed)).swap_remove(0).planes.unwrap();
    let silent = &pad(false);
    let mut said = vec![(silent, SWITCHES); 9];
    assert_eq!(labels(Fusion::Octomap, &said), "fff");
    // The sum stops at −2000, so 3511 lifts it however many were silent.
    said.push((robot, KnownRobot.log_odds(0)));
    assert_eq!(labels(Fusion::Octomap, &said), "fof");
    assert_eq!(labels(Fusion::OccupiedWins, &said), "fof");
}
