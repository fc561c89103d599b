"""A Slurm of one node on the loopback address, in a folder of its own, which ends with the test that started it."""
import ctypes
import os
import pwd
import shutil
import signal
import socket
import subprocess
import time
from pathlib import Path

PATH = os.environ["PATH"] + ":/usr/sbin:/sbin"
WANTED = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel")
CONFIGURATION = """ClusterName=ohb
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={folder}/munge/socket,cred_expire=5
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=bf_interval=1,sched_interval=1,sched_min_interval=100000,batch_sched_delay=0
SlurmdParameters=config_overrides
ReturnToService=2
MpiDefault=none
KillWait=2
MaxArraySize=5
NodeName={host} NodeAddr=127.0.0.1 CPUs=4 RealMemory=512
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def missing():
    """Words that say why there can be no cluster here; none if there can be."""
    absent = [name for name in WANTED if not shutil.which(name, path=PATH)]
    return "not installed: %s (Debian: slurm-wlm, munge)" % ", ".join(absent) if absent else ""


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


def die_with_parent():
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)


class Cluster:
    def __init__(self, folder):
        self.folder, self.daemons = Path(folder), []
        for name in ("munge", "state", "spool"):
            (self.folder / name).mkdir(parents=True)
        for place in (self.folder, self.folder / "munge"):
            place.chmod(0o755)      # munged asks for it
        host = socket.gethostname().split(".")[0]
        user = pwd.getpwuid(os.getuid()).pw_name
        configuration = self.folder / "slurm.conf"
        configuration.write_text(CONFIGURATION.format(host=host, ports=free_ports(2), user=user, folder=self.folder))
        key = self.folder / "munge/key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        self.environment = {**os.environ, "PATH": PATH, "SLURM_CONF": str(configuration)}
        for name in [n for n in self.environment if n.startswith(("SBATCH_", "SQUEUE_"))]:
            del self.environment[name]

    def start(self):
        munge = self.folder / "munge"
        self.daemon("munged", "--foreground", "--num-threads=2", "--key-file=%s" % (munge / "key"),
                    "--socket=%s" % (munge / "socket"), "--pid-file=%s" % (munge / "pid"), "--log-file=%s" % (munge / "log"),
                    "--seed-file=%s" % (munge / "seed"))
        self.wait_for(lambda: (munge / "socket").exists(), "munged")
        self.daemon("slurmctld", "-D", "-i")
        self.daemon("slurmd", "-D")
        self.wait_for(lambda: self.run("sinfo", "-h", "-o", "%t").stdout.strip() == "idle", "the node")

    def daemon(self, *words):
        with open(self.folder / (words[0] + ".out"), "wb") as log:
            self.daemons.append(subprocess.Popen(words, env=self.environment, stdin=subprocess.DEVNULL, stdout=log,
                                                 stderr=subprocess.STDOUT, preexec_fn=die_with_parent))

    def run(self, *words):
        return subprocess.run(words, env=self.environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=60)

    def wait_for(self, condition, what, seconds=60):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end or any(d.poll() is not None for d in self.daemons):
                raise AssertionError("%s did not come\n%s" % (what, self.words()))
            time.sleep(0.2)

    def words(self):
        """The last that its daemons said."""
        return "\n".join("%s: %s" % (log.name, log.read_text(errors="replace")[-1500:]) for log in self.folder.glob("*.out"))

    def stop(self):
        if len(self.daemons) > 1:
            self.run("scancel", "--quiet", "--signal=KILL", "--full", "--user=%d" % os.getuid())
            self.run("scancel", "--quiet", "--user=%d" % os.getuid())
        for daemon in reversed(self.daemons):
            daemon.terminate()
            try:
                daemon.wait(timeout=10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
