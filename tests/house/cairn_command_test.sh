#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# usage: cairn_command_test.sh CASE
# Runs ./cairn in a made-up machine: a copy of the script in a temporary folder, with a PATH that holds only harmless
# tools and stand-ins for apt-get, dpkg-query, sudo, cmake, ninja and ctest. They write down how they were called.
set -euo pipefail

project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
machine=$(mktemp -d)
trap 'chmod -R u+w "$machine"; rm -rf "$machine"' EXIT
calls=$machine/calls
installed=$machine/installed
home=$machine/home/cairn

fail() {
  printf 'FAILED: %s\n--- calls\n%s\n--- output\n%s\n' "$*" "$(cat "$calls")" "$(cat "$machine/output")" >&2
  exit 1
}

# stand_in NAME: makes the command NAME of the machine from standard input.
stand_in() {
  {
    printf '#!/bin/bash\nmachine=%q calls=%q installed=%q home=%q\n' "$machine" "$calls" "$installed" "$home"
    cat
  } >"$machine/bin/$1"
  chmod +x "$machine/bin/$1"
}

make_machine() {
  local tool
  mkdir -p "$machine/bin" "$home"
  cp "$project/cairn" "$project/packages.txt" "$home"
  : >"$calls"
  : >"$installed"
  : >"$machine/output"
  for tool in awk bash cat chmod comm dirname env flock grep mkdir mv nproc readlink sed sort; do
    ln -s "$(command -v "$tool")" "$machine/bin/$tool"
  done
  stand_in dpkg-query <<'END'
for word; do grep -qxF -- "$word" "$installed" && echo "installed $word"; done; exit 1
END
  stand_in apt-get <<'END'
echo "apt-get $*" >>"$calls"
[[ ! -e $machine/no_network ]] || exit 100
[[ " $* " != *" install "* ]] || printf '%s\n' "${@##-*}" >>"$installed"
END
  stand_in sudo <<'END'
echo "sudo" >>"$calls"
exec "$@"
END
  stand_in cmake <<'END'
echo "cmake $*" >>"$calls"
mkdir -p "$home/build/release/bin"
: >"$home/build/release/build.ninja"
echo "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" >"$home/build/release/CMakeCache.txt"
END
  stand_in ninja <<'END'
echo "ninja ${*: -1}" >>"$calls"
if [[ -e $machine/gate ]]; then read -r <"$machine/gate"; fi
if [[ -e $machine/bad_code ]]; then echo "a.cpp:1: error: bad code"; exit 1; fi
printf '#!/bin/bash\necho "cli $*"\nexit 7\n' >bin/cairn-cli
chmod +x bin/cairn-cli
echo "ninja done" >>"$calls"
END
  stand_in ctest <<'END'
echo "ctest $*" >>"$calls"
END
}

install_everything() {
  sed -n 's/^\([a-z][^ ]*\).*/\1/p' "$home/packages.txt" >"$installed"
}

# as_person COMMAND...: runs it without root's rights.
as_person() {
  if ((EUID != 0)); then
    "$@"
    return
  fi
  chown -R 65534:65534 "$machine"
  setpriv --reuid=65534 --regid=65534 --clear-groups "$@"
}

# cairn WORDS...: runs ./cairn on the machine; its output goes to $machine/output and its exit code to $status.
cairn() {
  status=0
  "${run_as[@]}" env -i HOME="$machine" PATH="$machine/bin" "$home/cairn" "$@" >"$machine/output" 2>&1 || status=$?
}
run_as=(env)

expect_status() { ((status == $1)) || fail "exit code $status, not $1"; }
expect_call() { grep -qE -- "$1" "$calls" || fail "no call like: $1"; }
expect_no_call() { ! grep -qE -- "$1" "$calls" || fail "a call like: $1"; }
expect_output() { grep -qE -- "$1" "$machine/output" || fail "no output like: $1"; }

installs_only_what_is_missing() {
  install_everything
  sed -i '/^cmake$/d; /^liblcm-dev$/d; /^libgtest-dev$/d' "$installed"
  cairn demo
  expect_call 'apt-get .*update$'
  expect_call 'apt-get .*install -y --no-install-recommends cmake liblcm-dev$'
  expect_call 'cmake --preset release .*-DCAIRN_TESTS=OFF'
  expect_output '^cli demo$'
}

no_network_when_nothing_is_missing() {
  install_everything
  cairn demo
  : >"$calls"
  cairn demo
  expect_no_call '^(apt-get|sudo|cmake)'
  [[ $(cat "$machine/output") == "cli demo" ]] || fail "more said than the CLI says"
}

root_is_asked_for_by_sudo() {
  run_as=(as_person)
  cairn demo
  expect_call '^sudo$'
  expect_output '^cli demo$'
}

without_root_or_sudo_it_says_what_to_run() {
  run_as=(as_person)
  rm "$machine/bin/sudo"
  cairn demo
  expect_status 1
  expect_output 'apt-get update && apt-get install --no-install-recommends .*cmake'
  expect_no_call '^(apt-get|cmake|ninja)'
}

a_failing_apt_says_what_to_run() {
  touch "$machine/no_network"
  cairn demo
  expect_status 1
  expect_output 'is there a network'
  expect_output 'apt-get install --no-install-recommends .*cmake'
  expect_no_call '^(cmake|ninja)'
}

another_system_is_told_the_list() {
  rm "$machine/bin/apt-get"
  cairn demo
  expect_status 1
  expect_output 'no apt-get.*packages.txt'
}

test_adds_the_test_packages() {
  cairn test -R Stereo
  expect_status 0
  expect_call 'apt-get .*install .*cmake.*libgtest-dev'
  expect_call 'cmake .*-DCAIRN_TESTS=ON'
  expect_call '^ninja all$'
  expect_call '^ctest .*--no-tests=error -j2 -R Stereo$'
}

a_failing_build_stops_before_the_cli() {
  install_everything
  touch "$machine/bad_code"
  cairn demo
  expect_status 1
  expect_output 'error: bad code'
  expect_output 'the build failed'
}

a_moved_folder_is_configured_anew() {
  install_everything
  cairn demo
  : >"$calls"
  sed -i 's/=.*/=\/elsewhere/' "$home/build/release/CMakeCache.txt"
  cairn demo
  expect_call 'cmake --preset release --fresh'
}

words_and_exit_code_go_through() {
  install_everything
  cairn eval map "a b" --json
  expect_status 7
  expect_output '^cli eval map a b --json$'
}

a_running_robot_never_waits_for_a_compiler() {
  install_everything
  cairn demo
  touch "$machine/bad_code"
  : >"$calls"
  cairn stop planner
  expect_no_call '.'
  expect_output '^cli stop planner$'
}

a_folder_that_cannot_be_written_says_so() {
  install_everything
  chmod a-w "$home"
  run_as=(as_person)
  cairn demo
  expect_status 1
  expect_output 'cannot be written'
}

# The first is held inside ninja until the second has said that it waits.
two_at_once_build_one_after_the_other() {
  install_everything
  mkfifo "$machine/gate" "$machine/second_says"
  cairn demo &
  exec 7>"$machine/gate"
  rm "$machine/gate"
  env -i HOME="$machine" PATH="$machine/bin" "$home/cairn" demo 2>"$machine/second_says" >/dev/null &
  exec 8<"$machine/second_says"
  read -r said <&8
  [[ $said == *"another ./cairn is building here"* ]] || fail "the second said: $said"
  echo go >&7
  wait
  [[ $(cat "$calls") == *$'ninja procs/all\nninja done\nninja procs/all\nninja done' ]] || fail "they overlapped"
}

make_machine
chmod 755 "$machine"
"$1"
