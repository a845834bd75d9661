//! Too much, too slow, too many.

use super::super::connections::MOST_CONNECTIONS;
use super::super::reader::{MOST_BODY, MOST_HEAD};
use super::*;

#[test]
fn a_head_has_64_kib() {
    let asked = with_server(PATIENCE, |client| {
        let with = |bytes: usize| {
            let bare = client.request("GET /query", "").len() + "X-Filler: \r\n".len();
            let filler = "a".repeat(bytes - bare);
            client.request("GET /query", "").replacen(
                "\r\n\r\n",
                &format!("\r\nX-Filler: {filler}\r\n\r\n"),
                1,
            )
        };
        assert_eq!(with(MOST_HEAD).len(), MOST_HEAD);
        assert_status(&client.ask(with(MOST_HEAD)), 200);
        assert_status(&client.ask(with(MOST_HEAD + 1)), 413);
        assert_status(&client.ask(with(3 << 20)), 413);
        let many = "X: 1\r\n".repeat(200);
        let many = client.request("GET /query", "").replacen("\r\n\r\n", &format!("\r\n{many}\r\n"), 1);
        assert_status(&client.ask(many), 413);
    });
    assert_eq!(asked, 1);
}

#[test]
fn a_body_has_1_mib() {
    let asked = with_server(PATIENCE, |client| {
        let largest = "a".repeat(MOST_BODY);
        let answer = client.ask(client.request("POST /echo", &largest));
        assert_eq!(body(&answer), largest);
        // The answer can be read although the body was not taken.
        let answer = client.ask(client.request("POST /echo", &(largest + "a")));
        assert_status(&answer, 413);
    });
    assert_eq!(asked, 1);
}

#[test]
fn a_head_and_a_body_have_their_time() {
    let asked = with_server(Duration::from_millis(200), |client| {
        let whole = client.request("POST /echo", "body");
        for part in [10, whole.len() - 1] {
            let mut stream = client.connect();
            stream.write_all(&whole.as_bytes()[..part]).unwrap();
            let answer = read_all(&mut stream);
            assert_status(&answer, 408);
        }
        // A byte now and then does not help.
        let mut stream = client.connect();
        for byte in whole.as_bytes().iter().take(20) {
            if stream.write_all(&[*byte]).is_err() {
                break;
            }
            thread::sleep(Duration::from_millis(30));
        }
        assert_status(&read_all(&mut stream), 408);
        // One that never said anything is closed without a word, and one that did may rest.
        assert_eq!(read_all(&mut client.connect()), "");
        let mut stream = client.connect();
        for _ in 0..2 {
            stream.write_all(whole.as_bytes()).unwrap();
            assert_eq!(body(&read_one(&mut stream)), "body");
            thread::sleep(Duration::from_millis(400));
        }
    });
    assert_eq!(asked, 2);
}

#[test]
fn the_ninth_connection_waits_for_no_one() {
    let asked = with_server(PATIENCE, |client| {
        // Each has begun a request, so none can make room.
        let mut busy: Vec<TcpStream> = (0..MOST_CONNECTIONS)
            .map(|_| {
                let mut stream = client.connect();
                stream.write_all(client.request("POST /echo", "0").as_bytes()).unwrap();
                assert_eq!(body(&read_one(&mut stream)), "0");
                stream.write_all(b"POST ").unwrap();
                stream
            })
            .collect();
        // What was sent may not have been read yet.
        thread::sleep(Duration::from_millis(200));
        let mut ninth = client.connect();
        assert_status(&read_all(&mut ninth), 503);
        for stream in &mut busy {
            let rest = client.request("POST /echo", "still");
            stream.write_all(rest.strip_prefix("POST ").unwrap().as_bytes()).unwrap();
            assert_eq!(body(&read_one(stream)), "still");
        }
        // Now all rest: the one that has rested longest makes room.
        let mut ninth = client.connect();
        ninth.write_all(client.request("POST /echo", "ninth").as_bytes()).unwrap();
        assert_eq!(body(&read_one(&mut ninth)), "ninth");
        assert_eq!(read_all(&mut busy[0]), "");
        for stream in &mut busy[1..] {
            stream.write_all(client.request("POST /echo", "on").as_bytes()).unwrap();
            assert_eq!(body(&read_one(stream)), "on");
        }
    });
    assert_eq!(asked, 8 + 8 + 1 + 7);
}
