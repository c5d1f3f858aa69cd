//! The example decoder passes, and copies of it with one mistake each fail the case for that mistake and not its sibling.
#![cfg(all(unix, feature = "cli"))]

mod common;

use std::fs;

use common::{check_with, have, repository};

const DECODER: &str = "examples/decoders/ptm_decoder.py";

/// A copy with one mistake.
struct Copy {
    name: &'static str,
    find: &'static str,
    replace: &'static str,
    /// The case written for the clause that is now misread.
    fails: &'static str,
    /// A case that differs in not exercising it.
    passes: &'static str,
}

const COPIES: &[Copy] = &[
    copy(
        "rows-top-down",
        "reversed(range(height))",
        "range(height)",
        "rows-run-upwards-1x2-rgb",
        "texels-run-to-the-right-2x1-rgb",
    ),
    copy(
        "big-endian-index",
        "\"little\")",
        "\"big\")",
        "table-of-257-entries-ptm-lut",
        "table-of-255-entries-ptm-lut",
    ),
    copy(
        "width-at-256",
        "len(entries) <= 256",
        "len(entries) < 256",
        "table-of-256-entries-ptm-lut",
        "table-of-255-entries-ptm-lut",
    ),
    copy(
        "width-at-258",
        "len(entries) <= 256",
        "len(entries) <= 257",
        "table-of-257-entries-ptm-lut",
        "table-of-256-entries-ptm-lut",
    ),
    copy(
        "width-by-largest-index",
        "1 if len(entries) <= 256 else 2",
        "1 if len(entries) <= 256 or not any(source.file[source.at + 1:source.at + 2 * count:2]) else 2",
        "table-of-300-entries-all-indices-small-ptm-c-lut",
        "table-of-300-entries-ptm-c-lut",
    ),
    copy(
        "rgb-eighteen-interleaved",
        "return [r + g + b for r, g, b in zip(red, green, blue)]",
        "return groups(blocks, 18)",
        "hand-rgb-blocks",
        "one-texel-rgb",
    ),
    copy(
        "lrgb-nine-interleaved",
        "luminance = groups(source.bytes(count * 6), 6)",
        "return groups(source.bytes(count * 9), 9)",
        "hand-lrgb-blocks",
        "one-texel-lrgb",
    ),
    copy(
        "cb-before-cr",
        "return groups(source.bytes(count * 8), 8)",
        "return [texel[:6] + texel[:5:-1] for texel in groups(source.bytes(count * 8), 8)]",
        "hand-lum",
        "payload-of-white-space-lum",
    ),
    copy(
        "coefficient-truncated",
        "return [(raw - ptm.bias[i % 6]) * ptm.scale[i % 6] if",
        "return [int((raw - ptm.bias[i % 6]) * ptm.scale[i % 6]) if",
        "hand-final-coefficients",
        "scale-hp-viewer-lrgb",
    ),
    copy(
        "v-negated",
        "return name, [float(word) for word in words]",
        "return name, [float(words[0]), -float(words[1])]",
        "lrgb-under-0-0-5",
        "lrgb-under-0-5-0",
    ),
    copy(
        "u-negated",
        "return name, [float(word) for word in words]",
        "return name, [-float(words[0]), float(words[1])]",
        "lrgb-under-0-5-0",
        "lrgb-under-0-0-5",
    ),
    copy(
        "color-over-256-truncated",
        "[luminance * channel / 255",
        "[luminance * channel // 256",
        "luminance-is-divided-by-255-lrgb",
        "luminance-of-254-rgb",
    ),
    copy(
        "clamp-before-color",
        "[luminance * channel / 255",
        "[min(255.0, max(0.0, luminance)) * channel / 255",
        "luminance-beyond-255-times-a-dark-color-lrgb",
        "luminance-of-127-lrgb",
    ),
    copy(
        "greedy-whitespace",
        "self.at = end + 1",
        "self.at = len(self.file) - len(self.file[end:].lstrip())",
        "payload-begins-with-0x20-lrgb",
        "payload-of-digits-lrgb",
    ),
    copy(
        "no-space-before-newline",
        "* ?\")",
        "*\")",
        "space-behind-scale-lrgb",
        "header-plain-lrgb",
    ),
    copy(
        "double-space-dies",
        "(?: +[!-~]+)",
        "(?: [!-~]+)",
        "gap-of-2-spaces-lrgb",
        "header-plain-lrgb",
    ),
    copy(
        "exponent-refused",
        "(?:[eE][+-]?[0-9]+)?\")",
        "\")",
        "scale-exponents-lrgb",
        "scale-hp-viewer-lrgb",
    ),
    copy(
        "size-two-lines-only",
        "if len(words) == 1:",
        "if len(words) <= 2:",
        "size-on-one-line-lrgb",
        "header-plain-lrgb",
    ),
    copy(
        "scale-bias-two-lines-only",
        "if len(words) == 6:",
        "if len(words) in (6, 12):",
        "scale-and-bias-on-one-line-lrgb",
        "header-plain-lrgb",
    ),
    copy(
        "bias-in-a-byte",
        "[whole_number(word) for word in words[6:]]",
        "[whole_number(word) % 256 for word in words[6:]]",
        "bias-negative-lrgb",
        "bias-hp-viewer-lrgb",
    ),
    copy(
        "matrix-transposed-but-translation",
        "m[row] * y + m[row + 4] * cr + m[row + 8] * cb",
        "m[4 * row] * y + m[4 * row + 1] * cr + m[4 * row + 2] * cb",
        "lum-translated-0-0",
        "hand-lum-in-color",
    ),
    copy(
        "index-clamped",
        "[int.from_bytes(index, \"little\") for",
        "[min(int.from_bytes(index, \"little\"), len(entries) - 1) for",
        "index-past-the-last-entry-5-ptm-lut",
        "lut-plain-5-ptm-lut",
    ),
    copy(
        "short-payload-padded",
        "raise Malformed(\"%d bytes needed, %d remain\" % (size, len(self.file) - self.at))",
        "self.file = self.file.ljust(self.at + size, b\"\\0\")",
        "one-byte-short-lrgb",
        "payload-plain-lrgb",
    ),
    copy(
        "version-unchecked",
        "if words != [b\"PTM_1.2\"]:",
        "if False:",
        "version-1-3-lrgb",
        "header-plain-lrgb",
    ),
];

const fn copy(
    name: &'static str,
    find: &'static str,
    replace: &'static str,
    fails: &'static str,
    passes: &'static str,
) -> Copy {
    Copy {
        name,
        find,
        replace,
        fails,
        passes,
    }
}

#[test]
fn the_python_decoder_passes() {
    if !have("python3") {
        return;
    }
    let checked = check_with(&[], &["python3", &repository(DECODER)]);
    assert_eq!(checked.status, 0, "{}", checked.text);
    assert_eq!(checked.report["verdict"], "pass");
    assert!(checked.cases("pass").len() > 700 && checked.cases("fail").is_empty());
}

#[test]
fn a_format_that_is_left_out_is_unsupported_and_no_failure() {
    if !have("python3") {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let text = fs::read_to_string(repository(DECODER)).expect("the decoder");
    let find = "    b\"PTM_FORMAT_LUM\": read_lum,\n";
    assert_eq!(text.matches(find).count(), 1);
    // A format that nobody reads is unsupported.
    let without = "def lacking(*_):\n    raise Unsupported(\"LUM\")\n\n\n";
    let table = text[..text.find(find).expect("the line")]
        .rfind("\n\n")
        .expect("a blank line")
        + 2;
    let text = format!(
        "{}{without}{}",
        &text[..table],
        text[table..].replace(find, "    b\"PTM_FORMAT_LUM\": lacking,\n")
    );
    let path = scratch.path().join("without lum.py");
    fs::write(&path, text).expect("a copy");
    let path = path.to_string_lossy();
    let checked = check_with(
        &["--case", "hand-*", "--case", "first-*", "--case", "lum-*"],
        &["python3", &path],
    );
    assert_eq!(checked.status, 0, "{}", checked.text);
    assert_eq!(
        checked.report["decoder"]["unsupported"],
        serde_json::json!(["LUM", "rgb of LUM"])
    );
    assert!(
        checked
            .cases("unsupported")
            .contains(&"hand-lum".to_owned())
    );
}

#[test]
fn each_broken_copy_fails_the_case_for_its_mistake_and_passes_the_sibling() {
    if !have("python3") {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let text = fs::read_to_string(repository(DECODER)).expect("the decoder");
    for Copy {
        name,
        find,
        replace,
        fails,
        passes,
    } in COPIES
    {
        assert_eq!(text.matches(find).count(), 1, "{name}: {find}");
        let path = scratch.path().join(format!("{name}.py"));
        fs::write(&path, text.replace(find, replace)).expect("a copy");
        let checked = check_with(
            &["--case", fails, "--case", passes],
            &["python3", &path.to_string_lossy()],
        );
        assert_eq!(checked.status, 1, "{name}: {}", checked.text);
        assert_eq!(
            (checked.cases("fail"), checked.cases("pass")),
            (vec![(*fails).to_owned()], vec![(*passes).to_owned()]),
            "{name}: {}",
            checked.text
        );
        assert!(
            checked.diagnoses().contains(&(*name).to_owned()) || checked.diagnoses().len() == 1,
            "{name}: {:?}",
            checked.diagnoses()
        );
    }
}
