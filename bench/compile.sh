#!/bin/sh
# Usage: sh bench/compile.sh
# Measures compile time and memory of one file at -O2 for each way to use the library (headers only,
# cageform::compiled), with each installed compiler (CXX selects others). Then measures a clone in a build
# without optimisation, with headers only and with the library. Each row has a budget of time and of megabytes.
# The time is a multiple of that for a file that uses std::regex, so the budget does not depend on the machine.
# Fails and lists the rows that exceed their budget twice.
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

awk '/^```cpp/ { inside = 1; next } /^```/ { if (inside) exit } inside' "$root/README.md" > "$work/readme.cpp"
[ -s "$work/readme.cpp" ] || { echo "compile.sh: README.md has no program" >&2; exit 1; }
echo '#include <cageform/cageform.hpp>' > "$work/umbrella.cpp"
echo '#include <cageform/runtime.hpp>' > "$work/runtime.cpp"
echo '#include <cageform/coordinates/harmonic.hpp>' > "$work/harmonic.cpp"
cat > "$work/plane.cpp" <<'END'
#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/harmonic.hpp>
using Points = std::vector<std::array<double, 2>>;
bool bind_figure(const Points& cage, const Points& figure) {
    return cageform::bind(cageform::HarmonicCoordinates(cage), figure).report.status == cageform::Status::ok;
}
END
cat > "$work/mean_value.cpp" <<'END'
#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/mean_value.hpp>
using Points = std::vector<std::array<double, 2>>;
bool bind_figure(const Points& cage, const Points& figure) {
    return cageform::bind(cageform::MeanValueCoordinates(cage), figure).report.status == cageform::Status::ok;
}
END
cat > "$work/space.cpp" <<'END'
#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/harmonic.hpp>
using Points = std::vector<std::array<double, 3>>;
using Faces = std::vector<std::array<std::uint32_t, 3>>;
bool bind_figure(const Points& cage, const Faces& faces, const Points& figure) {
    return cageform::bind(cageform::HarmonicCoordinates(cage, faces), figure).report.status == cageform::Status::ok;
}
END
cat > "$work/standard.cpp" <<'END'
#include <iostream>
#include <map>
#include <regex>
#include <string>
#include <vector>
int main() {
    const std::regex word("([a-z]+)-([0-9]+)", std::regex::icase);
    std::map<std::string, std::vector<int>> found;
    for (std::string line; std::getline(std::cin, line);) {
        for (std::sregex_iterator it(line.begin(), line.end(), word), end; it != end; ++it)
            found[(*it)[1]].push_back(std::stoi((*it)[2]));
    }
    for (const auto& [name, numbers] : found) std::cout << name << ' ' << numbers.size() << '\n';
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
# Runs a command and prints its processor seconds and megabytes.
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
    std::printf("%.2f %.0f\n", seconds, double(use.ru_maxrss) / 1024);
}
END

cost() { # COMPILER SOURCE[:compiled]
  library=
  [ "$2" = "${2%:compiled}" ] || library=-DCAGEFORM_COMPILED
  # shellcheck disable=SC2086 # the flags are words
  "$work/cost" "$1" $flags -O2 $library -c "$work/${2%:compiled}.cpp" -o "$work/object.o"
}
# Each line: source; description; budget in multiples of the std::regex file, and in megabytes. A :compiled
# source leaves bind, solvers and formulas to the library.
cat > "$work/rows" <<'END'
runtime runtime.hpp alone; 0.25 160
umbrella cageform.hpp alone; 1.2 400
harmonic harmonic.hpp alone; 1.1 350
readme README example; 2.4 480
mean_value mean value bind, plane; 2.4 480
plane harmonic bind, plane; 6 680
space harmonic bind, space; 6.5 750
mean_value:compiled mean value, with the library; 1.5 380
plane:compiled harmonic, plane, with the library; 1.5 380
space:compiled harmonic, space, with the library; 1.7 400
END

over=
for compiler in $compilers; do
  command -v "$compiler" > "$work/found" || continue
  [ -x "$work/cost" ] || "$compiler" -std=c++20 "$work/cost.cpp" -o "$work/cost"
  unit=$(cost "$compiler" standard) || { echo "compile.sh: $compiler cannot compile a file that uses std::regex" >&2; exit 1; }
  printf '%-28s %8s %8s     of budget\n' "$compiler -O2" seconds MB
  printf '  %-26s %8.1f %8.0f\n' "std::regex in use" ${unit% *} ${unit#* }
  while read -r source row; do
    what=${row%;*}
    budget=${row#*; }
    for try in 1 2; do
      taken=$(cost "$compiler" "$source") || { echo "compile.sh: $compiler does not compile: $what" >&2; exit 1; }
      shares=$(echo "$taken $unit $budget" | awk '{ printf "%.0f %.0f", 100 * $1 / ($3 * $5), 100 * $2 / $6 }')
      { [ "${shares% *}" -gt 100 ] || [ "${shares#* }" -gt 100 ]; } || break
      [ $try = 2 ] || unit=$(cost "$compiler" standard) # another program may have interfered
    done
    note=
    [ "${shares% *}" -le 100 ] && [ "${shares#* }" -le 100 ] || { note="  OVER"; over="$over, $what ($compiler)"; }
    printf '  %-26s %8.1f %8.0f   %4d %% %4d %%%s\n' "$what" ${taken% *} ${taken#* } ${shares% *} ${shares#* } "$note"
  done < "$work/rows"
  # shellcheck disable=SC2086
  "$compiler" $flags -O0 "$work/clone.cpp" -o "$work/clone"
  printf '  %-26s %s\n' "-O0: clone of 8,019 x 112" "$("$work/clone")"
  # shellcheck disable=SC2086
  "$compiler" $flags -O2 -DCAGEFORM_COMPILED -DCAGEFORM_D=3 -c "$root/cmake/compiled/clone.cpp" -o "$work/library.o"
  # shellcheck disable=SC2086
  "$compiler" $flags -O0 -DCAGEFORM_COMPILED "$work/clone.cpp" "$work/library.o" -o "$work/clone"
  printf '  %-26s %s\n' "-O0, with the library" "$("$work/clone")"
done
[ -x "$work/cost" ] || { echo "compile.sh: none of these compilers is installed: $compilers" >&2; exit 1; }
[ -z "$over" ] || { echo "compile.sh: over the budget: ${over#, }" >&2; exit 1; }
