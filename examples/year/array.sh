#!/bin/bash
#SBATCH --array=1-12
#SBATCH --cpus-per-task=1
#SBATCH --mem=4G
#SBATCH --time=04:00:00
# A year of days as a job array: each task builds its share of the rows of every_day.csv in a folder of its own.
# Neighbouring days stay together, for their air shares spectral points. PARTS is the number of shares where only some
# tasks of an array are sent again.
set -euo pipefail
here=${SLURM_SUBMIT_DIR:+$SLURM_SUBMIT_DIR/year}
here=${here:-$(cd "$(dirname "$0")" && pwd)}
part=$SLURM_ARRAY_TASK_ID parts=${PARTS:-$SLURM_ARRAY_TASK_COUNT}
out=$(printf '%s/built/part_%02d' "$PWD" "$part")
mkdir -p "$out"
grep -v '^#' "$here/every_day.csv" | awk -v part="$part" -v parts="$parts" '
  NR == 1 { print; next }
  { row[++count] = $0 }
  END { for (k = int((part - 1) * count / parts) + 1; k <= int(part * count / parts); k++) print row[k] }
' > "$out/every_day.csv"
cp "$here/every_day.yaml" "$out/job.yaml"
exec "${MAT:-mat}" build "$out/job.yaml" --out "$out" --jobs "${SLURM_CPUS_PER_TASK:-1}" --verbose
