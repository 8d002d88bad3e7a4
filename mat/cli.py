"""The command ``mat``."""

import click

from skyshine.schemas.commands import CommandGroup

COMMANDS = {
    "init": "Write a starter job that runs as it is.",
    "check": "Check a job and print what will be built and what is left out.",
    "build": "Build the databases of a job.",
    "info": "Show what a database holds.",
    "verify": "Check layout, values, physical laws and digest of databases.",
    "query": "Interpolate one value, with its stated error.",
    "plot": "Draw a database.",
    "render": "Draw a scene from built databases, by hour and band.",
    "contrast": "One material against another through the day, with crossovers.",
    "export": "Write databases for engines without HDF5.",
    "gazebo": "Write heat signatures for the thermal camera of Gazebo.",
    "view": "Write a page that shows built databases in the infrared.",
    "spectrum": "Transmittance and radiance of one line of sight.",
    "temperature": "One surface through the day: temperature and every flux.",
    "lut": "Write a look-up table for ISOFIT.",
    "specular": "Shininess and normalisation of a specular lobe.",
    "materials": "List, show or plot the materials.",
    "presets": "List or show the ready atmospheric states.",
    "lines": "The band model: build it from line lists, show what it holds.",
    "needs": "Cast the rays of a scene and print what it reads, as the needs of its job.",
    "report": "The error budget of built databases, source by source.",
    "bench": "Error against run time, measured.",
    "doctor": "What this installation has and lacks.",
}

main = CommandGroup(
    "mat",
    package="skyshine.mat.commands",
    commands=COMMANDS,
    help="Builds the atmospheric and temperature databases of an infrared scene from one YAML job.\n\n"
    "Example: mat init demo && mat build demo/job.yaml",
)
click.version_option(package_name="skyshine", prog_name="mat")(main)
