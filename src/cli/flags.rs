//! How the program writes arguments in messages: as flags.

use perirobot_march::Error;
use perirobot_march::error::Argument;

/// An error in the program's words.
pub(super) fn told(error: &Error) -> String {
    error.issue().told(&flag)
}

fn flag(argument: Argument) -> String {
    format!("--{}", argument.name().replace(' ', "-"))
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn each_argument_of_the_library_is_a_flag() {
        let program = super::super::Cli::command();
        let arguments = || program.get_subcommands().flat_map(|command| command.get_arguments());
        for &argument in Argument::ALL {
            let flag = flag(argument);
            let known =
                arguments().filter_map(|known| known.get_long()).any(|long| flag == format!("--{long}"));
            assert!(known, "no command has {flag}");
        }
    }
}
