//! Requests of pages of other origins, of rebound names, and of other users of the machine.

use super::*;

/// A request with other header fields than it must have.
struct Forged {
    line: &'static str,
    host: String,
    token: Option<String>,
    more: &'static str,
}

impl Forged {
    fn text(&self) -> String {
        let Forged { line, host, token, more } = self;
        let token = token.as_ref().map_or(String::new(), |token| format!("X-Perirobot-Token: {token}\r\n"));
        format!("{line} HTTP/1.1\r\n{host}{token}{more}\r\n")
    }
}

#[test]
fn hostile_requests_get_no_answer() {
    let asked = with_server(PATIENCE, |client| {
        let port = client.port;
        let own = || Forged {
            line: "GET /query",
            host: format!("Host: 127.0.0.1:{port}\r\n"),
            token: Some(client.token.clone()),
            more: "",
        };
        let host = |host: &str| Forged { host: format!("Host: {host}\r\n"), ..own() };
        let more = |more: &'static str| Forged { more, ..own() };
        let line = |line: &'static str| Forged { line, ..own() };
        let token = |token: Option<&str>| Forged { token: token.map(String::from), ..own() };
        let page =
            |host: &str| Forged { line: "GET /", token: None, host: format!("Host: {host}\r\n"), ..own() };
        let wrong =
            client.token.replace(&client.token[..1], if client.token.starts_with('0') { "1" } else { "0" });
        let origin = format!("Origin: http://127.0.0.1:{port}.evil.example\r\n").leak();
        let other_port = format!("Origin: http://127.0.0.1:{}\r\n", port ^ 1).leak();
        let secure = format!("Origin: https://127.0.0.1:{port}\r\n").leak();
        let absolute = format!("GET http://127.0.0.1:{port}/query").leak();
        let all = [
            ("another host", host("evil.example")),
            ("a rebound name with the right port", host(&format!("evil.example:{port}"))),
            ("a host with a suffix", host(&format!("127.0.0.1:{port}.evil.example"))),
            ("a host with a prefix", host(&format!("evil-127.0.0.1:{port}"))),
            ("a host without a port", host("127.0.0.1")),
            ("another port", host(&format!("127.0.0.1:{}", port ^ 1))),
            ("another name of this machine", host(&format!("0.0.0.0:{port}"))),
            ("a host with a user", host(&format!("a@127.0.0.1:{port}"))),
            ("no host", Forged { host: String::new(), ..own() }),
            ("two hosts", more("Host: evil.example\r\n")),
            ("the page by a rebound name", page(&format!("evil.example:{port}"))),
            ("a paper by a rebound name", Forged { line: "GET /paper/0", ..page("evil.example") }),
            (
                "a paper for a script of another site",
                Forged {
                    line: "GET /paper/0",
                    more: "Sec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: no-cors\r\nSec-Fetch-Dest: empty\r\n",
                    ..page(&format!("localhost:{port}"))
                },
            ),
            ("a change of a paper", Forged { line: "POST /paper/0", ..page(&format!("localhost:{port}")) }),
            (
                "the page for a frame of another site",
                Forged { more: "Sec-Fetch-Site: cross-site\r\n", ..page(&format!("localhost:{port}")) },
            ),
            (
                "what a link of another site must not reach",
                more(
                    "Sec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: navigate\r\nSec-Fetch-Dest: document\r\n",
                ),
            ),
            (
                "the page as a frame",
                Forged {
                    more: "Sec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: navigate\r\nSec-Fetch-Dest: iframe\r\n",
                    ..page(&format!("localhost:{port}"))
                },
            ),
            (
                "the page read by a script of another site",
                Forged {
                    more: "Sec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: no-cors\r\nSec-Fetch-Dest: document\r\n",
                    ..page(&format!("localhost:{port}"))
                },
            ),
            ("another origin", more("Origin: http://evil.example\r\n")),
            ("the origin null", more("Origin: null\r\n")),
            ("an empty origin", more("Origin: \r\n")),
            ("an origin that begins like ours", Forged { line: "POST /echo", ..more(origin) }),
            ("our origin with another port", more(other_port)),
            ("our origin by another scheme", more(secure)),
            ("another site", more("Sec-Fetch-Site: cross-site\r\n")),
            ("another page of the same site", more("Sec-Fetch-Site: same-site\r\n")),
            ("no token", token(None)),
            ("no token to change something", Forged { line: "POST /echo", ..token(None) }),
            ("another token", token(Some(&wrong))),
            ("an empty token", token(Some(""))),
            ("a part of the token", token(Some(&client.token[..31]))),
            ("the token with a suffix", token(Some(&format!("{}0", client.token)))),
            (
                "the token twice",
                Forged { more: format!("X-Perirobot-Token: {}\r\n", client.token).leak(), ..own() },
            ),
            (
                "the token in the address",
                Forged { line: format!("GET /query?token={}", client.token).leak(), ..token(None) },
            ),
            ("a target with another host", line("GET http://evil.example/query")),
            ("a target with our host", line(absolute)),
            ("a target that is no path", line("OPTIONS *")),
            ("a tunnel", line("CONNECT evil.example:443")),
            (
                "what a browser asks before a foreign request",
                Forged {
                    line: "OPTIONS /echo",
                    token: None,
                    more: "Origin: http://evil.example\r\nAccess-Control-Request-Method: POST\r\n",
                    ..own()
                },
            ),
        ];
        for (what, forged) in &all {
            let answer = client.ask(forged.text());
            assert!(answer.starts_with("HTTP/1.1 403 Forbidden\r\n"), "{what}: {answer}");
            assert!(
                !answer.contains(&client.token) && !answer.contains("Access-Control"),
                "{what}: {answer}"
            );
            assert!(answer.contains("Connection: close"), "{what}: {answer}");
        }
        // So it is not the helper that is refused.
        assert_status(&client.ask(own().text()), 200);
    });
    assert_eq!(asked, 1);
}

#[test]
fn where_a_request_ends_is_never_in_doubt() {
    let asked = with_server(PATIENCE, |client| {
        let with = |more: &str| {
            client.request("POST /echo", "").replacen("\r\n\r\n", &format!("\r\n{more}\r\n\r\n"), 1)
        };
        for (more, status) in [
            ("Content-Length: 4\r\nTransfer-Encoding: chunked", 411),
            ("Transfer-Encoding: chunked\r\nContent-Length: 4", 411),
            ("Content-Length: 4\r\nContent-Length: 5", 400),
            ("Content-Length: +4", 400),
            ("Content-Length: -1", 400),
            ("Content-Length: 4, 4", 400),
            ("Content-Length: 0x4", 400),
            ("Content-Length:", 400),
            ("Content-Length : 4", 400),
            ("Content-Length: 4\r\n Transfer-Encoding: chunked", 400),
            ("Transfer-Encoding: chunked", 411),
            ("Transfer-Encoding: identity", 400),
            ("Content-Length: 99999999999999999999999", 400),
        ] {
            let smuggled = with(more) + "1\r\na\r\n0\r\n\r\n" + &client.request("POST /echo", "smuggled");
            let answer = client.ask(smuggled);
            assert_status(&answer, status);
            assert_eq!(answer.matches("HTTP/1.1").count(), 1, "{more}: {answer}");
        }
    });
    assert_eq!(asked, 0);
}

#[test]
fn garbage_ends_its_connection() {
    let asked = with_server(PATIENCE, |client| {
        for garbage in
            ["\u{16}\u{3}\u{1}\u{2}", "GET\r\n\r\n", "GET  / HTTP/1.1\r\n\r\n", "{\"json\": 1}\r\n\r\n"]
        {
            assert_status(&client.ask(garbage), 400);
            let answer = client.ask(client.request("POST /echo", "good") + garbage);
            let (first, second) = answer.split_once("good").unwrap();
            assert_status(first, 200);
            assert_status(second, 400);
        }
        let old = format!("GET / HTTP/1.0\r\nHost: localhost:{}\r\n\r\n", client.port);
        assert!(client.ask(old).contains(" 505 "));
        assert_status(&client.ask("GET / HTTP/2.0\r\n\r\n"), 400);
        for method in ["PUT", "DELETE", "HEAD", "PATCH", "OPTIONS"] {
            let answer = client.ask(client.request(&format!("{method} /echo"), "{}"));
            assert_status(&answer, 405);
            assert!(answer.contains("Allow: GET, POST\r\n"), "{answer}");
        }
        // Somebody who leaves in the middle is no request.
        assert_eq!(client.ask("GET / HT"), "");
    });
    assert_eq!(asked, 4);
}
