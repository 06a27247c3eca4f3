#!/bin/sh
# Usage: sh examples/integrations/farms/run.sh [PROGRAMS]
# Runs rows on Slurm and on Dask, with one and with two workers on this host. Compares all files with those of one
# process, byte for byte, and prints times. In one of the runs every task first returns 75 and is repeated. The files
# for OpenCue and Kubernetes are only parsed.
#   PROGRAMS   the folder of the programs; by default they are built into build/examples
# Installs the Debian packages of Slurm and Dask. Slurm's daemons run in a temporary folder with their own
# configuration and key, and end with the script. Needs root for Slurm's daemons.
set -eu
cd "$(dirname "$0")/../../.."
farms=$PWD/examples/integrations/farms
python=/usr/bin/python3
sh cmake/install_packages.sh slurm-wlm munge python3-dask python3-distributed python3-yaml
if [ $# -eq 0 ]; then
  sh examples/run.sh --build-only
  set -- build/examples
fi
programs=$(cd "$1" && pwd)
work=$(mktemp -d)
daemons=
end() {
  for daemon in $daemons; do kill "$daemon" 2>/dev/null || true; done
  for daemon in $daemons; do wait "$daemon" 2>/dev/null || true; done
  rm -rf "$work"
}
trap end EXIT
trap 'exit 1' INT TERM HUP
cd "$work"
report() { printf '%s\n' "$*"; }
timed() { # WHAT COMMAND…   prints its seconds
  label=$1
  shift
  begin=$(date +%s.%N)
  "$@" >>log 2>&1 || { cat log; echo "FAILED: $label"; exit 1; }
  printf '%-32s %6.1f s\n' "$label" "$(echo "$begin $(date +%s.%N)" | awk '{ print $2 - $1 }')"
}

# ---- the data: poses of a character, and tiles of points around it ----
"$programs/make_character" . >>log
"$programs/bind_mesh" character.obj --cage character_cage.obj -o character.figure
# Poses between the first pose of the clip and each of the others.
awk -F, -v rows=200 '/^pose/ { ++p } /^[-0-9]/ { for (k = 1; k <= 3; ++k) x[p, ++n[p]] = $k }
  END { for (r = 0; r < rows; ++r) { q = 1 + r % p; t = r / rows
    for (k = 1; k <= n[1]; ++k) printf "%.6f%s", x[1, k] + t * (x[q, k] - x[1, k]), k < n[1] ? "," : "\n" } }' \
  character_clip.csv >poses.csv
mkdir tiles
"$programs/make_tiles" character.obj --points 800000 --tiles 16 -o 'tiles/%02d.ply'

# A program that returns 75 on the first run of a task.
cat >tries_again <<'SH'
#!/bin/sh
for word in "$@"; do rows=$word; done
[ -e "$TRIED/$rows" ] || { : >"$TRIED/$rows"; exit 75; }
exec "$@"
SH
chmod +x tries_again

# ---- Slurm, only on this host ----
host=$(hostname -s)
port=$((20000 + $$ % 20000))
mkdir state spool
dd if=/dev/urandom of=munge.key bs=128 count=1 2>/dev/null
chmod 600 munge.key
cat >slurm.conf <<CONF
ClusterName=rows
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket,cred_expire=5
SlurmctldPort=$port
SlurmdPort=$((port + 1))
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,batch_sched_delay=0,bf_interval=1
MailProg=/bin/true
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=rows Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF="$work/slurm.conf"
daemon() { # NAME COMMAND…
  name=$1
  shift
  "$@" >"$name.log" 2>&1 &
  daemons="$! $daemons"
}
waits_for() { # WHAT COMMAND…   until it succeeds, 30 s at most
  label=$1
  shift
  tries=0
  until "$@" >>log 2>&1; do
    tries=$((tries + 1))
    [ $tries -lt 150 ] || { tail ./*.log; echo "FAILED: $label does not start"; exit 1; }
    sleep 0.2
  done
}
daemon munged munged --foreground --force --key-file="$work/munge.key" --socket="$work/munge.socket" \
  --pid-file="$work/munged.pid" --log-file="$work/munged.log" --seed-file="$work/munge.seed"
waits_for munged munge --socket="$work/munge.socket" --no-input
daemon slurmctld slurmctld -D -f slurm.conf
daemon slurmd slurmd -D -f slurm.conf
is_up() { sinfo -h -o %T | grep -qx idle; }
waits_for Slurm is_up
# ---- each job by one process, by Dask, by Slurm ----
# Arguments: the number of WORKERS, and optionally a wrapper BEFORE the program.
# shellcheck disable=SC2086 # the words are meant to be split
dask() { # WORKERS [BEFORE]
  $python "$farms/dask_map.py" "$1" $rows $task ${2:-} $words -o "$work/new/$names"
}
# shellcheck disable=SC2086
slurm() { # WORKERS [BEFORE]
  job=$(sbatch --parsable --array="0-$(((rows + task - 1) / task - 1))" --cpus-per-task=$((2 / $1)) \
    "$farms/slurm.sbatch" $task ${2:-} $words -o "$work/new/$names")
  # sbatch --wait would check only after 2, 10 and 42 s.
  busy='PENDING\|CONFIGURING\|RUNNING\|COMPLETING\|REQUEUE'
  while states=$(squeue -h -r -t all -j "$job" -o %T) && echo "$states" | grep -q "$busy"; do sleep 0.1; done
  [ "$(echo "$states" | sort -u)" = COMPLETED ]
}
compared() { # WHAT COMMAND…   into a new folder
  rm -rf new tried
  mkdir new tried
  export TRIED="$work/tried"
  timed "$@"
  diff -r one new >>log || { echo "FAILED: $1: files differ from those of one process"; exit 1; }
}
run_all() { # WHAT ROWS ROWS_A_TASK NAMES WORD…   the program and its words come last
  what=$1 rows=$2 task=$3 names=$4
  shift 4
  words=$*
  rm -rf one
  mkdir one
  timed "$what, one process" "$@" -o "$work/one/$names"
  report "  $(find one -type f | wc -l) files, $(du -sm one | cut -f 1) MB, tasks of $task"
  compared "$what, two threads" "$@" --threads 2 -o "$work/new/$names"
  for farm in dask slurm; do
    for workers in 1 2; do compared "$what, $farm, workers: $workers" $farm $workers; done
  done
}
run_all poses 200 25 '%06d.obj' "$programs/clone_figure" "$work/character.figure" --poses "$work/poses.csv" \
  --mesh "$work/character.obj"
for farm in dask slurm; do compared "poses, $farm, each task twice" $farm 2 "$work/tries_again"; done
run_all tiles 16 2 '*.figure' "$programs/bind_tiles" "$work/character_cage.obj" --points "$work/tiles/*.ply" \
  --largest 8 --format int16
report "all files are equal to those of one process"

# ---- only parsed, because there is no Cuebot and no cluster ----
$python -c 'import ast, sys; ast.parse(open(sys.argv[1]).read())' "$farms/opencue.py"
$python -c 'import sys, yaml; assert yaml.safe_load(open(sys.argv[1]))["kind"] == "Job"' "$farms/kubernetes.yaml"
report "opencue.py and kubernetes.yaml are parsed only"
