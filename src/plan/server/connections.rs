//! The open connections: few at a time, each request within its limits of size and time.

use std::convert::Infallible;
use std::pin::pin;
use std::sync::{Arc, mpsc};
use std::time::Duration;

use http_body_util::{BodyExt, Limited};
use hyper::body::Incoming;
use hyper::header::HeaderValue;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::{TcpListener, TcpStream};
use tokio::select;
use tokio::sync::{Semaphore, oneshot, watch};
use tokio::time::{sleep, timeout};

use super::guard::Guard;
use super::jobs::{Job, Sent, begin};
use super::message::{Request, Response};

/// The header that says what a page may do.
pub(super) const POLICY: &str = "content-security-policy";
/// Most connections at a time.
pub(super) const MOST_CONNECTIONS: usize = 8;
/// Most bytes of a head.
pub(super) const MOST_HEAD: usize = 64 << 10;
/// Most bytes of a body.
pub(super) const MOST_BODY: usize = 1 << 20;
/// How long a connection may wait for a head, and how long its body may take.
pub(super) const PATIENCE: Duration = Duration::from_secs(10);
/// How long to wait for room before idle connections make it.
const PAUSE: Duration = Duration::from_millis(50);

/// What holds for all requests.
pub(super) struct Rules {
    pub(super) guard: Guard,
    /// The Content-Security-Policy.
    pub(super) policy: String,
    pub(super) patience: Duration,
}

/// Serves connections until it is stopped, and waits for the responses on their way.
pub(super) async fn serve(
    listener: TcpListener,
    rules: Arc<Rules>,
    jobs: mpsc::Sender<Job>,
    mut stop: watch::Receiver<bool>,
) {
    let slots = Arc::new(Semaphore::new(MOST_CONNECTIONS));
    // Ends connections once their response on its way is sent.
    let ending = watch::Sender::new(());
    loop {
        let accepted = select! {
            accepted = listener.accept() => accepted,
            _ = stop.wait_for(|is_stopped| *is_stopped) => break,
        };
        let Ok((stream, _)) = accepted else {
            sleep(PAUSE).await;
            continue;
        };
        if timeout(PAUSE, slots.acquire()).await.is_err() {
            ending.send_replace(());
        }
        let slot = select! {
            slot = slots.clone().acquire_owned() => slot.expect("never closed"),
            _ = stop.wait_for(|is_stopped| *is_stopped) => break,
        };
        let (rules, jobs, ended) = (rules.clone(), jobs.clone(), ending.subscribe());
        tokio::spawn(async move {
            converse(stream, rules, jobs, ended).await;
            drop(slot);
        });
    }
    drop(listener);
    ending.send_replace(());
    let _ = timeout(PATIENCE, slots.acquire_many(MOST_CONNECTIONS as u32)).await;
}

/// Answers the requests of a connection.
async fn converse(
    stream: TcpStream,
    rules: Arc<Rules>,
    jobs: mpsc::Sender<Job>,
    mut ended: watch::Receiver<()>,
) {
    let _ = stream.set_nodelay(true);
    let mut builder = http1::Builder::new();
    builder.timer(TokioTimer::new()).header_read_timeout(rules.patience).max_buf_size(MOST_HEAD);
    builder.half_close(true).title_case_headers(true).auto_date_header(false);
    let service = service_fn(|request| async {
        let mut response = ask(request, &rules, &jobs).await.unwrap_or_else(|refusal| {
            let mut response = begin(refusal).0;
            response.headers_mut().insert("connection", HeaderValue::from_static("close"));
            response
        });
        let fields = response.headers_mut();
        if !fields.contains_key(POLICY) {
            fields.insert(POLICY, HeaderValue::from_str(&rules.policy).expect("ASCII"));
        }
        for (name, value) in [
            ("x-content-type-options", "nosniff"),
            ("cache-control", "no-store"),
            ("referrer-policy", "no-referrer"),
            ("cross-origin-resource-policy", "same-origin"),
            ("cross-origin-opener-policy", "same-origin"),
        ] {
            fields.insert(name, HeaderValue::from_static(value));
        }
        Ok::<_, Infallible>(response)
    });
    let mut connection = pin!(builder.serve_connection(TokioIo::new(stream), service));
    select! {
        _ = &mut connection => return,
        _ = ended.changed() => connection.as_mut().graceful_shutdown(),
    }
    let _ = connection.await;
}

/// The response of the handler; or why the request is not handled.
async fn ask(
    request: hyper::Request<Incoming>,
    rules: &Rules,
    jobs: &mpsc::Sender<Job>,
) -> Result<Sent, Response<'static>> {
    let (head, body) = request.into_parts();
    let method = rules.guard.check(&head)?;
    let body = timeout(rules.patience, Limited::new(body, MOST_BODY).collect()).await;
    let body = body.map_err(|_| Response::error(408, "the request was not finished in time"))?;
    let body = body.map_err(|_| Response::error(413, "the body of a request has at most 1 MiB"))?.to_bytes();
    let query = head.uri.query().unwrap_or_default().into();
    let request = Request { method, path: head.uri.path().into(), query, body: body.to_vec() };
    let (reply, replied) = oneshot::channel();
    let gone = || Response::error(503, "the planner ends");
    jobs.send(Job { request, reply }).map_err(|_| gone())?;
    replied.await.map_err(|_| gone())
}
