//! Requests that count: scores, verdicts, reasons, pictures and the cell itself.

use std::collections::HashMap;
use std::io::Write;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard};

use glam::DVec3;
use perirobot_march::metrics::Confusion;
use perirobot_march::progress::Progress;
use perirobot_scene::pose::Pose;
use perirobot_study::input::{Planned, PlannedAt, Study};
use serde::Deserialize;
use serde_json::json;

use super::plan::{check_dead, no_moment, no_sensor, place_on_link, plan_of};
use super::{Answer, GIVES_WAY, LINES, Ready, Refused, STOPPED, Session, json_of, locked, number, read};
use crate::answers::{
    CellAnswer, JudgeReply, MomentsReply, SceneryReply, ScoreQuestion, ScoreReply, VoxelWord, WhyReply,
};
use crate::live::{Live, Resolution, ScoreRequest};
use crate::server::{Request, Response};

#[derive(Deserialize)]
struct WhyQuestion {
    #[serde(default)]
    n: u64,
    moment: usize,
    at_m: [f64; 3],
}

#[derive(Deserialize)]
struct JudgeQuestion {
    #[serde(default)]
    n: u64,
    #[serde(default)]
    dead: Option<usize>,
    /// Which window of the page asks.
    #[serde(default)]
    window: u64,
}

impl Session<'_> {
    pub(super) fn scenery(&self, request: &Request) -> Answer<'_> {
        let moment = number(request, "moment")?;
        json_of(&SceneryReply::new(&self.lock_ready().parts()?.0.scenery(moment)?))
    }

    pub(super) fn cell(&self, request: &Request) -> Answer<'_> {
        let moment = number(request, "moment")?;
        let wanted = match request.value("voxel") {
            Some("coarse") => Resolution::Coarse,
            _ => Resolution::Fine,
        };
        let mut ready = self.lock_ready();
        let (live, _) = ready.parts()?;
        let resolution = possible(live, wanted);
        let worlds = live.worlds(resolution)?;
        let world = worlds.get(moment).ok_or_else(|| no_moment(moment, worlds.len()))?;
        json_of(&CellAnswer::new(world))
    }

    pub(super) fn eye(&self, request: &Request) -> Answer<'_> {
        let (index, moment) = (number(request, "index")?, number(request, "moment")?);
        let mut ready = self.lock_ready();
        let (live, loaded) = ready.parts()?;
        let plan = plan_of(loaded, None, None)?;
        if index >= plan.len() {
            return Err(no_sensor(index, plan.len()));
        }
        Ok(Response::new(200, "image/png", live.eye(&plan, index, moment)?))
    }

    /// What each listed pose of a sensor would see alone, a line each as it is counted. Whatever a person does goes first.
    pub(super) fn listed(&self, request: &Request) -> Answer<'_> {
        let [sensor, moment, region] = ["sensor", "moment", "region"].map(|key| number(request, key));
        let (sensor, moment, region) = (sensor?, moment?, region?);
        let loaded = self.lock_ready().parts()?.1.clone();
        if region >= loaded.study.regions.len() || moment >= loaded.worlds.len() {
            return Err(Refused(400, "there is no such region or moment".into()));
        }
        // An edit may have taken the sensor away while the question was on its way: then nothing is listed.
        let candidates = loaded.study.sensors.get(sensor).map_or(&[][..], |sensor| &sensor.candidates);
        let names: Vec<String> = candidates.iter().map(|candidate| candidate.name.clone()).collect();
        let stream = move |out: &mut dyn Write| {
            for (pose, name) in names.iter().enumerate() {
                let Some(mut ready) = self.lock_ready_at_rest(&loaded.study) else { return Ok(()) };
                let plan = vec![Planned { sensor, at: PlannedAt::Listed(pose) }];
                let resolution = possible(&mut ready.live, Resolution::Coarse);
                let ask = ScoreRequest { plan, moment, repeat: 0, resolution, dead: None };
                let counted = ready.live.score(&ask);
                drop(ready);
                let score = counted.ok().and_then(|answer| worth(answer.counts.get(region)?));
                writeln!(out, "{}", json!({ "pose": name, "score": score }))?;
            }
            Ok(())
        };
        Ok(Response::stream(LINES, stream))
    }

    /// Locks what is counted for background work on a study; `None` if another study was loaded, or the planner ends.
    fn lock_ready_at_rest(&self, study: &Arc<Study>) -> Option<MutexGuard<'_, Ready>> {
        while self.waiting.load(Ordering::Relaxed) > 0 {
            std::thread::sleep(GIVES_WAY);
        }
        let ready = locked(&self.ready);
        let is_same = ready.loaded.as_ref().is_some_and(|loaded| Arc::ptr_eq(&loaded.study, study));
        (is_same && !self.is_ending.load(Ordering::Relaxed)).then_some(ready)
    }

    pub(super) fn score(&self, request: &Request) -> Answer<'_> {
        let mut question: ScoreQuestion = read(request)?;
        let mut ready = self.lock_ready();
        let (live, loaded) = ready.parts()?;
        let plan = plan_of(loaded, question.r#move.as_ref(), Some(question.moment))?;
        check_dead(question.dead, &plan)?;
        let resolution = possible(live, question.voxel.resolution());
        if resolution == Resolution::Fine {
            question.voxel = VoxelWord::Fine;
        }
        let ask = ScoreRequest { plan, moment: question.moment, repeat: 0, resolution, dead: question.dead };
        let answer = live.score(&ask)?;
        // What each sensor adds: what is lost without it. Asked only of a plan at rest.
        let mut without = Vec::new();
        if question.r#move.is_none() && question.dead.is_none() && ask.plan.len() > 1 {
            for index in 0..ask.plan.len() {
                without.push(live.score(&ScoreRequest { dead: Some(index), ..ask.clone() })?.counts);
            }
        }
        let world = &live.worlds(resolution)?[question.moment];
        let places = ask.plan.iter().map(|planned| place_on_link(loaded, planned, question.moment));
        let places: Vec<Option<Pose>> = places.collect();
        json_of(&ScoreReply::new(&question, &answer, &without, (&loaded.study, world)).with_places(&places))
    }

    /// The counts of all moments.
    pub(super) fn moments(&self, request: &Request) -> Answer<'_> {
        let JudgeQuestion { n, dead, window } = read(request)?;
        self.while_newest((&self.countings, window), |ready, progress| {
            let (live, loaded) = ready.parts()?;
            let plan = plan_of(loaded, None, None)?;
            check_dead(dead, &plan)?;
            let moments = live.moments(&plan, dead, progress)?;
            json_of(&MomentsReply::new(n, &moments, &loaded.study))
        })
    }

    pub(super) fn judge(&self, request: &Request) -> Answer<'_> {
        let JudgeQuestion { n, dead, window } = read(request)?;
        self.while_newest((&self.judgings, window), |ready, progress| {
            let (live, loaded) = ready.parts()?;
            let plan = plan_of(loaded, None, None)?;
            check_dead(dead, &plan)?;
            let judged = live.judge(&plan, dead, progress)?;
            json_of(&JudgeReply::new(n, &judged, loaded.cell.budget, (&loaded.study, &loaded.worlds)))
        })
    }

    /// Runs a job that a newer request of the same window cancels. Requests that wait go first; then the job begins again.
    fn while_newest<'s>(
        &self,
        (asked, window): (&Mutex<HashMap<u64, u64>>, u64),
        work: impl Fn(&mut Ready, &dyn Progress) -> Result<Response<'s>, Refused>,
    ) -> Answer<'s> {
        let own = {
            let mut latest = locked(asked);
            let own = latest.entry(window).or_default();
            *own += 1;
            *own
        };
        let is_newest =
            || locked(asked).get(&window) == Some(&own) && !self.is_ending.load(Ordering::Relaxed);
        loop {
            let progress = || {
                let gives_way = self.waiting.load(Ordering::Relaxed) > 0;
                (!is_newest() || gives_way).then(|| "a newer question came".to_string())
            };
            match work(&mut locked(&self.ready), &progress) {
                Err(Refused(STOPPED, _)) if is_newest() => std::thread::sleep(GIVES_WAY),
                Err(Refused(STOPPED, _)) => return json_of(&json!({ "superseded": true })),
                done => return done,
            }
        }
    }

    pub(super) fn why(&self, request: &Request) -> Answer<'_> {
        let WhyQuestion { n, moment, at_m } = read(request)?;
        let mut ready = self.lock_ready();
        let (live, loaded) = ready.parts()?;
        let plan = plan_of(loaded, None, None)?;
        let answer = live.why(&plan, moment, DVec3::from_array(at_m))?;
        json_of(&WhyReply::new(n, &answer))
    }
}

/// How much a pose shows of a region: of people's voxels, if there are any, else of all.
fn worth(counts: &Confusion) -> Option<f64> {
    counts.human_seen().or_else(|| counts.unknown().map(|unknown| 1.0 - unknown))
}

/// The wanted voxels, or those of the study if a thin region or zone has none of the larger ones.
fn possible(live: &mut Live, wanted: Resolution) -> Resolution {
    match wanted == Resolution::Coarse && live.worlds(Resolution::Coarse).is_ok() {
        true => Resolution::Coarse,
        false => Resolution::Fine,
    }
}
