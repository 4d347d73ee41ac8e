//! Merges the tables of several runs in one folder.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, bail};

use super::rows::{self, Place, Row, Status, all_tables, read};
use super::staging::{RECORD_FILE, StagingFolder, finished};
use super::sweep::Part;
use super::tally::Tally;
use crate::cli::interrupt::{INTERRUPTED, cancel_on_interrupt};
use crate::cli::output::{fail_by, say};
use crate::inference::Cancel;
use crate::io::Inputs;

/// Tables to merge.
#[derive(Debug, Clone, PartialEq)]
pub struct MergeJob {
    /// The folder that several runs wrote to.
    pub folder: PathBuf,
}

impl MergeJob {
    /// Does the job: `results.csv` and `results.jsonl` have a row a finished job
    /// and, from the tables of the runs, one for each that failed or was
    /// stopped. The exit status tells how many failed.
    pub fn run(&self) -> ExitCode {
        match self.work(&cancel_on_interrupt()) {
            Ok(None) => {
                say("stopped; nothing was written");
                ExitCode::from(INTERRUPTED)
            }
            Ok(Some((tally, table))) => {
                tally.conclude(&format!("{}, results in {}\n", tally.summary(), table.display()))
            }
            Err(e) => fail_by(&e),
        }
    }

    /// `None` if it was stopped while it waited for a run of the whole list.
    fn work(&self, cancel: &Cancel) -> anyhow::Result<Option<(Tally, PathBuf)>> {
        must_be_folder(&self.folder)?;
        let about = || format!("cannot read the folder {}", self.folder.display());
        let mut rows: HashMap<String, Row> = HashMap::new();
        // The newest table goes before older ones.
        let name = Part::All.table();
        let tables = all_tables(&self.folder).with_context(about)?;
        let mut inputs = Inputs::default();
        let outputs = rows::paths(&self.folder, &name);
        // Its own tables are made anew; a table of another run that is the same file is not.
        tables.iter().filter(|table| !outputs.contains(table)).for_each(|table| inputs.add(table));
        inputs.check(outputs)?;
        for table in tables {
            let unfinished = read(&table)?.into_iter().filter(|row| row.status != Status::Ok);
            rows.extend(unfinished.map(|row| (row.name.clone(), row)));
        }
        let mut done = Vec::new();
        collect(&self.folder, &mut done).with_context(about)?;
        rows.extend(done.into_iter().map(|row| (row.name.clone(), row)));
        if rows.is_empty() {
            bail!("no results in {}; give the output folder of the runs", self.folder.display());
        }
        let mut rows: Vec<Row> = rows.into_values().collect();
        rows.sort_by(|a, b| (a.job, &a.name).cmp(&(b.job, &b.name)));
        let Some(staging) = StagingFolder::take(&self.folder, &name, cancel)? else { return Ok(None) };
        let table = Place::new(&self.folder, &name, staging.folder()).write(&rows)?;
        Ok(Some((Tally::of(&rows), table)))
    }
}

/// The rows of all finished jobs below a folder.
fn collect(folder: &Path, rows: &mut Vec<Row>) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if !entry.file_type()?.is_dir() || entry.file_name().as_encoded_bytes().starts_with(b".") {
            continue;
        }
        let path = entry.path();
        if path.join(RECORD_FILE).is_file()
            && let Some((row, _)) = finished(&path)
        {
            rows.push(row);
        }
        collect(&path, rows)?;
    }
    Ok(())
}

/// What a folder is asked for that results are to be merged in.
fn must_be_folder(path: &Path) -> anyhow::Result<()> {
    if !path.is_dir() {
        bail!("{} is not a folder; give the output folder of the runs", path.display());
    }
    Ok(())
}
