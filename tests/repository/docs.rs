//! README and docs say what the program does: options, defaults, limits,
//! formats, methods and commands are compared with the program's own.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use clap::{CommandFactory as _, Parser as _};
use superform::cli::Cli;
use superform::inference::{Method, PARAMETERS};
use superform::io::Format;

use crate::guide::targets;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn page(name: &str) -> String {
    // Some systems check text out with their own line ends.
    fs::read_to_string(root().join(name)).unwrap().replace("\r\n", "\n")
}

/// README and all pages of docs, by their names.
fn pages() -> BTreeMap<String, String> {
    let mut found = BTreeMap::from([("README.md".to_owned(), page("README.md"))]);
    for folder in ["docs", "docs/guide"] {
        for entry in fs::read_dir(root().join(folder)).unwrap() {
            let name = format!("{folder}/{}", entry.unwrap().file_name().to_str().unwrap());
            if name.ends_with(".md") {
                found.insert(name.clone(), page(&name));
            }
        }
    }
    assert!(found.len() > 10, "only {} pages", found.len());
    found
}

/// What stands in backticks within lines, and all of the indented lines.
fn code(text: &str) -> Vec<&str> {
    let mut found: Vec<&str> = text.lines().filter(|line| line.starts_with("    ")).collect();
    for paragraph in text.split("\n\n").filter(|p| !p.starts_with("    ")) {
        found.extend(paragraph.split('`').skip(1).step_by(2));
    }
    found
}

/// Each option of the program with the default that its help tells, by command.
fn options() -> BTreeMap<String, BTreeMap<String, Option<String>>> {
    let of = |command: &clap::Command| {
        let default = |argument: &clap::Arg| {
            let told = argument.get_help().map(ToString::to_string).unwrap_or_default();
            let told =
                told.split_once("[default: ").map(|(_, rest)| rest.split([']', ';', ',']).next().unwrap());
            let known = argument.get_default_values().first().map(|value| value.to_str().unwrap().to_owned());
            known.or(told.map(str::to_owned))
        };
        command
            .get_arguments()
            .flat_map(|argument| {
                let names = argument.get_long_and_visible_aliases().unwrap_or_default();
                let all = argument.get_all_aliases().unwrap_or_default();
                names.into_iter().chain(all).map(move |name| (format!("--{name}"), default(argument)))
            })
            .collect()
    };
    let cli = Cli::command();
    let mut found: BTreeMap<_, _> =
        cli.get_subcommands().map(|command| (command.get_name().to_owned(), of(command))).collect();
    found.insert(String::new(), of(&cli));
    found
}

#[test]
fn every_option_that_is_named_is_one() {
    let known: BTreeSet<String> = options().into_values().flat_map(BTreeMap::into_keys).collect();
    // Of other programs, in lines that call these.
    let others = ["cargo", "install.sh", "callgrind", "docker", "python3", "sbatch", "srun", "pip", "perf"];
    // Of an example, and what every command has.
    let more = ["--chunk", "--help", "--version"];
    let mut checked = 0;
    for (name, text) in pages() {
        for code in code(&text).into_iter().filter(|code| !others.iter().any(|other| code.contains(other))) {
            for word in
                code.split([' ', '\n', '[', ']', '=', '\'', '"', '(', ')']).filter(|w| w.starts_with("--"))
            {
                let bare = word.trim_end_matches(['.', ',', ';', ':']);
                if bare.len() > 2 && !more.contains(&bare) {
                    assert!(known.contains(bare), "{name} names {bare}, which no command has: {code}");
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 60, "only {checked} options were found");
}

/// The rows of a page's tables of options, each with the heading above it.
fn rows(text: &str) -> Vec<(String, Vec<String>)> {
    let (mut heading, mut in_table, mut found) = (String::new(), false, Vec::new());
    for line in text.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            heading = title.to_owned();
        }
        in_table = line.starts_with('|') && (in_table || line.starts_with("| option |"));
        if in_table && line.starts_with("| `") {
            let cells = line.trim_matches('|').split(" | ").map(|cell| cell.trim().to_owned());
            found.push((heading.clone(), cells.collect()));
        }
    }
    found
}

#[test]
fn defaults_in_the_tables_are_the_programs() {
    let all = options();
    let mut compared = 0;
    for (heading, cells) in rows(&page("docs/command-line.md")) {
        let command = match heading.as_str() {
            command @ ("run" | "render" | "bench") => command,
            other => panic!("whose options are those of “{other}”?"),
        };
        let defaults: Vec<String> = cells.get(1).map_or_else(Vec::new, |cell| {
            let first = cell.split(';').next().unwrap();
            first.split(',').map(|part| part.trim().replace('`', "")).collect()
        });
        for (number, option) in cells[0].split('`').skip(1).step_by(2).enumerate() {
            let name = option.split([' ', '=']).next().unwrap();
            if !name.starts_with("--") {
                continue;
            }
            let default = all[command].get(name).unwrap_or_else(|| panic!("{command} has no {name}"));
            // A default of many words is told in other words than in the help.
            let told = defaults.get(number).filter(|told| !told.contains(' '));
            let (Some(default), Some(told)) = (default, told) else { continue };
            if !told.is_empty() && !default.contains(' ') {
                let same =
                    told == default || told.parse::<f64>().is_ok_and(|told| default.parse() == Ok(told));
                assert!(
                    same,
                    "docs/command-line.md: {name} of {command} is {told} by default; the program has {default}"
                );
                compared += 1;
            }
        }
    }
    assert!(compared >= 14, "only {compared} defaults were compared");
}

#[test]
fn commands_in_the_pages_can_be_given() {
    let mut given = 0;
    for (name, text) in pages() {
        for line in text.lines().filter_map(|line| line.strip_prefix("    ")) {
            let line = line.trim_start_matches("cargo run --release -- ");
            let Some(rest) = line.strip_prefix("superform ") else { continue };
            let words = rest.split(" > ").next().unwrap().split(" | ").next().unwrap().split_whitespace();
            let words = words.map(|word| word.trim_matches('\''));
            // What stands for one's own, and optional parts, are no commands.
            if rest.contains('[') || rest.contains('…') || rest.contains('$') || rest.ends_with('\\') {
                continue;
            }
            if let Err(e) = Cli::try_parse_from(std::iter::once("superform").chain(words)) {
                let shown = matches!(
                    e.kind(),
                    clap::error::ErrorKind::DisplayHelp | clap::error::ErrorKind::DisplayVersion
                );
                assert!(shown, "{name}: {line}: {e}");
            }
            given += 1;
        }
    }
    assert!(given > 15, "only {given} commands were found");
}

#[test]
fn limits_in_the_guide_are_the_programs() {
    let text = page("docs/guide/parameters.md");
    let number = |text: &str| -> f64 { if text == "10⁻⁶" { 1e-6 } else { text.parse().unwrap() } };
    for parameter in PARAMETERS.iter().filter(|p| p.number.is_some()) {
        let (heading, limits) = (format!("## {}", parameter.label), parameter.setting.range());
        let part = text.split(&heading).nth(1).unwrap_or_else(|| panic!("no {heading}"));
        let part = part.split("\n## ").next().unwrap().replace('\n', " ");
        let (low, high) = part.split("From ").nth(1).and_then(|rest| rest.split_once(" to ")).unwrap();
        let high = high.split([' ', '!']).next().unwrap().trim_end_matches('.');
        assert_eq!((number(low), number(high)), limits, "{heading}");
    }
}

#[test]
fn methods_and_formats_are_those_that_there_are() {
    let readme = page("README.md");
    let methods = page("docs/method.md");
    let guide = page("docs/guide/parameters.md");
    for method in Method::ALL {
        assert!(
            methods.contains(&format!("\n| `{}` |", method.name())),
            "docs/method.md lacks {}",
            method.name()
        );
        assert!(guide.contains(&format!("\n| {} |", method.title())), "the guide lacks {}", method.title());
    }
    let count = format!("exported in {} formats", Format::ALL.len());
    assert!(readme.replace('\n', " ").contains(&count), "README: there are {} formats", Format::ALL.len());
    let formats = page("docs/formats.md");
    for format in Format::ALL {
        let ending = format.ending();
        assert!(formats.contains(&format!(".{ending}")), "docs/formats.md doesn't know .{ending}");
    }
    let version = env!("CARGO_PKG_RUST_VERSION");
    for name in ["README.md", "docs/installing.md"] {
        assert!(page(name).contains(&format!("Rust {version}")), "{name} names another Rust than {version}");
    }
}

#[test]
fn links_and_pictures_are_there() {
    for (name, text) in pages() {
        let folder = root().join(Path::new(&name).parent().unwrap());
        for target in
            targets(&text).iter().filter(|target| !target.starts_with("http") && !target.starts_with('#'))
        {
            let file = target.split('#').next().unwrap();
            assert!(folder.join(file).exists(), "{name} points to {target}, which is not there");
        }
    }
}
