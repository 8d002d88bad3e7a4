"""The command ``mat``."""

import click

from skyshine.schemas.commands import CommandGroup

COMMANDS = {
    "init": "Write a starter job that runs as it is.",
    "check": "Check a job; print what will be built, left out, and what a scene needs.",
    "build": "Build the databases of a job.",
    "info": "Show what a database holds.",
    "verify": "Check layout, values, physical laws and digest of databases.",
    "query": "Interpolate one value, with its stated error.",
    "plot": "Draw a database.",
    "render": "Draw a scene from built databases, by hour and band.",
    "contrast": "One material against another through the day, with crossovers.",
    "export": "Write databases for other programs: GPU textures, flat arrays, Gazebo.",
    "view": "Write a page that shows built databases in the infrared.",
    "spectrum": "Transmittance and radiance of one line of sight.",
    "temperature": "One surface through the day: temperature and every flux.",
    "materials": "List, show or plot the materials.",
    "presets": "List or show the ready atmospheric states.",
    "lines": "The band model: build it from line lists, show what it holds.",
    "report": "The error budget of built databases, source by source.",
    "bench": "Error against run time, measured.",
    "doctor": "What this installation has and lacks.",
}

main = CommandGroup(
    "mat",
    package="skyshine.mat.commands",
    commands=COMMANDS,
    moved={
        "gazebo": "export FOLDER --to gazebo",
        "lut": "export --to lut",
        "needs": "check JOB --scene SCENE",
        "openmaterial": "export --to openmaterial",
        "specular": "materials specular",
    },
    help="Builds the atmospheric and temperature databases of an infrared scene from one YAML job.\n\n"
    "Example: mat init demo && mat build demo/job.yaml",
)
click.version_option(package_name="skyshine", prog_name="mat")(main)
