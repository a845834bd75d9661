//! A server of HTTP for one page on this machine. It listens on 127.0.0.1 only, answers only who shows the token, and
//! knows nothing of studies. The messages are parsed by `httparse`; what is written here are the rules of who may ask
//! ([`guard`]), the limits, and keep-alive.

mod connections;
mod guard;
mod message;
mod reader;
mod refusal;
mod writer;

#[cfg(test)]
mod tests;

use std::io::ErrorKind;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use perirobot_march::error::{Issue, describe_panic};
use perirobot_march::{Error, Result};
use perirobot_scene::source::hex;

use connections::Connections;
use guard::Guard;
pub use guard::TOKEN_HEADER;
pub use message::{Body, Method, Request, Response, Stream};
use reader::{End, Reader};
use refusal::Refusal;

/// How long a head may take from its first byte, and how long its body.
const PATIENCE: Duration = Duration::from_secs(10);
/// How long a connection may be idle.
const REST: Duration = Duration::from_secs(120);
/// How long to wait after the system had no room for a connection.
const PAUSE: Duration = Duration::from_millis(50);
/// What pages may do that bring no policy: nothing.
const NO_POLICY: &str = "default-src 'none'; frame-ancestors 'none'";

/// A port on 127.0.0.1, and the token that requests must show.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    guard: Guard,
    policy: String,
    patience: Duration,
    connections: Arc<Connections>,
}

/// Ends a server from another thread.
#[derive(Clone)]
pub struct Stop {
    address: SocketAddr,
    connections: Arc<Connections>,
}

impl Stop {
    /// Ends the server: idle connections are closed, and responses on their way are sent to their end.
    pub fn stop(&self) {
        self.connections.stop();
        // The server waits for a connection, and sees only then that it is to end.
        let _ = TcpStream::connect_timeout(&self.address, PATIENCE);
    }
}

impl Server {
    /// Opens a port; 0 is any that is free.
    ///
    /// # Errors
    /// If the port is taken, or the system has no random numbers.
    pub fn bind(port: u16) -> Result<Server> {
        let refused = |e: std::io::Error| {
            let issue = Issue::io("cannot be opened", &e).with_place(format!("port {port}"));
            let issue = issue.with_advice("take another port, or 0 for any that is free");
            match e.kind() {
                ErrorKind::AddrInUse => Error::Busy(issue),
                _ => Error::Input(issue),
            }
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(refused)?;
        let address = listener.local_addr().map_err(refused)?;
        Ok(Server {
            guard: Guard::new(address.port(), new_token()?),
            listener,
            address,
            policy: NO_POLICY.into(),
            patience: PATIENCE,
            connections: Arc::default(),
        })
    }

    /// The same with the Content-Security-Policy of its page, which has the hashes of its script and its style.
    #[must_use]
    pub fn with_policy(mut self, policy: impl Into<String>) -> Server {
        self.policy = policy.into();
        self
    }

    /// The same with less time for a head and a body.
    #[cfg(test)]
    fn with_patience(mut self, patience: Duration) -> Server {
        self.patience = patience;
        self
    }

    /// The port.
    pub fn port(&self) -> u16 {
        self.address.port()
    }

    /// What every request but that of the page must have in the header [`TOKEN_HEADER`]: 128 random bits.
    pub fn token(&self) -> &str {
        self.guard.token()
    }

    /// The address of the page. The token is in its fragment, which browsers neither send nor log.
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/#{}", self.port(), self.token())
    }

    /// A handle that ends it.
    pub fn stopper(&self) -> Stop {
        Stop { address: self.address, connections: self.connections.clone() }
    }

    /// Answers requests until it is stopped, those of several connections at a time.
    pub fn run<'h>(&self, handler: impl Fn(&Request) -> Response<'h> + Sync) {
        thread::scope(|scope| {
            for stream in self.listener.incoming() {
                if self.connections.is_stopped() {
                    break;
                }
                let Ok(stream) = stream else {
                    thread::sleep(PAUSE);
                    continue;
                };
                let _ = stream.set_nodelay(true);
                let _ = stream.set_write_timeout(Some(writer::WRITE_PATIENCE));
                let Some(id) = self.connections.add(&stream) else {
                    let _ = writer::send(&stream, Refusal::Crowded.to_response(), &self.policy, false);
                    continue;
                };
                let handler = &handler;
                scope.spawn(move || {
                    self.serve(&stream, id, handler);
                    self.connections.remove(id);
                });
            }
        });
    }

    /// Answers the requests of one connection.
    fn serve<'h>(&self, stream: &TcpStream, id: u64, handler: &(impl Fn(&Request) -> Response<'h> + Sync)) {
        let mut reader = Reader::new(stream, self.patience);
        let mut rest = self.patience;
        while self.connections.rest(id) && reader.wait(rest).is_ok() && self.connections.wake(id) {
            // One that has shown the token is a window of the planner, which may rest.
            rest = REST;
            let (response, keeps) = match reader.request(&self.guard) {
                Ok((request, keeps)) => (answer(handler, &request), keeps),
                Err(End::Refused(refusal)) => (refusal.to_response(), false),
                Err(End::Gone) => return,
            };
            let keeps = keeps && !self.connections.is_stopped();
            let is_sent = writer::send(stream, response, &self.policy, keeps);
            if !keeps || is_sent.is_err() {
                return writer::close(stream);
            }
        }
    }
}

/// The response of the handler. If it panics, its words.
fn answer<'h>(handler: &impl Fn(&Request) -> Response<'h>, request: &Request) -> Response<'h> {
    catch_unwind(AssertUnwindSafe(|| handler(request))).unwrap_or_else(|panic| {
        let words = describe_panic(panic.as_ref());
        log::error!("{}: {words}", request.path);
        Response::error(500, &format!("a fault of perirobot itself: it {words}"))
    })
}

/// 128 random bits of the system, in hexadecimal.
fn new_token() -> Result<String> {
    let mut bits = [0; 16];
    getrandom::fill(&mut bits)
        .map_err(|e| Error::device(format!("the system gave no random numbers for a token: {e}")))?;
    Ok(hex(&bits))
}
