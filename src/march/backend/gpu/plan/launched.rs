//! Whether all workgroups of some dispatches ran, and all of their loops to the end.

use super::Dispatch;
use crate::Result;
use crate::backend::gpu::kernels::Stage;
use crate::backend::gpu::loop_bounds::WORKGROUP;
use crate::error::{Argument, Issue, Words};

/// Workgroups launched since the last check, a counter a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::backend::gpu) struct Launched([u64; Stage::ALL.len()]);

impl Launched {
    /// Dispatches were submitted.
    pub(in crate::backend::gpu) fn add(&mut self, dispatches: &[Dispatch]) {
        for dispatch in dispatches {
            self.0[dispatch.stage as usize] += dispatch.workgroups();
        }
    }

    /// Compares the workgroups launched with those that came to their end, and their invocations with those
    /// whose loops did.
    pub(in crate::backend::gpu) fn check(&self, done: &[u32]) -> Result<(), Issue> {
        let (groups, whole) = done.split_at(self.0.len());
        let distrusted = |what: String| {
            Issue::damaged(format!("{what}, so its counts cannot be trusted"))
                .cure(Words::from("use another adapter, or ") + Argument("backend").quote("cpu"))
        };
        for stage in Stage::ALL {
            let (name, launched, ended) = (stage.name(), self.0[stage as usize], groups[stage as usize]);
            // The device counts in 32 bits.
            if ended != launched as u32 {
                return Err(distrusted(format!(
                    "incomplete dispatch: {ended} of {launched} workgroups of `{name}` ran to their end"
                )));
            }
            let (launched, ended) = (launched * u64::from(WORKGROUP), whole[stage as usize]);
            if ended != launched as u32 {
                return Err(distrusted(format!(
                    "loops cut short: in {ended} of {launched} invocations of `{name}` all loops ended by their own \
                     condition, the driver ended others early"
                )));
            }
        }
        Ok(())
    }
}
