"""labelling.py against a stand-in for the program: a script that speaks the same lines."""
import os
import stat
import sys
import tempfile
import unittest

import support  # noqa: F401
from human_material.services.errors import InputError
from human_material.services.labelling import Labelling

PROGRAM = """#!{python}
import json, sys
if "bad.obj" in sys.argv[2]:
    print("bad.obj: no such file; check the path", file=sys.stderr)
    sys.exit(2)
assert sys.argv[1] == "label" and sys.argv[3:] == ["--serve", "--unit", "cm"], sys.argv
say = lambda answer: print(json.dumps(answer), flush=True)
say({{"ready": True, "faces": 10, "changed": [[0, 6, 2], [6, 4, 0]], "confidence": [[0, 10, 15]], "suggested": None,
     "warnings": []}})
for line in sys.stdin:
    request = json.loads(line)
    if request["do"] == "stroke" and request["points"]:
        say({{"id": request["id"], "changed": [[request["points"][0][0], 2, 3]], "confidence": [[1, 1, 4]],
             "suggested": {{"face": 1}}, "warnings": ["w"]}})
    else:
        say({{"id": request["id"], "error": "request: has no point; give one or more"}})
"""


class LabellingClient(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.program = os.path.join(folder.name, "program")
        with open(self.program, "w", encoding="utf-8") as file:
            file.write(PROGRAM.format(python=sys.executable))
        os.chmod(self.program, os.stat(self.program).st_mode | stat.S_IXUSR)

    def start(self, scan="a.obj"):
        talk = Labelling(self.program, scan, unit="cm")
        self.addCleanup(talk.close)
        return talk

    def test_takes_over_what_strokes_change(self):
        talk = self.start()
        self.assertTrue(talk.answer(20)["ready"])
        self.assertEqual(list(talk.classes), [2] * 6 + [0] * 4)
        number = talk.stroke("leather", 1.5, [(1, 0, 0, 0)])
        self.assertEqual(talk.answer(20)["id"], number)
        self.assertEqual(list(talk.classes), [2, 3, 3, 2, 2, 2, 0, 0, 0, 0])
        self.assertEqual(list(talk.confidence), [15, 4] + [15] * 8)
        self.assertEqual((talk.suggested, talk.warnings), ({"face": 1}, ["w"]))
        self.assertIsNone(talk.answer(0.05))

    def test_a_refused_stroke_is_told_and_changes_nothing(self):
        talk = self.start()
        talk.answer(20)
        before = bytes(talk.classes)
        talk.stroke("leather", 1.5, [])
        with self.assertRaisesRegex(InputError, "has no point; give one"):
            talk.answer(20)
        self.assertEqual(bytes(talk.classes), before)

    def test_the_programs_own_words_are_kept_when_it_ends(self):
        talk = self.start("bad.obj")
        for _ in range(2):
            with self.assertRaisesRegex(InputError, "no such file; check the path"):
                talk.answer(20)

    def test_a_program_that_is_not_there(self):
        with self.assertRaisesRegex(InputError, "cannot be started"):
            Labelling(self.program + "x", "a.obj")


if __name__ == "__main__":
    unittest.main()
