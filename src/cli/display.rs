//! Whether a window can be opened at all.

/// Why no window can be opened here, or `None` if it is worth a try.
pub fn why_no_display() -> Option<String> {
    if !cfg!(feature = "window") {
        return Some("this program was built without its window".to_owned());
    }
    // Elsewhere there is always a desktop.
    if !cfg!(unix) || cfg!(target_os = "macos") {
        return None;
    }
    let set = |name: &str| std::env::var_os(name).is_some_and(|v| !v.is_empty());
    if set("WAYLAND_DISPLAY") || set("WAYLAND_SOCKET") || set("DISPLAY") {
        None
    } else {
        Some("there is no display (neither WAYLAND_DISPLAY nor DISPLAY is set)".to_owned())
    }
}
