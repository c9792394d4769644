# shellcheck shell=bash
# Building for ARM, sourced by .ci/run: finds a toolchain and an emulator, installing what is missing.
#
#   arm_ready TARGET          whether TARGET can be built and run here; the first call may install things
#   ${ARM_WHY[TARGET]}        why not
#   arm_cargo TARGET ARGS...  cargo ARGS for TARGET, whichever toolchain it is
#   arm_rustc TARGET ARGS...  its compiler
#   arm_variable TARGET NAME  the environment variable by which cargo takes NAME for TARGET
#   arm_emulator TARGET       the emulator's path, for targets that run a Linux program
#   arm_libraries TARGET      the environment it needs for programs that are not static
#
# Two ways, tried in this order; COMPASS_ARM=rustup or COMPASS_ARM=debian allows only one.
#   rustup  `rustup target add TARGET`
#   debian  Debian's rustc-web. Bare-metal targets build their own `core`; Linux targets take the standard
#           library out of the package for the foreign architecture, unpacked below the target directory.

# shellcheck disable=SC2034 # ARM_WHY is for the caller.
declare -A ARM_WAY=() ARM_WHY=()

arm_ready() {
  local target=$1
  if [[ -z ${ARM_WAY[$target]:-} ]]; then
    ARM_WAY[$target]=none
    if ! arm_tools "$target"; then
      ARM_WHY[$target]="no emulator or linker for $target, and Debian's packages could not be installed"
    elif [[ ${COMPASS_ARM:-rustup} == rustup ]] && arm_by_rustup "$target"; then
      ARM_WAY[$target]=rustup
    elif [[ ${COMPASS_ARM:-debian} == debian ]] && arm_by_debian "$target"; then
      ARM_WAY[$target]=debian
    else
      ARM_WHY[$target]="neither rustup nor Debian's rustc-web can build for $target here"
    fi
  fi
  [[ ${ARM_WAY[$target]} != none ]]
}

arm_cargo() {
  local target=$1
  shift
  arm_ready "$target" || return
  local settings=(CARGO_BUILD_TARGET="$target" CARGO_TARGET_DIR="$(arm_directory)") cargo=cargo
  case $target in
    *-linux-*)
      settings+=("$(arm_variable "$target" RUNNER)=$(arm_emulator "$target")" "$(arm_libraries "$target")")
      settings+=("$(arm_variable "$target" LINKER)=$(arm_linker "$target")")
      ;;
  esac
  if [[ ${ARM_WAY[$target]} == debian ]]; then
    cargo=/usr/bin/cargo
    settings+=(RUSTC=/usr/bin/rustc)
    case $target in
      *-linux-*)
        if [[ -d $(arm_sysroot "$target") ]]; then
          settings+=("$(arm_variable "$target" RUSTFLAGS)=--sysroot $(arm_sysroot "$target")")
        else
          settings+=(RUSTC_BOOTSTRAP=1 "CARGO_UNSTABLE_BUILD_STD=std,panic_abort")
        fi
        ;;
      *) settings+=("$(arm_variable "$target" LINKER)=ld.lld" RUSTC_BOOTSTRAP=1 CARGO_UNSTABLE_BUILD_STD=core) ;;
    esac
  fi
  # Flags meant for the host must not reach the target, and would hide those of the target's own table.
  env -u RUSTFLAGS -u CARGO_ENCODED_RUSTFLAGS "${settings[@]}" "$cargo" "$@"
}

arm_rustc() {
  local target=$1
  shift
  arm_ready "$target" || return
  if [[ ${ARM_WAY[$target]} == debian ]]; then /usr/bin/rustc "$@"; else rustc "$@"; fi
}

arm_variable() {
  local name=CARGO_TARGET_${1^^}_$2
  echo "${name//[-.]/_}"
}

# One target directory for all, so that `core` and the dependencies are built once.
arm_directory() { echo "${CARGO_TARGET_DIR:-$PWD/target}/arm"; }

arm_sysroot() { echo "$(arm_directory)/sysroot-$1-$(dpkg-query -W -f '${Version}' rustc-web)"; }

arm_linker() {
  case $1 in
    aarch64-*) echo aarch64-linux-gnu-gcc ;;
    armv7-*) echo arm-linux-gnueabihf-gcc ;;
  esac
}

# Where the emulator finds the libraries of programs that are not static, as a setting of the environment.
arm_libraries() {
  local linker
  linker=$(arm_linker "$1")
  echo "QEMU_LD_PREFIX=/usr/${linker%-gcc}"
}

# Newer distributions call the static emulator by the plain name.
arm_emulator() {
  local name=qemu-arm
  [[ $1 == aarch64-* ]] && name=qemu-aarch64
  command -v "$name-static" || command -v "$name"
}

# Emulator, and the linker and C library of Linux targets.
arm_tools() {
  case $1 in
    thumb*) command -v qemu-system-arm >/dev/null || debian_install qemu-system-arm ;;
    *)
      local packages=(gcc-aarch64-linux-gnu libc6-dev-arm64-cross)
      [[ $1 == armv7-* ]] && packages=(gcc-arm-linux-gnueabihf libc6-dev-armhf-cross)
      arm_emulator "$1" >/dev/null || debian_install qemu-user-static || return
      command -v "$(arm_linker "$1")" >/dev/null || debian_install "${packages[@]}"
      ;;
  esac
}

arm_by_rustup() {
  command -v rustup >/dev/null || return
  rustup target list --installed 2>/dev/null | grep -qx "$1" && return
  # A machine that cannot download is not asked a second time.
  [[ -z ${ARM_RUSTUP_FAILED:-} ]] || return
  echo "rustup target add $1"
  if ! RUSTUP_MAX_RETRIES=0 timeout 90 rustup target add "$1" </dev/null >/dev/null 2>&1; then
    echo "rustup cannot add $1 here"
    ARM_RUSTUP_FAILED=1
    return 1
  fi
}

arm_by_debian() {
  debian_install rustc-web cargo-web || return
  case $1 in
    thumb*) debian_install rust-web-src lld ;;
    *)
      [[ -d $(arm_sysroot "$1") ]] && return
      debian_standard_library "$1" && return
      echo "no packaged standard library for $1"
      # Building it takes a quarter of an hour: not for more than one target.
      [[ $1 == aarch64-* ]] && debian_install rust-web-src
      ;;
  esac
}

# The standard library for $1 as a sysroot, from the package of exactly the installed compiler's version.
# The package is unpacked, not installed: it would pull in half a foreign system. Reading the foreign package
# list into a directory of our own leaves the system's apt configuration alone.
debian_standard_library() {
  local target=$1 architecture=arm64 sysroot scratch host version options
  [[ $target == armv7-* ]] && architecture=armhf
  sysroot=$(arm_sysroot "$target")
  scratch=$(arm_directory)/apt-$architecture
  version=$(dpkg-query -W -f '${Version}' rustc-web)
  host=$(/usr/bin/rustc -vV | sed -n 's/^host: //p')
  options=(-qq -o APT::Architectures::="$architecture" -o APT::Sandbox::User=root -o Acquire::Languages=none
    -o Dir::State::lists="$scratch/lists" -o Dir::Cache="$scratch/cache")
  mkdir -p "$scratch"/{lists,cache/archives}/partial
  echo "unpacking libstd-rust-web-dev:$architecture $version"
  (
    cd "$scratch" || exit
    timeout 300 apt-get "${options[@]}" update
    timeout 300 apt-get "${options[@]}" download "libstd-rust-web-dev:$architecture=$version" &&
      dpkg -x libstd-rust-web-dev_*_"$architecture".deb unpacked
  ) </dev/null >"$scratch/log" 2>&1 || {
    grep -m 1 '^E:' "$scratch/log"
    return 1
  }
  local library=$scratch/unpacked/usr/lib/rustlib/$target
  [[ -d $library ]] || return
  rm -rf "$sysroot.new"
  mkdir -p "$sysroot.new/lib/rustlib"
  ln -s "$(realpath "$library")" "/usr/lib/rustlib/$host" "$sysroot.new/lib/rustlib/"
  mv "$sysroot.new" "$sysroot"
}

# Installs the missing ones of the named packages; fails quietly where that is not possible.
debian_install() {
  local missing=() package sudo=()
  command -v apt-get >/dev/null || return
  for package; do
    [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) == installed ]] || missing+=("$package")
  done
  ((${#missing[@]})) || return 0
  if ((EUID != 0)); then
    sudo -n true 2>/dev/null || return
    sudo=(sudo -n)
  fi
  local log
  log=$(arm_directory)/apt.log
  mkdir -p "${log%/*}"
  if [[ -z ${DEBIAN_LISTS_READ:-} ]]; then
    timeout 300 "${sudo[@]}" apt-get -qq update </dev/null >"$log" 2>&1 || true
    DEBIAN_LISTS_READ=1
  fi
  echo "installing ${missing[*]}"
  if ! timeout 900 "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get -qq install -y --no-install-recommends "${missing[@]}" </dev/null >"$log" 2>&1; then
    tail -n 5 "$log"
    return 1
  fi
}
