//! What is in the chunks of an MCAP file: whole, or packed by lz4 or zstd. The unpackers are written in Rust, so that
//! whoever builds this needs no compiler of C.

use std::borrow::Cow;
use std::io::Read;

use mcap::records::ChunkHeader;
use ruzstd::decoding::{
    StreamingDecoder,
    errors::{FrameDecoderError, ReadFrameHeaderError},
};

use super::bag::LONGEST_RECORD;
use crate::error::Issue;

/// The records of a chunk, unpacked. A damaged one makes room for no more than it holds.
pub(super) fn unpacked<'d>(header: &ChunkHeader, packed: Cow<'d, [u8]>) -> Result<Cow<'d, [u8]>, Issue> {
    let damaged = |what: String| Issue::damaged(format!("is no whole MCAP file: {what}"));
    let size = header.uncompressed_size;
    if size > LONGEST_RECORD as u64 {
        return Err(damaged(format!("a chunk of {size} bytes")));
    }
    let unpacked = match header.compression.as_str() {
        "" => packed,
        "lz4" => Cow::Owned(read(lz4_flex::frame::FrameDecoder::new(&*packed), size).map_err(damaged)?),
        "zstd" => Cow::Owned(of_zstd(&packed, size).map_err(damaged)?),
        other => {
            return Err(Issue::unsupported(format!("its chunks are packed by {other:?}"))
                .wanted("record it with lz4, zstd or no compression"));
        }
    };
    match unpacked.len() as u64 == size {
        true => Ok(unpacked),
        false => Err(damaged(format!("a chunk of {size} bytes has {}", unpacked.len()))),
    }
}

/// All that a decoder gives, at most one byte more than is wanted.
fn read(decoder: impl Read, size: u64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    decoder.take(size + 1).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    Ok(bytes)
}

/// The frames of zstd one after the other; those to be skipped hold nothing.
fn of_zstd(mut packed: &[u8], size: u64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    while !packed.is_empty() {
        match StreamingDecoder::new(&mut packed) {
            Ok(frame) => bytes.extend(read(frame, size.saturating_sub(bytes.len() as u64))?),
            Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                length, ..
            })) => {
                packed = packed.get(length as usize..).ok_or("a frame ends early")?;
            }
            Err(e) => return Err(e.to_string()),
        }
    }
    Ok(bytes)
}
