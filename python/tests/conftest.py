import pytest

SCENE = {
    "foundation": {"base": {"shear_modulus": "80 GPa", "poisson": 0.3}},
    "punch": {"shape": "sphere", "radius": "50 mm"},
    "friction": {"mu": 0.3},
    "loading": {"steps": [{"approach": "20 um", "shift_x": "2 um"}]},
}


@pytest.fixture
def scene():
    """A scene of its own for each test."""
    return {name: dict(table) for name, table in SCENE.items()}


@pytest.fixture
def store(tmp_path, monkeypatch):
    """The path of a store that nobody else has."""
    monkeypatch.delenv("TRIBOSWEEP_STORE", raising=False)
    return tmp_path / "store"
