//! Process information from the system: the memory of a call and its orphaned processes.
//!
//! A decoder may start processes that leave its group and outlive it. On Linux, this process becomes the parent of
//! such orphans, and every process can be traced to its call by its working directory or its `TMPDIR`. On systems
//! without `/proc` this is not possible, and the report says so.

use std::fs;
use std::io;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::process::{Child, Command};
use std::sync::{Mutex, PoisonError, RwLock};

use rustix::process::{
    Pid, Resource, Rlimit, Signal, WaitOptions, getrlimit, kill_process, setrlimit, waitpid,
};

/// Maximum size of a file that a decoder or this process may write.
const MAX_FILE_BYTES: u64 = 4 << 30;

/// Processes that this process started and has not reaped yet. All other children are orphans.
static STARTED_PROCESSES: Mutex<Vec<u32>> = Mutex::new(Vec::new());

/// A lock that is held for reading while a process is started and added to [`STARTED_PROCESSES`]. While the lock is held for
/// writing, the list is complete.
static START_LOCK: RwLock<()> = RwLock::new(());

/// Returns true if the system allows measuring memory and finding orphans.
#[must_use]
pub fn can_inspect_processes() -> bool {
    let this = std::process::id();
    Path::new(&format!("/proc/self/task/{this}/children")).exists()
}

/// Prepares this process to inherit orphans. Disables core dumps and limits file sizes for this process and its children.
pub fn prepare() {
    prepare_for(MAX_FILE_BYTES);
}

/// Like [`prepare`], but limits files to `largest_file` bytes.
pub fn prepare_for(largest_file: u64) {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::set_child_subreaper(Some(rustix::process::getpid()));
    for (resource, limit) in [(Resource::Core, 0), (Resource::Fsize, largest_file)] {
        let both = Rlimit {
            current: Some(limit),
            maximum: Some(limit),
        };
        // Setting a limit fails if a lower limit is in force, which then applies.
        let _ = setrlimit(resource, both);
    }
}

/// Returns true if the environment imposes a lower limit on file sizes than [`prepare`] does.
pub(crate) fn is_file_size_limited_by_environment() -> bool {
    let limit = getrlimit(Resource::Fsize).current;
    limit.is_some_and(|limit| limit < MAX_FILE_BYTES)
}

/// Starts a process and registers it, so that it does not count as an orphan.
///
/// # Errors
/// Returns an error if the system cannot start the process.
pub fn start(command: &mut Command) -> io::Result<Child> {
    let _starting = START_LOCK.read().unwrap_or_else(PoisonError::into_inner);
    let child = command.spawn()?;
    lock_started_processes().push(child.id());
    Ok(child)
}

/// Unregisters a process that was [started](start) and has been reaped.
pub fn unregister(pid: u32) {
    let mut started = lock_started_processes();
    // The id may already belong to another started process, which has a separate entry.
    if let Some(i) = started.iter().position(|&known| known == pid) {
        started.swap_remove(i);
    }
}

fn lock_started_processes() -> std::sync::MutexGuard<'static, Vec<u32>> {
    STARTED_PROCESSES
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
}

/// Returns the memory, in bytes, used by a process, its descendants and the orphans of its call.
#[must_use]
pub fn memory_of_call(root: Pid, work_dir: &Path) -> u64 {
    let page = rustix::param::page_size() as u64;
    let mut members = orphans(|pid| belongs_to(pid, work_dir));
    members.push(root.as_raw_nonzero().get().cast_unsigned());
    let mut pages = 0;
    while let Some(pid) = members.pop() {
        let sizes = fs::read_to_string(format!("/proc/{pid}/statm")).unwrap_or_default();
        let resident = sizes
            .split(' ')
            .nth(1)
            .and_then(|pages| pages.parse::<u64>().ok());
        pages += resident.unwrap_or_default();
        members.extend(children_of(pid));
    }
    pages * page
}

/// Kills all orphans of the call that runs in `work_dir`. Reaps all orphans that have ended, so that they do not count against
/// the process limit.
pub fn kill_orphans(work_dir: &Path) {
    kill_until_none(|| orphans(|pid| belongs_to(pid, work_dir)));
    for pid in orphans(has_ended).into_iter().filter_map(to_pid) {
        let _ = waitpid(Some(pid), WaitOptions::NOHANG);
    }
}

/// Kills all processes with a working directory or `TMPDIR` in `scratch`, and all orphans.
pub fn kill_all(scratch: &Path) {
    kill_until_none(|| {
        let marked = processes().filter(|&pid| belongs_to(pid, scratch));
        marked.chain(orphans(|_| true)).collect()
    });
}

fn kill_until_none(list: impl Fn() -> Vec<u32>) {
    for round in 0..200 {
        let left = list();
        if left.is_empty() {
            return;
        }
        for pid in left.into_iter().filter_map(to_pid) {
            let _ = kill_process(pid, Signal::KILL);
            // Only children can be reaped.
            let _ = waitpid(Some(pid), WaitOptions::NOHANG);
        }
        if round > 0 {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
    }
}

/// Returns the orphans of this process for which `wanted` returns true.
fn orphans(wanted: impl Fn(u32) -> bool) -> Vec<u32> {
    let this = std::process::id();
    // Orphans become children of the main thread. Children of other threads were started by these threads.
    let inherited = || {
        let mut children = children_of_thread(this, this);
        if !children.is_empty() {
            let started = lock_started_processes();
            children.retain(|pid| !started.contains(pid));
        }
        children
    };
    if inherited().is_empty() {
        return Vec::new();
    }
    // An apparent orphan may be a process that is just being started.
    let _nothing_starts = START_LOCK.write().unwrap_or_else(PoisonError::into_inner);
    let mut orphans = inherited();
    orphans.retain(|&pid| wanted(pid));
    orphans
}

/// Returns true if the process is a zombie.
fn has_ended(pid: u32) -> bool {
    state_and_start(pid).is_some_and(|(state, _)| state == 'Z')
}

/// Returns the state and the start time of a process. The id and the start time together identify a process.
fn state_and_start(pid: u32) -> Option<(char, u64)> {
    let text = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name in parentheses may contain any characters.
    let mut fields = text.rsplit_once(')')?.1.split_whitespace();
    Some((
        fields.next()?.chars().next()?,
        fields.nth(18)?.parse().ok()?,
    ))
}

/// A snapshot of the children of a process, for a watchdog that kills the children if that process disappears.
#[derive(Default)]
pub struct Children(Vec<(u32, u64)>);

impl Children {
    /// Lists the children of a process, including inherited orphans but excluding the current process.
    #[must_use]
    pub fn new(parent: u32) -> Children {
        let children = children_of(parent).filter(|&pid| pid != std::process::id());
        Children(children.filter_map(process_identity).collect())
    }

    /// Kills the processes that are still running, and their descendants.
    pub fn kill(self) {
        let mut left = self.0;
        while let Some((pid, start)) = left.pop() {
            if process_identity(pid) == Some((pid, start)) {
                left.extend(children_of(pid).filter_map(process_identity));
                if let Some(pid) = to_pid(pid) {
                    let _ = kill_process(pid, Signal::KILL);
                }
            }
        }
    }
}

/// Returns the id and the start time of a process.
fn process_identity(pid: u32) -> Option<(u32, u64)> {
    state_and_start(pid).map(|(_, start)| (pid, start))
}

fn children_of(pid: u32) -> impl Iterator<Item = u32> {
    let threads = fs::read_dir(format!("/proc/{pid}/task"));
    let threads = threads.into_iter().flatten().flatten();
    let threads = threads.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    threads.flat_map(move |thread| children_of_thread(pid, thread))
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

/// Returns true if a process has its working directory or its temporary directory in `place`, and is not a zombie.
fn belongs_to(pid: u32, place: &Path) -> bool {
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
