//! The last message that a crashed program printed.

/// Prefixes of lines that interpreters print after the message: locations, versions and hints.
const TRAILER_PREFIXES: [&str; 8] = [
    "at ",
    "from ",
    "... ",
    "Node.js v",
    "note: ",
    "}",
    "Execution of ",
    "BEGIN failed",
];

/// The beginning of the last line that Node.js prints after an error that no code handles.
const NODE_VERSION: &str = "\nNode.js v";

/// The line with which Python begins the trace of an exception.
const PYTHON_TRACE: &str = "Traceback (most recent call last):";

/// Returns `separator`, a label and the last message on standard error, or an empty string if there is no message.
#[must_use]
pub fn quote_last_message(separator: &str, stderr: &str) -> String {
    last_message(stderr).map_or(String::new(), |line| {
        format!("{separator}last message on its standard error: {line}")
    })
}

/// Returns the last line of standard error that looks like a message, if any. The locations in a trace are no messages.
#[must_use]
pub fn last_message(stderr: &str) -> Option<&str> {
    if let Some((_, trace)) = stderr.rsplit_once(PYTHON_TRACE) {
        // The message follows the indented locations, and may have several lines.
        let mut lines = trace.lines().filter(|line| !line.is_empty());
        let message = lines.find(|line| !line.starts_with([' ', '\t']));
        if let Some(message) = message {
            return Some(message.trim_end());
        }
    }
    if let Some((trace, _)) = stderr.rsplit_once(NODE_VERSION) {
        // The locations, and then the properties of the error, follow the message.
        let location = |line: &&str| line.starts_with("    at ");
        let before = trace.lines().take_while(|line| !location(line));
        let message = before.filter(|line| !line.trim().is_empty()).last();
        if let Some(message) = message.filter(|_| trace.lines().any(|line| location(&line))) {
            return Some(message.trim_end());
        }
    }
    let lines = stderr.lines().rev().map(str::trim_end);
    let mut messages = lines.filter(|line| !line.is_empty());
    let is_trailer = |line: &&str| {
        let line = line.trim_start();
        TRAILER_PREFIXES.iter().any(|word| line.starts_with(word))
    };
    messages
        .clone()
        .find(|line| !is_trailer(line))
        .or(messages.next())
}

#[cfg(test)]
mod tests {
    use super::last_message;

    #[test]
    fn last_message_of_perl_has_a_place() {
        let perl = "syntax error at d.pl line 3, near \"my \"\nExecution of d.pl aborted due to compilation errors.\n";
        assert_eq!(
            last_message(perl),
            Some("syntax error at d.pl line 3, near \"my \"")
        );
    }

    #[test]
    fn last_message_omits_interpreter_trailers() {
        let node = "dec.js:3\n  f();\n  ^\n\nTypeError: f is not a function\n    at main (dec.js:3:5)\n\nNode.js v20.20.2\n";
        assert_eq!(last_message(node), Some("TypeError: f is not a function"));
        let with_code = "d.js:3\n  f();\n  ^\n\nRangeError [ERR_OUT_OF_RANGE]: too large\n    at f (d.js:3:5) {\n  code: 'ERR_OUT_OF_RANGE'\n}\n\nNode.js v20.20.2\n";
        assert_eq!(
            last_message(with_code),
            Some("RangeError [ERR_OUT_OF_RANGE]: too large")
        );
        let python =
            "Traceback (most recent call last):\n  File \"d.py\", line 1\nValueError: bad\n";
        assert_eq!(last_message(python), Some("ValueError: bad"));
        let two_lines = python.replace("bad", "bad\nvery bad");
        assert_eq!(last_message(&two_lines), Some("ValueError: bad"));
        let ruby = "d.rb:9:in 'header': bad (ArgumentError)\n\tfrom d.rb:98:in '<main>'\n";
        assert_eq!(
            last_message(ruby),
            Some("d.rb:9:in 'header': bad (ArgumentError)")
        );
        let java = "Exception in thread \"main\" E: outer\n\tat D.main(D.java:3)\nCaused by: E: bad\n\tat D.f(D.java:9)\n\t... 1 more\n";
        assert_eq!(last_message(java), Some("Caused by: E: bad"));
        assert_eq!(last_message("\n"), None);
        assert_eq!(last_message("note: this is all"), Some("note: this is all"));
    }
}
