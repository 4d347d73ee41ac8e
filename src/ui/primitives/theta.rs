//! The parameters θ of a primitive as values to drag and type.

use egui::{Key, RichText, Ui, vec2};

use crate::geometry::Superquadric;
use crate::inference::Primitive;
use crate::session::Session;
use crate::session::action::Action;
use crate::session::shaping::{ShapeDraft, ShapeLimits};
use crate::ui::theme::{self, Palette};
use crate::ui::widgets::{editable, length};

/// Width of the column of labels.
const LABELS: f32 = 78.0;
const GAP: f32 = 4.0;

/// The edited values: the shape, and its rotation as angles in radians.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Theta {
    shape: Superquadric,
    angles: [f64; 3],
}

/// A line of numbers.
#[derive(Debug, Clone, Copy)]
enum Line {
    Exponents,
    SemiAxes,
    Center,
    Rotation,
    Taper,
}

impl Line {
    const ALL: [Self; 5] = [Self::Exponents, Self::SemiAxes, Self::Center, Self::Rotation, Self::Taper];

    fn label(self) -> &'static str {
        match self {
            Self::Exponents => "Exponents ε",
            Self::SemiAxes => "Semi-axes a",
            Self::Center => "Centre t",
            Self::Rotation => "Rotation R",
            Self::Taper => "Taper k",
        }
    }

    /// Accessible names, also used in tests.
    fn names(self) -> &'static [&'static str] {
        match self {
            Self::Exponents => &["Exponent ε1", "Exponent ε2"],
            Self::SemiAxes => &["Semi-axis ax", "Semi-axis ay", "Semi-axis az"],
            Self::Center => &["Centre tx", "Centre ty", "Centre tz"],
            Self::Rotation => &["Rotation about x", "Rotation about y", "Rotation about z"],
            Self::Taper => &["Taper kx", "Taper ky"],
        }
    }

    fn tooltip(self) -> &'static str {
        match self {
            Self::Exponents => {
                "ε1 shapes the profile from pole to pole, ε2 the cross-section at the equator. Near 0: box; \
                 1: round; near 2: octahedron"
            }
            Self::SemiAxes => {
                "ax, ay and az: half the lengths along the primitive's axes, in the file's units"
            }
            Self::Center => "t: the centre along x, y and z, in the file's units",
            Self::Rotation => "R: rotations about the file's x, then y, then z axis, in degrees",
            Self::Taper => {
                "kx and ky: how much the cross-section narrows or widens along the primitive's z axis; 0 \
                 means no taper"
            }
        }
    }

    fn value(self, theta: &Theta, column: usize) -> f64 {
        match self {
            Self::Exponents => theta.shape.exponents[column],
            Self::SemiAxes => theta.shape.semi_axes[column],
            Self::Center => theta.shape.translation[column],
            Self::Rotation => theta.angles[column].to_degrees(),
            Self::Taper => theta.shape.taper[column],
        }
    }

    fn set(self, theta: &mut Theta, column: usize, value: f64) {
        match self {
            Self::Exponents => theta.shape.exponents[column] = value,
            Self::SemiAxes => theta.shape.semi_axes[column] = value,
            Self::Center => theta.shape.translation[column] = value,
            Self::Rotation => {
                theta.angles[column] = value.to_radians();
                let [x, y, z] = theta.angles;
                theta.shape.rotation = nalgebra::Rotation3::from_euler_angles(x, y, z);
            }
            Self::Taper => theta.shape.taper[column] = value,
        }
    }

    fn range(self, limits: &ShapeLimits, column: usize) -> (f64, f64) {
        match self {
            Self::Exponents => ShapeLimits::EXPONENTS,
            Self::SemiAxes => limits.semi_axes(),
            Self::Center => limits.translation(column),
            // Any number of turns.
            Self::Rotation => (-3600.0, 3600.0),
            Self::Taper => ShapeLimits::TAPER,
        }
    }

    /// Change per logical pixel of dragging.
    fn speed(self, limits: &ShapeLimits) -> f64 {
        match self {
            Self::Exponents | Self::Taper => 0.005,
            Self::SemiAxes | Self::Center => 0.002 * limits.extent,
            Self::Rotation => 0.5,
        }
    }

    fn text(self, value: f64) -> String {
        match self {
            _ if !value.is_finite() => "–".to_owned(),
            Self::Exponents | Self::Taper => format!("{value:.3}"),
            Self::SemiAxes | Self::Center => length(value),
            // A turn by next to nothing has no sign.
            Self::Rotation => format!("{:.1}°", if value.abs() < 0.05 { 0.0 } else { value }),
        }
    }
}

pub(super) fn show(ui: &mut Ui, session: &Session, primitive: &Primitive, actions: &mut Vec<Action>) {
    let shape = *session.shape_of(primitive);
    let before = Theta { shape, angles: session.angles_of(primitive.id, &shape.rotation) };
    let mut theta = before;
    let why_fixed = session.why_fixed(primitive);
    let limits = session.shape_limits();
    ui.spacing_mut().item_spacing.x = GAP;
    let width = (ui.available_width() - LABELS - 3.0 * GAP) / 3.0;
    for line in Line::ALL {
        ui.horizontal(|ui| {
            label(ui, line.label(), line.tooltip());
            for (column, name) in line.names().iter().enumerate() {
                let response = ui
                    .add_enabled_ui(why_fixed.is_none(), |ui| {
                        number(ui, line, column, &mut theta, &limits, width)
                    })
                    .inner;
                let (low, high) = line.range(&limits, column);
                let tooltip = if matches!(line, Line::Rotation) {
                    line.tooltip().to_owned()
                } else {
                    format!("{}. From {} to {}", line.tooltip(), line.text(low), line.text(high))
                };
                response
                    .accessible_name(*name)
                    .on_hover_text(tooltip)
                    .on_disabled_hover_text(why_fixed.unwrap_or_default());
            }
        });
    }
    ui.horizontal(|ui| {
        let tooltip = "σ: standard deviation of the points' radial distances, in the file's \
             units. Every refit and iteration redraws it";
        label(ui, "Noise σ", tooltip);
        ui.label(length(primitive.sigma)).on_hover_text(tooltip);
    });
    // Escape gives the shape back, and the hand with it.
    if session.is_shaping() && ui.input(|i| i.key_pressed(Key::Escape)) {
        ui.ctx().stop_dragging();
        return;
    }
    if theta != before {
        let angles = (theta.angles != before.angles).then_some(theta.angles);
        actions.push(Action::DraftShape(ShapeDraft { id: primitive.id, shape: theta.shape, angles }));
    }
}

fn label(ui: &mut Ui, text: &str, tooltip: &str) {
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    ui.allocate_ui_with_layout(vec2(LABELS, theme::ROW), layout, |ui| {
        ui.set_min_size(vec2(LABELS, theme::ROW));
        ui.label(RichText::new(text).color(Palette::of(ui).weak)).on_hover_text(tooltip);
    });
}

fn number(
    ui: &mut Ui,
    line: Line,
    column: usize,
    theta: &mut Theta,
    limits: &ShapeLimits,
    width: f32,
) -> egui::Response {
    ui.spacing_mut().button_padding.x = 2.0;
    let mut value = line.value(theta, column);
    let unchanged = value;
    let (low, high) = line.range(limits, column);
    let number = editable(&mut value, move |v| line.text(v))
        .range(low..=high)
        // What fits have brought forth is not changed by being looked at.
        .clamp_existing_to_range(false)
        .speed(line.speed(limits));
    let response = ui.add_sized([width, theme::ROW], number);
    if value != unchanged {
        line.set(theta, column, value);
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_read_where_it_is_set() {
        let shape = Superquadric::sphere(nalgebra::Point3::origin(), 1.0);
        for line in Line::ALL {
            for column in 0..line.names().len() {
                let mut theta = Theta { shape, angles: [0.0; 3] };
                line.set(&mut theta, column, 0.25);
                assert!((line.value(&theta, column) - 0.25).abs() < 1e-12, "{line:?} {column}");
            }
        }
    }
}
