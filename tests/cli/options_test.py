"""Every option of --help: numbers outside their range are refused by name, help fits 80 columns, examples can be pasted,
misspelt words are guessed.

usage: options_test.py OPENHUMANBRDF [HUMANMATERIAL] [unittest's arguments]
OHB_ENDS=1 in the environment: every bad number for every option (minutes), not one for every fifth.
"""
import functools
import os
import re
import shlex
import unittest

from support import BAD_INPUT, DONE, Programs, run

NUMBER = re.compile(r"^  (?:-\w,)?(--[\w-]+) (INT|UINT|FLOAT)(?::(\S+?)\.\.([^\s=]+))?", re.MULTILINE)
BAD_NUMBERS = ["nan", "-nan", "inf", "-inf", "1e999", "-1e999", "1e-999", "1e300", "-1e300", "1e-300", "-1e-300", "x", "",
               " ", "1x", "0x10", "99999999999999999999999", "-99999999999999999999999", "1,5", "--"]
# The range in the help is written by the check itself, so that an option that shows one has it: a few options tried tell
# that this holds, and tests/dataset/program_test.cpp tries the numbers on the check.
EVERY_NUMBER = bool(os.environ.get("OHB_ENDS"))


@functools.lru_cache(None)
def result_of_help(program, *command):
    return run([program, *command, "--help"])


@functools.lru_cache(None)
def all_commands(program=None, command=()):
    """Each program and command that help names, with what is below it."""
    if program is None:
        return sum((all_commands(name) for name in ["openhumanbrdf"] + ["humanmaterial"] * bool(Programs.learner)), [])
    below = result_of_help(program, *command).stdout.partition("Subcommands:\n")[2].partition("\n\n")[0]
    return sum((all_commands(program, (*command, name)) for name in re.findall(r"^  (\w\S*)", below, re.MULTILINE)),
               [(program, command)])


class Options(unittest.TestCase):
    def help_of(self, program, command):
        result = result_of_help(program, *command)
        self.assertEqual(result.returncode, DONE, result.stderr)
        return result.stdout

    def test_help_fits_80_columns(self):
        for program, command in all_commands():
            for line in self.help_of(program, command).splitlines():
                self.assertLessEqual(len(line), 80, "%s %s: %s" % (program, command, line))

    def test_examples_can_be_pasted(self):
        """The shell's words of an example are a command line that the program parses: it fails at its missing files."""
        count = 0
        for program, command in all_commands():
            text = self.help_of(program, command)
            if "Examples:\n" not in text:
                self.fail("%s %s has no examples" % (program, command))
            examples = text.split("Examples:\n")[1].replace("\\\n", " ")
            for line in examples.splitlines():
                if not line.startswith("  " + program) or "--help" in line:
                    continue
                count += 1
                words = shlex.split(line)
                result = run([*words, "--threads", "4097"])    # the one thing that is wrong with it
                self.assertEqual(result.returncode, BAD_INPUT, line)
                self.assertIn("--threads: '4097'", result.stderr, line)
        self.assertGreater(count, 15)

    def test_numbers_outside_their_range_are_refused_by_name(self):
        options = 0
        for program, command in all_commands():
            for option, kind, low, high in NUMBER.findall(self.help_of(program, command)):
                what = " ".join([program, *command, option])
                if re.search(re.escape(option) + r" INT:\{", self.help_of(program, command)):
                    continue    # one of a few, which the parser lists
                self.assertNotEqual(low, "", what + " states no range")
                if not EVERY_NUMBER and option in ("--threads", "--seed") and command != ["render"]:
                    continue    # one function adds them to every command
                bad = [*BAD_NUMBERS, "%g" % (float(low) / 2 if kind == "FLOAT" else float(low) - 1), "%.17g" % (2 * float(high) + 1)]
                bad = [value for value in bad if not self.is_within(value, float(low), float(high), kind)]
                if not EVERY_NUMBER:
                    bad = [("nan", bad[-2], bad[-1])[options % 3]] if options % 5 == 0 else []
                options += 1
                for value in bad:
                    result = run([program, *command, "%s=%s" % (option, value)] if value else [program, *command, option, ""])
                    self.assertEqual(result.returncode, BAD_INPUT, "%s=%s: %s" % (what, value, result.stderr))
                    self.assertIn(option, result.stderr, "%s=%s" % (what, value))
                    self.assertIn("from %s to %s" % (low, high), result.stderr, "%s=%s" % (what, value))
                    self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertGreater(options, 40)

    @staticmethod
    def is_within(value, low, high, kind):
        try:
            number = float(value) if kind == "FLOAT" else int(value)
        except ValueError:
            return False
        return low <= number <= high and not ("e-999" in value)

    def test_misspelt_words_are_guessed(self):
        cases = [("openhumanbrdf", "rendre x", "'render'"), ("openhumanbrdf", "lable x", "'label'"),
                 ("openhumanbrdf", "chart stres", "'stress'"), ("openhumanbrdf", "--versoin", "'--version'"),
                 ("openhumanbrdf", "render model --enviroment e.exr -o out", "'--environment'"),
                 ("openhumanbrdf", "validate model --enviroment=e.exr -o out", "'--environment'"),
                 ("openhumanbrdf", "bake scan.obj --region r -o out", "'--regions'")]
        if Programs.learner:
            cases += [("humanmaterial", "estimat p.png", "'estimate'"), ("humanmaterial", "evalute x", "'evaluate'"),
                      ("humanmaterial", "train rss --data d -o o --wramup 3", "'--warmup'")]
        for program, line, meant in cases:
            result = run([program, *line.split()])
            self.assertEqual(result.returncode, BAD_INPUT, line)
            self.assertIn("did you mean " + meant, result.stderr, line)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        result = run(["openhumanbrdf", "cook"])
        self.assertEqual(result.returncode, BAD_INPUT)
        self.assertNotIn("did you mean", result.stderr)

    def test_one_value_is_not_chosen_from_two(self):
        cases = [("openhumanbrdf", "render model --spp 4 --spp 8 --spp=2 -o out", "--spp is given 3 times: give it once")]
        if Programs.learner:
            cases.append(("humanmaterial", "train rss --width 1 --width 2 --data d -o o", "--width is given 2 times: give it once"))
        for program, line, words in cases:
            result = run([program, *line.split()])
            self.assertEqual(result.returncode, BAD_INPUT, line)
            self.assertIn(words, result.stderr, line)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)

    def test_an_empty_word_is_not_taken_for_none(self):
        """As `--faces "$FACES"` gives, where FACES is not set."""
        cases = [("openhumanbrdf", "label scan.obj --faces @ -o out", "--faces"), ("openhumanbrdf", "inspect @", "SCAN"),
                 ("openhumanbrdf", "render model --environment @ -o out", "--environment")]
        if Programs.learner:
            cases += [("humanmaterial", "estimate photo.png --mask @ --weights w -o out", "--mask"),
                      ("humanmaterial", "evaluate w --data d -o @", "--output"),
                      ("humanmaterial", "train rss --data d --from @ -o out", "--from")]
        for program, line, name in cases:
            result = run([program, *(word.replace("@", "") for word in line.split())])
            self.assertEqual(result.returncode, BAD_INPUT, line)
            self.assertIn(name + " is empty", result.stderr, line)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)

    def test_lists_of_views_and_points(self):
        for option, value, *words in (("--views", "100:0,0", "view 0 twice"), ("--views", "4:4", "0 <= i < N"),
                                      ("--views", "99999999999", "is not a list"), ("--views", "nan", "is not a list"),
                                      ("--views", "4:", "is not a list"), ("--views", "", "is empty"),
                                      ("--point", "0,0,0,nan", "point light"), ("--point", "1e999,0,0,1", "point light"),
                                      ("--point", "0,0,0,-1", "point light"), ("--point", "0,0,0,inf", "point light")):
            result = run(["openhumanbrdf", "render", "model", option, value, "-o", "/nowhere/x"])
            self.assertEqual(result.returncode, BAD_INPUT, value)
            for word in (option, *words):
                self.assertIn(word, result.stderr, value)


if __name__ == "__main__":
    Programs.take_arguments()
    unittest.main(verbosity=2)
