//! The example decoder passes, and copies of it with one mistake each fail the case for that mistake and not its sibling.

use std::fs;

use crate::common::{check_with, have, have_python, repository};

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

/// Copies that misread 2.9, which needs Pillow.
const COMPRESSED_COPIES: &[Copy] = &[
    copy(
        "no-128",
        "(r + p - 128) % 256",
        "(r + p) % 256",
        "two-planes-predicted-jpeg-lrgb",
        "one-texel-jpeg-lrgb",
    ),
    copy(
        "wrap-mod-255",
        "(r + p - 128) % 256",
        "(r + p - 128) % 255",
        "sums-around-the-ends-star-jpeg-lrgb",
        "one-texel-jpeg-lrgb",
    ),
    copy(
        "clamp-not-wrap",
        "(r + p - 128) % 256",
        "min(255, max(0, r + p - 128))",
        "sums-around-the-ends-star-jpeg-lrgb",
        "residuals-of-nothing-jpeg-lrgb",
    ),
    copy(
        "wrap-below-only",
        "(r + p - 128) % 256",
        "min(255, r + p - 128 + 256 * (r + p < 128))",
        "sums-around-the-ends-star-jpeg-lrgb",
        "residuals-of-nothing-jpeg-lrgb",
    ),
    copy(
        "order-as-sequence",
        "sorted(range(count), key=lambda i: planes[i].rank)",
        "[plane.rank for plane in planes]",
        "planes-in-structure-deep-jpeg-lrgb",
        "planes-in-structure-chain-jpeg-lrgb",
    ),
    copy(
        "predicted-from-residuals",
        "reconstruct(planes, samples, i, width, height)\n",
        "reconstruct(planes, [decode(s, width, height) for s, _ in streams], i, width, height)\n",
        "planes-in-structure-chain-jpeg-lrgb",
        "planes-in-structure-star-jpeg-lrgb",
    ),
    copy(
        "planes-in-decode-order",
        "streams = [(source.bytes(plane.size), source.bytes(plane.side_size)) for plane in planes]",
        "streams = [None] * count\n    for i in sorted(range(count), key=lambda i: planes[i].rank):\n        streams[i] = source.bytes(planes[i].size), source.bytes(planes[i].side_size)",
        "planes-in-structure-upward-jpeg-lrgb",
        "planes-in-structure-chain-jpeg-lrgb",
    ),
    copy(
        "inversion-from-256",
        "255 - value",
        "(256 - value) % 256",
        "inverted-chain-jpeg-lrgb",
        "planes-in-structure-chain-jpeg-lrgb",
    ),
    copy(
        "transform-by-equality",
        "if plane.transform & INVERSION:",
        "if plane.transform == INVERSION:",
        "inverted-and-moved-by-nothing-jpeg-lrgb",
        "inverted-chain-jpeg-lrgb",
    ),
    copy(
        "motion-ignored",
        "if plane.transform & MOTION:",
        "if False:",
        "motion-along-rows-9x7-jpeg-lrgb",
        "motion-by-nothing-star-jpeg-lrgb",
    ),
    copy(
        "motion-whole-texels",
        "before, behind = half_steps // 2, (half_steps + 1) // 2",
        "before, behind = half_steps, half_steps",
        "motion-along-rows-9x7-jpeg-lrgb",
        "motion-by-nothing-star-jpeg-lrgb",
    ),
    copy(
        "vectors-y-first",
        "neighbours(width, mx)\n    upper, lower = neighbours(height, my)",
        "neighbours(width, my)\n    upper, lower = neighbours(height, mx)",
        "motion-along-rows-9x7-jpeg-lrgb",
        "motion-along-diagonals-jpeg-lrgb",
    ),
    copy(
        "vectors-interleaved",
        "planes = [Plane(*plane) for plane in zip(*groups(numbers, count))]",
        "numbers[count:3 * count] = numbers[count:3 * count:2] + numbers[count + 1:3 * count:2]\n    planes = [Plane(*plane) for plane in zip(*groups(numbers, count))]",
        "motion-both-ways-jpeg-lrgb",
        "inverted-chain-jpeg-lrgb",
    ),
    copy(
        "jpeg-rows-top-down",
        "stored = read_compressed(source, format, width, height)",
        "stored = read_compressed(source, format, width, height)\n        if b\"JPEG_\" in format:\n            stored = [t for y in reversed(range(height)) for t in stored[y * width:(y + 1) * width]]",
        "planes-run-upwards-1x20-jpeg-lrgb",
        "planes-run-to-the-right-20x1-jpeg-lrgb",
    ),
    copy(
        "jpeg-rows-padded-to-4",
        "return samples\n",
        "return b\"\".join(row.ljust(-len(row) % 4 + len(row), b\"\\0\") for row in groups(samples, width))[:len(samples)]\n",
        "planes-in-size-5x4-jpeg-lrgb",
        "planes-in-size-8x8-jpeg-lrgb",
    ),
    copy(
        "rgb-planes-coefficient-major",
        "zip(*samples)]",
        "zip(*(samples if count < 18 else [samples[6 * (i % 3) + i // 3] for i in range(18)]))]",
        "planes-of-stripes-jpeg-rgb",
        "planes-of-stripes-jpeg-lrgb",
    ),
    copy(
        "side-little-endian",
        "int.from_bytes(record[:4], \"big\")",
        "int.from_bytes(record[:4], \"little\")",
        "record-at-1-of-3x5-jpeg-lrgb",
        "record-of-the-first-texel-jpeg-lrgb",
    ),
    copy(
        "side-value-limited-to-127",
        "plane[position] = record[4]",
        "plane[position] = min(record[4], 127)",
        "record-values-of-0-and-255-jpeg-lrgb",
        "lists-plain-jpeg-lrgb",
    ),
    copy(
        "side-values-added",
        "plane[position] = record[4]",
        "plane[position] = (plane[position] + record[4]) % 256",
        "records-many-jpeg-lrgb",
        "lists-plain-jpeg-lrgb",
    ),
    copy(
        "side-cursor-by-one",
        "for record in groups(side, 5):",
        "for record in [side[at:at + 5] for at in range(len(side) // 5)]:",
        "records-many-jpeg-lrgb",
        "record-of-the-first-texel-jpeg-lrgb",
    ),
    copy(
        "side-last-record-lost",
        "for record in groups(side, 5):",
        "for record in groups(side, 5)[:-1]:",
        "record-of-the-first-texel-jpeg-lrgb",
        "lists-plain-jpeg-lrgb",
    ),
    copy(
        "side-information-ignored",
        "        correct(samples[i], streams[i][1])",
        "        pass",
        "record-in-plane-4-jpeg-lrgb",
        "lists-plain-jpeg-lrgb",
    ),
    copy(
        "side-information-too-late",
        "        correct(samples[i], streams[i][1])",
        "    for i in range(count):\n        correct(samples[i], streams[i][1])",
        "records-in-a-reference-star-jpeg-lrgb",
        "record-at-1-of-3x5-jpeg-lrgb",
    ),
    copy(
        "side-information-of-intra-planes-ignored",
        "        correct(samples[i], streams[i][1])",
        "        if planes[i].reference >= 0:\n            correct(samples[i], streams[i][1])",
        "record-in-plane-0-jpeg-lrgb",
        "records-in-predicted-planes-star-jpeg-lrgb",
    ),
    copy(
        "side-information-before-prediction",
        "samples[i] = reconstruct(planes, samples, i, width, height)\n        correct(samples[i], streams[i][1])",
        "samples[i] = bytearray(samples[i])\n        correct(samples[i], streams[i][1])\n        samples[i] = reconstruct(planes, samples, i, width, height)",
        "records-in-predicted-planes-star-jpeg-lrgb",
        "records-in-intra-planes-jpeg-lrgb",
    ),
    copy(
        "side-rows-turned",
        "        correct(samples[i], streams[i][1])",
        "        samples[i] = bytearray(b\"\".join(groups(bytes(samples[i]), width)[::-1]))\n        correct(samples[i], streams[i][1])\n        samples[i] = bytearray(b\"\".join(groups(bytes(samples[i]), width)[::-1]))",
        "record-at-1-of-3x5-jpeg-lrgb",
        "record-at-5-of-5x3-jpeg-lrgb",
    ),
    copy(
        "jpeg-ls-rows-top-down",
        "stored = read_compressed(source, format, width, height)",
        "stored = read_compressed(source, format, width, height)\n        if b\"JPEGLS\" in format:\n            stored = [t for y in reversed(range(height)) for t in stored[y * width:(y + 1) * width]]",
        "planes-run-upwards-1x20-jpegls-lrgb",
        "planes-run-to-the-right-20x1-jpegls-lrgb",
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
    // It says nothing of itself; a format that it declares must be read.
    let text = text.replace("\"capabilities\"", "\"nothing of itself\"");
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
    if have("python3") {
        for (name, diagnoses) in each_fails(COPIES, &[]) {
            let named = diagnoses.contains(&name.to_owned()) || diagnoses.len() == 1;
            assert!(named, "{name}: {diagnoses:?}");
        }
    }
}

#[test]
fn what_all_pictures_share_is_said_once_and_undone() {
    if !have("python3") {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let text = fs::read_to_string(repository(DECODER)).expect("the decoder");
    let top_down = "reversed(range(height))";
    let without_exponents = "(?:[eE][+-]?[0-9]+)?\")";
    for find in [top_down, without_exponents] {
        assert_eq!(text.matches(find).count(), 1, "{find}");
    }
    let text = text
        .replace(top_down, "range(height)")
        .replace(without_exponents, "\")");
    let path = scratch.path().join("two-mistakes.py");
    fs::write(&path, text).expect("a copy");
    let cases = [
        "rows-run-upwards-1x2-rgb",
        "scale-exponents-lrgb",
        "hand-lrgb-blocks",
    ];
    let options: Vec<&str> = cases.iter().flat_map(|case| ["--case", *case]).collect();
    let checked = check_with(&options, &["python3", &path.to_string_lossy()]);
    assert_eq!(checked.status, 1, "{}", checked.text);
    assert_eq!(checked.cases("fail"), ["scale-exponents-lrgb"]);
    let remarks = checked.report["remarks"]
        .as_array()
        .cloned()
        .unwrap_or_default();
    assert_eq!(remarks.len(), 1, "{remarks:?}");
    let says = remarks[0]["says"].as_str().unwrap_or_default();
    assert!(
        says.starts_with("raw, coef, rgb: its rows are upside down, in all first files"),
        "{says}"
    );
}

#[test]
fn each_copy_that_misreads_compressed_planes_fails_the_case_for_it_and_passes_the_sibling() {
    if have("python3") && have_codecs() {
        each_fails(COMPRESSED_COPIES, &["--view", "raw"]);
    }
}

/// Whether the decoder can read streams; says SKIPPED if not.
fn have_codecs() -> bool {
    have_python(&["PIL", "pillow_jpls"])
}

/// Checks copies, each with its two cases and these options; returns what each was taken for.
fn each_fails(copies: &[Copy], options: &[&str]) -> Vec<(&'static str, Vec<String>)> {
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let text = fs::read_to_string(repository(DECODER)).expect("the decoder");
    let check = |Copy {
                     name,
                     find,
                     replace,
                     fails,
                     passes,
                 }: &Copy| {
        assert_eq!(text.matches(find).count(), 1, "{name}: {find}");
        let path = scratch.path().join(format!("{name}.py"));
        fs::write(&path, text.replace(find, replace)).expect("a copy");
        let checked = check_with(
            &[options, &["--case", fails, "--case", passes]].concat(),
            &["python3", &path.to_string_lossy()],
        );
        assert_eq!(checked.status, 1, "{name}: {}", checked.text);
        assert_eq!(
            (checked.cases("fail"), checked.cases("pass")),
            (vec![(*fails).to_owned()], vec![(*passes).to_owned()]),
            "{name}: {}",
            checked.text
        );
        (*name, checked.diagnoses())
    };
    copies.iter().map(check).collect()
}
