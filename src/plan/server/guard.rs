//! Who may ask. A page of another origin, a name that was rebound to this machine, and another user of the machine all
//! reach the port; none of them gets an answer.

use hyper::Version;
use hyper::header::{HeaderMap, TRANSFER_ENCODING};
use hyper::http::request::Parts;

use super::message::{Method, Response};

/// The header in which the page sends the token.
pub const TOKEN_HEADER: &str = "X-Perirobot-Token";

/// Paths of pages that need no token, as what follows cannot be guessed.
pub const PAPERS: &str = "/paper/";

/// What a request must show.
pub(super) struct Guard {
    port: u16,
    token: String,
}

impl Guard {
    pub(super) fn new(port: u16, token: String) -> Guard {
        Guard { port, token }
    }

    pub(super) fn token(&self) -> &str {
        &self.token
    }

    pub(super) fn port(&self) -> u16 {
        self.port
    }

    /// The method of a request that may be answered, or what its sender gets instead.
    pub(super) fn check(&self, request: &Parts) -> Result<Method, Response<'static>> {
        let Parts { method, uri, version, headers, .. } = request;
        let hostile = |words: &str| Err(Response::error(403, words));
        // A target that names a host goes before the header Host.
        if uri.authority().is_some() || !uri.path().starts_with('/') {
            return hostile("the target of a request is a path");
        }
        // Rebound to this machine, a foreign name makes its page same-origin, whose requests carry no Origin.
        if !only(headers, "host")?.is_some_and(|host| self.is_own_host(host)) {
            return hostile("Host must be that of the planner");
        }
        let is_own_origin =
            |origin: &[u8]| origin.strip_prefix(b"http://").is_some_and(|host| self.is_own_host(host));
        if only(headers, "origin")?.is_some_and(|origin| !is_own_origin(origin)) {
            return hostile("the request comes from a page of another origin");
        }
        let is_page = method == hyper::Method::GET && (uri.path() == "/" || uri.path().starts_with(PAPERS));
        // A person may follow a link to the page, as from a notebook. It has no secret, and no frame shows it.
        let follows_link = is_page
            && only(headers, "sec-fetch-mode")? == Some(b"navigate")
            && only(headers, "sec-fetch-dest")? == Some(b"document");
        let is_own_site = |site: &[u8]| site == b"none" || site == b"same-origin";
        if only(headers, "sec-fetch-site")?.is_some_and(|site| !is_own_site(site) && !follows_link) {
            return hostile("the request comes from another site");
        }
        let token = only(headers, TOKEN_HEADER)?;
        if !is_page && !token.is_some_and(|token| is_equal(token, self.token.as_bytes())) {
            return hostile("the token is missing or wrong: open the address that the program printed");
        }
        if *version != Version::HTTP_11 {
            return Err(Response::error(505, "the version of HTTP must be 1.1"));
        }
        // Programs read a coded length in different ways.
        if headers.contains_key(TRANSFER_ENCODING) {
            return Err(Response::error(411, "a body has a Content-Length"));
        }
        match *method {
            hyper::Method::GET => Ok(Method::Get),
            hyper::Method::POST => Ok(Method::Post),
            _ => Err(Response::error(405, "a request reads with GET or changes with POST")),
        }
    }

    fn is_own_host(&self, host: &[u8]) -> bool {
        ["127.0.0.1", "localhost"].iter().any(|name| host == format!("{name}:{}", self.port).as_bytes())
    }
}

/// The value of a header that may be there once.
fn only<'a>(headers: &'a HeaderMap, name: &str) -> Result<Option<&'a [u8]>, Response<'static>> {
    let mut found = headers.get_all(name).iter();
    match (found.next(), found.next()) {
        (_, Some(_)) => Err(Response::error(403, "a header is there twice")),
        (first, None) => Ok(first.map(|value| value.as_bytes())),
    }
}

/// Whether two byte strings are equal, in a time that does not depend on where they differ.
pub fn is_equal(left: &[u8], right: &[u8]) -> bool {
    let difference = left.iter().zip(right).fold(0, |all, (l, r)| all | (l ^ r));
    left.len() == right.len() && std::hint::black_box(difference) == 0
}

#[cfg(test)]
mod tests {
    use super::is_equal;

    #[test]
    fn only_equal_bytes_are_equal() {
        assert!(is_equal(b"", b"") && is_equal(b"abc", b"abc"));
        for (left, right) in [("abc", "abd"), ("abc", "bbc"), ("abc", "ab"), ("ab", "abc"), ("", "a")] {
            assert!(!is_equal(left.as_bytes(), right.as_bytes()), "{left} {right}");
        }
    }
}
