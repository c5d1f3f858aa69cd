//! Compressed files made by hand: lists as they are written to the file, planes as they are stored.
//!
//! Nothing here predicts. A test states the residuals of a stream and the plane that it expects,
//! and derives one from the other on paper.

use crate::codec::{jpeg, jpeg_ls};
use crate::ptm::{Format, Size};

/// A file before it is written.
#[derive(Clone, Debug)]
pub struct ByHand {
    pub format: Format,
    pub size: Size,
    pub parameter: i64,
    pub transforms: Vec<i64>,
    pub motion: Vec<i64>,
    pub order: Vec<i64>,
    pub references: Vec<i64>,
    pub streams: Vec<Vec<u8>>,
    pub sides: Vec<Vec<u8>>,
}

impl ByHand {
    /// Makes a file of intra coded planes, plane i full of the value 10 · i, without side information.
    pub fn new(format: Format, width: u32, height: u32) -> ByHand {
        let planes = format.channels();
        let mut file = ByHand {
            format,
            size: Size { width, height },
            parameter: if jpeg(format) { 100 } else { 0 },
            transforms: vec![0; planes],
            motion: vec![0; 2 * planes],
            order: vec![0; planes],
            references: vec![-1; planes],
            streams: vec![Vec::new(); planes],
            sides: vec![Vec::new(); planes],
        };
        for plane in 0..planes {
            file.stream(plane, &vec![10 * plane as u8; file.size.texels()]);
        }
        file
    }

    /// Gives plane `plane` a stream of these samples, the bottom row of the image first.
    pub fn stream(&mut self, plane: usize, samples: &[u8]) {
        let Size { width, height } = self.size;
        let encoded = if jpeg(self.format) {
            jpeg::encode(samples, width, height, &jpeg::JpegOptions::new(100))
        } else {
            jpeg_ls::encode(
                samples,
                width,
                height,
                &jpeg_ls::JpegLsOptions {
                    near: 0,
                    presets: None,
                },
            )
        };
        // At quality 100 a flat block is restored exactly; tests with JPEG planes use nothing else.
        assert_eq!(encoded.samples, samples, "the samples of plane {plane}");
        self.streams[plane] = encoded.stream;
    }

    /// Predicts plane `plane`, of rank `rank`, from `reference`: its stream holds these residuals.
    pub fn predicted(
        &mut self,
        plane: usize,
        rank: i64,
        reference: i64,
        transform: i64,
        residuals: &[u8],
    ) {
        self.order[plane] = rank;
        self.references[plane] = reference;
        self.transforms[plane] = transform;
        self.stream(plane, residuals);
    }

    /// Displaces the reference of plane `plane`.
    pub fn displace(&mut self, plane: usize, mx: i64, my: i64) {
        self.motion[plane] = mx;
        self.motion[self.format.channels() + plane] = my;
    }

    /// Adds a record to the side information of plane `plane`.
    pub fn record(&mut self, plane: usize, position: u32, value: u8) {
        self.sides[plane].extend(position.to_be_bytes());
        self.sides[plane].push(value);
    }

    /// Returns the header up to the biases.
    pub fn header(&self) -> String {
        let Size { width, height } = self.size;
        format!(
            "PTM_1.2\n{}\n{width}\n{height}\n1 1 1 1 1 1\n0 0 0 0 0 0\n",
            self.format
        )
    }

    /// Returns the lists, one line each.
    pub fn lists(&self) -> Vec<String> {
        let line = |numbers: &[i64]| {
            numbers
                .iter()
                .map(i64::to_string)
                .collect::<Vec<_>>()
                .join(" ")
        };
        let sizes = |parts: &[Vec<u8>]| {
            line(
                &parts
                    .iter()
                    .map(|part| part.len() as i64)
                    .collect::<Vec<_>>(),
            )
        };
        let (x, y) = self.motion.split_at(self.format.channels());
        vec![
            self.parameter.to_string(),
            line(&self.transforms),
            line(x),
            line(y),
            line(&self.order),
            line(&self.references),
            sizes(&self.streams),
            sizes(&self.sides),
        ]
    }

    /// Returns the file.
    pub fn bytes(&self) -> Vec<u8> {
        self.with(&self.header(), &self.lists())
    }

    /// Returns the file with another header or other lists.
    pub fn with(&self, header: &str, lists: &[String]) -> Vec<u8> {
        let payload = self
            .streams
            .iter()
            .zip(&self.sides)
            .flat_map(|(stream, side)| [stream, side])
            .flatten();
        let text = format!("{header}{}\n", lists.join("\n"));
        text.bytes().chain(payload.copied()).collect()
    }
}

fn jpeg(format: Format) -> bool {
    matches!(format, Format::JpegRgb | Format::JpegLrgb)
}

/// Decodes a file and returns plane `plane` as it is stored, the bottom row of the image first.
#[track_caller]
pub fn stored(file: &[u8], plane: usize) -> Vec<u8> {
    let ptm = crate::decode(file).expect("a file that decodes");
    let channels = ptm.planes.shape.channels();
    let rows = ptm
        .planes
        .samples
        .chunks_exact(ptm.planes.size.width as usize * channels)
        .rev();
    rows.flat_map(|row| row.iter().skip(plane).step_by(channels).copied())
        .collect()
}

/// Asserts that a file is refused with a message that contains `words`.
#[track_caller]
pub fn assert_rejects(file: &[u8], words: &str) {
    assert_eq!(
        crate::decode(file)
            .expect_err("a file that is refused")
            .to_string(),
        words
    );
}
