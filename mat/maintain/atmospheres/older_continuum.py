"""The water vapour continuum of MT_CKD 2.4, for comparison with codes of its time.

    python -m mat.maintain.atmospheres.older_continuum --continua DIR

writes `atmospheres/continuum/mt_ckd_2.4.csv` from the coefficients before MT_CKD 4 in the folder of the continua, with
the self continuum of 2000 to 3200 cm^-1 that MT_CKD 2.5 replaced. Against the figures printed with release 2.5.3 the
self continuum agrees from 750 cm^-1 on (below, later releases changed it), and the foreign continuum to 3 % (its scale
factor of MT_CKD 2.4 is omitted). From 3300 to 5000 cm^-1 nothing was printed: both parts are those of the last release
before MT_CKD 4.
"""

from __future__ import annotations

import click
import numpy as np

from skyshine import atmospheres
from skyshine.mat.spectroscopy.continua import REFERENCE_TEMPERATURE, Continua
from skyshine.mat.spectroscopy.linebyline import CM2_TO_M2
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import read_csv, write_csv

NAME, REPLACED = "continuum/mt_ckd_2.4.csv", "continuum/mt_ckd_1.00_self.csv"
LOW, HIGH, STEP = 750.0, 5000.0, 10.0  # cm^-1
COLD = 260.0  # K, the second temperature of the self continuum
UNIT = 1e-20 * CM2_TO_M2  # of the coefficients, m2/molecule per cm^-1


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


@click.command()
@click.option("--continua", required=True, type=click.Path(exists=True), help="Folder of the MT_CKD files.")
@click.option("--out", type=click.Path(), help="The CSV file to write; default: the packaged one.")
def main(continua: str, out: str | None) -> None:
    """Write the water vapour continuum of MT_CKD 2.4."""
    source = Continua(continua)
    header = [
        (
            "Water vapour continuum of MT_CKD 2.4 (Mlawer et al. 2012, Phil. Trans. R. Soc. A 370, 2520), 296 K and"
            " 1013 hPa, without the"
        ),
        (
            "radiation term; the self continuum goes with (296 K / T)^exponent. Written by python -m"
            " mat.maintain.atmospheres.older_continuum."
        ),
        source.notice,
    ]
    per = "[m2/molecule per cm-1]"
    columns = ["wavenumber[cm-1]", f"self_continuum{per}", f"foreign_continuum{per}", "self_exponent"]
    write_csv(out or atmospheres.path(NAME), header, columns, np.transpose(coefficients(source)))


if __name__ == "__main__":
    main()
