#!/bin/sh
# Usage: sh bench/run.sh [--csv FILE | --count] [--compiled] [WORDS]
# Installs what the benchmarks need (Debian), builds them with -O3 -march=native into build/bench and runs them.
# Prints four tables: one thread; one, two and four threads; clones compiled with -O2 against -O3; compile time.
# Takes about ten minutes. bench/README.md explains the tables.
#   WORDS       prints only rows with these words in the description or the benchmark name, for example clone or
#               "solve in space"
#   --csv FILE  writes all medians and quartiles, in seconds
#   --count     prints the instructions of our benchmark in each row (callgrind, x86-64-v3) instead of times
#   --compiled  links the compiled library (cageform::compiled) instead of headers only
set -eu
usage="usage: sh bench/run.sh [--csv FILE | --count] [--compiled] [WORDS]"
fail() { # SENTENCE
  echo "bench/run.sh: $1" >&2
  exit 1
}
csv=
count=
compiled=
words=
while [ $# -gt 0 ]; do
  case $1 in
    --help | -h) sed -n '2,/^set/s/^# \{0,1\}//p' "$0" && exit 0 ;;
    --csv)
      [ $# -ge 2 ] || fail "--csv needs the name of a file; $usage"
      csv=$2
      shift
      ;;
    --count) count=yes ;;
    --compiled) compiled=-compiled ;;
    -*) fail "unknown option $1; $usage" ;;
    '') fail "WORDS is empty; $usage" ;;
    *)
      [ -z "$words" ] || fail "WORDS given twice: \"$words\" and \"$1\" (quote several words); $usage"
      words=$1
      ;;
  esac
  shift
done
case $csv in
  '' | /*) ;;
  *) csv=$PWD/$csv ;;
esac
[ -z "$csv" ] || { [ ! -d "$csv" ] && [ -d "$(dirname "$csv")" ] && [ -w "$(dirname "$csv")" ]; } || fail "cannot write $csv"
load=$(cut -d ' ' -f 1 /proc/loadavg 2>/dev/null || echo 0) # before the build
cd "$(dirname "$0")/.."

# A group is one process; its benchmarks are measured in turn, REPETITIONS times.
#   group PROGRAM REPETITIONS
#   row   description; our benchmark; peer; its benchmarks (best of several, separated by &); limit; its benchmark
#   row   description; our benchmark, where @ is the number of threads
#   row   description; our benchmark, where % is a compiler and its optimisation level
rows() {
  at=points:10000/handles:25
  many=points:1000000/handles:25
  cgal="CGAL fast with edges"
  plain="plain loop, double; plain_mean_value_mesh"
  in_double="writing weights; limit_write_weights/again/points:8019/handles:112"
  in_float="writing weights; limit_write_weights/again/points:8019/handles:56" # 56 doubles have as many bytes as 112 floats
  plane="multigrid<2>/n:1024/threads:1/real_time"
  plane_moved="moving the solution once; limit_move_solution<2>/n:1024"
  eigen="Eigen, best layout; eigen_product<float"
  cat <<END
group bind 9
row mean value, plane, 10k x 25, double: weights alone; evaluate_mean_value<double>/$at; $cgal; mean_value_of_cgal/again/$at; writing weights; limit_write_weights/again/$at
row mean value, plane, 10k x 25, double: bind; bind_mean_value_again<double>/$at; $cgal; mean_value_of_cgal/again/$at; writing weights; limit_write_weights/again/$at
group bind 7
row mean value, plane, 1M x 25, double: bind, memory in use; bind_mean_value_again<double>/$many; $cgal; mean_value_of_cgal/again/$many; writing weights; limit_write_weights/again/$many
row mean value, plane, 1M x 25, double: bind, new memory; bind_mean_value<double>/$many; $cgal, in use; mean_value_of_cgal/again/$many; writing weights; limit_write_weights/new/$many
row mean value, plane, 1M x 25, double: bind, new memory; bind_mean_value<double>/$many; $cgal, new; mean_value_of_cgal/new/$many; writing weights; limit_write_weights/new/$many
group bind 7
row mean value, space, 8,019 x 112, double: weights alone; evaluate_mean_value_mesh<double>; $plain; $in_double
row mean value, space, 8,019 x 112, double: bind; bind_mean_value_mesh<double>; $plain; $in_double
row mean value, space, 8,019 x 112, float: weights alone; evaluate_mean_value_mesh<float>; $plain; $in_float
row mean value, space, 8,019 x 112, float: bind; bind_mean_value_mesh<float>; $plain; $in_float
group bind 7
row maximum entropy, plane, 10k x 25, double: weights alone; evaluate_maximum_entropy<double, Wanted::weights>/10000/25; mean value; evaluate_mean_value<double>/$at; writing weights; limit_write_weights/again/$at
group bind 5
row maximum entropy, space, 8,019 x 112, double: weights alone; evaluate_maximum_entropy_mesh<double, Wanted::weights>; mean value; evaluate_mean_value_mesh<double>; $in_double
group grid 7
row solve in the plane, 1024^2 x 25; $plane; papers' sweeps, to 1e-2; papers_sweeps<2>/n:1024; $plane_moved
group grid 3
row solve in the plane, 1024^2 x 25; $plane; Eigen's LDLT; ldlt<2>/n:1024; $plane_moved
group grid 3
row solve in the plane, 1024^2 x 25; $plane; CHOLMOD; cholmod<2>/n:1024; $plane_moved
group grid 5
row solve in space, 128^3 x 112; multigrid<3>/n:128/threads:1/real_time; papers' sweeps, to 5e-2; papers_sweeps<3>/n:128; moving the solution once; limit_move_solution<3>/n:128
group clone 11
row clone, 1M x 25, float; clone_dense<float, 2>/$many; $eigen, 2, Eigen::RowMajor>/$many & eigen_product<float, 2, Eigen::ColMajor>/$many; moving its bytes; limit_move_bytes<float, 2>/$many
group clone 11
row clone, 8,019 x 112, float; clone_dense<float, 3>/points:8019/handles:112; $eigen, 3, Eigen::RowMajor>/points:8019/handles:112 & eigen_product<float, 3, Eigen::ColMajor>/points:8019/handles:112; moving its bytes; limit_move_bytes<float, 3>/points:8019/handles:112
group clone 11
row transposed clone, 1M x 25, float; transposed_dense<float, 2>/$many; the clone; clone_dense<float, 2>/$many; moving its bytes; limit_move_bytes<float, 2>/$many
group clone 11
row transposed clone, 8,019 x 112, float; transposed_dense<float, 3>/points:8019/handles:112; the clone; clone_dense<float, 3>/points:8019/handles:112; moving its bytes; limit_move_bytes<float, 3>/points:8019/handles:112
group levels 7
row level: clone, plane, dense, float; dense_plane/float/%
row level: clone, plane, dense, double; dense_plane/double/%
row level: clone, space, dense, float; dense_space/float/%
row level: clone, space, dense, double; dense_space/double/%
row level: clone, space, packed, float; packed_scalar/float/%
row level: clone, space, packed, half; packed_half/float/%
row level: clone, space, packed, int16; packed_int16/float/%
row level: clone, space, packed, int8; packed_int8/float/%
row level: clone, packed figure, normals, tangents, int16; figure_int16/float/%
row level: clone, normals alone, dense, float; normals/float/%
row level: clone, Jacobians, dense, float; jacobians/float/%
group grid 3
row threads: solve in space, 128^3 x 112; multigrid<3>/n:128/threads:@/real_time
group grid 5
row threads: solve in the plane, 1024^2 x 25; multigrid<2>/n:1024/threads:@/real_time
group bind 7
row threads: mean value, plane, 1M x 25, double: bind; bind_mean_value_threads<double>/$many/threads:@/real_time
row threads: mean value, space, 8,019 x 112, double: bind; bind_mean_value_mesh_threads<double>/threads:@/real_time
group clone 11
row threads: clone, 1M x 25, float; clone_threads<float, 2>/$many/threads:@/real_time
row threads: clone, 1M x 25, float: memory bandwidth; limit_move_bytes_threads<float, 2>/$many/threads:@/real_time
row threads: clone, 100k x 112, float; clone_threads<float, 3>/points:100000/handles:112/threads:@/real_time
row threads: clone, 100k x 112, float: memory bandwidth; limit_move_bytes_threads<float, 3>/points:100000/handles:112/threads:@/real_time
END
}
out=build/bench/results
rm -rf $out
mkdir -p $out
# Selected rows and their groups, numbered.
rows | awk -v words="$words" '
  /^group/ { group = $0; next }
  index(tolower($0), tolower(words)) { if (group != "") { ++n; print group > "/dev/stderr"; group = "" } print n, substr($0, 5) }
' >$out/rows 2>$out/groups
compile=
[ -n "$count" ] || case "compile time" in *"$words"*) compile=yes ;; esac
[ -s $out/rows ] || [ -n "$compile" ] || fail "no row matches \"$words\"; try mean value, solve, clone, threads, level, compile time"

sh cmake/install_packages.sh g++ cmake ninja-build libeigen3-dev libbenchmark-dev
sh cmake/install_packages.sh libcgal-dev libgmp-dev libmpfr-dev libsuitesparse-dev libopenblas0-serial ||
  echo "Continuing; rows without their peer show 'missing'." >&2

# ---- the machine
read_file() { cat "$1" 2>/dev/null || echo unknown; }
compiler=${CXX:-c++}
flags="-O3 -march=native -DNDEBUG"
folder=build/bench$compiled
if [ -n "$count" ]; then
  sh cmake/install_packages.sh valgrind
  folder=build/count$compiled
  [ "$(uname -m)" != x86_64 ] || flags="-O3 -march=x86-64-v3 -DNDEBUG" # callgrind does not support AVX-512
fi
# Installed compilers, and names of the objects of bench/level.cpp.
compilers=
! command -v g++ >$out/found || compilers="$compilers gxx"
! command -v clang++-19 >$out/found || compilers="$compilers clang"
objects=$(for name in $compilers; do echo "$name-O3 $name-O2"; done)
# Portable flags, as for shipped programs.
compile_levels() {
  mkdir -p $folder/bench/levels
  for object in $objects; do
    case $object in gxx*) by=g++ ;; *) by=clang++-19 ;; esac
    $by -std=c++20 -"${object#*-}" -DNDEBUG -fPIC -shared -fvisibility=hidden -Iinclude bench/level.cpp -o "$folder/bench/levels/$object.so" || return 1
  done
}
cores=$(getconf _NPROCESSORS_ONLN)
cpu=$(awk -F ': *' '/^model name/ { print $2; exit }' /proc/cpuinfo 2>/dev/null || true)
simd=$(awk '/^flags/ { print / avx512f / ? "AVX-512" : / avx2 / ? "AVX2" : "SSE2"; exit }' /proc/cpuinfo 2>/dev/null || true)
caches=$(for index in /sys/devices/system/cpu/cpu0/cache/index*; do
  case $(read_file "$index/level")$(read_file "$index/type") in
    1Instruction | unknown*) ;;
    *) printf ', L%s %s' "$(read_file "$index/level")" "$(read_file "$index/size")" ;;
  esac
done)
huge=$(sed -n 's/.*\[\(.*\)\].*/\1/p' /sys/kernel/mm/transparent_hugepage/enabled 2>/dev/null || true)
echo "${cpu:-unknown processor}, family $(awk -F ': *' '/^cpu family/ { f = $2 } /^model\t/ { print f " model " $2; exit }' /proc/cpuinfo 2>/dev/null || true), $cores processors, ${simd:-$(uname -m)}$caches," \
  "pages of $(getconf PAGESIZE) bytes, huge ones: ${huge:-none}; $("$compiler" --version | head -n 1), $flags; load $load at the start"
quiet=$(awk -v load="$load" 'BEGIN { print load < 0.3 ? "yes" : "no" }')
[ $quiet = yes ] || echo "WARNING: the machine is under load; ratios within a row remain comparable, times do not."
echo

# ---- build
if [ -s $out/groups ]; then
  targets=$(awk '{ print "bench_" $2 }' $out/groups | sort -u)
  printf 'Building %s into %s (a minute or two) ... ' "$(echo $targets)" $folder >&2
  # shellcheck disable=SC2086 # the targets are words
  {
    cmake -S . -B $folder -G Ninja -DCMAKE_BUILD_TYPE= "-DCMAKE_CXX_FLAGS=$flags" -DCAGEFORM_BUILD_TESTS=OFF \
      -DCAGEFORM_BUILD_EXAMPLES=OFF -DCAGEFORM_BUILD_BENCH=ON ${compiled:+-DCAGEFORM_BUILD_COMPILED=ON} &&
      cmake --build $folder --target $targets &&
      case $targets in *levels*) compile_levels ;; esac
  } >$out/build.txt 2>&1 || { cat $out/build.txt >&2; fail "the benchmarks were not built"; }
  echo done >&2
fi

# ---- count
if [ -n "$count" ]; then
  printf '| %-60s | %14s |\n' "one run of" instructions
  while read -r _ program _; do
    n=$((${n:-0} + 1))
    awk -v n=$n -v objects="$objects" -F ' *; *' '
      { number = $1; sub(/ .*/, "", number); sub(/^[0-9]+ (level: )?/, "", $1) }
      number == n && $2 ~ /%/ { parts = split(objects, of, /[ \n]+/); for (i = 1; i <= parts; ++i) { name = $2; sub(/%/, of[i], name); print name ";" $1 ": " of[i] } }
      number == n && $2 !~ /[@%]/ { print $2 ";" $1 }' $out/rows |
      while IFS=';' read -r name what; do
        grep -qxF "$name" $out/counted 2>/dev/null && continue # counted with another peer
        echo "$name" >>$out/counted
        valgrind --tool=callgrind --instr-atstart=no --collect-atstart=no --callgrind-out-file=/dev/null $folder/bench/bench_$program \
          "--benchmark_filter=^$name\$" --benchmark_min_time=0 >$out/$n.txt 2>&1 </dev/null || fail "callgrind failed: see $out/$n.txt"
        printf '| %-60s | %14s |\n' "$what" "$(awk '/Collected/ { print $NF }' $out/$n.txt)"
      done
  done <$out/groups
  exit
fi

# ---- run
# One thread for CHOLMOD: by default CHOLMOD starts several threads, which busy-wait.
export OMP_THREAD_LIMIT=1 OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
busy() { awk '/^cpu / { print $2 + $3 + $4 + $7 + $8, $9; exit }' /proc/stat 2>/dev/null || echo 0 0; }
others=$out/others # jiffies of all programs and of this script, before and after
note() { times >$out/times && { busy; awk 'NR == 2' $out/times; date +%s; } | tr '\n' ' ' && echo; }
pin= # pinning cuts the spread of single-threaded rows to a third
last=$((cores - 1))
! taskset -c $last true 2>/dev/null || pin="taskset -c $last"
note >$others
n=0
all=$(wc -l <$out/groups)
while read -r _ program repetitions; do
  n=$((n + 1))
  printf '[%d/%d] %s\n' $n "$all" "$(awk -v n=$n '$1 == n { sub(/^[0-9]+ /, ""); sub(/;.*/, ""); print; exit }' $out/rows)" >&2
  names=$(awk -v n=$n -v objects="$objects" -F ' *; *' '
    function name(text,    k) {
      if (text ~ /%/) { gsub(/[ \n]+/, "|", objects); sub(/%/, "(" objects ")", text) }
      if (text !~ /@/) add(text); else for (k = 1; k <= 4; k *= 2) { copy = text; sub(/@/, k, copy); add(copy) }
    }
    function add(text) { all = all (all == "" ? "" : "|") text }
    { number = $1; sub(/ .*/, "", number) }
    number == n { name($2); parts = split($4, of, / *& */); for (i = 1; i <= parts; ++i) name(of[i]); if ($6 != "") name($6) }
    END { print all }' $out/rows)
  on=$pin
  case $names in *threads:4*) on= ;; esac
  # shellcheck disable=SC2086
  timeout 150 $on $folder/bench/bench_$program "--benchmark_filter=^($names)\$" --benchmark_repetitions=$repetitions \
    --benchmark_enable_random_interleaving=true --benchmark_min_time=0.05 --benchmark_format=json \
    >"$out/$n.json" 2>"$out/$n.txt" </dev/null || echo "  not finished in 150 s, or failed ($out/$n.txt)" >&2
done <$out/groups
note >>$others

# ---- print
awk -v tick="$(getconf CLK_TCK)" '
  function own(text) { split(text, of, /[ms]/); return 60 * of[1] + of[2] }
  { busy[NR] = $1 / tick - own($3) - own($4); taken[NR] = $2 / tick; at[NR] = $5 }
  END {
    wall = at[2] - at[1]
    if (wall < 1) exit
    other = (busy[2] - busy[1]) / wall
    if (other > 0.1) printf "WARNING: other programs used %.1f processors during the run.\n", other
    if (taken[2] - taken[1] > 0.02 * wall) printf "WARNING: other virtual machines took %.0f %% of a processor during the run.\n", 100 * (taken[2] - taken[1]) / wall
  }' $others >$out/warnings
[ ! -s $out/rows ] || awk -v csv="$csv" -v cores="$cores" -v quiet=$quiet -v warnings=$out/warnings -f bench/run.awk $out/rows $out/[0-9]*.json
cat $out/warnings
if [ -n "$compile" ]; then
  [ ! -s $out/rows ] || echo
  echo "Compile time and its budget"
  CXX=$compiler sh bench/compile.sh
fi
