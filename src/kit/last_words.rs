//! The last message of a program that crashed.

/// Beginnings of lines that interpreters print after the message: locations, versions, hints.
const TRAILER_PREFIXES: [&str; 4] = ["at ", "Node.js v", "note: ", "}"];

/// Returns the last line of standard error that is a message, or `None`.
pub(crate) fn last_words(stderr: &str) -> Option<&str> {
    let lines = stderr.lines().rev().map(str::trim_end);
    let mut said = lines.filter(|line| !line.is_empty());
    let is_afterword = |line: &&str| {
        let line = line.trim_start();
        TRAILER_PREFIXES.iter().any(|word| line.starts_with(word))
    };
    said.clone()
        .find(|line| !is_afterword(line))
        .or(said.next())
}

#[cfg(test)]
mod tests {
    use super::last_words;

    #[test]
    fn last_words_omit_interpreter_trailers() {
        let node = "dec.js:3\n  f();\n  ^\n\nTypeError: f is not a function\n    at main (dec.js:3:5)\n\nNode.js v20.20.2\n";
        assert_eq!(last_words(node), Some("TypeError: f is not a function"));
        let python =
            "Traceback (most recent call last):\n  File \"d.py\", line 1\nValueError: bad\n";
        assert_eq!(last_words(python), Some("ValueError: bad"));
        assert_eq!(last_words("\n"), None);
        assert_eq!(last_words("note: this is all"), Some("note: this is all"));
    }
}
