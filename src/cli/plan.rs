//! `perirobot plan`: a local page in which sensors are placed by hand. Counted, edited and served in `perirobot-plan`.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::thread;
use std::time::Duration;

use clap::ValueEnum;
use perirobot_march::{Error, Result};
use perirobot_plan::server::Server;
use perirobot_plan::session::{Session, StudyReader};
use perirobot_study::input::Study;

use super::backend::BackendArgs;
use super::init::Template;
use super::stop::StopAt;
use super::study::StudyArgs;

/// Place sensors by hand, and see what they watch
///
/// Opens a page in the browser: the cell in 3D and as a floor plan. Sensors are added, dragged along the surfaces that
/// they are mounted on, turned, copied and removed; while one is dragged, the page shows what is seen, missed and
/// unknown, and after each change the verdicts of [[require]], the nearest unnoticed approach and the cost. It finds
/// sets as `perirobot choose` does, beside the sensors that a person placed.
///
/// Robots, people and furniture can be moved, too. The study and the scene files in its folder are the state: they are
/// written only on Save, comments stay, and `perirobot sweep` of the saved study counts what the page showed
/// (combination "planned"). The page is served to this machine only; from another one use ssh -L. Without a study the templates of `perirobot init` are listed.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
#[command(mut_arg("study", |arg| arg.required(false)))]
#[command(mut_args(|arg| match arg.get_id().as_str() {
    "voxel_size" | "noiseless" | "packages" | "allow_outside" | "xacro" | "port" | "no_open" | "read_only" => {
        arg.requires("study")
    }
    _ => arg,
}))]
pub(super) struct Args {
    #[command(flatten)]
    study: Option<StudyArgs>,
    /// The port on 127.0.0.1; 0 takes any that is free
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Page")]
    port: u16,
    /// Print the address only, and open no browser
    #[arg(long, help_heading = "Page")]
    no_open: bool,
    /// Never write the study and its scene files
    #[arg(long, help_heading = "Page")]
    read_only: bool,
    #[command(flatten)]
    backend: BackendArgs,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot init --template palletiser my-cell
  perirobot plan my-cell/study.toml
      opens the page; Ctrl-C ends it
  perirobot plan my-cell/study.toml --no-open --port 8080
      on a machine without a screen; on the other one:
      ssh -L 8080:127.0.0.1:8080 that-machine";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let Some(study) = &args.study else {
        super::print(&templates())?;
        return Ok(ExitCode::SUCCESS);
    };
    args.backend.start_threads()?;
    let stop = StopAt::listen_saying("the planner ends", None)?;
    let reader = Reader(study);
    let session = Session::open(study.path(), &reader, &args.backend.checked_choice()?, args.read_only)?;
    let server = Server::bind(args.port)?.with_policy(session.policy());
    let url = server.url();
    super::print(&format!("{} is at {url}\nCtrl-C ends the planner\n", study.path().display()))?;
    // Held until the planner ends.
    let _page = if args.no_open { None } else { open_browser(&url) };
    thread::scope(|scope| {
        let (ending, stop, session) = (server.stopper(), &stop, &session);
        scope.spawn(move || {
            while stop.reason().is_none() {
                thread::sleep(Duration::from_millis(50));
            }
            session.stop();
            ending.stop();
        });
        server.run(|request| session.answer(request));
    });
    if session.is_changed() {
        say!("warning: changes were not saved; the page has their text as long as it is open (Copy as TOML)");
    }
    Ok(ExitCode::SUCCESS)
}

/// The cells to begin with.
fn templates() -> String {
    let mut text = String::from("Name a study, or begin with one of these cells:\n");
    for template in Template::value_variants() {
        let Some(value) = template.to_possible_value() else { continue };
        let about = value.get_help().map(ToString::to_string).unwrap_or_default();
        text += &format!("  {:<12} {about}\n", value.get_name());
    }
    text + "as in:\n  perirobot init --template palletiser my-cell\n  perirobot plan my-cell/study.toml\n"
}

/// Reads the study as the command line says.
struct Reader<'a>(&'a StudyArgs);

impl StudyReader for Reader<'_> {
    fn read(
        &self,
        text: &str,
        files: &[(PathBuf, String)],
        voxel_size_m: Option<f64>,
    ) -> Result<Study, Vec<Error>> {
        self.0.examine_text(text, files, voxel_size_m)
    }
}

/// Opens the page by a file that leads to it, so that the token is in no command line that others may list. The file is
/// gone when what is returned is dropped.
fn open_browser(url: &str) -> Option<tempfile::NamedTempFile> {
    let page = format!(
        "<!doctype html><meta charset=\"utf-8\"><title>perirobot plan</title>\
         <meta http-equiv=\"refresh\" content=\"0; url={url}\"><a href=\"{url}\">perirobot plan</a>\n"
    );
    let made = tempfile::Builder::new().prefix("perirobot-plan-").suffix(".html").tempfile();
    let file = made.and_then(|mut file| file.write_all(page.as_bytes()).map(|()| file));
    match file {
        Ok(file) => match open::that_detached(file.path()) {
            Ok(()) => Some(file),
            Err(e) => {
                say!("warning: no browser was opened ({e}): open the address above in one");
                None
            }
        },
        Err(e) => {
            say!("warning: no browser was opened ({e}): open the address above in one");
            None
        }
    }
}
