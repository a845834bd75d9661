//! What is in the chunks of an MCAP file: whole, or packed by lz4 or zstd. The unpackers are written in Rust, so that
//! whoever builds this needs no compiler of C.

use std::borrow::Cow;
use std::io::Read;

use mcap::records::ChunkHeader;

use perirobot_march::error::Issue;

/// The longest record that is read, as a file may not be longer: a damaged length must not ask for all memory.
pub(super) const LONGEST_RECORD: usize = 1 << 30;

/// The records of a chunk, unpacked. A damaged one makes room for no more than it holds.
pub(super) fn unpack<'d>(header: &ChunkHeader, packed: Cow<'d, [u8]>) -> Result<Cow<'d, [u8]>, Issue> {
    let damaged = |what: String| Issue::damaged(format!("is no whole MCAP file: {what}"));
    let size = header.uncompressed_size;
    if size > LONGEST_RECORD as u64 {
        return Err(Issue::too_large(format!("has a chunk of {size} bytes"))
            .with_advice(format!("record it in chunks of {LONGEST_RECORD} bytes at most")));
    }
    let unpacked = match header.compression.as_str() {
        "" => packed,
        "lz4" => Cow::Owned(frames(&packed, size, unpack_lz4).map_err(damaged)?),
        "zstd" => Cow::Owned(frames(&packed, size, unpack_zstd).map_err(damaged)?),
        other => {
            return Err(Issue::unsupported(format!("its chunks are packed by {other:?}"))
                .with_advice("record it with lz4, zstd or no compression"));
        }
    };
    if unpacked.len() as u64 != size {
        return Err(damaged(format!("a chunk of {size} bytes has {}", unpacked.len())));
    }
    // 0 stands for a sum that nobody made.
    match header.uncompressed_crc {
        0 => Ok(unpacked),
        sum if crc32fast::hash(&unpacked) == sum => Ok(unpacked),
        _ => Err(damaged("a chunk has another checksum than is written".into())),
    }
}

/// What became of a frame.
enum ChunkFrame {
    Read,
    /// So many bytes that follow hold nothing.
    Skip(usize),
}

/// Takes the next frame of packed bytes, and appends what it holds, to one byte more than is left to be read at most.
type TakeFrame = fn(packed: &mut &[u8], left: u64, bytes: &mut Vec<u8>) -> Result<ChunkFrame, String>;

/// Frames one after the other, until there is enough; what comes behind is padding.
fn frames(mut packed: &[u8], size: u64, take: TakeFrame) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    while !packed.is_empty() && (bytes.len() as u64) < size {
        let left = size - bytes.len() as u64;
        if let ChunkFrame::Skip(length) = take(&mut packed, left, &mut bytes)? {
            packed = packed.get(length..).ok_or("a frame ends early")?;
        }
    }
    Ok(bytes)
}

fn unpack_lz4(packed: &mut &[u8], left: u64, bytes: &mut Vec<u8>) -> Result<ChunkFrame, String> {
    use lz4_flex::frame::{Error, FrameDecoder};
    match FrameDecoder::new(packed).take(left + 1).read_to_end(bytes) {
        Ok(_) => Ok(ChunkFrame::Read),
        Err(e) => match e.get_ref().and_then(|e| e.downcast_ref()) {
            Some(&Error::SkippableFrame(length)) => Ok(ChunkFrame::Skip(length as usize)),
            _ => Err(e.to_string()),
        },
    }
}

fn unpack_zstd(packed: &mut &[u8], left: u64, bytes: &mut Vec<u8>) -> Result<ChunkFrame, String> {
    use ruzstd::decoding::{StreamingDecoder, errors::FrameDecoderError, errors::ReadFrameHeaderError};
    match StreamingDecoder::new(packed) {
        Ok(frame) => match frame.take(left + 1).read_to_end(bytes) {
            Ok(_) => Ok(ChunkFrame::Read),
            Err(e) => Err(e.to_string()),
        },
        Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame { length, .. })) => {
            Ok(ChunkFrame::Skip(length as usize))
        }
        Err(e) => Err(e.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn header(compression: &str, size: usize, uncompressed_crc: u32) -> ChunkHeader {
        ChunkHeader {
            message_start_time: 0,
            message_end_time: 0,
            uncompressed_size: size as u64,
            uncompressed_crc,
            compression: compression.into(),
            compressed_size: 0,
        }
    }

    fn lz4(bytes: &[u8]) -> Vec<u8> {
        let mut packer = lz4_flex::frame::FrameEncoder::new(Vec::new());
        packer.write_all(bytes).unwrap();
        packer.finish().unwrap()
    }

    /// A frame that holds its bytes as they are.
    fn zstd(bytes: &[u8]) -> Vec<u8> {
        let block = (bytes.len() as u32) << 3 | 1;
        [&[0x28, 0xb5, 0x2f, 0xfd, 0x20, bytes.len() as u8][..], &block.to_le_bytes()[..3], bytes].concat()
    }

    /// A frame of either that holds nothing.
    const SKIPPED: [u8; 11] = [0x50, 0x2a, 0x4d, 0x18, 3, 0, 0, 0, 7, 7, 7];

    #[test]
    fn several_frames_are_read_and_what_is_behind_them_is_not() {
        for (name, pack) in [("lz4", lz4 as fn(&[u8]) -> Vec<u8>), ("zstd", zstd)] {
            let packed = [&pack(b"one ")[..], &SKIPPED, &pack(b"and two"), b"padding"].concat();
            let read = |size, crc| unpack(&header(name, size, crc), packed.as_slice().into());
            assert_eq!(&*read(11, 0).unwrap(), b"one and two", "{name}");
            assert_eq!(&*read(11, crc32fast::hash(b"one and two")).unwrap(), b"one and two", "{name}");
            for (size, crc, expected) in [
                (11, 5, "another checksum"),
                (10, 0, "a chunk of 10 bytes has 11"),
                (12, 0, "no whole MCAP file"),
                (LONGEST_RECORD + 1, 0, "has a chunk of 1073741825 bytes"),
            ] {
                let told = perirobot_march::Error::from(read(size, crc).unwrap_err()).to_string();
                assert!(told.contains(expected), "{name}: {told}");
            }
            let cut = unpack(&header(name, 4, 0), pack(b"one ")[..9].to_vec().into());
            assert!(cut.is_err(), "{name}");
        }
        let told =
            perirobot_march::Error::from(unpack(&header("brotli", 1, 0), b"x"[..].into()).unwrap_err());
        assert!(told.to_string().contains("packed by \"brotli\""), "{told}");
    }
}
