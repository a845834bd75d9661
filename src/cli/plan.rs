//! `perirobot plan`: a local page to place sensors by hand. Counted, edited and served in `perirobot-plan`.

use std::borrow::Borrow;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread;
use std::time::Duration;

use clap::ValueEnum;
use perirobot_march::backend::factory::BackendChoice;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_plan::gallery::{Gallery, TemplateCard, Templates};
use perirobot_plan::server::{Request, Response, Server};
use perirobot_plan::session::{Session, StudyReader};
use perirobot_scene::source::Sources;
use perirobot_study::input::{Overrides, Study};

use super::backend::BackendArgs;
use super::init::{self, Template};
use super::stop::StopAt;
use super::study::StudyArgs;

/// Place sensors by hand, and see what they watch
///
/// Opens a page in the browser: the cell in 3D and as a floor plan. Add sensors, drag them along their mounting
/// surfaces, turn, copy and remove them; during a drag, the page shows the seen, missed and unknown space, and after
/// each change the verdicts of [[require]], the nearest unnoticed approach and the cost. It finds sets as `perirobot
/// choose` does, in addition to the sensors placed by hand.
///
/// Robots, people and furniture can also be moved. The study and the scene files in its folder are the state: they are
/// written only on Save, comments stay, and `perirobot sweep` of the saved study counts the sensors of the page
/// (combination "planned"). The page is served to this machine only; use ssh -L from another one. Without a study the
/// page starts with the templates of `perirobot init`: choose one to write and open it.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
#[command(mut_arg("study", |arg| arg.required(false)))]
#[command(mut_args(|arg| match arg.get_id().as_str() {
    "voxel_size" | "noiseless" | "packages" | "allow_outside" | "xacro" | "step" | "read_only" => arg.requires("study"),
    _ => arg,
}))]
pub(super) struct Args {
    #[command(flatten)]
    study: Option<StudyArgs>,
    /// The port on 127.0.0.1; 0 takes any free port
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Page")]
    port: u16,
    /// Print the address, but do not open a browser
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
  perirobot plan
      choose one of five cells to begin with
  perirobot plan my-cell/study.toml
      opens the page; Ctrl-C ends it
  perirobot plan my-cell/study.toml --no-open --port 8080
      on a machine without a screen; on the other one:
      ssh -L 8080:127.0.0.1:8080 that-machine";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    args.backend.start_threads()?;
    let backend = args.backend.checked_choice()?;
    let stop = StopAt::listen_saying("the planner ends", None)?;
    let Some(study) = &args.study else {
        let templates = OwnTemplates { backend };
        let gallery = Gallery::new(&templates);
        let end = || gallery.session().into_iter().for_each(Session::stop);
        serve(
            args,
            "The page of cells to begin with",
            gallery.policy(),
            &stop,
            (&|ask| gallery.answer(ask), &end),
        )?;
        gallery.session().into_iter().for_each(warn_if_changed);
        return Ok(ExitCode::SUCCESS);
    };
    let session = Session::open(study.path(), Box::new(Reader(study)), &backend, args.read_only)?;
    let what = study.path().display().to_string();
    serve(args, &what, session.policy(), &stop, (&|ask| session.answer(ask), &|| session.stop()))?;
    warn_if_changed(&session);
    Ok(ExitCode::SUCCESS)
}

/// Answers requests.
type Handler<'h> = &'h (dyn Fn(&Request) -> Response<'h> + Sync);

/// Serves a page until the program ends. `end` stops the running jobs of the handler.
fn serve<'h>(
    args: &Args,
    what: &str,
    policy: &str,
    stop: &StopAt,
    (handler, end): (Handler<'h>, &(dyn Fn() + Sync)),
) -> Result<()> {
    let server = Server::bind(args.port)?.with_policy(policy);
    let url = server.url();
    super::print(&format!("{what} is at {url}\nCtrl-C ends the planner\n"))?;
    // Kept until the planner ends.
    let _page = if args.no_open { None } else { open_browser(&url) };
    thread::scope(|scope| {
        let ending = server.stopper();
        scope.spawn(move || {
            while stop.reason().is_none() {
                thread::sleep(Duration::from_millis(50));
            }
            end();
            ending.stop();
        });
        server.run(handler);
    });
    Ok(())
}

fn warn_if_changed(session: &Session) {
    if session.is_changed() {
        say!("warning: changes were not saved; while the page is open, Copy as TOML has them");
    }
}

/// Reads the study with the arguments of the command line.
struct Reader<S>(S);

impl<S: Borrow<StudyArgs> + Send + Sync> StudyReader for Reader<S> {
    fn read(
        &self,
        text: &str,
        files: &[(PathBuf, String)],
        voxel_size_m: Option<f64>,
    ) -> Result<Study, Vec<Error>> {
        self.0.borrow().examine_text(text, files, voxel_size_m)
    }
}

/// The templates of `perirobot init`.
struct OwnTemplates {
    backend: BackendChoice,
}

impl Templates for OwnTemplates {
    fn cards(&self) -> Vec<TemplateCard> {
        let card = |template: &Template| {
            let value = template.to_possible_value()?;
            let about = value.get_help().map(ToString::to_string).unwrap_or_default();
            let to_improve = template.to_improve().into();
            Some(TemplateCard { name: value.get_name().into(), about, to_improve })
        };
        Template::value_variants().iter().filter_map(card).collect()
    }

    fn study(&self, name: &str) -> Result<Study> {
        let folder = Path::new(name);
        let path = folder.join("study.toml");
        let files = template(name)?.files().into_iter();
        let sources = files.fold(Sources::from_main(&path), |all, (file, text)| {
            all.with_file(&folder.join(file), text.as_bytes().to_vec())
        });
        Study::read(&path, &Overrides::default(), sources)
    }

    fn write(&self, name: &str, folder: &Path) -> Result<PathBuf> {
        init::write_into(folder, template(name)?.files())?;
        Ok(folder.join("study.toml"))
    }

    fn open(&self, study: &Path) -> Result<Session<'_>> {
        let reader = Reader(StudyArgs::from_path(study.into()));
        Session::open(study, Box::new(reader), &self.backend, false)
    }
}

fn template(name: &str) -> Result<Template> {
    Template::from_str(name, false).map_err(|_| {
        let known = Template::value_variants().iter().filter_map(ValueEnum::to_possible_value);
        let known: Vec<String> = known.map(|value| value.get_name().into()).collect();
        let advice = format!("expected one of: {}", known.join(", "));
        Error::from(Issue::says(format!("{name:?} is not a template")).with_advice(advice))
    })
}

/// Opens the page through a file that redirects to it: other users can list command lines, and the address contains the
/// token. Dropping the result removes the file.
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
