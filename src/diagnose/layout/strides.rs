//! Right values in wrong places: where in a block of values a decoder looks for one of them.
//!
//! A value of column x, row y (from the bottom, as rows are stored) and channel k stands at shift + x · a + y · b + k · c.
//! What a, b, c and the shift are in the decoder under test is solved from its answer.

/// A distance in values that follows from width w, height h and channels c.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::diagnose) enum Step {
    One,
    /// c
    Texel,
    /// w · c
    Row,
    /// (w + 1) · c
    LongRow,
    /// (w − 1) · c
    ShortRow,
    /// w · c rounded up to a multiple of this
    PaddedRow(usize),
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
pub(in crate::diagnose) struct Strides {
    pub x: (Step, bool),
    pub y: (Step, bool),
    pub k: (Step, bool),
    /// So many of these steps too late in the file.
    pub shift: (isize, Step),
    /// What is taken for column and row before.
    pub slip: PlaceSlip,
}

/// A texel taken for another, columns from the left and rows as they are stored, from the bottom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::diagnose) enum PlaceSlip {
    None,
    /// Every second row is read from its end: those of odd numbers, or of even ones.
    TurnedOdd,
    TurnedEven,
    /// The column before the last for the last.
    LastColumn,
    FirstColumn,
    /// The row below the top one for it.
    TopRow,
    BottomRow,
    /// Rows or columns in eight bits.
    RowByte,
    ColumnByte,
    /// The number of the texel in sixteen bits.
    TexelWord,
}

impl PlaceSlip {
    const ALL: [PlaceSlip; 9] = [
        PlaceSlip::TurnedOdd,
        PlaceSlip::TurnedEven,
        PlaceSlip::LastColumn,
        PlaceSlip::FirstColumn,
        PlaceSlip::TopRow,
        PlaceSlip::BottomRow,
        PlaceSlip::RowByte,
        PlaceSlip::ColumnByte,
        PlaceSlip::TexelWord,
    ];

    /// The column and the row that are read for these.
    fn of(self, x: usize, y: usize, Extent { w, h, .. }: Extent) -> (usize, usize) {
        match self {
            PlaceSlip::TurnedOdd if y % 2 == 1 => (w - 1 - x, y),
            PlaceSlip::TurnedEven if y.is_multiple_of(2) => (w - 1 - x, y),
            PlaceSlip::LastColumn if x == w - 1 => (x.saturating_sub(1), y),
            PlaceSlip::FirstColumn if x == 0 => (1.min(w - 1), y),
            PlaceSlip::TopRow if y == h - 1 => (x, y.saturating_sub(1)),
            PlaceSlip::BottomRow if y == 0 => (x, 1.min(h - 1)),
            PlaceSlip::RowByte => (x, y & 0xff),
            PlaceSlip::ColumnByte => (x & 0xff, y),
            PlaceSlip::TexelWord => {
                let texel = (y * w + x) & 0xffff;
                (texel % w, texel / w)
            }
            _ => (x, y),
        }
    }

    /// As a sentence without its subject.
    const fn says(self) -> &'static str {
        match self {
            PlaceSlip::None => "",
            PlaceSlip::TurnedOdd => {
                "reads the second stored row and every second one after it from right to left"
            }
            PlaceSlip::TurnedEven => {
                "reads the first stored row and every second one after it from right to left"
            }
            PlaceSlip::LastColumn => "shows the column before the last as the last",
            PlaceSlip::FirstColumn => "shows the second column as the first",
            PlaceSlip::TopRow => "shows the row below the top one as the top one",
            PlaceSlip::BottomRow => "shows the row above the bottom one as the bottom one",
            PlaceSlip::RowByte => "counts rows in eight bits: row 256 is row 0 again",
            PlaceSlip::ColumnByte => "counts columns in eight bits: column 256 is column 0 again",
            PlaceSlip::TexelWord => "counts texels in sixteen bits: texel 65536 is texel 0 again",
        }
    }
}

/// Columns, rows and channels of a block.
#[derive(Clone, Copy)]
pub(in crate::diagnose) struct Extent {
    pub w: usize,
    pub h: usize,
    pub c: usize,
    /// Values from a row to the next.
    pub row: usize,
}

impl Extent {
    /// One row after another.
    pub const fn of(w: usize, h: usize, c: usize) -> Extent {
        let row = w * c;
        Extent { w, h, c, row }
    }
}

impl Step {
    fn of(self, Extent { w, h, c, row }: Extent) -> usize {
        match self {
            Step::One => 1,
            Step::Texel => c,
            Step::Row => row,
            Step::LongRow => row + c,
            Step::ShortRow => row - c,
            Step::PaddedRow(size) => row.next_multiple_of(size),
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
        [Step::Texel, Step::PaddedRow(4), Step::One],
        "takes rows to be padded to a multiple of four bytes",
    ),
    (
        [Step::Texel, Step::PaddedRow(2), Step::One],
        "takes rows to be padded to a multiple of two bytes",
    ),
    (
        [Step::Texel, Step::PaddedRow(8), Step::One],
        "takes rows to be padded to a multiple of eight bytes",
    ),
    (
        [Step::Texel, Step::PaddedRow(16), Step::One],
        "takes rows to be padded to a multiple of sixteen bytes",
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
        [Step::One, Step::RowOfOne, Step::One],
        "goes on by one byte from texel to texel, whatever a texel has",
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

/// Distances that follow from the size of the picture: a row, as many values as there are columns, or as texels.
const SHIFTS: [(isize, Step); 6] = [
    (1, Step::Row),
    (-1, Step::Row),
    (1, Step::RowOfOne),
    (-1, Step::RowOfOne),
    (1, Step::Plane),
    (-1, Step::Plane),
];

impl Strides {
    pub const RIGHT: Strides = Strides {
        x: (Step::Texel, false),
        y: (Step::Row, false),
        k: (Step::One, false),
        shift: (0, Step::One),
        slip: PlaceSlip::None,
    };

    /// The place of a value in its block.
    pub fn place(&self, x: usize, y: usize, k: usize, extent: Extent) -> isize {
        let term = |i: usize, n: usize, (step, back): (Step, bool)| {
            (if back { n - 1 - i } else { i } * step.of(extent)) as isize
        };
        let (x, y) = self.slip.of(x, y, extent);
        self.shift.0 * self.shift.1.of(extent) as isize
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
                    ..Strides::RIGHT
                };
                if far && one == Strides::RIGHT {
                    all.extend(SHIFTS.map(|shift| one.moved(shift)));
                }
                let far = match (far, one == Strides::RIGHT) {
                    (true, true) => FAR,
                    (true, false) => 18,
                    (false, _) => 0,
                };
                for shift in 0..=far {
                    for shift in [shift, -shift] {
                        all.push(one.later(shift));
                    }
                }
            }
        }
        all.extend(PlaceSlip::ALL.map(|slip| Strides {
            slip,
            ..Strides::RIGHT
        }));
        all.retain(|one| *one != Strides::RIGHT);
        all.dedup();
        all
    }

    /// The same, so many values later.
    pub fn later(self, count: isize) -> Strides {
        self.moved((count, Step::One))
    }

    /// The same with this shift.
    pub fn moved(self, shift: (isize, Step)) -> Strides {
        Strides { shift, ..self }
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
        if self.slip != PlaceSlip::None {
            says.push(self.slip.says().to_owned());
        }
        if self.k.1 {
            says.push("takes the channels of a texel in reverse order, the last first".to_owned());
        }
        says
    }

    /// As a sentence without its subject, of whole texels.
    pub fn says_of_texels(&self) -> String {
        let mut says = self.says_of_steps();
        let sign = if self.shift.0 < 0 { '−' } else { '+' };
        let distance = match self.shift {
            (0, _) => String::new(),
            (count, Step::One) => count.unsigned_abs().to_string(),
            (_, Step::Plane) => "width · height".to_owned(),
            _ => "width".to_owned(),
        };
        if !distance.is_empty() {
            says.push(format!(
                "shows as texel i what is stored for texel i {sign} {distance}"
            ));
        }
        says.join(", and ")
    }

    /// As a sentence without its subject. `values` is what the block holds; a texel of it has `channels`.
    pub fn says(&self, values: &str, channels: usize) -> String {
        let mut says = self.says_of_steps();
        let count = self.shift.0.unsigned_abs();
        let way = if self.shift.0 < 0 { "early" } else { "late" };
        match self.shift {
            (0, _) => {}
            (_, Step::Row) => says.push(format!("reads every value one row too {way}")),
            (_, Step::RowOfOne) => says.push(format!(
                "reads every value too {way}, by as many bytes as the picture has columns"
            )),
            (_, Step::Plane) => says.push(format!(
                "reads every value too {way}, by as many bytes as the picture has texels"
            )),
            _ => {
                let bytes = if count == 1 { "byte" } else { "bytes" };
                let texels = match count.is_multiple_of(channels) {
                    true => format!(" ({} texels)", count / channels),
                    false => String::new(),
                };
                says.push(format!(
                    "reads every value {count} {bytes} too {way}{texels}"
                ));
            }
        }
        format!("{}, in {values}", says.join(", and "))
    }

    /// Whether bytes are skipped between values that stand side by side.
    pub fn leaves_gaps(&self) -> bool {
        matches!(self.y.0, Step::PaddedRow(_) | Step::LongRow) || self.x.0 == Step::LongTexel
    }

    /// Whether it is the order of rows or columns that is wrong, and nothing else.
    pub fn is_of_rows(&self) -> bool {
        let order = Strides {
            x: self.x,
            y: self.y,
            slip: self.slip,
            ..Strides::RIGHT
        };
        *self == order
    }
}
