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


class Ended(InputError):
    """The program is no longer there, or is not the one that was meant."""


class Labelling:
    """One conversation about one scan."""

    def __init__(self, program, scan, unit=None, up=None):
        """Starts it; the classes are there with the first answer. `unit`, `up`: as the options of label."""
        command = [str(program), "label", str(scan), "--serve"]
        command += ["--unit", unit] if unit else []
        command += ["--up", up] if up else []
        try:
            self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                             stderr=subprocess.PIPE, text=True, encoding="utf-8", errors="replace")
        except OSError as error:
            raise InputError(program, "", f"cannot be started ({error.strerror})", "name the program openhumanbrdf")
        self._answers, self._requests = queue.SimpleQueue(), queue.SimpleQueue()
        self._errors = []   # what the program says on stderr
        self._next_id = 1
        self.classes, self.confidence = bytearray(), bytearray()   # of each face; confidence from 0 to 15
        self.suggested = None                                      # where a stroke helps most
        self.warnings, self.questions = [], []
        self._threads = [threading.Thread(target=self._read, daemon=True),
                         threading.Thread(target=self._read_errors, daemon=True),
                         threading.Thread(target=self._write, daemon=True)]
        for thread in self._threads:
            thread.start()

    def stroke(self, class_name, radius_cm, points):
        """Paints: points are (face, x, y, z). Gives the number of the request."""
        return self._send({"do": "stroke", "class": class_name, "radius_cm": radius_cm,
                           "points": [list(point) for point in points]})

    def strokes(self, strokes):
        """These (class, radius_cm, points) instead of all so far."""
        return self._send({"do": "strokes", "strokes": strokes})

    def undo(self):
        return self._send({"do": "undo"})

    def mesh(self, folder):
        """Asks for the scan as the program has read it (scan_mesh.py reads the answer)."""
        return self._send({"do": "mesh", "folder": str(folder)})

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
            self._threads[1].join(1)
            said = self._errors[-1] if self._errors else "it said nothing"
            raise Ended("", "openhumanbrdf label", "has ended: " + said, "" if self._errors else "start it again")
        try:
            answer = json.loads(line)
            if not isinstance(answer, dict):
                raise ValueError
        except ValueError:
            raise Ended("", "openhumanbrdf label", "answers what is no answer (%.40r)" % line,
                        "choose the program of the add-on's version") from None
        if "error" in answer:
            raise InputError("", "", answer["error"])
        if answer.get("ready"):
            self.classes = bytearray([UNLABELLED]) * answer["faces"]
            self.confidence = bytearray(answer["faces"])
        for runs, values in (("changed", self.classes), ("confidence", self.confidence)):
            for first, count, value in answer.get(runs, ()):   # (face, faces, class or confidence)
                values[first:first + count] = bytes([value]) * count
        for name in ("suggested", "warnings", "questions"):
            setattr(self, name, answer.get(name, getattr(self, name)))
        return answer

    def close(self, patience_s=5):
        """Ends the program, by force where it does not end by itself in that time. May be called more than once."""
        self._requests.put(None)
        if self._process.poll() is None:
            try:
                self._process.wait(patience_s)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        for thread in self._threads:
            thread.join(5)
        for stream in (self._process.stdout, self._process.stderr):
            stream.close()

    def _send(self, request):
        number = self._next_id
        self._next_id += 1
        if self._process.poll() is not None:
            raise Ended("", "openhumanbrdf label", "has ended", "start it again")
        self._requests.put(json.dumps({"id": number, **request}) + "\n")
        return number

    def _write(self):
        """In a thread: a program that does not read would stop the writer."""
        try:
            for line in iter(self._requests.get, None):
                self._process.stdin.write(line)
                self._process.stdin.flush()
            self._process.stdin.close()
        except (OSError, ValueError):
            pass   # it has ended: answer() says so

    def _read(self):
        for line in self._process.stdout:
            self._answers.put(line)
        self._answers.put(None)

    def _read_errors(self):
        for line in self._process.stderr:
            self._errors.append(line.strip())
