//! Colours, type scale and spacing. No other file of `ui` defines colours.

use egui::{
    Color32, CornerRadius, FontFamily, FontId, Margin, Stroke, Style, TextStyle, Theme, Visuals, vec2,
};

use crate::render::SceneTheme;
use crate::session::timeline::Mark;
use crate::session::view::ThemeChoice;

/// Height of a row of controls.
pub(super) const ROW: f32 = 22.0;
/// Height of a row in a list that stands by itself.
pub(super) const TALL_ROW: f32 = 26.0;
/// Space between sections.
pub(super) const SECTION_GAP: f32 = 10.0;

/// Colours that egui's visuals have no name for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Palette {
    pub(super) accent: Color32,
    /// Text on `accent`.
    pub(super) on_accent: Color32,
    /// Secondary text.
    pub(super) weak: Color32,
    pub(super) good: Color32,
    pub(super) warn: Color32,
    pub(super) error: Color32,
    /// What floats above the viewport.
    pub(super) overlay: Color32,
    pub(super) axes: [Color32; 3],
    /// In the order of [`Mark::ALL`].
    pub(super) marks: [Color32; Mark::ALL.len()],
    /// Letters on an axis's ball, and those under the pointer.
    pub(super) on_axis: Color32,
    pub(super) on_axis_hot: Color32,
}

const DARK: Palette = Palette {
    accent: Color32::from_rgb(86, 156, 230),
    on_accent: Color32::from_rgb(12, 18, 26),
    weak: Color32::from_rgb(148, 156, 168),
    good: Color32::from_rgb(84, 190, 130),
    warn: Color32::from_rgb(236, 178, 84),
    error: Color32::from_rgb(240, 108, 96),
    overlay: Color32::from_rgb(37, 41, 47),
    axes: [Color32::from_rgb(236, 98, 96), Color32::from_rgb(126, 196, 92), Color32::from_rgb(92, 146, 240)],
    marks: [
        Color32::from_rgb(40, 184, 136),
        Color32::from_rgb(240, 116, 40),
        Color32::from_rgb(236, 176, 40),
        Color32::from_rgb(104, 188, 240),
        Color32::from_rgb(216, 140, 188),
        Color32::from_rgb(232, 236, 240),
    ],
    on_axis: Color32::from_rgb(14, 16, 20),
    on_axis_hot: Color32::from_rgb(255, 255, 255),
};

const LIGHT: Palette = Palette {
    accent: Color32::from_rgb(28, 104, 188),
    on_accent: Color32::from_rgb(255, 255, 255),
    weak: Color32::from_rgb(94, 102, 114),
    good: Color32::from_rgb(24, 132, 76),
    warn: Color32::from_rgb(146, 84, 0),
    error: Color32::from_rgb(190, 44, 36),
    overlay: Color32::from_rgb(252, 253, 254),
    axes: [Color32::from_rgb(206, 52, 52), Color32::from_rgb(62, 138, 34), Color32::from_rgb(40, 92, 206)],
    marks: [
        Color32::from_rgb(0, 128, 92),
        Color32::from_rgb(200, 80, 0),
        Color32::from_rgb(168, 116, 0),
        Color32::from_rgb(24, 124, 184),
        Color32::from_rgb(172, 72, 136),
        Color32::from_rgb(32, 38, 46),
    ],
    on_axis: Color32::from_rgb(255, 255, 255),
    on_axis_hot: Color32::from_rgb(8, 10, 14),
};

impl Palette {
    pub(super) fn of(ui: &egui::Ui) -> Self {
        if ui.visuals().dark_mode { DARK } else { LIGHT }
    }
}

/// The viewport's colours for the present theme.
pub(super) fn scene(ui: &egui::Ui) -> SceneTheme {
    scene_of(ui.visuals().dark_mode)
}

/// The viewport's colours for a theme.
pub(super) fn scene_of(is_dark: bool) -> SceneTheme {
    if is_dark { SceneTheme::dark() } else { SceneTheme::light() }
}

/// The colour of a primitive.
pub(super) fn data_color([r, g, b]: [u8; 3]) -> Color32 {
    Color32::from_rgb(r, g, b)
}

/// Sets both themes up, once.
pub(super) fn install(ctx: &egui::Context) {
    // The session has the zoom; the keys for it are in the table of verbs.
    ctx.options_mut(|options| options.zoom_with_keyboard = false);
    ctx.style_mut_of(Theme::Dark, |style| {
        layout(style);
        style.visuals = visuals(
            Visuals::dark(),
            DARK,
            [Color32::from_rgb(29, 32, 37), Color32::from_rgb(22, 24, 28), Color32::from_rgb(46, 51, 58)],
            Color32::from_rgb(214, 219, 226),
            Color32::from_rgb(56, 62, 70),
        );
    });
    ctx.style_mut_of(Theme::Light, |style| {
        layout(style);
        style.visuals = visuals(
            Visuals::light(),
            LIGHT,
            [
                Color32::from_rgb(243, 245, 247),
                Color32::from_rgb(255, 255, 255),
                Color32::from_rgb(224, 229, 235),
            ],
            Color32::from_rgb(32, 38, 46),
            Color32::from_rgb(205, 211, 219),
        );
    });
}

/// Follows the choice.
pub(super) fn choose(ctx: &egui::Context, choice: ThemeChoice) {
    let preference = match choice {
        ThemeChoice::System => egui::ThemePreference::System,
        ThemeChoice::Light => egui::ThemePreference::Light,
        ThemeChoice::Dark => egui::ThemePreference::Dark,
    };
    if ctx.options(|o| o.theme_preference) != preference {
        ctx.set_theme(preference);
        // This frame's style was taken before.
        ctx.request_repaint();
    }
}

/// Draws everything so much larger than usual.
pub(super) fn zoom(ctx: &egui::Context, factor: f32) {
    if ctx.zoom_factor() != factor {
        ctx.set_zoom_factor(factor);
        ctx.request_repaint();
    }
}

fn layout(style: &mut Style) {
    let font = |size| FontId::new(size, FontFamily::Proportional);
    style.text_styles = [
        (TextStyle::Heading, font(15.0)),
        (TextStyle::Body, font(13.0)),
        (TextStyle::Button, font(13.0)),
        (TextStyle::Small, font(11.0)),
        (TextStyle::Monospace, FontId::new(12.0, FontFamily::Monospace)),
    ]
    .into();
    let spacing = &mut style.spacing;
    spacing.item_spacing = vec2(6.0, 4.0);
    spacing.button_padding = vec2(8.0, 3.0);
    spacing.interact_size = vec2(34.0, ROW);
    spacing.menu_margin = Margin::same(6);
    spacing.window_margin = Margin::same(12);
    spacing.slider_rail_height = 4.0;
    spacing.icon_width = 15.0;
    spacing.combo_width = 80.0;
    spacing.tooltip_width = 320.0;
    spacing.scroll = egui::style::ScrollStyle::thin();
    style.interaction.tooltip_delay = 0.4;
    style.interaction.selectable_labels = false;
    style.animation_time = 0.08;
}

fn visuals(
    mut v: Visuals,
    palette: Palette,
    [panel, sunken, raised]: [Color32; 3],
    text: Color32,
    line: Color32,
) -> Visuals {
    v.panel_fill = panel;
    v.window_fill = palette.overlay;
    v.window_stroke = Stroke::new(1.0, line);
    v.window_corner_radius = CornerRadius::same(6);
    v.menu_corner_radius = CornerRadius::same(5);
    v.extreme_bg_color = sunken;
    v.faint_bg_color = raised.gamma_multiply(0.5);
    v.weak_text_color = Some(palette.weak);
    v.hyperlink_color = palette.accent;
    v.error_fg_color = palette.error;
    v.warn_fg_color = palette.warn;
    v.slider_trailing_fill = true;
    v.selection.bg_fill = palette.accent.gamma_multiply(if v.dark_mode { 0.38 } else { 0.24 });
    v.selection.stroke = Stroke::new(1.0, if v.dark_mode { Color32::WHITE } else { text });
    v.disabled_alpha = 0.42;

    let radius = CornerRadius::same(4);
    let w = &mut v.widgets;
    w.noninteractive.bg_fill = panel;
    w.noninteractive.bg_stroke = Stroke::new(1.0, line);
    w.noninteractive.fg_stroke = Stroke::new(1.0, text);
    w.inactive.fg_stroke = Stroke::new(1.0, text);
    for state in [&mut w.inactive, &mut w.hovered, &mut w.active, &mut w.open] {
        state.corner_radius = radius;
        state.bg_fill = raised;
        state.weak_bg_fill = raised;
        state.bg_stroke = Stroke::NONE;
        state.expansion = 0.0;
    }
    let lift = |amount: f32| raised.lerp_to_gamma(text, amount);
    w.hovered.weak_bg_fill = lift(0.1);
    w.hovered.bg_fill = lift(0.14);
    w.hovered.bg_stroke = Stroke::new(1.0, lift(0.22));
    w.active.weak_bg_fill = lift(0.2);
    w.active.bg_fill = palette.accent;
    // Also what the keyboard has reached is active: it has a ring.
    w.active.bg_stroke = Stroke::new(1.5, palette.accent);
    w.open.weak_bg_fill = lift(0.12);
    w.noninteractive.corner_radius = radius;
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contrast ratio of WCAG 2: (L1 + 0.05) / (L2 + 0.05).
    fn contrast(a: Color32, b: Color32) -> f32 {
        let luminance = |color: Color32| {
            let c = egui::Rgba::from(color);
            0.2126 * c.r() + 0.7152 * c.g() + 0.0722 * c.b()
        };
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn the_contrast_is_the_standards() {
        assert!((contrast(Color32::WHITE, Color32::BLACK) - 21.0).abs() < 0.01);
        assert!((contrast(Color32::from_gray(119), Color32::WHITE) - 4.48).abs() < 0.02);
    }

    #[test]
    fn all_text_can_be_read() {
        let ctx = egui::Context::default();
        install(&ctx);
        for (theme, palette) in [(Theme::Dark, DARK), (Theme::Light, LIGHT)] {
            let style = ctx.style_of(theme);
            let v = &style.visuals;
            let w = &v.widgets;
            let selected = v.panel_fill.blend(v.selection.bg_fill);
            let mut pairs = vec![
                ("text on accent", palette.on_accent, palette.accent),
                ("selected text", v.selection.stroke.color, selected),
                ("text in a field", w.inactive.fg_stroke.color, v.extreme_bg_color),
                ("hint in a field", palette.weak, v.extreme_bg_color),
                ("details of an error", w.noninteractive.fg_stroke.color, v.extreme_bg_color),
            ];
            for ground in [v.panel_fill, palette.overlay] {
                pairs.extend([
                    ("text", w.noninteractive.fg_stroke.color, ground),
                    ("weak text", palette.weak, ground),
                    ("accent", palette.accent, ground),
                    ("warning", palette.warn, ground),
                    ("error", palette.error, ground),
                    ("chosen row", w.noninteractive.fg_stroke.color, ground.blend(v.selection.bg_fill)),
                ]);
            }
            for (name, state) in
                [("button", w.inactive), ("hovered", w.hovered), ("pressed", w.active), ("open", w.open)]
            {
                pairs.push((name, state.fg_stroke.color, state.weak_bg_fill));
            }
            for (name, text, ground) in pairs {
                let ratio = contrast(text, ground);
                assert!(ratio >= 4.5, "{name} in {theme:?}: {text:?} on {ground:?} has {ratio:.2} : 1");
            }
            // What is no text: marks, rings and dots.
            for mark in [palette.good, palette.accent, palette.axes[0], palette.axes[1], palette.axes[2]] {
                assert!(contrast(mark, v.panel_fill) >= 3.0, "{mark:?} in {theme:?}");
            }
        }
    }
}
