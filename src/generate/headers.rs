//! Rewriting of the headers of a stream: another order, another component id.

use super::plan::Stream;
use crate::codec::segments::{Segment, join_segments, split_segments};

// A marker, and offsets after the length of a segment.
const JFIF: u8 = 0xe0;
const COMPONENT_OF_FRAME: usize = 6;
const COMPONENT_OF_SCAN: usize = 1;

/// Returns the stream with the headers that `style` requests.
pub(super) fn with_headers(stream: &[u8], style: &Stream) -> Vec<u8> {
    let (mut segments, data) = split_segments(stream).expect("a stream of our encoders");
    if !style.jfif {
        segments.retain(|segment| segment.code != JFIF);
    }
    let is_frame = |segment: &Segment| matches!(segment.code, 0xc0 | 0xc1 | 0xf7);
    if let Some(frame) = segments.iter().position(is_frame) {
        segments[frame].content[COMPONENT_OF_FRAME] = style.component;
        // DQT of JPEG, LSE of JPEG-LS.
        let tables = (segments.iter()).position(|segment| matches!(segment.code, 0xdb | 0xf8));
        if let Some(tables) = tables.filter(|_| style.frame_moved) {
            let header = segments.remove(frame);
            segments.insert(tables, header);
        }
    }
    if let Some(scan) = segments.last_mut() {
        scan.content[COMPONENT_OF_SCAN] = style.component;
    }
    join_segments(&segments, data)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::jpeg::{self, JpegOptions};
    use crate::codec::jpeg_ls::{self, JpegLsOptions, PresetParameters};

    /// Returns the markers of the segments up to the scan header.
    fn markers(stream: &[u8]) -> Vec<u8> {
        let (segments, _) = split_segments(stream).expect("a stream of our encoders");
        segments.iter().map(|segment| segment.code).collect()
    }

    const MOVED: Stream = Stream {
        jfif: false,
        frame_moved: true,
        component: 0,
        ..Stream::PLAIN
    };

    #[test]
    fn plain_headers_stay_as_they_are() {
        let stream = jpeg::encode(&[100; 6], 3, 2, &JpegOptions::new(75)).stream;
        assert_eq!(with_headers(&stream, &Stream::PLAIN), stream);
    }

    #[test]
    fn a_frame_may_stand_before_tables_and_the_component_have_any_number() {
        let encoded = jpeg::encode(&[100; 6], 3, 2, &JpegOptions::new(75));
        let moved = with_headers(&encoded.stream, &MOVED);
        assert_eq!(markers(&moved), [0xc0, 0xdb, 0xc4, 0xc4, 0xda]);
        assert_eq!(jpeg::decode(&moved, 3, 2), Ok(encoded.samples));
    }

    #[test]
    fn presets_may_stand_before_the_frame() {
        let options = JpegLsOptions {
            near: 0,
            presets: Some(PresetParameters::default()),
        };
        let encoded = jpeg_ls::encode(&[100; 6], 3, 2, &options);
        let moved = with_headers(&encoded.stream, &MOVED);
        assert_eq!(markers(&moved), [0xf8, 0xf7, 0xda]);
        assert_eq!(jpeg_ls::decode(&moved, 3, 2), Ok(encoded.samples));
    }
}
