//! What the system tells of other processes: how much memory a call holds, and who is left of it.
//!
//! A decoder may start processes that leave its group and outlive it. This process asks to inherit such orphans, and
//! every process carries the mark of its call: the directory it works in, as its `TMPDIR` or as its working directory.
//! On systems without `/proc` none of this is in force, and the report says so.

use std::fs;
use std::io;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::process::{Child, Command};
use std::sync::Mutex;

use rustix::process::{
    Pid, Resource, Rlimit, Signal, WaitOptions, kill_process, setrlimit, waitpid,
};

/// Largest file that a decoder, or this process, may write.
const LARGEST_FILE: u64 = 4 << 30;

/// The processes that this one has started itself and not yet waited for; its other children are orphans.
static STARTED: Mutex<Vec<u32>> = Mutex::new(Vec::new());

/// Whether memory can be measured and orphans found.
#[must_use]
pub fn can_be_watched() -> bool {
    let this = std::process::id();
    Path::new(&format!("/proc/self/task/{this}/children")).exists()
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

/// Starts a process of this program's own.
///
/// # Errors
/// Those of the system.
pub fn start(command: &mut Command) -> io::Result<Child> {
    let child = command.spawn()?;
    started().push(child.id());
    Ok(child)
}

/// Says that a process that was [started](start) has been waited for.
pub fn has_been_waited_for(pid: u32) {
    started().retain(|&known| known != pid);
}

fn started() -> std::sync::MutexGuard<'static, Vec<u32>> {
    STARTED.lock().expect("nothing panics while it is held")
}

/// Bytes of memory that a process, its descendants and the orphans of its call hold, all together.
#[must_use]
pub fn memory_of(root: Pid, workplace: &Path) -> u64 {
    let page = rustix::param::page_size() as u64;
    let mut members = orphans(|pid| works_in(pid, workplace));
    members.push(root.as_raw_nonzero().get().cast_unsigned());
    let mut pages = 0;
    while let Some(pid) = members.pop() {
        pages += resident_pages(pid).unwrap_or_default();
        members.extend(children_of(pid));
    }
    pages * page
}

fn resident_pages(pid: u32) -> Option<u64> {
    let sizes = fs::read_to_string(format!("/proc/{pid}/statm")).ok()?;
    sizes.split(' ').nth(1)?.parse().ok()
}

/// Kills every orphan that works for the call in `workplace`, wherever it has gone to, until none is left.
pub fn kill_orphans(workplace: &Path) {
    kill_while_there_are(|| orphans(|pid| works_in(pid, workplace)));
}

/// Kills every process that works anywhere below `scratch`, and every orphan that hides where it works.
pub fn kill_all(scratch: &Path) {
    kill_while_there_are(|| {
        let marked = processes().filter(|&pid| works_in(pid, scratch));
        marked.chain(orphans(|_| true)).collect()
    });
}

fn kill_while_there_are(those: impl Fn() -> Vec<u32>) {
    for round in 0..200 {
        let left = those();
        if left.is_empty() {
            return;
        }
        for pid in left.into_iter().filter_map(to_pid) {
            let _ = kill_process(pid, Signal::KILL);
            // Only children can be waited for; others are somebody else's to wait for.
            let _ = waitpid(Some(pid), WaitOptions::NOHANG);
        }
        if round > 0 {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
    }
}

/// The processes that this one has inherited, as far as they are `wanted`.
fn orphans(wanted: impl Fn(u32) -> bool) -> Vec<u32> {
    let this = std::process::id();
    // Orphans come to the first thread; what other threads start is theirs.
    let mut inherited = children_of_thread(this, this);
    if !inherited.is_empty() {
        let started = started();
        inherited.retain(|pid| !started.contains(pid));
    }
    inherited.retain(|&pid| wanted(pid));
    inherited
}

fn children_of(pid: u32) -> Vec<u32> {
    let threads = fs::read_dir(format!("/proc/{pid}/task"));
    let threads = threads.into_iter().flatten().flatten();
    let threads = threads.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    threads
        .flat_map(|thread| children_of_thread(pid, thread))
        .collect()
}

fn children_of_thread(pid: u32, thread: u32) -> Vec<u32> {
    let children = fs::read_to_string(format!("/proc/{pid}/task/{thread}/children"));
    let children = children.unwrap_or_default();
    children
        .split_whitespace()
        .filter_map(|pid| pid.parse().ok())
        .collect()
}

fn processes() -> impl Iterator<Item = u32> {
    let entries = fs::read_dir("/proc").into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok())
}

/// Whether a process was started with its temporary directory in or below `place`, or works there; and is no zombie.
fn works_in(pid: u32, place: &Path) -> bool {
    let directory = fs::read_link(format!("/proc/{pid}/cwd"));
    if directory.is_ok_and(|directory| directory.starts_with(place)) {
        return true;
    }
    let environment = fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
    let mark = [b"TMPDIR=", place.as_os_str().as_bytes()].concat();
    environment.split(|&byte| byte == 0).any(|variable| {
        let rest = variable.strip_prefix(&mark[..]);
        rest.is_some_and(|rest| rest.first().is_none_or(|&next| next == b'/'))
    })
}

fn to_pid(pid: u32) -> Option<Pid> {
    Pid::from_raw(i32::try_from(pid).ok()?)
}
