//! Where the window stands and how large it is, from start to start. eframe
//! could keep that, but stores a size in points of the interface's zoom and
//! reads it before there is a zoom: the window would shrink at each start.

use eframe::egui::{Rect, Vec2, ViewportCommand, ViewportInfo, pos2, vec2};
use serde::{Deserialize, Serialize};

/// First size, in the system's logical pixels.
pub(super) const SIZE: [f32; 2] = [1440.0, 900.0];
/// What the system's bars and the window's own frame may take of a screen, in
/// logical pixels: which of it is free is nowhere to be had.
const BARS: Vec2 = vec2(64.0, 96.0);
/// So much of the title bar has to be on a screen, in logical pixels, for the
/// window to be caught by it.
const TITLE: Vec2 = vec2(96.0, 24.0);

/// What is kept.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Place {
    /// Of the window's frame in physical pixels, where the system tells.
    position: Option<[f32; 2]>,
    /// Of the window's contents in the system's logical pixels, whatever the
    /// interface's zoom.
    size: [f32; 2],
    maximized: bool,
}

impl Place {
    /// The present place; one that is maximised goes back to where it was
    /// `before`.
    pub(super) fn of(window: &ViewportInfo, pixels_per_point: f32, before: Option<Self>) -> Option<Self> {
        if window.minimized == Some(true) || window.fullscreen == Some(true) {
            return before;
        }
        let scale = window.native_pixels_per_point.unwrap_or(1.0);
        let maximized = window.maximized == Some(true);
        if let (true, Some(before)) = (maximized, before) {
            return Some(Self { maximized, ..before });
        }
        let size = window.inner_rect?.size() * pixels_per_point / scale;
        let position = window.outer_rect.map(|rect| rect.min * pixels_per_point);
        Some(Self { position: position.map(Into::into), size: size.into(), maximized })
    }
}

/// A screen, in physical pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Screen {
    rect: Rect,
    /// Physical pixels in a logical one.
    scale: f32,
}

/// What the window is to be brought to, in physical pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Target {
    position: Option<[f32; 2]>,
    size: Vec2,
    maximized: bool,
}

impl Target {
    /// As it was kept, as far as the screens allow; without that the first
    /// size, which fills a small screen. `here` is the screen that the system
    /// would choose.
    fn new(kept: Option<Place>, here: Screen, screens: &[Screen]) -> Self {
        let Some(kept) = kept else {
            let (wanted, free) = (Vec2::from(SIZE) * here.scale, here.rect.size() - BARS * here.scale);
            let fits = wanted.x <= free.x && wanted.y <= free.y;
            return Self { position: None, size: wanted.min(free), maximized: !fits };
        };
        let size = Vec2::from(kept.size);
        let catches = |screen: &&Screen| {
            let position = kept.position.map_or(pos2(f32::NAN, f32::NAN), Into::into);
            let title = Rect::from_min_size(position, vec2(size.x, TITLE.y) * screen.scale);
            let seen = title.intersect(screen.rect).size();
            seen.x >= TITLE.x * screen.scale && seen.y >= 0.5 * TITLE.y * screen.scale
        };
        let found = screens.iter().find(catches);
        let screen = found.copied().unwrap_or(here);
        Self {
            position: kept.position.filter(|_| found.is_some()),
            size: (size * screen.scale).min(screen.rect.size()),
            maximized: kept.maximized,
        }
    }
}

/// The window's place while the program runs.
#[derive(Debug, Default)]
pub(super) struct Placing {
    pub(super) kept: Option<Place>,
    /// What window managers do for a window that is seen only.
    due: Vec<ViewportCommand>,
    is_seen: bool,
}

impl Placing {
    /// Brings a window that is not yet seen to its place.
    pub(super) fn new(cc: &eframe::CreationContext<'_>, kept: Option<Place>) -> Self {
        let sound = |place: &Place| place.size.iter().all(|side| (1.0..1e5).contains(side));
        let kept = kept.filter(sound);
        let mut placing = Self { kept, ..Self::default() };
        let Some(window) = cc.winit_window() else { return placing };
        let screens: Vec<Screen> = window
            .available_monitors()
            .map(|monitor| {
                let (at, size) = (monitor.position(), monitor.size());
                Screen {
                    rect: Rect::from_min_size(
                        pos2(at.x as f32, at.y as f32),
                        vec2(size.width as f32, size.height as f32),
                    ),
                    scale: monitor.scale_factor() as f32,
                }
            })
            .filter(|screen| screen.rect.is_positive())
            .collect();
        let here = window.current_monitor().or_else(|| window.primary_monitor()).map(|m| m.position());
        let here = here
            .and_then(|at| screens.iter().find(|screen| screen.rect.min == pos2(at.x as f32, at.y as f32)));
        // Without a screen there is nothing to fit into.
        let Some(here) = here.or(screens.first()) else { return placing };
        let target = Target::new(kept, *here, &screens);
        let mut size = window.inner_size();
        (size.width, size.height) = (target.size.x.round() as u32, target.size.y.round() as u32);
        let _ = window.request_inner_size(size);
        if let (Some([x, y]), Ok(mut at)) = (target.position, window.outer_position()) {
            (at.x, at.y) = (x.round() as i32, y.round() as i32);
            window.set_outer_position(at);
            placing.due.push(ViewportCommand::OuterPosition(pos2(x, y)));
        }
        if target.maximized {
            placing.due.push(ViewportCommand::Maximized(true));
        }
        placing
    }

    /// To be called in each frame.
    pub(super) fn advance(&mut self, ctx: &egui::Context) {
        let scale = ctx.pixels_per_point();
        if std::mem::replace(&mut self.is_seen, true) && !self.due.is_empty() {
            for command in self.due.drain(..) {
                ctx.send_viewport_cmd(match command {
                    ViewportCommand::OuterPosition(at) => ViewportCommand::OuterPosition(at / scale),
                    command => command,
                });
            }
            return;
        }
        if self.due.is_empty() {
            self.kept = ctx.input(|i| Place::of(i.viewport(), scale, self.kept));
        } else {
            ctx.request_repaint();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn screen(x: f32, width: f32, height: f32, scale: f32) -> Screen {
        Screen { rect: Rect::from_min_size(pos2(x, 0.0), vec2(width, height)), scale }
    }

    /// What is known of a window of so many physical pixels.
    fn info(position: [f32; 2], size: [f32; 2], zoom: f32, scale: f32) -> ViewportInfo {
        let inner = Rect::from_min_size(position.into(), size.into()) / (zoom * scale);
        let native_pixels_per_point = Some(scale);
        ViewportInfo {
            inner_rect: Some(inner),
            outer_rect: Some(inner),
            native_pixels_per_point,
            ..Default::default()
        }
    }

    #[test]
    fn the_first_size_fits_the_screen() {
        for (width, height, scale, fills) in [
            (1920.0, 1080.0, 1.0, false),
            (1440.0, 900.0, 1.0, true),
            (1366.0, 768.0, 1.0, true),
            (1024.0, 700.0, 1.0, true),
            (3840.0, 2160.0, 2.0, false),
            (2880.0, 1800.0, 2.0, true),
        ] {
            let here = screen(0.0, width, height, scale);
            let target = Target::new(None, here, &[here]);
            let free = here.rect.size() - BARS * scale;
            assert!(target.size.x <= free.x && target.size.y <= free.y, "{target:?} on {here:?}");
            assert_eq!(target.maximized, fills, "{here:?}");
            assert!(fills || target.size == Vec2::from(SIZE) * scale);
        }
    }

    #[test]
    fn a_window_comes_back_as_it_was_at_every_zoom() {
        for scale in [1.0, 1.25, 2.0] {
            let here = screen(0.0, 3840.0, 2160.0, scale);
            for zoom in [0.5, 0.8, 1.0, 1.1, 1.5, 3.0] {
                let (mut position, mut size) = ([100.0, 60.0], [1300.0, 777.0]);
                for start in 0..5 {
                    let kept = Place::of(&info(position, size, zoom, scale), zoom * scale, None);
                    let target = Target::new(kept, here, &[here]);
                    let found = target.position.expect("it is on the screen");
                    for (a, b) in [(found, position), (target.size.into(), size)] {
                        assert!(
                            (a[0] - b[0]).abs() < 0.5 && (a[1] - b[1]).abs() < 0.5,
                            "{start}: {target:?}"
                        );
                    }
                    (position, size) = (found, target.size.into());
                }
            }
        }
    }

    #[test]
    fn a_window_is_never_larger_than_its_screen_nor_off_all_of_them() {
        let (left, right) = (screen(0.0, 1366.0, 768.0, 1.0), screen(1366.0, 1920.0, 1080.0, 1.0));
        let kept =
            |x: f32, y: f32| Some(Place { position: Some([x, y]), size: [1800.0, 1000.0], maximized: false });
        let both = [left, right];
        let target = Target::new(kept(1400.0, 20.0), left, &both);
        assert_eq!((target.position, target.size), (Some([1400.0, 20.0]), vec2(1800.0, 1000.0)));
        // The right one was taken away.
        let target = Target::new(kept(1400.0, 20.0), left, &[left]);
        assert_eq!((target.position, target.size), (None, vec2(1366.0, 768.0)));
        for (x, y) in [(-1750.0, 20.0), (20.0, 760.0), (20.0, -300.0)] {
            assert_eq!(Target::new(kept(x, y), left, &[left]).position, None, "{x}, {y}");
        }
        // Wayland tells no position.
        let unknown = Some(Place { position: None, size: [900.0, 600.0], maximized: true });
        let target = Target::new(unknown, left, &both);
        assert_eq!((target.position, target.size, target.maximized), (None, vec2(900.0, 600.0), true));
    }

    #[test]
    fn what_is_maximised_keeps_the_place_that_it_goes_back_to() {
        let before = Place::of(&info([30.0, 40.0], [900.0, 600.0], 1.5, 1.0), 1.5, None);
        let mut filled = info([0.0, 0.0], [1366.0, 768.0], 1.5, 1.0);
        filled.maximized = Some(true);
        let place = Place::of(&filled, 1.5, before).expect("it has a place");
        assert_eq!((place.size, place.position, place.maximized), ([900.0, 600.0], Some([30.0, 40.0]), true));
        filled.minimized = Some(true);
        assert_eq!(Place::of(&filled, 1.5, before), before);
    }
}
