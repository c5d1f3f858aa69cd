//! §2.9 and §2.9.1: mistakes with lines, sizes and the compression parameter

use super::at::At;

pub(super) const CHANGES: &[(&str, At)] = &[
    (
        "motion-on-one-line-only",
        At::Bytes(|file| {
            let vectors = file.field_texts(&["2.9.3/1"]).len();
            file.refuse_if(
                vectors > 1
                    && file
                        .bytes_after("2.9.3/1", vectors / 2 - 1)
                        .contains(&b'\n'),
            )
        }),
    ),
    (
        "missing-records-forgiven",
        At::Bytes(|file| match crate::decode::fields(file.file).1 {
            Some(error) if error.clause() == "2.9.8/2" => file.respell(|clause, text| {
                (clause == "2.9.7/1" && text != "0").then(|| "0".to_owned())
            }),
            _ => file.unchanged(),
        }),
    ),
    (
        "compressed-size-sign-ignored",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                text.strip_prefix('-')
                    .filter(|_| clause == "2.9.6/1")
                    .map(str::to_owned)
            })
        }),
    ),
    (
        "side-information-always",
        At::Bytes(|file| {
            file.respell(|clause, text| {
                (clause == "2.9.7/1" && text == "0").then(|| "5".to_owned())
            })
        }),
    ),
    (
        "parameter-not-read",
        At::Bytes(|file| file.refuse_if(!file.field_texts(&["2.9.1/1"]).is_empty())),
    ),
    (
        "parameter-always-a-quality",
        At::Bytes(|file| {
            let below = |text: &&str| text.parse().is_ok_and(|value: i64| value < 20);
            file.refuse_if(file.field_texts(&["2.9.1/1"]).first().is_some_and(below))
        }),
    ),
    (
        "jpeg-ls-lossless-only",
        At::Bytes(|file| {
            let lossy = file
                .field_texts(&["2.9.1/1"])
                .first()
                .is_some_and(|text| *text != "0");
            let jpeg_ls = file
                .field_texts(&["2.2/1"])
                .first()
                .is_some_and(|text| text.contains("JPEGLS"));
            file.refuse_if(lossy && jpeg_ls)
        }),
    ),
    (
        "compressed-lists-of-nine",
        At::Bytes(|file| {
            let rgb = file
                .field_texts(&["2.2/1"])
                .first()
                .is_some_and(|text| text.starts_with("PTM_FORMAT_JPEG") && text.ends_with("_RGB"));
            file.refuse_if(rgb)
        }),
    ),
    (
        "negative-vectors-refused",
        At::Bytes(|file| {
            file.refuse_if(
                file.field_texts(&["2.9.3/1"])
                    .iter()
                    .any(|text| text.starts_with('-')),
            )
        }),
    ),
];
