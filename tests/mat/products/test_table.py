"""The table of products: one entry for each kind of task, and only the files that the plan names."""

from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import Kind, make_plan
from skyshine.mat.products.product import Context
from skyshine.mat.products.table import PRODUCTS
from skyshine.materials.library import load_library


def test_every_kind_of_task_has_a_product():
    assert set(PRODUCTS) == set(Kind)


def test_a_product_writes_the_files_that_the_plan_names(small_job):
    loaded, library = load_job(small_job), load_library()
    tasks = make_plan(loaded, library).tasks
    assert {task.kind for task in tasks} == set(Kind) - {Kind.TEXTURE}
    for task in tasks:
        identities = PRODUCTS[task.kind].identity(Context(task, loaded, ("asphalt_road", "grass_green"), library))
        assert tuple(identity.file for identity in identities) == task.files
