"""What is released: a wheel and a source distribution, of the three packages and nothing else.

`make dist` sets DIST to the folder that it has built into; without, both are built here, offline.
"""

import os
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from email import message_from_bytes
from pathlib import Path, PurePosixPath

import pytest
from trove_classifiers import classifiers

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PACKAGES = {"swarm_forage_env", "baselines", "training"}
BESIDE = {"CHANGELOG.md", "CITATION.cff", "LICENSE", "README.md", "constraints.txt"}
OF_THE_BUILD = {".gitignore", "PKG-INFO", "pyproject.toml"}
LARGEST = 1.0
"""Of either file [MB]."""


def build(folder, source=ROOT, *targets):
    """Build from a folder with the backend alone, which takes no network."""
    command = sys.executable, "-m", "hatchling", "build", "-d", folder
    options = [word for target in targets for word in ("-t", target)]
    made = subprocess.run(
        [*command, *options], cwd=source, capture_output=True, text=True, check=False,
        timeout=300,
    )  # fmt: skip
    assert made.returncode == 0, made.stdout + made.stderr


@pytest.fixture(scope="module")
def dist(tmp_path_factory):
    """The folder with both files."""
    if "DIST" in os.environ:
        return ROOT / os.environ["DIST"]
    folder = tmp_path_factory.mktemp("dist")
    build(folder)
    return folder


@pytest.fixture(scope="module")
def wheel(dist):
    """The content of the wheel by name."""
    (file,) = dist.glob("*.whl")
    with zipfile.ZipFile(file) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.fixture(scope="module")
def sdist(dist):
    """The content of the source distribution by name, without the folder that all is in."""
    (file,) = dist.glob("*.tar.gz")
    with tarfile.open(file) as archive:
        members = [each for each in archive.getmembers() if each.isfile()]
        return {each.name.partition("/")[2]: archive.extractfile(each).read() for each in members}


@pytest.fixture(scope="module")
def metadata(wheel):
    (name,) = (each for each in wheel if each.endswith(".dist-info/METADATA"))
    return message_from_bytes(wheel[name])


def tops(names):
    """The first folder or file of each name."""
    return {PurePosixPath(name).parts[0] for name in names}


def test_both_carry_the_version_of_the_project_and_are_small(dist):
    version = PROJECT["version"]
    names = {file.name for file in dist.iterdir() if file.suffix in {".whl", ".gz"}}
    stem = f"swarm_forage-{version}"
    assert names == {f"{stem}-py3-none-any.whl", f"{stem}.tar.gz"}
    assert max((dist / name).stat().st_size for name in names) < LARGEST * 1e6


def test_the_source_holds_what_the_wheel_is_built_from_and_nothing_else(sdist):
    assert tops(sdist) == PACKAGES | BESIDE | OF_THE_BUILD


def test_both_hold_every_file_of_the_packages_and_the_wheel_nothing_else(sdist, wheel):
    files = {
        path.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for path in (ROOT / package).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    ours = {name: content for name, content in wheel.items() if ".dist-info/" not in name}
    assert ours.keys() == files
    assert ours == {name: sdist[name] for name in sdist if tops([name]) <= PACKAGES}
    assert not [name for name in ours if "/test_" in name or "/tests/" in name]
    assert {f"{package}/py.typed" for package in PACKAGES} <= files


def test_the_wheel_from_the_source_distribution_is_that_of_the_checkout(dist, wheel, tmp_path):
    (file,) = dist.glob("*.tar.gz")
    with tarfile.open(file) as archive:
        archive.extraction_filter = getattr(tarfile, "data_filter", None)  # from Python 3.11.4 on
        archive.extractall(tmp_path)
    (source,) = tmp_path.iterdir()
    build(tmp_path / "again", source, "wheel")
    (again,) = (tmp_path / "again").glob("*.whl")
    with zipfile.ZipFile(again) as archive:
        assert {name: archive.read(name) for name in archive.namelist()} == wheel


def test_the_metadata_are_complete(metadata):
    assert metadata["Name"] == "swarm-forage"
    assert metadata["Summary"] == PROJECT["description"]
    assert metadata["License-Expression"] == "MIT"
    assert metadata["Description-Content-Type"] == "text/markdown"
    assert metadata.get_payload().startswith("# swarm-forage")
    assert metadata["Requires-Python"] == PROJECT["requires-python"]
    assert set(metadata.get_all("Provides-Extra")) == set(PROJECT["optional-dependencies"])
    assert all(metadata[field] for field in ("Author", "Keywords", "License-File"))


def test_every_classifier_is_one_of_the_index_s(metadata):
    assert set(metadata.get_all("Classifier")) <= classifiers
    assert len(PROJECT["classifiers"]) == len(set(PROJECT["classifiers"]))
