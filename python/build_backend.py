"""Builds the wheel: first the command, which becomes a script of the wheel, then maturin the module.

maturin packs a module or commands, not both, and the workers of a run must be the command itself.
TRIBOSWEEP_BUILD_PROFILE names the profile of Cargo; without it that is `release`.
"""

import json
import os
import pathlib
import shutil
import subprocess

import maturin

HERE = pathlib.Path(__file__).resolve().parent
PROFILE = os.environ.get("TRIBOSWEEP_BUILD_PROFILE", "release")


def _build_command():
    # With the module among the packages their features are those of maturin's build, which then
    # finds everything compiled.
    command = [
        "cargo", "build", "--locked", "--profile", PROFILE, "--package", "tribosweep",
        "--package", "tribosweep-python", "--bin", "tribosweep", "--manifest-path", str(HERE.parent / "Cargo.toml"),
        "--message-format", "json-render-diagnostics",
    ]  # fmt: skip
    built = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
    messages = [json.loads(line) for line in built.splitlines()]
    programs = [message["executable"] for message in messages if message.get("executable")]
    scripts = HERE / "wheel-data" / "scripts"
    scripts.mkdir(parents=True, exist_ok=True)
    shutil.copy2(programs[-1], scripts / "tribosweep")
    os.environ["MATURIN_PEP517_ARGS"] = f"--profile {PROFILE}"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    _build_command()
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    _build_command()
    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory, config_settings=None):
    raise RuntimeError(
        "tribosweep is built from its repository, which holds the crates: pip install ./python"
    )


def get_requires_for_build_wheel(config_settings=None):
    return []


def get_requires_for_build_editable(config_settings=None):
    return []
