"""Maps a program over rows on the workers of a Dask cluster.

Usage: python3 dask_map.py SCHEDULER COUNT ROWS PROGRAM ARGUMENT…

Each task processes ROWS of COUNT rows. SCHEDULER is an address such as tcp://host:8786, or a number of workers
to start on this host. A task with exit status 75 (for instance a full disk) is repeated, at most three times.
"""
import subprocess
import sys

from dask.distributed import Client, LocalCluster


def run(first, rows, command):
    code = subprocess.run([*command, "--rows", f"{first}:{first + rows}"], check=False).returncode
    if code == 75:
        raise RuntimeError(f"rows from {first}: try again")
    return code


if __name__ == "__main__":
    place, count, rows, command = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4:]
    if place.isdigit():
        place = LocalCluster(n_workers=int(place), threads_per_worker=1, dashboard_address=None)
    with Client(place) as client:
        tasks = client.map(run, range(0, count, rows), rows=rows, command=command, retries=3, pure=False)
        sys.exit(max(client.gather(tasks)))
