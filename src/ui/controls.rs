//! The left panel: shape, run and parameters.

use egui::{DragValue, Grid, Label, Response, RichText, Slider, Ui, vec2};

use super::priors;
use super::theme::{self, Palette};
use super::widgets::{
    choice, count, divide, editable, fact, length, primary_button, section, setting, tooltip, verb_button,
};
use crate::geometry::kernel::Distance;
use crate::geometry::{Isolated, Surface};
use crate::inference::parameters::{Number, Taken};
use crate::inference::{MergeRule, Method, PARAMETERS, Parameter, Params, Setting};
use crate::io::ShapeGeometry;
use crate::session::Session;
use crate::session::action::Action;
use crate::session::scene::extent_of;
use crate::session::verb::Verb;
use crate::worker::{Pace, SamplingOptions};

/// Width of the column of labels.
const LABELS: f32 = 104.0;
/// Width of an editable number.
const NUMBER: f32 = 58.0;
/// Display speeds of a run.
pub(super) const PACES: [(Pace, &str); 5] = [
    (Pace::PerSecond(1), "1/s"),
    (Pace::PerSecond(3), "3/s"),
    (Pace::PerSecond(10), "10/s"),
    (Pace::PerSecond(30), "30/s"),
    (Pace::Unlimited, "Max"),
];

pub(super) fn show(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    shape(ui, session, actions);
    divide(ui);
    run(ui, session, actions);
    divide(ui);
    parameters(ui, session, actions);
}

fn shape(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    section(ui, "Shape");
    let Some(loaded) = &session.loaded else {
        ui.label(RichText::new("No shape open").color(Palette::of(ui).weak));
        verb_button(ui, session, Verb::Open, 0.0, actions);
        return;
    };
    let name = ui.add(Label::new(RichText::new(&loaded.shape.name).heading()).truncate());
    if let Some(path) = &loaded.shape.path {
        name.on_hover_text(path.display().to_string());
    }
    Grid::new("shape facts").num_columns(2).min_col_width(LABELS).show(ui, |ui| {
        match &loaded.shape.geometry {
            ShapeGeometry::Mesh(mesh) => {
                let text = format!("mesh, {} triangles", count(mesh.faces.len()));
                fact(ui, "Input", &text).on_hover_text(format!("{} vertices", count(mesh.vertices.len())));
            }
            ShapeGeometry::Cloud(cloud) => {
                fact(ui, "Input", &format!("cloud, {} points", count(cloud.points.len())));
            }
        }
        let size = extent_of(&loaded.cloud.points);
        let text = format!("{} × {} × {}", length(size.x), length(size.y), length(size.z));
        fact(ui, "Size", &text).on_hover_text(format!("{text} along x, y and z, in the file's units"));
    });
    let mut sampling = session.sampling;
    // Seeds have up to 20 digits.
    ui.horizontal_wrapped(|ui| {
        let label = labelled(ui, "Samples");
        let used = count(loaded.cloud.points.len());
        let (least, most) = SamplingOptions::POINTS;
        ui.add(DragValue::new(&mut sampling.points).range(least..=most).speed(20.0))
            .labelled_by(label)
            .on_hover_text(format!(
                "Number of points N sampled from the shape and clustered; {used} in this run"
            ));
        let label = ui.label(RichText::new("seed").color(Palette::of(ui).weak)).id;
        ui.add(DragValue::new(&mut sampling.seed).speed(0.05))
            .labelled_by(label)
            .on_hover_text("Random seed of the sampling");
    });
    let with_note = |tooltip: &str| match loaded.cloud.part.note() {
        Some(note) => format!("{tooltip}. In this run: {note}"),
        None => tooltip.to_owned(),
    };
    if matches!(loaded.shape.geometry, ShapeGeometry::Mesh(_)) {
        let mut outside = sampling.surface == Surface::Outside;
        ui.checkbox(&mut outside, "Only the surface visible from outside")
            .on_hover_text(with_note("Place no samples on inner walls and hidden parts"));
        sampling.surface = if outside { Surface::Outside } else { Surface::All };
    } else {
        let mut leave_out = sampling.isolated == Isolated::LeaveOut;
        ui.checkbox(&mut leave_out, "Leave out isolated points").on_hover_text(with_note(
            "Skip outliers, which have almost no neighbours; points far from all others stay unassigned",
        ));
        sampling.isolated = if leave_out { Isolated::LeaveOut } else { Isolated::Keep };
    }
    // With Live on, it is done without a word.
    let is_due = session.is_enabled(Verb::Resample) && !session.awaits_newer_run();
    if is_due {
        verb_button(ui, session, Verb::Resample, ui.available_width(), actions);
    }
    if sampling != session.sampling {
        actions.push(Action::SetSampling(sampling));
    }
}

fn run(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    section(ui, "Run");
    let gap = ui.spacing().item_spacing.x;
    let width = ui.available_width();
    let half = (width - gap) / 2.0;
    ui.horizontal(|ui| {
        let verb = if session.is_enabled(Verb::Pause) { Verb::Pause } else { Verb::Run };
        primary_button(ui, session, verb, half, actions);
        verb_button(ui, session, Verb::Reset, half, actions);
    });
    ui.horizontal(|ui| {
        ui.spacing_mut().button_padding.x = 4.0;
        let third = (width - 2.0 * gap) / 3.0;
        for (verb, more) in [(Verb::StepIteration, 10.0), (Verb::StepMerge, 0.0), (Verb::MergeAll, -10.0)] {
            verb_button(ui, session, verb, third + more, actions);
        }
    });
    ui.horizontal(|ui| {
        ui.label(RichText::new("Speed").color(Palette::of(ui).weak))
            .on_hover_text("How fast Run and Merge all show their steps. Live results are not slowed down");
        ui.spacing_mut().item_spacing.x = 3.0;
        let width = (ui.available_width() - 3.0 * (PACES.len() - 1) as f32) / PACES.len() as f32;
        for (pace, text) in PACES {
            let tooltip = match pace {
                Pace::PerSecond(1) => "Show one step per second".to_owned(),
                Pace::PerSecond(steps) => format!("Show at most {steps} steps per second"),
                Pace::Unlimited => "Show steps as fast as they are computed".to_owned(),
            };
            if choice(ui, session.pace == pace, text, width).on_hover_text(tooltip).clicked() {
                actions.push(Action::SetPace(pace));
            }
        }
    });
    live(ui, session, actions);
}

/// The check box for Live, with its status.
fn live(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let entry = Verb::ToggleLive.entry();
        let mut on = session.live.is_on;
        if ui.checkbox(&mut on, entry.text).on_hover_text(tooltip(Verb::ToggleLive)).clicked() {
            actions.push(Action::Verb(Verb::ToggleLive));
        }
        let (text, color) = if session.live.is_renewing() {
            ("Updating…", Palette::of(ui).accent)
        } else {
            ("Every change starts a new run", Palette::of(ui).weak)
        };
        if on {
            ui.label(RichText::new(text).small().color(color));
        }
    });
}

fn parameters(ui: &mut Ui, session: &Session, actions: &mut Vec<Action>) {
    section(ui, "Parameters");
    let mut p = session.params;
    method(ui, &p, actions);
    for parameter in &PARAMETERS {
        number(ui, session, &mut p, parameter);
        match parameter.setting {
            Setting::Alpha => priors::tables(ui, session, &p),
            Setting::P0 => priors::distance(ui, session, &p),
            _ => {}
        }
    }
    let before = p;
    where_read(ui, &before, Setting::Seed, |ui| {
        ui.horizontal(|ui| {
            let label = labelled(ui, "Seed");
            ui.add(DragValue::new(&mut p.seed).speed(0.05).update_while_editing(false))
                .labelled_by(label)
                .on_hover_text(after(session, Setting::Seed))
        })
        .inner
    });
    Choices {
        setting: Setting::Merge,
        options: &[
            (
                MergeRule::Energy,
                "Energy",
                "Merge the pair that lowers the energy most: two-way error plus cost of primitives",
            ),
            (
                MergeRule::Paper,
                "Paper's thresholds",
                "Use the thresholds of the paper's authors, largest cluster first",
            ),
            (MergeRule::None, "None", "No merging; Step merge proposes nothing"),
        ],
    }
    .show(ui, session, &mut p, |p| &mut p.merge);
    Choices {
        setting: Setting::FitDistance,
        options: &[
            (
                Distance::FirstOrder,
                "First order",
                "Close to the Euclidean distance, even for thin plates and long rods",
            ),
            (
                Distance::Radial,
                "Radial",
                "The paper's distance, measured along the ray from the primitive's centre",
            ),
        ],
    }
    .show(ui, session, &mut p, |p| &mut p.fit_distance);
    type Field = fn(&mut Params) -> &mut bool;
    let switches: [(Field, Setting); 2] =
        [(|p| &mut p.refine, Setting::Refine), (|p| &mut p.freeze, Setting::Freeze)];
    for (field, setting) in switches {
        let Parameter { label, tooltip, .. } = setting.parameter();
        let before = p;
        where_read(ui, &before, setting, |ui| {
            ui.horizontal(|ui| {
                ui.allocate_space(vec2(LABELS, theme::ROW));
                ui.checkbox(field(&mut p), *label).on_hover_text(*tooltip)
            })
            .inner
        });
    }
    if let (Some(start), false) = (session.stale_start(), session.live.is_renewing()) {
        let text = if start.algorithm == p.algorithm {
            format!(
                "K and seed apply from the next start. This run: K = {}, seed {}.",
                start.clusters, start.seed
            )
        } else {
            format!("Run restarts with the chosen method. Shown now: {}.", start.algorithm.title())
        };
        ui.add(Label::new(RichText::new(text).small().color(Palette::of(ui).accent)).wrap());
    }
    if p != session.params {
        actions.push(Action::SetParams(p));
    }
}

/// The list of methods, with descriptions and references.
fn method(ui: &mut Ui, params: &Params, actions: &mut Vec<Action>) {
    let present = Method::of(params);
    let tooltip = |m: Method| format!("{}.\n{}", m.tooltip(), m.reference());
    ui.horizontal(|ui| {
        let label = labelled(ui, "Method");
        let combo = egui::ComboBox::from_id_salt("method")
            .selected_text(present.map_or("Custom", Method::title))
            .width(ui.available_width() - 8.0)
            .height(400.0_f32.min(0.6 * ui.ctx().content_rect().height()))
            .show_ui(ui, |ui| {
                for m in Method::ALL {
                    let item = ui.selectable_label(present == Some(m), m.title());
                    if item.on_hover_text(tooltip(m)).clicked() {
                        actions.push(Action::SetMethod(m));
                    }
                }
            });
        combo.response.labelled_by(label).on_hover_text(present.map_or_else(
            || "The sampler with your own settings; choose a method to restore its settings".to_owned(),
            tooltip,
        ));
    });
}

/// Shows the control of a parameter; disabled, with the reason as tooltip, if
/// the method does not use it.
fn where_read(ui: &mut Ui, params: &Params, setting: Setting, show: impl FnOnce(&mut Ui) -> Response) {
    let why = params.why_unread(setting);
    ui.add_enabled_ui(why.is_none(), |ui| {
        let response = show(ui);
        if let Some(why) = why {
            response.on_disabled_hover_text(why);
        }
    });
}

/// A label with the common width of all rows; returns its id.
fn labelled(ui: &mut Ui, text: &str) -> egui::Id {
    let height = theme::ROW;
    ui.allocate_ui_with_layout(vec2(LABELS, height), egui::Layout::left_to_right(egui::Align::Center), |ui| {
        ui.set_min_size(vec2(LABELS, height));
        ui.label(RichText::new(text).color(Palette::of(ui).weak)).id
    })
    .inner
}

/// A parameter's tooltip that says when it is taken; with Live on there is
/// nothing to wait for.
fn after(session: &Session, setting: Setting) -> String {
    let Parameter { tooltip, taken, .. } = setting.parameter();
    let when = if session.live.is_on {
        "Live is on: every change starts a new run."
    } else {
        match taken {
            Taken::Iteration => "Takes effect at the next iteration.",
            Taken::Step => "Takes effect at the next step.",
            Taken::Fit => "Takes effect at the next iteration or fit.",
            Taken::Merge => "Takes effect at the next merge and at the end.",
            Taken::Start => "Takes effect at the next start.",
        }
    };
    format!("{tooltip} {when}")
}

/// A parameter with a few choices.
struct Choices<'a, T> {
    setting: Setting,
    /// Value, text and tooltip.
    options: &'a [(T, &'static str, &'static str)],
}

impl<T: Copy + PartialEq> Choices<'_, T> {
    fn show(&self, ui: &mut Ui, session: &Session, params: &mut Params, field: fn(&mut Params) -> &mut T) {
        let before = *params;
        let value = field(params);
        where_read(ui, &before, self.setting, |ui| {
            ui.horizontal(|ui| {
                let text = self.setting.parameter().label;
                let label = labelled(ui, text);
                let chosen = self.options.iter().find(|(v, ..)| v == value).map_or("", |(_, text, _)| text);
                egui::ComboBox::from_id_salt(text)
                    .selected_text(chosen)
                    .width(ui.available_width() - 8.0)
                    .show_ui(ui, |ui| {
                        for (option, text, tooltip) in self.options {
                            ui.selectable_value(value, *option, *text).on_hover_text(*tooltip);
                        }
                    })
                    .response
                    .labelled_by(label)
                    .on_hover_text(after(session, self.setting))
            })
            .inner
        });
    }
}

/// A parameter that is a number: its label, a slider and the number itself.
fn number(ui: &mut Ui, session: &Session, params: &mut Params, parameter: &Parameter) {
    match parameter.number {
        Some(Number::Real(field, range)) => slider(ui, session, params, parameter, field, range),
        Some(Number::Count(field, range)) => slider(ui, session, params, parameter, field, range),
        None => {}
    }
}

fn slider<Num: egui::emath::Numeric>(
    ui: &mut Ui,
    session: &Session,
    params: &mut Params,
    parameter: &Parameter,
    field: fn(&mut Params) -> &mut Num,
    (low, high): (Num, Num),
) {
    let before = *params;
    let value = field(params);
    where_read(ui, &before, parameter.setting, |ui| {
        ui.horizontal(|ui| {
            let label = labelled(ui, parameter.label);
            let gap = ui.spacing().item_spacing.x;
            ui.spacing_mut().slider_width = (ui.available_width() - NUMBER - gap).max(40.0);
            let tooltip = after(session, parameter.setting);
            let slider = ui
                .add(Slider::new(value, low..=high).logarithmic(true).show_value(false))
                .labelled_by(label)
                .on_hover_text(&tooltip);
            let number = if Num::INTEGRAL {
                DragValue::new(value).speed(0.2).update_while_editing(false)
            } else {
                let speed = value.to_f64().abs() * 0.01;
                editable(value, setting).speed(speed)
            };
            let number = ui
                .add_sized([NUMBER, theme::ROW], number.range(low..=high))
                .labelled_by(label)
                .on_hover_text(tooltip);
            slider | number
        })
        .inner
    });
}
