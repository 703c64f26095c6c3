#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs scenarios as a Slurm job array: each task runs its shard of the files, like a pod of
# deploy/kubernetes/tests.
#
#   sbatch --array=1-7 deploy/slurm/tests.sh 7 TESTS BENCH.yaml REPORTS
#
# TESTS, BENCH.yaml and the folder REPORTS must be on a file system shared by the nodes, and the
# package vdrive installed on them. Afterwards: vdrive test --merge REPORTS --junit result.xml
# --array=2,5 repeats shards 2 and 5 of the 7.
#SBATCH --job-name=vdrive-tests
#SBATCH --cpus-per-task=2
#SBATCH --mem=512M
#SBATCH --requeue
#SBATCH --open-mode=append
set -euo pipefail

if (($# != 4)) || [[ ! -d $4 ]]; then
  echo "usage: sbatch --array=1-N tests.sh N TESTS BENCH.yaml REPORTS; REPORTS is a folder" >&2
  exit 2
fi

code=0
vdrive test "$2" --config "$3" --shard "$SLURM_ARRAY_TASK_ID/$1" --jobs "$SLURM_CPUS_PER_TASK" \
  --junit "$4/$SLURM_ARRAY_TASK_ID.xml" || code=$?
# Exit code 6: the tests were not run. Failed tests are not repeated.
if ((code == 6 && ${SLURM_RESTART_COUNT:-0} < 2)); then
  scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
fi
exit "$code"
