//! Who may depend on whom: modules as the table in `src/lib.rs` has it, files within a
//! module in no circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::code::{Crate, Source, names_crate};

/// Crates that only some places may name, by the start of the path below src.
const CRATES: [(&[&str], &[&str]); 2] = [
    (&["egui", "eframe", "egui_wgpu", "egui_plot", "rfd"], &["app", "ui", "pictures/lettering"]),
    (&["wgpu"], &["app", "render", "ui/viewport"]),
];

/// The one file that writes to standard output, where what gets lost is noticed.
const STANDARD_OUTPUT: &str = "io/write/standard.rs";

/// Each module with those that it may use, as the documentation has it.
fn allowed(documentation: &str) -> BTreeMap<String, BTreeSet<String>> {
    let names = |cell: &str| -> Vec<String> {
        let marked = cell.split('`').skip(1).step_by(2);
        marked.filter_map(|name| name.split("::").next()).map(str::to_owned).collect()
    };
    let rows = documentation.lines().filter_map(|line| {
        let cells: Vec<&str> = line.strip_prefix("//! | ")?.split('|').collect();
        Some((names(cells[0]).pop()?, cells.get(2).copied()?))
    });
    let rows: Vec<(String, &str)> = rows.collect();
    let mut table: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (module, cell) in &rows {
        let mut may = BTreeSet::new();
        if cell.trim() == "all" {
            may.extend(rows.iter().map(|(other, _)| other.clone()));
        }
        for name in names(cell) {
            // Those that others use stand above them.
            if cell.contains("what it uses") || cell.contains("what they use") {
                may.extend(table.get(&name).into_iter().flatten().cloned());
            }
            may.insert(name);
        }
        table.insert(module.clone(), may);
    }
    table
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

#[test]
fn modules_depend_only_on_what_the_table_allows() {
    let all = Crate::read(&root());
    assert!(all.sources.len() > 20, "only {} files below {}", all.sources.len(), root().display());
    let table = allowed(&fs::read_to_string(root().join("lib.rs")).unwrap());
    let mut faults = Vec::new();
    for (module, Source { name, tokens }) in &all.sources {
        for (crates, places) in CRATES {
            for used in crates.iter().filter(|c| names_crate(tokens, c)) {
                if !places.iter().any(|p| name.starts_with(p)) {
                    faults.push(format!("{name} names {used}, which belongs to {places:?}"));
                }
            }
        }
        let prints = |way: &&[&str; 2]| tokens.windows(2).any(|pair| pair == way.as_slice());
        let ways = [["stdout", "("], ["print", "!"], ["println", "!"]];
        if let Some(way) = ways.iter().find(|way| name != STANDARD_OUTPUT && prints(way)) {
            faults.push(format!("{name} uses {}, which is for {STANDARD_OUTPUT}", way.concat()));
        }
        let top = module[0].as_str();
        if ["main", "lib"].contains(&top) {
            continue;
        }
        let Some(allowed) = table.get(top) else {
            faults.push(format!("{name} is in no module of the table"));
            continue;
        };
        for used in all.named(module).filter_map(|path| path.into_iter().next()) {
            if used != top && table.contains_key(&used) && !allowed.contains(&used) {
                faults.push(format!("{name} uses crate::{used}, which {top} may not"));
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn files_of_a_module_use_one_another_in_no_circle() {
    let all = Crate::read(&root());
    let modules: BTreeSet<&String> = all.sources.keys().map(|module| &module[0]).collect();
    let mut faults = Vec::new();
    for top in modules.into_iter() {
        if let Some(circle) = all.circle(top) {
            let files: Vec<&str> = circle.iter().map(|module| all.sources[module].name.as_str()).collect();
            faults.push(format!("{} use one another in a circle: move what they share", files.join(" → ")));
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

/// The layers of a module as its documentation has them, the highest first.
fn layers(documentation: &str) -> Vec<Vec<String>> {
    let rows = documentation.lines().filter_map(|line| line.strip_prefix("//! | `")?.split('|').next());
    rows.map(|cell| format!("`{cell}").split('`').skip(1).step_by(2).map(str::to_owned).collect()).collect()
}

#[test]
fn layers_of_a_module_use_only_those_below_them() {
    let all = Crate::read(&root());
    let tops: BTreeSet<&str> = all.sources.keys().map(|module| module[0].as_str()).collect();
    let mut faults = Vec::new();
    let mut seen = 0;
    for top in tops {
        let documentation = fs::read_to_string(root().join(top).join("mod.rs")).unwrap_or_default();
        if !documentation.contains("//! | layer |") {
            continue;
        }
        let layers = layers(&documentation);
        let rank = |name: &str| layers.iter().position(|layer| layer.iter().any(|module| module == name));
        for (module, source) in all.sources.iter().filter(|(module, _)| module[0] == top) {
            let Some(own) = module.get(1).filter(|own| *own != "tests") else { continue };
            let own_rank = rank(own).unwrap_or_else(|| panic!("{own} is no layer of src/{top}/mod.rs"));
            for path in all.named(module).filter(|path| path.len() > 1 && path[0] == top) {
                seen += 1;
                if rank(&path[1]).is_none_or(|used| used < own_rank) {
                    let path = path.join("::");
                    faults.push(format!("{} uses {path}, which is no layer below {own}", source.name));
                }
            }
        }
    }
    assert!(seen > 100, "only {seen} uses were found");
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn the_table_is_read_as_it_is_meant() {
    let table = allowed(
        "//! | module | what lives there | may use |\n//! |---|---|---|\n\
         //! | [`low`] | numbers | nothing of ours |\n//! | [`mid`] | `io` and more | `low` |\n\
         //! | `high` | panels | `mid::part`, and what they use |\n//! | `top` | the rest | all |",
    );
    let may = |module: &str| table[module].iter().map(String::as_str).collect::<Vec<_>>();
    assert_eq!((may("low"), may("mid"), may("high")), (vec![], vec!["low"], vec!["low", "mid"]));
    assert_eq!(may("top"), ["high", "low", "mid", "top"]);
}
