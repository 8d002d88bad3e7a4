"""The command ``tmm``."""

import click

from skyshine.schemas.commands import CommandGroup

COMMANDS = {
    "init": "Write a starter job that runs as it is.",
    "check": "Check a job, or a map against ground truth.",
    "suggest": "Select patches to label (active learning).",
    "classify": "Map the texels of a job's textures to materials.",
    "train": "Train a classifier for a library of textures.",
    "preview": "Show or draw a texture database: materials, confidence, shade.",
    "export": "Write PNG, GeoTIFF, glTF, DIRSIG or OGC CDB; read an OGC CDB.",
}

main = CommandGroup(
    "tmm",
    package="skyshine.tmm.commands",
    commands=COMMANDS,
    moved={
        "build": "classify JOB",
        "import": "export FILE --to tmm",
        "info": "preview FILE",
        "score": "check DATABASE --truth LABELS",
        "usage": "preview FILES",
    },
    help="Maps the texels of textures to materials, with confidence and exact mip levels.\n\n"
    "Training labels can come from three sources, alone or together, under 'seeds' of a texture in the job: answers "
    "to 'tmm suggest' ('suggested'), a label image ('labels'), or polygons in pixels ('polygons') or in map "
    "coordinates as GeoJSON ('file').\n\n"
    "Example: tmm classify demo/job.tmm.yaml && tmm preview build/yellowstone_road.tmm.h5 --out materials.png",
)
click.version_option(package_name="skyshine", prog_name="tmm")(main)
