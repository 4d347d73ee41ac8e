//! Progress of a batch on standard error.

use std::io::IsTerminal as _;
use std::time::Duration;

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

use crate::cli::headless::primitives;
use crate::cli::job::Stage;
use crate::cli::output::say;
use crate::io::harmless;

/// Bars where standard error is a terminal (one for the whole, and a line a job
/// that is under way), a line a finished job elsewhere, or nothing.
#[derive(Debug)]
pub(super) struct Progress {
    total: usize,
    ended: usize,
    quiet: bool,
    bars: Option<Bars>,
}

#[derive(Debug)]
struct Bars {
    all: MultiProgress,
    whole: ProgressBar,
    workers: Vec<ProgressBar>,
}

/// The line of one worker; does nothing where there are no bars.
#[derive(Debug, Clone, Default)]
pub(super) struct Line(Option<ProgressBar>);

impl Line {
    pub(super) fn begin(&self, name: &str) {
        if let Some(bar) = &self.0 {
            bar.reset();
            bar.set_prefix(harmless(name).into_owned());
            bar.enable_steady_tick(Duration::from_millis(200));
        }
    }

    pub(super) fn show(&self, stage: Stage<'_>) {
        let Some(bar) = &self.0 else { return };
        bar.set_message(match stage {
            Stage::Reading | Stage::Read(_) => "reading".to_owned(),
            Stage::Sampling => "sampling".to_owned(),
            Stage::Starting => "starting".to_owned(),
            Stage::Step { iteration, clusters } => format!("{iteration}: {}", primitives(clusters)),
        });
    }

    pub(super) fn end(&self) {
        if let Some(bar) = &self.0 {
            bar.disable_steady_tick();
            bar.set_prefix("");
            bar.set_message("");
        }
    }
}

impl Progress {
    /// For `total` jobs, `before` of which are done already.
    pub(super) fn new(total: usize, before: usize, workers: usize, quiet: bool) -> Self {
        let bars = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let all = MultiProgress::new();
            let bar = |template: &str, bar: ProgressBar| {
                if let Ok(style) = ProgressStyle::with_template(template) {
                    bar.set_style(style);
                }
                all.add(bar)
            };
            let whole = bar("{bar:30} {pos}/{len} {elapsed} (+{eta}) {msg}", ProgressBar::new(total as u64));
            whole.set_position(before as u64);
            whole.reset_eta();
            let workers = (0..workers)
                .map(|_| bar("{spinner} {prefix} {msg:.dim}", ProgressBar::no_length()))
                .collect();
            Bars { all, whole, workers }
        });
        Self { total, ended: before, quiet, bars }
    }

    pub(super) fn line(&self, worker: usize) -> Line {
        Line(self.bars.as_ref().and_then(|bars| bars.workers.get(worker).cloned()))
    }

    /// Says how a job ended.
    pub(super) fn ended(&mut self, name: &str, how: &str, failed: usize) {
        self.ended += 1;
        match &self.bars {
            Some(bars) => {
                bars.whole.inc(1);
                if failed > 0 {
                    bars.whole.set_message(format!("{failed} failed"));
                }
            }
            None if self.quiet => {}
            None => say(&format!("[{}/{}] {name}: {how}", self.ended, self.total)),
        }
    }

    pub(super) fn finish(self) {
        if let Some(bars) = self.bars {
            bars.workers.iter().for_each(ProgressBar::finish_and_clear);
            bars.whole.finish_and_clear();
            // A terminal that is gone needs no clearing.
            let _ = bars.all.clear();
        }
    }
}
