//! A kernel's pass through a batch: its pipeline, what it is bound to, and how it is dispatched.

use super::device::GpuDevice;
use super::kernels::Stage;
use super::pipeline::{Groups, Pipeline};
use super::plan::Dispatch;
use super::types::HEAD_WORDS;

/// A kernel and the buffers that it sees in all dispatches of a batch.
pub(super) struct Pass {
    stage: Stage,
    /// The region that it counts, if each region has its own pass.
    region: Option<u32>,
    pipeline: Pipeline,
    bound: wgpu::BindGroup,
    /// The heads in which the device writes how many workgroups each dispatch has, if it decides that.
    heads: Option<wgpu::Buffer>,
}

impl Pass {
    /// Binds buffers to the pipeline of a stage, in the order of its bindings.
    pub(super) fn new(
        device: &GpuDevice,
        stage: Stage,
        pipeline: &Pipeline,
        buffers: &[&wgpu::Buffer],
    ) -> Self {
        let bound = pipeline.bind(device, buffers);
        Pass { stage, region: None, pipeline: pipeline.clone(), bound, heads: None }
    }

    /// The same for the dispatches of one region only.
    pub(super) fn with_region(self, region: u32) -> Self {
        Pass { region: Some(region), ..self }
    }

    /// The same with as many workgroups a dispatch as its head in a buffer has.
    pub(super) fn with_heads(self, heads: &wgpu::Buffer) -> Self {
        Pass { heads: Some(heads.clone()), ..self }
    }

    /// Whether a dispatch is one of this pass.
    pub(super) fn includes(&self, dispatch: &Dispatch) -> bool {
        self.stage == dispatch.stage && self.region.is_none_or(|region| region == dispatch.part.region)
    }

    /// Records a dispatch, whose part begins at `offset`. `stamps` says where to write when it began and ended.
    pub(super) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        dispatch: &Dispatch,
        offset: u32,
        stamps: Option<wgpu::ComputePassTimestampWrites>,
    ) {
        let groups = match dispatch.head().zip(self.heads.as_ref()) {
            Some((head, heads)) => Groups::In(heads, u64::from(head * HEAD_WORDS) * 4),
            None => Groups::Known(dispatch.groups),
        };
        self.pipeline.dispatch(encoder, &self.bound, Some(offset), groups, stamps);
    }
}
