"""Derives `materials/colours.csv`: the fixed colour of each packaged material, from its spectrum.

Run ``python -m mat.maintain.materials.colours`` after materials are added; those before them in the order of
codes keep their colours.
"""

from __future__ import annotations

import os

import numpy as np

from skyshine import materials
from skyshine.materials.colours import FILE, natural_colour, spread_colours
from skyshine.materials.library import ENVIRONMENT, load_library
from skyshine.schemas.whole_files import write_whole

APART = 9.0  # CIELAB units between any two materials: about four just noticeable differences
HEAD = """\
# Colours that pictures of materials show, sRGB: that of the reflectance spectrum (ref/NAME.csv) in daylight, made
# clearer and moved until no two are nearer than {apart:g} in CIELAB; derived by mat.maintain.materials.colours
material,red,green,blue
"""


def derive() -> str:
    """The text of the file."""
    os.environ.pop(ENVIRONMENT, None)  # a user's own materials have colours of their own
    library = load_library()
    natural = np.stack([natural_colour(material.wavelength, material.reflectance) for material in library])
    rows = zip(library.names, spread_colours(natural, APART).tolist(), strict=True)
    return HEAD.format(apart=APART) + "".join(f"{name},{','.join(map(str, colour))}\n" for name, colour in rows)


if __name__ == "__main__":
    write_whole(materials.path() / FILE, derive().encode())
