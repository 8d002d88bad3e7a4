"""Stacks driven from behind: heat and temperatures from inside, steady and by hour, and temperatures given by hand."""

from dataclasses import replace

import numpy as np
import pytest
from surface_oracle import solve_oracle

from skyshine.mat.api.own_material import new_material
from skyshine.mat.bench.marching import march
from skyshine.mat.job.load import load_job
from skyshine.mat.job.surface import Operation
from skyshine.mat.scene.surface import surface_materials
from skyshine.mat.surface.back_boundary import at_hours, back_drive
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import depth_response
from skyshine.mat.surface.days import solve_days
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solution import Method
from skyshine.mat.surface.solver import solve_columns
from skyshine.mat.surface.table import temperature_table
from skyshine.materials.files import load_thermal
from skyshine.materials.library import load_library
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack
from skyshine.schemas.errors import InputError

SIGMA = 5.670374419e-8
DRY = SurfaceProperties(1e-6, 0.0, 0.0, False, False)
LAYERS = (Layer(0.02, 0.5, 2000.0, 900.0), Layer(0.003, 45.0, 7800.0, 480.0))
RESISTANCE = 0.02 / 0.5 + 0.003 / 45.0  # m2 K / W


def material(back, emissivity=0.9, layers=LAYERS):
    return SurfaceMaterial("hood", ThermalStack(Layer(1e-4, 1.0, 1500.0, 1000.0), layers, back), DRY, 0.7, emissivity)


def night(steps, pressure=0.0, sky=200.0):
    def row(value):
        return np.full((1, steps), float(value))

    return Forcing(
        row(0), row(0), row(0), row(sky), row(0), row(280), row(800), row(pressure), row(2), np.array([[1.0]])
    )


def solve(chosen, forcing=night, **options):
    ((_, solution),) = (part for part in solve_columns(chosen, forcing, **options) if len(part[0]))
    return solution


def test_steady_heat_from_inside_leaves_through_the_surface():
    """eps sigma T^4 = q + eps L without air: 500 + 0.9 x 200 W/m2 make 339.75 K; the inner face is q R warmer."""
    solution = solve(material(Back("heated", heat_flux=500.0)))
    exact = ((500 + 180) / (0.9 * SIGMA)) ** 0.25
    assert solution.temperature == pytest.approx(exact, abs=1e-3)
    assert solution.bound_excess[0] == pytest.approx(0, abs=1e-3) and abs(solution.energy_closure[0]) < 1e-3
    stack = material(Back("heated", heat_flux=500.0)).thermal
    surface, inside = depth_response(stack, [0.0], 0.023)
    assert (surface[0], inside[0]) == (pytest.approx(1.0), pytest.approx(RESISTANCE))


def test_steady_interior_through_layers():
    """A body that does not radiate: h_in (T_in - T_b) = (T_b - T_s) / R = h (T_s - T_air), with h of still vacuum 0."""
    solution = solve(material(Back("convective", 350.0, 25.0)))
    surface = solution.temperature[0, 0]
    through = (350.0 - surface) / (1 / 25.0 + RESISTANCE)
    assert 0.9 * SIGMA * surface**4 - 180.0 == pytest.approx(through, abs=2e-3)


def test_heat_wave_through_a_thin_plate():
    """A plate that stores as one capacity: C dT/dt + 4 eps sigma T0^3 dT = q1 cos(omega t), to first order in q1."""
    plate = (Layer(0.002, 45.0, 7800.0, 480.0), Layer(0.003, 45.0, 7800.0, 480.0))
    hours = np.arange(24.0)
    heat = tuple(float(value) for value in 400 + 0.5 * np.cos(2 * np.pi * hours / 24))
    chosen = material(Back("heated", heat_flux=heat), layers=plate)
    solution = solve(chosen, scheme="spectral", steps=192)
    wave = np.fft.rfft(solution.temperature[0])[1] / 96
    mean = ((np.mean(heat) + 180) / (0.9 * SIGMA)) ** 0.25
    capacity = 0.005 * 7800 * 480 + 1e-4 * 1500 * 1000
    # Linear interpolation between 24 points keeps sinc^2(1/24) of a daily wave.
    amplitude = 0.5 * np.sinc(1 / 24) ** 2
    exact = amplitude / (4 * 0.9 * SIGMA * mean**3 + 1j * 2 * np.pi / 86400 * capacity)
    assert wave == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("kind", ["fixed", "convective", "heated"])
def test_hourly_backs_agree_with_the_oracle(kind):
    pytest.importorskip("casadi")
    hours = np.arange(24.0)
    interior = tuple(float(value) for value in 320 + 40 * np.sin(2 * np.pi * hours / 24))
    heat = tuple(float(value) for value in 300 + 250 * np.sin(2 * np.pi * (hours - 3) / 24))
    back = (
        Back(kind, heat_flux=heat) if kind == "heated" else Back(kind, interior, 20.0 if kind == "convective" else None)
    )
    chosen = material(back)
    oracle = solve_oracle(chosen, lambda s: night(len(s), 1e5), intervals=48, cells=10)
    solution = solve(chosen, lambda n: night(n, 1e5), steps=192, fine_steps=None)
    assert np.abs(np.roll(solution.temperature[0], -1)[3::4] - oracle.surface).max() < 0.05


CAVITY = Back("cavity", coefficient=8.0, exchange=3.0, capacity=2e4)


def windy(steps):
    return windy_at(24.0 * np.arange(steps) / steps)


def windy_at(hours, wave=6.0):
    """A clear day in windy air of 285 K and its daily wave."""
    steps = len(hours)
    sun = 700 * np.maximum(np.sin(np.pi * (hours - 6) / 12), 0.0)
    air = 285.0 + wave * np.sin(2 * np.pi * (hours - 9) / 24)
    level = np.full((1, steps), 1.0)
    return Forcing(
        *(sun * level, 50 * level, 0 * level, 300 * level, 0 * level, air * level, 900 * level, 1e5 * level),
        *(3 * level, np.array([[1.0]])),
    )


def test_a_cavity_at_rest_is_two_conductances_in_line():
    """h and G in line with the layers lead to the air: with heat Q inside it is as if that were Q / G warmer."""
    for heat in (None, 90.0):
        solution = solve(material(replace(CAVITY, heat_flux=heat)))
        surface = solution.temperature[0, 0]
        through = (280.0 + (heat or 0.0) / 3.0 - surface) / (1 / 8.0 + 1 / 3.0 + RESISTANCE)
        assert 0.9 * SIGMA * surface**4 - 180.0 == pytest.approx(through, abs=2e-3)


@pytest.mark.validation  # 3 s each; by day `test_days_before_reach_a_cavity` marches through one
@pytest.mark.parametrize("back", [replace(CAVITY, capacity=3e5), CAVITY, Back("open", coefficient=8.0)])
def test_cavities_agree_with_a_march_in_finite_volumes(back):
    chosen = material(back)
    marched = march(chosen, windy(1152), 1152, 30, 10, 1.0)[:, ::6]
    assert solve(chosen, windy, steps=192, fine_steps=None).temperature == pytest.approx(marched, abs=0.12)


@pytest.mark.parametrize("capacity", [0.0, 2e4, 3e5])
def test_cavities_agree_with_the_oracle(capacity):
    pytest.importorskip("casadi")
    chosen = material(replace(CAVITY, capacity=capacity, heat_flux=60.0))

    def at(seconds):
        return windy_at(seconds / 3600)

    oracle = solve_oracle(chosen, at, intervals=48, cells=10)
    solution = solve(chosen, windy, steps=192, fine_steps=None)
    assert np.abs(np.roll(solution.temperature[0], -1)[3::4] - oracle.surface).max() < 0.1


def test_a_closed_cavity_comes_between_no_back_and_the_outdoor_air():
    """Nothing behind, a cavity that hardly breathes, one that breathes more, the outdoor air: colder and colder by
    day."""
    backs = [
        Back("adiabatic"),
        replace(CAVITY, exchange=1e-3, capacity=0.0),
        replace(CAVITY, capacity=0.0),
        replace(CAVITY, exchange=1e5, capacity=0.0),
        Back("open", coefficient=8.0),
    ]
    noon = [solve(material(back), windy).temperature.max() for back in backs]
    assert noon[0] == pytest.approx(noon[1], abs=0.02) and noon[3] == pytest.approx(noon[4], abs=0.02)
    assert noon[1] > noon[2] + 1.0 > noon[3] + 2.0


def test_the_back_wave_of_a_cavity_at_depth():
    """Its bottom, at rest, lies on the line from the surface to the air behind."""
    surface, behind = depth_response(material(CAVITY).thermal, [0.0], 0.023)
    beyond = 1 / (1 / 8.0 + 1 / 3.0)
    assert surface[0] == pytest.approx(1 / (1 + beyond * RESISTANCE))
    assert behind[0] == pytest.approx(beyond * RESISTANCE / (1 + beyond * RESISTANCE))


def test_days_before_reach_a_cavity():
    """Yesterday's cold air is in the walls of a heavy cavity."""
    chosen = material(replace(CAVITY, capacity=5e5))

    def colder(steps):
        return replace(windy(steps), air_temperature=windy(steps).air_temperature - 12.0)

    ((_, after),) = solve_days(chosen, [colder, colder, windy])
    ((_, same),) = solve_days(chosen, [windy, windy, windy])
    ((_, alone),) = solve_columns(chosen, windy, steps=192, scheme="bdf2")
    assert same.temperature == pytest.approx(alone.temperature, abs=2e-3)
    assert (alone.temperature - after.temperature).mean() > 0.3
    marched = _march_of_days(chosen, [colder] * 20 + [windy])
    assert np.quantile(np.abs(after.temperature - marched), 0.95) < 0.06


def _march_of_days(chosen, days, steps=576):
    """The march's one day is all of them, of capacities so much less."""
    parts = [day(steps) for day in days]
    whole = Forcing(
        **{
            name: np.concatenate([np.broadcast_to(getattr(part, name), (1, steps)) for part in parts], axis=1)
            for name in parts[0].given
        }
    )
    share = 1 / len(days)
    thermal = chosen.thermal
    layers = tuple(replace(layer, heat_capacity=layer.heat_capacity * share) for layer in thermal.layers)
    skin = replace(thermal.skin, heat_capacity=thermal.skin.heat_capacity * share)
    back = replace(thermal.back, capacity=thermal.back.capacity * share)
    slower = replace(chosen, thermal=replace(thermal, skin=skin, layers=layers, back=back))
    return march(slower, whole, steps * len(days), 1, 10, 1.0)[:, -steps::3]


def test_interiors_of_the_library_are_rooms_or_float():
    """No material rests on the day's mean air but the ground, whose deep temperature it is."""
    library = load_library()
    backs = {name: library[name].thermal.back for name in library.names}
    assert {back.kind for back in backs.values() if back.temperature is None} == {
        "fixed",
        "open",
        "cavity",
        "adiabatic",
    }
    assert all(back.temperature == 293.15 for back in backs.values() if back.kind == "convective")
    assert {name for name, back in backs.items() if back.kind == "open"} == {
        "camouflage_net_desert",
        "camouflage_net_green",
        "camouflage_net_low_emissivity",
        "camouflage_net_winter",
        "concrete_bridge",
        "pv_module",
    }


def test_what_a_cavity_lacks_is_said():
    with pytest.raises(InputError, match="found a cavity back without exchange"):
        solve(material(Back("cavity", coefficient=8.0, capacity=0.0)))


def test_a_period_may_begin_at_any_hour():
    interior = tuple(float(value) for value in 320 + 40 * np.sin(2 * np.pi * np.arange(24.0) / 24))
    usual = solve(material(Back("fixed", interior)), fine_steps=None).temperature
    later = solve(material(Back("fixed", interior)), fine_steps=None, start_hour=6.0).temperature
    assert np.allclose(np.roll(usual, -usual.shape[1] // 4, axis=1), later, atol=2e-4)


def test_given_temperatures_stand_in_the_table(sun_path, weather, sky):
    by_hand = tuple(300.0 + hour for hour in range(24))
    chosen = [material(Back("fixed")), replace(material(Back("fixed")), name="engine")]
    table = temperature_table(
        chosen, sun_path, weather, sky, [0.0], [0.0, 90.0], [0.0, 90.0], [3.0, 3.5], prescribed={"engine": by_hand}
    )
    assert np.all(table.temperature[1] == np.array([303.0, 303.5], np.float32))
    assert np.all(table.method[1] == Method.GIVEN) and not np.any(table.method[0] == Method.GIVEN)


def test_hours_are_periodic():
    assert at_hours(range(24), np.array([23.5, 24.0, 25.0])) == pytest.approx([11.5, 0.0, 1.0])


JOB = """\
skyshine: 1
name: operated
site: {latitude_deg: 39.7, longitude_deg: -105.2, date: 2026-06-22, utc_offset_h: -7}
states: [{profile: midlatitude_summer, weather: {air_temperature_c: 20}}]
bands: [{wavelength_um: [8, 12]}]
materials: [asphalt_road, concrete]
operated:
  concrete: {kind: heated, heat_flux_w_m2: 120}
"""


def test_a_job_operates_a_material(tmp_path):
    (tmp_path / "job.yaml").write_text(JOB, encoding="utf-8")
    job = load_job(tmp_path / "job.yaml").trimmed
    library = load_library()
    road, concrete = surface_materials([library["asphalt_road"], library["concrete"]], job.operated)
    assert concrete.thermal.back == Back("heated", heat_flux=120.0) and road.thermal == library["asphalt_road"].thermal


def test_a_job_operates_a_material_by_a_name_of_its_own(tmp_path, monkeypatch):
    text = JOB.replace("[asphalt_road, concrete]", "[engine_deck]").replace(
        "concrete: {kind: heated, heat_flux_w_m2: 120}", "%s"
    )
    for operation in ("engine_deck: idling", "engine_deck: driving"):
        (tmp_path / "job.yaml").write_text(text % operation, encoding="utf-8")
        back = load_job(tmp_path / "job.yaml").trimmed.operated["engine_deck"].back
        assert back == load_library()["engine_deck"].operated[operation.split()[1]], operation
    for operation, message in (
        ("engine_deck: flying", r"job.yaml:8:.*operated.engine_deck: found 'flying'; .*allowed: idling, driving$"),
        ("engine_deck: drivin", r"job.yaml:8:.*found 'drivin'; did you mean 'driving'"),
        ("concrete: idling", r"job.yaml:8:.*found 'idling'; allowed: a mapping with kind, for concrete has none"),
        ("engine_desk: idling", r"job.yaml:8:.*unknown material 'engine_desk'"),
    ):
        (tmp_path / "job.yaml").write_text(text % operation, encoding="utf-8")
        with pytest.raises(InputError, match=message):
            load_job(tmp_path / "job.yaml")
    new_material("hood", like="engine_deck", folder=tmp_path / "own")
    monkeypatch.setenv("MATERIALS_DATABASE", str(tmp_path / "own"))
    (tmp_path / "job.yaml").write_text(text.replace("engine_deck", "hood") % "hood: idling", encoding="utf-8")
    assert load_job(tmp_path / "job.yaml").trimmed.operated["hood"].back == load_library()["hood"].operated["idling"]


def test_operations_by_hour_keep_their_hours():
    """From a file of materials to the keys of a job and back."""
    hours = tuple(300.0 + hour for hour in range(24))
    for back in (
        Back("convective", hours, 12.5),
        Back("cavity", None, 7.7, tuple(range(24)), 12.0, 1e4),
        Back("heated", heat_flux=120.0),
    ):
        assert Operation.model_validate(Operation.of_back(back)).back == back


def test_a_job_encloses_air_behind_a_material(tmp_path):
    cavity = "{kind: cavity, coefficient_w_m2_k: 7.7, exchange_w_m2_k: 12, capacity_j_m2_k: 1e4, heat_flux_w_m2: 200}"
    (tmp_path / "job.yaml").write_text(JOB.replace("{kind: heated, heat_flux_w_m2: 120}", cavity), encoding="utf-8")
    back = load_job(tmp_path / "job.yaml").trimmed.operated["concrete"].back
    assert back == Back("cavity", None, 7.7, 200.0, 12.0, 1e4)
    wrong = cavity.replace("exchange_w_m2_k: 12, ", "")
    (tmp_path / "job.yaml").write_text(JOB.replace("{kind: heated, heat_flux_w_m2: 120}", wrong), encoding="utf-8")
    with pytest.raises(InputError, match=r"job.yaml:8:.*a back of kind 'cavity' needs a 'exchange_w_m2_k'; add it"):
        load_job(tmp_path / "job.yaml")


def test_a_material_file_carries_its_back_by_hour(tmp_path):
    from skyshine.materials import files

    text = (files.Path(files.__file__).parent / "ht" / "concrete.yaml").read_text(encoding="utf-8")
    before, _, after = text.partition("back:")
    surface = after[after.index("surface:") :]
    hours = ", ".join(str(100 + hour) for hour in range(24))
    file = tmp_path / "hood.yaml"
    file.write_text(
        f"{before}back:\n  kind: {{value: heated, source: test}}\n  heat_flux: {{value: [{hours}], source:"
        f" test}}\n{surface}",
        encoding="utf-8",
    )
    stack, *_ = load_thermal(file)
    assert stack.back.heat_flux == tuple(100.0 + hour for hour in range(24))
    file.write_text(f"{before}back:\n  kind: {{value: heated, source: test}}\n{surface}", encoding="utf-8")
    with pytest.raises(InputError, match="hood.yaml:.*back: a back of kind 'heated' needs a 'heat_flux'"):
        load_thermal(file)


def a_record(days, air):
    """Hourly forcing of a record under an air temperature (N,) [K]."""
    none = np.zeros((1, 1))
    return Forcing(none, none, none, none, none, air[None], none, none + 1e5, none + 2, none + 1), np.arange(
        24.0 * days
    )


def test_a_year_does_not_rest_on_the_year_s_mean():
    """A monthly mean of a yearly wave of 10 K keeps sin(x) / x of it, x = 30 pi / 365: 9.89 K, and no wave of days."""
    hours = np.arange(24.0 * 365)
    air = 283.0 + 10 * np.cos(2 * np.pi * hours / hours.size) + 6 * np.cos(2 * np.pi * hours / 24)
    forcing, clock = a_record(365, air)
    drive = back_drive(material(Back("fixed")), forcing, clock)
    assert drive.shape == (1, hours.size)
    expected = 283.0 + 9.89 * np.cos(2 * np.pi * hours / hours.size)
    assert np.abs(drive[0] - expected).max() < 0.03


def test_some_weeks_rest_on_their_mean():
    air = 283.0 + np.linspace(-5.0, 5.0, 24 * 30)
    assert back_drive(material(Back("fixed")), *a_record(30, air)) == pytest.approx(np.full((1, 1), 283.0))
