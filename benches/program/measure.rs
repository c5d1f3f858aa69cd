//! Measurement of time and memory.

use std::fs;
use std::io::Read;
use std::process::{Command, Stdio};
use std::time::Instant;

/// Times in seconds.
#[derive(Clone, Copy, Default)]
pub struct Spent {
    /// Processor time, user and system.
    pub processor: f64,
    /// Wall-clock time.
    pub wall: f64,
}

/// Runs several closures in turn, after one round to warm up. Returns, for each, the mean processor time, which for other processes
/// is counted in ticks, and the median wall-clock time.
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

/// Measures a program.
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

/// Measures a closure in this thread.
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

/// Returns the processor time of this thread in seconds.
fn of_thread() -> Option<f64> {
    let text = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split(' ').next()?.parse().ok()?;
    Some(nanoseconds / 1e9)
}

/// Returns the processor time of ended children in seconds, in ticks of 10 ms.
fn of_children() -> f64 {
    let text = fs::read_to_string("/proc/self/stat").expect("Linux");
    // After the name, which may contain anything: field 3 is the state, fields 16 and 17 are the times of children.
    let fields: Vec<&str> = text[text.rfind(')').expect("a name") + 2..]
        .split(' ')
        .collect();
    let ticks = |field: usize| fields[field - 3].parse::<f64>().expect("a number");
    (ticks(16) + ticks(17)) / 100.0
}

/// Returns the peak memory of a program in bytes, read before its output ends: it cannot exit before all is read.
pub fn memory_of_call(command: &mut Command) -> u64 {
    let mut child = command.stdout(Stdio::piped()).spawn().expect("it starts");
    let mut out = child.stdout.take().expect("its output");
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    let mut buffer = vec![0; 1 << 20];
    // A pipe holds less than the last pieces, so some reads happen while the program still waits.
    while out.read(&mut buffer).expect("its output") > 0 {
        let status = fs::read_to_string(&status).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        most = most.max(kilobytes.unwrap_or(0) << 10);
    }
    child.wait().expect("it ends");
    most
}

/// Returns the slope of the line through the logarithms: 1 for linear growth.
pub fn slope(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (x.ln(), y.ln())).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let up: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    up / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}
