//! Two states side by side, with their differences painted and counted.

use std::sync::Arc;

use egui::{
    Align2, ComboBox, FontId, Grid, Layout, Popup, PopupCloseBehavior, Rect, RichText, Slider, TextStyle, Ui,
    UiBuilder, pos2, vec2,
};

use super::scene::SceneView;
use super::theme::Palette;
use super::timeline::value_text;
use super::viewport::Viewport;
use super::widgets::{close_button, count};
use crate::geometry::palette::Colors;
use crate::inference::{align_labels, disagreement};
use crate::session::Session;
use crate::session::action::Action;
use crate::session::comparison::{Compared, Comparison};
use crate::session::curves::Curve;
use crate::session::view::{Layer, View};
use crate::worker::Snapshot;

/// Space between the two views.
const GAP: f32 = 2.0;
/// Accessible name of the view.
const NAME: &str = "3D view of the other state";

/// Differences between two states, by their keys.
#[derive(Debug)]
struct Difference {
    keys: (u64, u64),
    /// For each sample; `None` where the states label different samples.
    disagrees: Option<Arc<[bool]>>,
    /// Of the other state's primitives: those of the shown one's that they stand
    /// for.
    colors: Arc<Colors>,
}

impl Difference {
    fn between(shown: &Snapshot, session: &Session, other: &Compared<'_>) -> Self {
        let keys = (shown.key, other.snapshot.key);
        if !other.same_samples {
            return Self { keys, disagrees: None, colors: Arc::clone(&other.branch.colors) };
        }
        let (here, there) = (&shown.abstraction.labels, &other.snapshot.abstraction.labels);
        let places = session.timeline.current().map(|b| Arc::clone(&b.colors)).unwrap_or_default();
        let kept = align_labels(here, there).into_iter().map(|(b, a)| (b, places.place(a))).collect();
        let ids = other.snapshot.abstraction.primitives.iter().map(|p| p.id);
        Self {
            keys,
            disagrees: Some(disagreement(here, there).into()),
            colors: Arc::new(Colors::new(kept, ids)),
        }
    }

    /// Of the samples, those that belong to different primitives.
    fn share(&self) -> Option<f64> {
        let marks = self.disagrees.as_ref()?;
        Some(marks.iter().filter(|m| **m).count() as f64 / marks.len().max(1) as f64)
    }
}

/// The second view and what it was made from.
#[derive(Debug, Default)]
pub(super) struct Compare {
    viewport: Option<Viewport>,
    difference: Option<Difference>,
}

impl Compare {
    /// Fills the remaining space with one or two views.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        session: &Session,
        first: &mut Viewport,
        actions: &mut Vec<Action>,
    ) {
        let (Some(comparison), Some(other), Some(shown)) =
            (session.comparison, session.compared(), &session.snapshot)
        else {
            // Its pipelines and points take memory.
            *self = Self::default();
            first.show(ui, &SceneView::of(session), actions);
            return;
        };
        let keys = (shown.key, other.snapshot.key);
        let is_known = self
            .difference
            .as_ref()
            .is_some_and(|d| d.keys == keys && d.disagrees.is_some() == other.same_samples);
        if !is_known {
            self.difference = Some(Difference::between(shown, session, &other));
        }
        let Some(difference) = &self.difference else { return };
        bar(ui, session, &comparison, &other, difference, actions);

        let painted = if comparison.paints_disagreement { difference.disagrees.as_ref() } else { None };
        // Surfaces would hide what is painted on the points.
        let view = if painted.is_some() { points_only(&session.view) } else { session.view };
        let (left, right) = halves(ui.available_rect_before_wrap());
        let second = self.viewport.get_or_insert_with(|| first.another(NAME));
        let scene = SceneView { view: &view, disagrees: painted, ..SceneView::of(session) };
        ui.scope_builder(UiBuilder::new().max_rect(left), |ui| first.show(ui, &scene, actions));
        let scene = SceneView {
            loaded: Some(&other.branch.loaded),
            snapshot: Some(other.snapshot),
            colors: Arc::clone(&difference.colors),
            camera: if comparison.is_linked { &session.camera } else { &session.other_camera },
            selection: &Default::default(),
            hidden: &Default::default(),
            lit: Vec::new(),
            draft: None,
            handles: None,
            ghosts: Vec::new(),
            ..scene
        };
        let mut theirs = Vec::new();
        ui.scope_builder(UiBuilder::new().max_rect(right), |ui| second.show(ui, &scene, &mut theirs));
        actions.extend(theirs.into_iter().filter_map(|action| from_other(action, &comparison, &other)));
        if let Some(branch) = session.timeline.current() {
            let names = ["A", &branch.name, &session.timeline.shown_name().to_string()];
            caption(ui, session, left, names, shown);
        }
        caption(ui, session, right, ["B", &other.branch.name, &other.name().to_string()], other.snapshot);
    }
}

/// Actions in the other view, as far as they apply there.
fn from_other(action: Action, comparison: &Comparison, other: &Compared<'_>) -> Option<Action> {
    match action {
        Action::Orbit { .. }
        | Action::Pan(_)
        | Action::Zoom { .. }
        | Action::SetPivot(_)
        | Action::Verb(_) => {
            Some(if comparison.is_linked { action } else { Action::InOther(Box::new(action)) })
        }
        Action::SelectPoints { .. } if other.same_samples => Some(action),
        // Ids mean something else in another state.
        _ => None,
    }
}

fn points_only(view: &View) -> View {
    let mut view = *view;
    view.set_layer(Layer::Points, true);
    view.set_layer(Layer::Primitives, false);
    view
}

/// Side by side, or stacked if that leaves more space for each.
fn halves(rect: Rect) -> (Rect, Rect) {
    if rect.width() >= rect.height() {
        let middle = rect.center().x.round();
        (
            Rect::from_min_max(rect.min, pos2(middle - 0.5 * GAP, rect.max.y)),
            Rect::from_min_max(pos2(middle + 0.5 * GAP, rect.min.y), rect.max),
        )
    } else {
        let middle = rect.center().y.round();
        (
            Rect::from_min_max(rect.min, pos2(rect.max.x, middle - 0.5 * GAP)),
            Rect::from_min_max(pos2(rect.min.x, middle + 0.5 * GAP), rect.max),
        )
    }
}

/// Controls for the compared state, and the disagreement.
fn bar(
    ui: &mut Ui,
    session: &Session,
    comparison: &Comparison,
    other: &Compared<'_>,
    difference: &Difference,
    actions: &mut Vec<Action>,
) {
    let mut wanted = *comparison;
    let fill = ui.visuals().panel_fill;
    egui::Frame::new().fill(fill).inner_margin(egui::Margin::symmetric(8, 3)).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            let label = ui.label(RichText::new("Compare with").color(Palette::of(ui).weak)).id;
            ComboBox::from_id_salt("branch beside")
                .selected_text(&other.branch.name)
                .width(96.0)
                .show_ui(ui, |ui| {
                    for branch in session.timeline.branches() {
                        if ui.selectable_label(branch.id == wanted.branch, &branch.name).clicked() {
                            wanted = Comparison { branch: branch.id, index: None, ..wanted };
                        }
                    }
                })
                .response
                .labelled_by(label)
                .on_hover_text("The branch shown on the right as B");
            state_slider(ui, other, &mut wanted);
            ui.checkbox(&mut wanted.is_linked, "Link cameras").on_hover_text("Move both cameras together");
            ui.add_enabled(
                other.same_samples,
                egui::Checkbox::new(&mut wanted.paints_disagreement, "Paint disagreement"),
            )
            .on_hover_text(
                "Highlight the samples that belong to different primitives in A and B. Primitives are first \
                 matched one to one so that as many samples as possible agree",
            )
            .on_disabled_hover_text("Not available: A and B label different samples");
            let share = difference.share().map_or_else(|| "–".to_owned(), |s| format!("{:.1} %", 100.0 * s));
            ui.label(RichText::new(format!("Disagreement {share}")).strong())
                .on_hover_text("Share of the samples that belong to different primitives in A and B");
            let button = ui.button("A | B").on_hover_text("Metrics of both states");
            Popup::menu(&button)
                .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
                .show(|ui| table(ui, session, other));
            ui.with_layout(Layout::right_to_left(egui::Align::Center), |ui| {
                if close_button(ui, "Stop comparing").clicked() {
                    actions.push(Action::Compare(None));
                }
            });
        });
    });
    if wanted != *comparison {
        actions.push(Action::Compare(Some(wanted)));
    }
}

fn state_slider(ui: &mut Ui, other: &Compared<'_>, wanted: &mut Comparison) {
    let last = other.branch.states.len().saturating_sub(1);
    let mut index = other.index;
    ui.spacing_mut().slider_width = 90.0;
    let slider = ui.add_enabled(last > 0, Slider::new(&mut index, 0..=last).show_value(false));
    slider.widget_info(|| egui::WidgetInfo::slider(last > 0, index as f64, "State of B"));
    let slider = slider.on_disabled_hover_text("This branch has only one state");
    if slider.on_hover_text("Which state of the branch to show; the right end is the latest").changed() {
        wanted.index = (index < last).then_some(index);
    }
    ui.label(other.name().to_string());
}

/// Metrics of both states.
fn table(ui: &mut Ui, session: &Session, other: &Compared<'_>) {
    let Some(shown) = &session.snapshot else { return };
    let weak = Palette::of(ui).weak;
    Grid::new("figures of both").num_columns(3).spacing([18.0, 2.0]).show(ui, |ui| {
        let row = |ui: &mut Ui, name: &str, value: &dyn Fn(&Snapshot) -> String| {
            ui.label(RichText::new(name).color(weak));
            ui.label(value(shown));
            ui.label(value(other.snapshot));
            ui.end_row();
        };
        let here = session.timeline.current().map_or("", |b| &b.name);
        ui.label("");
        ui.label(RichText::new(format!("A  {here}")).strong());
        ui.label(RichText::new(format!("B  {}", other.branch.name)).strong());
        ui.end_row();
        ui.label(RichText::new("State").color(weak));
        ui.label(session.timeline.shown_name().to_string());
        ui.label(other.name().to_string());
        ui.end_row();
        for curve in Curve::ALL {
            row(ui, curve.text(), &|state| value_text(session, curve, state));
        }
        row(ui, "IoU", &|state| {
            let metrics = session.measurement_of(state.key).and_then(|m| m.result.as_ref().ok());
            metrics.and_then(|m| m.iou).map_or_else(|| "–".to_owned(), |iou| format!("{iou:.3}"))
        });
        row(ui, "Unassigned", &|state| count(state.abstraction.figures.unassigned));
        row(ui, "Computing time", &|state| format!("{:.2} s", state.elapsed.as_secs_f64()));
    });
}

/// Caption of a view in its upper left corner: its letter, branch and state.
fn caption(ui: &mut Ui, session: &Session, rect: Rect, [letter, branch, name]: [&str; 3], state: &Snapshot) {
    let palette = Palette::of(ui);
    let figures = [Curve::Clusters, Curve::MeanError, Curve::Chamfer].map(|c| value_text(session, c, state));
    let [clusters, error, chamfer] = figures;
    let text = format!("{name}\nK {clusters}  error {error}  Chamfer {chamfer}");
    let font = FontId::proportional(TextStyle::Small.resolve(ui.style()).size);
    let title = ui.painter().layout_no_wrap(
        format!("{letter}  {branch}"),
        TextStyle::Body.resolve(ui.style()),
        ui.visuals().strong_text_color(),
    );
    let body = ui.painter().layout(text.clone(), font, palette.weak, (rect.width() - 90.0).max(60.0));
    let size = vec2(title.size().x.max(body.size().x), title.size().y + body.size().y) + vec2(16.0, 10.0);
    let place = Align2::LEFT_TOP.anchor_size(rect.min + vec2(8.0, 8.0), size);
    let response = ui.interact(place, ui.scope_id().with(("caption", letter)), egui::Sense::hover());
    let name = format!("{letter} {branch}, {}", text.replace('\n', ", "));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &name));
    let painter = ui.painter().with_clip_rect(rect);
    painter.rect_filled(place, 4.0, palette.overlay.gamma_multiply(0.85));
    let at = place.min + vec2(8.0, 5.0);
    let below = at + vec2(0.0, title.size().y);
    painter.galley(at, title, palette.weak);
    painter.galley(below, body, palette.weak);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longer_side_is_halved() {
        for size in [vec2(900.0, 400.0), vec2(300.0, 500.0)] {
            let rect = Rect::from_min_size(pos2(10.0, 20.0), size);
            let (a, b) = halves(rect);
            assert!(!a.intersects(b) && rect.contains_rect(a) && rect.contains_rect(b));
            assert!((a.area() - b.area()).abs() < 1e3 && a.union(b) == rect);
            assert!(a.width().min(a.height()) >= 0.4 * size.min_elem());
        }
    }
}
