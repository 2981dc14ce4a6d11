from __future__ import annotations

import pytest

from asap_laboratory import scenes
from asap_laboratory.scenes import Scene
from house import ROOT

pytest.importorskip("matplotlib")

from asap import plots
from asap_laboratory import scene_pictures

PAGES = ROOT / "python" / "laboratory" / "pages"


@pytest.fixture(scope="module")
def scene() -> Scene:
    return scenes.timing(3, 120, 90, 100.0, duration_s=0.2)


def test_pictures_of_the_documentation_are_there_light_and_alike(scene: Scene) -> None:
    names = {f"scene_{one.name}.svg" for one, _, _ in scene_pictures.documented()}
    files = {path.name: path for path in PAGES.glob("scene_*.svg")}
    assert set(files) == names
    sizes = [path.stat().st_size for path in files.values()]
    assert max(sizes) < 60_000
    assert sum(sizes) < 300_000
    page = (PAGES / "scenes.md").read_text()
    assert all(f"({name})" in page for name in names)
    assert plots.svg(scene.plot()) == plots.svg(scene.plot())
