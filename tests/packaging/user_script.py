"""A user's script, whose types `.ci/run` checks as a user would: against the installed package alone."""

from pathlib import Path

import numpy as np

import skyshine
import skyshine.mat
from skyshine.tmm import open_tmm


def hottest(folder: Path) -> float:
    """Highest temperature of the road, and what else the calls give."""
    plan = skyshine.mat.check(folder / "job.yaml")
    names: list[str] = plan.files
    surface = skyshine.mat.open(folder / "built" / "s01.htt.h5")
    air = skyshine.mat.open(folder / "built" / "s01b02.atmq.h5")
    band = skyshine.mat.open(folder / "built" / "b02.band.h5")
    assert isinstance(surface, skyshine.mat.TemperatureTable)
    assert isinstance(air, skyshine.mat.AtmosphereTable)
    assert isinstance(band, skyshine.mat.BandTable)
    kelvin = surface.temperature(material="asphalt_road", slope=0, time=np.linspace(0, 24, 25))
    radiance = band.blackbody_radiance(kelvin) * air.transmittance(range=2.0, beta_star=30.0)
    dataset = skyshine.mat.spectrum(wavelength=(8, 12), altitude=3, elevation=-20, range=2).to_xarray()
    for entry in skyshine.mat.open_catalog(folder / "built").find("htt", date="2026-07-28"):
        print(entry.file, names, dataset.sizes, radiance.max())
    texture = open_tmm(folder / "built" / "yellowstone_road.tmm.h5")
    print(texture, skyshine.Scene(folder / "scene.yaml"))
    return float(kelvin.max())


if __name__ == "__main__":
    built = skyshine.mat.build("demo/job.yaml")
    print(built.to_xarray(), hottest(Path("demo")))
