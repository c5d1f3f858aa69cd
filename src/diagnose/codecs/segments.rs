//! The segments of a JPEG stream, taken apart and changed: what a decoder reads that takes them for something else.

/// A marker segment before the data, the scan header as the last of them.
pub(super) struct Segment {
    /// Its marker, by the second byte.
    pub kind: u8,
    /// What stands behind its length.
    pub content: Vec<u8>,
}

// Markers that are changed (T.81 Table B.1). A frame header may have any of its kinds.
pub(super) const SOF: u8 = 0xC0;
pub(super) const DHT: u8 = 0xC4;
pub(super) const SOS: u8 = 0xDA;
pub(super) const DQT: u8 = 0xDB;
pub(super) const DRI: u8 = 0xDD;

/// The stream with other segments. Nothing of a stream that has none, or whose data are not found.
pub(super) fn changed(stream: &[u8], change: fn(&mut Vec<Segment>)) -> Option<Vec<u8>> {
    let (mut segments, data) = apart(stream)?;
    change(&mut segments);
    let mut changed = stream[..2].to_vec();
    for segment in segments {
        let length = u16::try_from(segment.content.len() + 2).ok()?;
        changed.extend([0xFF, segment.kind]);
        changed.extend(length.to_be_bytes());
        changed.extend(segment.content);
    }
    changed.extend(data);
    Some(changed)
}

fn apart(stream: &[u8]) -> Option<(Vec<Segment>, &[u8])> {
    let mut segments = Vec::new();
    let mut rest = stream.get(2..)?;
    while segments
        .last()
        .is_none_or(|last: &Segment| last.kind != SOS)
    {
        // Fill bytes are no part of a segment.
        while rest.get(1) == Some(&0xFF) {
            rest = &rest[1..];
        }
        let [_, kind, high, low, ..] = *rest else {
            return None;
        };
        let end = 2 + usize::from(u16::from_be_bytes([high, low]));
        segments.push(Segment {
            kind,
            content: rest.get(4..end)?.to_vec(),
        });
        rest = &rest[end..];
    }
    Some((segments, rest))
}

/// Changes each segment of one kind.
pub(super) fn each(segments: &mut [Segment], kind: u8, change: fn(&mut Segment)) {
    let is_frame = |of: u8| matches!(of, 0xC0..=0xC3);
    let is_of = |of: u8| of == kind || kind == SOF && is_frame(of);
    for segment in segments.iter_mut().filter(|segment| is_of(segment.kind)) {
        change(segment);
    }
}

/// Takes away the tables of a kind whose number another had before them. Tables that share a segment are one.
pub(super) fn keep_first(segments: &mut Vec<Segment>, kind: u8) {
    let mut numbers = Vec::new();
    segments.retain(|segment| {
        let number = segment.content.first().copied().map(|number| match kind {
            DHT => number,
            _ => number & 15,
        });
        let is_new = segment.kind != kind || !numbers.contains(&number);
        if segment.kind == kind {
            numbers.push(number);
        }
        is_new
    });
}

impl Segment {
    /// Where its tables begin: those of Huffman codes have sixteen counts, those of steps 64 numbers.
    fn tables(&self) -> Vec<usize> {
        let mut starts = Vec::new();
        let mut at = 0;
        while let Some(&number) = self.content.get(at) {
            starts.push(at);
            at += match self.kind {
                DHT => {
                    let counts = self.content[at + 1..].iter().take(16);
                    17 + counts.map(|&count| usize::from(count)).sum::<usize>()
                }
                _ => 1 + 64 * (1 + usize::from(number >> 4)),
            };
        }
        starts
    }

    /// Changes the byte in which each table has its number.
    pub fn renumber(&mut self, change: fn(u8) -> u8) {
        for at in self.tables() {
            self.content[at] = change(self.content[at]);
        }
    }

    /// Exchanges the two bytes of each step that has two.
    pub fn exchange_bytes(&mut self) {
        for at in self.tables() {
            if self.content[at] >> 4 == 1 {
                for step in self.content[at + 1..].chunks_exact_mut(2).take(64) {
                    step.swap(0, 1);
                }
            }
        }
    }

    /// Takes away all tables but the first.
    pub fn keep_first_table(&mut self) {
        if let Some(&second) = self.tables().get(1) {
            self.content.truncate(second);
        }
    }
}
