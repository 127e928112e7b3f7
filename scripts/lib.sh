# Shared by scripts/demo and scripts/test. Source it; it defines functions and changes to the
# project's folder. Plain bash, nothing assumed but git and the Debian base system.

set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '\n== %s\n' "$*"; }
die() { printf 'error: %s\n' "$*" >&2; exit 1; }

# packages_of GROUP...: names of the packages in these groups of packages.txt.
packages_of() {
  local name group rest wanted=" $* "
  while read -r name group rest; do
    [[ -z "$name" || "$name" == \#* ]] && continue
    [[ "$wanted" == *" $group "* ]] && echo "$name"
  done < scripts/packages.txt
  return 0
}

is_installed() {
  [[ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" == installed ]]
}

# missing_of GROUP...: those of packages_of that are not installed, on one line.
missing_of() {
  local name missing=()
  for name in $(packages_of "$@"); do
    is_installed "$name" || missing+=("$name")
  done
  echo "${missing[*]-}"
}

apt_install() {
  DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3 \
    install -y -qq --no-install-recommends "$@" < /dev/null > "$apt_log" 2>&1
}

# install_packages GROUP...: as root installs what is missing, else prints the line to run and stops.
install_packages() {
  command -v dpkg-query > /dev/null ||
    die "this needs Debian or Ubuntu; elsewhere install what scripts/packages.txt lists and use the CMake presets"
  local required optional name
  required=$(missing_of "$@")
  optional=$(missing_of optional)
  [[ -z "$required$optional" ]] && return 0
  if [[ $EUID -ne 0 ]]; then
    [[ -z "$required" ]] && return 0
    echo "Some packages are missing. Run this once, then start again:"
    echo
    echo "    sudo apt-get install -y --no-install-recommends $required $optional"
    exit 1
  fi
  say "Installing packages: $required $optional"
  apt_log=$(mktemp)
  apt-get -qq update < /dev/null > "$apt_log" 2>&1 || { cat "$apt_log" >&2; die "apt-get update failed"; }
  # shellcheck disable=SC2086  # word splitting is wanted
  if [[ -n "$required" ]]; then
    apt_install $required || { tail -n 40 "$apt_log" >&2; die "apt-get install failed"; }
  fi
  for name in $optional; do
    apt_install "$name" || echo "warning: $name cannot be installed here; going on without it" >&2
  done
  rm -f "$apt_log"
}

# job_count: as many jobs as cores, and no more than the memory holds (1.5 GiB a compiler).
job_count() {
  local cores available_kib jobs
  cores=$(nproc)
  available_kib=$(sed -n 's/^MemAvailable: *\([0-9]*\) kB/\1/p' /proc/meminfo)
  jobs=$(( ${available_kib:-1572864} / 1572864 ))
  (( jobs < 1 )) && jobs=1
  (( jobs > cores )) && jobs=$cores
  echo "$jobs"
}

# build PRESET [TARGET...]
build() {
  local preset=$1 log
  shift
  log=$(mktemp)
  cmake --preset "$preset" -DCMAKE_EXPORT_COMPILE_COMMANDS=ON > "$log" 2>&1 || { cat "$log" >&2; die "configuring failed (preset $preset)"; }
  rm -f "$log"
  cmake --build --preset "$preset" --parallel "$(job_count)" ${1+--target "$@"}
}

# timed NAME COMMAND...: runs it and notes its wall time for `timings`.
timing_names=()
timing_values_s=()
timed() {
  local name=$1 start=$SECONDS
  shift
  "$@"
  timing_names+=("$name")
  timing_values_s+=($(( SECONDS - start )))
}

timings() {
  local i
  for i in "${!timing_names[@]}"; do
    printf '  %-28s %5d s\n' "${timing_names[$i]}" "${timing_values_s[$i]}"
  done
}
