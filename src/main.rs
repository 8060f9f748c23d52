//! Parses the command line, calls a stage, prints what went wrong and chooses the exit code.

use clap::Parser;
use miette::Diagnostic;
use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use thinshell::{Error, cli};

fn main() -> ExitCode {
    let command_line = cli::CommandLine::parse();
    let Err(error) = command_line.start_log().and_then(|()| command_line.run()) else { return ExitCode::SUCCESS };
    let code = error.exit_code();
    let plain = plain(&error);
    log::error!(target: cli::FILE_ONLY, "{plain}");
    let text = if std::io::stderr().is_terminal() { graphical(error) } else { plain };
    // Nobody is left to hear about a broken standard error.
    let _ = writeln!(std::io::stderr(), "{text}");
    ExitCode::from(code)
}

/// For a terminal: with the lines of the scene around the fault.
fn graphical(error: Error) -> String {
    // The messages contain their causes already.
    let hook = miette::set_hook(Box::new(|_| Box::new(miette::MietteHandlerOpts::new().without_cause_chain().build())));
    debug_assert!(hook.is_ok(), "nothing else sets the hook");
    format!("{:?}", miette::Report::new(error)).trim_end().to_owned()
}

/// For files and pipes: `error: FILE:LINE:COLUMN: message`, then the advice.
fn plain(error: &Error) -> String {
    let label = error.labels().and_then(|mut labels| labels.next());
    let place = label.zip(error.source_code()).and_then(|(label, text)| {
        let place = text.read_span(label.inner(), 0, 0).ok()?;
        Some(format!("{}:{}:{}: ", place.name().unwrap_or("input"), place.line() + 1, place.column() + 1))
    });
    let help = error.help().map(|help| format!("\n  help: {help}"));
    format!("error: {}{error}{}", place.unwrap_or_default(), help.unwrap_or_default())
}
