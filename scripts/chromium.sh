#!/usr/bin/env bash
# Finds Chromium for the browser test, or installs it by the system's package manager.
# Never fails: without a browser those tests are skipped, and this says what to install.
set -u

find_browser() {
    [ -x "${CHROMIUM:-}" ] && return 0
    for name in chromium chromium-browser google-chrome google-chrome-stable; do
        command -v "$name" >/dev/null && return 0
    done
    return 1
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"
    elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then sudo -n "$@"
    else return 1
    fi
}

install_browser() {
    if command -v apt-get >/dev/null; then
        as_root apt-get update -qq &&
            as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium
    elif command -v dnf >/dev/null; then as_root dnf install -y -q chromium
    elif command -v pacman >/dev/null; then as_root pacman -S --noconfirm --quiet chromium
    elif command -v zypper >/dev/null; then as_root zypper --quiet install -y chromium
    elif command -v apk >/dev/null; then as_root apk add --quiet chromium
    else return 1
    fi
}

find_browser && exit 0
echo "Chromium is missing; the browser test needs it. Trying the system's package manager ..."
install_browser >/dev/null 2>&1
find_browser && exit 0
cat >&2 <<'MESSAGE'
Chromium could not be installed from here: the browser test will be skipped.
Install it by hand, then run make test again:
  Debian:  sudo apt install chromium          Fedora:  sudo dnf install chromium
  Arch:    sudo pacman -S chromium            Ubuntu:  sudo snap install chromium
MESSAGE
exit 0
