# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the project's programs are, and running them without waiting. No bpy."""
import os
import re
import shutil
import subprocess
import tempfile
import threading

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


KEPT = 1 << 16   # of what a program says


class Run:
    """One run of a program. Its stdout goes into a file, its stderr to a thread, so that it never waits for a reader.

    Where there are terminals (not on Windows) stderr is one: only there do the programs draw their progress.
    """

    def __init__(self, command):
        self._out = tempfile.TemporaryFile(mode="w+", encoding="utf-8", errors="replace")
        self._said, self._name = b"", os.path.basename(str(command[0]))
        listening, saying = os.openpty() if hasattr(os, "openpty") else os.pipe()
        try:
            self._process = subprocess.Popen([str(part) for part in command], stdin=subprocess.DEVNULL,
                                             stdout=self._out, stderr=saying)
        except OSError as error:
            os.close(listening)
            raise InputError(command[0], "", "cannot be started (%s)" % error.strerror,
                             "choose the programs of this system") from None
        finally:
            os.close(saying)
        self._listener = threading.Thread(target=self._listen, args=(listening,), daemon=True)
        self._listener.start()

    def _listen(self, source):
        try:
            while part := os.read(source, 4096):
                self._said = (self._said + part)[-KEPT:]
        except OSError:   # a terminal that nobody writes to any more
            pass
        os.close(source)

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
        lines = self._said.decode("utf-8", "replace").replace("\r", "\n").split("\n")
        return next((line.strip() for line in reversed(lines) if line.strip()), "")

    def share(self):
        """How much of the work is done, 0 to 1, by the bar that it draws; None where it draws none."""
        found = re.search(r"\[[#.]+\]\s+(\d+) %", self.last_words())
        return int(found.group(1)) / 100 if found else None

    def result(self, accepted=(0,)):
        """Its stdout. Raises InputError with its own words if it ended with another code than those accepted."""
        self._listener.join(1)
        if self._process.returncode not in accepted:
            words = self.last_words()
            if self._process.returncode < 0:
                words = "%s was stopped by signal %d" % (self._name, -self._process.returncode)
            raise InputError("", "", words or "%s ended with code %d and said nothing"
                             % (self._name, self._process.returncode))
        self._out.seek(0)
        return self._out.read()
