"""Water vapour continua of MT_CKD beside that of the absorption table.

    python -m mat.maintain.atmospheres.water_continua --continua DIR

writes two files to `atmospheres/continuum` from the files of MT_CKD in a folder.

`mt_ckd_4.3_closure.csv`: the foreign continuum that MT_CKD 4.3 offers beside its own from 610 to 1380 cm^-1
(`for_closure_absco_ref`), with which measured spectra are met from 780 to 1250 cm^-1 (Mlawer et al. 2023).

`mt_ckd_2.4.csv`: the coefficients before MT_CKD 4, with the self continuum of 2000 to 3200 cm^-1 that MT_CKD 2.5
replaced, for comparison with codes of its time. Against the figures printed with release 2.5.3 the
self continuum agrees from 750 cm^-1 on (below, later releases changed it), and the foreign continuum to 3 % (its scale
factor of MT_CKD 2.4 is omitted). From 3300 to 5000 cm^-1 nothing was printed: both parts are those of the last release
before MT_CKD 4.
"""

from __future__ import annotations

from collections.abc import Sequence

import click
import numpy as np

from skyshine import atmospheres
from skyshine.mat.atmosphere.gases.absorption import WATER_CONTINUA
from skyshine.mat.spectroscopy.continua import REFERENCE_TEMPERATURE, Continua
from skyshine.mat.spectroscopy.linebyline import CM2_TO_M2
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import read_csv, write_csv

REPLACED = "continuum/mt_ckd_1.00_self.csv"
CLOSURE_LOW, CLOSURE_HIGH = 610.0, 1380.0  # cm^-1, where the two foreign continua of MT_CKD 4.3 differ
LOW, HIGH, STEP = 750.0, 5000.0, 10.0  # cm^-1
COLD = 260.0  # K, the second temperature of the self continuum
UNIT = 1e-20 * CM2_TO_M2  # unit of the coefficients, m2/molecule per cm^-1


def coefficients(continua: Continua) -> tuple[Floats, Floats, Floats, Floats]:
    """Wavenumber (K,) cm^-1, self and foreign continuum at 296 K (K,) m2/molecule per cm^-1, exponent of the self
    continuum (K,).
    """
    wavenumber = np.arange(LOW, HIGH + 1, STEP)
    at_296, at_260, foreign = (continua.before_4(name, wavenumber) for name in ("bs296", "bs260", "bfh2o"))
    replaced = read_csv(atmospheres.path(REPLACED))
    index = np.searchsorted(wavenumber, replaced["wavenumber[cm-1]"])
    at_296[index], at_260[index] = replaced["self_296[1e-20 cm3]"], replaced["self_260[1e-20 cm3]"]
    exponent = np.log(at_260 / at_296) / np.log(REFERENCE_TEMPERATURE / COLD)
    return wavenumber, at_296 * UNIT, foreign * UNIT, exponent


def closure(continua: Continua) -> tuple[Floats, Floats]:
    """Wavenumber (K,) cm^-1 and foreign continuum at 296 K (K,) m2/molecule per cm^-1, for radiative closure."""
    wavenumber = np.arange(CLOSURE_LOW, CLOSURE_HIGH + 1, STEP)
    return wavenumber, continua.foreign_for_closure(wavenumber)


@click.command(help=__doc__)
@click.option("--continua", required=True, type=click.Path(exists=True), help="Folder of the MT_CKD files.")
def main(continua: str) -> None:
    """Write the packaged files."""
    source = Continua(continua)
    by = "Written by python -m mat.maintain.atmospheres.water_continua."
    of_2_4 = (
        "Water vapour continuum of MT_CKD 2.4 (Mlawer et al. 2012, Phil. Trans. R. Soc. A 370, 2520), 296 K and"
        " 1013 hPa, without the",
        f"radiation term; the self continuum goes with (296 K / T)^exponent. {by}",
        source.notice,
    )
    of_closure = (
        "Foreign continuum of water vapour of MT_CKD 4.3 for radiative closure (for_closure_absco_ref), 296 K and 1013"
        " hPa, without the",
        f"radiation term; all other coefficients are those of MT_CKD 4.3. {by}",
        source.notice,
    )
    wavenumber, per = "wavenumber[cm-1]", "[m2/molecule per cm-1]"
    columns = [wavenumber, f"self_continuum{per}", f"foreign_continuum{per}", "self_exponent"]
    _write("mt_ckd_2.4", of_2_4, columns, coefficients(source))
    _write("mt_ckd_4.3_closure", of_closure, [wavenumber, f"foreign_continuum{per}"], closure(source))


def _write(name: str, header: Sequence[str], columns: Sequence[str], values: Sequence[Floats]) -> None:
    write_csv(atmospheres.path(WATER_CONTINUA[name]), list(header), list(columns), np.transpose(values))


if __name__ == "__main__":
    main()
