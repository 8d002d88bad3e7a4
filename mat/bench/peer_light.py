"""Light as peers compute it: spectra of lines of sight by LOWTRAN7, scattering by PythonicDISORT."""

from __future__ import annotations

import time
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.band.selection import select_points
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.layer_columns import vertical_column
from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight
from skyshine.mat.atmosphere.transfer.ordinate_light import level_light
from skyshine.mat.bench import lowtran
from skyshine.mat.bench.equal_error import EqualError, Measured, rms
from skyshine.mat.job.model import Job
from skyshine.mat.quantities.formulas import mean_transmittance
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.bands import all_points
from skyshine.schemas.arrays import Floats, Integers

_SIGHTS = 24  # random lines of sight, of which every other judges
# Ends of their height above the ground [m], elevation [degree] and range [m].
_HEIGHTS, _ELEVATIONS, _RANGES = (0.0, 10e3), (5.0, 80.0), (1e3, 40e3)
# m; with levels above, or with as many levels as it takes otherwise, its multiple scattering gives no numbers.
_PEER_TOP, _PEER_LEVELS = 60e3, lowtran.MAX_LEVELS - 1
# Spectral points of ours that are tried, out of so many candidates.
_POINTS, _CANDIDATES = (1, 2, 4, 8, 16), 400
# Settings of scattering: points of a band, of which the most transparent fourth part is compared; the Sun's elevation,
# degree.
_SCATTERING_POINTS, _SUN_DEG, _MANY_STREAMS = 32, 60.0, 24


def spectra(program: Path, job: Job, state: AtmosphericState, response: SpectralResponse) -> EqualError:
    """In-band transmittance of random lines of sight by LOWTRAN7 and by few of our points, judged by all of them.

    Parameters
    ----------
    program : Path
        LOWTRAN7, from `lowtran.built_program`.
    job : Job
    state : AtmosphericState
        Air without particles; it is given to both on as many levels as LOWTRAN7 takes.
    response : SpectralResponse

    Raises
    ------
    InputError
        LOWTRAN7 gives no spectrum of a line of sight.
    """
    highest = int(np.searchsorted(state.altitude, _PEER_TOP, side="right")) - 1
    state = thinned(state, np.unique(np.linspace(0, highest, _PEER_LEVELS).astype(int)))
    draw = np.random.default_rng(0).uniform
    altitude = state.altitude[0] + draw(*_HEIGHTS, _SIGHTS)
    elevation, distance = draw(*_ELEVATIONS, _SIGHTS), np.exp(draw(np.log(_RANGES[0]), np.log(_RANGES[1]), _SIGHTS))
    lines = zip(altitude, elevation, distance, strict=True)
    sights = [lowtran.Sight(float(height), float(angle), float(away)) for height, angle, away in lines]
    low, high = (5.0 * round(1e4 / edge / 5.0) for edge in (response.upper, response.lower))
    peer = lowtran.run(program, state, sights, low, high)
    by_wavelength = peer.wavenumber**-2.0
    of_peer = peer.transmittance @ by_wavelength / by_wavelength.sum()
    everything = all_points(response, job.water_continuum)

    def depths(index: Integers) -> tuple[Floats, float]:
        """Optical depths (M, k) at some points, and the processor seconds of a line."""
        begin, points = time.process_time(), everything.points.subset(index)
        air = SpectralAir.of(state, points, everything.gases, everything.weight[index])
        paths = lines_of_sight(air, distance[:, None], altitude, np.radians(elevation))
        depth = np.array([path.depth[0] for path in paths], float)
        return depth, (time.process_time() - begin) / _SIGHTS

    depth, _ = depths(np.arange(everything.weight.size))
    exact = np.exp(mean_transmittance(depth, everything.weight, everything.weight.sum())[0])
    order = np.argsort(depth.mean(axis=0))
    candidates = order[np.unique(np.linspace(0, order.size - 1, _CANDIDATES).astype(int))]
    fit, test = slice(0, None, 2), slice(1, None, 2)
    ours = []
    for count in _POINTS:
        chosen, weight, _ = select_points(
            np.exp(-depth[fit][:, candidates]).T, exact[fit], tolerance=0.0, max_points=count, total_weight=1.0
        )
        of_few, seconds = depths(candidates[chosen])
        ours.append(Measured(f"{count} points", seconds, rms(np.exp(-of_few[test]) @ weight - exact[test])))
    theirs = [Measured("steps of 5 cm^-1", float(peer.seconds.mean()), rms((of_peer - exact)[test]))]
    work = f"transmittance of a line of sight, {response.lower:g}-{response.upper:g} um, gases alone"
    judged = f"root mean square against all {everything.weight.size} points"
    return EqualError.of(work, "LOWTRAN7", "1", ours, theirs, judged)


def scattering(job: Job, state: AtmosphericState, response: SpectralResponse) -> EqualError:
    """Diffuse light of the Sun at points of a band by our discrete ordinates and by PythonicDISORT, in the layers of a
    state, judged by PythonicDISORT with many streams.
    """
    from PythonicDISORT import pydisort

    everything = all_points(response, job.water_continuum)
    index = np.linspace(0, everything.weight.size - 1, _SCATTERING_POINTS).astype(int)
    air = SpectralAir.of(state, everything.points.subset(index), everything.gases, everything.weight[index])
    optics, sine = air.optics, np.sin(np.radians(_SUN_DEG))
    albedo = np.broadcast_to(state.albedo_at(optics.wavenumber), index.shape)
    depth = vertical_column(air.shells, optics.extinction)
    particles = vertical_column(air.shells, optics.aerosol_scattering)
    scattered = particles + vertical_column(air.shells, optics.rayleigh)
    transparent = np.argsort(depth.sum(axis=0))[: _SCATTERING_POINTS // 4]

    def of_peer(streams: int) -> tuple[Floats, float]:
        """Flux up at the top and down at the ground (2, p) of the most transparent points; seconds of a point."""
        flux, begin = [], time.process_time()
        for point in transparent:
            moments = optics.moments[: streams + 1] @ optics.phase_share[:, point]  # (L, N)
            share = (particles / scattered)[:, point]
            mixed = share * 0.5 * (moments[:, 1:] + moments[:, :-1])
            mixed[0] += 1 - share
            mixed[2] += 0.1 * (1 - share)  # second moment of molecules
            down = slice(None, None, -1)
            ends = np.cumsum(depth[down, point])
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # albedos near 1
                _, up, falling, *_ = pydisort(
                    ends,
                    np.minimum((scattered / depth)[down, point], 1 - 1e-9),
                    streams,
                    mixed.T[down],
                    float(sine),
                    1.0,
                    0.0,
                    NLeg=streams,
                    only_flux=True,
                    f_arr=np.clip(mixed[streams, down], 0.0, None),
                    BDRF_Fourier_modes=[float(albedo[point])],
                )
            flux.append((float(up(0.0)), float(np.sum(falling(ends[-1])))))
        return np.array(flux).T, (time.process_time() - begin) / transparent.size

    def of_ours(nodes: int) -> tuple[Floats, float]:
        begin, scaled = time.process_time(), replace(air, nodes=nodes)
        rising, falling = level_light(
            state,
            air.shells,
            optics,
            scaled.delta_fraction,
            scaled.scaled_source_paths,
            np.array([sine]),
            albedo,
            nodes,
        )
        seconds = (time.process_time() - begin) / _SCATTERING_POINTS
        beam = sine * np.exp(-vertical_column(air.shells, scaled.scaled_extinction).sum(axis=0) / sine)
        return np.stack([rising[-1, 0], falling[0, 0] + beam])[:, transparent], seconds

    reference, _ = of_peer(_MANY_STREAMS)

    def measured(name: str, flux: Floats, seconds: float) -> Measured:
        return Measured(name, seconds, rms(flux - reference) / float(sine))

    ours = [measured(f"{2 * nodes} streams", *of_ours(nodes)) for nodes in (2, 3, 4, 6)]
    theirs = [measured(f"{streams} streams", *of_peer(streams)) for streams in (4, 6, 8, 12)]
    work = f"diffuse light of a point, {response.lower:g}-{response.upper:g} um"
    judged = f"flux at top and ground over that of the Sun, against its {_MANY_STREAMS} streams"
    return EqualError.of(work, "PythonicDISORT", "1", ours, theirs, judged)


def thinned(state: AtmosphericState, levels: Integers) -> AtmosphericState:
    """A state at some of its levels, by their indices."""
    return replace(
        state,
        altitude=state.altitude[levels],
        pressure=state.pressure[levels],
        temperature=state.temperature[levels],
        mole_fraction={gas: values[levels] for gas, values in state.mole_fraction.items()},
        aerosols=tuple(replace(part, extinction_550=part.extinction_550[levels]) for part in state.aerosols),
    )
