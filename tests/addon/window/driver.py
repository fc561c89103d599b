"""Drives a real window of Blender by simulated pointer and keys. Steps are a generator: each `yield` lets the window go
on; a failure prints its trace, takes a last picture and ends Blender with 1.

Blender needs --enable-event-simulate; the arguments after -- are the folder for pictures and what the steps want.
"""
import faulthandler
import os
import sys
import time
import traceback

import bpy

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
import support  # noqa: E402,F401

import human_material.ui  # noqa: E402

BEAT_S = 0.05
HANG_S = 120


def arguments():
    return sys.argv[sys.argv.index("--") + 1:]


class Window:
    """The first window, its largest 3D view, and a hand."""

    def __init__(self, folder):
        self.folder, self.x, self.y = folder, 0, 0
        bpy.context.preferences.view.show_splash = False
        bpy.context.preferences.view.ui_scale = 1.0
        bpy.context.preferences.system.viewport_aa = "OFF"   # else each view is drawn eight times by the processor

    @property
    def window(self):
        return bpy.context.window_manager.windows[0]

    @property
    def area(self):
        return max((a for a in self.window.screen.areas if a.type == "VIEW_3D"), key=lambda a: a.width * a.height)

    def region(self, kind="WINDOW"):
        return next(r for r in self.area.regions if r.type == kind)

    def view(self):
        return self.area.spaces.active.region_3d

    def override(self):
        return bpy.context.temp_override(window=self.window, area=self.area, region=self.region())

    # The hand. Places are in pixels of the 3D view's region.
    def move(self, x, y):
        region = self.region()
        self.x, self.y = int(region.x + x), int(region.y + y)
        self.window.event_simulate("MOUSEMOVE", "NOTHING", x=self.x, y=self.y)

    def click_window(self, x, y):
        """Places in the window, from its top left."""
        self.x, self.y = x, self.window.height - y
        self.window.event_simulate("MOUSEMOVE", "NOTHING", x=self.x, y=self.y)
        yield
        self.button("PRESS")
        yield
        self.button("RELEASE")
        yield

    def button(self, value):
        self.window.event_simulate("LEFTMOUSE", value, x=self.x, y=self.y)

    def key(self, name, **modifiers):
        for value in ("PRESS", "RELEASE"):
            self.window.event_simulate(name, value, x=self.x, y=self.y, **modifiers)

    def drag(self, places):
        """Press at the first place, go through the others, let go."""
        self.move(*places[0])
        yield
        self.button("PRESS")
        yield
        for place in places[1:]:
            self.move(*place)
            yield
        self.button("RELEASE")
        yield

    def show_panels(self, *names):
        """Of the sidebar only these panels of the add-on, open."""
        for panel in [c for c in human_material.ui.CLASSES if issubclass(c, bpy.types.Panel)]:
            if hasattr(bpy.types, panel.__name__):
                bpy.utils.unregister_class(panel)
            if panel.__name__ in names:
                panel.bl_options = set(getattr(panel, "bl_options", ())) - {"DEFAULT_CLOSED"}
                bpy.utils.register_class(panel)

    def wait(self, until, what, timeout_s=300):
        end = time.monotonic() + timeout_s
        while not until():
            if time.monotonic() > end:
                raise AssertionError("waited %g s for %s" % (timeout_s, what))
            yield

    def picture(self, name):
        for _ in range(4):   # the window is drawn after the steps
            yield
        with self.override():
            bpy.ops.screen.screenshot(filepath=os.path.join(self.folder, name + ".png"))
        yield


def drive(steps, window):
    """Runs the steps by a timer; Blender ends with 0 if they end."""
    def beat():
        faulthandler.dump_traceback_later(HANG_S, exit=True)   # a step that does not come back
        try:
            next(steps)
        except StopIteration:
            print("window test passed", flush=True)
            sys.stdout.flush()
            os._exit(0)
        except BaseException:   # also of assertions
            traceback.print_exc()
            try:
                with window.override():
                    bpy.ops.screen.screenshot(filepath=os.path.join(window.folder, "failed.png"))
            finally:
                sys.stderr.flush()
                os._exit(1)
        faulthandler.cancel_dump_traceback_later()
        return BEAT_S
    bpy.app.timers.register(beat, first_interval=1.0)


faulthandler.enable()
