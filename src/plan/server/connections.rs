//! The open connections: a few at a time, and of these the idle ones make room for others.

use std::net::{Shutdown, TcpStream};
use std::sync::{Mutex, PoisonError};

/// Most connections at a time.
pub(super) const MOST_CONNECTIONS: usize = 8;

/// All open connections, those that have been idle longest first.
#[derive(Default)]
pub(super) struct Connections(Mutex<State>);

#[derive(Default)]
struct State {
    open: Vec<Connection>,
    next: u64,
    is_stopped: bool,
}

struct Connection {
    id: u64,
    stream: TcpStream,
    is_idle: bool,
    /// Whether it was shut down, and is about to end.
    is_ending: bool,
}

impl State {
    fn position(&self, id: u64) -> Option<usize> {
        self.open.iter().position(|connection| connection.id == id)
    }

    fn count(&self) -> usize {
        self.open.iter().filter(|connection| !connection.is_ending).count()
    }
}

impl Connection {
    fn end(&mut self) {
        self.is_ending = true;
        // What its thread waits for is over.
        let _ = self.stream.shutdown(Shutdown::Both);
    }
}

impl Connections {
    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a connection; none if all others are busy.
    pub(super) fn add(&self, stream: &TcpStream) -> Option<u64> {
        let mut state = self.state();
        let stream = stream.try_clone().ok()?;
        if state.count() >= MOST_CONNECTIONS {
            state.open.iter_mut().find(|other| other.is_idle && !other.is_ending)?.end();
        }
        let id = state.next;
        state.next += 1;
        state.open.push(Connection { id, stream, is_idle: true, is_ending: false });
        Some(id)
    }

    /// Says that a connection waits for its next request. Whether it may.
    pub(super) fn rest(&self, id: u64) -> bool {
        let mut state = self.state();
        let Some(position) = state.position(id) else { return false };
        let mut connection = state.open.remove(position);
        connection.is_idle = true;
        let may = !connection.is_ending && !state.is_stopped;
        state.open.push(connection);
        may
    }

    /// Says that a connection has a request. Whether it may be answered.
    pub(super) fn wake(&self, id: u64) -> bool {
        let mut state = self.state();
        let Some(position) = state.position(id) else { return false };
        state.open[position].is_idle = false;
        !state.open[position].is_ending
    }

    pub(super) fn remove(&self, id: u64) {
        let mut state = self.state();
        if let Some(position) = state.position(id) {
            state.open.remove(position);
        }
    }

    /// Ends all that are idle, and lets the others send what they have begun.
    pub(super) fn stop(&self) {
        let mut state = self.state();
        state.is_stopped = true;
        state.open.iter_mut().filter(|connection| connection.is_idle).for_each(Connection::end);
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.state().is_stopped
    }
}
