"""What `skyshine.tmm` shows: every name loads, says what it does, and the examples run."""

import doctest
import inspect

import skyshine.tmm


def test_public_names_load_and_have_a_docstring():
    assert dir(skyshine.tmm) == sorted(skyshine.tmm.__all__)
    for name in skyshine.tmm.__all__:
        assert inspect.getdoc(getattr(skyshine.tmm, name)), name


def test_examples_of_the_package_run():
    results = doctest.testmod(skyshine.tmm)
    assert results.attempted >= 3 and not results.failed


def test_the_demo_is_mapped_by_the_public_functions(demo_folder, tmp_path):
    from skyshine.materials.library import load_library

    library = load_library()
    job = skyshine.tmm.TextureJob(image="yellowstone_road.png", material="asphalt_road")
    written = skyshine.tmm.write_texture(skyshine.tmm.map_texture(job, demo_folder, library), tmp_path / "a.tmm.h5")
    with skyshine.tmm.open_tmm(tmp_path / "a.tmm.h5") as file:
        assert file.materials == {library["asphalt_road"].code: "asphalt_road"}
        assert file.usage["asphalt_road"] == written.usage[0] == 1
