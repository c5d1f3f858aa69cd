//! Parts of the writer suite that only reports need.

use maud::{Markup, html};

use crate::diagnose::Causes;
use crate::kit::digest::sha256;
use crate::misreadings::Misreading;
use crate::report::html::{download, standard_error};
use crate::report::reported::Reported;
use crate::session::observation::Observation;
use crate::session::run::Run;
use crate::suite::cases::{Suite, TableSpelling};
use crate::suite::name::SuiteName;
use crate::writers::cases::WriterCase;
use crate::writers::diagnose::diagnose;
use crate::writers::test_case::wrong_file;

/// Maximum number of bytes of a wrong file that a page displays.
const MAX_DISPLAYED_BYTES: usize = 512;

impl Reported for WriterCase {
    const SUITE: SuiteName = SuiteName::Writers;

    type MisreadingPoint = &'static Misreading;

    fn suite() -> Result<Suite<WriterCase>, String> {
        Suite::load_writer_requests()
    }

    fn digest(suite: &Suite<WriterCase>) -> String {
        let digests = suite.cases.iter().map(|case| {
            let request = case.request();
            sha256(&[request.header.to_json().as_bytes(), &request.samples].concat())
        });
        sha256(digests.collect::<String>().as_bytes())
    }

    fn evidence(&self, _: TableSpelling, observation: &Observation<WriterCase>) -> Markup {
        let file = wrong_file(Some(observation)).map(|(file, _)| file);
        html! {
            p.label { "The request" }
            pre.bytes tabindex="0" { (self.request().header.to_json()) }
            @if let Some(file) = file {
                p.label { "The file, " (file.len()) " bytes" @if file.len() > MAX_DISPLAYED_BYTES { ", its beginning" } }
                pre.bytes tabindex="0" { (file[..file.len().min(MAX_DISPLAYED_BYTES)].escape_ascii().to_string().replace("\\n", "\\n\n")) }
                (download(&format!("{}.ptm", self.id), file))
            }
            @if !observation.stderr.is_empty() { (standard_error(&observation.stderr)) }
        }
    }

    fn diagnose(
        suite: &Suite<WriterCase>,
        run: &Run<WriterCase>,
        _: &[String],
        threads: usize,
    ) -> Causes<&'static Misreading> {
        diagnose(suite, run, threads).into()
    }
}
