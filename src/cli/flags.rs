//! Writes arguments in messages as flags.

use perirobot_march::Error;
use perirobot_march::error::Argument;

/// The text of an error with flags of the program.
pub(super) fn to_text(error: &Error) -> String {
    error.issue().to_text(&flag)
}

fn flag(argument: Argument) -> String {
    format!("--{}", argument.0.replace(' ', "-"))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::CommandFactory;

    #[test]
    fn each_argument_of_the_library_is_a_flag() {
        let program = super::super::Cli::command();
        let arguments = || program.get_subcommands().flat_map(|command| command.get_arguments());
        let mut found = 0;
        for text in sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src")) {
            for rest in text.split("Argument(\"").skip(1) {
                let flag = format!("--{}", rest.split('"').next().unwrap().replace(' ', "-"));
                let known =
                    arguments().filter_map(|known| known.get_long()).any(|long| flag == format!("--{long}"));
                assert!(known || flag == "--{}", "no command has {flag}");
                found += 1;
            }
        }
        assert!(found > 60, "{found} arguments: are they found?");
    }

    /// The texts of the Rust files below a folder.
    fn sources(folder: &Path) -> Vec<String> {
        let mut texts = Vec::new();
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                texts.extend(sources(&path));
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                texts.push(std::fs::read_to_string(path).unwrap());
            }
        }
        texts
    }
}
