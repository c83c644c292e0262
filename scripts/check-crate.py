"""Holds an RO-Crate against the validator of the format, and reads it with the library for it.

    check-crate.py DIRECTORY

The validator asks the network for the context of the format, which may not be there; it gets the one
that the library brings. The addresses of licences and people are not looked up.
"""

import importlib.resources
import json
import pathlib
import sys
import types

from rocrate.rocrate import ROCrate
from rocrate_validator import models, services
from rocrate_validator.utils.http import HttpRequester

CONTEXT = "https://w3id.org/ro/crate/1.1/context"


def serve_context():
    """Answers requests for the context from the library's copy."""
    text = importlib.resources.files("rocrate").joinpath("data/ro-crate.jsonld").read_text()
    ask = HttpRequester.__getattr__

    def answered(self, name):
        method = ask(self, name)

        def wrapped(url, *arguments, **options):
            if url != CONTEXT:
                return method(url, *arguments, **options)
            return types.SimpleNamespace(
                status_code=200,
                ok=True,
                url=url,
                text=text,
                content=text.encode(),
                headers={"Content-Type": "application/ld+json"},
                json=lambda: json.loads(text),
                raise_for_status=lambda: None,
            )

        return wrapped if name in ("get", "head") else method

    HttpRequester.__getattr__ = answered


def validate(root):
    """Fails with the findings of the validator, if it has any that are required."""
    result = services.validate(
        services.ValidationSettings(
            rocrate_uri=str(root),
            profile_identifier="ro-crate-1.1",
            requirement_severity=models.Severity.REQUIRED,
        )
    )
    issues = [f"{issue.check.identifier}: {issue.message}" for issue in result.get_issues()]
    assert result.passed() and not issues, "\n".join(issues)


def read(root):
    """Checks that the library finds every file and the runs, and says how many there are."""
    crate = ROCrate(root)
    listed = {entity.id for entity in crate.data_entities}
    there = {str(path.relative_to(root)) for path in root.rglob("*") if path.is_file()}
    assert there - listed == {"ro-crate-metadata.json"}, (there, listed)
    assert listed <= there, (there, listed)
    runs = [entity for entity in crate.contextual_entities if entity.id.startswith("#run-")]
    assert runs and all(run["instrument"]["name"] == "tribosweep" for run in runs), runs
    assert all(run["object"] and run["result"] for run in runs), runs
    print(f"{root.name}: valid; {len(listed)} files and {len(runs)} run(s), read by rocrate")


serve_context()
directory = pathlib.Path(sys.argv[1])
validate(directory)
read(directory)
