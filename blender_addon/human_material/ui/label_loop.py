# SPDX-License-Identifier: GPL-3.0-or-later
"""What goes on beside the artist: answers are taken over, saving ends, messages are shown. Nothing here waits."""
import time

import bpy

from ..services import label_session, regions
from ..services.errors import InputError
from . import job_loop, label_properties

EACH_S = 0.05


def say(message, icon="ERROR"):
    """Blender's own report, where no operator is there to make it."""
    print("Human Material: %s" % message)
    manager = bpy.context.window_manager
    if bpy.app.background or not manager.windows:
        return
    with bpy.context.temp_override(window=manager.windows[0]):
        manager.popup_menu(lambda menu, _: menu.layout.label(text=message), title="Human Material", icon=icon)


def redraw(only_panels=False):
    """The 3D views; only their sidebars where nothing but words has changed: a view of a scan is slow to draw."""
    for window in bpy.context.window_manager.windows:
        for area in (a for a in window.screen.areas if a.type == "VIEW_3D"):
            for region in (r for r in area.regions if not only_panels or r.type == "UI"):
                region.tag_redraw()


def greet(item):
    """A scan that was just read: selected, seen, and one step of undo."""
    context = bpy.context
    for other in context.view_layer.objects:
        other.select_set(False)
    item.select_set(True)
    context.view_layer.objects.active = item
    show = context.scene.hm.label.show
    label_session.sessions[item.name].shown = show
    label_properties.set_viewports(context, show)
    look_at_all(item)
    bpy.ops.ed.undo_push(message="Open Scan")


def look_at_all(item):
    windows = bpy.context.window_manager.windows
    if bpy.app.background or not windows:
        return
    for area in windows[0].screen.areas:
        region = next((r for r in area.regions if r.type == "WINDOW"), None)
        if area.type == "VIEW_3D" and region is not None:
            with bpy.context.temp_override(window=windows[0], area=area, region=region):
                bpy.ops.view3d.view_axis(type="FRONT")
                bpy.ops.view3d.view_selected()
            return


def step():
    """One round; also what tests without a window call. Gives whether anything changed."""
    scene = bpy.context.scene
    changed, new, errors = label_session.poll_all(scene)
    for item in new:
        greet(item)
    for message in errors:
        scene.hm.label.message = message
    for message in errors + job_loop.step():
        say(message)
    has_news = job_loop.has_news()
    if (changed or has_news) and not bpy.app.background:
        redraw(only_panels=not changed)
    return changed


def take_over(name, output):
    """The classes that were saved are those that are shown."""
    classes = regions.classes_of(output)
    session = label_session.sessions.get(name)
    differing = 0
    if session is not None and len(session.classes) == len(classes):
        differing = sum(a != b for a, b in zip(session.classes, classes))
        session.take_classes(classes)
    print("Human Material: saved %s; %d faces differed from the last answer" % (output, differing))
    return "Saved %s" % output


def _tick():
    if bpy.context.window_manager is None:
        return EACH_S
    step()
    return EACH_S


def wait(until, timeout_s):
    """For scripts without a window, where no timer runs."""
    end = time.monotonic() + timeout_s
    while not until():
        if time.monotonic() > end:
            raise InputError("", "openhumanbrdf label", "has not answered for %g s" % timeout_s)
        if not step():
            time.sleep(0.01)


@bpy.app.handlers.persistent
def _on_jump(*_):
    for session in label_session.sessions.values():
        session.set_dirty()


@bpy.app.handlers.persistent
def _on_load(*_):
    label_session.close_all()


_HANDLERS = (("undo_post", _on_jump), ("redo_post", _on_jump), ("load_pre", _on_load))


def register():
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)
    if not bpy.app.background:
        bpy.app.timers.register(_tick, first_interval=EACH_S, persistent=True)


def unregister():
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    for name, handler in _HANDLERS:
        if handler in getattr(bpy.app.handlers, name):
            getattr(bpy.app.handlers, name).remove(handler)
    job_loop.cancel_all()
    label_session.close_all()


