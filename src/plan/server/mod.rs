//! A server of HTTP for one page on this machine. It listens on 127.0.0.1 only, answers only requests that show the
//! token, and knows nothing of studies. Messages are read and written by `hyper`; here are the rules of who may ask
//! ([`guard`]), the limits ([`connections`]), and threads for handlers that take long ([`jobs`]).

mod connections;
mod guard;
mod jobs;
mod message;

#[cfg(test)]
mod tests;

use std::io::{Error as IoError, ErrorKind};
use std::net::Ipv4Addr;
use std::sync::{Arc, mpsc};
use std::thread;
#[cfg(test)]
use std::time::Duration;

use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::source::hex;
use tokio::net::TcpListener;
use tokio::runtime::{Builder, Runtime};
use tokio::sync::watch;

use connections::{PATIENCE, Rules};
use guard::Guard;
pub use guard::{PAPERS, TOKEN_HEADER, is_equal};
pub use message::{Body, Method, Request, Response, Stream};

/// What pages may do that bring no policy: nothing.
const NO_POLICY: &str = "default-src 'none'; frame-ancestors 'none'";

/// A port on 127.0.0.1, and the token that requests must show.
pub struct Server {
    runtime: Runtime,
    listener: TcpListener,
    rules: Rules,
    stop: Stop,
}

/// Ends a server from another thread.
#[derive(Clone)]
pub struct Stop(watch::Sender<bool>);

impl Stop {
    /// Ends the server: idle connections are closed, and responses on their way are sent to their end.
    pub fn stop(&self) {
        self.0.send_replace(true);
    }
}

impl Server {
    /// Opens a port; 0 is any that is free.
    ///
    /// # Errors
    /// If the port is taken, or the system has no random numbers.
    pub fn bind(port: u16) -> Result<Server> {
        let refused = |e: IoError| {
            let issue = Issue::io("cannot be opened", &e).with_place(format!("port {port}"));
            let issue = issue.with_advice("take another port, or 0 for any that is free");
            match e.kind() {
                ErrorKind::AddrInUse => Error::Busy(issue),
                _ => Error::Input(issue),
            }
        };
        let runtime = Builder::new_current_thread().enable_all().build().map_err(refused)?;
        let listener = runtime.block_on(TcpListener::bind((Ipv4Addr::LOCALHOST, port))).map_err(refused)?;
        let port = listener.local_addr().map_err(refused)?.port();
        let rules =
            Rules { guard: Guard::new(port, new_token()?), policy: NO_POLICY.into(), patience: PATIENCE };
        Ok(Server { runtime, listener, rules, stop: Stop(watch::Sender::new(false)) })
    }

    /// The same with the Content-Security-Policy of its page, which has the hashes of its script and its style.
    #[must_use]
    pub fn with_policy(mut self, policy: impl Into<String>) -> Server {
        self.rules.policy = policy.into();
        self
    }

    /// The same with less time for a head and a body.
    #[cfg(test)]
    fn with_patience(mut self, patience: Duration) -> Server {
        self.rules.patience = patience;
        self
    }

    /// The port.
    pub fn port(&self) -> u16 {
        self.rules.guard.port()
    }

    /// What every request but that of the page must have in the header [`TOKEN_HEADER`]: 128 random bits.
    pub fn token(&self) -> &str {
        self.rules.guard.token()
    }

    /// The address of the page. The token is in its fragment, which browsers neither send nor log.
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/#{}", self.port(), self.token())
    }

    /// A handle that ends it.
    pub fn stopper(&self) -> Stop {
        self.stop.clone()
    }

    /// Answers requests until it is stopped, those of several connections at a time.
    pub fn run<'h>(self, handler: impl Fn(&Request) -> Response<'h> + Sync) {
        let Server { runtime, listener, rules, stop } = self;
        let (sender, jobs) = mpsc::channel();
        let connections = connections::serve(listener, Arc::new(rules), sender, stop.0.subscribe());
        thread::scope(|scope| {
            // Connections that are still open at the end go with the runtime, and so do the senders of jobs.
            scope.spawn(move || runtime.block_on(connections));
            for job in jobs {
                scope.spawn(|| job.answer(&handler));
            }
        });
    }
}

/// 128 random bits of the system, in hexadecimal.
///
/// # Errors
/// If the system has none.
pub fn new_token() -> Result<String> {
    let mut bits = [0; 16];
    getrandom::fill(&mut bits)
        .map_err(|e| Error::device(format!("the system gave no random numbers for a token: {e}")))?;
    Ok(hex(&bits))
}
