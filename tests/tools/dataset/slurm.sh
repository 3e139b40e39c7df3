#!/bin/bash
# Renders a small data set by a Slurm array on this machine alone: starts munged, slurmctld and slurmd, submits
# tools/render_dataset.sbatch, kills one task with SIGKILL, requeues it, and expects every sample, whole.
# As root, with Debian's slurmctld, slurmd, slurm-client and munge:
#   tests/tools/dataset/slurm.sh build/release/tools/dualpixel build/release/scenes
set -euo pipefail
program=$(realpath "$1")
scenes=$(realpath "$2")
repository=$(realpath "$(dirname "$0")/../../..")
for needed in munged slurmctld slurmd sbatch; do
  command -v $needed >/dev/null || { echo "skipped: no $needed"; exit 77; }
done

work=$(mktemp -d)
cleanup() {
  for name in slurmd slurmctld munged; do
    [ -f "$work/$name.pid" ] && kill "$(cat "$work/$name.pid")" 2>/dev/null || true
  done
  sleep 1
  rm -rf "$work"
}
trap cleanup EXIT
node=$(hostname -s)
mkdir -p "$work/state" "$work/spool"
head -c 1024 /dev/urandom > "$work/munge.key"
chmod 400 "$work/munge.key"
cat > "$work/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$node
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
SlurmUser=root
SlurmctldPort=26817
SlurmdPort=26818
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MailProg=/bin/true
NodeName=$node NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES State=UP
CONF
export SLURM_CONF=$work/slurm.conf
munged --force --key-file="$work/munge.key" --socket="$work/munge.socket" --pid-file="$work/munged.pid" \
  --log-file="$work/munged.log" --seed-file="$work/munged.seed"
slurmctld
slurmd
for _ in $(seq 60); do sinfo -h -o %t 2>/dev/null | grep -q idle && break; sleep 1; done
sinfo

cat > "$work/recipe.json" <<RECIPE
{"version": 1, "count": 40, "layout": "npy", "keep": ["left", "right", "view_disparity_dp_px"],
 "scenes": [{"file": "$scenes/slanted_planes.json"}, {"file": "$scenes/occlusion_edges.json"}],
 "set": {"sensor.width_px": 64, "sensor.height_px": 48, "sensor.pixel_pitch_um": 58.8, "burst.frames": 1,
         "render.samples_per_pixel": 64, "render.light_spacing_px": 0},
 "relations": {"focus": "surface"}}
RECIPE
"$program" dataset plan "$work/recipe.json" -o "$work/set"
job=$(cd "$work" && DUALPIXEL=$program sbatch --parsable --array=0-7 --cpus-per-task=1 "$repository/tools/render_dataset.sbatch" "$work/set")
echo "job $job"
victim=
for _ in $(seq 600); do
  victim=$(pgrep -f "^$program dataset render $work/set" | head -n 1) && [ -n "$victim" ] && break
  sleep 0.1
done
task=$(tr '\0' '\n' < "/proc/$victim/environ" | sed -n 's/^SLURM_ARRAY_TASK_ID=//p')
kill -9 "$victim"
echo "killed task $task"
for _ in $(seq 60); do scontrol requeue "${job}_$task" 2>/dev/null && break; sleep 1; done
for _ in $(seq 600); do [ -z "$(squeue -h)" ] && break; sleep 1; done
"$program" dataset status "$work/set"
"$program" dataset verify "$work/set"
"$program" dataset status --json "$work/set" | tr -d ' \n' | grep -q '"all":{"planned":40,"rendered":40,'
echo "40 of 40"
