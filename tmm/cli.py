"""The command ``tmm``."""

import click

from skyshine.schemas.commands import CommandGroup

COMMANDS = {
    "init": "Write a starter job that runs as it is.",
    "check": "Check a job: images, seeds, materials.",
    "suggest": "Select patches to label (active learning).",
    "classify": "Map the texels of a job's textures to materials.",
    "train": "Train a classifier for a library of textures.",
    "score": "Compare a texture database with a label image.",
    "info": "Show the content of a texture database.",
    "usage": "Share of each material in one texture or several.",
    "import": "Take materials from an OGC CDB.",
    "export": "Write a texture's materials for others: PNG, GeoTIFF, glTF, DIRSIG, OGC CDB.",
    "preview": "Draw texture, materials, confidence and shade side by side.",
}

main = CommandGroup(
    "tmm",
    package="skyshine.tmm.commands",
    commands=COMMANDS,
    help="Maps the texels of textures to materials, with confidence and exact mip levels.\n\n"
    "Training labels can come from three sources, alone or together, under 'seeds' of a texture in the job: answers "
    "to 'tmm suggest' ('suggested'), a label image ('labels'), or polygons in pixels ('polygons') or in map "
    "coordinates as GeoJSON ('file').\n\n"
    "Example: tmm classify demo.tmm.yaml && tmm preview build/yellowstone_road.tmm.h5 --out materials.png",
)
click.version_option(package_name="skyshine", prog_name="tmm")(main)
