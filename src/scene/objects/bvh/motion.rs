//! The frames of a BVH file: lines of numbers, of which only those that are posed are read.

use std::ops::Range;

use super::hierarchy::numbers;
use perirobot_march::error::Issue;

/// The frames of a file, as text.
#[derive(Debug)]
pub(super) struct MotionFrames {
    text: String,
    /// The line of each frame, in bytes; at least one.
    frames: Vec<Range<usize>>,
    /// How many numbers a frame has.
    channels: usize,
    /// Between one frame and the next.
    frame_s: f64,
    /// Lines behind the frames that are declared.
    pub(super) behind: usize,
}

impl MotionFrames {
    /// The frames of a text, of which the first `from` bytes are the skeleton.
    pub(super) fn read(text: String, from: usize, channels: usize) -> Result<MotionFrames, Issue> {
        let mut at = from;
        let mut lines = text[from..].split_inclusive('\n').filter_map(|line| {
            let begin = at + (line.len() - line.trim_start().len());
            at += line.len();
            let line = line.trim();
            (!line.is_empty()).then_some((begin..begin + line.len(), line))
        });
        let mut value = |key: &str| {
            let line =
                lines.next().and_then(|(_, line)| line.strip_prefix(key)?.trim_start().strip_prefix(':'));
            line.map(str::trim).ok_or_else(|| Issue::damaged(format!("lacks `{key}:` behind MOTION")))
        };
        let frames = value("Frames")?;
        let seconds = value("Frame Time")?;
        let rule = |key: &str, value: &str, rule: &str| Err(Issue::value(key, format!("{value:.40}"), rule));
        let Some(count) = frames.parse::<usize>().ok().filter(|count| *count > 0) else {
            return rule("Frames", frames, "must be 1 or more");
        };
        // Of one frame, such as a pose, the time is often 0.
        let is_time = |seconds: &f64| (1e-6..=1e3).contains(seconds) || (count == 1 && *seconds == 0.0);
        let Some(frame_s) = seconds.parse::<f64>().ok().filter(is_time) else {
            return rule("Frame Time", seconds, "must be seconds from 0.000001 to 1000");
        };
        let mut frames: Vec<Range<usize>> = lines.map(|(line, _)| line).collect();
        if frames.len() < count {
            return Err(Issue::damaged(format!("has {} frames and declares {count}", frames.len()))
                .with_advice("each is a line: is it cut off?"));
        }
        let behind = frames.len() - count;
        frames.truncate(count);
        Ok(MotionFrames { text, frames, channels, frame_s, behind })
    }

    pub(super) fn span_s(&self) -> [f64; 2] {
        [0.0, (self.frames.len() - 1) as f64 * self.frame_s]
    }

    /// The numbers of the frame that is nearest to a time.
    pub(super) fn frame(&self, time_s: f64) -> Result<Vec<f64>, Issue> {
        let last = self.frames.len() - 1;
        // Without a time between frames there is one frame; a quotient that is no number is the first.
        let frame = ((time_s / self.frame_s).round().max(0.0) as usize).min(last);
        let line = &self.text[self.frames[frame].clone()];
        numbers(line).filter(|numbers| numbers.len() == self.channels).ok_or_else(|| {
            let what = format!("frame {frame} is no line of {} numbers", self.channels);
            Issue::damaged(what).with_advice("its bones have as many channels")
        })
    }
}
