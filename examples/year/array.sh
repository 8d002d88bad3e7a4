#!/bin/bash
#SBATCH --array=1-12
#SBATCH --cpus-per-task=1
#SBATCH --mem=4G
#SBATCH --time=04:00:00
# A year of days as a job array: each task builds one of the disjoint parts of the job into one folder; the part that
# ends last writes the catalogue. PARTS is the number of parts where only some tasks of an array are sent again.
set -euo pipefail
here=${SLURM_SUBMIT_DIR:+$SLURM_SUBMIT_DIR/year}
here=${here:-$(cd "$(dirname "$0")" && pwd)}
exec "${MAT:-mat}" build "$here/every_day.yaml" --out "$PWD/built" --verbose \
  --part "$SLURM_ARRAY_TASK_ID/${PARTS:-$SLURM_ARRAY_TASK_COUNT}" --jobs "${SLURM_CPUS_PER_TASK:-1}"
