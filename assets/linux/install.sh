#!/bin/sh
# Installs a built superform with its menu entry, icon, file types, shell
# completions and manual pages to a prefix; `--remove` uninstalls everything.
#
#     assets/linux/install.sh [--remove] [PREFIX [PROGRAM]]
#
# PREFIX defaults to ~/.local, PROGRAM to target/release/superform.
set -eu

here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
remove=false
if [ "${1:-}" = --remove ]; then
    remove=true
    shift
fi
prefix=${1:-$HOME/.local}
program=${2:-$here/../../target/release/superform}

bin=$prefix/bin/superform
desktop=$prefix/share/applications/superform.desktop
icon=$prefix/share/icons/hicolor/scalable/apps/superform.svg
small=$prefix/share/icons/hicolor/256x256/apps/superform.png
types=$prefix/share/mime/packages/superform.xml
bash=$prefix/share/bash-completion/completions/superform
zsh=$prefix/share/zsh/site-functions/_superform
fish=$prefix/share/fish/vendor_completions.d/superform.fish
manual=$prefix/share/man/man1

# Updates the desktop's caches, if these programs are installed.
tell() {
    if command -v update-desktop-database >/dev/null; then
        update-desktop-database -q "$prefix/share/applications" || true
    fi
    if command -v update-mime-database >/dev/null; then
        update-mime-database "$prefix/share/mime" >/dev/null 2>&1 || true
    fi
}

if $remove; then
    rm -f "$bin" "$desktop" "$icon" "$small" "$types" "$bash" "$zsh" "$fish" \
        "$manual"/superform.1 "$manual"/superform-*.1
    tell
    echo "removed superform from $prefix"
    exit
fi

if [ ! -x "$program" ]; then
    echo "install.sh: $program not found; build it first: cargo build --release" >&2
    exit 1
fi
install -D -m 755 "$program" "$bin"
install -D -m 644 "$here/superform.desktop" "$desktop"
install -D -m 644 "$here/superform.svg" "$icon"
install -D -m 644 "$here/../icon.png" "$small"
install -D -m 644 "$here/superform.xml" "$types"
mkdir -p "$(dirname "$bash")" "$(dirname "$zsh")" "$(dirname "$fish")" "$manual"
"$bin" completions bash >"$bash"
"$bin" completions zsh >"$zsh"
"$bin" completions fish >"$fish"
"$bin" man -o "$manual" >/dev/null
tell
echo "installed superform to $bin"
