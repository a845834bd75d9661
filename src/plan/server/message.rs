//! A request that was let in, and its response.

use std::io::{self, Write};

/// A request that passed all checks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// What it may do.
    pub method: Method,
    /// The path, `/score`, as it was sent: nothing is decoded.
    pub path: String,
    /// What is behind the question mark, without it; empty if there is none.
    pub query: String,
    /// The body; empty if there is none.
    pub body: Vec<u8>,
}

impl Request {
    /// The value of a key of the query, as it was sent. Values that the page sends are numbers and words.
    pub fn value(&self, key: &str) -> Option<&str> {
        let pairs = self.query.split('&').filter_map(|pair| pair.split_once('='));
        pairs.into_iter().find(|(name, _)| *name == key).map(|(_, value)| value)
    }
}

/// What a request may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Read.
    Get,
    /// Change something, or ask for work.
    Post,
}

/// Writes the parts of a response that grows. A part is sent at once. It fails once the reader has left.
pub type Stream<'a> = Box<dyn FnOnce(&mut dyn Write) -> io::Result<()> + 'a>;

/// The body of a response.
pub enum Body<'a> {
    /// All of it.
    Whole(Vec<u8>),
    /// Parts that are sent as they are written.
    Stream(Stream<'a>),
}

/// A response. The rules for browsers are added as it is sent.
pub struct Response<'a> {
    /// The status: 200, 404.
    pub status: u16,
    /// The type of the body: `application/json`.
    pub content_type: &'static str,
    /// The body.
    pub body: Body<'a>,
    /// A Content-Security-Policy of its own.
    pub policy: Option<&'static str>,
}

/// The type of JSON.
const JSON: &str = "application/json";

impl<'a> Response<'a> {
    /// A whole body.
    pub fn new(status: u16, content_type: &'static str, body: impl Into<Vec<u8>>) -> Response<'a> {
        Response { status, content_type, body: Body::Whole(body.into()), policy: None }
    }

    /// JSON that was found.
    pub fn json(body: impl Into<Vec<u8>>) -> Response<'a> {
        Response::new(200, JSON, body)
    }

    /// What is wrong, as JSON: `{"error": "…"}`.
    pub fn error(status: u16, words: &str) -> Response<'a> {
        Response::new(status, JSON, serde_json::json!({ "error": words }).to_string())
    }

    /// The same under another policy than that of the planner's page.
    #[must_use]
    pub fn with_policy(self, policy: &'static str) -> Response<'a> {
        Response { policy: Some(policy), ..self }
    }

    /// A body that is sent part by part.
    pub fn stream(
        content_type: &'static str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()> + 'a,
    ) -> Response<'a> {
        Response { status: 200, content_type, body: Body::Stream(Box::new(write)), policy: None }
    }
}
