//! What the system tells of other processes: how much memory a group holds, and who is left of a call.
//!
//! A decoder may start processes that leave its group and outlive it. This process asks to inherit such orphans, and
//! every process carries the mark of its call in its environment: the directory it works in. On systems without
//! `/proc` none of this is in force, and the report says so.

use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use rustix::process::{
    Pid, Resource, Rlimit, Signal, WaitOptions, kill_process, setrlimit, waitpid,
};

/// Largest file that a decoder, or this process, may write.
const LARGEST_FILE: u64 = 4 << 30;

/// Whether memory can be measured and orphans found.
#[must_use]
pub fn can_be_watched() -> bool {
    Path::new("/proc/self/stat").exists()
}

/// Prepares this process: orphans come to it, and what it starts inherits no core dumps and no endless files.
pub fn prepare() {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::set_child_subreaper(Some(rustix::process::getpid()));
    // Where a limit cannot be set, the decoder runs without it.
    let _ = setrlimit(
        Resource::Core,
        Rlimit {
            current: Some(0),
            maximum: Some(0),
        },
    );
    let _ = setrlimit(
        Resource::Fsize,
        Rlimit {
            current: Some(LARGEST_FILE),
            maximum: Some(LARGEST_FILE),
        },
    );
}

/// Bytes of memory that the processes of a group hold, all together.
#[must_use]
pub fn memory_of_group(group: Pid) -> u64 {
    let group = group.as_raw_nonzero().get();
    let page = rustix::param::page_size() as u64;
    let resident = |pid: u32| {
        let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        // The second field is the program's name in parentheses, and may hold anything.
        let mut fields = stat.rsplit_once(')')?.1.split_whitespace();
        let member = fields.nth(2)?.parse::<i32>().ok()? == group;
        // Field 5 is the group, field 24 the resident set.
        member
            .then(|| fields.nth(18)?.parse::<u64>().ok())
            .flatten()
    };
    processes().filter_map(resident).sum::<u64>() * page
}

/// Kills every process that works for the call in `workplace`, wherever it has gone to, until none is left.
pub fn kill_orphans(workplace: &Path) {
    for _ in 0..100 {
        let mine: Vec<Pid> = children()
            .filter(|&pid| works_in(pid, workplace))
            .filter_map(to_pid)
            .collect();
        if mine.is_empty() {
            return;
        }
        for pid in mine {
            let _ = kill_process(pid, Signal::KILL);
            let _ = waitpid(Some(pid), WaitOptions::empty());
        }
    }
}

/// Kills every process that works anywhere below `scratch`.
pub fn kill_all(scratch: &Path) {
    for _ in 0..100 {
        let left: Vec<Pid> = processes()
            .filter(|&pid| works_in(pid, scratch))
            .filter_map(to_pid)
            .collect();
        if left.is_empty() {
            return;
        }
        for pid in left {
            let _ = kill_process(pid, Signal::KILL);
            let _ = waitpid(Some(pid), WaitOptions::NOHANG);
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
}

/// The processes that this one has started or inherited and not yet waited for.
fn children() -> impl Iterator<Item = u32> {
    let threads = fs::read_dir("/proc/self/task")
        .into_iter()
        .flatten()
        .flatten();
    threads.flat_map(|thread| {
        let children = fs::read_to_string(thread.path().join("children")).unwrap_or_default();
        children
            .split_whitespace()
            .filter_map(|pid| pid.parse().ok())
            .collect::<Vec<u32>>()
    })
}

fn processes() -> impl Iterator<Item = u32> {
    let entries = fs::read_dir("/proc").into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok())
}

/// Whether a process was started with its temporary directory in or below `place`, and is no zombie.
fn works_in(pid: u32, place: &Path) -> bool {
    let environment = fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
    let mark = [b"TMPDIR=", place.as_os_str().as_bytes()].concat();
    environment
        .split(|&byte| byte == 0)
        .any(|variable| variable.starts_with(&mark))
}

fn to_pid(pid: u32) -> Option<Pid> {
    Pid::from_raw(i32::try_from(pid).ok()?)
}
