"""The command ``mat``."""

import click

from skyshine.schemas.commands import CommandGroup

COMMANDS = {
    "init": "Write a starter job that runs as it is.",
    "check": "Check a job: what will be built and omitted; what a scene needs.",
    "build": "Build the databases of a job.",
    "info": "Show or draw the content of a database; list presets of air.",
    "verify": "Check layout, values, physical laws and digest of databases.",
    "query": "Interpolate one value, with its stated error.",
    "render": "Draw a scene from built databases, by hour and band.",
    "contrast": "Contrast of two materials through the day, with crossovers.",
    "export": "Write for other programs: GPU textures, flat arrays, Gazebo.",
    "view": "Write a page that shows built databases in the infrared.",
    "spectrum": "Transmittance and radiance of one line of sight.",
    "temperature": "One surface through the day: temperature and every flux.",
    "materials": "List, show or draw the materials; make your own.",
    "lines": "Show the band model, or build one from line lists.",
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
        "gpu": "export FOLDER --to gpu",
        "lut": "export --to lut",
        "needs": "check JOB --scene SCENE",
        "openmaterial": "export --to openmaterial",
        "plot": "info FILE --out FILE.png",
        "presets": "info --preset",
        "specular": "materials specular",
    },
    help="Builds the atmospheric and temperature databases of an infrared scene from one YAML job.\n\n"
    "Example: mat init demo && mat build demo/job.yaml",
)
click.version_option(package_name="skyshine", prog_name="mat")(main)
