"""What a check accepts is built: bands at the ends of the spectrum and bands narrower than a spectral interval."""

import pytest

from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.builder.build import build
from skyshine.mat.job.load import load_job
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.bands import absorption_table
from skyshine.mat.scene.check import check_scene
from skyshine.mat.tables.verify import problems


@pytest.mark.parametrize("band", [(26.0, 30.0), (50.0, 100.0), (300.0, 1000.0), (100.0, 100.01)])
def test_bands_beyond_25_um_are_built_and_hold(tmp_path, tiny_job, band):
    file = tmp_path / "job.yaml"
    text = tiny_job().replace("[10.0, 10.2]", str(list(band))).replace("sources: [sun]", "sources: [sun, moon]")
    file.write_text(text, encoding="utf-8")
    job = load_job(file)
    check_scene(job)
    build(job, jobs=1)
    built = sorted(path.name for path in (tmp_path / "built").glob("*.h5"))
    assert built == ["b01.band.h5", "s01.htt.h5", "s01b01.atmq.h5", "s01b01.lunar_atmq.h5"]
    assert [problem for path in (tmp_path / "built").glob("*.h5") for problem in problems(path)] == []


@pytest.mark.parametrize("lower", [0.31, 0.5, 1.0, 4.0, 10.0, 25.0, 50.0, 100.0, 300.0, 999.0])
@pytest.mark.parametrize("width", [0.01, 1e-4])
def test_points_of_a_narrow_band_weigh_as_much_as_the_band_is_wide(lower, width):
    response = SpectralResponse.rectangular(lower, lower + width)
    band = band_points(absorption_table().points(*response.wavenumber_range), response)
    assert band.weight.sum() == pytest.approx(width, rel=6e-3)
