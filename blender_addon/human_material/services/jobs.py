# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs that work beside the artist, one of a kind at a time. No bpy."""
import shutil

from . import programs

running = []   # jobs, in the order of their start


class Job:
    """A run of a program for the panel of its kind ("label", "bake", "produce", "validate").

    finish(stdout): takes the result over and says what was done; called by whoever finds the job done.
    accepted: exit codes that bring a result. scratch: a folder that goes with the job.
    """

    def __init__(self, kind, title, command, finish, accepted=(0,), scratch=""):
        self.kind, self.title, self.scratch = kind, title, scratch
        self._finish, self._accepted, self._is_cancelled = finish, accepted, False
        try:
            self._run = programs.Run(command)
        except Exception:
            self._clean()
            raise

    def is_done(self):
        return self._run.is_done()

    def wait(self):
        self._run.wait()

    def words(self):
        """Its last line, without the bar that the panel draws itself."""
        words = self._run.last_words()
        return self.title + ": " + (words.partition("%")[2].strip() if self.share() is not None else words)

    def share(self):
        return self._run.share()

    def cancel(self):
        self._is_cancelled = True
        self._run.cancel()

    def end(self):
        """What was done, in words. Raises InputError with the program's own."""
        try:
            if self._is_cancelled:
                return self.title + ": cancelled"
            return self._finish(self._run.result(self._accepted))
        finally:
            self._clean()

    def _clean(self):
        if self.scratch:
            shutil.rmtree(self.scratch, ignore_errors=True)


def of(kind):
    """The job of that kind that runs, or None."""
    return next((job for job in running if job.kind == kind), None)
