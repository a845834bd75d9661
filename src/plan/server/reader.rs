//! Reads the requests of a connection: one after the other, each within its limits of size and time.

use std::io::{ErrorKind, Read};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use super::guard::{Fields, Guard};
use super::message::Request;
use super::refusal::Refusal;

/// Most bytes of a head.
pub(super) const MOST_HEAD: usize = 64 << 10;
/// Most header fields.
const MOST_FIELDS: usize = 100;
/// Most bytes of a body.
pub(super) const MOST_BODY: usize = 1 << 20;

/// What ends a connection.
#[derive(Debug)]
pub(super) enum End {
    /// Nobody is there any more, or nothing more is asked.
    Gone,
    /// A request that is not handled.
    Refused(Refusal),
}

impl From<Refusal> for End {
    fn from(refusal: Refusal) -> End {
        End::Refused(refusal)
    }
}

/// The bytes of a connection, read as they are needed.
pub(super) struct Reader<'a> {
    stream: &'a TcpStream,
    /// Read, but not used yet.
    bytes: Vec<u8>,
    /// How long a head may take, and how long its body.
    patience: Duration,
}

/// A request whose body is still to be read.
struct Head {
    request: Request,
    bytes: usize,
    body: usize,
    /// Whether another request may follow.
    keeps: bool,
}

impl<'a> Reader<'a> {
    pub(super) fn new(stream: &'a TcpStream, patience: Duration) -> Reader<'a> {
        Reader { stream, bytes: Vec::new(), patience }
    }

    /// Waits until something of the next request is there.
    pub(super) fn wait(&mut self, at_most: Duration) -> Result<(), End> {
        match self.bytes.is_empty() {
            true => self.more(Instant::now() + at_most).map_err(|_| End::Gone),
            false => Ok(()),
        }
    }

    /// The next request, if it may be answered, and whether another may follow it.
    pub(super) fn request(&mut self, guard: &Guard) -> Result<(Request, bool), End> {
        let until = Instant::now() + self.patience;
        let Head { mut request, bytes, body, keeps } = loop {
            if let Some(head) = parse(&self.bytes, guard)? {
                break head;
            }
            if self.bytes.len() >= MOST_HEAD {
                return Err(Refusal::Large("the head of a request has at most 64 KiB").into());
            }
            self.more(until)?;
        };
        let until = Instant::now() + self.patience;
        while self.bytes.len() < bytes + body {
            self.more(until)?;
        }
        request.body = self.bytes[bytes..bytes + body].to_vec();
        self.bytes.drain(..bytes + body);
        Ok((request, keeps))
    }

    /// Reads what has come, or waits for it.
    fn more(&mut self, until: Instant) -> Result<(), End> {
        let mut part = [0; 16 << 10];
        loop {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(Refusal::Slow.into());
            }
            self.stream.set_read_timeout(Some(left)).map_err(|_| End::Gone)?;
            match self.stream.read(&mut part) {
                Ok(0) => return Err(End::Gone),
                Ok(count) => {
                    self.bytes.extend_from_slice(&part[..count]);
                    return Ok(());
                }
                Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(_) => return Err(End::Gone),
            }
        }
    }
}

/// The head at the beginning of some bytes; none if it is not there as a whole.
fn parse(bytes: &[u8], guard: &Guard) -> Result<Option<Head>, Refusal> {
    let mut fields = [httparse::EMPTY_HEADER; MOST_FIELDS];
    let mut request = httparse::Request::new(&mut fields);
    let head = &bytes[..bytes.len().min(MOST_HEAD)];
    let bytes = match request.parse(head) {
        Ok(httparse::Status::Complete(bytes)) => bytes,
        Ok(httparse::Status::Partial) => return Ok(None),
        Err(httparse::Error::TooManyHeaders) => {
            return Err(Refusal::Large("a request has at most 100 headers"));
        }
        Err(httparse::Error::Version) => return Err(Refusal::Version),
        Err(_) => return Err(Refusal::Malformed("this is not a request of HTTP")),
    };
    if request.version != Some(1) {
        return Err(Refusal::Version);
    }
    let fields = Fields(request.headers);
    let body = body_length(&fields)?;
    let method = guard.check(&request)?;
    if body > MOST_BODY {
        return Err(Refusal::Large("the body of a request has at most 1 MiB"));
    }
    let is_close = |value: &[u8]| {
        value.split(|&byte| byte == b',').any(|word| word.trim_ascii().eq_ignore_ascii_case(b"close"))
    };
    let keeps = !fields.all("connection").any(is_close);
    let target = request.path.unwrap_or_default();
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    let request = Request { method, path: path.into(), query: query.into(), body: Vec::new() };
    Ok(Some(Head { request, bytes, body, keeps }))
}

/// How long the body is. What programs read in different ways is refused: where one request ends would be open.
fn body_length(fields: &Fields) -> Result<usize, Refusal> {
    let mut lengths = fields.all("content-length");
    let (length, another) = (lengths.next(), lengths.next());
    let is_coded = fields.all("transfer-encoding").next().is_some();
    match (length, another, is_coded) {
        (_, Some(_), _) => Err(Refusal::Malformed("Content-Length is there twice")),
        (Some(_), None, true) => Err(Refusal::Malformed("both Content-Length and Transfer-Encoding")),
        (None, None, true) => Err(Refusal::Length),
        (None, None, false) => Ok(0),
        (Some(digits), None, false) => {
            let is_number = !digits.is_empty() && digits.iter().all(u8::is_ascii_digit);
            let text = std::str::from_utf8(digits).ok().filter(|_| is_number);
            let text = text.ok_or(Refusal::Malformed("Content-Length is not a number"))?;
            Ok(text.parse().unwrap_or(usize::MAX))
        }
    }
}
