"""In a window: a scan is baked, a dataset produced, a view compared with Cycles, a video rendered; each while the window
goes on; the programs are cancelled once each. Arguments: folder for pictures and results, scan, its classes, an environment."""
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

import bpy  # noqa: E402
import driver  # noqa: E402
from support import maps_folder  # noqa: E402

import human_material  # noqa: E402
from human_material.services import jobs, programs  # noqa: E402
from human_material.ui import job_loop  # noqa: E402

PLAN = """<plan schema="1" name="small" seed="1"><maps size_px="64"/>
<person id="a" scan="{scan}" labels="{labels}" split="train" licence="CC0-1.0"/>
<environments id="e" folder="{lights}"/>
<views split="train" count="2" size_px="32" spp="4"><lights from="e" count="1"/></views></plan>"""


def run(window, operator, kind):
    """Starts it; the window must draw on until it ends. Gives the last words."""
    with window.override():
        getattr(bpy.ops.hm, operator)("EXEC_DEFAULT")
    assert jobs.of(kind) is not None
    beats = 0
    while jobs.of(kind) is not None:
        beats += 1
        yield
    assert beats > 1, beats   # it did not wait
    print("%s: %s, %d beats" % (operator, job_loop.last_words[kind], beats), flush=True)
    return job_loop.last_words[kind]


def cancelled(window, operator, kind):
    with window.override():
        getattr(bpy.ops.hm, operator)("EXEC_DEFAULT")
        bpy.ops.hm.cancel_job(kind=kind)
    yield from window.wait(lambda: jobs.of(kind) is None, "the end of " + operator, 30)
    assert job_loop.last_words[kind].endswith(": cancelled"), job_loop.last_words[kind]


def prepared(folder, scan, labels, light):
    """REGIONS, plan and the fields of the panels."""
    regions = os.path.join(folder, "regions")
    subprocess.run([programs.find("openhumanbrdf"), "label", scan, "--faces", labels, "--classes",
                    "skin,hair,fabric,leather", "-o", regions], check=True, capture_output=True)
    settings = bpy.context.scene.hm.tools
    plan = os.path.join(folder, "plan.xml")
    with open(plan, "w", encoding="utf-8") as file:
        file.write(PLAN.format(scan=scan, labels=labels, lights=os.path.dirname(light)))
    settings.scan, settings.regions, settings.size_px, settings.model = scan, regions, 512, os.path.join(folder, "model")
    settings.plan, settings.dataset = plan, os.path.join(folder, "dataset")
    settings.environment, settings.view_px, settings.spp, settings.seeds = light, 32, 256, 8
    settings.report = os.path.join(folder, "report")


def baked(window):
    settings = bpy.context.scene.hm.tools
    yield from cancelled(window, "bake", "bake")
    assert not os.path.exists(settings.model)
    words = yield from run(window, "bake", "bake")
    assert words == "Baked model", words
    with window.override():
        bpy.ops.hm.show_model()
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    window.area.spaces.active.shading.color_type = "TEXTURE"
    yield from window.picture("bake")


def produced(window):
    window.show_panels("HM_PT_produce")
    yield from cancelled(window, "produce", "produce")
    words = yield from run(window, "produce", "produce")
    assert os.path.isfile(os.path.join(bpy.context.scene.hm.tools.dataset, "dataset.xml")), words
    words = yield from run(window, "show_samples", "produce")
    assert words.startswith("Samples: "), words
    yield from window.picture("produce")


def comparison_cancelled(window):
    """test_tools.py waits for a verdict; here the window goes on while Cycles renders."""
    window.show_panels("HM_PT_validate")
    with window.override():
        bpy.ops.hm.validate("EXEC_DEFAULT")
    yield from window.wait(lambda: jobs.of("validate").share() is not None, "progress", 60)
    yield from window.picture("validate_running")
    bpy.ops.hm.cancel_job(kind="validate")
    yield from window.wait(lambda: jobs.of("validate") is None, "the end of validate", 30)
    assert job_loop.last_words["validate"] == "Comparing: cancelled"
    assert not os.path.exists(bpy.context.scene.hm.tools.report)


def validated(window):
    """For the pictures of the docs."""
    words = yield from run(window, "validate", "validate")
    assert words.split(":")[0] in ("Pass", "Undecided", "Difference"), words
    for name in ("index.html", "scene.blend"):
        assert os.path.isfile(os.path.join(bpy.context.scene.hm.tools.report, name))
    yield from window.picture("validate")


def filmed(window, folder):
    """A video of two frames. (A simulated Esc does not reach Blender's renders: test_studio.py plays that.)"""
    maps_folder.write(os.path.join(folder, "person"), maps_folder.Person(24, 24))
    with window.override():
        bpy.ops.hm.import_maps("EXEC_DEFAULT", filepath=os.path.join(folder, "person", "maps.json"))
    scene, path = bpy.context.scene, os.path.join(folder, "a.mp4")
    scene.hm.samples = 1
    scene.frame_end = 2
    with window.override():
        bpy.ops.hm.prepare_render()
        bpy.ops.hm.render_video("EXEC_DEFAULT", filepath=path)
    yield from window.wait(lambda: os.path.exists(path), "the video", 120)
    yield from window.wait(lambda: not bpy.app.is_job_running("RENDER"), "the end of the render", 30)
    assert scene.frame_current == 1 and not scene.render.filepath.endswith(".mp4")


def steps(window, folder, scan, labels, light):
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    window.area.spaces.active.show_region_ui = True
    prepared(folder, scan, labels, light)
    window.show_panels("HM_PT_bake")
    yield
    yield from window.click_window(1044, 272)   # the tab Human Material
    yield from baked(window)
    yield from produced(window)
    yield from comparison_cancelled(window)
    yield from filmed(window, folder)


def main():
    folder, *rest = driver.arguments()
    human_material.register()
    window = driver.Window(folder)
    driver.drive(steps(window, folder, *rest), window)


if __name__ == "__main__":
    main()
