//! §2.9 and §2.9.1: mistakes in reading lines, sizes and the compression parameter

use super::anatomy::{Anatomy, EditedFile};
use super::change::{Change, Changes};

pub const CHANGES: Changes = |slug| {
    let edit: fn(&Anatomy) -> EditedFile = match slug {
        "motion-on-one-line-only" => |f| {
            let vectors = f.field_texts(&["2.9.3/1"]).len();
            let ends = || f.bytes_after("2.9.3/1", vectors / 2 - 1).contains(&b'\n');
            f.refuse_if(vectors > 1 && ends())
        },
        "missing-records-forgiven" => |f| match ptm::decode::fields(f.file).1 {
            Some(error) if error.clause() == "2.9.8/2" => {
                f.respell(&["2.9.7/1"], |text| (text != "0").then(|| "0".to_owned()))
            }
            _ => f.unchanged(),
        },
        "compressed-size-sign-ignored" => |f| {
            f.respell(&["2.9.6/1"], |text| {
                text.strip_prefix('-').map(str::to_owned)
            })
        },
        "side-information-always" => {
            |f| f.respell(&["2.9.7/1"], |text| (text == "0").then(|| "5".to_owned()))
        }
        "parameter-not-read" => |f| f.refuse_text(&["2.9.1/1"], |_| true),
        "parameter-always-a-quality" => |f| {
            f.refuse_text(&["2.9.1/1"], |text| {
                text.parse().is_ok_and(|value: i64| value < 20)
            })
        },
        "jpeg-ls-lossless-only" => |f| match f.field_texts(&["2.2/1"])[..] {
            [format] if format.contains("JPEGLS") => {
                f.refuse_text(&["2.9.1/1"], |text| text != "0")
            }
            _ => f.unchanged(),
        },
        "compressed-lists-of-nine" => |f| {
            f.refuse_text(&["2.2/1"], |text| {
                text.starts_with("PTM_FORMAT_JPEG") && text.ends_with("_RGB")
            })
        },
        "negative-vectors-refused" => |f| f.refuse_text(&["2.9.3/1"], |text| text.starts_with('-')),
        _ => return None,
    };
    Some(Change::Bytes(edit))
};
