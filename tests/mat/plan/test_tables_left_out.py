"""What a job leaves out is named with the key that brings it back."""

from skyshine.mat.job.load import load_job
from skyshine.mat.plan.left_out import tables_left_out, temperature_times
from skyshine.materials.library import load_library


def load(folder, text):
    (folder / "job.yaml").write_text(text, encoding="utf-8")
    return load_job(folder / "job.yaml")


def left_out(loaded):
    return {item.what: item for item in tables_left_out(loaded, load_library(), ("asphalt_road",))}


def test_tables_of_a_source_that_is_not_asked_for_are_named_with_their_key(tmp_path, tiny_job):
    found = left_out(load(tmp_path, tiny_job()))
    assert found["lunar_atmq tables"].restore == "sources: [moon]" and "atmq tables" not in found
    both = left_out(load(tmp_path, tiny_job().replace("sources: [sun]", "sources: [sun, moon]")))
    assert "lunar_atmq tables" not in both


def test_copies_of_level_surfaces_are_counted(tmp_path, tiny_job):
    """One level slope of two, two azimuths: one of four orientations is a copy."""
    assert "1 of 4 orientations" in left_out(load(tmp_path, tiny_job()))
    tilted = tiny_job().replace("slope_deg: [0, 45]", "slope_deg: [30, 45]")
    assert not any("orientations" in what for what in left_out(load(tmp_path, tilted)))


def test_ranges_beyond_those_needed_are_left_out(tmp_path, tiny_job):
    text = tiny_job().replace("range_km: [0.001, 5]", "range_km: [0.001, 5, 10, 20]")
    found = left_out(load(tmp_path, text + "needs: {range_km: [0.1, 4]}\n"))
    assert found["2 of 4 ranges"].restore == "a wider needs.range_km, or none"
    assert not any("ranges" in what for what in left_out(load(tmp_path, text)))


def test_times_are_those_of_the_job_unless_hours_are_needed(tmp_path, tiny_job):
    job = load(tmp_path, tiny_job()).trimmed
    assert temperature_times(job) == list(job.surface_grid.time)


def test_needed_hours_leave_the_times_around_them(tmp_path, tiny_job):
    """Hours past midnight count on from 24; the times around them bound the interpolation."""
    text = tiny_job().replace("[00:00, 12:00]", "[0:00, 3:00, 6:00, 9:00, 12:00, 15:00, 18:00, 21:00]")
    evening = load(tmp_path, text + "needs: {hours: [22:00, 02:00]}\n")
    assert temperature_times(evening.trimmed) == [21.0, 24.0, 27.0]
    assert left_out(evening)["5 of 8 times of day"].restore == "a wider needs.hours, or none"
    noon = load(tmp_path, text + "needs: {hours: [12:00, 13:00]}\n")
    assert temperature_times(noon.trimmed) == [12.0, 15.0]
