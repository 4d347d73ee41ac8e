//! The command palette: finds commands by a few letters, runs them with Enter.

use egui::{
    Align2, Context, FontId, Key, Label, Modal, Modifiers, RichText, Role, ScrollArea, Sense, TextEdit,
    TextWrapMode, Ui, WidgetInfo, WidgetText, vec2,
};

use super::controls::PACES;
use super::fuzzy;
use super::theme::{self, Palette};
use crate::inference::Method;
use crate::session::Session;
use crate::session::action::Action;
use crate::session::scene::UpAxis;
use crate::session::verb::Verb;
use crate::session::view::{ColorBy, Layer, SurfaceStyle};
use crate::worker::Pace;

const WIDTH: f32 = 560.0;
/// Number of visible rows.
const ROWS: f32 = 12.0;

/// An entry.
#[derive(Debug)]
struct Item {
    name: String,
    /// Its category.
    group: &'static str,
    tooltip: String,
    shortcut: Option<String>,
    action: Action,
    /// Why it is not available.
    reason: Option<&'static str>,
    is_on: bool,
}

/// The open palette.
#[derive(Debug, Default)]
pub(super) struct Commands {
    query: String,
    chosen: usize,
    is_open: bool,
}

impl Commands {
    pub(super) fn show(&mut self, ctx: &Context, session: &Session, actions: &mut Vec<Action>) {
        if !session.window.shows_commands {
            self.is_open = false;
            return;
        }
        let is_new = !std::mem::replace(&mut self.is_open, true);
        if is_new {
            *self = Self { is_open: true, ..Self::default() };
        }
        let items = found(items(session), &self.query, &session.window.commands);
        let moved = self.move_by_keys(ctx, items.len());
        let window = ctx.content_rect();
        let width = WIDTH.min(window.width() - 32.0);
        let id = egui::Id::unique("all commands");
        let area_top = (0.1 * window.height()).min(90.0);
        let area = Modal::default_area(id).anchor(Align2::CENTER_TOP, vec2(0.0, area_top));
        let frame = egui::Frame::popup(&ctx.global_style()).inner_margin(10.0);
        let mut picked = None;
        let modal = Modal::new(id).area(area).frame(frame).show(ctx, |ui| {
            ui.set_width(width - 20.0);
            let field = TextEdit::singleline(&mut self.query)
                .hint_text("Search all commands")
                .desired_width(f32::INFINITY)
                .margin(egui::Margin::symmetric(8, 6));
            let field = ui.add(field);
            field.request_focus();
            if field.changed() {
                self.chosen = 0;
            }
            ui.add_space(6.0);
            if items.is_empty() {
                ui.label(RichText::new("No matching commands").color(Palette::of(ui).weak));
            }
            ui.spacing_mut().item_spacing.y = 0.0;
            // Below it stands how it is used.
            let used = area_top + ui.cursor().top() - ui.min_rect().top();
            let height = (ROWS * theme::TALL_ROW).min(window.height() - used - 60.0).max(theme::TALL_ROW);
            let area = ScrollArea::vertical().max_height(height).min_scrolled_height(height);
            area.auto_shrink([false, true]).show(ui, |ui| {
                for (index, item) in items.iter().enumerate() {
                    let is_chosen = index == self.chosen;
                    let response = row(ui, item, is_chosen);
                    if is_chosen && (moved || is_new) {
                        response.scroll_to_me(None);
                    }
                    // The pointer chooses where it moves, not where it rests.
                    if response.hovered() && ui.input(|i| i.pointer.delta() != egui::Vec2::ZERO) {
                        self.chosen = index;
                    }
                    if response.clicked() {
                        picked = Some(index);
                    }
                }
            });
            ui.add_space(6.0);
            let help = "Arrow keys to choose, Enter to run, Esc to close";
            ui.add(Label::new(RichText::new(help).small().color(Palette::of(ui).weak)).wrap());
        });
        if ctx.input(|i| i.key_pressed(Key::Enter)) {
            picked = picked.or(Some(self.chosen));
        }
        let chosen = picked.and_then(|index| items.into_iter().nth(index));
        if let Some(item) = chosen.filter(|item| item.reason.is_none()) {
            actions.push(Action::Verb(Verb::ShowCommands));
            actions.push(Action::FromList(item.name, Box::new(item.action)));
        } else if modal.should_close() {
            actions.push(Action::Verb(Verb::ShowCommands));
        }
    }

    /// Whether the choice has changed.
    fn move_by_keys(&mut self, ctx: &Context, count: usize) -> bool {
        let last = count.saturating_sub(1);
        let before = self.chosen;
        let pressed = |key| ctx.input_mut(|i| i.consume_key(Modifiers::NONE, key));
        if pressed(Key::ArrowDown) {
            self.chosen = if self.chosen >= last { 0 } else { self.chosen + 1 };
        }
        if pressed(Key::ArrowUp) {
            self.chosen = self.chosen.checked_sub(1).unwrap_or(last);
        }
        if pressed(Key::PageDown) {
            self.chosen += ROWS as usize;
        }
        if pressed(Key::PageUp) {
            self.chosen = self.chosen.saturating_sub(ROWS as usize);
        }
        self.chosen = self.chosen.min(last);
        self.chosen != before
    }
}

fn row(ui: &mut Ui, item: &Item, is_chosen: bool) -> egui::Response {
    let enabled = item.reason.is_none();
    let size = vec2(ui.available_width(), theme::TALL_ROW);
    let (rect, response) = ui.allocate_exact_size(size, Sense::CLICK);
    response.widget_info(|| WidgetInfo::selected(Role::Button, enabled, is_chosen, &item.name));
    if ui.is_rect_visible(rect) {
        let palette = Palette::of(ui);
        if is_chosen {
            ui.painter().rect_filled(rect, 4.0, ui.visuals().selection.bg_fill);
        }
        let inner = rect.shrink2(vec2(8.0, 0.0));
        let is_strong = enabled || is_chosen;
        let color = if is_strong { ui.visuals().text_color() } else { palette.weak };
        let right = match (item.reason, &item.shortcut) {
            (Some(reason), _) => reason.to_owned(),
            (None, Some(shortcut)) => shortcut.clone(),
            (None, None) => item.group.to_owned(),
        };
        let truncated = |text: &str, width: f32, size: f32| {
            let font = FontId::proportional(size);
            WidgetText::from(text).into_galley(ui, Some(TextWrapMode::Truncate), width, font)
        };
        let right = truncated(&right, 0.62 * inner.width(), 11.5);
        let mark = if item.is_on { 14.0 } else { 0.0 };
        let left = truncated(&item.name, inner.width() - right.size().x - 14.0 - mark, 13.0);
        let y = |galley: &egui::Galley| rect.center().y - 0.5 * galley.size().y;
        let left_size = left.size();
        ui.painter().galley(egui::pos2(inner.left(), y(&left)), left, color);
        if item.is_on {
            let center = egui::pos2(inner.left() + left_size.x + 9.0, rect.center().y);
            ui.painter().circle_filled(center, 3.0, palette.accent);
        }
        let x = inner.right() - right.size().x;
        // Weak text would be too weak on what is chosen.
        let color = if is_chosen { ui.visuals().text_color() } else { palette.weak };
        ui.painter().galley(egui::pos2(x, y(&right)), right, color);
    }
    response.on_hover_text(item.reason.unwrap_or(&item.tooltip))
}

/// All commands without arguments.
fn items(session: &Session) -> Vec<Item> {
    let verbs = Verb::ALL.iter().filter(|verb| **verb != Verb::ShowCommands).map(|&verb| {
        let entry = verb.entry();
        Item {
            name: entry.text.to_owned(),
            group: entry.group.text(),
            tooltip: entry.tooltip.to_owned(),
            shortcut: entry.shortcut.map(|shortcut| shortcut.to_string()),
            action: Action::Verb(verb),
            reason: session.reason(verb),
            is_on: session.is_on(verb) == Some(true),
        }
    });
    let plain = |name: String, group: &'static str, tooltip: String, action: Action, is_on: bool| Item {
        name,
        group,
        tooltip,
        shortcut: None,
        action,
        reason: None,
        is_on,
    };
    let present = Method::of(&session.params);
    let methods = Method::ALL.into_iter().map(|method| {
        let name = format!("Method: {}", method.title());
        plain(name, "Method", method.tooltip().to_owned(), Action::SetMethod(method), present == Some(method))
    });
    let paces = PACES.into_iter().map(|(pace, _)| {
        let name = match pace {
            Pace::PerSecond(1) => "Speed: 1 step per second".to_owned(),
            Pace::PerSecond(steps) => format!("Speed: {steps} steps per second"),
            Pace::Unlimited => "Speed: maximum".to_owned(),
        };
        let tooltip = "How fast Run and Merge all show their steps".to_owned();
        plain(name, "Run", tooltip, Action::SetPace(pace), session.pace == pace)
    });
    let styles = SurfaceStyle::ALL.into_iter().map(|style| {
        let name = format!("Draw primitives {}", style.text().to_lowercase());
        let is_on = session.view.surface_style == style;
        plain(name, "View", "How primitives are drawn".to_owned(), Action::SetSurfaceStyle(style), is_on)
    });
    let colors = ColorBy::ALL.into_iter().map(|by| {
        let name = match by {
            ColorBy::Plain => "Colour points in one colour".to_owned(),
            _ => format!("Colour points by {}", by.text().to_lowercase()),
        };
        let is_on = session.view.color_by == by;
        plain(name, "View", by.tooltip().to_owned(), Action::SetColorBy(by), is_on)
    });
    let layers = Layer::ALL.into_iter().map(|layer| {
        let shown = session.view.shows(layer);
        let name = format!("{} {}", if shown { "Hide" } else { "Show" }, layer.text().to_lowercase());
        plain(name, "Layer", "Show or hide this layer".to_owned(), Action::SetLayer(layer, !shown), false)
    });
    let axes = [(UpAxis::Y, "Y is up"), (UpAxis::Z, "Z is up")].into_iter().map(|(axis, name)| {
        let tooltip = "Which axis of the file points up".to_owned();
        plain(name.to_owned(), "View", tooltip, Action::SetUpAxis(axis), session.view.up == axis)
    });
    let recent = session.window.recent.iter().map(|path| {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let action = Action::OpenRecent(path.to_owned());
        plain(format!("Open {name}"), "Recent file", path.display().to_string(), action, false)
    });
    verbs
        .chain(methods)
        .chain(paces)
        .chain(styles)
        .chain(colors)
        .chain(layers)
        .chain(axes)
        .chain(recent)
        .collect()
}

/// Commands that match the query, best first; without a query all of them, recently used first.
fn found(items: Vec<Item>, query: &str, used: &[String]) -> Vec<Item> {
    let recency = |item: &Item| used.iter().position(|name| *name == item.name).unwrap_or(usize::MAX);
    let mut scored: Vec<(i32, usize, Item)> = items
        .into_iter()
        .filter_map(|item| {
            let in_name = fuzzy::score(query, &item.name);
            // What the tooltip says counts less than any name.
            let elsewhere = || {
                let text = format!("{} {}", item.group, item.tooltip).to_lowercase();
                let words = query.split_whitespace().all(|word| text.contains(&word.to_lowercase()));
                words.then_some(-1000)
            };
            Some((in_name.or_else(elsewhere)?, recency(&item), item))
        })
        .collect();
    // Stable: what is equal stays in the order of the table.
    scored.sort_by_key(|(score, recency, _)| (std::cmp::Reverse(*score), *recency));
    scored.into_iter().map(|(_, _, item)| item).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::Params;
    use crate::worker::SamplingOptions;

    fn names(query: &str, used: &[&str]) -> Vec<String> {
        let session = Session::new(Params::default(), SamplingOptions::default());
        let used: Vec<String> = used.iter().map(|name| (*name).to_owned()).collect();
        found(items(&session), query, &used).into_iter().map(|item| item.name).collect()
    }

    #[test]
    fn each_has_its_own_name() {
        let mut all = names("", &[]);
        let count = all.len();
        assert!(count > Verb::ALL.len() + Method::ALL.len());
        all.sort();
        all.dedup();
        assert_eq!(all.len(), count, "two commands share a name");
    }

    #[test]
    fn a_few_letters_find_a_command() {
        for (query, first) in [
            ("run", "Run"),
            ("stme", "Step merge"),
            ("merge all", "Merge all"),
            ("dark", "Dark theme"),
            ("wire", "Draw primitives wire"),
            ("exag", "Export again"),
        ] {
            assert_eq!(names(query, &[]).first().map(String::as_str), Some(first), "{query}");
        }
        assert!(names("arXiv licence paper", &[]).is_empty());
        assert_eq!(
            names("licence", &[]).first().map(String::as_str),
            Some("About Superform"),
            "by its tooltip"
        );
        assert!(names("qqq", &[]).is_empty());
    }

    #[test]
    fn what_was_used_last_comes_first() {
        let all = names("", &["Quit", "Z is up"]);
        assert_eq!(all[..2], ["Quit", "Z is up"]);
        // But not before what fits better.
        assert_eq!(names("run", &["Quit"])[0], "Run");
    }
}
