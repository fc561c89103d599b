"""Runs the suite, the installation and the extension platform's own validation in other versions of Blender, as modules
of Python:

    wheels_test.py --make FOLDER 4.5.14 5.0.1     makes a virtual environment a version there (350 MB each, by pip), unless
                                                  it is there; needs the Python of those versions (4.2 to 5.0: 3.11)
    wheels_test.py PYTHON...                      runs in these

Ends with a line a version; exits with 77 and says so where one is not there. `./test --blenders 4.5.14,5.0.1` does both.
"""
import os
import runpy
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
SUITE = ("test_import", "test_material", "test_light", "test_edit", "test_bad_input", "test_guest", "test_garments",
         "test_studio", "test_files", "test_label_faults", "test_label", "test_tools")
VALIDATOR = "import bpy, os; print(os.path.join(bpy.utils.system_resource('SCRIPTS'), " \
            "'addons_core', 'bl_pkg', 'cli', 'blender_ext.py'))"


def make(folder, versions):
    """Whether all are there. One that could not be installed leaves nothing."""
    failed = []
    for version in versions:
        home = os.path.join(folder, "bpy-" + version)
        python = os.path.join(home, "bin", "python")
        if not os.path.exists(python):
            commands = ([sys.executable, "-m", "venv", home],
                        [os.path.join(home, "bin", "pip"), "install", "-q", "bpy==" + version])
            if any(subprocess.run(command).returncode != 0 for command in commands):
                shutil.rmtree(home, ignore_errors=True)
                failed.append(version)
                continue
        print(python)
    if failed:
        print("could not be installed: Blender %s" % ", ".join(failed))
    return int(bool(failed))


def environment_of(folder):
    return dict(os.environ, BLENDER_USER_RESOURCES=folder, BLENDER_USER_CONFIG=os.path.join(folder, "config"),
                BLENDER_USER_SCRIPTS=os.path.join(folder, "scripts"),
                BLENDER_USER_EXTENSIONS=os.path.join(folder, "extensions"))


def validate(python, folder):
    """The platform's own words, or None where this version has no extensions."""
    found = subprocess.run([python, "-c", VALIDATOR], capture_output=True, text=True).stdout.split()
    if not found or not os.path.exists(found[-1]):
        return None
    archive = os.path.join(folder, "human_material.zip")
    build = os.path.join(os.path.dirname(os.path.dirname(HERE)), "blender_addon", "tools", "build_zip.py")
    runpy.run_path(build)["build"](archive)
    done = subprocess.run([python, found[-1], "validate", archive], capture_output=True, text=True)
    return (done.stdout + done.stderr).strip() if done.returncode == 0 else "INVALID: " + done.stdout + done.stderr


def test(python):
    """A line of words, and whether all is well."""
    with tempfile.TemporaryDirectory(prefix="hm") as folder:
        words, is_good = [], True
        for modules in (SUITE, ("test_registration",)):
            for name in ("config", "scripts", "extensions"):
                os.makedirs(os.path.join(folder, name), exist_ok=True)
            done = subprocess.run([python, os.path.join(HERE, "blender", "run.py"), *modules], capture_output=True,
                                  text=True, env=environment_of(folder))
            lines = done.stdout.strip().splitlines()
            words.append(lines[-1] if lines else "nothing ran: " + done.stderr[-300:])
            if done.returncode != 0:
                is_good = False
                print(done.stdout[-8000:] + done.stderr[-2000:])
        found = validate(python, folder)
        words.append("no extensions" if found is None else found.replace(folder, ""))
        return "; ".join(words), is_good and not (found or "").startswith("INVALID")


def main(arguments):
    if arguments[:1] == ["--make"]:
        return make(arguments[1], arguments[2:])
    missing = [python for python in arguments if not os.path.exists(python)]
    if missing or not arguments:
        print("skipped: %s is not there; ./test --blenders VERSION,... installs other Blenders"
              % (", ".join(missing) or "any Python"))
        return 77
    results = [(python, *test(python)) for python in arguments]
    for python, words, _ in results:
        print("%s: %s" % (python, words))
    return int(not all(is_good for _, _, is_good in results))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
