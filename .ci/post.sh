#!/bin/sh
# Runs a Python script of the pictures and plots in a virtual environment of its own.
#
#   .ci/post.sh              make the environment and stop
#   .ci/post.sh SCRIPT ...   make it if needed, then run the script with these arguments
#
# The script runs in the folder of the caller, so its arguments mean what they say; a script that is not there is taken
# from the repository.
# Where Python, the packages or off-screen graphics are missing this prints one line `skipped: why` and succeeds,
# because results do not depend on pictures. The script's own failure is a failure.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
venv=$root/post/.venv
requirements=$root/post/requirements.txt
mkdir -p "$root/.tools"
python=$venv/bin/python
log=$root/.tools/post.log

skip() {
    echo "skipped: ${1:-post/.venv}: $2"
    exit 0
}

# Prints the first interpreter that is new enough for the pinned packages.
find_python() {
    for candidate in ${PYTHON:-} python3 python3.14 python3.13 python3.12 python3.11; do
        if "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
            echo "$candidate"
            return 0
        fi
    done
    return 1
}

if ! cmp -s "$requirements" "$venv/requirements.txt"; then
    base=$(find_python) || skip "${1:-}" "there is no Python 3.11 or newer"
    echo "post: installing post/requirements.txt into $venv"
    rm -rf "$venv"
    "$base" -m venv "$venv" >"$log" 2>&1 || skip "${1:-}" "'$base -m venv' failed (Debian: install python3-venv); see $log"
    "$python" -m pip --disable-pip-version-check install -q --retries 1 --timeout 20 -r "$requirements" >"$log" 2>&1 ||
        skip "${1:-}" "pip could not install post/requirements.txt; see $log"
    cp "$requirements" "$venv/requirements.txt"
    rm -f "$log"
fi
if [ $# -eq 0 ]; then exit 0; fi

script=$1
shift
if ! [ -e "$script" ]; then script=$root/$script; fi

# In a process of its own: a missing graphics library can end the interpreter without a Python exception.
if ! "$python" "$root/post/graphics.py" >"$log" 2>&1; then
    skip "$script" "no off-screen graphics (Debian: install libegl1 libgl1 libxrender1, or libosmesa6): $(tail -n 1 "$log")"
fi
rm -f "$log"
exec "$python" "$script" "$@"
