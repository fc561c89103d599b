"""`submit`: on a real Slurm of one node, which the test starts and stops itself, and against commands that only look like
Slurm's.

usage: slurm_test.py OPENHUMANBRDF [HUMANMATERIAL] [unittest's arguments]
"""
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import slurm_cluster
from dataset_support import BAD_INPUT, DONE, PROGRAM, TRY_AGAIN, Production, tree

LEARNER = os.path.abspath(sys.argv.pop(1)) if sys.argv[1:2] and sys.argv[1].endswith("humanmaterial") else None


def process_with(*wanted):
    """The process whose command line has these words, one after the other."""
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = entry.read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        if any(tuple(words[i:i + len(wanted)]) == wanted for i in range(len(words))):
            return int(entry.parent.name)
    raise AssertionError("no process has " + " ".join(wanted))


class Submissions(Production):
    environment = None

    def setUp(self):
        super().setUp()
        # A fourth person, like the third.
        shutil.copytree(self.folder / "people/c", self.folder / "people/d")
        for file in (self.folder / "people/d").glob("c_scan*"):
            file.rename(file.with_name(file.name.replace("c_scan", "d_scan")))

    def ohb(self, *words, code=DONE):
        result = subprocess.run([PROGRAM, *map(str, words)], env=self.environment, stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=100)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        self.stderr = result.stderr
        return result.stdout

    def submit(self, *more, code=DONE, out=None):
        return self.ohb("submit", self.plan, "-o", out or self.out, "--threads", 1, *more, code=code)


@unittest.skipIf(slurm_cluster.missing(), slurm_cluster.missing())
class RealSlurm(Submissions):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.mkdtemp(prefix="ohb-slurm-")
        cls.addClassCleanup(shutil.rmtree, folder, True)
        cls.cluster = slurm_cluster.Cluster(folder)
        cls.addClassCleanup(cls.cluster.stop)
        cls.cluster.start()
        cls.environment = cls.cluster.environment

    def setUp(self):
        super().setUp()
        self.out = self.folder / "my 'data' $(x) å"

    def state(self, task):
        """As Slurm names it."""
        return self.cluster.run("squeue", "-h", "-r", "-t", "all", "-j", "%s_%d" % (self.job, task), "-o", "%T").stdout.strip()

    def array(self):
        return json.loads(self.ohb("status", self.out, "--json"))["array"]

    def log(self, task):
        return (self.out / (".ohb/slurm/logs/%s_%d.txt" % (self.job, task))).read_text()

    def wait_for_end(self, seconds=120):
        end = time.monotonic() + seconds
        while True:
            array = self.array()
            if array["pending"] + array["running"] == 0:
                return array
            self.assertLess(time.monotonic(), end, self.cluster.run("squeue", "-r", "-t", "all").stdout)
            time.sleep(0.5)

    def test_an_array_with_a_task_killed_and_one_out_of_time(self):
        self.write_plan(views=4, size=96, spp=64)
        self.produce("--workers", 2, out=self.folder / "whole")
        self.job = json.loads(self.submit("--json"))["job"]
        self.wait_for(lambda: self.our_workers("b"))
        self.kill(process_with("--shard", "2/4"))
        self.wait_for(lambda: self.our_workers("c"))
        self.cluster.run("scancel", "--signal=TERM", "--batch", self.job + "_3")  # as before the end of its time
        self.submit(code=TRY_AGAIN)
        self.assertIn("array %s is not over" % self.job, self.one_line())
        self.cluster.wait_for(lambda: self.state(2) == "FAILED", "the end of the task that was killed")
        self.assertEqual(self.array()["failed"], [{"task": 2, "state": "FAILED"}])
        self.assertIn("task 2: FAILED: .ohb/slurm/logs/%s_2.txt" % self.job, self.ohb("status", self.out))
        self.assertEqual(self.cluster.run("scontrol", "requeue", self.job + "_2").stdout, "")
        array = self.wait_for_end()
        self.assertEqual((array["tasks"], array["done"], array["failed"]), (4, 4, []), self.log(2) + self.log(3))
        self.assertIn("stopped by a signal", self.log(3))
        self.assertIn("1 people, 4 sets", self.log(3))      # the second time
        self.assertEqual(tree(self.out), tree(self.folder / "whole"))

    def test_a_cancelled_task_stays_so_until_the_next_submission(self):
        self.write_plan(views=1, size=128, spp=256)
        self.job = json.loads(self.submit("--tasks", 2, "--json"))["job"]
        self.wait_for(lambda: self.our_workers())
        self.cluster.run("scancel", self.job)
        array = self.wait_for_end()
        self.assertEqual({task["state"] for task in array["failed"]}, {"CANCELLED"})
        self.write_plan(views=1)
        self.job = json.loads(self.submit("--json"))["job"]
        self.assertEqual(self.wait_for_end()["done"], 4)
        self.assertEqual(self.produce()["there"], 4)

    @unittest.skipUnless(LEARNER, "humanmaterial was not built")
    def test_four_ranks_train_one_network(self):
        """As docs/commands/train.md says; one process alone with the same batch comes to the same loss."""
        self.produce(out=self.folder / "data")
        training = ("train", "geometry", "--data", self.folder / "data", "--size", 16, "--width", 0.125, "--batch", 4, "--threads", 1,
                    "--steps", 2, "--log-every", 1, "-o")
        command = " ".join(map(shlex.quote, map(str, (LEARNER, *training, self.folder / "ranks"))))
        port = slurm_cluster.free_ports(1)[0]
        result = self.cluster.run("srun", "--ntasks", "4", "bash", "-c", "RANK=$SLURM_PROCID WORLD_SIZE=$SLURM_NTASKS "
                                  "MASTER_ADDR=127.0.0.1 MASTER_PORT=%d GLOO_SOCKET_IFNAME=lo %s" % (port, command))
        if "cannot do" in result.stdout:
            self.skipTest("built without Gloo")
        self.assertEqual(result.returncode, DONE, result.stdout)
        alone = subprocess.run([LEARNER, *map(str, training), str(self.folder / "alone")], stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True, timeout=100)
        self.assertEqual(alone.returncode, DONE, alone.stdout)
        logs = [map(json.loads, (self.folder / run / "log.jsonl").read_text().splitlines()) for run in ("ranks", "alone")]
        losses = [[event["loss"] for event in log if "loss" in event] for log in logs]
        self.assertEqual(len(losses[0]), 2)
        for with_ranks, without in zip(*losses):
            self.assertAlmostEqual(with_ranks / without, 1, delta=1e-5)

    def test_what_the_cluster_refuses(self):
        self.submit("--tasks", 5, code=BAD_INPUT)
        self.assertIn("takes 4 in one array", self.one_line())
        self.submit("--partition", "nowhere", code=BAD_INPUT)
        self.assertIn("Invalid partition", self.one_line())
        self.submit("--sbatch", "mem=900G", code=BAD_INPUT)
        self.one_line()
        self.assertFalse(self.out.exists())


class LikeSlurm(Submissions):
    """Commands of the names of Slurm's, which do as the test says."""

    def setUp(self):
        super().setUp()
        self.commands = self.folder / "bin"
        self.commands.mkdir()
        self.environment = {**os.environ, "PATH": str(self.commands)}

    def command_named(self, name, text):
        file = self.commands / name
        file.write_text("#!/bin/sh\n" + text)
        file.chmod(0o755)

    def test_no_slurm_here(self):
        self.submit(code=BAD_INPUT)
        self.assertIn("sbatch: cannot be started", self.one_line())
        self.assertFalse(self.out.exists())

    def test_the_cluster_says_no_or_nothing(self):
        for words, code in (("Batch job submission failed: Invalid account", BAD_INPUT), ("Socket timed out", TRY_AGAIN),
                            ("Unable to contact slurm controller (connect failure)", TRY_AGAIN)):
            self.command_named("sbatch", "echo 'sbatch: error: %s' >&2; exit 1\n" % words)
            self.submit(code=code)
            self.assertIn(words, self.one_line())
            self.assertFalse(self.out.exists())

    def test_what_is_written_down(self):
        self.command_named("sbatch", 'echo "site: welcome"; case "$*" in *--parsable*) echo "12;lab";; esac\n')
        self.command_named("squeue", "echo '1|RUNNING|None'; echo '2|PENDING|Resources'; echo '3|CANCELLED|None'\n")
        self.assertIn("array 12 queued: 4 tasks for 4 people", self.submit())
        self.assertIn("array 12 of 4 tasks: 1 pending (Resources), 1 running, 0 done, 1 failed, 1 over",
                      self.ohb("status", self.out))
        self.command_named("sacct", "echo '12_4|COMPLETED'; echo '12_3|CANCELLED by 0'; echo '12_[5-9]|PENDING'\n")
        self.assertIn("1 done, 1 failed\n", self.ohb("status", self.out))
        (self.commands / "squeue").unlink()
        self.assertIn("does not answer", self.ohb("status", self.out))
        (self.out / ".ohb/slurm/array.json").write_text('{"job": "1; rm", "tasks": 1}')
        self.ohb("status", self.out, code=BAD_INPUT)
        self.assertIn("array.json", self.one_line())

    def test_options_that_the_script_cannot_hold(self):
        bad = {"--time": ["", "x", "5", "9:59", "1:2:3:4", "10\n#SBATCH --uid=0", "-5", "1-", "1--2", "9999999999999999"],
               "--partition": ["a b", "-x", "a\n", "$(x)", "a#b"],
               "--sbatch": ["--account=x", "account=a b", "account='x'", "array=1-9", "chdir=/", "mem=$X", "Mem=1", "a=1\n",
                            "no-requeue"],
               "--tasks": ["0", "1001", "x"], "--at-once": ["0", "x"]}
        for option, values in bad.items():
            for value in values:
                if option == "--time" and value == "":
                    continue
                self.submit("--dry-run", "%s=%s" % (option, value), code=BAD_INPUT)
                self.assertIn(option, self.stderr, repr(value))
        self.ohb("submit", self.plan, "-o", "", "--dry-run", code=BAD_INPUT)
        self.assertIn("is empty", self.one_line())
        for sign in "%", "\\":
            self.submit("--dry-run", code=BAD_INPUT, out=self.folder / ("a" + sign))
            self.assertIn("sign in its path", self.one_line())
        script = self.submit("--dry-run", "--time", "2-12", "--partition", "cpu,gpu", "--sbatch", "account=lab", "--sbatch",
                             "exclusive", "--at-once", 2, "--tasks", 3)
        for line in ("--time=2-12", "--partition=cpu,gpu", "--account=lab", "--exclusive", "--array=1-3%2", "--cpus-per-task=1"):
            self.assertIn("#SBATCH %s\n" % line, script)
        self.assertFalse(self.out.exists())

    def test_the_script_by_hand(self):
        odd = self.folder / "o'd $(touch pwned) \"x\"; #"
        shutil.copytree(self.folder, odd, ignore=lambda folder, names: [n for n in names if n == odd.name])
        self.plan, whole, self.out = odd / "plan.xml", self.folder / "whole", odd / "out"
        self.produce(out=whole)
        script = self.folder / "job.sh"
        script.write_text(self.submit("--dry-run", "--tasks", 2))
        self.assertEqual(self.task(script, 1).wait(60), DONE)
        self.assertEqual(self.task(script, 2).wait(60), DONE)
        self.assertEqual(tree(self.out), tree(whole))
        self.assertEqual(list(self.folder.rglob("pwned")), [])

    def task(self, script, number, **more):
        environment = {"SLURM_ARRAY_TASK_ID": str(number), "SLURM_ARRAY_JOB_ID": "7", "PATH": "%s:%s" % (self.commands, os.environ["PATH"])}
        return subprocess.Popen(["bash", str(script)], cwd=self.folder, env={**environment, **more}, stdin=subprocess.DEVNULL)

    def test_a_task_that_is_warned_asks_for_another_turn(self):
        self.write_plan(views=2, size=256, spp=4096)
        script = self.folder / "job.sh"
        script.write_text(self.submit("--dry-run", "--tasks", 1))
        self.command_named("scontrol", 'echo "$@" >>"%s/asked"\n' % self.folder)
        for state, restarts, asked in (("RUNNING", "49", True), ("CANCELLED", "0", False), ("RUNNING", "50", False)):
            self.command_named("squeue", "echo %s\n" % state)
            task = self.task(script, 1, SLURM_RESTART_COUNT=restarts)
            self.wait_for(lambda: self.our_workers())
            task.send_signal(signal.SIGTERM)
            self.assertEqual(task.wait(30), TRY_AGAIN)
            self.assertEqual(self.our_workers(), [])
            self.assertEqual((self.folder / "asked").exists(), asked, (state, restarts))
            if asked:
                self.assertEqual((self.folder / "asked").read_text(), "requeue 7_1\n")
                (self.folder / "asked").unlink()


if __name__ == "__main__":
    unittest.main(verbosity=2)
