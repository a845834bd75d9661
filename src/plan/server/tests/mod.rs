//! Each test speaks to a server by raw sockets, as a program that does not keep to any rule would.

mod hostile;
mod limits;

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use super::*;

/// How long the handler of `/slow` takes.
const SLOW: Duration = Duration::from_millis(300);

/// How long a test waits for bytes.
const WAIT: Duration = Duration::from_secs(20);

/// The handler of `/half` fails once its beginning has been read.
static HALF_IS_READ: AtomicBool = AtomicBool::new(false);

/// Runs a test beside a server that echoes bodies, and counts what its handler was asked.
fn with_server(patience: Duration, test: impl FnOnce(&Client)) -> usize {
    let server = Server::bind(0).unwrap().with_policy("default-src 'self'").with_patience(patience);
    let client = Client { port: server.port(), token: server.token().into() };
    let (stop, asked) = (server.stopper(), AtomicUsize::new(0));
    let handler = &|request: &Request| {
        asked.fetch_add(1, Ordering::Relaxed);
        match request.path.as_str() {
            "/" => Response::new(200, "text/html; charset=utf-8", "the page"),
            "/echo" => Response::json(request.body.clone()),
            "/query" => Response::json(request.value("moment").unwrap_or("none")),
            "/fault" => panic!("out of range"),
            "/lines" => Response::stream("application/x-ndjson", |lines| {
                (0..3).try_for_each(|i| writeln!(lines, "{{\"line\":{i}}}"))
            }),
            "/half" => Response::stream("text/plain", |lines| {
                lines.write_all(b"half")?;
                while !HALF_IS_READ.load(Ordering::Relaxed) {
                    thread::yield_now();
                }
                panic!("in the middle")
            }),
            "/slow" => {
                thread::sleep(SLOW);
                Response::json("slow")
            }
            _ => Response::error(404, "there is no such path"),
        }
    };
    thread::scope(|scope| {
        let running = scope.spawn(|| server.run(handler));
        // Whatever the test does, the server ends.
        let result = catch_unwind(AssertUnwindSafe(|| test(&client)));
        stop.stop();
        running.join().unwrap();
        result.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    });
    asked.into_inner()
}

struct Client {
    port: u16,
    token: String,
}

impl Client {
    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(WAIT)).unwrap();
        stream
    }

    /// A request that may be answered.
    fn request(&self, line: &str, body: &str) -> String {
        let Client { port, token } = self;
        let length =
            if body.is_empty() { String::new() } else { format!("Content-Length: {}\r\n", body.len()) };
        format!(
            "{line} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nX-Perirobot-Token: {token}\r\n{length}\r\n{body}"
        )
    }

    /// The answer to some bytes on a connection of their own, to its end.
    fn ask(&self, bytes: impl AsRef<[u8]>) -> String {
        let mut stream = self.connect();
        let _ = stream.write_all(bytes.as_ref());
        let _ = stream.shutdown(std::net::Shutdown::Write);
        read_all(&mut stream)
    }
}

fn read_all(stream: &mut TcpStream) -> String {
    let (mut bytes, mut part) = (Vec::new(), [0; 4096]);
    loop {
        match stream.read(&mut part) {
            Ok(0) => break,
            Ok(count) => bytes.extend_from_slice(&part[..count]),
            Err(e) if e.kind() == ErrorKind::ConnectionReset => break,
            Err(e) => panic!("{e}: {}", String::from_utf8_lossy(&bytes)),
        }
    }
    String::from_utf8(bytes).unwrap()
}

/// One whole response of a connection that stays open.
fn read_one(stream: &mut TcpStream) -> String {
    let (mut text, mut byte) = (String::new(), [0; 1]);
    while !text.ends_with("\r\n\r\n") {
        stream.read_exact(&mut byte).unwrap();
        text.push(byte[0].into());
    }
    let length = text.lines().find_map(|line| line.strip_prefix("Content-Length: ")).unwrap();
    let mut body = vec![0; length.parse().unwrap()];
    stream.read_exact(&mut body).unwrap();
    text + &String::from_utf8(body).unwrap()
}

#[track_caller]
fn assert_status(answer: &str, status: u16) {
    assert!(answer.starts_with(&format!("HTTP/1.1 {status} ")), "expected {status}: {answer:?}");
}

#[track_caller]
fn body(answer: &str) -> &str {
    answer.split_once("\r\n\r\n").unwrap().1
}

#[test]
fn a_request_with_the_token_is_answered() {
    let asked = with_server(PATIENCE, |client| {
        let answer = client.ask(client.request("POST /echo", "{\"n\":1}"));
        assert_status(&answer, 200);
        assert_eq!(body(&answer), "{\"n\":1}");
        assert_eq!(body(&client.ask(client.request("GET /query?voxel=fine&moment=3", ""))), "3");
        assert_status(&client.ask(client.request("GET /nowhere", "")), 404);
        let local = client.request("GET /query", "").replace("127.0.0.1", "localhost");
        assert_eq!(body(&client.ask(local)), "none");
        let own = client.request("POST /echo", "1").replace(
            "\r\n\r\n",
            &format!("\r\nOrigin: http://localhost:{}\r\nSec-Fetch-Site: same-origin\r\n\r\n", client.port),
        );
        assert_eq!(body(&client.ask(own)), "1");
    });
    assert_eq!(asked, 5);
}

#[test]
fn the_page_needs_no_token_and_has_the_rules_for_browsers() {
    with_server(PATIENCE, |client| {
        let answer = client.ask(format!("GET / HTTP/1.1\r\nHost: localhost:{}\r\n\r\n", client.port));
        assert_status(&answer, 200);
        assert_eq!(body(&answer), "the page");
        for rule in [
            "Content-Security-Policy: default-src 'self'\r\n",
            "X-Content-Type-Options: nosniff\r\n",
            "Cache-Control: no-store\r\n",
            "Content-Type: text/html; charset=utf-8\r\n",
            "Cross-Origin-Resource-Policy: same-origin\r\n",
            "Cross-Origin-Opener-Policy: same-origin\r\n",
            "Referrer-Policy: no-referrer\r\n",
        ] {
            assert!(answer.contains(rule), "{rule}: {answer}");
        }
        // So is somebody who follows a link in a notebook.
        let link = "Sec-Fetch-Site: same-site\r\nSec-Fetch-Mode: navigate\r\nSec-Fetch-Dest: document\r\n";
        let linked = client.ask(format!("GET / HTTP/1.1\r\nHost: localhost:{}\r\n{link}\r\n", client.port));
        assert_eq!(body(&linked), "the page");
        assert!(!answer.contains("Access-Control"), "{answer}");
    });
}

#[test]
fn a_connection_serves_several_requests() {
    with_server(PATIENCE, |client| {
        let mut stream = client.connect();
        for n in ["1", "22", "333"] {
            stream.write_all(client.request("POST /echo", n).as_bytes()).unwrap();
            let answer = read_one(&mut stream);
            assert!(!answer.contains("Connection: close") && body(&answer) == n, "{answer}");
        }
        // Two at once are answered in their order.
        let both = client.request("POST /echo", "a") + &client.request("GET /query?moment=b", "");
        stream.write_all(both.as_bytes()).unwrap();
        assert_eq!(
            [read_one(&mut stream), read_one(&mut stream)].each_ref().map(|one| body(one)),
            ["a", "b"]
        );
        // A request that comes byte by byte is one request.
        for byte in client.request("POST /echo", "slowly").bytes() {
            stream.write_all(&[byte]).unwrap();
        }
        assert_eq!(body(&read_one(&mut stream)), "slowly");
    });
}

#[test]
fn a_client_may_close_its_connection() {
    with_server(PATIENCE, |client| {
        let mut stream = client.connect();
        let request = client.request("POST /echo", "last");
        stream.write_all(request.replacen("\r\n", "\r\nConnection: x, Close\r\n", 1).as_bytes()).unwrap();
        let answer = read_all(&mut stream);
        assert!(answer.contains("Connection: close") && body(&answer) == "last", "{answer}");
    });
}

#[test]
fn a_response_is_sent_as_it_grows() {
    with_server(PATIENCE, |client| {
        let mut stream = client.connect();
        let both = client.request("GET /lines", "") + &client.request("POST /echo", "next");
        stream.write_all(both.as_bytes()).unwrap();
        stream.shutdown(std::net::Shutdown::Write).unwrap();
        let all = read_all(&mut stream);
        let (head, chunks) = all.split_once("\r\n\r\n").unwrap();
        assert!(head.contains("Transfer-Encoding: chunked"), "{head}");
        let (chunks, next) = chunks.split_once("HTTP/1.1 200 OK").unwrap();
        assert!(chunks.ends_with("\r\n0\r\n\r\n") && body(next) == "next", "{all}");
        let lines: Vec<&str> = chunks.lines().filter(|line| line.contains("line")).collect();
        assert_eq!(lines.len(), 3, "{all}");
        // The end is missing, so a page sees that it is not all.
        let (mut stream, mut half) = (client.connect(), String::new());
        stream.write_all(client.request("GET /half", "").as_bytes()).unwrap();
        while !half.ends_with("4\r\nhalf\r\n") {
            let mut byte = [0; 1];
            stream.read_exact(&mut byte).unwrap();
            half.push(byte[0].into());
        }
        HALF_IS_READ.store(true, Ordering::Relaxed);
        assert_eq!(read_all(&mut stream), "");
    });
}

#[test]
fn a_handler_that_panics_does_not_end_the_server() {
    with_server(PATIENCE, |client| {
        let mut stream = client.connect();
        stream.write_all(client.request("GET /fault", "").as_bytes()).unwrap();
        let answer = read_one(&mut stream);
        assert_status(&answer, 500);
        assert!(body(&answer).contains("panicked: out of range"), "{answer}");
        stream.write_all(client.request("POST /echo", "on").as_bytes()).unwrap();
        assert_eq!(body(&read_one(&mut stream)), "on");
    });
}

#[test]
fn a_stop_lets_answers_be_sent_to_their_end() {
    let server = Server::bind(0).unwrap();
    let client = Client { port: server.port(), token: server.token().into() };
    let (stop, begun) = (server.stopper(), AtomicUsize::new(0));
    let handler = &|_: &Request| {
        begun.store(1, Ordering::SeqCst);
        thread::sleep(Duration::from_millis(200));
        Response::json("all of it")
    };
    thread::scope(|scope| {
        let running = scope.spawn(|| server.run(handler));
        let _idle = client.connect();
        let asking = scope.spawn(|| client.ask(client.request("GET /state", "")));
        while begun.load(Ordering::SeqCst) == 0 {
            thread::yield_now();
        }
        let begin = Instant::now();
        stop.stop();
        running.join().unwrap();
        assert!(begin.elapsed() < PATIENCE / 2, "{:?}", begin.elapsed());
        assert_eq!(body(&asking.join().unwrap()), "all of it");
    });
}

#[test]
fn a_port_that_is_taken_is_told() {
    let first = Server::bind(0).unwrap();
    let error = Server::bind(first.port()).err().unwrap();
    assert!(matches!(error, Error::Busy(_)), "{error}");
    let words = format!("port {}: cannot be opened", first.port());
    assert!(error.to_string().starts_with(&words), "{error}");
}

#[test]
fn each_token_has_128_other_bits() {
    let tokens: Vec<String> = (0..20).map(|_| new_token().unwrap()).collect();
    assert!(tokens.iter().all(|token| token.len() == 32));
    let mut different = tokens.clone();
    different.sort();
    different.dedup();
    assert_eq!(different.len(), tokens.len());
    // A part that is always the same is not random.
    let is_constant =
        |place: usize| tokens.iter().all(|token| token[place..=place] == tokens[0][place..=place]);
    assert!(!(0..32).any(is_constant), "{tokens:?}");
}
