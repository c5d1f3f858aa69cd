//! Means of two samples and of four that are not (a + b + 1) >> 1 and (a + b + c + d + 2) >> 2 (clause 2.9.3/5).

/// A way to take them.
pub(super) struct Mean {
    /// Completes "for means of two columns it …".
    pub says: &'static str,
    /// Of how many samples; 0 for two and four.
    pub samples: usize,
    pub of: fn(&[u8]) -> u8,
}

fn sum(samples: &[u8]) -> u32 {
    samples.iter().copied().map(u32::from).sum()
}

fn up(samples: &[u8]) -> u8 {
    let count = samples.len() as u32;
    ((sum(samples) + count / 2) / count) as u8
}

/// Those that are tried.
#[rustfmt::skip]
pub(super) const MEANS: &[Mean] = &[
    Mean { says: "rounds down", samples: 0, of: |s| (sum(s) / s.len() as u32) as u8 },
    Mean { says: "rounds at a half to the even number", samples: 0, of: |s| {
        (f64::from(sum(s)) / s.len() as f64).round_ties_even() as u8
    } },
    Mean { says: "keeps the sum in a byte", samples: 0, of: |s| {
        let count = s.len() as u32;
        ((sum(s) + count / 2) % 256 / count) as u8
    } },
    Mean { says: "takes the first sample alone", samples: 0, of: |s| s[0] },
    Mean { says: "takes the last sample alone", samples: 0, of: |s| s[s.len() - 1] },
    Mean { says: "takes the largest sample", samples: 0, of: |s| s.iter().copied().max().unwrap_or_default() },
    Mean { says: "takes the smallest sample", samples: 0, of: |s| s.iter().copied().min().unwrap_or_default() },
    Mean { says: "rounds every remainder up", samples: 0, of: |s| sum(s).div_ceil(s.len() as u32) as u8 },
    Mean { says: "adds 1 before the division by 4, where 2 belongs", samples: 4, of: |s| ((sum(s) + 1) / 4) as u8 },
    Mean { says: "takes the mean of two means, rounded twice", samples: 4, of: |s| up(&[up(&s[..2]), up(&s[2..])]) },
    Mean { says: "takes two diagonal samples, (x, y) and (x + 1, y + 1)", samples: 4, of: |s| up(&[s[0], s[3]]) },
    Mean { says: "takes two diagonal samples, (x + 1, y) and (x, y + 1)", samples: 4, of: |s| up(&[s[1], s[2]]) },
    Mean { says: "takes two samples of one row", samples: 4, of: |s| up(&s[..2]) },
    Mean { says: "takes two samples of one column", samples: 4, of: |s| up(&[s[0], s[2]]) },
    Mean { says: "takes (x + 1, y) twice and leaves out (x, y + 1)", samples: 4, of: |s| up(&[s[0], s[1], s[1], s[3]]) },
    Mean { says: "takes (x, y + 1) twice and leaves out (x + 1, y)", samples: 4, of: |s| up(&[s[0], s[2], s[2], s[3]]) },
    Mean { says: "takes the first sample three times", samples: 2, of: |s| up(&[s[0], s[0], s[0], s[1]]) },
    Mean { says: "takes three quarters of the first sample and a quarter of the second, rounded down", samples: 2, of: |s| ((3 * u32::from(s[0]) + u32::from(s[1])) / 4) as u8 },
];
