//! Who may ask. A page of another origin, a name that was rebound to this machine, and another user of the machine all
//! reach the port; none of them gets an answer.

use httparse::Header;

use super::message::Method;
use super::refusal::Refusal;

/// The header in which the page sends the token.
pub const TOKEN_HEADER: &str = "X-Perirobot-Token";

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

    /// The method of a request that may be answered.
    pub(super) fn check(&self, request: &httparse::Request) -> Result<Method, Refusal> {
        let (method, target) = (request.method.unwrap_or_default(), request.path.unwrap_or_default());
        // A target that names a host goes before the header Host.
        if !target.starts_with('/') {
            return Err(Refusal::Hostile("the target of a request is a path"));
        }
        let fields = Fields(request.headers);
        // Rebound to this machine, a foreign name makes its page same-origin, whose requests carry no Origin.
        match fields.only("host")? {
            Some(host) if self.is_own_host(host) => {}
            _ => return Err(Refusal::Hostile("Host must be that of the planner")),
        }
        let is_own_origin =
            |origin: &[u8]| origin.strip_prefix(b"http://").is_some_and(|h| self.is_own_host(h));
        if fields.only("origin")?.is_some_and(|origin| !is_own_origin(origin)) {
            return Err(Refusal::Hostile("the request comes from a page of another origin"));
        }
        let path = target.split('?').next().unwrap_or_default();
        let is_page = method == "GET" && path == "/";
        // A person may follow a link to the page, as from a notebook. It has no secret, and no frame shows it.
        let follows_link = is_page
            && fields.only("sec-fetch-mode")? == Some(b"navigate")
            && fields.only("sec-fetch-dest")? == Some(b"document");
        let is_own_site = |site: &[u8]| site == b"none" || site == b"same-origin";
        if fields.only("sec-fetch-site")?.is_some_and(|site| !is_own_site(site) && !follows_link) {
            return Err(Refusal::Hostile("the request comes from another site"));
        }
        let token = fields.only(TOKEN_HEADER)?;
        if !is_page && !token.is_some_and(|token| is_equal(token, self.token.as_bytes())) {
            return Err(Refusal::Hostile(
                "the token is missing or wrong: open the address that the program printed",
            ));
        }
        match method {
            "GET" => Ok(Method::Get),
            "POST" => Ok(Method::Post),
            _ => Err(Refusal::Method),
        }
    }

    fn is_own_host(&self, host: &[u8]) -> bool {
        ["127.0.0.1", "localhost"].iter().any(|name| host == format!("{name}:{}", self.port).as_bytes())
    }
}

/// The header fields of a request.
pub(super) struct Fields<'a>(pub(super) &'a [Header<'a>]);

impl<'a> Fields<'a> {
    /// The value of a field that may be there once.
    pub(super) fn only(&self, name: &'static str) -> Result<Option<&'a [u8]>, Refusal> {
        let mut found = self.all(name);
        match (found.next(), found.next()) {
            (_, Some(_)) => Err(Refusal::Hostile("a header is there twice")),
            (first, None) => Ok(first),
        }
    }

    /// All values of a field.
    pub(super) fn all(&self, name: &'static str) -> impl Iterator<Item = &'a [u8]> {
        self.0.iter().filter(move |field| field.name.eq_ignore_ascii_case(name)).map(|field| field.value)
    }
}

/// Whether two byte strings are equal, in a time that does not depend on where they differ.
fn is_equal(left: &[u8], right: &[u8]) -> bool {
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
