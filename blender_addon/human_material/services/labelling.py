# SPDX-License-Identifier: GPL-3.0-or-later
"""Classes of a scan's faces while strokes are painted: the client of `openhumanbrdf label --serve`.

A request is sent without waiting; answers come from a thread of their own, so that a window that paints never stops.
Positions are in the scan's own unit and axes, faces count from 0 in the order of its file.
"""
import json
import queue
import subprocess
import threading

from .errors import InputError

UNLABELLED = 255


class Labelling:
    """One conversation about one scan."""

    def __init__(self, program, scan, unit=None, strokes=None):
        """Starts it; the classes are there with the first answer. `strokes`: a strokes.xml to go on with."""
        command = [str(program), "label", str(scan), "--serve"]
        command += ["--unit", unit] if unit else []
        command += ["--strokes", str(strokes)] if strokes else []
        try:
            self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                             stderr=subprocess.PIPE, text=True, encoding="utf-8", errors="replace")
        except OSError as error:
            raise InputError(program, "", f"cannot be started ({error.strerror})", "name the program openhumanbrdf")
        self._answers = queue.SimpleQueue()
        self._errors = []   # what the program says on stderr
        self._next_id = 1
        self.classes, self.confidence = bytearray(), bytearray()   # of each face; confidence from 0 to 15
        self.suggested = None                                      # where a stroke helps most
        self.warnings = []
        self._threads = [threading.Thread(target=self._read, daemon=True),
                         threading.Thread(target=self._read_errors, daemon=True)]
        for thread in self._threads:
            thread.start()

    def stroke(self, class_name, radius_cm, points):
        """Paints: points are (face, x, y, z). Gives the number of the request."""
        return self._send({"do": "stroke", "class": class_name, "radius_cm": radius_cm,
                           "points": [list(point) for point in points]})

    def undo(self):
        return self._send({"do": "undo"})

    def save(self, file):
        return self._send({"do": "save", "file": str(file)})

    def answer(self, timeout_s=None):
        """The next answer, with its changes taken over; None if there is none in that time (None: waits).

        Raises InputError for a request that was refused, and if the program has ended.
        """
        try:
            line = self._answers.get(timeout=timeout_s)
        except queue.Empty:
            return None
        if line is None:
            self._answers.put(None)
            self._threads[1].join(5)
            said = self._errors[-1] if self._errors else "said nothing"
            raise InputError("", "label --serve", "has ended: " + said)
        answer = json.loads(line)
        if "error" in answer:
            raise InputError("", "", answer["error"])
        if answer.get("ready"):
            self.classes = bytearray([UNLABELLED]) * answer["faces"]
            self.confidence = bytearray(answer["faces"])
        for runs, values in (("changed", self.classes), ("confidence", self.confidence)):
            for first, count, value in answer.get(runs, ()):
                values[first:first + count] = bytes([value]) * count
        self.suggested = answer.get("suggested", self.suggested)
        self.warnings = answer.get("warnings", self.warnings)
        return answer

    def close(self):
        """Ends the program. May be called more than once."""
        if self._process.poll() is None:
            try:
                self._process.stdin.close()
                self._process.wait(5)
            except (OSError, subprocess.TimeoutExpired):
                self._process.kill()
                self._process.wait()
        for thread in self._threads:
            thread.join(5)
        for stream in (self._process.stdin, self._process.stdout, self._process.stderr):
            try:
                stream.close()
            except OSError:
                pass

    def _send(self, request):
        number = self._next_id
        self._next_id += 1
        try:
            self._process.stdin.write(json.dumps({"id": number, **request}) + "\n")
            self._process.stdin.flush()
        except (OSError, ValueError):
            raise InputError("", "label --serve", "has ended", "start it again")
        return number

    def _read(self):
        for line in self._process.stdout:
            self._answers.put(line)
        self._answers.put(None)

    def _read_errors(self):
        for line in self._process.stderr:
            self._errors.append(line.strip())
