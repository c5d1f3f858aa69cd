//! The example decoder passes. Each copy with one mistake fails the case for that mistake, but passes a similar case.

use crate::common::{
    CheckRun, Workspace, check, edit, have_python, have_tool, python_example, repository_text, rows,
};

/// Copies of the decoder, each with one mistake: its name, the text to replace, the replacement, the case for the misread
/// clause, and a similar case without that clause.
const COPIES: &str = r#"
big-endian-index | "little") | "big") | table-of-257-entries-ptm-lut | table-of-255-entries-ptm-lut
width-at-256 | len(entries) <= 256 | len(entries) < 256 | table-of-256-entries-ptm-lut | table-of-255-entries-ptm-lut
width-at-258 | len(entries) <= 256 | len(entries) <= 257 | table-of-257-entries-ptm-lut | table-of-256-entries-ptm-lut
width-by-largest-index | 1 if len(entries) <= 256 else 2
  | 1 if len(entries) <= 256 or not any(source.file[source.at + 1:source.at + 2 * count:2]) else 2
  | table-of-300-entries-all-indices-small-ptm-c-lut | table-of-300-entries-ptm-c-lut
rgb-eighteen-interleaved | return [r + g + b for r, g, b in zip(red, green, blue)] | return groups(blocks, 18)
  | hand-rgb-blocks | one-texel-rgb
lrgb-nine-interleaved | luminance = groups(source.bytes(count * 6), 6) | return groups(source.bytes(count * 9), 9)
  | hand-lrgb-blocks | one-texel-lrgb
cb-before-cr | return groups(source.bytes(count * 8), 8)
  | return [texel[:6] + texel[:5:-1] for texel in groups(source.bytes(count * 8), 8)] | hand-lum
  | payload-of-white-space-lum
coefficient-truncated | return [(raw - ptm.bias[i % 6]) * ptm.scale[i % 6] if
  | return [int((raw - ptm.bias[i % 6]) * ptm.scale[i % 6]) if | hand-final-coefficients | scale-hp-viewer-lrgb
v-negated | return name, [float(word) for word in words] | return name, [float(words[0]), -float(words[1])]
  | lrgb-under-0-0-5 | lrgb-under-0-5-0
u-negated | return name, [float(word) for word in words] | return name, [-float(words[0]), float(words[1])]
  | lrgb-under-0-5-0 | lrgb-under-0-0-5
color-over-256-truncated | [luminance * channel / 255 | [luminance * channel // 256 | luminance-is-divided-by-255-lrgb
  | luminance-of-254-rgb
greedy-whitespace | self.at = end + 1 | self.at = len(self.file) - len(self.file[end:].lstrip())
  | payload-begins-with-0x20-lrgb | payload-of-digits-lrgb
no-space-before-newline | * ?") | *") | space-behind-scale-lrgb | header-plain-lrgb
exponent-refused | (?:[eE][+-]?[0-9]+)?") | ") | scale-exponents-lrgb | scale-hp-viewer-lrgb
size-two-lines-only | if len(words) == 1: | if len(words) <= 2: | size-on-one-line-lrgb | header-plain-lrgb
scale-bias-two-lines-only | if len(words) == 6: | if len(words) in (6, 12): | scale-and-bias-on-one-line-lrgb
  | header-plain-lrgb
bias-in-a-byte | [whole_number(word) for word in words[6:]] | [whole_number(word) % 256 for word in words[6:]]
  | bias-negative-lrgb | bias-hp-viewer-lrgb
matrix-transposed-but-translation | m[row] * y + m[row + 4] * cr + m[row + 8] * cb
  | m[4 * row] * y + m[4 * row + 1] * cr + m[4 * row + 2] * cb | lum-translated-0-0 | hand-lum-in-color
index-clamped | [int.from_bytes(index, "little") for | [min(int.from_bytes(index, "little"), len(entries) - 1) for
  | index-past-the-last-entry-5-ptm-lut | lut-plain-5-ptm-lut
short-payload-padded | raise Malformed("%d bytes needed, %d remain" % (size, len(self.file) - self.at))
  | self.file = self.file.ljust(self.at + size, b"\0") | one-byte-short-lrgb | payload-plain-lrgb
version-unchecked | if words != [b"PTM_1.2"]: | if False: | version-1-3-lrgb | header-plain-lrgb
"#;

/// Copies that misread section 2.9. They need Pillow.
const COMPRESSED_COPIES: &str = r#"
no-128 | (r + p - 128) % 256 | (r + p) % 256 | two-planes-predicted-jpeg-lrgb | one-texel-jpeg-lrgb
wrap-mod-255 | (r + p - 128) % 256 | (r + p - 128) % 255 | sums-around-the-ends-star-jpeg-lrgb | one-texel-jpeg-lrgb
clamp-not-wrap | (r + p - 128) % 256 | min(255, max(0, r + p - 128)) | sums-around-the-ends-star-jpeg-lrgb
  | residuals-of-nothing-jpeg-lrgb
wrap-below-only | (r + p - 128) % 256 | min(255, r + p - 128 + 256 * (r + p < 128))
  | sums-around-the-ends-star-jpeg-lrgb | residuals-of-nothing-jpeg-lrgb
order-as-sequence | sorted(range(count), key=lambda i: planes[i].rank) | [plane.rank for plane in planes]
  | planes-in-structure-deep-jpeg-lrgb | planes-in-structure-chain-jpeg-lrgb
predicted-from-residuals | reconstruct(planes, samples, i, width, height)↵
  | reconstruct(planes, [decode(s, width, height) for s, _ in streams], i, width, height)↵
  | planes-in-structure-chain-jpeg-lrgb | planes-in-structure-star-jpeg-lrgb
planes-in-decode-order | streams = [(source.bytes(plane.size), source.bytes(plane.side_size)) for plane in planes]
  | streams = [None] * count↵    for i in sorted(range(count), key=lambda i: planes[i].rank):↵        streams[i] = source.bytes(planes[i].size), source.bytes(planes[i].side_size)
  | planes-in-structure-upward-jpeg-lrgb | planes-in-structure-chain-jpeg-lrgb
inversion-from-256 | 255 - value | (256 - value) % 256 | inverted-chain-jpeg-lrgb
  | planes-in-structure-chain-jpeg-lrgb
transform-by-equality | if plane.transform & INVERSION: | if plane.transform == INVERSION:
  | inverted-and-moved-by-nothing-jpeg-lrgb | inverted-chain-jpeg-lrgb
motion-ignored | if plane.transform & MOTION: | if False: | motion-along-rows-9x7-jpeg-lrgb
  | motion-by-nothing-star-jpeg-lrgb
motion-whole-texels | lower, upper = half_steps // 2, (half_steps + 1) // 2
  | lower, upper = half_steps, half_steps | motion-along-rows-9x7-jpeg-lrgb | motion-by-nothing-star-jpeg-lrgb
vectors-y-first | neighbors(width, mx)↵    upper, lower = neighbors(height, my)
  | neighbors(width, my)↵    upper, lower = neighbors(height, mx) | motion-along-rows-9x7-jpeg-lrgb
  | motion-along-diagonals-jpeg-lrgb
vectors-interleaved | planes = [Plane(*plane) for plane in zip(*groups(numbers, count))]
  | numbers[count:3 * count] = numbers[count:3 * count:2] + numbers[count + 1:3 * count:2]↵    planes = [Plane(*plane) for plane in zip(*groups(numbers, count))]
  | motion-both-ways-jpeg-lrgb | inverted-chain-jpeg-lrgb
jpeg-rows-top-down | stored = read_compressed(source, format, width, height)
  | stored = read_compressed(source, format, width, height)↵        if b"JPEG_" in format:↵            stored = [t for y in reversed(range(height)) for t in stored[y * width:(y + 1) * width]]
  | planes-run-upwards-1x20-jpeg-lrgb | planes-run-to-the-right-20x1-jpeg-lrgb
jpeg-rows-padded-to-4 | return samples↵
  | return b"".join(row.ljust(-len(row) % 4 + len(row), b"\0") for row in groups(samples, width))[:len(samples)]↵
  | planes-in-size-5x4-jpeg-lrgb | planes-in-size-8x8-jpeg-lrgb
rgb-planes-coefficient-major | zip(*samples)]
  | zip(*(samples if count < 18 else [samples[6 * (i % 3) + i // 3] for i in range(18)]))]
  | planes-of-stripes-jpeg-rgb | planes-of-stripes-jpeg-lrgb
side-little-endian | int.from_bytes(record[:4], "big") | int.from_bytes(record[:4], "little")
  | record-at-1-of-3x5-jpeg-lrgb | record-of-the-first-texel-jpeg-lrgb
side-value-limited-to-127 | plane[position] = record[4] | plane[position] = min(record[4], 127)
  | record-values-of-0-and-255-jpeg-lrgb | lists-plain-jpeg-lrgb
side-values-added | plane[position] = record[4] | plane[position] = (plane[position] + record[4]) % 256
  | records-many-jpeg-lrgb | lists-plain-jpeg-lrgb
side-cursor-by-one | for record in groups(side, 5): | for record in [side[at:at + 5] for at in range(len(side) // 5)]:
  | records-many-jpeg-lrgb | record-of-the-first-texel-jpeg-lrgb
side-last-record-lost | for record in groups(side, 5): | for record in groups(side, 5)[:-1]:
  | record-of-the-first-texel-jpeg-lrgb | lists-plain-jpeg-lrgb
side-information-ignored | correct(samples[i], streams[i][1]) | pass | record-in-plane-4-jpeg-lrgb
  | lists-plain-jpeg-lrgb
side-information-too-late | ↵        correct(samples[i], streams[i][1])
  | ↵    for i in range(count):↵        correct(samples[i], streams[i][1]) | records-in-a-reference-star-jpeg-lrgb
  | record-at-1-of-3x5-jpeg-lrgb
side-information-of-intra-planes-ignored | correct(samples[i], streams[i][1])
  | if planes[i].reference >= 0:↵            correct(samples[i], streams[i][1]) | record-in-plane-0-jpeg-lrgb
  | records-in-predicted-planes-star-jpeg-lrgb
side-information-before-prediction
  | samples[i] = reconstruct(planes, samples, i, width, height)↵        correct(samples[i], streams[i][1])
  | samples[i] = bytearray(samples[i])↵        correct(samples[i], streams[i][1])↵        samples[i] = reconstruct(planes, samples, i, width, height)
  | records-in-predicted-planes-star-jpeg-lrgb | records-in-intra-planes-jpeg-lrgb
side-rows-turned | correct(samples[i], streams[i][1])
  | samples[i] = bytearray(b"".join(groups(bytes(samples[i]), width)[::-1]))↵        correct(samples[i], streams[i][1])↵        samples[i] = bytearray(b"".join(groups(bytes(samples[i]), width)[::-1]))
  | record-at-1-of-3x5-jpeg-lrgb | record-at-5-of-5x3-jpeg-lrgb
jpeg-ls-rows-top-down | stored = read_compressed(source, format, width, height)
  | stored = read_compressed(source, format, width, height)↵        if b"JPEGLS" in format:↵            stored = [t for y in reversed(range(height)) for t in stored[y * width:(y + 1) * width]]
  | planes-run-upwards-1x20-jpegls-lrgb | planes-run-to-the-right-20x1-jpegls-lrgb
"#;

/// Returns the Python decoder, if Python is installed.
fn decoder() -> Option<String> {
    have_tool("python3").then(|| repository_text("examples/decoders/ptm_decoder.py"))
}

/// Checks a Python decoder with the given source text.
fn check_copy(text: &str, options: &str) -> CheckRun {
    let here = Workspace::new();
    here.write("copy of decoder.py", text);
    here.check(&format!("{options} -- python3 'copy of decoder.py'"))
}

#[test]
fn python_decoder_passes() {
    if !have_tool("python3") {
        return;
    }
    let checked = check(&format!("-- {}", python_example("decoders/ptm_decoder.py")));
    checked.assert_exit(0, "");
    assert_eq!(checked.report["verdict"], "pass");
    assert!(checked.cases("pass").len() > 700 && checked.cases("fail").is_empty());
}

#[test]
fn missing_format_is_unsupported() {
    let Some(decoder) = decoder() else { return };
    let formats = "    b\"PTM_FORMAT_LUM\": read_lum,\n";
    let text = edit(&decoder, formats, &formats.replace("read_lum", "lacking"));
    let table = text[..text.find("lacking").expect("the entry")].rfind("\n\n");
    let (before, after) = text.split_at(table.expect("a blank line") + 2);
    let lacking = "def lacking(*_):\n    raise Unsupported(\"LUM\")\n\n\n";
    // It declares no capabilities, because a decoder must support every format that it declares.
    let after = after.replace("\"capabilities\"", "\"nothing\"");
    let text = format!("{before}{lacking}{after}");
    let checked = check_copy(&text, "--case hand-* --case first-* --case lum-*");
    checked.assert_exit(0, "");
    // Without its optional packages, the decoder does not support compressed formats, either.
    let unsupported = checked.report["decoder"]["unsupported"].to_string();
    assert!(
        unsupported.contains("\"LUM\"") && unsupported.contains("\"rgb of LUM\""),
        "{unsupported}"
    );
    assert!(!unsupported.contains("\"LRGB\""), "{unsupported}");
    assert_eq!(checked.case("hand-lum")["outcome"], "unsupported");
}

#[test]
fn copies_with_one_mistake_fail_only_its_case() {
    for (name, diagnoses) in assert_each_fails(COPIES, "") {
        // A single refusal names no misreading.
        let is_named = diagnoses.contains(&name) || diagnoses.len() <= 1;
        assert!(is_named, "{name}: {diagnoses:?}");
    }
}

#[test]
fn copies_that_misread_compressed_planes_fail_only_their_case() {
    if have_python(&["PIL", "pillow_jpls"]) {
        assert_each_fails(COMPRESSED_COPIES, "--view raw");
    }
}

#[test]
fn common_transform_is_reported_once_and_undone() {
    let Some(decoder) = decoder() else { return };
    let text = edit(&decoder, "reversed(range(height))", "range(height)");
    let text = edit(&text, "(?:[eE][+-]?[0-9]+)?\")", "\")");
    let cases =
        "--case rows-run-upwards-1x2-rgb --case scale-exponents-lrgb --case hand-lrgb-blocks";
    let checked = check_copy(&text, cases);
    checked.assert_exit(1, "");
    assert_eq!(checked.cases("fail"), ["scale-exponents-lrgb"]);
    let remarks = checked.report["remarks"].as_array().expect("remarks");
    assert_eq!(remarks.len(), 1, "{remarks:?}");
    let says = remarks[0]["says"].as_str().unwrap_or_default();
    let expected = "raw, coef, rgb: the rows are upside down, in all of the first files";
    assert!(says.starts_with(expected), "{says}");
}

/// Asserts that each copy fails the first of its two cases and passes the second. Returns the names and diagnoses.
fn assert_each_fails(copies: &str, options: &str) -> Vec<(String, Vec<String>)> {
    let Some(text) = decoder() else {
        return Vec::new();
    };
    let diagnosed = |[name, find, replace, fails, passes]: [String; 5]| {
        let options = format!("{options} --case {fails} --case {passes}");
        let checked = check_copy(&edit(&text, &find, &replace), &options);
        let outcomes = (checked.status, checked.cases("fail"), checked.cases("pass"));
        let expected = (1, vec![fails], vec![passes]);
        assert_eq!(outcomes, expected, "{name}: {}", checked.text);
        (name, checked.diagnoses())
    };
    rows(copies).into_iter().map(diagnosed).collect()
}
