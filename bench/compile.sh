#!/bin/sh
# sh bench/compile.sh: what the headers cost those who include them.
# For each way to use the library the seconds of processor and the megabytes that one file takes to compile, with each
# compiler installed (CXX names others); then how long a clone takes in a build without optimisation.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
compilers=${CXX:-"g++ clang++-19"}
flags="-std=c++20 -I$root/include"
for folder in /usr/include/eigen3 /usr/local/include/eigen3 /opt/homebrew/include/eigen3; do
  [ ! -d "$folder" ] || flags="$flags -isystem $folder"
done

# The sources.
awk '/^```cpp/ { inside = 1; next } /^```/ { if (inside) exit } inside' "$root/README.md" > "$work/readme.cpp"
[ -s "$work/readme.cpp" ] || { echo "compile.sh: no program in README.md" >&2; exit 1; }
echo '#include <cageform/cageform.hpp>' > "$work/umbrella.cpp"
echo '#include <cageform/runtime.hpp>' > "$work/runtime.cpp"
cat > "$work/plane.cpp" <<'END'
#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/mean_value.hpp>
using Points = std::vector<std::array<double, 2>>;
bool bind_both(const Points& cage, const Points& figure) {
    const cageform::MeanValueCoordinates2d mean_value(cage);
    const cageform::HarmonicCoordinates2d harmonic(cage);
    return cageform::bind(mean_value, figure).report.status == cageform::Status::ok &&
           cageform::bind(harmonic, figure).report.status == cageform::Status::ok;
}
END
cat > "$work/space.cpp" <<'END'
#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/mean_value_3d.hpp>
using Points = std::vector<std::array<double, 3>>;
using Faces = std::vector<std::array<std::uint32_t, 3>>;
bool bind_both(const Points& cage, const Faces& faces, const Points& figure) {
    const cageform::MeanValueCoordinates3d mean_value(cage, faces);
    const cageform::HarmonicCoordinates3d harmonic(cage, faces);
    return cageform::bind(mean_value, figure).report.status == cageform::Status::ok &&
           cageform::bind(harmonic, figure).report.status == cageform::Status::ok;
}
END
cat > "$work/clone.cpp" <<'END'
#include <cageform/runtime.hpp>
#include <chrono>
#include <cstdio>
template <class T>
double milliseconds() {
    constexpr std::size_t points = 8019, handles = 112, blocks = cageform::block_count<T>(points);
    std::vector<cageform::Lanes<T>> weights(blocks * handles), rest(blocks * 3);
    for (auto& row : weights) {
        for (auto& w : row.v) w = T(1) / T(handles);
    }
    for (auto& row : rest) {
        for (auto& x : row.v) x = T(0);
    }
    std::vector<cageform::Vec<T, 3>> cage(handles), out(points);
    for (std::size_t i = 0; i < handles; ++i) cage[i] = {T(i), T(i % 7), T(i % 5)};
    const cageform::Binding<T, 3> binding(std::move(weights), std::move(rest), cage, points);
    cage[3][0] += T(1);
    double least = 1e9;
    for (int run = 0; run < 30; ++run) {
        const auto start = std::chrono::steady_clock::now();
        if (clone(binding, cage, out) != cageform::Status::ok) return -1;
        const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
        if (time.count() < least) least = time.count();
    }
    return least;
}
int main() { std::printf("float %.1f ms, double %.1f ms\n", milliseconds<float>(), milliseconds<double>()); }
END
# Runs a command and prints what it took: seconds of processor and megabytes.
cat > "$work/cost.cpp" <<'END'
#include <cstdio>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
int main(int, char** words) {
    if (const pid_t child = fork(); child == 0) {
        execvp(words[1], words + 1);
        _exit(127);
    }
    int status = 0;
    rusage use{};
    if (wait(&status) < 0 || status != 0 || getrusage(RUSAGE_CHILDREN, &use) != 0) return 1;
    const double seconds = double(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
                           1e-6 * double(use.ru_utime.tv_usec + use.ru_stime.tv_usec);
    std::printf("%6.1f s %6.0f MB\n", seconds, double(use.ru_maxrss) / 1024);
}
END

for compiler in $compilers; do
  command -v "$compiler" > "$work/found" || continue
  [ -x "$work/cost" ] || "$compiler" -std=c++20 "$work/cost.cpp" -o "$work/cost"
  echo "$compiler -O2"
  for source in runtime umbrella readme plane space; do
    case $source in
      runtime) what="runtime.hpp alone" ;;
      umbrella) what="cageform.hpp alone" ;;
      readme) what="README's ten lines" ;;
      plane) what="mean value and harmonic, plane" ;;
      space) what="mean value and harmonic, space" ;;
    esac
    # shellcheck disable=SC2086 # the flags are words
    taken=$("$work/cost" "$compiler" $flags -O2 -c "$work/$source.cpp" -o "$work/$source.o") ||
      { echo "compile.sh: $compiler does not compile: $what" >&2; exit 1; }
    printf '  %-32s%s\n' "$what" "$taken"
  done
  # shellcheck disable=SC2086
  "$compiler" $flags -O0 "$work/clone.cpp" -o "$work/clone"
  printf '  %-32s  %s\n' "-O0: a clone of 8,019 x 112" "$("$work/clone")"
done
[ -x "$work/cost" ] || { echo "compile.sh: none of these compilers is here: $compilers" >&2; exit 1; }
