//! Right values in wrong places: where in a block of values a decoder looks for one of them.
//!
//! A value of column x, row y (from the bottom, as rows are stored) and channel k stands at shift + x · a + y · b + k · c.
//! What a, b, c and the shift are in the decoder under test is solved from its answer.

/// A distance in values that follows from width w, height h and channels c.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    One,
    /// c
    Texel,
    /// w · c
    Row,
    /// (w + 1) · c
    LongRow,
    /// (w − 1) · c
    ShortRow,
    /// w · c rounded up to a multiple of 4
    PaddedRow,
    /// h · c
    Column,
    /// w
    RowOfOne,
    /// h
    ColumnOfOne,
    /// w · h
    Plane,
    /// (c + 1)
    LongTexel,
    /// Of every texel, row or channel the same value.
    Nowhere,
}

/// How far values are from each other, and whether they are counted from the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Strides {
    pub x: (Step, bool),
    pub y: (Step, bool),
    pub k: (Step, bool),
    pub shift: isize,
}

/// Columns, rows and channels of a block.
#[derive(Clone, Copy)]
pub(super) struct Extent {
    pub w: usize,
    pub h: usize,
    pub c: usize,
}

impl Step {
    fn of(self, Extent { w, h, c }: Extent) -> usize {
        match self {
            Step::One => 1,
            Step::Texel => c,
            Step::Row => w * c,
            Step::LongRow => (w + 1) * c,
            Step::ShortRow => (w - 1) * c,
            Step::PaddedRow => (w * c).next_multiple_of(4),
            Step::Column => h * c,
            Step::RowOfOne => w,
            Step::ColumnOfOne => h,
            Step::Plane => w * h,
            Step::LongTexel => c + 1,
            Step::Nowhere => 0,
        }
    }
}

/// Orders in which values may be taken to stand: steps of x, y and k, and what that is.
const LAYOUTS: &[([Step; 3], &str)] = &[
    ([Step::Texel, Step::Row, Step::One], ""),
    (
        [Step::Texel, Step::LongRow, Step::One],
        "takes rows to be one texel longer than they are (a stride of width + 1)",
    ),
    (
        [Step::Texel, Step::ShortRow, Step::One],
        "takes rows to be one texel shorter than they are (a stride of width − 1)",
    ),
    (
        [Step::Texel, Step::PaddedRow, Step::One],
        "takes rows to be padded to a multiple of four bytes",
    ),
    (
        [Step::Texel, Step::Column, Step::One],
        "takes rows to be as long as columns (a stride of height)",
    ),
    (
        [Step::Column, Step::Texel, Step::One],
        "reads column after column where the file has row after row",
    ),
    (
        [Step::One, Step::Row, Step::RowOfOne],
        "takes the channels to be interleaved row by row: a row of one, then the same row of the next",
    ),
    (
        [Step::One, Step::RowOfOne, Step::Plane],
        "takes the channels to stand one after the other, each as a whole plane",
    ),
    (
        [Step::ColumnOfOne, Step::One, Step::Plane],
        "takes the channels to stand one after the other, each as a whole plane, column after column",
    ),
    (
        [Step::LongTexel, Step::Row, Step::One],
        "takes texels to be one byte longer than they are",
    ),
    (
        [Step::Texel, Step::Nowhere, Step::One],
        "reads the same row again and again",
    ),
    (
        [Step::Nowhere, Step::Row, Step::One],
        "reads the same texel of a row again and again",
    ),
];

/// How far values may be read from the wrong place and still be recognized.
const FAR: isize = 64;

impl Strides {
    pub const RIGHT: Strides = Strides {
        x: (Step::Texel, false),
        y: (Step::Row, false),
        k: (Step::One, false),
        shift: 0,
    };

    /// The place of a value in its block.
    pub fn place(&self, x: usize, y: usize, k: usize, extent: Extent) -> isize {
        let term = |i: usize, n: usize, (step, back): (Step, bool)| {
            (if back { n - 1 - i } else { i } * step.of(extent)) as isize
        };
        self.shift
            + term(x, extent.w, self.x)
            + term(y, extent.h, self.y)
            + term(k, extent.c, self.k)
    }

    /// All that are tried: every layout in every direction, those that are right but for a shift with the farthest.
    pub fn all(far: bool) -> Vec<Strides> {
        let mut all = Vec::new();
        for &([x, y, k], _) in LAYOUTS {
            for back in 0..8 {
                let one = Strides {
                    x: (x, back & 1 != 0),
                    y: (y, back & 2 != 0),
                    k: (k, back & 4 != 0),
                    shift: 0,
                };
                let far = match (far, one == Strides::RIGHT) {
                    (true, true) => FAR,
                    (true, false) => 18,
                    (false, _) => 0,
                };
                for shift in 0..=far {
                    all.push(Strides { shift, ..one });
                    all.push(Strides {
                        shift: -shift,
                        ..one
                    });
                }
            }
        }
        all.retain(|one| *one != Strides::RIGHT);
        all.dedup();
        all
    }

    /// What is wrong with the steps, as sentences without their subject.
    fn says_of_steps(&self) -> Vec<String> {
        let steps = [self.x.0, self.y.0, self.k.0];
        let layout = LAYOUTS.iter().find(|(known, _)| *known == steps);
        let layout = layout.filter(|(_, says)| !says.is_empty());
        let mut says: Vec<String> = layout
            .map(|(_, says)| (*says).to_owned())
            .into_iter()
            .collect();
        match (self.x.1, self.y.1) {
            (true, true) => says.push("shows pictures turned by half a turn".to_owned()),
            (true, false) => says.push("mirrors rows, left for right".to_owned()),
            (false, true) => says.push("reads rows from the top down".to_owned()),
            (false, false) => {}
        }
        if self.k.1 {
            says.push("takes the channels of a texel in reverse order, the last first".to_owned());
        }
        says
    }

    /// As a sentence without its subject, of whole texels.
    pub fn says_of_texels(&self) -> String {
        let mut says = self.says_of_steps();
        let texels = self.shift.unsigned_abs();
        let sign = if self.shift < 0 { '−' } else { '+' };
        if texels > 0 {
            says.push(format!(
                "shows as texel i what is stored for texel i {sign} {texels}"
            ));
        }
        says.join(", and ")
    }

    /// As a sentence without its subject. `values` is what the block holds; a texel of it has `channels`.
    pub fn says(&self, values: &str, channels: usize) -> String {
        let mut says = self.says_of_steps();
        let count = self.shift.unsigned_abs();
        let bytes = if count == 1 { "byte" } else { "bytes" };
        let texels = match count.is_multiple_of(channels) {
            true => format!(" ({} texels)", count / channels),
            false => String::new(),
        };
        match self.shift {
            0 => {}
            1.. => says.push(format!(
                "reads every value {count} {bytes} too late{texels}"
            )),
            _ => says.push(format!(
                "reads every value {count} {bytes} too early{texels}"
            )),
        }
        format!("{}, in {values}", says.join(", and "))
    }
}
