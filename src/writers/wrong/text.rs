//! The same file with its header, its line ends or the end of its payload written in another way.

use crate::misreadings::Anatomy;
use crate::reading::Reading;
use crate::writers::request::WriteRequest;

/// A file with its parts at hand.
struct RightFile<'a> {
    request: &'a WriteRequest,
    /// The lines of the header, without their ends.
    lines: Vec<String>,
    payload: &'a [u8],
}

/// Variants of the right file.
pub(super) fn candidates(request: &WriteRequest, right: &[u8]) -> Vec<Vec<u8>> {
    let start = Anatomy::of(right, &Reading::SPEC).payload();
    let Ok(header) = std::str::from_utf8(&right[..start]) else {
        return Vec::new();
    };
    let file = RightFile {
        request,
        lines: header.lines().map(str::to_owned).collect(),
        payload: &right[start..],
    };
    if request.format.is_compressed() {
        // Headers are the same in every format, and streams take their time.
        return file.without_lines();
    }
    [
        file.names(),
        file.sizes(),
        file.numbers(),
        file.line_ends(),
        file.payloads(),
        file.without_lines(),
    ]
    .concat()
}

impl RightFile<'_> {
    fn of_lines(&self, lines: &[String]) -> Vec<u8> {
        [(lines.join("\n") + "\n").as_bytes(), self.payload].concat()
    }

    /// With one line of the header replaced.
    fn with_line(&self, i: usize, line: impl Into<String>) -> Vec<u8> {
        let mut lines = self.lines.clone();
        lines[i] = line.into();
        self.of_lines(&lines)
    }

    /// With other bytes between header and payload.
    fn with_between(&self, end: &[u8], payload: &[u8]) -> Vec<u8> {
        [self.lines.join("\n").as_bytes(), end, payload].concat()
    }

    /// 2.1 and 2.2.
    fn names(&self) -> Vec<Vec<u8>> {
        let versions = [
            "PTM_1.1", "PTM_1.3", "PTM_1.20", "PTM_1.2b", "PTM_2.0", "ptm_1.2", "XPTM_1.2",
        ];
        let versions = versions.iter().map(|version| self.with_line(0, *version));
        let name = &self.lines[1];
        let swapped = match name.as_str() {
            "PTM_FORMAT_PTM_LUT" => "PTM_FORMAT_PTM_C_LUT",
            "PTM_FORMAT_PTM_C_LUT" => "PTM_FORMAT_PTM_LUT",
            _ => name,
        };
        let names = [
            name.to_lowercase(),
            name["PTM_FORMAT_".len()..].to_owned(),
            format!("{name}_1"),
            format!("X{name}"),
            swapped.to_owned(),
        ];
        versions
            .chain(names.iter().map(|name| self.with_line(1, name)))
            .collect()
    }

    /// 2.3.
    fn sizes(&self) -> Vec<Vec<u8>> {
        let (width, height) = (self.request.header.width, self.request.header.height);
        let mut exchanged = self.lines.clone();
        exchanged.swap(2, 3);
        let widths = [
            format!("-{width}"),
            (u64::from(width) + (1 << 32)).to_string(),
            (u128::from(width) + (1 << 64)).to_string(),
            format!("{width} 1"),
            format!("0{width:o}"),
            format!("0x{width:x}"),
        ];
        let widths = widths.iter().map(|width| self.with_line(2, width));
        let heights = [format!("{height} 1"), format!("0{height:o}")];
        let heights = heights.iter().map(|height| self.with_line(3, height));
        [self.of_lines(&exchanged)]
            .into_iter()
            .chain(widths)
            .chain(heights)
            .collect()
    }

    /// 2.4 and 2.6.
    fn numbers(&self) -> Vec<Vec<u8>> {
        let scales: Vec<&str> = self.lines[4].split(' ').collect();
        let biases: Vec<&str> = self.lines[5].split(' ').collect();
        let with = |of: &[&str], spell: fn(&str) -> String| {
            of.iter()
                .map(|text| spell(text))
                .collect::<Vec<_>>()
                .join(" ")
        };
        let mut files = vec![
            self.with_line(4, with(&scales, |text| format!("{text}f"))),
            self.with_line(4, format!("{} 1", self.lines[4])),
            self.with_line(5, format!("{} 0", self.lines[5])),
            self.with_line(5, with(&biases, |text| format!("{text}.7"))),
            self.with_line(4, with(&scales, hexadecimal)),
        ];
        if self.request.header.matrix.is_some() {
            let shorter = self.lines[6].rsplit_once(' ').map_or("", |(line, _)| line);
            files.push(self.with_line(6, shorter));
        }
        files
    }

    /// Between header and payload, and all lines of the header.
    fn line_ends(&self) -> Vec<Vec<u8>> {
        let ends: [&[u8]; 12] = [
            b"\n\n",
            b"\n\r",
            b"\n ",
            b"\n\t",
            b"\n\x0c",
            b"\r\n",
            b"\n\r\n",
            b"\n\xef\xbb\xbf",
            b"\n# written by a program\n",
            b" \n",
            b" \n\n",
            b" ",
        ];
        let ends = ends.iter().map(|end| self.with_between(end, self.payload));
        let mut lines = self.lines.join("\r\n");
        lines += "\r\n";
        ends.chain([[lines.as_bytes(), self.payload].concat()])
            .collect()
    }

    /// Bytes that a writer of text adds, or loses.
    fn payloads(&self) -> Vec<Vec<u8>> {
        let payload = self.payload;
        let added = payload.iter().flat_map(|&byte| match byte {
            b'\n' => vec![b'\r', b'\n'],
            byte => vec![byte],
        });
        let mut payloads = vec![
            added.collect(),
            payload.iter().rev().copied().collect(),
            [payload, &[0]].concat(),
            [payload, b"\n"].concat(),
        ];
        if let Some(zeros) = payload
            .iter()
            .rev()
            .position(|&byte| byte != 0)
            .filter(|&zeros| zeros > 0)
        {
            payloads.push(payload[..payload.len() - zeros].to_vec());
        }
        if let Some(of_block) = self.blocks() {
            let (first, rest) = payload.split_at(of_block.min(payload.len()));
            payloads.push([first, b"\n", rest].concat());
        }
        if let [18] = [self.request.format.channels()]
            && !self.request.format.is_compressed()
        {
            let block = payload.len() / 3;
            payloads.push(payload.chunks(block).collect::<Vec<_>>().join(&b'\n'));
        }
        payloads
            .iter()
            .map(|payload| self.with_between(b"\n", payload))
            .collect()
    }

    /// Where the first block of an uncompressed payload ends.
    fn blocks(&self) -> Option<usize> {
        let texels = self.request.size().texels();
        (!self.request.format.has_table() && !self.request.format.is_compressed())
            .then_some(6 * texels)
    }

    /// With one line of the header left out, or two joined.
    fn without_lines(&self) -> Vec<Vec<u8>> {
        let left_out = (6..self.lines.len()).map(|i| {
            let mut lines = self.lines.clone();
            lines.remove(i);
            self.of_lines(&lines)
        });
        left_out.collect()
    }
}

/// A number as C's `%a` writes it.
fn hexadecimal(text: &str) -> String {
    match text.parse::<f64>() {
        Ok(number) if number.fract() == 0.0 && (0.0..1e9).contains(&number) => {
            format!("0x{:x}", number as u64)
        }
        Ok(number) => {
            let exponent = 40;
            let scaled = number * f64::from(2).powi(exponent);
            let sign = if scaled < 0.0 { "-" } else { "" };
            format!("{sign}0x{:x}p-{exponent}", scaled.abs() as u64)
        }
        Err(_) => text.to_owned(),
    }
}
