//! Buffers on the device that are kept from use to use.

use super::device::GpuDevice;

/// A buffer that is kept, and grows when more is asked of it; then it forgets what it held.
pub(super) struct GrowingBuffer {
    label: &'static str,
    usage: wgpu::BufferUsages,
    buffer: Option<wgpu::Buffer>,
}

impl GrowingBuffer {
    /// For storage that the host can clear, write and read.
    pub(super) fn storage(label: &'static str) -> Self {
        use wgpu::BufferUsages as Usage;
        GrowingBuffer { label, usage: Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC, buffer: None }
    }

    /// For storage that tells dispatches how many workgroups they have.
    pub(super) fn indirect(label: &'static str) -> Self {
        use wgpu::BufferUsages as Usage;
        GrowingBuffer { label, usage: Usage::STORAGE | Usage::INDIRECT | Usage::COPY_DST, buffer: None }
    }

    /// For uniforms that the host can write.
    pub(super) fn uniform(label: &'static str) -> Self {
        use wgpu::BufferUsages as Usage;
        GrowingBuffer { label, usage: Usage::UNIFORM | Usage::COPY_DST, buffer: None }
    }

    /// The buffer, of at least so many bytes.
    pub(super) fn hold(&mut self, device: &GpuDevice, bytes: u64) -> wgpu::Buffer {
        // The old one goes first, so that both need not fit side by side.
        let kept = self.buffer.take().filter(|buffer| buffer.size() >= bytes);
        let buffer = kept.unwrap_or_else(|| device.buffer(self.label, bytes, self.usage));
        self.buffer.insert(buffer).clone()
    }

    /// The buffer with `data` written to its beginning.
    pub(super) fn fill<T: bytemuck::NoUninit>(&mut self, device: &GpuDevice, data: &[T]) -> wgpu::Buffer {
        let buffer = self.hold(device, size_of_val(data).max(size_of::<T>()) as u64);
        device.write(&buffer, 0, data);
        buffer
    }
}

/// A storage buffer whose words are remembered: if the next scene has the same, they are not written again.
pub(super) struct RememberedBuffer {
    room: GrowingBuffer,
    words: Remembered,
}

impl RememberedBuffer {
    /// Nothing is written yet.
    pub(super) fn new(label: &'static str) -> Self {
        RememberedBuffer { room: GrowingBuffer::storage(label), words: Remembered::default() }
    }

    /// The buffer, which begins with these words.
    pub(super) fn hold(&mut self, device: &GpuDevice, words: &[u32]) -> wgpu::Buffer {
        match self.words.replace(words) {
            true => self.room.fill(device, words),
            false => self.room.hold(device, size_of_val(words) as u64),
        }
    }
}

/// The words that were written last, if any were.
#[derive(Default)]
struct Remembered(Option<Vec<u32>>);

impl Remembered {
    /// Remembers other words; whether they are others.
    fn replace(&mut self, words: &[u32]) -> bool {
        let is_new = self.0.as_deref() != Some(words);
        if is_new {
            let kept = self.0.get_or_insert_default();
            kept.clear();
            kept.extend_from_slice(words);
        }
        is_new
    }
}

#[cfg(test)]
mod tests {
    use super::Remembered;

    #[test]
    fn only_other_words_are_written() {
        let mut remembered = Remembered::default();
        let all: [&[u32]; 8] = [&[], &[], &[1, 2], &[1, 2], &[1], &[1, 2], &[2, 2], &[]];
        let is_new = all.map(|words| remembered.replace(words));
        assert_eq!(is_new, [true, false, true, false, true, true, true, true]);
    }
}
