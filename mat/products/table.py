"""The table of products: one entry for each kind of task. A new file type is a module here and an entry below."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from skyshine.mat.plan.plan import Kind
from skyshine.mat.products.atmosphere import AtmosphereProduct
from skyshine.mat.products.band import BandProduct
from skyshine.mat.products.product import Product
from skyshine.mat.products.temperature import TemperatureProduct
from skyshine.mat.products.texture import TextureProduct

PRODUCTS: Mapping[Kind, Product[Any]] = {
    Kind.TEXTURE: TextureProduct(),  # .tmm
    Kind.ATMOSPHERE: AtmosphereProduct(),  # .atmq, .lunar_atmq
    Kind.TEMPERATURE: TemperatureProduct(),  # .htt
    Kind.BAND: BandProduct(),  # .band
}
