//! Why a request is not handled.

use super::message::Response;

/// Why a request is not handled. Its connection ends: where the next request begins is unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// It is no HTTP, or what another program would read otherwise.
    Malformed(&'static str),
    /// It may not ask.
    Hostile(&'static str),
    /// It does something other than to read or to post.
    Method,
    /// It was not finished in time.
    Slow,
    /// Its body has no length.
    Length,
    /// Its head or its body is too large.
    Large(&'static str),
    /// Too many others are asking.
    Crowded,
    /// It is of another version of HTTP.
    Version,
}

impl Refusal {
    /// Its status and its words.
    pub(super) fn to_response<'a>(self) -> Response<'a> {
        match self {
            Refusal::Malformed(words) => Response::error(400, words),
            Refusal::Hostile(words) => Response::error(403, words),
            Refusal::Method => Response::error(405, "a request reads with GET or changes with POST"),
            Refusal::Slow => Response::error(408, "the request was not finished in time"),
            Refusal::Length => Response::error(411, "a body has a Content-Length"),
            Refusal::Large(words) => Response::error(413, words),
            Refusal::Crowded => {
                Response::error(503, "too many connections: close other windows of this planner")
            }
            Refusal::Version => Response::error(505, "the version of HTTP must be 1.1"),
        }
    }
}
