# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the project's programs are, and running them without waiting. No bpy."""
import os
import shutil
import subprocess
import tempfile

from .errors import InputError

VARIABLE = "HM_TOOLS"   # a folder, where the preferences name none


def find(name, folder=""):
    """The program's path: in the folder of the preferences, in that of HM_TOOLS, or on the PATH."""
    for place in (folder, os.environ.get(VARIABLE, "")):
        if place:
            path = os.path.join(place, name + (".exe" if os.name == "nt" else ""))
            if not os.path.isfile(path):
                raise InputError(path, "", "is not there", "set the folder of the programs in the add-on's preferences")
            if not os.access(path, os.X_OK):
                raise InputError(path, "", "may not be run", "make it executable")
            return path
    found = shutil.which(name)
    if found is None:
        raise InputError("", name, "was not found", "set the folder of the programs in the add-on's preferences")
    return found


class Run:
    """One run of a program; what it says goes into files, so that it never waits for a reader."""

    def __init__(self, command):
        self._out, self._err = (tempfile.TemporaryFile(mode="w+", encoding="utf-8", errors="replace")
                                for _ in range(2))
        try:
            self._process = subprocess.Popen([str(part) for part in command], stdin=subprocess.DEVNULL,
                                             stdout=self._out, stderr=self._err)
        except OSError as error:
            raise InputError(command[0], "", "cannot be started (%s)" % error.strerror,
                             "choose the programs of this system") from None

    def is_done(self):
        return self._process.poll() is not None

    def wait(self, timeout_s=None):
        try:
            self._process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            pass
        return self.is_done()

    def cancel(self):
        """Asks the program to stop: it leaves no half output."""
        if not self.is_done():
            self._process.terminate()

    def last_words(self):
        """The last line that it wrote to stderr: progress while it runs."""
        self._err.seek(0)
        lines = self._err.read().replace("\r", "\n").split("\n")
        return next((line.strip() for line in reversed(lines) if line.strip()), "")

    def result(self):
        """Its stdout. Raises InputError with its own words if it failed."""
        if self._process.returncode != 0:
            words = self.last_words() or "it said nothing"
            if self._process.returncode < 0:
                words = "was stopped by signal %d" % -self._process.returncode
            raise InputError("", "", words)
        self._out.seek(0)
        return self._out.read()
