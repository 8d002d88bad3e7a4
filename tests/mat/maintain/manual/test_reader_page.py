"""The page of the readers names what they read."""

from mat.maintain.manual.reader_page import PAGE, page
from mat.maintain.manual.sources import generated_pages
from skyshine.mat.surface.weather_forms import FORMS


def test_the_page_has_every_form_and_extension():
    text = page()
    assert all(f"| {form.title} |" in text for form in FORMS)
    assert "| `KHR_mesh_quantization` | decoded" in text and "| `KHR_draco_mesh_compression` | refused" in text
    assert "`reflectance scale factor`" in text and "`t2m`" in text and "`dew_point`" in text and "tiff" in text
    assert generated_pages()[PAGE] == text


def test_tables_have_as_many_cells_in_each_row():
    block = None
    for line in page().splitlines():
        block = (block or line.replace("\\|", "").count("|")) if line.startswith("|") else None
        assert block is None or line.replace("\\|", "").count("|") == block
