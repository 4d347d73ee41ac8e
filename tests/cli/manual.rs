//! Completions and manual pages know every command and option.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::needs::skipped;
use crate::process::done;
use clap::CommandFactory as _;
use superform::cli::Cli;

fn superform(args: &[&str]) -> String {
    done(Path::new("."), args).0
}

/// Each command with its long options.
fn commands() -> Vec<(String, Vec<String>)> {
    let of = |command: &clap::Command| {
        let options = command.get_arguments().filter_map(|a| a.get_long().map(str::to_owned)).collect();
        (command.get_name().to_owned(), options)
    };
    Cli::command().get_subcommands().map(of).collect()
}

#[test]
fn every_shell_gets_a_script_with_every_command() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = superform(&["completions", shell]);
        for (command, options) in commands() {
            assert!(script.contains(&command), "{shell} lacks {command}");
            for option in options {
                assert!(script.contains(&option), "{shell} lacks --{option} of {command}");
            }
        }
    }
}

/// Shells that are there read the scripts made for them.
#[test]
fn shells_read_their_scripts() {
    let folder = tempfile::tempdir().unwrap();
    for (shell, check) in [("bash", "-n"), ("zsh", "-n"), ("fish", "--no-execute")] {
        let script = folder.path().join(shell);
        fs::write(&script, superform(&["completions", shell])).unwrap();
        match Command::new(shell).arg(check).arg(&script).output() {
            Ok(output) => assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr)),
            Err(e) => skipped(format!("{shell} is not there ({e})")),
        }
    }
    // What bash offers after `superform run --s`.
    let complete = format!(
        ". {}; COMP_WORDS=(superform run --sw); COMP_CWORD=2; _superform superform --sw run; echo \"${{COMPREPLY[@]}}\"",
        folder.path().join("bash").display()
    );
    match Command::new("bash").args(["--norc", "-c", &complete]).output() {
        Ok(output) => {
            let offered = String::from_utf8_lossy(&output.stdout).into_owned();
            assert!(offered.contains("--sweep"), "{offered} {}", String::from_utf8_lossy(&output.stderr));
        }
        Err(e) => skipped(format!("bash is not there ({e})")),
    }
}

#[test]
fn there_is_a_manual_page_for_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("man1");
    let said = superform(&["man", "-o", place.to_str().unwrap()]);
    let main = superform(&["man"]);
    assert_eq!(fs::read_to_string(place.join("superform.1")).unwrap(), main);
    for (command, options) in commands() {
        assert!(main.contains(&command.replace('-', "\\-")), "the main page lacks {command}");
        let name = format!("superform-{command}.1");
        assert!(said.contains(&name), "{said}");
        let page = fs::read_to_string(place.join(&name)).unwrap();
        for option in options {
            assert!(page.contains(&option.replace('-', "\\-")), "{name} lacks --{option}");
        }
    }
    assert_eq!(fs::read_dir(&place).unwrap().count(), commands().len() + 1);
}
