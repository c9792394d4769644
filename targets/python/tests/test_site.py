import pytest

import compass_localization as compass
from conftest import save_image


def test_a_site_is_saved_and_opened(site, tmp_path):
    site.save(tmp_path / "sample.site")
    again = compass.Site.open(tmp_path / "sample.site")
    assert again.to_bytes() == site.to_bytes() == (tmp_path / "sample.site").read_bytes()
    assert again.floors == ["sample-building"]
    candidates = again.candidates()
    assert candidates.shape[1] == 2 and len(candidates) > 1000
    assert (candidates >= 0).all() and (candidates <= [32, 22]).all()
    with pytest.raises(compass.CompassError, match="floor: 1"):
        again.candidates(1)


def test_the_command_builds_the_same_bytes(command, plan, tmp_path):
    save_image(tmp_path / "floor.ppm", plan.image)
    built = command("map", "build", tmp_path / "floor.ppm", "--spacing", 1, "--out", tmp_path / "floor.site")
    site = compass.Site.build(compass.load_plan(tmp_path / "floor.ppm"), spacing=1)
    assert site.to_bytes() == (tmp_path / "floor.site").read_bytes()
    assert len(site.candidates()) == built["candidates"]


def test_bad_sites_are_named(plan, tmp_path):
    with pytest.raises(compass.CompassError, match="missing.site"):
        compass.Site.open(tmp_path / "missing.site")
    (tmp_path / "text.site").write_text("no site")
    with pytest.raises(compass.CompassError, match="text.site"):
        compass.Site.open(tmp_path / "text.site")
    with pytest.raises(compass.CompassError, match="sample-building: .*spacing"):
        compass.Site.build(plan, spacing=-1)
    with pytest.raises(compass.CompassError, match="layers: 3"):
        compass.Site.build(plan, layers=3)
    with pytest.raises(compass.CompassError, match="name: "):
        compass.Site.build(plan, name="x" * 40)
    site = compass.Site.build(plan, spacing=2)
    with pytest.raises(compass.CompassError, match="floor: 7: there are 1"):
        site.candidates(7)
    with pytest.raises(compass.CompassError, match="gone"):
        site.save(tmp_path / "gone" / "x.site")
