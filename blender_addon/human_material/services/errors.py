# SPDX-License-Identifier: GPL-3.0-or-later
"""The one kind of error for bad input: a line that says where, what and how to mend it."""


class InputError(Exception):
    """Bad input of the user. Its text is one line: file: place: cause; mend."""

    def __init__(self, file, place, cause, mend=""):
        parts = [str(part) for part in (file, place, cause) if part]
        line = ": ".join(parts) + ("; " + mend if mend else "")
        super().__init__(line.replace("\n", " ").replace("\r", " "))
