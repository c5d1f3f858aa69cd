//! How much time and memory something takes.

use std::fs;
use std::io::Read;
use std::process::{Command, Stdio};
use std::time::Instant;

/// Time, in seconds.
#[derive(Clone, Copy, Default)]
pub struct Spent {
    /// Of the processors, user and system.
    pub processor: f64,
    /// On the clock.
    pub wall: f64,
}

/// Does several things in turn, so many times after one round to warm up; of each, the mean of processor time, which for
/// other processes is counted in ticks, and the median on the clock.
pub fn repeated<const N: usize>(
    times: usize,
    things: &mut [&mut dyn FnMut() -> Spent; N],
) -> [Spent; N] {
    for thing in things.iter_mut() {
        thing();
    }
    let mut rounds: Vec<[Spent; N]> = Vec::new();
    for _ in 0..times {
        rounds.push(std::array::from_fn(|i| things[i]()));
    }
    std::array::from_fn(|i| {
        let mut walls: Vec<f64> = rounds.iter().map(|round| round[i].wall).collect();
        walls.sort_by(f64::total_cmp);
        Spent {
            processor: rounds.iter().map(|round| round[i].processor).sum::<f64>() / times as f64,
            wall: walls[times / 2],
        }
    })
}

/// What a program takes.
pub fn time_of(command: &mut Command) -> Spent {
    let (start, before) = (Instant::now(), of_children());
    assert!(
        command.status().expect("it starts").success(),
        "{command:?}"
    );
    Spent {
        processor: of_children() - before,
        wall: start.elapsed().as_secs_f64(),
    }
}

/// What this thread takes for it.
pub fn own_time(work: impl FnOnce()) -> Spent {
    let (start, before) = (Instant::now(), of_thread());
    work();
    let wall = start.elapsed().as_secs_f64();
    Spent {
        processor: of_thread()
            .zip(before)
            .map_or(wall, |(after, before)| after - before),
        wall,
    }
}

/// Seconds that this thread has been on a processor.
fn of_thread() -> Option<f64> {
    let text = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split(' ').next()?.parse().ok()?;
    Some(nanoseconds / 1e9)
}

/// Seconds that ended children were on a processor; ticks of 10 ms.
fn of_children() -> f64 {
    let text = fs::read_to_string("/proc/self/stat").expect("Linux");
    // Behind the name, which may hold anything: state is field 3, the children's times are fields 16 and 17.
    let fields: Vec<&str> = text[text.rfind(')').expect("a name") + 2..]
        .split(' ')
        .collect();
    let ticks = |field: usize| fields[field - 3].parse::<f64>().expect("a number");
    (ticks(16) + ticks(17)) / 100.0
}

/// The most bytes of memory that a program holds until its output is nearly over: it cannot end before all is read.
pub fn memory_of(command: &mut Command) -> u64 {
    let mut child = command.stdout(Stdio::piped()).spawn().expect("it starts");
    let mut out = child.stdout.take().expect("its output");
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    let mut buffer = vec![0; 1 << 20];
    // A pipe holds less than the last pieces, so that some reading comes while the program still waits.
    while out.read(&mut buffer).expect("its output") > 0 {
        let status = fs::read_to_string(&status).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        most = most.max(kilobytes.unwrap_or(0) << 10);
    }
    child.wait().expect("it ends");
    most
}

/// The slope of the line through the logarithms: 1 for what grows in proportion.
pub fn slope(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (x.ln(), y.ln())).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let up: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    up / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}
