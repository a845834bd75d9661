//! A planner that runs, and requests to it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

use serde_json::Value;

use crate::common::program::Outcome;

/// The program at work on a study.
pub(crate) struct Planner {
    process: Child,
    stdout: BufReader<ChildStdout>,
    port: u16,
    token: String,
}

impl Planner {
    /// Starts `perirobot plan`, and waits for its address.
    pub(crate) fn start(study: &str, more: &[&str]) -> Planner {
        Planner::start_in(Path::new(env!("CARGO_MANIFEST_DIR")), &[&[study], more].concat())
    }

    /// The same in a folder, with or without a study.
    pub(crate) fn start_in(folder: &Path, words: &[&str]) -> Planner {
        let mut command = Command::new(env!("CARGO_BIN_EXE_perirobot"));
        command.current_dir(folder).args(["plan", "--no-open"]).args(words);
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut stdout = BufReader::new(process.stdout.take().unwrap());
        let (mut line, begin) = (String::new(), "http://127.0.0.1:");
        stdout.read_line(&mut line).unwrap();
        let Some((_, address)) = line.split_once(begin) else {
            let output = process.wait_with_output().unwrap();
            panic!("no address in {line:?}: {}", String::from_utf8_lossy(&output.stderr));
        };
        let (port, token) = address.trim().split_once("/#").unwrap();
        Planner { port: port.parse().unwrap(), token: token.into(), process, stdout }
    }

    /// The address of its page, with the token.
    pub(crate) fn address(&self) -> String {
        format!("http://127.0.0.1:{}/#{}", self.port, self.token)
    }

    /// The number of its process.
    pub(crate) fn process(&self) -> u32 {
        self.process.id()
    }

    /// The status and the body of an answer.
    pub(crate) fn send(&self, method: &str, path: &str, body: &str) -> (u16, Vec<u8>) {
        self.send_as(&self.token, method, path, body)
    }

    /// The same as text of a request that does not know the token.
    pub(crate) fn send_without_token(&self, method: &str, path: &str) -> (u16, String) {
        let (status, body) = self.send_as("", method, path, "");
        (status, String::from_utf8(body).unwrap())
    }

    fn send_as(&self, token: &str, method: &str, path: &str, body: &str) -> (u16, Vec<u8>) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nX-Perirobot-Token: {}\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\nConnection: close\r\n\r\n",
            self.port,
            token,
            body.len()
        );
        stream.write_all(head.as_bytes()).unwrap();
        stream.write_all(body.as_bytes()).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("a head");
        let head = String::from_utf8(answer[..end].to_vec()).unwrap().to_ascii_lowercase();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        let body = answer.split_off(end + 4);
        (status, if head.contains("transfer-encoding: chunked") { joined(&body) } else { body })
    }

    /// The JSON of an answer that must be good.
    #[track_caller]
    pub(crate) fn get(&self, path: &str) -> Value {
        good(path, self.send("GET", path, ""))
    }

    /// The same of a request that changes something or asks for work.
    #[track_caller]
    pub(crate) fn post(&self, path: &str, body: Value) -> Value {
        good(path, self.send("POST", path, &body.to_string()))
    }

    /// What is wrong with a request that must be refused with a status.
    #[track_caller]
    pub(crate) fn refused(&self, path: &str, body: Value, expected: u16) -> String {
        let (status, answer) = self.send("POST", path, &body.to_string());
        let answer = String::from_utf8(answer).unwrap();
        assert_eq!(status, expected, "{path} {body}: {answer}");
        let answer: Value = serde_json::from_str(&answer).unwrap();
        answer["error"].as_str().unwrap_or_default().into()
    }

    /// Ends it as Ctrl-C does.
    pub(crate) fn end(mut self) -> Outcome {
        let process = self.process.id().to_string();
        assert!(Command::new("kill").args(["-INT", &process]).status().unwrap().success());
        let (mut stdout, mut stderr) = (String::new(), String::new());
        self.stdout.read_to_string(&mut stdout).unwrap();
        self.process.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        Outcome { code: self.process.wait().unwrap().code(), stdout, stderr }
    }
}

/// A test that fails leaves no planner behind.
impl Drop for Planner {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[track_caller]
fn good(path: &str, (status, body): (u16, Vec<u8>)) -> Value {
    let body = String::from_utf8(body).unwrap();
    assert_eq!(status, 200, "{path}: {body}");
    serde_json::from_str(&body).unwrap_or_else(|e| panic!("{path}: {e}: {body}"))
}

/// The parts of a body that came in chunks.
fn joined(mut body: &[u8]) -> Vec<u8> {
    let mut whole = Vec::new();
    while let Some(end) = body.windows(2).position(|two| two == b"\r\n") {
        let length = usize::from_str_radix(std::str::from_utf8(&body[..end]).unwrap().trim(), 16).unwrap();
        if length == 0 {
            break;
        }
        whole.extend(&body[end + 2..end + 2 + length]);
        body = &body[end + 2 + length + 2..];
    }
    whole
}
