"""Bake the takes of a jobs file on a Dask cluster.

python -m samp_blender.batch.dask --scheduler ADDRESS|local:N jobs.jsonl --report report.json
"""

import sys

if __name__ == "__main__":
    # Not at import: workers of this machine import this file, and Blender only with their first task.
    from ..samp_addon.batch.farm import dask_command

    sys.exit(dask_command.main(sys.argv[1:]))
