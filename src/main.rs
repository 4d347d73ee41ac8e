//! The command line leads to the window or to the job without one.

use std::process::ExitCode;

use clap::CommandFactory as _;
use superform::cli::{self, Cli, Journal, Request, WindowRequest};

fn main() -> ExitCode {
    let journal = cli::start_log();
    let command_line = match Cli::read() {
        Ok(command_line) => command_line,
        Err(exit) => return exit,
    };
    let request = command_line.request();
    if matches!(request, Ok(Request::Render(_) | Request::Window(_))) {
        cli::spare_complaints();
    }
    match request {
        Ok(Request::Headless(job)) => job.run(),
        Ok(Request::Batch(job)) => job.run(),
        Ok(Request::Merge(job)) => job.run(),
        Ok(Request::Manual(job)) => job.run(Cli::command()),
        Ok(Request::Evaluate(job)) => job.run(),
        Ok(Request::Export(job)) => job.run(),
        Ok(Request::Bench(job)) => job.run(),
        Ok(Request::Scaling(job)) => job.run(),
        Ok(Request::Render(job)) => job.run(),
        Ok(Request::Window(request)) => match cli::why_no_display() {
            Some(why) => cli::instead_of_window(request, &why),
            None => open(request, journal),
        },
        Err(problem) => cli::refuse(&problem),
    }
}

#[cfg(not(feature = "window"))]
fn open(request: WindowRequest, _journal: Journal) -> ExitCode {
    cli::instead_of_window(request, "this program was built without a window")
}

#[cfg(feature = "window")]
fn open(request: WindowRequest, journal: Journal) -> ExitCode {
    use std::any::Any;
    use std::panic;

    use superform::app::RunError;

    /// The message of a panic over a library that the window needs at run
    /// time and that isn't installed (libxkbcommon-x11, for one): the window
    /// toolkit knows no other way to say so.
    fn missing_library(payload: &(dyn Any + Send)) -> Option<&str> {
        let text = payload.downcast_ref::<&str>().copied();
        text.or_else(|| payload.downcast_ref::<String>().map(String::as_str))
            .filter(|text| text.contains("could not be loaded"))
    }

    let state_folder = superform::project::user_folder();
    let WindowRequest { source, sampling, params, screenshot, reset_layout } = request.clone();
    let options =
        superform::app::Options { source, sampling, params, screenshot, state_folder, reset_layout };
    let usual = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        if missing_library(info.payload()).is_none() {
            usual(info);
        }
    }));
    let why =
        match panic::catch_unwind(panic::AssertUnwindSafe(|| superform::app::run(options, Some(journal)))) {
            Ok(Ok(())) => return ExitCode::SUCCESS,
            Ok(Err(RunError::NoPicture(problem))) => return cli::fail(&problem),
            Ok(Err(RunError::NoWindow(why))) => why,
            Err(payload) => match missing_library(payload.as_ref()) {
                Some(text) => text.trim_end_matches('.').to_owned(),
                None => panic::resume_unwind(payload),
            },
        };
    cli::instead_of_window(request, &format!("cannot open the window ({why})"))
}
