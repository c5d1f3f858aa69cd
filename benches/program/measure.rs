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

/// Runs several closures in turn, after one round to warm up. Returns the mean processor time and the median wall-clock time
/// of each closure. The mean is necessary because the processor time of other processes is counted in ticks.
pub fn measure_in_turn<const N: usize>(
    times: usize,
    closures: &mut [&mut dyn FnMut() -> Spent; N],
) -> [Spent; N] {
    for closure in closures.iter_mut() {
        closure();
    }
    let mut rounds: Vec<[Spent; N]> = Vec::new();
    for _ in 0..times {
        rounds.push(std::array::from_fn(|i| closures[i]()));
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

/// Measures the times of a program.
pub fn time_of(command: &mut Command) -> Spent {
    let (start, before) = (Instant::now(), children_seconds());
    assert!(
        command.status().expect("it starts").success(),
        "{command:?}"
    );
    Spent {
        processor: children_seconds() - before,
        wall: start.elapsed().as_secs_f64(),
    }
}

/// Measures the times of a closure in this thread.
pub fn own_time(work: impl FnOnce()) -> Spent {
    let (start, before) = (Instant::now(), thread_seconds());
    work();
    let wall = start.elapsed().as_secs_f64();
    Spent {
        processor: thread_seconds()
            .zip(before)
            .map_or(wall, |(after, before)| after - before),
        wall,
    }
}

/// Returns the processor time of this thread in seconds.
fn thread_seconds() -> Option<f64> {
    let text = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split(' ').next()?.parse().ok()?;
    Some(nanoseconds / 1e9)
}

/// Returns the processor time of ended child processes in seconds, with a resolution of 10 ms.
fn children_seconds() -> f64 {
    let text = fs::read_to_string("/proc/self/stat").expect("Linux");
    // Skip the name, which may contain any character. Field 3 is the state, and fields 16 and 17 are the times of children.
    let fields: Vec<&str> = text[text.rfind(')').expect("a name") + 2..]
        .split(' ')
        .collect();
    let ticks = |field: usize| fields[field - 3].parse::<f64>().expect("a number");
    (ticks(16) + ticks(17)) / 100.0
}

/// Returns the peak memory of a program in bytes. It is read before the end of the output, while the program still runs.
pub fn memory_of_call(command: &mut Command) -> u64 {
    let mut child = command.stdout(Stdio::piped()).spawn().expect("it starts");
    let mut out = child.stdout.take().expect("its output");
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    let mut buffer = vec![0; 1 << 20];
    // The pipe buffer is smaller than the output, so some reads happen while the program still waits.
    while out.read(&mut buffer).expect("its output") > 0 {
        let status = fs::read_to_string(&status).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        peak = peak.max(kilobytes.unwrap_or(0) << 10);
    }
    child.wait().expect("it ends");
    peak
}

/// Returns the slope of the regression line in log-log scale, which is 1 for linear growth.
pub fn slope(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (x.ln(), y.ln())).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let covariance: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    covariance / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}
