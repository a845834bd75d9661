//! `perirobot sensors`: the devices that a study may name, with their values and where those are from. They are in
//! `study::catalogue`.

use std::process::ExitCode;

use perirobot::study::catalogue::{Model, models};
use perirobot::{Error, Result};

/// List the devices that a study may name, with sources
///
/// A [[sensor]] with `model = "realsense-d435"` has the keys of that device; keys that the study writes itself go before
/// them. Values are the makers', as far as they could be had; what could not be compared with a maker's own document is
/// named. Have a look at the data sheet of your device before you rely on any.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  perirobot sensors                      all devices, a line each
  perirobot sensors realsense-d435       one device: its keys, source and notes
  perirobot sensors ouster sick          all devices with these in their names")]
pub(super) struct Args {
    /// Only devices with one of these in their names, and all that is known of them
    #[arg(value_name = "NAME")]
    names: Vec<String>,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    if args.names.is_empty() {
        let lines =
            models().iter().map(|model| format!("{:<26} {:<6} {}\n", model.name, model.kind(), model.title));
        let more = "\n`perirobot sensors NAME` tells values and sources; in a study: model = \"NAME\"\n";
        super::print(&(lines.collect::<String>() + more))?;
        return Ok(ExitCode::SUCCESS);
    }
    for name in &args.names {
        let found: Vec<_> =
            models().iter().filter(|model| model.name.contains(&name.to_lowercase())).collect();
        if found.is_empty() {
            let what = format!("no device has {name:?} in its name: `perirobot sensors` lists all");
            return Err(Error::Input(what));
        }
        found.into_iter().try_for_each(|model| super::print(&told(model)))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// All that is known of a device; its lines can be pasted into a study.
fn told(model: &Model) -> String {
    let mut text = format!("# {}\n# source: {}\n#         {}\n", model.title, model.source, model.url);
    text += &format!("# {}\n", model.note);
    if let Some(unconfirmed) = &model.unconfirmed {
        text += &format!("# not compared with the maker's words: {unconfirmed}\n");
    }
    let keys = model.keys.iter().map(|(key, value)| format!("{key} = {value}\n"));
    format!(
        "{text}model = {:?}\n# which stands for\n{}\n",
        model.name,
        keys.map(|line| format!("#   {line}")).collect::<String>()
    )
}
