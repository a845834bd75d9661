//! Requests that the handler answers, each in a thread of its own, as counting takes long.

use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::Pin;
use std::task::{Context, Poll};

use hyper::body::{Body as HttpBody, Bytes, Frame, SizeHint};
use perirobot_march::error::describe_panic;
use tokio::sync::{mpsc, oneshot};

use super::connections::POLICY;
use super::message::{Body, Request, Response, Stream};

/// A response as it is sent.
pub(super) type Sent = hyper::Response<Parts>;

/// A request that was let in, and where its response goes.
pub(super) struct Job {
    pub(super) request: Request,
    pub(super) reply: oneshot::Sender<Sent>,
}

impl Job {
    /// Answers the request. If the handler panics, with its words.
    pub(super) fn answer<'h>(self, handler: &impl Fn(&Request) -> Response<'h>) {
        let Job { request, reply } = self;
        let response = catch_unwind(AssertUnwindSafe(|| handler(&request))).unwrap_or_else(|panic| {
            let words = describe_panic(panic.as_ref());
            log::error!("{}: {words}", request.path);
            Response::error(500, &format!("a fault of perirobot itself: it {words}"))
        });
        let (sent, stream) = begin(response);
        // A reader that has gone needs neither head nor body.
        if reply.send(sent).is_ok()
            && let Some((write, mut parts)) = stream
        {
            let written = catch_unwind(AssertUnwindSafe(|| write(&mut parts)));
            let written =
                written.unwrap_or_else(|panic| Err(io::Error::other(describe_panic(panic.as_ref()))));
            // Without the end of the body the page sees that something is missing.
            if let Err(error) = written {
                let _ = parts.0.blocking_send(Err(error));
            }
        }
    }
}

/// A response as it is sent. A stream is left to be written.
pub(super) fn begin(response: Response<'_>) -> (Sent, Option<(Stream<'_>, PartWriter)>) {
    let Response { status, content_type, body, policy } = response;
    let (sender, receiver) = mpsc::channel(1);
    let (length, stream) = match body {
        Body::Whole(bytes) => {
            let length = bytes.len() as u64;
            sender.try_send(Ok(bytes.into())).expect("it has room for one");
            (Some(length), None)
        }
        Body::Stream(write) => (None, Some((write, PartWriter(sender)))),
    };
    let head = hyper::Response::builder().status(status).header("content-type", content_type);
    let head = if status == 405 { head.header("allow", "GET, POST") } else { head };
    let head = if let Some(policy) = policy { head.header(POLICY, policy) } else { head };
    (head.body(Parts { receiver, length }).expect("a status and a type"), stream)
}

/// A body that is sent as its parts come.
pub(super) struct Parts {
    receiver: mpsc::Receiver<io::Result<Bytes>>,
    length: Option<u64>,
}

impl HttpBody for Parts {
    type Data = Bytes;
    type Error = io::Error;

    fn poll_frame(mut self: Pin<&mut Self>, cx: &mut Context) -> Poll<Option<io::Result<Frame<Bytes>>>> {
        self.receiver.poll_recv(cx).map(|part| part.map(|part| part.map(Frame::data)))
    }

    fn size_hint(&self) -> SizeHint {
        self.length.map_or_else(SizeHint::default, SizeHint::with_exact)
    }
}

/// Sends the parts of a stream.
pub(super) struct PartWriter(mpsc::Sender<io::Result<Bytes>>);

impl Write for PartWriter {
    fn write(&mut self, part: &[u8]) -> io::Result<usize> {
        let sent = self.0.blocking_send(Ok(Bytes::copy_from_slice(part)));
        sent.map(|()| part.len()).map_err(io::Error::other)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
