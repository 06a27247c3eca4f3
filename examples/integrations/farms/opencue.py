"""Launches an OpenCue job. Each of its frames processes ROWS of COUNT rows.

Usage: python3 opencue.py COUNT ROWS PROGRAM ARGUMENT…

Needs pyoutline of OpenCue, and CUEBOT_HOSTS with the address of a Cuebot. Cuebot repeats failed frames, so
pass --skip-existing to clone_figure: existing files are kept. Tested only for syntax.
"""
import getpass
import sys

import outline
import outline.cuerun
import outline.modules.shell

count, rows, command = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]
tasks = (count + rows - 1) // rows
script = f'first=$((#IFRAME# * {rows})); exec "$@" --rows "$first:$((first + {rows}))"'
job = outline.Outline("cageform", shot="rows", show="testing", user=getpass.getuser())
job.add_layer(
    outline.modules.shell.Shell(
        "rows", command=["sh", "-c", script, "sh", *command], chunk=1, threads=1, range=f"0-{tasks - 1}"
    )
)
outline.cuerun.launch(job, use_pycuerun=False)
