"""A stand-in for `openhumanbrdf` that goes wrong in one way; a scan of two faces."""
import os
import stat
import sys

SCRIPT = """#!{python}
import json, os, struct, sys, time
fault = {fault!r}
def say(answer):
    print(json.dumps(answer), flush=True)
def die(words="", code=2):
    print(words, file=sys.stderr, flush=True)
    sys.exit(code)
if "-o" in sys.argv:
    die("regions: cannot be written; choose another folder") if fault == "save" else time.sleep(600)
if fault == "start":
    die("scan.obj: line 3: index out of range; export it again")
if fault == "hang":
    time.sleep(600)
if fault == "words":
    print("openhumanbrdf 9.9", flush=True); sys.stdin.read()
if fault == "other":
    say({{"version": 2}}); sys.stdin.read()
say({{"ready": True, "faces": 2, "unit_cm": 1, "classes": ["skin", "hair", "fabric", "leather"], "strokes": 0,
     "changed": [[0, 2, 2]], "confidence": [[0, 2, 9]], "suggested": None, "questions": [], "warnings": []}})
for line in sys.stdin:
    request = json.loads(line)
    if request["do"] == "mesh":
        if fault == "old":
            say({{"id": request["id"], "error": 'request: "mesh" is not known; use stroke'}})
            continue
        path = os.path.join(request["folder"], "mesh.bin")
        with open(path, "wb") as file:
            file.write(struct.pack("<12f", 0, 0, 0, 10, 0, 0, 10, 170, 0, 0, 170, 0))
            file.write(struct.pack("<3I6I", 0, 3, 6, 0, 1, 2, 0, 2, 3))
            file.write(struct.pack("<12f2H2H", *[0.5] * 12, 0, 0, 0, 0)[:10 if fault == "short" else None])
        say({{"id": request["id"], "file": path, "positions": 4, "faces": 2, "corners": 6, "groups": ["a"],
             "materials": [{{"name": "m", "picture": "", "color": [1, 1, 1]}}],
             "scan_sha256": open(sys.argv[2]).read().strip()}})
    elif fault == "crash":
        os.abort()
    elif fault == "hang later":
        time.sleep(600)
    elif fault == "garbage":
        print("[1, 2", flush=True)
    elif fault == "half":
        say({{"id": request["id"], "changed": [[0, 1]]}})
    elif fault == "refuse":
        say({{"id": request["id"], "error": "request: a point is 9.0 cm away from its face 0; is this the scan?"}})
    else:
        say({{"id": request["id"], "strokes": 1, "changed": [[0, 1, 3]], "confidence": [[0, 1, 15]],
             "suggested": None, "questions": [], "warnings": [], "seconds": 0.0}})
"""


def write(folder, fault=""):
    """Writes the program `openhumanbrdf` into the folder; gives its path."""
    return write_script(folder, SCRIPT, fault=fault)


def write_script(folder, script, **values):
    path = os.path.join(folder, "openhumanbrdf")
    with open(path, "w", encoding="utf-8") as file:
        file.write(script.format(python=sys.executable if "blender" not in sys.executable else "/usr/bin/env python3",
                                 **values))
    os.chmod(path, os.stat(path).st_mode | stat.S_IXUSR)
    return path
