//! What `docs/batch.md` and the Slurm script tell people to type works.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::batch_common::*;

fn repository() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The indented blocks of a page, without their indentation.
fn blocks(page: &str) -> Vec<String> {
    let mut blocks: Vec<String> = Vec::new();
    let mut inside = false;
    for line in page.lines() {
        match line.strip_prefix("    ") {
            Some(code) if inside => blocks.last_mut().unwrap().push_str(&format!("{code}\n")),
            Some(code) => blocks.push(format!("{code}\n")),
            None => {}
        }
        inside = line.starts_with("    ");
    }
    blocks
}

/// A box as a mesh.
fn write_mesh(path: &Path) {
    let mut text = String::new();
    for i in 0..8 {
        text.push_str(&format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2));
    }
    for [a, b, c, d] in [[1, 2, 4, 3], [5, 6, 8, 7], [1, 2, 6, 5], [3, 4, 8, 7], [1, 3, 7, 5], [2, 4, 8, 6]] {
        text.push_str(&format!("f {a} {b} {c} {d}\n"));
    }
    fs::write(path, text).unwrap();
}

/// The shapes that the page is about.
fn prepare(folder: &Path) {
    write_box(&folder.join("shapes/table.ply"), 3);
    write_mesh(&folder.join("shapes/chair.obj"));
}

/// The program under its own name, in the PATH.
fn path_with_program() -> String {
    let program = Path::new(env!("CARGO_BIN_EXE_superform"));
    format!("{}:{}", program.parent().unwrap().display(), std::env::var("PATH").unwrap_or_default())
}

#[test]
fn the_commands_of_the_page_work() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    prepare(folder);
    let page = fs::read_to_string(repository().join("docs/batch.md")).unwrap();
    let mut commands = 0;
    for block in blocks(&page) {
        if block.starts_with("input,") {
            fs::write(folder.join("jobs.csv"), &block).unwrap();
        } else if block.starts_with("{\"input\"") {
            fs::write(folder.join("jobs.jsonl"), &block).unwrap();
        }
        for line in block.lines().filter(|line| line.starts_with("superform ")) {
            // Fewer samples: the page is about something else.
            let line = if line.starts_with("superform run") {
                format!("{line} --points 300")
            } else {
                line.to_owned()
            };
            let output = Command::new("sh")
                .args(["-c", &line])
                .current_dir(folder)
                .env("PATH", path_with_program())
                .output()
                .unwrap();
            assert!(output.status.success(), "{line}: {}", text(&output.stderr));
            commands += 1;
        }
    }
    assert_eq!(commands, 10, "the page has other commands than this test knows of");
    for job in [
        "results/chair",
        "sweep/table/alpha=0.5,p0=0.1",
        "seeds/chair/seed=5",
        "shared/chair/alpha=0.3,seed=2",
    ] {
        assert!(folder.join(job).join("job.json").is_file(), "{job}");
    }
    assert!(folder.join("results/furniture/table/primitives.json").is_file());
    let merged = table(&folder.join("shared/results.csv"));
    assert_eq!(column(&merged, "status"), ["ok"; 3]);
    // The columns that the page names are those that there are.
    for name in merged[0].keys() {
        assert!(page.contains(&format!("`{name}`")), "the page does not tell what {name} is");
    }
}

#[test]
fn an_array_of_slurm_covers_the_list() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let mut list = "input\n".to_owned();
    for number in 0..7 {
        write_box(&folder.join(format!("{number}.xyz")), number);
        list.push_str(&format!("{number}.xyz\n"));
    }
    fs::write(folder.join("jobs.csv"), list).unwrap();
    let task = |id: u32, count: u32| {
        Command::new("bash")
            .arg(repository().join("examples/slurm/array.sbatch"))
            .args(["jobs.csv", "results"])
            .current_dir(folder)
            .env("PATH", path_with_program())
            .env("SLURM_CPUS_PER_TASK", "1")
            .env("SLURM_ARRAY_TASK_ID", id.to_string())
            .env("SLURM_ARRAY_TASK_MIN", "1")
            .env("SLURM_ARRAY_TASK_MAX", "3")
            .env("SLURM_ARRAY_TASK_COUNT", count.to_string())
            .output()
            .unwrap()
    };
    for id in 1..=3 {
        let output = task(id, 3);
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    assert_eq!(job_folders(&folder.join("results")).len(), 7);
    let (said, _) = done(folder, &["merge-results", "results"]);
    assert!(said.contains("7 jobs: 7 done"), "{said}");
    // An array with gaps would leave jobs out.
    let output = task(1, 2);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("gaps"));
}
