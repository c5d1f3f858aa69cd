//! Rewrites the headers of a stream in a different order or with a different component id.

use super::plan::Stream;
use ptm::codec::segments::{MarkerSegment, join_segments, split_segments};

// A marker code, and offsets in the contents of segments.
const JFIF: u8 = 0xe0;
const COMPONENT_OF_FRAME: usize = 6;
const COMPONENT_OF_SCAN: usize = 1;

pub fn rewrite_headers(stream: &[u8], style: &Stream) -> Vec<u8> {
    let (mut segments, data) = split_segments(stream).expect("the encoders write valid streams");
    if !style.jfif {
        segments.retain(|segment| segment.code != JFIF);
    }
    let is_frame = |segment: &MarkerSegment| matches!(segment.code, 0xc0 | 0xc1 | 0xf7);
    if let Some(frame) = segments.iter().position(is_frame) {
        segments[frame].content[COMPONENT_OF_FRAME] = style.component;
        // DQT in JPEG, LSE in JPEG-LS.
        let tables = (segments.iter()).position(|segment| matches!(segment.code, 0xdb | 0xf8));
        if let Some(tables) = tables.filter(|_| style.moves_frame_header) {
            let header = segments.remove(frame);
            segments.insert(tables, header);
        }
    }
    if let Some(scan) = segments.last_mut() {
        scan.content[COMPONENT_OF_SCAN] = style.component;
    }
    join_segments(&segments, data)
}
