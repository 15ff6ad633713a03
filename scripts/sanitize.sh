#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the engine and the laws with sanitizers and runs their GoogleTests. The last line is
# `N passed, N failed`:
#
#     scripts/sanitize.sh
#
# There are two builds: one with the address and the undefined-behaviour sanitizer, and one with the
# thread sanitizer. Their output is in build/reports/sanitize/. A finding of a sanitizer fails the
# test in which it occurred.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." && pwd)
reports=$root/build/reports/sanitize
jobs=$(nproc)

say() { printf '%s\n' "reve: $*" >&2; }

# build NAME SANITIZERS: builds the engine and the laws in build/sanitize-NAME.
build() {
  local out=$root/build/sanitize-$1 flags="-fsanitize=$2 -fno-sanitize-recover=all -fno-omit-frame-pointer"
  # The option -O1 is used, because sanitizers then find the same faults as without optimisation,
  # and compilation is faster.
  local debug=(-DCMAKE_BUILD_TYPE=Debug "-DCMAKE_C_FLAGS_DEBUG=-O1 -g1" "-DCMAKE_CXX_FLAGS_DEBUG=-O1 -g1")
  cmake -S "$root/vesper-native" -B "$out/engine" -G Ninja "${debug[@]}" -DVESPER_SANITIZE="$2" &&
  cmake --build "$out/engine" -- -j"$jobs" &&
  cmake -S "$root/laws" -B "$out/laws" -G Ninja "${debug[@]}" \
    -DVesper_DIR="$out/engine" -DCMAKE_CXX_FLAGS="$flags" &&
  cmake --build "$out/laws" -- -j"$jobs"
}

# run_tests NAME SANITIZERS ROOM: runs the tests of build/sanitize-NAME/ROOM and writes a JUnit
# report. Skips tests on an OpenCL device, because its driver contains a compiler with threads that
# is built without sanitizers. Skips the law with a deliberate race if the sanitizer would end the
# process before the test kit detects the race. Projects that a test builds outside the tree
# (new-law) take the sanitizer from CXXFLAGS.
run_tests() {
  local except='opencl|OpenCl|OnADevice|NBodyWorld'
  [ "$1" != thread ] || except+='|FailsItsCheck/threads'
  CXXFLAGS="-fsanitize=$2" ctest --test-dir "$root/build/sanitize-$1/$3" --output-on-failure \
    -j"$jobs" --exclude-regex "$except" --output-junit "$reports/$1-$3.xml"
}

check() { # NAME SANITIZERS
  say "building with the $1 sanitizer …"
  if ! build "$1" "$2" > "$reports/$1-build.log" 2>&1; then
    say "the build failed; see $reports/$1-build.log:"
    grep -m 5 -E 'error|FAILED' "$reports/$1-build.log" >&2 || true
    return
  fi
  local room
  for room in engine laws; do
    say "running the tests of the $room with the $1 sanitizer …"
    run_tests "$1" "$2" "$room" > "$reports/$1-$room.log" 2>&1 || true
  done
}

rm -rf "$reports"
mkdir -p "$reports"
# Mesa, which draws for the renderer, has its own threads and is built without the sanitizer. The
# thread sanitizer therefore sees Mesa's accesses to memory but not its locks, and reports races
# that do not exist. The same is true for TBB. The sanitizer still checks the engine's code on TBB's
# threads, see vesper-native/src/thread_sanitizer.hpp.
printf '%s\n' race:libOSMesa.so called_from_lib:libtbb.so > "$reports/thread.supp"
export TSAN_OPTIONS="suppressions=$reports/thread.supp"
check address address,undefined
check thread thread
python3 "$root/scripts/test_summary.py" "$reports" \
  address-engine address-laws thread-engine thread-laws
