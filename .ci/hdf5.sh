#!/bin/sh
# Prints the cargo flags that give the build an HDF5 library; says on stderr what it does and why.
#
# In this order:
#   1. HDF5_DIR, or an HDF5 that pkg-config knows (`hdf5` or `hdf5-serial`): no flags.
#   2. The package libhdf5-dev, installed as root or through `sudo -n`: no flags.
#   3. The bundled HDF5 sources, linked statically: `--features hdf5-static`. They need cmake >= 3.26; an older or
#      missing one is replaced by the wheel from PyPI. `.tools/bin`, where it is linked, has to lead the caller's PATH.
# The third answer is kept in .tools/hdf5-static, so that a failed installation is not tried again at every call.
set -eu
cd "$(dirname "$0")/.."
tools=$PWD/.tools
PATH=$tools/bin:$PATH

say() { echo "hdf5: $*" >&2; }

known() {
    if [ -n "${HDF5_DIR:-}" ]; then return 0; fi
    command -v pkg-config >/dev/null 2>&1 && { pkg-config --exists hdf5 || pkg-config --exists hdf5-serial; }
}

cmake_is_new_enough() {
    command -v cmake >/dev/null 2>&1 &&
        [ "$(printf '3.26\n%s\n' "$(cmake --version | sed -n '1s/[^0-9]*\([0-9.]*\).*/\1/p')" | sort -V | head -n 1)" = 3.26 ]
}

install_package() {
    if ! command -v apt-get >/dev/null 2>&1; then
        say "cannot install libhdf5-dev: there is no apt-get"
        return 1
    fi
    if [ "$(id -u)" -eq 0 ]; then
        as_root="env"
    elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
        as_root="sudo -n env"
    else
        say "cannot install libhdf5-dev: neither root nor sudo without a password"
        return 1
    fi
    say "pkg-config knows no HDF5; installing libhdf5-dev with apt-get"
    apt="$as_root DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=120"
    $apt update >&2 || say "apt-get update failed; trying with the package lists as they are"
    $apt install -y --no-install-recommends pkg-config libhdf5-dev >&2 || {
        say "apt-get could not install libhdf5-dev"
        return 1
    }
    known || {
        say "libhdf5-dev is installed, but pkg-config does not find it"
        return 1
    }
}

provide_cmake() {
    if cmake_is_new_enough; then return 0; fi
    say "no cmake >= 3.26; installing its wheel from PyPI into .tools"
    python3 -m venv "$tools/cmake" >&2 && "$tools/cmake/bin/pip" install -q 'cmake>=3.26,<5' >&2 || return 1
    mkdir -p "$tools/bin"
    # The program itself, not the wheel's Python launcher: the virtual environment stays off the PATH.
    ln -sf "$("$tools/cmake/bin/python" -c 'import cmake; print(cmake.CMAKE_BIN_DIR)')/cmake" "$tools/bin/cmake"
    cmake_is_new_enough
}

if known; then
    say "found by ${HDF5_DIR:+HDF5_DIR=}${HDF5_DIR:-pkg-config}"
    exit 0
fi
if ! [ -e "$tools/hdf5-static" ]; then
    if install_package; then exit 0; fi
    say "building the bundled HDF5 sources instead, which takes some minutes"
fi
if ! provide_cmake; then
    say "no HDF5 and no cmake >= 3.26 to build it with."
    say "Install libhdf5-dev (Debian, Ubuntu), hdf5-devel (Fedora) or hdf5 (Homebrew), or set HDF5_DIR, and try again."
    exit 1
fi
mkdir -p "$tools"
: >"$tools/hdf5-static"
echo "--features hdf5-static"
