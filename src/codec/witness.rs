//! Streams for tests, in the notation of the standards.

/// Parses bytes in hexadecimal, with spaces anywhere, and `01*64` for sixty-four bytes 01.
pub(super) fn bytes(text: &str) -> Vec<u8> {
    let word = |word: &str| {
        let (digits, times) = word.split_once('*').unwrap_or((word, "1"));
        let byte = u8::from_str_radix(digits, 16).expect("two hexadecimal digits");
        vec![byte; times.parse().expect("a number of times")]
    };
    text.split_whitespace().flat_map(word).collect()
}
