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
    let set = |name: &str| std::env::var(name).ok().filter(|v| !v.is_empty());
    if set("WAYLAND_DISPLAY").or_else(|| set("WAYLAND_SOCKET")).is_some() {
        return None;
    }
    match set("DISPLAY") {
        None => Some("there is no display (neither WAYLAND_DISPLAY nor DISPLAY is set)".to_owned()),
        Some(name) if nobody_answers(&name) => {
            Some(format!("there is no display (nobody answers at DISPLAY={name})"))
        }
        Some(_) => None,
    }
}

/// Whether an X display of this machine, as `:1` or `:1.0`, is not there.
/// Displays of other machines are left to the window to find out.
#[cfg(unix)]
fn nobody_answers(display: &str) -> bool {
    use std::os::unix::net::UnixStream;
    let Some(number) = display.strip_prefix(':').and_then(|d| d.split('.').next()) else { return false };
    let path = format!("/tmp/.X11-unix/X{number}");
    let by_name = UnixStream::connect(&path).is_ok();
    #[cfg(target_os = "linux")]
    let by_name = by_name || {
        // The socket's second name, which needs no file.
        use std::os::linux::net::SocketAddrExt;
        use std::os::unix::net::SocketAddr;
        SocketAddr::from_abstract_name(&path).is_ok_and(|at| UnixStream::connect_addr(&at).is_ok())
    };
    !by_name
}

#[cfg(not(unix))]
fn nobody_answers(_: &str) -> bool {
    false
}
