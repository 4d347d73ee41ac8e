//! Shell completions and manual pages.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use clap::CommandFactory;
use clap_complete::Shell;

use super::{Cli, fail_by, folder_for_results, print};
use crate::io;

/// A text that is made from the command line's own description.
#[derive(Debug, Clone, PartialEq)]
pub enum ManualJob {
    /// A script for a shell, which completes commands and options.
    Completions(Shell),
    /// Manual pages: that of the program to standard output, or one a command
    /// into a folder.
    Pages(Option<PathBuf>),
}

impl ManualJob {
    /// Does the job.
    pub fn run(&self) -> ExitCode {
        match self.work() {
            Ok(text) => print(&text),
            Err(e) => fail_by(&e),
        }
    }

    /// What goes to standard output.
    fn work(&self) -> anyhow::Result<String> {
        match self {
            Self::Completions(shell) => {
                let mut text = Vec::new();
                clap_complete::generate(*shell, &mut Cli::command(), "superform", &mut text);
                Ok(String::from_utf8(text)?)
            }
            Self::Pages(None) => Ok(String::from_utf8(page(&clap_mangen::Man::new(described()))?)?),
            Self::Pages(Some(folder)) => write_pages(folder),
        }
    }
}

/// The command line without `help`, which is said in every page.
fn described() -> clap::Command {
    Cli::command().disable_help_subcommand(true)
}

fn page(man: &clap_mangen::Man) -> std::io::Result<Vec<u8>> {
    let mut text = Vec::new();
    man.render(&mut text)?;
    Ok(text)
}

/// Writes a page a command; returns the list of what was written.
fn write_pages(folder: &Path) -> anyhow::Result<String> {
    folder_for_results(folder).map_err(anyhow::Error::msg)?;
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    let mut program = described();
    program.build();
    let commands: Vec<clap::Command> =
        program.get_subcommands().filter(|command| !command.is_hide_set()).cloned().collect();
    let mut written = String::new();
    for command in std::iter::once(program).chain(commands) {
        let man = clap_mangen::Man::new(command);
        let path = folder.join(man.get_filename());
        io::write_whole(&path, &page(&man)?)?;
        written += &format!("wrote {}\n", path.display());
    }
    Ok(written)
}
