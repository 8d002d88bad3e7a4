"""Images that an entry of a job stands for: folders, patterns, UDIM sets."""

import pytest
from PIL import Image

from skyshine.schemas.errors import InputError
from skyshine.tmm.job.images import find_images
from skyshine.tmm.job.load import load_job
from skyshine.tmm.mapping.run import output_folder


@pytest.fixture
def files(tmp_path):
    def make(*names):
        for name in names:
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).touch()

    return make


@pytest.fixture
def job(tmp_path, library):
    def load(text):
        (tmp_path / "job.yaml").write_text(f"textures:\n{text}")
        return load_job(tmp_path / "job.yaml", library)[0]

    return load


def test_a_folder_stands_for_its_images(tmp_path, files):
    files("sheets/b.PNG", "sheets/a.tif", "sheets/readme.txt", "sheets/.hidden.png", "sheets/deep/c.png")
    assert find_images(tmp_path, "sheets") == {"a": "sheets/a.tif", "b": "sheets/b.PNG"}


def test_a_file_stands_for_itself_also_with_characters_of_patterns(tmp_path, files):
    files("a[1].png", "a1.png")
    assert find_images(tmp_path, "a[1].png") is None
    assert find_images(tmp_path, "missing.png") is None


@pytest.mark.parametrize(
    "pattern, names",
    [
        ("*.png", ["a", "b"]),
        ("?.png", ["a", "b"]),
        ("[b-z].png", ["b"]),
        ("**/*.png", ["a", "b", "c"]),
        ("d*/c.*", ["c"]),
    ],
)
def test_patterns(tmp_path, files, pattern, names):
    files("b.png", "a.png", "deep/c.png", "notes.txt")
    assert list(find_images(tmp_path, pattern)) == names


def test_a_udim_set_is_its_tiles(tmp_path, files):
    files("wood.1001.png", "wood.1002.png", "wood.1011.png", "wood.0999.png", "wood.10011.png", "wood.base.png")
    assert list(find_images(tmp_path, "wood.<UDIM>.png").values()) == [
        "wood.1001.png",
        "wood.1002.png",
        "wood.1011.png",
    ]


def test_images_of_one_name_are_named_by_their_folders(tmp_path, files):
    files("brick/albedo.png", "wood/albedo.png")
    assert find_images(tmp_path, "*/albedo.png") == {
        "brick_albedo": "brick/albedo.png",
        "wood_albedo": "wood/albedo.png",
    }
    files("x/a.png", "x/a.jpg")
    with pytest.raises(ValueError, match="would both be named 'x_a'"):
        find_images(tmp_path, "x")


def test_an_entry_becomes_a_texture_an_image(job, files):
    files("one/a.png", "two/b.png", "two/c.png", "d.png")
    loaded = job(
        "  - {image: one/*.png, material: grass_green}\n"
        "  - {image: two/*.png, material: asphalt_road, alpha: ignore}\n"
        "  - {image: d.png, name: last, material: grass_green}\n"
    )
    found = [(texture.name, texture.image, texture.material, texture.alpha) for texture in loaded.textures]
    assert found == [
        ("a", "one/a.png", "grass_green", "auto"),
        ("b", "two/b.png", "asphalt_road", "ignore"),
        ("c", "two/c.png", "asphalt_road", "ignore"),
        ("last", "d.png", "grass_green", "auto"),
    ]


def test_each_texture_has_its_own_seeds(job, files):
    files("sheets/a.png", "sheets/b.png")
    loaded = job(
        "  - image: sheets\n"
        "    seeds:\n"
        "      file: clicks/{name}.geojson\n"
        "      labels: {image: 'labels/{name}.png', palette: {'1': grass_green}}\n"
        "    overrides: {file: all.geojson}\n"
    )
    assert [texture.seeds.labels.image for texture in loaded.textures] == ["labels/a.png", "labels/b.png"]
    assert [texture.seeds.file for texture in loaded.textures] == ["clicks/a.geojson", "clicks/b.geojson"]
    assert {texture.overrides.file for texture in loaded.textures} == {"all.geojson"}


@pytest.mark.parametrize(
    "text, message",
    [
        ("  - {image: '*.jpg', material: grass_green}\n", "found no image for '\\*.jpg'"),
        (
            f"  - {{image: {'a' * 5000}, material: grass_green}}\n",
            "a name of 5000 bytes; allowed: names of 255 at most",
        ),
        ("  - {image: '**a/*.png', material: grass_green}\n", "\\*\\*"),
        ("  - {image: '**/../../*.png', material: grass_green}\n", "leads out of the job's folder"),
        ("  - {image: '../*.png', material: grass_green}\n", "leads out of the job's folder"),
        ("  - {image: '*.png', name: x, material: grass_green}\n", "leave 'name' out"),
        (
            "  - {image: '*.png', material: grass_green}\n  - {image: a.png, material: grass_green}\n",
            "two textures named 'a'",
        ),
    ],
)
def test_what_cannot_be_meant(job, files, text, message):
    files("a.png", "b.png")
    with pytest.raises(InputError, match=message):
        job(text)


def test_a_link_out_of_the_folder_is_no_image_of_a_pattern(job, files, tmp_path):
    files("a.png")
    (tmp_path / "link.png").symlink_to("/etc/hostname")
    with pytest.raises(InputError, match=r"'link.png', which leads out of the job's folder"):
        job("  - {image: '*.png', material: grass_green}\n")


def test_an_absolute_pattern(job, files, tmp_path):
    files("a.png", "b.png")
    loaded = job(f"  - {{image: '{tmp_path}/*.png', material: grass_green}}\n")
    assert [texture.image for texture in loaded.textures] == [f"{tmp_path}/{name}.png" for name in "ab"]


@pytest.mark.parametrize("output", ["output: {folder: shown}", "skyshine: 1\noutput: {folder: shown}"])
def test_the_top_keys_are_those_of_a_job_of_mat(tmp_path, library, output):
    Image.new("RGB", (4, 4), (90, 90, 90)).save(tmp_path / "road.png")
    (tmp_path / "job.yaml").write_text(f"{output}\ntextures: [{{image: road.png, material: asphalt_road}}]\n")
    job, folder = load_job(tmp_path / "job.yaml", library)
    assert job.skyshine == 1 and output_folder(job, folder, None) == tmp_path / "shown"


def test_another_version_of_the_format_is_refused(tmp_path, library):
    Image.new("RGB", (4, 4), (90, 90, 90)).save(tmp_path / "road.png")
    (tmp_path / "job.yaml").write_text("skyshine: 2\ntextures: [{image: road.png, material: asphalt_road}]\n")
    with pytest.raises(InputError, match=r"job\.yaml:1:"):
        load_job(tmp_path / "job.yaml", library)
