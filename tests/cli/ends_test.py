"""How commands end before their time: by a signal at any moment, or for want of memory.

usage: ends_test.py OPENHUMANBRDF [HUMANMATERIAL] [unittest's arguments]
OHB_ENDS=N in the environment: N signals and N limits of memory for each command (default 1 and 4, and no
limits for humanmaterial's).
"""
import os
import random
import re
import resource
import signal
import subprocess
import time
import unittest
import uuid

from support import BUG, DONE, TRY_AGAIN, Fixture, Programs, run

MANY = int(os.environ.get("OHB_ENDS", "0"))
SECONDS_TO_END = 12     # train's grace is the longest; most end in one
MEBIBYTE = 1 << 20


def catches_sigterm(process):
    try:
        with open("/proc/%d/status" % process.pid) as status:
            caught = next(line for line in status if line.startswith("SigCgt"))
        return bool(int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1)
    except (OSError, StopIteration):
        return False


def processes_with(mark):
    """Living processes whose environment has the mark."""
    found = []
    for entry in os.listdir("/proc"):
        if not entry.isdigit():
            continue
        try:
            with open("/proc/%s/environ" % entry, "rb") as file:
                if mark.encode() in file.read():
                    found.append(entry)
        except OSError:
            pass
    return found


class Ends(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.fixture = Fixture()
        cls.random = random.Random(int(os.environ.get("OHB_SEED", "1")))

    @classmethod
    def tearDownClass(cls):
        cls.fixture.remove()

    def place(self):
        """A new folder to write into, and one for temporary files."""
        place = self.fixture.folder / uuid.uuid4().hex
        (place / "tmp").mkdir(parents=True)
        return place

    def expect_clean(self, place, what):
        names = sorted(p.name for p in place.rglob("*") if ".tmp" in p.name or ".old" in p.name)
        self.assertEqual(names, [], what)
        self.assertEqual(list((place / "tmp").iterdir()), [], what)
        self.assertLessEqual({p.name for p in place.iterdir()}, {"tmp", "out", "out.png"}, what)

    def stop(self, name, words, place, delay, number):
        mark = "OHB_MARK=" + uuid.uuid4().hex
        environment = {**os.environ, "TMPDIR": str(place / "tmp"), "OHB_MARK": mark.split("=")[1]}
        process = subprocess.Popen(Programs.command(words), stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True, env=environment)
        deadline = time.monotonic() + 60
        while process.poll() is None and not catches_sigterm(process) and time.monotonic() < deadline:
            time.sleep(0.001)
        time.sleep(delay)
        started = time.monotonic()
        process.send_signal(number)
        try:
            process.wait(timeout=60)
        finally:
            process.kill()
        seconds = time.monotonic() - started
        stderr = process.stderr.read()
        process.stdin.close()
        process.stderr.close()
        what = "%s after %.2f s: %s" % (name, delay, stderr)
        # Who was done before the signal is done; an exception while it ended is no other result.
        self.assertIn(process.returncode, (TRY_AGAIN, DONE), what)
        if process.returncode == TRY_AGAIN:
            self.assertIn("stopped by a signal", stderr, what)
        self.assertLess(seconds, SECONDS_TO_END, what)
        time.sleep(0.05)
        self.assertEqual(processes_with(mark), [], what)
        self.expect_clean(place, what)
        return process.returncode

    def test_a_signal_ends_every_command_in_seconds(self):
        stopped = {}
        for _ in range(max(1, MANY)):
            place = self.place()
            for name, words in self.fixture.commands(place / "out", heavy=True).items():
                with self.subTest(name):
                    place = self.place()
                    words = self.fixture.commands(place / "out", heavy=True)[name]
                    delay = self.random.uniform(0, 2.5)
                    code = self.stop(name, words, place, delay, self.random.choice((signal.SIGTERM, signal.SIGINT)))
                    stopped[name] = stopped.get(name, 0) + (code == TRY_AGAIN)
        # Of commands that are long enough.
        for name in ("render", "validate", "label serve", "chart speed-accuracy"):
            self.assertGreater(stopped[name], 0, name)

    def test_a_second_signal_ends_at_once(self):
        words = ["openhumanbrdf", "label", self.fixture.scan, "--serve"]
        process = subprocess.Popen(Programs.command(words), stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        process.stdout.readline()
        started = time.monotonic()
        process.send_signal(signal.SIGTERM)
        time.sleep(0.1)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(timeout=10), TRY_AGAIN)
        self.assertLess(time.monotonic() - started, 0.8)
        process.stdin.close()
        process.stdout.close()

    def test_no_memory_is_told_in_words(self):
        count = max(2, MANY)
        seen = {}
        for name, words in self.fixture.commands(self.place() / "out", heavy=False).items():
            lowest, highest = (40, 700) if words[0] == "openhumanbrdf" else (200, 1600)
            if words[0] != "openhumanbrdf" and not MANY:
                continue        # each takes seconds to load its libraries
            for i in range(count):
                limit = lowest + (highest - lowest) * (i + self.random.random()) / count
                with self.subTest(name, limit=limit):
                    place = self.place()
                    words = self.fixture.commands(place / "out", heavy=False)[name]
                    result = run(words, memory_limit=int(limit) * MEBIBYTE,
                                 env={**os.environ, "TMPDIR": str(place / "tmp")})
                    what = "%s with %d MiB: %d, %s" % (name, limit, result.returncode, result.stderr)
                    seen[result.returncode] = seen.get(result.returncode, 0) + 1
                    if result.returncode == 127 and re.search("shared librar|TLS data", result.stderr):
                        continue        # the system's loader, before there is a program
                    self.assertIn(result.returncode, (DONE, 1, 3, TRY_AGAIN), what)
                    if result.returncode == TRY_AGAIN:
                        self.assertIn("memory", result.stderr, what)
                    self.expect_clean(place, what)
        self.assertGreater(seen.get(TRY_AGAIN, 0), 0, seen)
        self.assertNotIn(BUG, seen)


if __name__ == "__main__":
    Programs.take_arguments()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    unittest.main(verbosity=2)
