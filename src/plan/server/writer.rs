//! Sends responses, with the rules that keep a browser from showing them elsewhere.

use std::fmt::Write as _;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use perirobot_march::error::describe_panic;

use super::message::{Body, Response};

/// How long a reader may make a response wait.
pub(super) const WRITE_PATIENCE: Duration = Duration::from_secs(10);
/// How long, and of how many bytes, what a refused request goes on to send is taken, so that it can read its response.
const LINGER: Duration = Duration::from_millis(500);
const MOST_LINGER: usize = 8 << 20;

/// Sends a response. `policy` is the Content-Security-Policy.
pub(super) fn send(stream: &TcpStream, response: Response, policy: &str, keeps: bool) -> io::Result<()> {
    let Response { status, content_type, body } = response;
    let mut head = format!("HTTP/1.1 {status} {}\r\nContent-Type: {content_type}\r\n", reason(status));
    let rules = [
        ("Content-Security-Policy", policy),
        ("X-Content-Type-Options", "nosniff"),
        ("Cache-Control", "no-store"),
        ("Referrer-Policy", "no-referrer"),
        ("Cross-Origin-Resource-Policy", "same-origin"),
        ("Cross-Origin-Opener-Policy", "same-origin"),
        ("Connection", if keeps { "keep-alive" } else { "close" }),
    ];
    for (name, value) in rules {
        let _ = write!(head, "{name}: {value}\r\n");
    }
    if status == 405 {
        head += "Allow: GET, POST\r\n";
    }
    let mut stream = stream;
    match body {
        Body::Whole(bytes) => {
            let _ = write!(head, "Content-Length: {}\r\n\r\n", bytes.len());
            let mut all = head.into_bytes();
            all.extend(bytes);
            stream.write_all(&all)
        }
        Body::Stream(write) => {
            head += "Transfer-Encoding: chunked\r\n\r\n";
            stream.write_all(head.as_bytes())?;
            let mut chunks = Chunks(stream);
            // The end of the last chunk is left out after a failure, so that the page sees that something is missing.
            let written = catch_unwind(AssertUnwindSafe(|| write(&mut chunks)));
            written.unwrap_or_else(|panic| Err(io::Error::other(describe_panic(panic.as_ref()))))?;
            stream.write_all(b"0\r\n\r\n")
        }
    }
}

/// Ends a connection after a last response, which is lost if bytes are left unread.
pub(super) fn close(stream: &TcpStream) {
    let until = Instant::now() + LINGER;
    let _ = stream.shutdown(Shutdown::Write);
    let (mut reader, mut part, mut left) = (stream, [0; 16 << 10], MOST_LINGER);
    while left > 0 {
        let wait = until.saturating_duration_since(Instant::now());
        if wait.is_zero() || stream.set_read_timeout(Some(wait)).is_err() {
            return;
        }
        match reader.read(&mut part) {
            Ok(count) if count > 0 => left = left.saturating_sub(count),
            _ => return,
        }
    }
}

/// Parts of a body, each with its length before it.
struct Chunks<'a>(&'a TcpStream);

impl Write for Chunks<'_> {
    fn write(&mut self, part: &[u8]) -> io::Result<usize> {
        // A chunk of length 0 would be the last.
        if !part.is_empty() {
            let mut chunk = format!("{:x}\r\n", part.len()).into_bytes();
            chunk.extend_from_slice(part);
            chunk.extend_from_slice(b"\r\n");
            self.0.write_all(&chunk)?;
        }
        Ok(part.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn reason(status: u16) -> &'static str {
    match status {
        200 => "OK",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        409 => "Conflict",
        411 => "Length Required",
        413 => "Content Too Large",
        422 => "Unprocessable Content",
        500 => "Internal Server Error",
        503 => "Service Unavailable",
        505 => "HTTP Version Not Supported",
        _ => "Other",
    }
}
