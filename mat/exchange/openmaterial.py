"""Materials as files of ASAM OpenMATERIAL 3D 1.1.0: a material (.xomp), its BRDF (.xompt) and their mapping (.xomm).

The layout is that of the schemas ``material_schema.json``, ``material_brdf_schema.json`` and ``mapping_schema.json`` of
the standard, with the rules of its annex A: the schema named in the second line, tables sorted by column, no URI
without its file.

A BRDF table contains the diffuse share of the reflectance, (1 - f_s) rho / pi, at the wavelengths of the spectrum;
being the same in all directions it needs only the corners of the three angles. The specular share is in
``customProperties.skyshine``, for a table that resolved lobes of 1 to 30 degrees at hundreds of wavelengths would have
millions of rows. Height and correlation length of roughness, elasticity and refractive index are not in the library.
"""

from __future__ import annotations

import json
import uuid
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.scene.material_summary import TEMPERATURE, material_summary
from skyshine.materials.library import Material, MaterialLibrary
from skyshine.tmm.exchange.files import write_bytes, write_json

VERSION = "1.1.0"
SCHEMA = f"https://raw.githubusercontent.com/asam-ev/OpenMATERIAL-3D/refs/tags/v{VERSION}/schemas/{{}}_schema.json"
# Chosen once: a material keeps its identifier through all versions, as the standard wants.
NAMESPACE = uuid.UUID("6f5c2a52-5a8e-4b0c-9b0e-2f6d3c1a7e41")
ZENITHS, AZIMUTHS = (0.0, 1.570796), (0.0, 6.283185)  # rad; the limits of the standard
OWNER = "the skyshine authors"
LICENCE = "Apache-2.0"
WAVELENGTH_DIGITS = 12  # digits of a wavelength in m: 1e-6 um
EMISSION = (
    "Planck mean at this temperature of 1 - hemispherical reflectance at near-normal incidence, which replaces"
    " hemispherical emissivity"
)
LOBE = (
    "specular_fraction of the reflectance lies in a lobe cos^n of the angle between normal and half vector, whose full"
    " width at half maximum over directions of the observer is lobe_fwhm"
)


def write_openmaterial(library: MaterialLibrary, names: Sequence[str], folder: Path) -> list[Path]:
    """Write ``NAME.xomp`` and ``NAME_brdf.xompt`` for materials, and ``materials.xomm``, which maps names to files.

    Parameters
    ----------
    names : sequence of str
        Names of materials; empty for all.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        There is no such material, or a file cannot be written.
    """
    created, mapping = [], []
    for material in [library[name] for name in names] or list(library):
        paths = folder / f"{material.name}.xomp", folder / f"{material.name}_brdf.xompt"
        write_bytes(paths[1], _by_row(_brdf(material, library)))  # first: a URI never names what is not there
        write_json(paths[0], _material(material, library, paths[1].name))
        created += [*paths]
        mapping.append([material.name, paths[0].name, material.description])
    metadata = _metadata("skyshine materials", "Names of materials of skyshine.", "mapping", library, ())
    metadata["mappingVersion"] = metadata.pop("materialVersion")
    path = folder / "materials.xomm"
    write_json(path, {"$schema": SCHEMA.format("mapping"), "metadata": metadata, "materialMapping": mapping})
    return [*created, path]


def _material(material: Material, library: MaterialLibrary, brdf: str) -> dict[str, Any]:
    summary, skin = material_summary(material), material.thermal.skin
    properties = {
        "code": material.code,
        "group": material.group,
        "solarAbsorptance": summary["solar_absorptance"],
        "specularFraction": material.specular_fraction,
        "lobeFwhmDegree": material.lobe_fwhm,
        "lobe": LOBE,
        "transmits": material.transmits,
        "layers": [
            {
                "thicknessMetre": layer.thickness,
                "conductivityWattPerMetreKelvin": layer.conductivity,
                "densityKilogramPerCubicMetre": layer.density,
                "heatCapacityJoulePerKilogramKelvin": layer.heat_capacity,
            }
            for layer in (skin, *material.thermal.layers)
        ],
    }
    return {
        "$schema": SCHEMA.format("material"),
        "metadata": _metadata(material.name, material.description, "material", library, _credits(material)),
        "materialProperties": {
            "emissivityData": {
                "emissivityCoefficient": summary["thermal_emissivity"],
                "temperature": TEMPERATURE,
                "sources": EMISSION,
            },
            "densityData": {"density": skin.density, "sources": material.sources["skin.density"]},
            "brdfUris": [brdf],
            "customProperties": {"skyshine": properties},
        },
    }


def _brdf(material: Material, library: MaterialLibrary) -> dict[str, Any]:
    diffuse = material.reflectance * (1.0 - material.specular_fraction) / np.pi
    wavelengths = [round(1e-6 * float(value), WAVELENGTH_DIGITS) for value in material.wavelength]
    directions = list(product(ZENITHS, ZENITHS, AZIMUTHS))
    description = f"{material.description}; diffuse share of the reflectance, the same in all directions"
    return {
        "$schema": SCHEMA.format("material_brdf"),
        "metadata": {
            **_metadata(material.name, description, "brdf", library, _credits(material)),
            "sources": " ".join(material.reflectance_note.split()),
            "typicalSensorTechnology": "camera",
        },
        "brdf": {
            "wavelengths": wavelengths,
            "lookupTable": [
                [wavelength, *direction, round(float(value), 9)]
                for wavelength, value in zip(wavelengths, diffuse, strict=True)
                for direction in directions
            ],
        },
    }


def _by_row(content: dict[str, Any]) -> bytes:
    """JSON with each row of its table on a line of its own."""
    table, placeholder = content["brdf"]["lookupTable"], "rows of the table"
    rows = ",\n".join(f"      {json.dumps(row)}" for row in table)
    content["brdf"] = {"wavelengths": content["brdf"]["wavelengths"], "lookupTable": placeholder}
    text = json.dumps(content, indent=2, ensure_ascii=False)
    return (text.replace(json.dumps(placeholder), f"[\n{rows}\n    ]") + "\n").encode()


def _metadata(
    name: str, description: str, kind: str, library: MaterialLibrary, credits: Sequence[str]
) -> dict[str, Any]:
    return {
        "name": name,
        "description": description,
        "uuid": str(uuid.uuid5(NAMESPACE, f"{kind}/{name}")),
        "materialVersion": library.version.split("+")[0],
        "openMaterial3dVersion": VERSION,
        "copyrights": [OWNER, *credits],
        "license": LICENCE,
        "authors": [OWNER],
    }


def _credits(material: Material) -> list[str]:
    """Lines of a spectrum's header that state somebody's copyright."""
    return [line for line in material.reflectance_note.splitlines() if "copyright" in line.lower()]
