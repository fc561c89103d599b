"""Runs steps of window/ in a real window of Blender on a virtual screen:

    window_test.py BLENDER FOLDER STEPS.py ARGUMENT...

Exits with 77 (skipped) and says why where there is no xvfb-run, or an argument that names a file is not there. Pictures
of the window stay in FOLDER.
"""
import os
import shutil
import subprocess
import sys


def main():
    blender, folder, steps, *rest = sys.argv[1:]
    missing = [path for path in rest if os.path.isabs(path) and not os.path.exists(path)]
    if shutil.which("xvfb-run") is None or missing:
        print("skipped: %s" % (missing[0] + " is not there" if missing else "xvfb-run is not installed (xvfb)"))
        return 77
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(os.path.join(folder, "user"))
    environment = dict(os.environ, BLENDER_USER_CONFIG=os.path.join(folder, "user"),
                       BLENDER_USER_SCRIPTS=os.path.join(folder, "user"), LIBGL_ALWAYS_SOFTWARE="1")
    command = ["xvfb-run", "-a", "-s", "-screen 0 1280x800x24", blender, "--factory-startup", "-noaudio",
               "--enable-event-simulate", "--window-geometry", "0", "0", "1280", "800", "--python-exit-code", "1",
               "--python", os.path.join(os.path.dirname(os.path.abspath(__file__)), "window", steps), "--", folder, *rest]
    return subprocess.run(command, env=environment, timeout=1500).returncode


if __name__ == "__main__":
    sys.exit(main())
