//! The segments of a JPEG stream, taken apart and changed: what a decoder reads that takes them for something else.

use crate::codec::segments::{Segment, apart, together};

// Markers that are changed (T.81 Table B.1). A frame header may have any of its kinds.
pub(super) const SOF: u8 = 0xC0;
pub(super) const DHT: u8 = 0xC4;
pub(super) const SOS: u8 = 0xDA;
pub(super) const DQT: u8 = 0xDB;
pub(super) const DRI: u8 = 0xDD;

/// The stream with other segments; nothing where they are the same.
pub(super) fn changed(stream: &[u8], change: fn(&mut Vec<Segment>)) -> Option<Vec<u8>> {
    let (mut segments, data) = apart(stream).ok()?;
    change(&mut segments);
    let changed = together(&segments, data);
    (changed != stream).then_some(changed)
}

/// Changes each segment of one kind.
pub(super) fn each(segments: &mut [Segment], kind: u8, change: fn(&mut Segment)) {
    let is_frame = |of: u8| matches!(of, 0xC0..=0xC3);
    let is_of = |of: u8| of == kind || kind == SOF && is_frame(of);
    for segment in segments.iter_mut().filter(|segment| is_of(segment.code)) {
        change(segment);
    }
}

/// Takes away the tables of a kind whose number another had before them. Tables that share a segment are one.
pub(super) fn keep_first(segments: &mut Vec<Segment>, kind: u8) {
    let mut numbers = Vec::new();
    segments.retain(|segment| {
        if segment.code != kind {
            return true;
        }
        let number = segment.content.first().copied().map(|number| match kind {
            DHT => number,
            _ => number & 15,
        });
        let is_new = !numbers.contains(&number);
        numbers.push(number);
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
            at += match self.code {
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
