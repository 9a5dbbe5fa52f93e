"""Fixtures for all tests: the available devices, and ``verified`` (verification.py)."""

import os

# Workers share the cores, hence one thread of NumPy each. NumPy reads these variables when it is imported.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
import warp as wp

wp.config.log_level = wp.LOG_WARNING

pytest_plugins = ("verification", "pytester")


def _devices() -> list[str]:
    wp.init()
    return ["cpu"] + (["cuda:0"] if wp.is_cuda_available() else [])


@pytest.fixture(params=_devices(), scope="session")
def device(request) -> str:
    """Each available device: the CPU, and CUDA where there is one."""
    return request.param


@pytest.fixture(autouse=True, scope="session")
def _own_surfaces(tmp_path_factory):
    """No surface from a file is taken from earlier runs of the tests: each is made by the present programs."""
    from warp_rods.membranes import surface_cache

    with pytest.MonkeyPatch.context() as patched:
        folder = tmp_path_factory.mktemp("surfaces")
        patched.setattr(surface_cache, "_folder", lambda: folder)
        yield


@pytest.fixture(autouse=True, scope="session")
def _no_posters():
    """Runs of the tests make no posters, which would take a second each; tests/draw/test_pictures.py makes one."""
    from warp_rods import workflow

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(workflow, "_MADE", workflow._MADE[:1])
        yield
