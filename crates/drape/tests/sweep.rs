//! The scripts that submit shards, each with its scheduler. A test whose scheduler is absent says
//! that it was skipped.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::common::{python, skipped};
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

fn script(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/sweep")).join(name)
}

fn answers(program: &str, arguments: &[&str]) -> bool {
    Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success())
}

/// Sweeps a study in three shards, one of which is done before, and again where a shard was lost.
fn sweeps(mut command: impl FnMut() -> Command) {
    let folder = tempfile::tempdir().unwrap();
    let mut sweep = || {
        let mut command = command();
        command.arg(folder.path()).arg("3").arg(env!("CARGO_BIN_EXE_drape"));
        let output = command.args(["experiment", "momentum", "--quick"]).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        said
    };
    let said = sweep();
    assert!(said.contains("round 1") && !said.contains("round 2"), "{said}");
    let record = folder.path().join("results/momentum.json");
    let first = std::fs::read_to_string(&record).unwrap();
    let facts = |text: &str| text.split("\"provenance\"").next().unwrap().to_owned();
    // A shard that was killed left no sign that it is done; the others are not run again.
    std::fs::remove_dir_all(folder.path().join("results")).unwrap();
    std::fs::remove_dir_all(folder.path().join("part-2")).unwrap();
    let said = sweep();
    assert!(said.contains("shards 2 of 3") || said.contains("1 of 3 shards"), "{said}");
    assert_eq!(facts(&std::fs::read_to_string(&record).unwrap()), facts(&first));
}

#[test]
fn gnu_parallel() {
    if !answers("parallel", &["--version"]) {
        skipped("GNU parallel is not on the path");
        return;
    }
    sweeps(|| Command::new(script("parallel.sh")));
}

/// A Slurm of one node: a controller and a node in a folder, on loopback, without munge. It ends with
/// the test, however that ends.
struct Slurm {
    folder: tempfile::TempDir,
    daemons: Vec<Child>,
}

/// Debian keeps daemons in a folder that is not on the path of every user.
fn path_with_daemons() -> OsString {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&path).chain([PathBuf::from("/usr/sbin")]);
    std::env::join_paths(folders).unwrap()
}

fn printed(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output().unwrap();
    assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().trim().to_owned()
}

impl Slurm {
    /// What the daemons said where they do not start, as some containers keep them from it.
    fn start() -> Result<Self, String> {
        let folder = tempfile::tempdir().unwrap();
        let home = folder.path().to_owned();
        for name in ["state", "spool"] {
            std::fs::create_dir(home.join(name)).unwrap();
        }
        // Two at a time, lest it be one port twice.
        let free = || TcpListener::bind("127.0.0.1:0").unwrap();
        let [controller, node] =
            [free(), free()].map(|listener| listener.local_addr().unwrap().port());
        let name = printed("uname", &["-n"]);
        let host = name.split('.').next().unwrap();
        let (user, home) = (printed("id", &["-un"]), home.display());
        let settings = format!(
            "ClusterName=drape\n\
             SlurmctldHost={host}(127.0.0.1)\n\
             SlurmctldPort={controller}\n\
             SlurmdPort={node}\n\
             SlurmUser={user}\n\
             SlurmdUser={user}\n\
             AuthType=auth/none\n\
             CredType=cred/none\n\
             ProctrackType=proctrack/pgid\n\
             TaskPlugin=task/none\n\
             JobAcctGatherType=jobacct_gather/none\n\
             MpiDefault=none\n\
             SelectType=select/cons_tres\n\
             SelectTypeParameters=CR_CPU\n\
             SlurmdParameters=config_overrides\n\
             ReturnToService=2\n\
             StateSaveLocation={home}/state\n\
             SlurmdSpoolDir={home}/spool\n\
             SlurmctldPidFile={home}/slurmctld.pid\n\
             SlurmdPidFile={home}/slurmd.pid\n\
             NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN\n\
             PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n"
        );
        std::fs::write(folder.path().join("slurm.conf"), settings).unwrap();
        let mut slurm = Self { folder, daemons: Vec::new() };
        // The daemon of a node looks for cgroups even where nothing uses them. It is told to leave
        // them alone; versions before 23 do not know that, and are told to do without systemd.
        let output = slurm.command("slurmd").arg("-V").output().unwrap();
        let version = String::from_utf8(output.stdout).unwrap();
        let number = version.split_whitespace().last().unwrap_or_default();
        let year = number.split('.').next().and_then(|year| year.parse::<u32>().ok());
        let is_old = year.is_some_and(|year| year < 23);
        let cgroups = if is_old { "IgnoreSystemd=yes\n" } else { "CgroupPlugin=disabled\n" };
        std::fs::write(slurm.folder.path().join("cgroup.conf"), cgroups).unwrap();
        for daemon in ["slurmctld", "slurmd"] {
            let log = File::create(slurm.log(daemon)).unwrap();
            let mut command = slurm.command(daemon);
            command.arg("-D").stdout(log.try_clone().unwrap()).stderr(log);
            let child = command.spawn().unwrap();
            slurm.daemons.push(child);
        }
        slurm.wait_for("the node is idle", |slurm| {
            let output = slurm.command("sinfo").args(["--noheader", "--format=%T"]).output();
            output.is_ok_and(|output| output.stdout.trim_ascii() == b"idle")
        })?;
        Ok(slurm)
    }

    fn log(&self, daemon: &str) -> PathBuf {
        self.folder.path().join(daemon).with_extension("log")
    }

    /// A command that speaks to this Slurm, and takes nothing from another one around the test.
    fn command(&self, program: impl AsRef<OsStr>) -> Command {
        let mut command = Command::new(program);
        for (name, _) in std::env::vars_os() {
            let text = name.to_string_lossy();
            if text.starts_with("SLURM") || text.starts_with("SBATCH") {
                command.env_remove(&name);
            }
        }
        command.env("PATH", path_with_daemons());
        command.env("SLURM_CONF", self.folder.path().join("slurm.conf"));
        command
    }

    /// Waits at most a minute; what the daemons said where that is in vain.
    fn wait_for(&mut self, what: &str, is_so: impl Fn(&Self) -> bool) -> Result<(), String> {
        let begun = Instant::now();
        while !is_so(self) {
            let ended = self.daemons.iter_mut().any(|child| child.try_wait().unwrap().is_some());
            if ended || begun.elapsed() > Duration::from_secs(60) {
                let logs = ["slurmctld", "slurmd"]
                    .map(|daemon| std::fs::read_to_string(self.log(daemon)).unwrap_or_default());
                return Err(format!("not so: {what}\n{}", logs.join("\n")));
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        Ok(())
    }
}

impl Drop for Slurm {
    /// Jobs first: nobody else would end them.
    fn drop(&mut self) {
        let is_empty = || {
            let output = self.command("squeue").arg("--noheader").output();
            output.is_ok_and(|output| output.stdout.is_empty())
        };
        if !is_empty() {
            for state in ["--state=PENDING", "--state=RUNNING"] {
                let _ = self.command("scancel").arg(state).output();
            }
            let begun = Instant::now();
            while !is_empty() && begun.elapsed() < Duration::from_secs(10) {
                std::thread::sleep(Duration::from_millis(100));
            }
        }
        for child in self.daemons.iter_mut().rev() {
            let _ = Command::new("kill").arg(child.id().to_string()).output();
            let begun = Instant::now();
            while matches!(child.try_wait(), Ok(None)) && begun.elapsed() < Duration::from_secs(10)
            {
                std::thread::sleep(Duration::from_millis(20));
            }
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn without_slurm(why: &str) {
    assert_ne!(std::env::var("DRAPE_SLURM").as_deref(), Ok("required"), "{why}");
    skipped(why);
}

/// On a controller and a node of its own. Debian's package is `slurm-wlm`. With DRAPE_SLURM=required
/// they must be there and start.
#[test]
fn slurm() {
    let path = path_with_daemons();
    let is_there = |name: &&str| std::env::split_paths(&path).any(|at| at.join(name).is_file());
    let needed = ["slurmctld", "slurmd", "sbatch", "sinfo"];
    if !needed.iter().all(is_there) {
        return without_slurm(&format!("one of {} is not on the path", needed.join(", ")));
    }
    match Slurm::start() {
        Ok(slurm) => sweeps(|| slurm.command(script("slurm.sh"))),
        Err(said) => without_slurm(&format!("a Slurm of one node does not start here: {said}")),
    }
}

/// On a server and a worker of its own. `DRAPE_PYTHON` names the Python that has the package.
#[test]
fn hyperqueue() {
    let python = python();
    if !answers(&python, &["-c", "import hyperqueue"]) {
        skipped(&format!("`{python} -c 'import hyperqueue'` fails on this machine"));
        return;
    }
    sweeps(|| {
        let mut command = Command::new(&python);
        command.arg(script("with_hyperqueue.py")).arg("--local");
        command
    });
}
