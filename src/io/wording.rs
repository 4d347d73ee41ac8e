//! Messages for errors of the operating system, and escaping of names with arbitrary characters.

use std::borrow::Cow;
use std::io::{Error, ErrorKind};

/// Why something can't be read, and what to do about it.
pub fn on_reading(error: &Error) -> String {
    let advice = match innermost(error).kind() {
        ErrorKind::NotFound => "check the name and the folder",
        ErrorKind::PermissionDenied => "change its permissions or copy it to a readable location",
        ErrorKind::IsADirectory => "choose a file inside it",
        ErrorKind::NotADirectory | ErrorKind::InvalidFilename | ErrorKind::InvalidInput => "check the path",
        ErrorKind::UnexpectedEof | ErrorKind::InvalidData => "copy or export it again",
        ErrorKind::OutOfMemory => "close other programs or reduce the size of the shape first",
        ErrorKind::BrokenPipe => "restart the program that writes it",
        kind if is_unreachable(kind) => "check that the drive is connected and try again",
        kind if is_in_use(kind) => "close the program that uses it and try again",
        _ => "copy it elsewhere and try again",
    };
    format!("{}; {advice}", cause(error))
}

/// Why something can't be written, and what to do about it.
pub fn on_writing(error: &Error) -> String {
    let advice = match innermost(error).kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "free some space or choose another folder",
        ErrorKind::NotFound => "create the folder first or choose another",
        ErrorKind::PermissionDenied => "choose a folder with write permission",
        ErrorKind::ReadOnlyFilesystem => "choose another folder",
        ErrorKind::IsADirectory | ErrorKind::AlreadyExists | ErrorKind::DirectoryNotEmpty => {
            "choose another name"
        }
        ErrorKind::NotADirectory => "choose another folder or move the file away",
        ErrorKind::InvalidFilename | ErrorKind::InvalidInput => "choose a shorter or simpler name",
        ErrorKind::FileTooLarge => "choose another disk or export less",
        ErrorKind::OutOfMemory => "close other programs and try again",
        ErrorKind::BrokenPipe => "restart the program that reads it",
        kind if is_unreachable(kind) => "check that the drive is connected or choose another folder",
        kind if is_in_use(kind) => "close the program that uses it or choose another name",
        _ => "choose another folder",
    };
    format!("{}; {advice}", cause(error))
}

/// What happened, without advice.
pub fn cause(error: &Error) -> String {
    let error = innermost(error);
    let words = match error.kind() {
        ErrorKind::NotFound => "file or folder not found",
        ErrorKind::PermissionDenied => "permission denied",
        ErrorKind::IsADirectory => "it is a folder",
        ErrorKind::NotADirectory => "part of its path is a file, not a folder",
        ErrorKind::DirectoryNotEmpty => "the folder is not empty",
        ErrorKind::AlreadyExists => "the name already exists",
        ErrorKind::InvalidFilename => "the name is too long or not allowed",
        ErrorKind::StorageFull => "the disk is full",
        ErrorKind::QuotaExceeded => "your disk quota is used up",
        ErrorKind::FileTooLarge => "the file is larger than the file system or a limit allows",
        ErrorKind::ReadOnlyFilesystem => "the disk is read-only",
        ErrorKind::OutOfMemory => "not enough memory",
        ErrorKind::BrokenPipe => "the other end of the pipe was closed",
        ErrorKind::WriteZero => "no more data could be written",
        ErrorKind::UnexpectedEof => "it ends unexpectedly",
        ErrorKind::TooManyLinks => "it has too many links",
        kind if is_unreachable(kind) => "its drive does not respond",
        kind if is_in_use(kind) => "another program is using it",
        _ => return error.to_string(),
    };
    // What our own code says of it is nearer.
    error.get_ref().map_or_else(|| words.to_owned(), ToString::to_string)
}

fn is_unreachable(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::StaleNetworkFileHandle
            | ErrorKind::TimedOut
            | ErrorKind::HostUnreachable
            | ErrorKind::NetworkUnreachable
            | ErrorKind::NetworkDown
            | ErrorKind::NotConnected
            | ErrorKind::ConnectionAborted
            | ErrorKind::ConnectionReset
    )
}

fn is_in_use(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::ResourceBusy | ErrorKind::ExecutableFileBusy | ErrorKind::WouldBlock)
}

/// The error of the operating system, where a library wraps it up in another.
fn innermost(error: &Error) -> &Error {
    let mut next = error.get_ref().map(|inner| inner as &(dyn std::error::Error + 'static));
    while let Some(inner) = next {
        if let Some(found) = inner.downcast_ref::<Error>() {
            return innermost(found);
        }
        next = inner.source();
    }
    error
}

/// A text with what steers a terminal or breaks a line escaped: names of files
/// may hold any character.
pub fn harmless(text: &str) -> Cow<'_, str> {
    // Among them those that turn the direction of writing.
    let steers = |c: char| {
        c.is_control()
            || matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        if steers(c) { shown.extend(c.escape_default()) } else { shown.push(c) }
    }
    shown.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advice_matches_the_cause() {
        for (kind, words, reading, writing) in [
            (ErrorKind::NotFound, "file or folder not found", "check the name", "create the folder"),
            (ErrorKind::PermissionDenied, "permission denied", "permissions", "with write permission"),
            (ErrorKind::IsADirectory, "is a folder", "a file inside it", "another name"),
            (ErrorKind::NotADirectory, "a file, not a folder", "check the path", "move the file away"),
            (ErrorKind::InvalidFilename, "too long", "check the path", "shorter"),
            (ErrorKind::StorageFull, "disk is full", "", "free some space"),
            (ErrorKind::QuotaExceeded, "used up", "", "free some space"),
            (ErrorKind::ReadOnlyFilesystem, "read-only", "", "another folder"),
            (ErrorKind::FileTooLarge, "larger than", "", "another disk"),
            (ErrorKind::TooManyLinks, "too many links", "", "another folder"),
            (ErrorKind::StaleNetworkFileHandle, "does not respond", "connected", "connected"),
            (ErrorKind::BrokenPipe, "pipe was closed", "", "reads it"),
            (ErrorKind::ResourceBusy, "another program", "close", "close"),
            (ErrorKind::Other, "other error", "", "another folder"),
        ] {
            let error = Error::from(kind);
            assert!(cause(&error).contains(words), "{kind:?}: {}", cause(&error));
            assert!(on_reading(&error).contains(reading), "{kind:?}: {}", on_reading(&error));
            assert!(on_writing(&error).contains(writing), "{kind:?}: {}", on_writing(&error));
            let asks_for_room = on_writing(&error).contains("free some space");
            assert_eq!(asks_for_room, matches!(kind, ErrorKind::StorageFull | ErrorKind::QuotaExceeded));
        }
    }

    #[test]
    fn causes_lose_neither_our_words_nor_those_of_the_system() {
        let ours = Error::new(ErrorKind::AlreadyExists, "a picture is there already");
        assert_eq!(on_writing(&ours), "a picture is there already; choose another name");
        assert_eq!(cause(&Error::other("a picture has another size")), "a picture has another size");
        // As libraries do that name the file in the error.
        let system = Error::from_raw_os_error(if cfg!(windows) { 112 } else { 28 });
        assert!(on_writing(&Error::other(Wrapper(system))).starts_with("the disk is full; free some space"));
        #[cfg(target_os = "linux")]
        assert!(on_reading(&Error::other(Wrapper(Error::from_raw_os_error(40)))).contains("symbolic links"));
    }

    #[derive(Debug, thiserror::Error)]
    #[error("at /tmp/.part")]
    struct Wrapper(#[source] Error);

    #[test]
    fn names_do_not_steer_the_terminal() {
        assert_eq!(harmless("a ünïcode стул.ply"), "a ünïcode стул.ply");
        assert_eq!(harmless("a\u{1b}[31m\n\u{202e}b\u{9b}"), "a\\u{1b}[31m\\n\\u{202e}b\\u{9b}");
    }
}
