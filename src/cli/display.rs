//! Whether a window can be opened.

/// Why no window can be opened here, or `None` if it is worth a try.
pub fn why_no_display() -> Option<String> {
    if !cfg!(feature = "window") {
        return Some("this program was built without a window".to_owned());
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
        None => Some("no display (neither WAYLAND_DISPLAY nor DISPLAY is set)".to_owned()),
        Some(name) if nobody_answers(&name) => {
            Some(format!("no display (no X server responds at DISPLAY={name})"))
        }
        Some(_) => None,
    }
}

/// Name of the variable that keeps Mesa's choice among several graphics cards from
/// asking a Wayland display for its own.
#[cfg(unix)]
const NO_DEVICE_CHOICE: &str = "NODEVICE_SELECT";

/// Keeps graphics drivers from complaining on standard error that there is no
/// XDG_RUNTIME_DIR, which is no fault where nobody is logged in. They read the
/// environment, so that the program is started anew in its own place, once.
#[cfg(unix)]
pub fn spare_complaints() {
    use std::os::unix::process::CommandExt as _;

    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if !cfg!(feature = "window") || is_set("XDG_RUNTIME_DIR") || is_set(NO_DEVICE_CHOICE) {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    let arguments = std::env::args_os().skip(1);
    // Returns only where it fails; then they complain.
    let error = std::process::Command::new(program).args(arguments).env(NO_DEVICE_CHOICE, "1").exec();
    tracing::debug!("cannot restart the program: {error}");
}

#[cfg(not(unix))]
pub fn spare_complaints() {}

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
