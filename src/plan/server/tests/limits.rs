//! Too much, too slow, too many.

use super::super::connections::{MOST_BODY, MOST_CONNECTIONS, MOST_HEAD};
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
        assert_status(&client.ask(with(2 * MOST_HEAD)), 431);
        assert_status(&client.ask(with(3 << 20)), 431);
        let many = "X: 1\r\n".repeat(200);
        let many = client.request("GET /query", "").replacen("\r\n\r\n", &format!("\r\n{many}\r\n"), 1);
        assert_status(&client.ask(many), 431);
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
        // Half a head is closed without a word.
        let mut stream = client.connect();
        stream.write_all(&whole.as_bytes()[..10]).unwrap();
        assert_eq!(read_all(&mut stream), "");
        let mut stream = client.connect();
        stream.write_all(&whole.as_bytes()[..whole.len() - 1]).unwrap();
        assert_status(&read_all(&mut stream), 408);
        // A byte now and then does not help.
        let mut stream = client.connect();
        for byte in whole.as_bytes().iter().take(20) {
            if stream.write_all(&[*byte]).is_err() {
                break;
            }
            thread::sleep(Duration::from_millis(30));
        }
        assert_eq!(read_all(&mut stream), "");
        // So is a connection that rests.
        assert_eq!(read_all(&mut client.connect()), "");
        let mut stream = client.connect();
        for _ in 0..2 {
            stream.write_all(whole.as_bytes()).unwrap();
            assert_eq!(body(&read_one(&mut stream)), "body");
            thread::sleep(Duration::from_millis(50));
        }
        assert_eq!(read_all(&mut stream), "");
    });
    assert_eq!(asked, 2);
}

#[test]
fn idle_connections_make_room_for_a_ninth() {
    let asked = with_server(PATIENCE, |client| {
        let mut open: Vec<TcpStream> = (0..MOST_CONNECTIONS)
            .map(|_| {
                let mut stream = client.connect();
                stream.write_all(client.request("POST /echo", "0").as_bytes()).unwrap();
                assert_eq!(body(&read_one(&mut stream)), "0");
                stream
            })
            .collect();
        // One of them has an answer on its way.
        open[0].write_all(client.request("GET /slow", "").as_bytes()).unwrap();
        thread::sleep(Duration::from_millis(100));
        let begin = Instant::now();
        let mut ninth = client.connect();
        ninth.write_all(client.request("POST /echo", "ninth").as_bytes()).unwrap();
        assert_eq!(body(&read_one(&mut ninth)), "ninth");
        assert!(begin.elapsed() < PATIENCE / 2, "{:?}", begin.elapsed());
        assert_eq!(body(&read_one(&mut open[0])), "slow");
        for stream in &mut open {
            assert_eq!(read_all(stream), "");
        }
    });
    assert_eq!(asked, 8 + 2);
}

#[test]
fn no_more_than_eight_are_served_at_a_time() {
    let asked = with_server(Duration::from_secs(2), |client| {
        let mut busy: Vec<TcpStream> = (0..=MOST_CONNECTIONS)
            .map(|_| {
                let mut stream = client.connect();
                stream.write_all(client.request("GET /slow", "").as_bytes()).unwrap();
                stream
            })
            .collect();
        let begin = Instant::now();
        assert_eq!(body(&read_one(&mut busy[0])), "slow");
        let first = begin.elapsed();
        assert_eq!(body(&read_one(&mut busy[MOST_CONNECTIONS])), "slow");
        // The last was asked only after another was answered.
        assert!(begin.elapsed() >= first + SLOW / 2, "{first:?}, {:?}", begin.elapsed());
    });
    assert_eq!(asked, 9);
}
