//! Mesa's drivers write two lines about XDG_RUNTIME_DIR on standard error where it is not set, as in
//! containers and over ssh. They say nothing about results, so the variable is set here.

/// Starts the program anew in its own process with the variable set, where it is not: to a folder that does
/// not exist, so that nothing is found there. (A process cannot set its own variables without `unsafe`.) If
/// that fails, the program goes on without.
#[cfg(unix)]
pub(super) fn keep_quiet() {
    use std::os::unix::process::CommandExt;

    const VARIABLE: &str = "XDG_RUNTIME_DIR";
    if std::env::var_os(VARIABLE).is_some() {
        return;
    }
    if let Ok(program) = std::env::current_exe() {
        let mut arguments = std::env::args_os();
        let mut again = std::process::Command::new(program);
        if let Some(name) = arguments.next() {
            again.arg0(name);
        }
        // Only returns if it failed.
        let _ = again.args(arguments).env(VARIABLE, "/nonexistent").exec();
    }
}

/// Mesa's drivers are for Unix.
#[cfg(not(unix))]
pub(super) fn keep_quiet() {}
